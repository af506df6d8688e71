const TRAIL_CELLS = 400;
const MOST_POINTS = 2000;
export class Mission {
    hello;
    isTraversable;
    blocked;
    levels;
    searched;
    version = 0;
    isOutOfReach;
    zones = new Map();
    frame;
    trails = new Map();
    curve = [];
    orders = [];
    marks = [];
    segments = [];
    isOver = false;
    constructor(hello) {
        this.hello = hello;
        this.isTraversable = bytes(hello.ground);
        this.blocked = [...this.isTraversable.keys()].filter((cell) => this.isTraversable[cell] !== 1);
        this.levels = new Uint8Array(hello.rows * hello.columns);
        this.searched = new Uint8Array(hello.rows * hello.columns);
        this.isOutOfReach = new Uint8Array(hello.rows * hello.columns);
    }
    take(frame) {
        if (frame.is_whole) {
            this.trails.clear();
            this.curve = frame.curve ?? [];
        }
        else {
            this.curve.push([frame.time, frame.entropy, frame.progress]);
            if (this.curve.length > MOST_POINTS)
                this.curve = this.curve.filter((_, index) => index % 2 === 0);
        }
        this.takeCells(frame);
        for (const robot of frame.robots) {
            const trail = [...(this.trails.get(robot.robot) ?? []), ...robot.trail];
            this.trails.set(robot.robot, trail.slice(-TRAIL_CELLS));
        }
        this.orders = frame.orders ?? this.orders;
        this.marks = frame.marked ?? this.marks;
        this.segments = frame.segments ?? this.segments;
        if (frame.zones !== undefined)
            this.zones = zoned(frame.zones);
        this.frame = frame;
    }
    takeCells(frame) {
        const changes = frame.changes ?? [];
        if (frame.levels !== undefined)
            this.levels = bytes(frame.levels);
        if (frame.searched !== undefined)
            this.searched = bytes(frame.searched);
        if (frame.out_of_reach !== undefined)
            this.isOutOfReach = bytes(frame.out_of_reach);
        for (const [cell, level, searched] of changes) {
            this.levels[cell] = level;
            this.searched[cell] = searched;
        }
        if (frame.levels !== undefined || frame.out_of_reach !== undefined || changes.length > 0)
            this.version += 1;
    }
    cellAt([east, north]) {
        const { rows, columns } = this.hello;
        const [row, column] = [Math.floor(north), Math.floor(east)];
        return row >= 0 && row < rows && column >= 0 && column < columns ? row * columns + column : undefined;
    }
    middle(cell) {
        const [row, column] = this.place(cell);
        return [column + 0.5, row + 0.5];
    }
    position(cell) {
        const { declared, dismissed } = this.frame ?? { declared: [], dismissed: [] };
        return [...declared, ...dismissed].find((find) => find.cell === cell)?.position;
    }
    where(cell) {
        const position = this.position(cell);
        if (position === undefined)
            return this.middle(cell);
        const [east, north] = position.meters;
        return [east / this.hello.cell_meters, north / this.hello.cell_meters];
    }
    place(cell) {
        return [Math.floor(cell / this.hello.columns), cell % this.hello.columns];
    }
    name(cell) {
        const [row, column] = this.place(cell);
        return `[${row}, ${column}]`;
    }
}
function zoned(runs) {
    return new Map(runs.flatMap(([first, count, zone]) => Array.from({ length: count }, (_, index) => [first + index, zone])));
}
function bytes(base64) {
    return Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
}
export function due(robot, place, now) {
    const seconds = robot.expected.at(place);
    return seconds === undefined ? "" : `in ${clock(Math.max(0, seconds - now))}`;
}
export function clock(seconds) {
    const whole = Math.floor(seconds);
    const [hours, minutes, rest] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
    const two = (number) => String(number).padStart(2, "0");
    return hours > 0 ? `${hours}:${two(minutes)}:${two(rest)}` : `${minutes}:${two(rest)}`;
}
