// The operator's marks: the form in which they are made, and their list, in which they are withdrawn.

import { form } from "./form.js";
import type { MapView } from "./map.js";
import { type MarkFrame, type Mission, type Spot, clock } from "./mission.js";
import { element } from "./panel.js";
import { coordinates } from "./place.js";

/** What is marked: a clue, or that others have searched. */
export type MarkKind = "clue" | "searched";

/** What the form says of a mark, as the commands take it. */
export type Said = { note: string; ratio: number; radius_meters: number } | { note: string; pod: number };

/** Withdraws marks. */
export interface Desk {
  withdraw(id: string): void;
  /** Why no command can be given now; undefined if one can. */
  readonly reason: string | undefined;
}

const TITLES: Record<MarkKind, string> = { clue: "Clue", searched: "Searched by others" };

/** Asks for what is to be said of a mark. */
export class MarkForm {
  private readonly dialog = form("mark", () => this.given?.(this.said()));
  private given: ((said: Said) => void) | undefined;
  private kind: MarkKind = "clue";

  /** Opens the form for something in a place; `given` takes what was said. */
  open(kind: MarkKind, place: string, given: (said: Said) => void): void {
    [this.kind, this.given] = [kind, given];
    element("mark-title", HTMLElement).textContent = `${TITLES[kind]}: ${place}`;
    this.offer(["mark-ratio", "mark-radius"], kind === "clue");
    this.offer(["mark-pod"], kind === "searched");
    this.dialog.querySelector("form")?.reset();
    this.dialog.returnValue = "";
    this.dialog.showModal();
    element("mark-note", HTMLInputElement).focus();
  }

  /** Shows fields, or hides them, so that they cannot be wrong. */
  private offer(ids: string[], isOffered: boolean): void {
    for (const id of ids) {
      const field = document.getElementById(id);
      if (field instanceof HTMLInputElement || field instanceof HTMLSelectElement) field.disabled = !isOffered;
      const label = field?.closest("label");
      if (label) label.hidden = !isOffered;
    }
  }

  private said(): Said {
    const note = element("mark-note", HTMLInputElement).value.trim();
    const number = (id: string) => Number(element(id, HTMLInputElement).value);
    if (this.kind === "searched") return { note, pod: number("mark-pod") / 100 };
    return { note, ratio: Number(element("mark-ratio", HTMLSelectElement).value), radius_meters: number("mark-radius") };
  }
}

/** Fills the list of marks. */
export function showMarks(mission: Mission, map: MapView, desk: Desk): void {
  const marks = [...mission.marks].reverse();
  element("marked-title", HTMLElement).hidden = marks.length === 0;
  const list = element("marked", HTMLUListElement);
  while (list.children.length > marks.length) list.lastElementChild?.remove();
  marks.forEach((mark, index) => show(list.children[index] ?? newItem(list), mark, mission, map, desk));
}

function show(item: Element, mark: MarkFrame, mission: Mission, map: MapView, desk: Desk): void {
  const [place, said, button] = item.children;
  if (!(place instanceof HTMLButtonElement && said instanceof HTMLElement && button instanceof HTMLButtonElement)) return;
  const cell = cellOf(mission, mark);
  write(place, cell === undefined ? "no cell" : coordinates(mission.hello, mission.middle(cell)));
  place.onclick = () => {
    if (cell === undefined) return;
    map.goTo(cell);
    element("ground", HTMLElement).focus();
  };
  write(said, ` ${clock(mark.time)} ${described(mark)} `);
  button.hidden = mission.hello.end !== null;
  button.disabled = desk.reason !== undefined;
  button.title = desk.reason ?? "";
  button.onclick = () => desk.withdraw(mark.id);
}

/** `clue, 10 times within 50 m: a glove`. */
export function described(mark: MarkFrame): string {
  const note = mark.note === "" ? "" : `: ${mark.note}`;
  if (mark.pod !== undefined) return `searched by others, ${(100 * mark.pod).toFixed(0)} %${note}`;
  const radius = mark.radius_meters ?? 0;
  return `clue, ${mark.ratio} times${radius > 0 ? ` within ${radius} m` : ""}${note}`;
}

/** The cell of a clue, or one in the middle of what others have searched. */
function cellOf(mission: Mission, mark: MarkFrame): number | undefined {
  if (mark.cell !== undefined) return mark.cell;
  const runs = mark.cells ?? [];
  if (runs.length === 0) return undefined;
  const middles = runs.map(([first, count]): Spot => mission.middle(first + (count >> 1)));
  const mean = (axis: 0 | 1) => middles.reduce((sum, middle) => sum + middle[axis], 0) / middles.length;
  return mission.cellAt([mean(0), mean(1)]);
}

function newItem(list: HTMLElement): Element {
  const item = list.appendChild(document.createElement("li"));
  const [place, said, button] = [document.createElement("button"), document.createElement("span"), document.createElement("button")];
  [place.type, place.className, place.title] = ["button", "go", "Show on the map"];
  [button.type, button.textContent] = ["button", "Withdraw"];
  item.append(place, said, button);
  return item;
}

function write(place: Element, text: string): void {
  if (place.textContent !== text) place.textContent = text;
}
