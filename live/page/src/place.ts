// Coordinates of points of the map as people pass them on.

import { keep, kept } from "./kept.js";
import { forward } from "./mgrs.js";
import type { Hello, Mission, Spot } from "./mission.js";

/** `[latitude, longitude]` of a point in cells east and north; undefined if the map is not on the earth. */
export function degrees(hello: Hello, [east, north]: Spot): [number, number] | undefined {
  if (hello.earth === null) return undefined;
  const { corner, east: perEast, north: perNorth } = hello.earth;
  const along = (axis: 0 | 1) => corner[axis] + hello.cell_meters * (east * perEast[axis] + north * perNorth[axis]);
  return [along(0), along(1)];
}

/** The point in cells east and north of `[latitude, longitude]`; undefined if the map is not on the earth. */
export function spotAt(hello: Hello, [latitude, longitude]: [number, number]): Spot | undefined {
  if (hello.earth === null) return undefined;
  const { corner, east, north } = hello.earth;
  const [down, along] = [latitude - corner[0], longitude - corner[1]];
  const area = (east[0] * north[1] - east[1] * north[0]) * hello.cell_meters;
  return [(down * north[1] - along * north[0]) / area, (east[0] * along - east[1] * down) / area];
}

/** How coordinates on the earth are written: as the viewer's maps and receivers do. */
export type Notation = "degrees" | "mgrs" | "utm";

const KEPT = "notation";
const WAYS = { degrees: inDegrees, mgrs: mgrsOf, utm: utmOf };
let notation: Notation = first();

function first(): Notation {
  const chosen = kept(KEPT);
  return chosen === "mgrs" || chosen === "utm" ? chosen : "degrees";
}

/** How the page writes coordinates. */
export function noted(): Notation {
  return notation;
}

/** Chooses how the page writes coordinates, now and in later missions. */
export function note(chosen: Notation): void {
  notation = chosen;
  keep(KEPT, chosen);
}

/**
 * To a meter, in the notation of the page, or in degrees where it has none; of a map that is not on the earth
 * `12.5 m east, 30.5 m north` of its corner.
 */
export function coordinates(hello: Hello, spot: Spot): string {
  const point = degrees(hello, spot);
  if (point !== undefined) return WAYS[notation](point) ?? inDegrees(point);
  const [east, north] = spot.map((cells) => Number((cells * hello.cell_meters).toFixed(1)));
  return `${east} m east, ${north} m north`;
}

/** The same in a second notation, MGRS or else degrees; undefined if the map is not on the earth. */
export function otherwise(hello: Hello, spot: Spot): string | undefined {
  const point = degrees(hello, spot);
  return point === undefined ? undefined : (notation === "degrees" ? mgrsOf(point) : inDegrees(point));
}

/** `49.23650, -2.23959`: latitude and longitude. */
function inDegrees(point: [number, number]): string {
  return point.map((number) => number.toFixed(5)).join(", ");
}

/** Zone, square, and meters east and north in it, of `[latitude, longitude]`; undefined near the poles. */
function square([latitude, longitude]: [number, number]): string[] | undefined {
  if (Math.abs(latitude) > 80) return undefined;
  return /^(\d+[A-Z])([A-Z]{2})(\d{5})(\d{5})$/.exec(forward([longitude, latitude]))?.slice(1);
}

/** `30U WV 55433 53954`; undefined near the poles. */
export function mgrsOf(point: [number, number]): string | undefined {
  return square(point)?.join(" ");
}

/** Letters of the squares of 100 km from west to east in zones 1, 2 and 3; they repeat in each third zone. */
const COLUMNS = ["ABCDEFGH", "JKLMNPQR", "STUVWXYZ"] as const;
/** From the equator to the north, in odd zones; even ones begin with F. They repeat after 2000 km. */
const ROWS = "ABCDEFGHJKLMNPQRSTUV";
const ROW_METERS = 100_000;
const CYCLE_METERS = ROWS.length * ROW_METERS;
/** Northings of the southern hemisphere count from here south of the equator. */
const FALSE_NORTHING_METERS = 10_000_000;
/** Enough to tell one cycle of rows from the next. */
const METERS_PER_DEGREE = 110_900;

/** `30U 555433E 5453954N`: of MGRS, whose squares are those of UTM; undefined near the poles. */
export function utmOf(point: [number, number]): string | undefined {
  const [zone = "", letters = "", east = "", north = ""] = square(point) ?? [];
  if (zone === "") return undefined;
  const number = Number.parseInt(zone, 10);
  const column = 1 + (COLUMNS[(number - 1) % 3] ?? "").indexOf(letters.charAt(0));
  const row = (ROWS.indexOf(letters.charAt(1)) + (number % 2 === 0 ? 15 : 0)) % ROWS.length;
  const about = METERS_PER_DEGREE * point[0] + (point[0] < 0 ? FALSE_NORTHING_METERS : 0);
  const northing = row * ROW_METERS + Number(north);
  const cycles = Math.round((about - northing) / CYCLE_METERS);
  return `${zone} ${column * ROW_METERS + Number(east)}E ${northing + cycles * CYCLE_METERS}N`;
}

/** ` within 2 m`: how well a robot knows where the find of a cell is, as far as its coordinates are written; empty if it is known by its cell alone. */
export function within(mission: Mission, cell: number): string {
  const meters = mission.position(cell)?.accuracy_meters;
  if (meters === undefined) return "";
  return ` within ${mission.hello.earth === null ? meters.toFixed(1) : Math.ceil(meters)} m`;
}

/** Direction of north on the page, radians clockwise from up. */
export function north(hello: Hello): number {
  return hello.earth === null ? 0 : Math.atan2(hello.earth.east[0], hello.earth.north[0]);
}

/** `850 m`, `1.25 km`. */
export function distance(meters: number): string {
  if (meters < 100) return `${meters.toFixed(1)} m`;
  return meters < 1000 ? `${meters.toFixed(0)} m` : `${(meters / 1000).toFixed(2)} km`;
}
