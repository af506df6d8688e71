import { LAYERS, STYLES, name, radii } from "../areas.js";
import { TILE_URL, basemap } from "../basemap.js";
import { robotColor } from "../colors.js";
import { element } from "../panel.js";
import { kindOf, lines, moveCorner, removeCorner } from "./drawing.js";
const MOST_HANDLES = 200;
const WORLD = [[30, 0], 2];
const CLOSEST = 21;
const NEAR = 16;
const TINY = 2;
const STEPS = [30, 10, 5, 2, 1, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005];
const LEAST_PIXELS = 110;
export class PlanMap {
    events;
    isDrawing = false;
    map;
    shapes = L.layerGroup();
    handles = L.layerGroup();
    graticule = L.layerGroup();
    sketch = L.layerGroup();
    isMoved = false;
    constructor(ground, events) {
        this.events = events;
        this.map = L.map(ground, {
            zoomControl: false, attributionControl: false, doubleClickZoom: false, zoomSnap: 0.5, zoomDelta: 0.5, maxZoom: CLOSEST,
            minZoom: 1, worldCopyJump: true, fadeAnimation: false, zoomAnimation: false,
        });
        this.map.setView(...WORLD);
        for (const [pane, zIndex] of [["grid", 405], ["outlines", 420], ["names", 640]]) {
            this.map.createPane(pane).style.zIndex = String(zIndex);
        }
        const names = this.map.getPane("names");
        if (names !== undefined)
            names.style.pointerEvents = "none";
        L.control.scale({ imperial: false, position: "bottomleft", maxWidth: 130 }).addTo(this.map);
        for (const group of [this.graticule, this.shapes, this.sketch, this.handles])
            group.addTo(this.map);
        this.map.on("click", ({ latlng }) => {
            events.tapped(position(latlng));
            if (!this.isDrawing)
                events.selected(undefined);
        });
        this.map.on("mousemove", ({ latlng }) => events.hovered(position(latlng)));
        this.map.on("mouseout", () => events.hovered(undefined));
        this.map.on("dragstart zoomstart", () => (this.isMoved = true));
        this.map.on("moveend resize", () => this.drawGraticule());
        new ResizeObserver(() => this.map.invalidateSize({ pan: false })).observe(ground);
        this.drawGraticule();
        void this.lay();
        const press = (id, act) => element(id, HTMLButtonElement).addEventListener("click", act);
        press("zoom-in", () => this.map.zoomIn());
        press("zoom-out", () => this.map.zoomOut());
    }
    async lay() {
        const about = await basemap();
        if (about === undefined)
            return;
        const { min_zoom: minNativeZoom, max_zoom: maxNativeZoom, bounds: [west, south, east, north] } = about;
        const bounds = L.latLngBounds([south, west], [north, east]);
        const minZoom = Math.max(minNativeZoom - TINY, 0);
        L.tileLayer(TILE_URL, { minZoom, minNativeZoom, maxNativeZoom, maxZoom: CLOSEST, bounds }).addTo(this.map);
        if (this.isMoved || this.shapes.getLayers().length > 0)
            return;
        this.map.setView(bounds.getCenter(), Math.max(this.map.getBoundsZoom(bounds), minNativeZoom), { animate: false });
    }
    whole(features, isFirst = false) {
        if (isFirst && this.isMoved)
            return;
        const corners = features.flatMap(cornersOf);
        if (corners.length === 0)
            return;
        this.map.fitBounds(L.latLngBounds(corners.map(latLng)), { padding: [40, 40], maxZoom: NEAR, animate: false });
    }
    show(feature) {
        this.whole([feature]);
    }
    goTo(at) {
        this.isMoved = true;
        this.map.setView(latLng(at), Math.max(this.map.getZoom(), NEAR - 1), { animate: false });
    }
    draw(state, selected) {
        this.shapes.clearLayers();
        this.handles.clearLayers();
        const { features, scenario } = state.plan;
        this.addUnseen(state.review.unseen);
        let starts = 0;
        features.forEach((feature, index) => {
            const isWrong = state.review.problems.some(({ at }) => typeof at === "object" && "feature" in at && at.feature === index);
            if (kindOf(feature) === "start")
                starts += 1;
            this.add(feature, index, { isSelected: index === selected, isWrong, robot: starts <= scenario.robots.count ? starts : undefined });
        });
        const feature = selected === undefined ? undefined : features[selected];
        if (feature !== undefined && selected !== undefined && !this.isDrawing)
            this.addHandles(feature, selected);
    }
    addUnseen(unseen) {
        const style = { stroke: false, fillColor: "url(#hatch)", fillOpacity: 1, interactive: false, pane: "outlines", className: "plan-unseen" };
        for (const [south, west, north, east] of unseen)
            L.rectangle([[south, west], [north, east]], style).addTo(this.shapes);
        element("unseen", HTMLElement).hidden = unseen.length === 0;
    }
    add(feature, index, as) {
        const kind = kindOf(feature);
        const style = {
            ...STYLES[LAYERS[kind]], pane: "outlines", fill: true, fillOpacity: as.isSelected ? 0.3 : 0.12, weight: as.isSelected ? 4 : 2.5,
            ...(as.isWrong ? { color: "#ffb000", dashArray: "2 6" } : {}),
        };
        const select = (event) => {
            if (this.isDrawing)
                return;
            L.DomEvent.stopPropagation(event);
            this.events.selected(index);
        };
        const label = { name: feature.properties?.name ?? "", kind, ...known({ poa: feature.properties?.poa }) };
        for (const { corners, isRing } of lines(feature.geometry)) {
            if (!corners.every(isPosition) || corners.length === 0)
                continue;
            const points = corners.map(latLng);
            const line = isRing ? L.polygon(points, style) : L.polyline(points, { ...style, fill: false });
            name(line.addTo(this.shapes).on("click", select).getBounds(), label).addTo(this.shapes);
        }
        if (feature.geometry?.type !== "Point" || !isPosition(feature.geometry.coordinates))
            return;
        const at = latLng(feature.geometry.coordinates);
        const around = kind === "last_known_position" ? radii(feature.properties ?? {}).filter((radius) => radius > 0) : [];
        for (const radius of around)
            L.circle(at, { ...style, radius }).addTo(this.shapes).on("click", select);
        this.marker(at, as.robot === undefined || kind !== "start" ? "" : String(as.robot), kind === "start" ? as.robot : undefined)
            .on("click", select)
            .on("dragend", (event) => this.movePlace(index, event.target.getLatLng()))
            .addTo(this.shapes);
        name(L.latLngBounds([at]), { ...label, at: [0, 0] }).addTo(this.shapes);
    }
    movePlace(index, to) {
        this.events.changed(index, (feature) => {
            feature.geometry = { type: "Point", coordinates: position(to) };
        });
    }
    marker(at, text, robot) {
        const sign = document.createElement("span");
        sign.textContent = text;
        if (robot !== undefined)
            sign.style.borderColor = robotColor(robot);
        const icon = L.divIcon({ html: sign, className: "plan-place", iconSize: [26, 26] });
        return L.marker(at, { icon, draggable: true, keyboard: false, autoPan: true });
    }
    addHandles(feature, index) {
        const all = lines(feature.geometry);
        if (all.reduce((sum, line) => sum + line.corners.length, 0) > MOST_HANDLES)
            return;
        all.forEach(({ corners, isRing }, which) => {
            const change = (act) => this.events.changed(index, (it) => {
                const line = lines(it.geometry)[which];
                if (line !== undefined)
                    act(line);
            });
            const count = isRing ? corners.length - 1 : corners.length;
            for (let at = 0; at < count; at += 1) {
                const [here, next] = [corners[at], corners[at + 1]];
                if (here === undefined || !isPosition(here))
                    continue;
                this.handle(here, "plan-corner", 18)
                    .on("dragend", (event) => change((line) => moveCorner(line, at, position(event.target.getLatLng()))))
                    .on("dblclick", () => change((line) => removeCorner(line, at)));
                if (next === undefined || !isPosition(next))
                    continue;
                const middle = [(Number(here[0]) + Number(next[0])) / 2, (Number(here[1]) + Number(next[1])) / 2];
                this.handle(middle, "plan-middle", 12).on("dragend", (event) => change((line) => line.corners.splice(at + 1, 0, position(event.target.getLatLng()))));
            }
        });
    }
    handle(at, className, pixels) {
        const icon = L.divIcon({ className, iconSize: [pixels, pixels] });
        return L.marker(latLng(at), { icon, draggable: true, keyboard: false }).addTo(this.handles);
    }
    sketchOf(corners) {
        this.sketch.clearLayers();
        const points = corners.map(latLng);
        if (points.length > 1)
            L.polyline(points, { color: "#ffffff", weight: 3, dashArray: "6 5", interactive: false, pane: "outlines" }).addTo(this.sketch);
        for (const point of points)
            L.circleMarker(point, { radius: 5, color: "#111111", fillColor: "#ffffff", fillOpacity: 1, weight: 2, interactive: false, pane: "outlines" }).addTo(this.sketch);
    }
    drawGraticule() {
        this.graticule.clearLayers();
        const bounds = this.map.getBounds();
        const width = this.map.getSize().x / Math.max(bounds.getEast() - bounds.getWest(), 1e-9);
        const step = STEPS.findLast((it) => it * width >= LEAST_PIXELS) ?? 30;
        const style = { color: "#ffffff", weight: 1, opacity: 0.22, interactive: false, pane: "grid" };
        const digits = Math.max(0, -Math.floor(Math.log10(step)));
        const label = (text, at) => L.tooltip({ permanent: true, direction: "right", offset: [-4, 0], className: "plan-degree", pane: "grid", interactive: false }).setLatLng(at).setContent(text).addTo(this.graticule);
        const [west, east] = [Math.max(bounds.getWest(), -540), Math.min(bounds.getEast(), 540)];
        const [south, north] = [Math.max(bounds.getSouth(), -85), Math.min(bounds.getNorth(), 85)];
        const edge = this.map.containerPointToLatLng([60, this.map.getSize().y - 34]);
        for (let number = Math.ceil(west / step); number * step <= east; number += 1) {
            L.polyline([[south, number * step], [north, number * step]], style).addTo(this.graticule);
            label(`${(number * step).toFixed(digits)}°`, [edge.lat, number * step]);
        }
        for (let number = Math.ceil(south / step); number * step <= north; number += 1) {
            L.polyline([[number * step, west], [number * step, east]], style).addTo(this.graticule);
            label(`${(number * step).toFixed(digits)}°`, [number * step, edge.lng]);
        }
    }
}
function known(label) {
    return label.poa === undefined ? {} : { poa: label.poa };
}
function cornersOf(feature) {
    const { geometry } = feature;
    const corners = geometry?.type === "Point" ? [geometry.coordinates] : lines(geometry).flatMap((line) => line.corners);
    return corners.filter(isPosition);
}
function isPosition(position) {
    return position.length >= 2 && position.every(Number.isFinite) && Math.abs(position[1] ?? 90) <= 85;
}
function latLng([longitude = 0, latitude = 0]) {
    return [latitude, longitude];
}
function position(at) {
    const { lng, lat } = at.wrap();
    return [Number(lng.toFixed(7)), Number(lat.toFixed(7))];
}
