import { robotColor } from "./colors.js";
import { due } from "./mission.js";
import { spread } from "./spread.js";
const CROWD = 9;
export class Pen {
    context;
    mission;
    view;
    constructor(context, mission, view) {
        this.context = context;
        this.mission = mission;
        this.view = view;
    }
    middle(cell) {
        return this.view.at(this.mission.middle(cell));
    }
    get robots() {
        return this.mission.frame?.robots ?? [];
    }
    get sign() {
        return Math.min(Math.max(this.view.size * 0.85, 12), 16);
    }
    hatch() {
        const { context, mission, view } = this;
        if (view.size < 4)
            return;
        context.strokeStyle = "rgba(60, 66, 76, 0.75)";
        context.lineWidth = Math.max(1, view.size / 14);
        context.beginPath();
        for (const cell of mission.blocked) {
            const [row, column] = mission.place(cell);
            const [x, y] = view.at([column, row]);
            if (x < -view.size || y < 0 || x > view.width || y > view.height + view.size)
                continue;
            context.moveTo(x, y);
            context.lineTo(x + view.size, y - view.size);
        }
        context.stroke();
    }
    zones() {
        const { context, mission, view } = this;
        const size = view.size;
        const [crossed, striped] = [new Path2D(), new Path2D()];
        for (const [cell, zone] of mission.zones) {
            const [row, column] = mission.place(cell);
            const [x, y] = view.at([column, row]);
            if (x < -size || y < 0 || x > view.width || y > view.height + size)
                continue;
            context.fillStyle = zone === 2 ? "rgba(200, 30, 40, 0.35)" : "rgba(255, 255, 255, 0.35)";
            context.fillRect(x, y - size, size, size);
            const lines = zone === 2 ? crossed : striped;
            lines.moveTo(x, y - size);
            lines.lineTo(x + size, y);
            if (zone !== 2)
                continue;
            lines.moveTo(x, y);
            lines.lineTo(x + size, y - size);
        }
        if (size < 4)
            return;
        context.lineWidth = Math.max(1, size / 14);
        context.strokeStyle = "rgba(165, 15, 30, 0.9)";
        context.stroke(crossed);
        context.strokeStyle = "rgba(40, 44, 52, 0.75)";
        context.stroke(striped);
    }
    tracks() {
        for (const robot of this.robots)
            this.line(this.mission.trails.get(robot.robot) ?? [], robot, []);
    }
    plans() {
        for (const robot of this.robots) {
            this.line(robot.cell === null ? robot.plan : [robot.cell, ...robot.plan], robot, [5, 4]);
            const goal = robot.plan.at(-1);
            if (goal === undefined)
                continue;
            const [x, y] = this.middle(goal);
            this.context.beginPath();
            this.context.arc(x, y, this.sign / 3, 0, 2 * Math.PI);
            this.casing(robotColor(robot.robot), 2, []);
            if (this.robots.length < CROWD)
                this.label(due(robot, -1, this.mission.frame?.time ?? 0), x, y - this.sign / 2);
        }
    }
    label(text, x, y) {
        const { context } = this;
        context.font = "600 12px system-ui, sans-serif";
        context.textAlign = "center";
        context.textBaseline = "bottom";
        context.lineJoin = "round";
        context.lineWidth = 3;
        context.strokeStyle = "rgba(255, 255, 255, 0.85)";
        context.strokeText(text, x, y);
        context.fillStyle = "#111111";
        context.fillText(text, x, y);
    }
    line(cells, robot, dash) {
        if (cells.length < 2)
            return;
        this.trace(cells.map((cell) => this.middle(cell)));
        this.casing(robotColor(robot.robot), this.robots.length < CROWD ? 2.5 : 1.5, dash);
    }
    trace(points) {
        this.context.beginPath();
        points.forEach(([x, y], index) => (index === 0 ? this.context.moveTo(x, y) : this.context.lineTo(x, y)));
    }
    casing(color, width, dash) {
        const { context } = this;
        context.lineJoin = "round";
        context.lineCap = dash.length > 0 ? "butt" : "round";
        context.setLineDash(dash);
        context.strokeStyle = "rgba(255, 255, 255, 0.85)";
        context.lineWidth = width + Math.min(2, width);
        context.stroke();
        context.strokeStyle = color;
        context.lineWidth = width;
        context.stroke();
        context.setLineDash([]);
    }
    finds() {
        const { context, mission, view } = this;
        for (const object of mission.frame?.declared ?? []) {
            const [x, y] = view.at(mission.where(object.cell));
            if (object.position !== undefined) {
                context.beginPath();
                context.arc(x, y, (object.position.accuracy_meters / mission.hello.cell_meters) * view.size, 0, 2 * Math.PI);
                this.casing("#c2410c", 1.5, [4, 3]);
            }
            const half = this.sign * 0.72;
            this.trace([[x, y - half], [x + half, y], [x, y + half], [x - half, y]]);
            context.closePath();
            context.fillStyle = "rgba(255, 255, 255, 0.9)";
            context.fill();
            this.casing("#c2410c", 2.5, []);
            if (object.operator === "confirmed")
                this.tick(x, y, half / 2);
        }
    }
    clues() {
        const { context, mission, view } = this;
        for (const { cell, radius_meters = 0 } of mission.marks) {
            if (cell === undefined)
                continue;
            const [x, y] = this.middle(cell);
            const half = this.sign * 0.6;
            context.beginPath();
            context.arc(x, y, (radius_meters / mission.hello.cell_meters) * view.size, 0, 2 * Math.PI);
            this.casing("#6d28d9", 1.5, [4, 3]);
            context.beginPath();
            context.arc(x, y, half, 0, 2 * Math.PI);
            context.fillStyle = "#ffffff";
            context.fill();
            this.casing("#6d28d9", 2, []);
            this.number("!", [x, y], half);
        }
    }
    tick(x, y, half) {
        this.trace([[x - half, y], [x - half / 3, y + 0.7 * half], [x + half, y - 0.7 * half]]);
        this.casing("#1d6b3c", 2.5, []);
    }
    markers() {
        const known = this.robots.filter((robot) => robot.cell !== null);
        const places = known.map((robot) => this.middle(robot.cell ?? 0));
        const beside = spread(places, 1.5 * this.sign + 4);
        const pairs = places.map((from, index) => [from, beside[index] ?? from]);
        for (const [from, to] of pairs)
            this.leader(from, to);
        known.forEach((robot, index) => this.marker(robot, beside[index] ?? [0, 0]));
    }
    leader(from, to) {
        if (from[0] === to[0] && from[1] === to[1])
            return;
        this.trace([from, to]);
        this.casing("#111111", 1, []);
    }
    marker(robot, [x, y]) {
        const { context } = this;
        const half = this.sign * 0.75;
        context.beginPath();
        if (robot.state === "searching" || robot.state === "lost")
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
        this.number(String(robot.robot), [x, y], half);
        if (robot.is_doubled)
            this.twice(x, y, half);
        if (robot.state === "lost")
            this.cross(x, y, half);
        if (robot.state === "paused")
            this.bars(x + half, y - half);
    }
    number(text, [x, y], half) {
        const { context } = this;
        context.fillStyle = "#111111";
        context.font = `600 ${Math.round(half * (text.length < 3 ? 1.2 : 0.9))}px system-ui, sans-serif`;
        context.textAlign = "center";
        context.textBaseline = "middle";
        context.fillText(text, x, y + 0.5);
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
        const points = corners.map((corner) => this.view.at(corner));
        this.trace(points);
        if (points.length > 2)
            context.closePath();
        context.fillStyle = "rgba(11, 92, 173, 0.25)";
        context.fill();
        this.casing("#0b5cad", 2, [6, 4]);
        this.handles(points, "#0b5cad");
    }
    measure(spots) {
        const points = spots.map((spot) => this.view.at(spot));
        this.trace(points);
        this.casing("#111111", 2, []);
        this.handles(points, "#111111");
    }
    handles(points, color) {
        this.context.fillStyle = color;
        for (const [x, y] of points)
            this.context.fillRect(x - 4, y - 4, 8, 8);
    }
    cursor(cell) {
        const { size } = this.view;
        const [row, column] = this.mission.place(cell);
        const [x, y] = this.view.at([column, row + 1]);
        const grow = Math.max(0, (9 - size) / 2);
        this.context.beginPath();
        this.context.rect(x - grow, y - grow, size + 2 * grow, size + 2 * grow);
        this.casing("#111111", 2, []);
    }
}
