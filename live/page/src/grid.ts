// A metric grid over the map.

import type { Mission } from "./mission.js";
import type { View } from "./view.js";

/** The least distance between two lines, pixels. */
const LEAST_PIXELS = 80;

export function drawGrid(context: CanvasRenderingContext2D, mission: Mission, view: View): void {
  const { rows, columns, cell_meters } = mission.hello;
  const step = roundUp((LEAST_PIXELS / view.size) * cell_meters);
  const stroke = (color: string, width: number) => {
    context.strokeStyle = color;
    context.lineWidth = width;
    context.stroke();
  };
  const lines = (axis: 0 | 1, end: number) =>
    Array.from({ length: Math.floor((end * cell_meters) / step) + 1 }, (_, index) => {
      const cells = (index * step) / cell_meters;
      return { meters: index * step, pixel: view.at([cells, cells])[axis] };
    });
  const [west, south] = view.at([0, 0]);
  const [east, north] = view.at([columns, rows]);
  const [down, across] = [lines(0, columns), lines(1, rows)];
  context.beginPath();
  for (const { pixel } of down) context.rect(pixel, north, 0, south - north);
  for (const { pixel } of across) context.rect(west, pixel, east - west, 0);
  stroke("rgba(255, 255, 255, 0.55)", 2);
  stroke("rgba(20, 26, 34, 0.55)", 0.8);
  const bottom = Math.min(south, view.height) - 4;
  const left = Math.max(west, 0) + 3;
  for (const { meters, pixel } of down.slice(1)) label(context, `${meters} m`, pixel + 3, bottom);
  for (const { meters, pixel } of across.slice(1)) label(context, `${meters} m`, left, pixel - 3);
}

function label(context: CanvasRenderingContext2D, text: string, x: number, y: number): void {
  context.font = "11px system-ui, sans-serif";
  context.textAlign = "left";
  context.textBaseline = "alphabetic";
  context.lineJoin = "round";
  context.strokeStyle = "rgba(255, 255, 255, 0.85)";
  context.lineWidth = 3;
  context.strokeText(text, x, y);
  context.fillStyle = "#141a22";
  context.fillText(text, x, y);
}

/** The next of 1, 2, 5, 10, 20, 50, ... */
function roundUp(number: number): number {
  const power = 10 ** Math.floor(Math.log10(number));
  const factor = [1, 2, 5, 10].find((it) => it * power >= number * (1 - 1e-9)) ?? 10;
  return factor * power;
}
