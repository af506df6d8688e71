// Features of the plan, and coordinates as people type them. Nothing here touches the page.

import type { Feature, Geometry, Kind, Position } from "./api.js";

export const KINDS: Record<Kind, string> = {
  search: "Search area",
  no_go: "No-go area",
  prior: "Likely region",
  last_known_position: "Last known position",
  linear_feature: "Linear feature",
  start: "Start",
};

/** Kinds that a shape can have. */
export const OF_AREAS: readonly Kind[] = ["search", "no_go", "prior"];
export const OF_LINES: readonly Kind[] = ["no_go", "linear_feature"];
export const OF_PLACES: readonly Kind[] = ["last_known_position", "start"];

export function isPlace(kind: Kind): boolean {
  return OF_PLACES.includes(kind);
}

/** The kinds that the shape of a feature can have. */
export function kindsOf(feature: Feature): readonly Kind[] {
  if (isPlace(kindOf(feature))) return OF_PLACES;
  const all = lines(feature.geometry);
  return all.length > 0 && all.every((line) => !line.isRing) ? OF_LINES : OF_AREAS;
}

export function kindOf(feature: Feature): Kind {
  return feature.properties?.kind ?? "search";
}

/** A new feature; `corners` are longitudes and latitudes. */
export function feature(kind: Kind, corners: Position[], features: Feature[]): Feature {
  const geometry: Geometry = isPlace(kind)
    ? { type: "Point", coordinates: corners[0] ?? [] }
    : { type: "Polygon", coordinates: [closed(corners)] };
  const spread = kind === "last_known_position" ? { spread_meters: 200 } : {};
  return { type: "Feature", properties: { name: nextName(kind, features), kind, ...spread }, geometry };
}

/** `No-go area 2`: the first name that is free. */
function nextName(kind: Kind, features: Feature[]): string {
  const names = new Set(features.map((it) => it.properties?.name));
  for (let number = 1; ; number += 1) {
    const name = `${KINDS[kind]} ${number}`;
    if (!names.has(name)) return name;
  }
}

/** A ring whose last corner is its first. */
export function closed(corners: Position[]): Position[] {
  const [first, last] = [corners[0], corners.at(-1)];
  if (first === undefined || last === undefined) return [];
  return first[0] === last[0] && first[1] === last[1] ? corners : [...corners, first];
}

/** All rings and lines of a shape, and whether they are closed. The lists are those of the shape: changing one changes it. */
export function lines(geometry: Geometry | null): { corners: Position[]; isRing: boolean }[] {
  const of = (all: Position[][], isRing: boolean) => all.map((corners) => ({ corners, isRing }));
  switch (geometry?.type) {
    case "Polygon": return of(geometry.coordinates, true);
    case "MultiPolygon": return of(geometry.coordinates.flat(), true);
    case "LineString": return of([geometry.coordinates], false);
    case "MultiLineString": return of(geometry.coordinates, false);
    case "GeometryCollection": return geometry.geometries.flatMap(lines);
    default: return [];
  }
}

/** Moves a corner of a line; the first of a ring is its last too. */
export function moveCorner({ corners, isRing }: { corners: Position[]; isRing: boolean }, index: number, to: Position): void {
  corners[index] = to;
  if (isRing && index === 0) corners[corners.length - 1] = to;
}

/** Removes a corner, if enough remain. */
export function removeCorner({ corners, isRing }: { corners: Position[]; isRing: boolean }, index: number): void {
  if (corners.length <= (isRing ? 4 : 2)) return;
  corners.splice(index, 1);
  const first = corners[0];
  if (isRing && index === 0 && first !== undefined) corners[corners.length - 1] = first;
}

/** `900 m²`, `3.25 ha`, `1.30 km²`: the unit in which the number can be read. */
export function groundOf(squareMeters: number): string {
  if (squareMeters < 1e4) return `${squareMeters.toFixed(0)} m²`;
  return squareMeters < 1e6 ? `${(squareMeters / 1e4).toFixed(2)} ha` : `${(squareMeters / 1e6).toFixed(2)} km²`;
}

/** `49.23600, -2.24000`: latitude and longitude to a meter. */
export function written([longitude = NaN, latitude = NaN]: Position): string {
  return `${latitude.toFixed(5)}, ${longitude.toFixed(5)}`;
}

/**
 * A position from a text such as `49.236, -2.24`, `49.236 N 2.24 W`, `49°14'10"N 2°14'24"W` or `49 14.16 N, 2 14.4 W`;
 * latitude first. Otherwise what is wrong with it.
 */
export function parsePosition(text: string): Position | string {
  const allowed = "allowed is a latitude and a longitude such as 49.236, -2.24 or 49°14'10\"N 2°14'24\"W";
  const parts = halves(text.trim().toUpperCase());
  const [latitude, longitude] = [angle(parts?.[0], "NS"), angle(parts?.[1], "EW")];
  if (latitude === undefined || longitude === undefined) return `“${text.trim()}” is no position; ${allowed}.`;
  if (Math.abs(latitude) > 85) return `A latitude of ${latitude} is not possible; allowed is -85 to 85.`;
  if (Math.abs(longitude) > 180) return `A longitude of ${longitude} is not possible; allowed is -180 to 180.`;
  return [longitude, latitude];
}

/** Latitude and longitude: divided by a comma or semicolon, by the letter of the first, or by the space between two numbers. */
function halves(text: string): [string, string] | undefined {
  const found = /^([^,;]+)[,;]([^,;]+)$/.exec(text) ?? /^(.*[NS])\s*(.+)$/.exec(text) ?? /^(\S+)\s+(\S+)$/.exec(text);
  return found === null ? undefined : [found[1] ?? "", found[2] ?? ""];
}

/** Degrees of an angle: decimal, or with minutes and seconds. */
function angle(text: string | undefined, letters: string): number | undefined {
  const found = /^(?<sign>[-−+]?)(?<numbers>[\d.]+(?:[\s°'′"″]+[\d.]+){0,2})[\s°'′"″]*(?<letter>[NSEW]?)$/.exec(text?.trim() ?? "");
  const { sign = "", numbers = "", letter = "" } = found?.groups ?? {};
  if (found === null || (letter !== "" && (!letters.includes(letter) || sign !== ""))) return undefined;
  const [degrees = NaN, minutes = 0, seconds = 0] = numbers.split(/[\s°'′"″]+/).map(Number);
  if (!(minutes < 60 && seconds < 60)) return undefined;
  const value = degrees + minutes / 60 + seconds / 3600;
  return Number.isFinite(value) ? (/[-−]/.test(sign) || letter === "S" || letter === "W" ? -value : value) : undefined;
}

/** What an area with fewer corners is told. */
export const FEW_CORNERS = "An area has at least three corners.";

/** Corners of a text, one a line; otherwise what is wrong, and in which line. */
export function parseCorners(text: string, isRing: boolean): Position[] | string {
  const positions: Position[] = [];
  for (const [index, line] of text.split("\n").entries()) {
    if (line.trim() === "") continue;
    const position = parsePosition(line);
    if (typeof position === "string") return `Line ${index + 1}: ${position}`;
    positions.push(position);
  }
  if (isRing && positions.length < 3) return FEW_CORNERS;
  return positions.length < 2 ? "A line has at least two corners." : positions;
}
