import { clock } from "./mission.js";
const LEFT = 42;
const BOTTOM = 18;
const TOP = 6;
const RIGHT = 8;
export function drawAxes(canvas, { left = 0, right, top, levels, level, ends }) {
    const context = fit(canvas);
    const style = getComputedStyle(document.documentElement);
    const color = (name) => style.getPropertyValue(name).trim();
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const x = (value) => LEFT + ((value - left) / (right - left)) * (width - LEFT - RIGHT);
    const y = (value) => height - BOTTOM - (value / top) * (height - BOTTOM - TOP);
    context.clearRect(0, 0, width, height);
    context.font = "11px system-ui, sans-serif";
    context.fillStyle = color("--quiet");
    context.strokeStyle = color("--line");
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const value of levels) {
        context.beginPath();
        context.moveTo(LEFT, y(value));
        context.lineTo(width - RIGHT, y(value));
        context.stroke();
        context.fillText(level(value), LEFT - 6, y(value));
    }
    context.textBaseline = "alphabetic";
    context.textAlign = "left";
    context.fillText(ends[0], LEFT, height - 4);
    context.textAlign = "right";
    context.fillText(ends[1], width - RIGHT, height - 4);
    return { context, x, y, color };
}
export function drawChart(canvas, mission, value, most) {
    const until = Math.max(mission.hello.end ?? mission.frame?.time ?? 1, 1);
    const top = most ?? Math.max(1, ...mission.curve.map((point) => point[value])) * 1.05;
    const levels = [0, 0.5, 1].map((share) => share * (most ?? top / 1.05));
    const level = (number) => label(number, top);
    drawCurve(drawAxes(canvas, { right: until, top, levels, level, ends: ["0:00", clock(until)] }), mission, value);
}
function drawCurve({ context, x, y, color }, mission, value) {
    context.strokeStyle = color("--accent");
    context.lineWidth = 2;
    context.beginPath();
    let last;
    for (const point of mission.curve) {
        if (last === undefined)
            context.moveTo(x(point[0]), y(point[value]));
        else
            context.lineTo(x(point[0]), y(last));
        context.lineTo(x(point[0]), y(point[value]));
        last = point[value];
    }
    if (last !== undefined && mission.frame !== undefined)
        context.lineTo(x(mission.frame.time), y(last));
    context.stroke();
    context.lineWidth = 1;
}
function label(number, top) {
    if (top <= 1.5)
        return number.toFixed(1);
    return top < 10 ? number.toFixed(1) : number.toFixed(0);
}
export function fit(canvas) {
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
    if (canvas.width !== width || canvas.height !== height) {
        canvas.width = width;
        canvas.height = height;
    }
    const context = canvas.getContext("2d");
    if (context === null)
        throw new Error("this browser has no 2D canvas");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    return context;
}
