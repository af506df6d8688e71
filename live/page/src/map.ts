// The map: its view, a cell cursor for pointer and keys, and what is drawn on it.

import { AreaLayers } from "./areas.js";
import { BaseMap } from "./basemap.js";
import { drawGrid } from "./grid.js";
import type { Choice } from "./layers.js";
import type { Mission, Spot } from "./mission.js";
import { element } from "./panel.js";
import { Pen } from "./pen.js";
import { north } from "./place.js";
import { Raster } from "./raster.js";
import { Sheet, viewOf } from "./view.js";

/** Cells that the cursor moves with Shift. */
const STRIDE = 5;
/** Pixels of a cell at the closest view, */
const CLOSEST_PIXELS = 90;
/** and at least where the map goes to a cell. */
const NEAR_PIXELS = 14;
/** Pixels around the whole map: left and above, where the buttons are, and right and below. On a map wider than this
 * the left margin is as wide as the upper one. */
const WIDE_PIXELS = 600;
const MARGIN: L.PointTuple = [16, 60];
const MARGIN_END: L.PointTuple = [16, 34];
/** Steps of the zoom keys and buttons, powers of two. */
const ZOOM_STEP = 0.5;

export interface MapEvents {
  /** The view or the cursor has changed. */
  changed(): void;
  /** The map was tapped at a point, in cells east and north of the south-western corner. */
  tapped(spot: Spot): void;
  /** The pointer is over a point, and at these pixels; undefined when it leaves. */
  hovered(spot: Spot | undefined, pixels: Spot): void;
}

export class MapView {
  cursor: number | undefined;
  /** Corners of an area that is being drawn. */
  corners: Spot[] = [];
  /** Points between which a distance is measured. */
  measured: Spot[] = [];
  private readonly map: L.Map;
  private readonly basemap: BaseMap;
  private readonly cells: Sheet;
  private readonly marks: Sheet;
  private readonly areas: AreaLayers;
  private readonly raster = new Raster();
  private mission: Mission | undefined;
  /** Whether the viewer has chosen another view than the whole map. */
  private isMoved = false;

  constructor(
    private readonly ground: HTMLElement,
    private readonly events: MapEvents,
  ) {
    // Meters to the east and north. The canvases are drawn anew at each step of a zoom, so there is nothing to animate.
    this.map = L.map(ground, {
      crs: L.CRS.Simple, keyboard: false, zoomControl: false, attributionControl: false, zoomAnimation: false,
      fadeAnimation: false, doubleClickZoom: false, zoomSnap: 0, zoomDelta: ZOOM_STEP, wheelPxPerZoomLevel: 120,
      maxBoundsViscosity: 0.8,
    });
    this.map.setView([0, 0], 0);
    L.control.scale({ imperial: false, position: "bottomleft", maxWidth: 130 }).addTo(this.map);
    this.basemap = new BaseMap(this.map, () => events.changed());
    this.cells = new Sheet(this.map, "cells", 410);
    this.areas = new AreaLayers(this.map);
    this.marks = new Sheet(this.map, "canvas", 450);
    this.listen();
  }

