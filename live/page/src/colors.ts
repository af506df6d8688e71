// Colors of the map and of robots. Those of a layer can be ordered with color blindness.

export type Rgb = readonly [number, number, number];

/** Viridis (van der Walt and Smith 2015) at ten even steps, from dark violet to yellow: no gray, which no-go ground has. */
const VIRIDIS: readonly Rgb[] = [
  [68, 1, 84], [72, 40, 120], [62, 73, 137], [49, 104, 142], [38, 130, 142],
  [31, 158, 137], [53, 183, 121], [110, 206, 88], [181, 222, 43], [253, 231, 37],
];

/** The color at a share of the scale, 0 to 1. */
export function shade(share: number): Rgb {
  const at = Math.min(Math.max(share, 0), 1) * (VIRIDIS.length - 1);
  const low = Math.min(Math.floor(at), VIRIDIS.length - 2);
  return mix(VIRIDIS[low] ?? [0, 0, 0], VIRIDIS[low + 1] ?? [0, 0, 0], at - low);
}

/** A color between two; `share` is that of the second. */
export function mix(from: Rgb, to: Rgb, share: number): Rgb {
  const between = (a: number, b: number) => Math.round(a + (b - a) * share);
  return [between(from[0], to[0]), between(from[1], to[1]), between(from[2], to[2])];
}

/** Log-odds beyond these are shown as these, nats; equal to those of `live/src/frame.rs`. */
const LEAST_NATS = -14;
const MOST_NATS = 6;

/** The color of a level from 1 to 255. */
export function probabilityColor(level: number): Rgb {
  return shade((level - 1) / 254);
}

/** The place of a probability on the scale, 0 to 1. */
export function placeOnScale(probability: number): number {
  return (Math.log(probability / (1 - probability)) - LEAST_NATS) / (MOST_NATS - LEAST_NATS);
}

/** The probability of a level from 1 to 255. */
export function probability(level: number): number {
  return 1 / (1 + Math.exp(-LEAST_NATS - ((level - 1) / 254) * (MOST_NATS - LEAST_NATS)));
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
