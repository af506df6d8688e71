// Colors of the map and of robots. Those of a layer can be ordered with color blindness.

export type Rgb = readonly [number, number, number];

/** Cividis (Nunez, Anderton, Renslow 2018) at ten even steps, from dark blue to yellow. */
const CIVIDIS: readonly Rgb[] = [
  [0, 32, 77], [0, 51, 111], [57, 72, 107], [87, 92, 109], [112, 113, 115],
  [138, 135, 121], [166, 157, 117], [196, 181, 108], [228, 207, 91], [255, 234, 70],
];

/** The color at a share of the scale, 0 to 1. */
export function shade(share: number): Rgb {
  const at = Math.min(Math.max(share, 0), 1) * (CIVIDIS.length - 1);
  const low = Math.min(Math.floor(at), CIVIDIS.length - 2);
  return mix(CIVIDIS[low] ?? [0, 0, 0], CIVIDIS[low + 1] ?? [0, 0, 0], at - low);
}

/** A color between two; `share` is that of the second. */
export function mix(from: Rgb, to: Rgb, share: number): Rgb {
  const between = (a: number, b: number) => Math.round(a + (b - a) * share);
  return [between(from[0], to[0]), between(from[1], to[1]), between(from[2], to[2])];
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

/** Cells that were never looked at: the only warm color of the searched layer. */
export const NEVER: Rgb = [240, 138, 56];

/** Bands of the probability of detection, with their lower bounds in percent as `dragnet export` draws them. */
export const BANDS: readonly { from: number; color: Rgb }[] = [
  { from: 0, color: [190, 222, 247] },
  { from: 10, color: [130, 187, 232] },
  { from: 50, color: [68, 141, 205] },
  { from: 80, color: [28, 92, 160] },
  { from: 95, color: [8, 48, 98] },
];

/** The color of a searched level: 0 if never looked at, otherwise 1 plus percent. */
export function searchedColor(level: number): Rgb {
  if (level === 0) return NEVER;
  return BANDS.findLast((band) => level - 1 >= band.from)?.color ?? NEVER;
}

/** Colors of cells without a value. */
export interface Plain {
  unsearched: Rgb;
  blocked: Rgb;
  outOfReach: Rgb;
}

export function plainColors(): Plain {
  return matchMedia("(prefers-color-scheme: dark)").matches
    ? { unsearched: [46, 53, 63], blocked: [100, 107, 118], outOfReach: [122, 106, 138] }
    : { unsearched: [223, 225, 226], blocked: [154, 161, 172], outOfReach: [196, 186, 205] };
}

export function css(color: Rgb): string {
  return `rgb(${color.join(" ")})`;
}

/** Colors of the first robots (Okabe and Ito 2008). */
const ROBOTS = ["#d55e00", "#56b4e9", "#009e73", "#cc79a7", "#e69f00", "#0072b2"];
/** Turn of the hue from one robot to the next, degrees: no two of hundreds have the same. */
const GOLDEN_DEGREES = 137.508;

/** A color of its own for each robot. */
export function robotColor(robot: number): string {
  const known = ROBOTS[robot - 1];
  if (known !== undefined) return known;
  const hue = ((robot * GOLDEN_DEGREES) % 360).toFixed(0);
  return `hsl(${hue} ${robot % 2 === 0 ? 85 : 60}% ${[38, 52, 45][robot % 3] ?? 45}%)`;
}
