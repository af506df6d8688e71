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
