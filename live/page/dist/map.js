import { fit } from "./chart.js";
import { BLOCKED, OUT_OF_REACH, UNSEARCHED, logOdds, MOST_NATS, probability, robotColor, shade } from "./colors.js";
const STRIDE = 5;
export class MapView {
    ground;
    canvas;
    events;
    cursor;
    corners = [];
    cells = document.createElement("canvas");
    mission;
    constructor(ground, canvas, events) {
        this.ground = ground;
        this.canvas = canvas;
        this.events = events;
        ground.addEventListener("click", (event) => this.tap(event));
        ground.addEventListener("keydown", (event) => this.key(event));
    }
    tap(event) {
        if (this.mission === undefined)
            return;
        const { rows, columns } = this.mission.hello;
        const box = this.canvas.getBoundingClientRect();
        const east = ((event.clientX - box.left) / box.width) * columns;
        const north = (1 - (event.clientY - box.top) / box.height) * rows;
        const within = (value, most) => Math.min(Math.max(value, 0), most);
        const spot = [within(east, columns), within(north, rows)];
        this.events.tapped(spot);
        this.move(Math.min(Math.floor(spot[1]), rows - 1), Math.min(Math.floor(spot[0]), columns - 1));
    }
    key(event) {
        const steps = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };
        const step = steps[event.key];
        if (step === undefined || this.mission === undefined || event.ctrlKey || event.altKey || event.metaKey)
            return;
        event.preventDefault();
        const { rows, columns } = this.mission.hello;
        const [row, column] = this.cursor === undefined ? [rows >> 1, columns >> 1] : this.mission.place(this.cursor);
        const by = this.cursor === undefined ? 0 : event.shiftKey ? STRIDE : 1;
        const within = (value, most) => Math.min(Math.max(value, 0), most);
        this.move(within(row + by * step[0], rows - 1), within(column + by * step[1], columns - 1));
    }
    move(row, column) {
        if (this.mission === undefined)
            return;
        this.cursor = row * this.mission.hello.columns + column;
        this.events.moved(this.cursor);
    }
    cursorSpot() {
        if (this.cursor === undefined || this.mission === undefined)
            return undefined;
        const [row, column] = this.mission.place(this.cursor);
        return [column + 0.5, row + 0.5];
    }
    show(mission) {
        const { rows, columns } = mission.hello;
        if (this.mission !== mission) {
            this.mission = mission;
            if (this.cursor !== undefined && this.cursor >= rows * columns)
                this.cursor = undefined;
        }
        const width = Math.min(this.ground.parentElement?.clientWidth ?? 300, (window.innerHeight * 0.78 * columns) / rows);
        this.ground.style.width = `min(100%, ${Math.floor(width)}px)`;
        this.canvas.style.aspectRatio = `${columns} / ${rows}`;
        this.draw(mission);
    }
    draw(mission) {
        const context = fit(this.canvas);
        const size = this.canvas.clientWidth / mission.hello.columns;
        const pen = new Pen(context, mission, size);
        this.paintCells(mission);
        context.imageSmoothingEnabled = false;
        context.drawImage(this.cells, 0, 0, this.canvas.clientWidth, this.canvas.clientHeight);
        pen.hatch();
        for (const robot of mission.frame?.robots ?? [])
            pen.path(robot);
        for (const object of mission.frame?.declared ?? [])
            pen.object(object.cell);
        for (const robot of mission.frame?.robots ?? [])
            pen.robot(robot);
        pen.area(this.corners);
        if (this.cursor !== undefined)
            pen.cursor(this.cursor);
    }
    paintCells(mission) {
        const { rows, columns } = mission.hello;
        if (this.cells.width !== columns || this.cells.height !== rows) {
            this.cells.width = columns;
            this.cells.height = rows;
        }
        const image = new ImageData(columns, rows);
        mission.levels.forEach((level, cell) => {
            const [row, column] = mission.place(cell);
            const plain = mission.isTraversable[cell] === 1 ? UNSEARCHED : BLOCKED;
            const ground = mission.isOutOfReach[cell] === 1 ? OUT_OF_REACH : plain;
            const [red, green, blue] = ground !== OUT_OF_REACH && level !== 0 ? shade((logOdds(level) / MOST_NATS + 1) / 2) : ground;
            image.data.set([red, green, blue, 255], 4 * ((rows - 1 - row) * columns + column));
        });
        this.cells.getContext("2d")?.putImageData(image, 0, 0);
    }
}
class Pen {
    context;
    mission;
    size;
    constructor(context, mission, size) {
        this.context = context;
        this.mission = mission;
        this.size = size;
    }
    at([east, north]) {
        return [east * this.size, (this.mission.hello.rows - north) * this.size];
    }
    middle(cell) {
        const [row, column] = this.mission.place(cell);
        return this.at([column + 0.5, row + 0.5]);
    }
    get sign() {
        return Math.min(Math.max(this.size * 0.85, 8), 15);
    }
    hatch() {
        const { context, size } = this;
        if (size < 4)
            return;
        context.strokeStyle = "rgba(60, 66, 76, 0.75)";
        context.lineWidth = Math.max(1, size / 14);
        context.beginPath();
        this.mission.isTraversable.forEach((isTraversable, cell) => {
            if (isTraversable === 1)
                return;
            const [row, column] = this.mission.place(cell);
            const [x, y] = this.at([column, row]);
            context.moveTo(x, y);
            context.lineTo(x + size, y - size);
        });
        context.stroke();
    }
    path(robot) {
        const trail = this.mission.trails.get(robot.robot) ?? [];
        this.line(trail, robotColor(robot.robot), []);
        const plan = robot.cell === null ? robot.plan : [robot.cell, ...robot.plan];
        this.line(plan, robotColor(robot.robot), [5, 4]);
        const goal = robot.plan.at(-1);
        if (goal === undefined)
            return;
        const [x, y] = this.middle(goal);
        this.context.beginPath();
        this.context.arc(x, y, this.sign / 3, 0, 2 * Math.PI);
        this.casing(robotColor(robot.robot), 2, []);
    }
    line(cells, color, dash) {
        if (cells.length < 2)
            return;
        this.context.beginPath();
        cells.forEach((cell, index) => {
            const [x, y] = this.middle(cell);
            if (index === 0)
                this.context.moveTo(x, y);
            else
                this.context.lineTo(x, y);
        });
        this.casing(color, 2.5, dash);
    }
    casing(color, width, dash) {
        const { context } = this;
        context.lineJoin = "round";
        context.lineCap = dash.length > 0 ? "butt" : "round";
        context.setLineDash(dash);
        context.strokeStyle = "rgba(255, 255, 255, 0.85)";
        context.lineWidth = width + 2;
        context.stroke();
        context.strokeStyle = color;
        context.lineWidth = width;
        context.stroke();
        context.setLineDash([]);
    }
    object(cell) {
        const { context } = this;
        const [x, y] = this.middle(cell);
        const half = this.sign * 0.72;
        context.beginPath();
        context.moveTo(x, y - half);
        context.lineTo(x + half, y);
        context.lineTo(x, y + half);
        context.lineTo(x - half, y);
        context.closePath();
        context.fillStyle = "rgba(255, 255, 255, 0.9)";
        context.fill();
        this.casing("#c2410c", 2.5, []);
    }
    robot(robot) {
        if (robot.cell === null)
            return;
        const { context } = this;
        const half = this.sign * 0.75;
        const [middle, y] = this.middle(robot.cell);
        const x = middle + 1.6 * half * this.robotsBefore(robot);
        const isMoving = robot.state === "searching";
        context.beginPath();
        if (isMoving || robot.state === "lost")
            context.arc(x, y, half, 0, 2 * Math.PI);
        else
            context.rect(x - half, y - half, 2 * half, 2 * half);
        context.fillStyle = "#ffffff";
        context.fill();
        context.setLineDash(robot.state === "lost" ? [3, 2] : []);
        context.strokeStyle = robotColor(robot.robot);
        context.lineWidth = 4;
        context.stroke();
        context.setLineDash([]);
        context.strokeStyle = "#111111";
        context.lineWidth = 1.2;
        context.stroke();
        context.fillStyle = "#111111";
        context.font = `600 ${Math.round(half * 1.25)}px system-ui, sans-serif`;
        context.textAlign = "center";
        context.textBaseline = "middle";
        context.fillText(String(robot.robot), x, y + 0.5);
        if (robot.is_doubled)
            this.twice(x, y, half);
        if (robot.state === "lost")
            this.cross(x, y, half);
        if (robot.state === "paused")
            this.bars(x + half, y - half);
    }
    robotsBefore(robot) {
        const robots = this.mission.frame?.robots ?? [];
        return robots.filter((other) => other.cell === robot.cell && other.robot < robot.robot).length;
    }
    twice(x, y, half) {
        this.context.beginPath();
        this.context.arc(x, y, 1.5 * half, 0, 2 * Math.PI);
        this.casing("#c2410c", 2.5, []);
    }
    cross(x, y, half) {
        this.context.beginPath();
        this.context.moveTo(x - half, y - half);
        this.context.lineTo(x + half, y + half);
        this.context.moveTo(x + half, y - half);
        this.context.lineTo(x - half, y + half);
        this.casing("#111111", 2, []);
    }
    bars(x, y) {
        const { context } = this;
        context.fillStyle = "#ffffff";
        context.fillRect(x - 5, y - 5, 10, 10);
        context.fillStyle = "#111111";
        context.fillRect(x - 3, y - 4, 2.2, 8);
        context.fillRect(x + 0.8, y - 4, 2.2, 8);
    }
    area(corners) {
        if (corners.length === 0)
            return;
        const { context } = this;
        const points = corners.map((corner) => this.at(corner));
        context.beginPath();
        points.forEach(([x, y], index) => (index === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
        if (points.length > 2)
            context.closePath();
        context.fillStyle = "rgba(11, 92, 173, 0.25)";
        context.fill();
        this.casing("#0b5cad", 2, [6, 4]);
        for (const [x, y] of points) {
            context.fillStyle = "#0b5cad";
            context.fillRect(x - 4, y - 4, 8, 8);
        }
    }
    cursor(cell) {
        const [row, column] = this.mission.place(cell);
        const [x, y] = this.at([column, row + 1]);
        const grow = Math.max(0, (9 - this.size) / 2);
        this.context.beginPath();
        this.context.rect(x - grow, y - grow, this.size + 2 * grow, this.size + 2 * grow);
        this.casing("#111111", 2, []);
    }
}
export function drawScale(canvas) {
    const context = fit(canvas);
    for (let x = 0; x < canvas.clientWidth; x += 1) {
        context.fillStyle = `rgb(${shade(x / canvas.clientWidth).join(" ")})`;
        context.fillRect(x, 0, 1.5, canvas.clientHeight);
    }
}
export function describe(mission, cell) {
    const level = mission.levels[cell] ?? 0;
    const ground = mission.isTraversable[cell] === 1 ? "" : ", not traversable";
    const robots = (mission.frame?.robots ?? []).filter((robot) => robot.cell === cell);
    const here = robots.map((robot) => `, robot ${robot.robot} is here${robot.is_doubled ? ", with a duplicate number" : ""}`).join("");
    const isDeclared = (mission.frame?.declared ?? []).some((object) => object.cell === cell);
    const belief = level === 0 ? "not searched" : `probability of an object ${bounded(level)}`;
    const reach = mission.isOutOfReach[cell] === 1 ? ", out of reach: no robot can observe it" : "";
    return `Cell ${mission.name(cell)}: ${belief}${isDeclared ? ", declared" : ""}${reach}${ground}${here}`;
}
function bounded(level) {
    if (level === 1)
        return `under ${percent(probability(2))}`;
    if (level === 255)
        return `over ${percent(probability(254))}`;
    return percent(probability(level));
}
export function percent(share) {
    const isEven = share === 0 || share === 1;
    const digits = isEven ? 0 : share < 0.01 || share > 0.99 ? 2 : 1;
    return `${(100 * share).toFixed(digits)} %`;
}
