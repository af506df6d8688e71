// The settings of the plan, each with what is wrong with it.

import { element } from "../panel.js";
import type { Place, Plan, State } from "./api.js";
import { type Allowed, type Entries, parseNumber } from "./entries.js";
import { sentence } from "./store.js";

/** A field of the page, and the setting that it shows. */
interface Field {
  /** The keys in scenarios whose problems stand below it. */
  keys: string[];
  /** For numbers. */
  allowed?: Allowed;
  get(plan: Plan): string;
  set(plan: Plan, value: string | number | undefined): void;
}

/** Sensors to begin with: assumptions, which a measured sensor replaces. Radius in cells, variance of a reading at one cell. */
const SENSORS: Record<string, { radius: number; noise_variance: number }> = {
  standard: { radius: 5, noise_variance: 0.005 },
  clear: { radius: 8, noise_variance: 0.002 },
  poor: { radius: 3, noise_variance: 0.02 },
};

/** What a scenario allows at most: 1e9 seconds and 1e9 meters. */
const MOST_HOURS = 277_777;
const MOST_KILOMETERS = 1_000_000;
/** The most whose number may be known for certain. */
const MOST_SUBJECTS = 100;

const rounded = (value: number) => Number(value.toFixed(6));

/** A number of the scenario, `table.name`; the page shows it divided by the unit. */
function numeric(key: string, allowed: Allowed = {}, unit = 1): Field {
  const [table = "", name = ""] = key.split(".");
  const values = ({ scenario }: Plan) => (scenario as unknown as Record<string, Record<string, number | undefined>>)[table] ?? {};
  return {
    keys: [key], allowed,
    get: (plan) => {
      const value = values(plan)[name];
      return value === undefined ? "" : String(rounded(value / unit));
    },
    set: (plan, value) => {
      if (value === undefined) delete values(plan)[name];
      else values(plan)[name] = rounded(Number(value) * unit);
    },
  };
}

const cell = numeric("map.cell_meters");
const objects = numeric("objects.count", { isWhole: true });
const elsewhere = numeric("prior.rest_of_world", { isOptional: true, least: 0, most: 99.99, unit: "%" }, 0.01);
const hours = numeric("mission.budget_seconds", { isOptional: true, above: 0, most: MOST_HOURS, unit: "hours" }, 3600);

const FIELDS: Record<string, Field> = {
  "field-name": { keys: ["name"], get: ({ scenario }) => scenario.name, set: ({ scenario }, value) => (scenario.name = String(value).trim()) },
  "field-objects": {
    ...objects, keys: [...objects.keys, "objects"],
    set: (plan, value) => {
      objects.set(plan, value);
      // Of one it is certain that there are no more; of several the number may be a guess.
      if (value === 1) plan.scenario.prior.rest_of_world ??= 0;
      else if (!isKnown(plan)) delete plan.scenario.prior.rest_of_world;
    },
  },
  "field-elsewhere": elsewhere,
  // That a mission has no budget at all is a problem of its table.
  "field-hours": { ...hours, keys: [...hours.keys, "mission"] },
  "field-kilometers": numeric("mission.budget_meters", { isOptional: true, above: 0, most: MOST_KILOMETERS, unit: "km" }, 1000),
  "field-remaining": numeric("mission.stop_when_expected_remaining"),
  "field-robots": numeric("robots.count", { isWhole: true }),
  "field-start": {
    keys: ["robots.start"],
    get: ({ scenario }) => (typeof scenario.robots.start === "string" ? scenario.robots.start : ""),
    set: ({ scenario }, value) => {
      if (value === "") delete scenario.robots.start;
      else scenario.robots.start = value;
    },
  },
  "field-speed": numeric("mission.speed_meters_per_second"),
  "field-sensor": {
    keys: ["sensor"], get: ({ scenario }) => preset(scenario.sensor),
    set: ({ scenario }, value) => (scenario.sensor = { ...scenario.sensor, ...SENSORS[String(value)] }),
  },
  "field-radius": numeric("sensor.radius", { isWhole: true }),
  "field-variance": numeric("sensor.noise_variance"),
  "field-cell": {
    ...cell,
    set: (plan, value) => {
      cell.set(plan, value);
      plan.is_cell_suggested = false;
    },
  },
};

