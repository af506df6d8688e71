// Colors that can be ordered with color blindness: cividis, from dark blue to yellow.

type Rgb = readonly [number, number, number];

/** Cividis (Nunez, Anderton, Renslow 2018) at ten even steps. */
const CIVIDIS: readonly Rgb[] = [
  [0, 32, 77], [0, 51, 111], [57, 72, 107], [87, 92, 109], [112, 113, 115],
  [138, 135, 121], [166, 157, 117], [196, 181, 108], [228, 207, 91], [255, 234, 70],
];

/** The color at a share of the scale, 0 to 1. */
export function shade(share: number): Rgb {
  const at = Math.min(Math.max(share, 0), 1) * (CIVIDIS.length - 1);
  const low = Math.min(Math.floor(at), CIVIDIS.length - 2);
  const [from, to] = [CIVIDIS[low] ?? [0, 0, 0], CIVIDIS[low + 1] ?? [0, 0, 0]];
  const mix = (a: number, b: number) => Math.round(a + (b - a) * (at - low));
  return [mix(from[0], to[0]), mix(from[1], to[1]), mix(from[2], to[2])];
}

/** Log-odds beyond this are shown as this, nats; equal to that of `live/src/frame.rs`. */
export const MOST_NATS = 8;

/** The log-odds of a level from 1 to 255, nats. */
export function logOdds(level: number): number {
  return ((level - 1) / 254) * 2 * MOST_NATS - MOST_NATS;
}

/** The probability of a level from 1 to 255. */
export function probability(level: number): number {
  return 1 / (1 + Math.exp(-logOdds(level)));
}

export const UNSEARCHED: Rgb = [223, 227, 232];
export const BLOCKED: Rgb = [154, 161, 172];
export const OUT_OF_REACH: Rgb = [196, 186, 205];

/** Colors of robots' paths (Okabe and Ito 2008), repeating; robots are labeled with their numbers too. */
const ROBOTS = ["#d55e00", "#56b4e9", "#009e73", "#cc79a7", "#e69f00", "#0072b2"];

export function robotColor(robot: number): string {
  return ROBOTS[(robot - 1 + ROBOTS.length) % ROBOTS.length] ?? "#d55e00";
}
