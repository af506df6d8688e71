import { AreaLayers } from "./areas.js";
import { BaseMap } from "./basemap.js";
import { drawGrid } from "./grid.js";
import { element } from "./panel.js";
import { Pen } from "./pen.js";
import { north } from "./place.js";
import { Raster } from "./raster.js";
import { Sheet, viewOf } from "./view.js";
const STRIDE = 5;
const CLOSEST_PIXELS = 90;
const NEAR_PIXELS = 14;
const WIDE_PIXELS = 600;
const MARGIN = [16, 60];
const MARGIN_END = [16, 34];
const ZOOM_STEP = 0.5;
export class MapView {
    ground;
    events;
    cursor;
    corners = [];
    measured = [];
    map;
    basemap;
    cells;
    marks;
    areas;
    raster = new Raster();
    mission;
    isMoved = false;
    constructor(ground, events) {
        this.ground = ground;
        this.events = events;
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
    listen() {
        const { ground, map } = this;
        map.on("move zoom resize", () => this.events.changed());
        map.on("dragstart", () => (this.isMoved = true));
        map.on("click", (event) => this.tap(event.latlng));
        map.on("mousemove", (event) => this.events.hovered(this.spot(event.latlng), [event.containerPoint.x, event.containerPoint.y]));
        map.on("mouseout", () => this.events.hovered(undefined, [0, 0]));
        ground.addEventListener("wheel", () => (this.isMoved = true), { passive: true });
        ground.addEventListener("keydown", (event) => this.key(event));
        new ResizeObserver(() => this.resize()).observe(ground);
        const press = (id, act) => element(id, HTMLButtonElement).addEventListener("click", act);
        press("zoom-in", () => this.zoom(1));
        press("zoom-out", () => this.zoom(-1));
        press("whole", () => this.whole());
    }
    resize() {
        this.map.invalidateSize({ pan: false });
        if (!this.isMoved)
            this.whole();
    }
    zoom(steps) {
        this.isMoved = true;
        this.map.setZoom(this.map.getZoom() + steps * ZOOM_STEP);
    }
    whole() {
        if (this.mission === undefined)
            return;
        const { rows, columns, cell_meters } = this.mission.hello;
        const bounds = L.latLngBounds([0, 0], [rows * cell_meters, columns * cell_meters]);
        this.map.setMinZoom(-30).setMaxZoom(30);
        const margin = this.map.getSize().x < WIDE_PIXELS ? MARGIN : [MARGIN[1], MARGIN[1]];
        const fitting = this.map.getBoundsZoom(bounds, false, L.point(margin).add(MARGIN_END));
        this.map.setMaxBounds(bounds.pad(0.6)).setMinZoom(fitting - 1.5);
        this.map.setMaxZoom(Math.max(fitting, Math.log2(CLOSEST_PIXELS / cell_meters)));
        this.map.fitBounds(bounds, { paddingTopLeft: margin, paddingBottomRight: MARGIN_END, animate: false });
        this.isMoved = false;
    }
    goTo(cell) {
        if (this.mission === undefined)
            return;
        const near = Math.log2(NEAR_PIXELS / this.mission.hello.cell_meters);
        this.isMoved = true;
        this.map.setView(this.point(this.mission.where(cell)), Math.max(this.map.getZoom(), near), { animate: false });
        this.move(...this.mission.place(cell));
    }
    point([east, north]) {
        const meters = this.mission?.hello.cell_meters ?? 1;
        return [north * meters, east * meters];
    }
    spot({ lat, lng }) {
        const meters = this.mission?.hello.cell_meters ?? 1;
        return [lng / meters, lat / meters];
    }
    tap(at) {
        if (this.mission === undefined)
            return;
        const spot = this.spot(at);
        this.events.tapped(spot);
        const cell = this.mission.cellAt(spot);
        if (cell !== undefined)
            this.move(...this.mission.place(cell));
    }
    key(event) {
        if (this.mission === undefined || event.ctrlKey || event.altKey || event.metaKey)
            return;
        const views = {
            "+": () => this.zoom(1), "=": () => this.zoom(1), "-": () => this.zoom(-1), "0": () => this.whole(),
        };
        views[event.key]?.();
        const steps = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };
        const step = steps[event.key];
        if (step === undefined)
            return;
        event.preventDefault();
        const { rows, columns } = this.mission.hello;
        const [row, column] = this.cursor === undefined ? [rows >> 1, columns >> 1] : this.mission.place(this.cursor);
        const by = this.cursor === undefined ? 0 : event.shiftKey ? STRIDE : 1;
        const within = (value, most) => Math.min(Math.max(value, 0), most);
        this.move(within(row + by * step[0], rows - 1), within(column + by * step[1], columns - 1));
        this.map.panInside(this.point(this.cursorSpot() ?? [0, 0]), { padding: [30, 30], animate: false });
    }
    move(row, column) {
        if (this.mission === undefined)
            return;
        this.cursor = row * this.mission.hello.columns + column;
        this.events.changed();
    }
    cursorSpot() {
        return this.cursor === undefined ? undefined : this.mission?.middle(this.cursor);
    }
    begin(mission) {
        const [before, now] = [this.mission?.hello, mission.hello];
        const isSame = before?.rows === now.rows && before.columns === now.columns && before.cell_meters === now.cell_meters;
        this.mission = mission;
        this.areas.begin(now);
        element("north", HTMLElement).style.transform = `rotate(${north(now)}rad)`;
        if (isSame)
            return;
        this.cursor = undefined;
        this.whole();
    }
    draw(mission, choice) {
        const view = viewOf(this.map, mission.hello);
        const isOnMap = choice.basemap && this.basemap.isFor(mission);
        element("layer-basemap-choice", HTMLElement).hidden = !this.basemap.isFor(mission);
        this.basemap.draw(mission, view, isOnMap);
        this.raster.paint(mission, choice, isOnMap);
        const under = this.cells.begin();
        this.raster.draw(under, mission, view);
        const below = new Pen(under, mission, view);
        if (choice.no_go)
            below.hatch();
        below.zones();
        if (choice.grid)
            drawGrid(under, mission, view);
        this.areas.show(choice);
        const pen = new Pen(this.marks.begin(), mission, view);
        if (choice.tracks)
            pen.tracks();
        if (choice.plans)
            pen.plans();
        pen.clues();
        pen.finds();
        pen.markers();
        pen.area(this.corners);
        pen.measure(this.measured);
        if (this.cursor !== undefined)
            pen.cursor(this.cursor);
    }
}
