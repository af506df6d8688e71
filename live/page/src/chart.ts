// A curve over the mission's time.

import { type Mission, clock } from "./mission.js";

/** Margins for the labels of the axes, pixels. */
const LEFT = 42;
const BOTTOM = 18;
const TOP = 6;
const RIGHT = 8;

/** What the axes of a chart show. */
export interface Scale {
  /** The values at the right and the top; left and bottom are `left` and 0. */
  left?: number;
  right: number;
  top: number;
  /** Labeled values, from the bottom up. */
  levels: number[];
  level: (value: number) => string;
  /** Labels of the two ends of the lower axis. */
  ends: [string, string];
}

/** A chart with its axes, and where its values lie. */
export interface Axes {
  context: CanvasRenderingContext2D;
  x: (value: number) => number;
  y: (value: number) => number;
  color: (name: string) => string;
}

/** Draws the axes of an empty chart. */
export function drawAxes(canvas: HTMLCanvasElement, { left = 0, right, top, levels, level, ends }: Scale): Axes {
  const context = fit(canvas);
  const style = getComputedStyle(document.documentElement);
  const color = (name: string) => style.getPropertyValue(name).trim();
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  const x = (value: number) => LEFT + ((value - left) / (right - left)) * (width - LEFT - RIGHT);
  const y = (value: number) => height - BOTTOM - (value / top) * (height - BOTTOM - TOP);
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

/** Draws one value of the curve: 1 is the entropy, 2 the progress. */
export function drawChart(canvas: HTMLCanvasElement, mission: Mission, value: 1 | 2, most: number | undefined): void {
  const until = Math.max(mission.hello.end ?? mission.frame?.time ?? 1, 1);
  const top = most ?? Math.max(1, ...mission.curve.map((point) => point[value])) * 1.05;
  const levels = [0, 0.5, 1].map((share) => share * (most ?? top / 1.05));
  const level = (number: number) => label(number, top);
  drawCurve(drawAxes(canvas, { right: until, top, levels, level, ends: ["0:00", clock(until)] }), mission, value);
}

/** Each value holds until the next. */
function drawCurve({ context, x, y, color }: Axes, mission: Mission, value: 1 | 2): void {
  context.strokeStyle = color("--accent");
  context.lineWidth = 2;
  context.beginPath();
  let last: number | undefined;
  for (const point of mission.curve) {
    if (last === undefined) context.moveTo(x(point[0]), y(point[value]));
    else context.lineTo(x(point[0]), y(last));
    context.lineTo(x(point[0]), y(point[value]));
    last = point[value];
  }
  if (last !== undefined && mission.frame !== undefined) context.lineTo(x(mission.frame.time), y(last));
  context.stroke();
  context.lineWidth = 1;
}

function label(number: number, top: number): string {
  if (top <= 1.5) return number.toFixed(1);
  return top < 10 ? number.toFixed(1) : number.toFixed(0);
}

/** Sets the resolution of a canvas to that of the screen; coordinates stay those of the page. */
export function fit(canvas: HTMLCanvasElement): CanvasRenderingContext2D {
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  const context = canvas.getContext("2d");
  if (context === null) throw new Error("this browser has no 2D canvas");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return context;
}
