const GOLDEN = Math.PI * (3 - Math.sqrt(5));
const TRIES = 200;
export function spread(points, diameter) {
    const placed = [];
    const isFree = ([x, y]) => placed.every((other) => Math.hypot(other[0] - x, other[1] - y) >= diameter);
    for (const point of points)
        placed.push(free(point, diameter, isFree));
    return placed;
}
function free([x, y], diameter, isFree) {
    for (let place = 0; place < TRIES; place += 1) {
        const away = 0.55 * diameter * Math.sqrt(place);
        const point = [x + away * Math.cos(place * GOLDEN), y + away * Math.sin(place * GOLDEN)];
        if (isFree(point))
            return point;
    }
    return [x, y];
}
