// The cells of the map as an image, one pixel a cell.

import { type Rgb, mix, plainColors, probabilityColor, searchedColor } from "./colors.js";
import type { Choice } from "./layers.js";
import type { Mission } from "./mission.js";
import type { View } from "./view.js";

/** Share of the color of no-go ground where it covers another. */
const COVER = 0.65;
/** Opacity of the cells over a base map. */
const OVER_MAP = 0.6;

export class Raster {
  readonly canvas = document.createElement("canvas");
  private key = "";
  private isOnMap = false;
  private mission: Mission | undefined;

  /** Paints the cells, unless nothing has changed. On a base map the ground outside the search area is not covered. */
  paint(mission: Mission, choice: Choice, isOnMap: boolean): void {
    const plain = plainColors();
    const key = `${mission.version} ${choice.base} ${choice.no_go} ${isOnMap} ${plain.unsearched.join()}`;
    if (this.mission === mission && this.key === key) return;
    [this.mission, this.key] = [mission, key];
    const { rows, columns } = mission.hello;
    if (this.canvas.width !== columns || this.canvas.height !== rows) {
      this.canvas.width = columns;
      this.canvas.height = rows;
    }
    this.isOnMap = isOnMap;
    const image = new ImageData(columns, rows);
    const pixels = new Uint32Array(image.data.buffer);
    const colors = lookup(choice);
    const covered = choice.no_go ? colors.map((color) => mix(color, plain.blocked, COVER)) : colors;
    const [open, closed] = [colors.map(pixel), covered.map(pixel)];
    const unsearched = isOnMap ? 0 : pixel(plain.unsearched);
    const blocked = choice.no_go ? pixel(plain.blocked) : unsearched;
    const outOfReach = pixel(plain.outOfReach);
    const values = choice.base === "searched" ? mission.searched : mission.levels;
    for (let cell = 0; cell < rows * columns; cell += 1) {
      const isOpen = mission.isTraversable[cell] === 1;
      const value = values[cell] ?? 0;
      let color: number | undefined = isOpen ? unsearched : blocked;
      if (mission.levels[cell] !== 0) color = isOpen ? open[value] : closed[value];
      if (mission.isOutOfReach[cell] === 1) color = outOfReach;
      pixels[(rows - 1 - Math.floor(cell / columns)) * columns + (cell % columns)] = color ?? 0;
    }
    this.canvas.getContext("2d")?.putImageData(image, 0, 0);
  }

  /** Draws the cells that are in view: the whole map at a close view would be an image of many thousand pixels. */
  draw(context: CanvasRenderingContext2D, mission: Mission, view: View): void {
    const { rows, columns } = mission.hello;
    const [x, y] = view.at([0, rows]);
    const within = (cells: number, most: number) => Math.min(Math.max(cells, 0), most);
    const [west, north] = [within(Math.floor(-x / view.size), columns), within(Math.floor(-y / view.size), rows)];
    const wide = within(Math.ceil((view.width - x) / view.size), columns) - west;
    const high = within(Math.ceil((view.height - y) / view.size), rows) - north;
    if (wide <= 0 || high <= 0) return;
    // Cells keep their edges, unless several share a pixel.
    context.imageSmoothingEnabled = view.size < 1;
    const [left, top] = [x + west * view.size, y + north * view.size];
    context.globalAlpha = this.isOnMap ? OVER_MAP : 1;
    context.drawImage(this.canvas, west, north, wide, high, left, top, wide * view.size, high * view.size);
    context.globalAlpha = 1;
  }
}

/** The color of each value of a layer. */
function lookup(choice: Choice): Rgb[] {
  const color = choice.base === "searched" ? searchedColor : probabilityColor;
  return Array.from({ length: 256 }, (_, value) => color(value));
}

/** A color as a pixel in memory: red, green, blue, alpha. */
function pixel([red, green, blue]: Rgb): number {
  return ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
}
