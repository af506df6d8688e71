// The settings of the plan, each with what is wrong with it.

import { element } from "../panel.js";
import type { Plan, State } from "./api.js";

/** A field of the page, and the setting that it shows. */
interface Field {
  /** The setting's key in scenarios, at which problems stand. */
  key: string;
  get(plan: Plan): string;
  set(plan: Plan, value: string): void;
}

/** Sensors to begin with: assumptions, which a measured sensor replaces. Radius in cells, variance of a reading at one cell. */
const SENSORS: Record<string, { radius: number; noise_variance: number }> = {
  standard: { radius: 5, noise_variance: 0.005 },
  clear: { radius: 8, noise_variance: 0.002 },
  poor: { radius: 3, noise_variance: 0.02 },
};

const number = (value: string) => Number(value.trim().replace(",", ".") || NaN);
const plain = (value: number | undefined, factor = 1) => (value === undefined ? "" : String(Number((value * factor).toFixed(6))));
/** Nothing, or a number in another unit. */
const scaled = (value: string, factor: number) => (value.trim() === "" ? undefined : Number((number(value) * factor).toFixed(6)));

const FIELDS: Record<string, Field> = {
  "field-name": { key: "name", get: ({ scenario }) => scenario.name, set: ({ scenario }, value) => (scenario.name = value.trim()) },
  "field-objects": {
    key: "objects.count", get: ({ scenario }) => plain(scenario.objects.count), set: ({ scenario }, value) => (scenario.objects.count = number(value)),
  },
  "field-robots": {
    key: "robots.count", get: ({ scenario }) => plain(scenario.robots.count), set: ({ scenario }, value) => (scenario.robots.count = number(value)),
  },
  "field-start": {
    key: "robots.start",
    get: ({ scenario }) => (typeof scenario.robots.start === "string" ? scenario.robots.start : ""),
    set: ({ scenario }, value) => {
      if (value === "") delete scenario.robots.start;
      else scenario.robots.start = value;
    },
  },
  "field-speed": {
    key: "mission.speed_meters_per_second", get: ({ scenario }) => plain(scenario.mission.speed_meters_per_second),
    set: ({ scenario }, value) => (scenario.mission.speed_meters_per_second = number(value)),
  },
  "field-hours": {
    key: "mission.budget_seconds", get: ({ scenario }) => plain(scenario.mission.budget_seconds, 1 / 3600),
    set: ({ scenario }, value) => put(scenario.mission, "budget_seconds", scaled(value, 3600)),
  },
  "field-kilometers": {
    key: "mission.budget_meters", get: ({ scenario }) => plain(scenario.mission.budget_meters, 1 / 1000),
    set: ({ scenario }, value) => put(scenario.mission, "budget_meters", scaled(value, 1000)),
  },
  "field-cell": {
    key: "map.cell_meters", get: ({ scenario }) => plain(scenario.map.cell_meters),
    set: (plan, value) => {
      plan.scenario.map.cell_meters = number(value);
      plan.is_cell_suggested = false;
    },
  },
  "field-sensor": {
    key: "", get: ({ scenario }) => preset(scenario.sensor),
    set: ({ scenario }, value) => (scenario.sensor = { ...scenario.sensor, ...SENSORS[value] }),
  },
  "field-radius": {
    key: "sensor.radius", get: ({ scenario }) => plain(scenario.sensor.radius), set: ({ scenario }, value) => (scenario.sensor.radius = number(value)),
  },
  "field-variance": {
    key: "sensor.noise_variance", get: ({ scenario }) => plain(scenario.sensor.noise_variance),
    set: ({ scenario }, value) => (scenario.sensor.noise_variance = number(value)),
  },
};

export class Fields {
  constructor(private readonly change: (act: (plan: Plan) => void) => void) {
    for (const [id, field] of Object.entries(FIELDS)) {
      control(id).addEventListener("change", () => change((plan) => field.set(plan, control(id).value)));
    }
    element("suggested", HTMLInputElement).addEventListener("change", (event) => {
      const isSuggested = (event.target as HTMLInputElement).checked;
      this.change((plan) => (plan.is_cell_suggested = isSuggested));
    });
  }

  draw(state: State, mayChange: boolean): void {
    const { plan, review } = state;
    element("settings", HTMLFieldSetElement).disabled = !mayChange;
    for (const [id, { key, get }] of Object.entries(FIELDS)) {
      const field = control(id);
      // A value that is being typed stays.
      if (document.activeElement !== field || field.value === "") field.value = get(plan);
      const problem = review.problems.find(({ at }) => typeof at === "object" && "key" in at && key !== "" && (at.key === key || at.key.startsWith(`${key}[`)));
      const said = element(`${id}-problem`, HTMLElement);
      said.textContent = problem?.message ?? "";
      said.hidden = problem === undefined;
      field.setAttribute("aria-invalid", String(problem !== undefined));
    }
    element("suggested", HTMLInputElement).checked = plan.is_cell_suggested;
    const { cell_meters } = plan.scenario.map;
    const suggested = review.suggested_cell_meters;
    element("cell-note", HTMLElement).textContent = suggested === null || suggested === cell_meters ? "" : `Suggested for this area: ${suggested} m.`;
    const reach = plan.scenario.sensor.radius * cell_meters;
    element("radius-note", HTMLElement).textContent = Number.isFinite(reach) ? `That is ${Number(reach.toFixed(1))} m.` : "";
  }
}

function control(id: string): HTMLInputElement | HTMLSelectElement {
  const found = document.getElementById(id);
  if (found instanceof HTMLInputElement || found instanceof HTMLSelectElement) return found;
  throw new Error(`the page has no ${id}`);
}

function put<K extends string>(table: { [key in K]?: number }, key: K, value: number | undefined): void {
  if (value === undefined) delete table[key];
  else table[key] = value;
}

/** The name of a preset; none of a sensor of its own. */
function preset(sensor: { radius: number; noise_variance: number }): string {
  const is = ([, { radius, noise_variance }]: [string, { radius: number; noise_variance: number }]) =>
    radius === sensor.radius && noise_variance === sensor.noise_variance;
  return Object.entries(SENSORS).find(is)?.[0] ?? "own";
}
