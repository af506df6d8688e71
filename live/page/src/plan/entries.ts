// What people enter: numbers in the units of the page, and entries that are refused. Nothing here touches the page.

import type { Place, Plan, Problem } from "./api.js";

/** The numbers that a field allows, in the unit of the page. Limits in the unit of a scenario are checked with it. */
export interface Allowed {
  isWhole?: true;
  /** Whether it may be empty. */
  isOptional?: true;
  /** Limits; that of `above` is not allowed itself. */
  above?: number;
  least?: number;
  most?: number;
  unit?: string;
}

const NUMBER = /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i;

/** The number of a text, nothing of an empty one where that is allowed; otherwise what is wrong with it. */
export function parseNumber(text: string, allowed: Allowed): number | undefined | string {
  const { isWhole, isOptional, above = -Infinity, least = -Infinity, most = Infinity } = allowed;
  const trimmed = text.replace(/%\s*$/, "").trim();
  if (trimmed === "") return isOptional ? undefined : refusal("A number is missing", allowed);
  const plain = trimmed.replace(",", ".").replace("−", "-");
  const value = NUMBER.test(plain) ? Number(plain) : NaN;
  if (!Number.isFinite(value)) return refusal(`“${trimmed}” is no number`, allowed);
  const isAllowed = value > above && value >= least && value <= most && (!isWhole || Number.isSafeInteger(value));
  return isAllowed ? value : refusal(`${trimmed} is not possible`, allowed);
}

/** Four distances, each above the one before; nothing of an empty text where that is allowed; otherwise what is wrong with it. */
export function parseQuartiles(text: string, isOptional: boolean): number[] | undefined | string {
  const words = text.split(/[\s,;]+/).filter((word) => word !== "");
  if (words.length === 0 && isOptional) return undefined;
  const meters = words.map((word) => (NUMBER.test(word) ? Number(word) : NaN));
  const isAllowed = meters.length === 4 && meters.every((value, index) => value > (meters[index - 1] ?? 0) && value <= 100_000);
  return isAllowed ? meters : "Allowed are four distances in meters, such as 40, 150, 400, 1200: each above the one before, up to 100000 m.";
}

/** What is wrong, and `a whole number from 1 to 1000`, or `a number above 0, up to 100 %`. */
function refusal(what: string, { isWhole, above, least, most, unit }: Allowed): string {
  const limits = [
    ...(above === undefined ? [] : [` above ${above}`]),
    ...(least === undefined ? [] : [` from ${least}`]),
    ...(most === undefined ? [] : [`${above === undefined ? " to" : ", up to"} ${most}`]),
  ];
  const allowed = `a ${isWhole ? "whole " : ""}number${limits.join("")}${unit === undefined ? "" : ` ${unit}`}`;
  return allowed === "a number" ? `${what}.` : `${what}; allowed is ${allowed}.`;
}

/** An entry that was not sent. */
interface Refused {
  at: Place;
  text: string;
  message: string;
  /** What the plan has in its place, */
  shown(plan: Plan): string;
  /** and had when it was refused. */
  before: string;
}

/** Entries that are refused, by the ids of their fields: they stay on the page until they are mended. */
export class Entries {
  private readonly refused = new Map<string, Refused>();

  constructor(private readonly changed: () => void) {}

  /** Passes a valid entry on; otherwise it stays where it is, with what is wrong with it. */
  take<T>(id: string, at: Place, plan: Plan | undefined, shown: (plan: Plan) => string, text: string, value: T | string, act: (value: T) => void): void {
    if (typeof value !== "string") {
      this.refused.delete(id);
      act(value);
    } else if (plan !== undefined) {
      this.refused.set(id, { at, text, message: value, shown, before: shown(plan) });
      this.changed();
    }
  }

  /** What is wrong. An entry is forgotten once the plan has something else in its place. */
  problems(plan: Plan): Problem[] {
    for (const [id, { shown, before }] of this.refused) if (shown(plan) !== before) this.refused.delete(id);
    return [...this.refused.values()].map(({ at, message }) => ({ at, message }));
  }

  text(id: string): string | undefined {
    return this.refused.get(id)?.text;
  }

  get isEmpty(): boolean {
    return this.refused.size === 0;
  }

  /** Forgets all of them. */
  clear(): void {
    this.refused.clear();
    this.changed();
  }
}