/** Whether a problem is of this field: of a key of it, or of a part of its value. */
function isOf(at: Place, { keys }: Field): boolean {
  return typeof at === "object" && "key" in at && keys.some((key) => at.key === key || at.key.startsWith(`${key}[`));
}

/** Whether a problem stands at an area or below a field; what has no such place concerns the plan as a whole. */
export function hasPlace(at: Place): boolean {
  return typeof at === "object" && ("feature" in at || Object.values(FIELDS).some((field) => isOf(at, field)));
}

export class Fields {
  private plan: Plan | undefined;

  constructor(private readonly entries: Entries, private readonly change: (act: (plan: Plan) => void) => void) {
    for (const [id, field] of Object.entries(FIELDS)) control(id).addEventListener("change", () => this.enter(id, field));
    element("suggested", HTMLInputElement).addEventListener("change", (event) => {
      const isSuggested = (event.target as HTMLInputElement).checked;
      this.change((plan) => (plan.is_cell_suggested = isSuggested));
    });
  }

  private enter(id: string, { keys: [key = ""], allowed, get, set }: Field): void {
    const { value: text } = control(id);
    if (allowed === undefined) this.change((plan) => set(plan, text));
    else this.entries.take(id, { key }, this.plan, get, text, parseNumber(text, allowed), (value) => this.change((plan) => set(plan, value)));
  }

  draw({ plan, review }: State, mayChange: boolean): void {
    this.plan = plan;
    element("settings", HTMLFieldSetElement).disabled = !mayChange;
    for (const [id, it] of Object.entries(FIELDS)) {
      const field = control(id);
      // A value that is being typed stays.
      if (document.activeElement !== field || field.value === "") field.value = this.entries.text(id) ?? it.get(plan);
      const problem = review.problems.find(({ at }) => isOf(at, it));
      const said = element(`${id}-problem`, HTMLElement);
      said.textContent = problem === undefined ? "" : sentence(problem.message);
      said.hidden = problem === undefined;
      field.setAttribute("aria-invalid", String(problem !== undefined));
      if (problem !== undefined) field.closest("details")?.setAttribute("open", "");
    }
    element("field-elsewhere", HTMLInputElement).disabled = !isKnown(plan);
    element("suggested", HTMLInputElement).checked = plan.is_cell_suggested;
    const { map: { cell_meters }, sensor: { radius } } = plan.scenario;
    const { objects: { count }, mission: { stop_when_expected_remaining: remaining } } = plan.scenario;
    element("remaining-note", HTMLElement).textContent = describeEnd(remaining, count);
    const suggested = review.suggested_cell_meters;
    element("cell-note", HTMLElement).textContent = suggested === null || suggested === cell_meters ? "" : `Suggested for this area: ${suggested} m.`;
    element("sensor-note", HTMLElement).textContent =
      `Sees ${Number((radius * cell_meters).toFixed(1))} m: ${radius} ${radius === 1 ? "cell" : "cells"} of ${rounded(cell_meters)} m.`;
  }
}

/** Whether the number of the missing may be known for certain. */
function isKnown({ scenario: { objects: { count } } }: Plan): boolean {
  return count !== undefined && count >= 1 && count <= MOST_SUBJECTS;
}

/** What the end of the search means for the missing. */
function describeEnd(remaining: number, count: number | undefined): string {
  if (remaining === 0) return "No cell may be in doubt then: this takes long.";
  if (count === undefined || !(remaining < count)) return "";
  return `Of all missing ${rounded(Number((100 * (1 - remaining / count)).toFixed(1)))} % are expected to be found then.`;
}

function control(id: string): HTMLInputElement | HTMLSelectElement {
  const found = document.getElementById(id);
  if (found instanceof HTMLInputElement || found instanceof HTMLSelectElement) return found;
  throw new Error(`the page has no ${id}`);
}

/** The name of a preset; none of a sensor of its own. */
function preset(sensor: { radius: number; noise_variance: number }): string {
  const is = ([, { radius, noise_variance }]: [string, { radius: number; noise_variance: number }]) =>
    radius === sensor.radius && noise_variance === sensor.noise_variance;
  return Object.entries(SENSORS).find(is)?.[0] ?? "own";
}
