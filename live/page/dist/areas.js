const OUTLINES = "outlines";
const NAMES = "names";
export const LAYERS = {
    search: "areas", no_go: "no_go", prior: "prior", last_known_position: "prior", linear_feature: "prior", start: "areas",
};
export const STYLES = {
    areas: { color: "#ffffff", weight: 2, fill: false },
    no_go: { color: "#ff5a4f", weight: 2.5, fill: false },
    prior: { color: "#f0a6ff", weight: 2, fill: false, dashArray: "7 5" },
};
export class AreaLayers {
    map;
    groups = {
        areas: L.layerGroup(), no_go: L.layerGroup(), prior: L.layerGroup(),
    };
    constructor(map) {
        this.map = map;
        for (const [id, zIndex] of [[OUTLINES, 420], [NAMES, 440]]) {
            const pane = map.createPane(id);
            pane.style.zIndex = String(zIndex);
            pane.style.pointerEvents = "none";
        }
    }
    begin(hello) {
        for (const group of Object.values(this.groups))
            group.clearLayers();
        for (const area of hello.areas)
            this.add(area);
    }
    show(choice) {
        for (const [id, group] of Object.entries(this.groups)) {
            const isShown = choice[id];
            if (isShown && !this.map.hasLayer(group))
                group.addTo(this.map);
            if (!isShown && this.map.hasLayer(group))
                group.remove();
        }
    }
    add(area) {
        const layer = LAYERS[area.kind];
        const group = this.groups[layer];
        const options = { ...STYLES[layer], pane: OUTLINES, interactive: false };
        const polygons = (area.polygons ?? []).map((rings) => rings.map((ring) => ring.map(point)));
        if (polygons.length > 0)
            name(L.polygon(polygons, options).addTo(group).getBounds(), area).addTo(group);
        for (const line of area.lines ?? [])
            name(L.polyline(line.map(point), options).addTo(group).getBounds(), area).addTo(group);
        if (area.at === undefined)
            return;
        const place = point(area.at);
        for (const radius of radii(area))
            L.circle(place, { ...options, radius }).addTo(group);
        L.circleMarker(place, { ...options, dashArray: "", radius: 4, fill: true, fillOpacity: 1 }).addTo(group);
        name(L.latLngBounds([place]), area).addTo(group);
    }
}
export function radii(place) {
    return place.quartiles_meters ?? (place.spread_meters === undefined ? [] : [place.spread_meters]);
}
export function name(bounds, area) {
    const poa = area.poa === undefined ? "" : `, ${(100 * area.poa).toFixed(0)} %`;
    const content = document.createElement("span");
    content.textContent = area.name + poa;
    const middle = bounds.getCenter();
    const at = area.kind === "search" ? L.latLng(bounds.getNorth(), middle.lng) : middle;
    const direction = area.at !== undefined ? "right" : area.kind === "search" ? "top" : "center";
    return L.tooltip({ permanent: true, direction, className: "area-name", pane: NAMES, interactive: false, opacity: 1 })
        .setLatLng(at)
        .setContent(content);
}
function point([east, north]) {
    return [north, east];
}
