// Requests to the server of the planning page (`live/src/planning.rs`).

/** A `GeoJSON` feature of the plan, by the convention of map files. */
export interface Feature {
  type: "Feature";
  properties: Properties | null;
  geometry: Geometry | null;
}

export interface Properties {
  name?: string;
  kind?: Kind;
  poa?: number;
  spread_meters?: number;
  /** Distances within which 25, 50, 75 and 95 % are found. */
  quartiles_meters?: number[];
}

export type Kind = "search" | "no_go" | "prior" | "last_known_position" | "linear_feature" | "start";

/** Longitude and latitude, degrees. */
export type Position = number[];

export type Geometry =
  | { type: "Point"; coordinates: Position }
  | { type: "Polygon"; coordinates: Position[][] }
  | { type: "MultiPolygon"; coordinates: Position[][][] }
  | { type: "LineString"; coordinates: Position[] }
  | { type: "MultiLineString"; coordinates: Position[][] }
  | { type: "GeometryCollection"; geometries: Geometry[] };

/** The plan; its settings are those of a scenario file, of which the page changes these. */
export interface Plan {
  scenario: {
    name: string;
    map: { cell_meters: number };
    sensor: { radius: number; noise_variance: number };
    objects: { count?: number };
    /** Given if exactly one is missing. */
    prior: { rest_of_world?: number };
    robots: { count: number; start?: unknown };
    mission: { speed_meters_per_second: number; budget_seconds?: number; budget_meters?: number; stop_when_expected_remaining: number };
  };
  is_cell_suggested: boolean;
  features: Feature[];
}

export type Place = { feature: number } | { key: string } | "map";

export interface Problem {
  at: Place;
  message: string;
}

export interface Review {
  problems: Problem[];
  warnings: string[];
  size: { rows: number; columns: number; searched: number; traversable: number; searched_square_meters: number } | null;
  suggested_cell_meters: number | null;
  effects: { name: string | null; kind: Kind; cells: number; poa: number | null }[];
  starts: ([number, number] | null)[];
  /** Searched ground that no robot sees: south, west, north and east, degrees. */
  unseen: [number, number, number, number][];
}

/** One team of a forecast, as `dragnet forecast --json` tells it. */
export interface Team {
  robots: number;
  missions: number;
  budget_seconds: number;
  on_map: number;
  success: { mean: number; low: number; high: number };
  seconds_to: (number | null)[];
  curve: [number, number][];
}

export type Forecast =
  | { revision: number; state: "running"; progress: [number, number]; minutes_left: number | null }
  | { revision: number; state: "done"; teams: Team[] }
  | { revision: number; state: "failed"; why: string };

export interface State {
  revision: number;
  plan: Plan;
  review: Review;
  saved: { scenario: string; areas: string; is_current: boolean } | null;
  folder: string;
  forecast: Forecast | null;
  message?: string;
}

export interface News {
  revision: number;
  forecast: Forecast | null;
}

/** An answer that is not what was asked for. */
export class Refusal extends Error {
  constructor(
    readonly status: number,
    message: string,
    /** Files that would be overwritten. */
    readonly existing: string[],
  ) {
    super(message);
  }
}

export class Api {
  readonly token = new URLSearchParams(location.hash.slice(1)).get("token");

  /** Whether the token in the address allows changes. */
  async mayChange(): Promise<boolean> {
    if (this.token === null) return false;
    const answer = await fetch("auth", { headers: this.headers() }).catch(() => undefined);
    return answer?.ok === true;
  }

  state(): Promise<State> {
    return this.answer(fetch("plan/state"));
  }

  news(): Promise<News> {
    return this.answer(fetch("plan/news"));
  }

  post<T>(what: string, body: unknown): Promise<T> {
    return this.answer(fetch(`plan/${what}`, { method: "POST", headers: this.headers(), body: JSON.stringify(body) }));
  }

  private headers(): Record<string, string> {
    return { Authorization: `Bearer ${this.token ?? ""}` };
  }

  private async answer<T>(asked: Promise<Response>): Promise<T> {
    const answer = await asked.catch(() => undefined);
    if (answer === undefined) throw new Refusal(0, "The program that serves this page does not answer. Is it still running?", []);
    if (answer.ok) return (await answer.json()) as T;
    const refused = (await answer.json().catch(() => ({}))) as { error?: string; existing?: string[] };
    throw new Refusal(answer.status, refused.error ?? `the server answers ${answer.status}`, refused.existing ?? []);
  }
}
