// The state of the mission on the page, from the messages of the server (`live/src/frame.rs`).

export interface Hello {
  kind: "hello";
  name: string;
  rows: number;
  columns: number;
  cell_meters: number;
  ground: string;
  detection_threshold: number;
  objects: number | null;
  earth: EarthFrame | null;
  areas: Area[];
  end: number | null;
  /** Times of a recording at which objects were declared, seconds. */
  finds: number[];
}

/** `[latitude, longitude]` of the south-western corner, and their change per meter east and north on the map. */
export interface EarthFrame {
  corner: [number, number];
  east: [number, number];
  north: [number, number];
}

/** Cells or meters east and north of the south-western corner. */
export type Spot = [number, number];

/** An area or a place drawn on the map, in meters. */
export interface Area {
  name: string;
  kind: "search" | "no_go" | "prior" | "last_known_position" | "linear_feature" | "start";
  polygons?: Spot[][][];
  lines?: Spot[][];
  at?: Spot;
  spread_meters?: number;
  quartiles_meters?: number[];
  poa?: number;
}

/** How many subjects there are, and how many are expected in declared cells and outside of the area. */
export interface SubjectFrame {
  number: number;
  found: number;
  rest_of_world: number;
}

export interface Frame {
  kind: "frame";
  is_whole: boolean;
  time: number;
  levels?: string;
  searched?: string;
  /** Cell, level, searched level. */
  changes?: [number, number, number][];
  out_of_reach?: string;
  /** Runs of cells in the operator's zones: first cell, number of cells, zone. Absent if nothing has changed. */
  zones?: [number, number, Zone][];
  marked?: MarkFrame[];
  /** Each segment, the whole search last. Absent if nothing has changed. */
  segments?: SegmentRow[];
  robots: RobotFrame[];
  declared: Declared[];
  dismissed: Dismissed[];
  /** Absent if nothing has changed. */
  orders?: OrderFrame[];
  pod: number;
  expected: number;
  /** Present if the number of subjects is known. */
  subject?: SubjectFrame;
  entropy: number;
  progress: number;
  messages: number;
  observations: number;
  marks: number;
  is_paused: boolean;
  is_called_back: boolean;
  /** The robots that are not back yet, if the mission is ending. */
  ending?: number[];
  added: number;
  curve?: Point[];
}

export type State = "awaited" | "lost" | "searching" | "paused" | "cleared" | "spent" | "stuck" | "waiting" | "returning" | "recalled" | "sent" | "holding" | "leaving" | "giving_way";

/** What the operator has made of a cell: 0 open, 1 skipped, 2 no-go. */
export type Zone = 0 | 1 | 2;

/** What the operator wants of a robot. */
export type RobotOrder = "resume" | "go" | "return" | "pause";

export interface RobotFrame {
  robot: number;
  state: State;
  order: RobotOrder;
  /** Whether several processes have its number. */
  is_doubled: boolean;
  /** For how long it has entered no cell although it drives, seconds, if that is longer than usual. */
  stands_for: number | null;
  cell: number | null;
  trail: number[];
  plan: number[];
  /** When it is expected in each of these, seconds of mission time; empty if that is unknown. */
  expected: number[];
  meters: number;
}

export interface Declared {
  cell: number;
  probability: number;
  since: number;
  robot: number | null;
  /** What the operator has decided; `dismissed` if it was declared again after that. */
  operator: "confirmed" | "dismissed" | null;
  position?: Position;
  picture?: Picture;
}

/** The position of a find, if a robot knows it better than by its cell. */
export interface Position {
  /** Meters east and north of the south-western corner. */
  meters: Spot;
  /** The largest distance of the object from there with a probability of 95 %. */
  accuracy_meters: number;
}

/** A find that the operator has dismissed. */
export interface Dismissed {
  cell: number;
  since: number;
  robot: number | null;
  position?: Position;
  picture?: Picture;
}

/** A robot's picture of a find. */
export interface Picture {
  /** Path of its file. */
  file: string;
  /** When it was taken, seconds. */
  time: number;
  robot: number;
  camera: string;
  /** The detector's class and score, in words; may be empty. */
  seen: string;
}

/** A mark of the operator that counts. */
export interface MarkFrame {
  /** A number that may be too long for a `number`. */
  id: string;
  time: number;
  note: string;
  /** Of a clue. */
  cell?: number;
  ratio?: number;
  radius_meters?: number;
  /** Of a search of others: runs `[first, count]`, and its probability of detection. */
  cells?: [number, number][];
  pod?: number;
}

/** How thoroughly a segment was searched. Values that are unknown, or have no meaning for it, are null. */
export interface SegmentRow {
  name: string;
  kind: string;
  cells: number;
  area_square_meters: number | null;
  poa: number;
  poa_now: number | null;
  pod: number;
  pos: number;
  sweep_width_meters: number | null;
  track_meters: number | null;
  effort_square_meters: number | null;
  /** Effort by area. */
  coverage: number | null;
}

/** A command of the operator, the robots that have it, and those of which that is not known. */
export interface OrderFrame {
  time: number;
  what: RobotOrder | "end" | "area" | "open" | "skip" | "no_go" | "searched" | "clue" | "withdraw" | "confirmed" | "dismissed" | "undone";
  /** The robot that it is for; null if it is for all. */
  robot: number | null;
  cell: number | null;
  cells: number;
  has: number[];
  waits: number[];
}

/** Seconds, entropy in nats, and recall or the number of objects declared. */
export type Point = [number, number, number];

export interface Over {
  kind: "over";
}

/** Nothing has changed. */
export interface Beat {
  kind: "beat";
  quiet_seconds: number;
}

