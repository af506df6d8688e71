const CIVIDIS = [
    [0, 32, 77], [0, 51, 111], [57, 72, 107], [87, 92, 109], [112, 113, 115],
    [138, 135, 121], [166, 157, 117], [196, 181, 108], [228, 207, 91], [255, 234, 70],
];
export function shade(share) {
    const at = Math.min(Math.max(share, 0), 1) * (CIVIDIS.length - 1);
    const low = Math.min(Math.floor(at), CIVIDIS.length - 2);
    const [from, to] = [CIVIDIS[low] ?? [0, 0, 0], CIVIDIS[low + 1] ?? [0, 0, 0]];
    const mix = (a, b) => Math.round(a + (b - a) * (at - low));
    return [mix(from[0], to[0]), mix(from[1], to[1]), mix(from[2], to[2])];
}
export const MOST_NATS = 8;
export function logOdds(level) {
    return ((level - 1) / 254) * 2 * MOST_NATS - MOST_NATS;
}
export function probability(level) {
    return 1 / (1 + Math.exp(-logOdds(level)));
}
export const UNSEARCHED = [223, 227, 232];
export const BLOCKED = [154, 161, 172];
export const OUT_OF_REACH = [196, 186, 205];
const ROBOTS = ["#d55e00", "#56b4e9", "#009e73", "#cc79a7", "#e69f00", "#0072b2"];
export function robotColor(robot) {
    return ROBOTS[(robot - 1 + ROBOTS.length) % ROBOTS.length] ?? "#d55e00";
}