  private listen(): void {
    const { ground, map } = this;
    map.on("move zoom resize", () => this.events.changed());
    map.on("dragstart", () => (this.isMoved = true));
    map.on("click", (event) => this.tap(event.latlng));
    map.on("mousemove", (event) => this.events.hovered(this.spot(event.latlng), [event.containerPoint.x, event.containerPoint.y]));
    map.on("mouseout", () => this.events.hovered(undefined, [0, 0]));
    ground.addEventListener("wheel", () => (this.isMoved = true), { passive: true });
    ground.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.resize()).observe(ground);
    const press = (id: string, act: () => void) => element(id, HTMLButtonElement).addEventListener("click", act);
    press("zoom-in", () => this.zoom(1));
    press("zoom-out", () => this.zoom(-1));
    press("whole", () => this.whole());
  }

  private resize(): void {
    this.map.invalidateSize({ pan: false });
    if (!this.isMoved) this.whole();
  }

  private zoom(steps: number): void {
    this.isMoved = true;
    this.map.setZoom(this.map.getZoom() + steps * ZOOM_STEP);
  }

  /** Shows the whole map. */
  whole(): void {
    if (this.mission === undefined) return;
    const { rows, columns, cell_meters } = this.mission.hello;
    const bounds = L.latLngBounds([0, 0], [rows * cell_meters, columns * cell_meters]);
    // The bounds of the view would otherwise hold it at the old zoom.
    this.map.setMinZoom(-30).setMaxZoom(30);
    const margin: L.PointTuple = this.map.getSize().x < WIDE_PIXELS ? MARGIN : [MARGIN[1], MARGIN[1]];
    const fitting = this.map.getBoundsZoom(bounds, false, L.point(margin).add(MARGIN_END));
    this.map.setMaxBounds(bounds.pad(0.6)).setMinZoom(fitting - 1.5);
    this.map.setMaxZoom(Math.max(fitting, Math.log2(CLOSEST_PIXELS / cell_meters)));
    this.map.fitBounds(bounds, { paddingTopLeft: margin, paddingBottomRight: MARGIN_END, animate: false });
    this.isMoved = false;
  }

  /** Brings a cell, or the find in it, to the middle, near enough to see it, and moves the cursor there. */
  goTo(cell: number): void {
    if (this.mission === undefined) return;
    const near = Math.log2(NEAR_PIXELS / this.mission.hello.cell_meters);
    this.isMoved = true;
    this.map.setView(this.point(this.mission.where(cell)), Math.max(this.map.getZoom(), near), { animate: false });
    this.move(...this.mission.place(cell));
  }

  private point([east, north]: Spot): L.LatLngTuple {
    const meters = this.mission?.hello.cell_meters ?? 1;
    return [north * meters, east * meters];
  }

  private spot({ lat, lng }: L.LatLng): Spot {
    const meters = this.mission?.hello.cell_meters ?? 1;
    return [lng / meters, lat / meters];
  }

  private tap(at: L.LatLng): void {
    if (this.mission === undefined) return;
    const spot = this.spot(at);
    this.events.tapped(spot);
    const cell = this.mission.cellAt(spot);
    if (cell !== undefined) this.move(...this.mission.place(cell));
  }

  private key(event: KeyboardEvent): void {
    if (this.mission === undefined || event.ctrlKey || event.altKey || event.metaKey) return;
    const views: Record<string, () => void> = {
      "+": () => this.zoom(1), "=": () => this.zoom(1), "-": () => this.zoom(-1), "0": () => this.whole(),
    };
    views[event.key]?.();
    const steps: Record<string, Spot> = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };
    const step = steps[event.key];
    if (step === undefined) return;
    event.preventDefault();
    const { rows, columns } = this.mission.hello;
    const [row, column] = this.cursor === undefined ? [rows >> 1, columns >> 1] : this.mission.place(this.cursor);
    const by = this.cursor === undefined ? 0 : event.shiftKey ? STRIDE : 1;
    const within = (value: number, most: number) => Math.min(Math.max(value, 0), most);
    this.move(within(row + by * step[0], rows - 1), within(column + by * step[1], columns - 1));
    this.map.panInside(this.point(this.cursorSpot() ?? [0, 0]), { padding: [30, 30], animate: false });
  }

  private move(row: number, column: number): void {
    if (this.mission === undefined) return;
    this.cursor = row * this.mission.hello.columns + column;
    this.events.changed();
  }

  /** The middle of the cursor's cell. */
  cursorSpot(): Spot | undefined {
    return this.cursor === undefined ? undefined : this.mission?.middle(this.cursor);
  }

  /** Takes up a mission. The same one again, after the stream broke, keeps its view and cursor. */
  begin(mission: Mission): void {
    const [before, now] = [this.mission?.hello, mission.hello];
    const isSame = before?.rows === now.rows && before.columns === now.columns && before.cell_meters === now.cell_meters;
    this.mission = mission;
    this.areas.begin(now);
    element("north", HTMLElement).style.transform = `rotate(${north(now)}rad)`;
    if (isSame) return;
    this.cursor = undefined;
    this.whole();
  }

  draw(mission: Mission, choice: Choice): void {
    const view = viewOf(this.map, mission.hello);
    const isOnMap = choice.basemap && this.basemap.isFor(mission);
    element("layer-basemap-choice", HTMLElement).hidden = !this.basemap.isFor(mission);
    this.basemap.draw(mission, view, isOnMap);
    this.raster.paint(mission, choice, isOnMap);
    const under = this.cells.begin();
    this.raster.draw(under, mission, view);
    const below = new Pen(under, mission, view);
    if (choice.no_go) below.hatch();
    below.zones();
    if (choice.grid) drawGrid(under, mission, view);
    this.areas.show(choice);
    const pen = new Pen(this.marks.begin(), mission, view);
    if (choice.tracks) pen.tracks();
    if (choice.plans) pen.plans();
    pen.clues();
    pen.finds();
    pen.markers();
    pen.area(this.corners);
    pen.measure(this.measured);
    if (this.cursor !== undefined) pen.cursor(this.cursor);
  }
}
