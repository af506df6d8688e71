export const KINDS = {
    search: "Search area",
    no_go: "No-go area",
    prior: "Likely region",
    last_known_position: "Last known position",
    linear_feature: "Linear feature",
    start: "Start",
};
export const OF_AREAS = ["search", "no_go", "prior"];
export const OF_LINES = ["no_go", "linear_feature"];
export const OF_PLACES = ["last_known_position", "start"];
export function isPlace(kind) {
    return OF_PLACES.includes(kind);
}
export function kindsOf(feature) {
    if (isPlace(kindOf(feature)))
        return OF_PLACES;
    const all = lines(feature.geometry);
    return all.length > 0 && all.every((line) => !line.isRing) ? OF_LINES : OF_AREAS;
}
export function kindOf(feature) {
    return feature.properties?.kind ?? "search";
}
export function feature(kind, corners, features) {
    const geometry = isPlace(kind)
        ? { type: "Point", coordinates: corners[0] ?? [] }
        : { type: "Polygon", coordinates: [closed(corners)] };
    const spread = kind === "last_known_position" ? { spread_meters: 200 } : {};
    return { type: "Feature", properties: { name: nextName(kind, features), kind, ...spread }, geometry };
}
function nextName(kind, features) {
    const names = new Set(features.map((it) => it.properties?.name));
    for (let number = 1;; number += 1) {
        const name = `${KINDS[kind]} ${number}`;
        if (!names.has(name))
            return name;
    }
}
export function closed(corners) {
    const [first, last] = [corners[0], corners.at(-1)];
    if (first === undefined || last === undefined)
        return [];
    return first[0] === last[0] && first[1] === last[1] ? corners : [...corners, first];
}
export function lines(geometry) {
    const of = (all, isRing) => all.map((corners) => ({ corners, isRing }));
    switch (geometry?.type) {
        case "Polygon": return of(geometry.coordinates, true);
        case "MultiPolygon": return of(geometry.coordinates.flat(), true);
        case "LineString": return of([geometry.coordinates], false);
        case "MultiLineString": return of(geometry.coordinates, false);
        case "GeometryCollection": return geometry.geometries.flatMap(lines);
        default: return [];
    }
}
export function moveCorner({ corners, isRing }, index, to) {
    corners[index] = to;
    if (isRing && index === 0)
        corners[corners.length - 1] = to;
}
export function removeCorner({ corners, isRing }, index) {
    if (corners.length <= (isRing ? 4 : 2))
        return;
    corners.splice(index, 1);
    const first = corners[0];
    if (isRing && index === 0 && first !== undefined)
        corners[corners.length - 1] = first;
}
export function groundOf(squareMeters) {
    if (squareMeters < 1e4)
        return `${squareMeters.toFixed(0)} m²`;
    return squareMeters < 1e6 ? `${(squareMeters / 1e4).toFixed(2)} ha` : `${(squareMeters / 1e6).toFixed(2)} km²`;
}
export function written([longitude = NaN, latitude = NaN]) {
    return `${latitude.toFixed(5)}, ${longitude.toFixed(5)}`;
}
export function parsePosition(text) {
    const allowed = "allowed is a latitude and a longitude such as 49.236, -2.24 or 49°14'10\"N 2°14'24\"W";
    const parts = halves(text.trim().toUpperCase());
    const [latitude, longitude] = [angle(parts?.[0], "NS"), angle(parts?.[1], "EW")];
    if (latitude === undefined || longitude === undefined)
        return `“${text.trim()}” is no position; ${allowed}.`;
    if (Math.abs(latitude) > 85)
        return `A latitude of ${latitude} is not possible; allowed is -85 to 85.`;
    if (Math.abs(longitude) > 180)
        return `A longitude of ${longitude} is not possible; allowed is -180 to 180.`;
    return [longitude, latitude];
}
function halves(text) {
    const found = /^([^,;]+)[,;]([^,;]+)$/.exec(text) ?? /^(.*[NS])\s*(.+)$/.exec(text) ?? /^(\S+)\s+(\S+)$/.exec(text);
    return found === null ? undefined : [found[1] ?? "", found[2] ?? ""];
}
function angle(text, letters) {
    const found = /^(?<sign>[-−+]?)(?<numbers>[\d.]+(?:[\s°'′"″]+[\d.]+){0,2})[\s°'′"″]*(?<letter>[NSEW]?)$/.exec(text?.trim() ?? "");
    const { sign = "", numbers = "", letter = "" } = found?.groups ?? {};
    if (found === null || (letter !== "" && (!letters.includes(letter) || sign !== "")))
        return undefined;
    const [degrees = NaN, minutes = 0, seconds = 0] = numbers.split(/[\s°'′"″]+/).map(Number);
    if (!(minutes < 60 && seconds < 60))
        return undefined;
    const value = degrees + minutes / 60 + seconds / 3600;
    return Number.isFinite(value) ? (/[-−]/.test(sign) || letter === "S" || letter === "W" ? -value : value) : undefined;
}
export const FEW_CORNERS = "An area has at least three corners.";
export function parseCorners(text, isRing) {
    const positions = [];
    for (const [index, line] of text.split("\n").entries()) {
        if (line.trim() === "")
            continue;
        const position = parsePosition(line);
        if (typeof position === "string")
            return `Line ${index + 1}: ${position}`;
        positions.push(position);
    }
    if (isRing && positions.length < 3)
        return FEW_CORNERS;
    return positions.length < 2 ? "A line has at least two corners." : positions;
}
