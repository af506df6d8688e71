const VIRIDIS = [
    [68, 1, 84], [72, 40, 120], [62, 73, 137], [49, 104, 142], [38, 130, 142],
    [31, 158, 137], [53, 183, 121], [110, 206, 88], [181, 222, 43], [253, 231, 37],
];
export function shade(share) {
    const at = Math.min(Math.max(share, 0), 1) * (VIRIDIS.length - 1);
    const low = Math.min(Math.floor(at), VIRIDIS.length - 2);
    return mix(VIRIDIS[low] ?? [0, 0, 0], VIRIDIS[low + 1] ?? [0, 0, 0], at - low);
}
export function mix(from, to, share) {
    const between = (a, b) => Math.round(a + (b - a) * share);
    return [between(from[0], to[0]), between(from[1], to[1]), between(from[2], to[2])];
}
const LEAST_NATS = -14;
const MOST_NATS = 6;
export function probabilityColor(level) {
    return shade((level - 1) / 254);
}
export function placeOnScale(probability) {
    return (Math.log(probability / (1 - probability)) - LEAST_NATS) / (MOST_NATS - LEAST_NATS);
}
export function probability(level) {
    return 1 / (1 + Math.exp(-LEAST_NATS - ((level - 1) / 254) * (MOST_NATS - LEAST_NATS)));
}
export const NEVER = [240, 138, 56];
export const BANDS = [
    { from: 0, color: [190, 222, 247] },
    { from: 10, color: [130, 187, 232] },
    { from: 50, color: [68, 141, 205] },
    { from: 80, color: [28, 92, 160] },
    { from: 95, color: [8, 48, 98] },
];
export function searchedColor(level) {
    if (level === 0)
        return NEVER;
    return BANDS.findLast((band) => level - 1 >= band.from)?.color ?? NEVER;
}
export function plainColors() {
    return matchMedia("(prefers-color-scheme: dark)").matches
        ? { unsearched: [46, 53, 63], blocked: [100, 107, 118], outOfReach: [122, 106, 138] }
        : { unsearched: [223, 225, 226], blocked: [154, 161, 172], outOfReach: [196, 186, 205] };
}
export function css(color) {
    return `rgb(${color.join(" ")})`;
}
const ROBOTS = ["#d55e00", "#56b4e9", "#009e73", "#cc79a7", "#e69f00", "#0072b2"];
const GOLDEN_DEGREES = 137.508;
export function robotColor(robot) {
    const known = ROBOTS[robot - 1];
    if (known !== undefined)
        return known;
    const hue = ((robot * GOLDEN_DEGREES) % 360).toFixed(0);
    return `hsl(${hue} ${robot % 2 === 0 ? 85 : 60}% ${[38, 52, 45][robot % 3] ?? 45}%)`;
}
