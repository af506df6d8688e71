const TRAIL_CELLS = 400;
const MOST_POINTS = 2000;
export class Mission {
    hello;
    isTraversable;
    levels;
    isOutOfReach;
    frame;
    trails = new Map();
    curve = [];
    isOver = false;
    constructor(hello) {
        this.hello = hello;
        this.isTraversable = bytes(hello.ground);
        this.levels = new Uint8Array(hello.rows * hello.columns);
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
        if (frame.levels !== undefined)
            this.levels = bytes(frame.levels);
        if (frame.out_of_reach !== undefined)
            this.isOutOfReach = bytes(frame.out_of_reach);
        for (const [cell, level] of frame.changes ?? [])
            this.levels[cell] = level;
        for (const robot of frame.robots) {
            const trail = [...(this.trails.get(robot.robot) ?? []), ...robot.trail];
            this.trails.set(robot.robot, trail.slice(-TRAIL_CELLS));
        }
        this.frame = frame;
    }
    place(cell) {
        return [Math.floor(cell / this.hello.columns), cell % this.hello.columns];
    }
    name(cell) {
        const [row, column] = this.place(cell);
        return `[${row}, ${column}]`;
    }
}
function bytes(base64) {
    return Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
}
export function clock(seconds) {
    const whole = Math.floor(seconds);
    const [hours, minutes, rest] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
    const two = (number) => String(number).padStart(2, "0");
    return hours > 0 ? `${hours}:${two(minutes)}:${two(rest)}` : `${minutes}:${two(rest)}`;
}
