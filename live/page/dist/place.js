import { forward } from "./mgrs.js";
export function degrees(hello, [east, north]) {
    if (hello.earth === null)
        return undefined;
    const { corner, east: perEast, north: perNorth } = hello.earth;
    const along = (axis) => corner[axis] + hello.cell_meters * (east * perEast[axis] + north * perNorth[axis]);
    return [along(0), along(1)];
}
export function coordinates(hello, spot) {
    const point = degrees(hello, spot);
    if (point !== undefined)
        return point.map((number) => number.toFixed(5)).join(", ");
    const [east, north] = spot.map((cells) => Number((cells * hello.cell_meters).toFixed(1)));
    return `${east} m east, ${north} m north`;
}
export function mgrs(hello, spot) {
    const point = degrees(hello, spot);
    return point === undefined ? undefined : mgrsOf(point);
}
export function mgrsOf([latitude, longitude]) {
    if (Math.abs(latitude) > 80)
        return undefined;
    const found = /^(\d+[A-Z])([A-Z]{2})(\d{5})(\d{5})$/.exec(forward([longitude, latitude]));
    return found?.slice(1).join(" ");
}
export function north(hello) {
    return hello.earth === null ? 0 : Math.atan2(hello.earth.east[0], hello.earth.north[0]);
}
export function distance(meters) {
    if (meters < 100)
        return `${meters.toFixed(1)} m`;
    return meters < 1000 ? `${meters.toFixed(0)} m` : `${(meters / 1000).toFixed(2)} km`;
}