export type Message = Hello | Frame | Over | Beat;

/** Number of cells of a robot's trail. */
const TRAIL_CELLS = 400;
/** Maximum number of points of a curve: more than there are pixels. */
const MOST_POINTS = 2000;

/** One mission, running or recorded. */
export class Mission {
  readonly hello: Hello;
  readonly isTraversable: Uint8Array;
  /** No-go cells. */
  readonly blocked: number[];
  /** The belief, one level per cell: 0 not searched, otherwise 1 to 255 over the log-odds. */
  levels: Uint8Array;
  /** How thoroughly each cell was searched: 0 never observed, otherwise 1 plus the probability of detection in percent. */
  searched: Uint8Array;
  /** Counts changes of the cells. */
  version = 0;
  /** 1 in searched cells that are out of reach of all robots. */
  isOutOfReach: Uint8Array;
  /** The operator's zones, by cell; cells that are open are absent. */
  zones = new Map<number, Zone>();
  frame: Frame | undefined;
  trails = new Map<number, number[]>();
  curve: Point[] = [];
  /** The operator's last commands, the newest first. */
  orders: OrderFrame[] = [];
  /** The operator's marks that count, in the order in which they were made. */
  marks: MarkFrame[] = [];
  segments: SegmentRow[] = [];
  isOver = false;

  constructor(hello: Hello) {
    this.hello = hello;
    this.isTraversable = bytes(hello.ground);
    this.blocked = [...this.isTraversable.keys()].filter((cell) => this.isTraversable[cell] !== 1);
    this.levels = new Uint8Array(hello.rows * hello.columns);
    this.searched = new Uint8Array(hello.rows * hello.columns);
    this.isOutOfReach = new Uint8Array(hello.rows * hello.columns);
  }

  take(frame: Frame): void {
    if (frame.is_whole) {
      this.trails.clear();
      this.curve = frame.curve ?? [];
    } else {
      this.curve.push([frame.time, frame.entropy, frame.progress]);
      if (this.curve.length > MOST_POINTS) this.curve = this.curve.filter((_, index) => index % 2 === 0);
    }
    this.takeCells(frame);
    for (const robot of frame.robots) {
      const trail = [...(this.trails.get(robot.robot) ?? []), ...robot.trail];
      this.trails.set(robot.robot, trail.slice(-TRAIL_CELLS));
    }
    this.orders = frame.orders ?? this.orders;
    this.marks = frame.marked ?? this.marks;
    this.segments = frame.segments ?? this.segments;
    if (frame.zones !== undefined) this.zones = zoned(frame.zones);
    this.frame = frame;
  }

  private takeCells(frame: Frame): void {
    const changes = frame.changes ?? [];
    if (frame.levels !== undefined) this.levels = bytes(frame.levels);
    if (frame.searched !== undefined) this.searched = bytes(frame.searched);
    if (frame.out_of_reach !== undefined) this.isOutOfReach = bytes(frame.out_of_reach);
    for (const [cell, level, searched] of changes) {
      this.levels[cell] = level;
      this.searched[cell] = searched;
    }
    if (frame.levels !== undefined || frame.out_of_reach !== undefined || changes.length > 0) this.version += 1;
  }

  /** The cell at a point, in cells east and north; undefined off the map. */
  cellAt([east, north]: Spot): number | undefined {
    const { rows, columns } = this.hello;
    const [row, column] = [Math.floor(north), Math.floor(east)];
    return row >= 0 && row < rows && column >= 0 && column < columns ? row * columns + column : undefined;
  }

  /** The middle of a cell, in cells east and north. */
  middle(cell: number): Spot {
    const [row, column] = this.place(cell);
    return [column + 0.5, row + 0.5];
  }

  /** The position of the find of a cell, if a robot knows it better than by the cell. */
  position(cell: number): Position | undefined {
    const { declared, dismissed } = this.frame ?? { declared: [], dismissed: [] };
    return [...declared, ...dismissed].find((find) => find.cell === cell)?.position;
  }

  /** Where the find of a cell is, in cells east and north: its position, or else the middle of the cell. */
  where(cell: number): Spot {
    const position = this.position(cell);
    if (position === undefined) return this.middle(cell);
    const [east, north] = position.meters;
    return [east / this.hello.cell_meters, north / this.hello.cell_meters];
  }

  /** `[row, column]` of a cell's number, from the south-west. */
  place(cell: number): [number, number] {
    return [Math.floor(cell / this.hello.columns), cell % this.hello.columns];
  }

  /** A cell in the notation of scenarios. */
  name(cell: number): string {
    const [row, column] = this.place(cell);
    return `[${row}, ${column}]`;
  }
}

function zoned(runs: [number, number, Zone][]): Map<number, Zone> {
  return new Map(runs.flatMap(([first, count, zone]) => Array.from({ length: count }, (_, index) => [first + index, zone] as const)));
}

function bytes(base64: string): Uint8Array {
  return Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
}

/** When a robot is expected at a place of its plan: `in 2:03`, or nothing if that is unknown. */
export function due(robot: RobotFrame, place: number, now: number): string {
  const seconds = robot.expected.at(place);
  return seconds === undefined ? "" : `in ${clock(Math.max(0, seconds - now))}`;
}

/** `1:02:03`, or `2:03` within the first hour. */
export function clock(seconds: number): string {
  const whole = Math.floor(seconds);
  const [hours, minutes, rest] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  const two = (number: number) => String(number).padStart(2, "0");
  return hours > 0 ? `${hours}:${two(minutes)}:${two(rest)}` : `${minutes}:${two(rest)}`;
}
