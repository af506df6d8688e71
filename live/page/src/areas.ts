// The areas drawn on the map, with their names.

import type { Choice } from "./layers.js";
import type { Area, Hello, Spot } from "./mission.js";

/** Panes between the cells and the robots: outlines, and names over them. */
const OUTLINES = "outlines";
const NAMES = "names";

type Layer = "areas" | "no_go" | "prior";

export const LAYERS: Record<Area["kind"], Layer> = {
  search: "areas", no_go: "no_go", prior: "prior", last_known_position: "prior", linear_feature: "prior", start: "areas",
};

export const STYLES: Record<Layer, L.PathOptions> = {
  areas: { color: "#ffffff", weight: 2, fill: false },
  no_go: { color: "#ff5a4f", weight: 2.5, fill: false },
  prior: { color: "#f0a6ff", weight: 2, fill: false, dashArray: "7 5" },
};

export class AreaLayers {
  private readonly groups: Record<Layer, L.LayerGroup> = {
    areas: L.layerGroup(), no_go: L.layerGroup(), prior: L.layerGroup(),
  };

  constructor(private readonly map: L.Map) {
    for (const [id, zIndex] of [[OUTLINES, 420], [NAMES, 440]] as const) {
      const pane = map.createPane(id);
      pane.style.zIndex = String(zIndex);
      pane.style.pointerEvents = "none";
    }
  }

  begin(hello: Hello): void {
    for (const group of Object.values(this.groups)) group.clearLayers();
    for (const area of hello.areas) this.add(area);
  }

  show(choice: Choice): void {
    for (const [id, group] of Object.entries(this.groups)) {
      const isShown = choice[id as Layer];
      if (isShown && !this.map.hasLayer(group)) group.addTo(this.map);
      if (!isShown && this.map.hasLayer(group)) group.remove();
    }
  }

  private add(area: Area): void {
    const layer = LAYERS[area.kind];
    const group = this.groups[layer];
    const options = { ...STYLES[layer], pane: OUTLINES, interactive: false };
    const polygons = (area.polygons ?? []).map((rings) => rings.map((ring) => ring.map(point)));
    if (polygons.length > 0) name(L.polygon(polygons, options).addTo(group).getBounds(), area).addTo(group);
    for (const line of area.lines ?? []) name(L.polyline(line.map(point), options).addTo(group).getBounds(), area).addTo(group);
    if (area.at === undefined) return;
    const place = point(area.at);
    for (const radius of radii(area)) L.circle(place, { ...options, radius }).addTo(group);
    L.circleMarker(place, { ...options, dashArray: "", radius: 4, fill: true, fillOpacity: 1 }).addTo(group);
    name(L.latLngBounds([place]), area).addTo(group);
  }
}

/** One spread around a place, or the distances within which a quarter, a half, three quarters and 95 % are found. */
export function radii(place: { spread_meters?: number; quartiles_meters?: number[] }): number[] {
  return place.quartiles_meters ?? (place.spread_meters === undefined ? [] : [place.spread_meters]);
}

/** The name of an area in its middle, of a place beside it; that of a search area at its edge, since others lie in it. */
export function name(bounds: L.LatLngBounds, area: Pick<Area, "name" | "kind" | "at" | "poa">): L.Tooltip {
  const poa = area.poa === undefined ? "" : `, ${(100 * area.poa).toFixed(0)} %`;
  // As a node, so that a name is never read as HTML.
  const content = document.createElement("span");
  content.textContent = area.name + poa;
  const middle = bounds.getCenter();
  const at = area.kind === "search" ? L.latLng(bounds.getNorth(), middle.lng) : middle;
  const direction = area.at !== undefined ? "right" : area.kind === "search" ? "top" : "center";
  return L.tooltip({ permanent: true, direction, className: "area-name", pane: NAMES, interactive: false, opacity: 1 })
    .setLatLng(at)
    .setContent(content);
}

/** A point in meters, as Leaflet takes it. */
function point([east, north]: Spot): L.LatLngTuple {
  return [north, east];
}
