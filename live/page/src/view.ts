// From cells of the map to pixels of the page, and canvases over the whole map.

import { fit } from "./chart.js";
import type { Hello, Spot } from "./mission.js";

/** The part of the map that is on the page. */
export interface View {
  /** Pixels of a cell. */
  size: number;
  /** Pixels of the page's map. */
  width: number;
  height: number;
  /** Pixels, from the map's upper left, of a point in cells east and north. */
  at(spot: Spot): Spot;
}

/** The view that a map shows. Its coordinates are meters, `lat` to the north and `lng` to the east. */
export function viewOf(map: L.Map, hello: Hello): View {
  const corner = map.latLngToContainerPoint([0, 0]);
  const size = hello.cell_meters * 2 ** map.getZoom();
  const { x: width, y: height } = map.getSize();
  return { size, width, height, at: ([east, north]) => [corner.x + east * size, corner.y - north * size] };
}

/** A canvas over the whole map, which stays in place while the map moves under it. */
export class Sheet {
  private readonly canvas = document.createElement("canvas");

  constructor(
    private readonly map: L.Map,
    id: string,
    zIndex: number,
  ) {
    const pane = map.createPane(id);
    pane.style.zIndex = String(zIndex);
    pane.style.pointerEvents = "none";
    this.canvas.id = id;
    pane.append(this.canvas);
  }

  /** An empty sheet; its coordinates are those of [`View`]. */
  begin(): CanvasRenderingContext2D {
    const { x, y } = this.map.getSize();
    L.DomUtil.setPosition(this.canvas, this.map.containerPointToLayerPoint([0, 0]));
    this.canvas.style.width = `${x}px`;
    this.canvas.style.height = `${y}px`;
    const context = fit(this.canvas);
    context.clearRect(0, 0, x, y);
    return context;
  }
}
