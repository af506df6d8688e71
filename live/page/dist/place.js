import { keep, kept } from "./kept.js";
import { forward } from "./mgrs.js";
export function degrees(hello, [east, north]) {
    if (hello.earth === null)
        return undefined;
    const { corner, east: perEast, north: perNorth } = hello.earth;
    const along = (axis) => corner[axis] + hello.cell_meters * (east * perEast[axis] + north * perNorth[axis]);
    return [along(0), along(1)];
}
export function spotAt(hello, [latitude, longitude]) {
    if (hello.earth === null)
        return undefined;
    const { corner, east, north } = hello.earth;
    const [down, along] = [latitude - corner[0], longitude - corner[1]];
    const area = (east[0] * north[1] - east[1] * north[0]) * hello.cell_meters;
    return [(down * north[1] - along * north[0]) / area, (east[0] * along - east[1] * down) / area];
}
const KEPT = "notation";
const WAYS = { degrees: inDegrees, mgrs: mgrsOf, utm: utmOf };
let notation = first();
function first() {
    const chosen = kept(KEPT);
    return chosen === "mgrs" || chosen === "utm" ? chosen : "degrees";
}
export function noted() {
    return notation;
}
export function note(chosen) {
    notation = chosen;
    keep(KEPT, chosen);
}
export function coordinates(hello, spot) {
    const point = degrees(hello, spot);
    if (point !== undefined)
        return WAYS[notation](point) ?? inDegrees(point);
    const [east, north] = spot.map((cells) => Number((cells * hello.cell_meters).toFixed(1)));
    return `${east} m east, ${north} m north`;
}
export function otherwise(hello, spot) {
    const point = degrees(hello, spot);
    return point === undefined ? undefined : (notation === "degrees" ? mgrsOf(point) : inDegrees(point));
}
function inDegrees(point) {
    return point.map((number) => number.toFixed(5)).join(", ");
}
function square([latitude, longitude]) {
    if (Math.abs(latitude) > 80)
        return undefined;
    return /^(\d+[A-Z])([A-Z]{2})(\d{5})(\d{5})$/.exec(forward([longitude, latitude]))?.slice(1);
}
export function mgrsOf(point) {
    return square(point)?.join(" ");
}
const COLUMNS = ["ABCDEFGH", "JKLMNPQR", "STUVWXYZ"];
const ROWS = "ABCDEFGHJKLMNPQRSTUV";
const ROW_METERS = 100_000;
const CYCLE_METERS = ROWS.length * ROW_METERS;
const FALSE_NORTHING_METERS = 10_000_000;
const METERS_PER_DEGREE = 110_900;
export function utmOf(point) {
    const [zone = "", letters = "", east = "", north = ""] = square(point) ?? [];
    if (zone === "")
        return undefined;
    const number = Number.parseInt(zone, 10);
    const column = 1 + (COLUMNS[(number - 1) % 3] ?? "").indexOf(letters.charAt(0));
    const row = (ROWS.indexOf(letters.charAt(1)) + (number % 2 === 0 ? 15 : 0)) % ROWS.length;
    const about = METERS_PER_DEGREE * point[0] + (point[0] < 0 ? FALSE_NORTHING_METERS : 0);
    const northing = row * ROW_METERS + Number(north);
    const cycles = Math.round((about - northing) / CYCLE_METERS);
    return `${zone} ${column * ROW_METERS + Number(east)}E ${northing + cycles * CYCLE_METERS}N`;
}
export function within(mission, cell) {
    const meters = mission.position(cell)?.accuracy_meters;
    if (meters === undefined)
        return "";
    return ` within ${mission.hello.earth === null ? meters.toFixed(1) : Math.ceil(meters)} m`;
}
export function north(hello) {
    return hello.earth === null ? 0 : Math.atan2(hello.earth.east[0], hello.earth.north[0]);
}
export function distance(meters) {
    if (meters < 100)
        return `${meters.toFixed(1)} m`;
    return meters < 1000 ? `${meters.toFixed(0)} m` : `${(meters / 1000).toFixed(2)} km`;
}
