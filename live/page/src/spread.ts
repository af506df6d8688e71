// Places for the markers of robots that are too close to each other to be told apart.

/** Turn from one place to the next, radians: the golden angle, which leaves no gaps. */
const GOLDEN = Math.PI * (3 - Math.sqrt(5));
/** Most places that are tried for one marker. */
const TRIES = 200;

type Point = [number, number];

/**
 * For each point a place where a circle of this diameter overlaps no other: the point itself if it is free, otherwise
 * the next free one on a spiral around it. Earlier points have precedence, so that a marker does not jump when a later
 * robot passes. Pixels.
 */
export function spread(points: Point[], diameter: number): Point[] {
  const placed: Point[] = [];
  const isFree = ([x, y]: Point) => placed.every((other) => Math.hypot(other[0] - x, other[1] - y) >= diameter);
  for (const point of points) placed.push(free(point, diameter, isFree));
  return placed;
}

function free([x, y]: Point, diameter: number, isFree: (point: Point) => boolean): Point {
  for (let place = 0; place < TRIES; place += 1) {
    const away = 0.55 * diameter * Math.sqrt(place);
    const point: Point = [x + away * Math.cos(place * GOLDEN), y + away * Math.sin(place * GOLDEN)];
    if (isFree(point)) return point;
  }
  return [x, y];
}
