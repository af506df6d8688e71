// Coordinates of points of the map as people pass them on.

import { forward } from "./mgrs.js";
import type { Hello, Spot } from "./mission.js";

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

/** `49.23650, -2.23959`, to a meter; of a map that is not on the earth `12.5 m east, 30.5 m north` of its corner. */
export function coordinates(hello: Hello, spot: Spot): string {
  const point = degrees(hello, spot);
  if (point !== undefined) return point.map((number) => number.toFixed(5)).join(", ");
  const [east, north] = spot.map((cells) => Number((cells * hello.cell_meters).toFixed(1)));
  return `${east} m east, ${north} m north`;
}

/** `30U WV 55433 53954`: zone, square, and meters east and north in it; undefined if the map is not on the earth. */
export function mgrs(hello: Hello, spot: Spot): string | undefined {
  const point = degrees(hello, spot);
  return point === undefined ? undefined : mgrsOf(point);
}

/** The same of `[latitude, longitude]`; undefined near the poles. */
export function mgrsOf([latitude, longitude]: [number, number]): string | undefined {
  if (Math.abs(latitude) > 80) return undefined;
  const found = /^(\d+[A-Z])([A-Z]{2})(\d{5})(\d{5})$/.exec(forward([longitude, latitude]));
  return found?.slice(1).join(" ");
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
