import { clock } from "./mission.js";
const LEFT = 42;
const BOTTOM = 18;
const TOP = 6;
const RIGHT = 8;
export function drawChart(canvas, mission, value, most) {
    const context = fit(canvas);
    const style = getComputedStyle(document.documentElement);
    const color = (name) => style.getPropertyValue(name).trim();
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const until = Math.max(mission.hello.end ?? mission.frame?.time ?? 1, 1);
    const top = most ?? Math.max(1, ...mission.curve.map((point) => point[value])) * 1.05;
    const x = (seconds) => LEFT + (seconds / until) * (width - LEFT - RIGHT);
    const y = (number) => height - BOTTOM - (number / top) * (height - BOTTOM - TOP);
    context.clearRect(0, 0, width, height);
    context.font = "11px system-ui, sans-serif";
    context.fillStyle = color("--quiet");
    context.strokeStyle = color("--line");
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const share of [0, 0.5, 1]) {
        const number = share * (most ?? top / 1.05);
        context.beginPath();
        context.moveTo(LEFT, y(number));
        context.lineTo(width - RIGHT, y(number));
        context.stroke();
        context.fillText(label(number, top), LEFT - 6, y(number));
    }
    context.textBaseline = "alphabetic";
    context.textAlign = "left";
    context.fillText("0:00", LEFT, height - 4);
    context.textAlign = "right";
    context.fillText(clock(until), width - RIGHT, height - 4);
    drawCurve(context, mission, value, { x, y, color: color("--accent") });
}
function drawCurve(context, mission, value, axes) {
    const { x, y, color } = axes;
    context.strokeStyle = color;
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
