// Finds: a banner and a sound for each new one, and the list, in which the operator confirms and dismisses them.

import { percent } from "./describe.js";
import type { MapView } from "./map.js";
import { type Declared, type Dismissed, type Frame, type Hello, type Mission, type Picture, clock } from "./mission.js";
import { element } from "./panel.js";
import { PictureView, thumbnail } from "./picture.js";
import { coordinates, otherwise, within } from "./place.js";
import type { Sound } from "./sound.js";

/** Gives the operator's decisions to the mission. */
export interface Desk {
  decide(cell: number, as: Decision): void;
  /** Why no command can be given now; undefined if one can. */
  readonly reason: string | undefined;
}

type Decision = "confirmed" | "dismissed" | "undone";

const BUTTONS: [Decision, string][] = [["confirmed", "Confirm"], ["dismissed", "Dismiss"], ["undone", "Undo"]];

/** What `within` means. */
const SURE = "95 of 100 objects are within that distance of the coordinates";

export class Finds {
  /** Cells of the finds at the last frame; undefined before the first. */
  private known: Set<number> | undefined;
  /** Cells of the dismissed finds then. */
  private dismissed = new Set<number>();
  /** The finds that the banner shows, the latest last. */
  private fresh: number[] = [];
  /** Cells of finds that were withdrawn since: further observations speak against them. */
  private withdrawn: number[] = [];
  private about = "";
  private readonly pictures: PictureView;

  constructor(
    private readonly map: MapView,
    private readonly sound: Sound,
    private readonly desk: Desk,
  ) {
    element("find-show", HTMLButtonElement).addEventListener("click", () => {
      const cell = this.fresh.at(-1) ?? this.withdrawn.at(-1);
      if (cell !== undefined) this.goTo(cell);
    });
    for (const [id, as] of [["find-confirm", "confirmed"], ["find-dismiss", "dismissed"]] as const) {
      element(id, HTMLButtonElement).addEventListener("click", () => {
        const cell = this.fresh.at(-1);
        if (cell !== undefined) this.decide(cell, as);
      });
    }
    element("find-close", HTMLButtonElement).addEventListener("click", () => this.close());
    this.pictures = new PictureView((cell, as) => this.decide(cell, as));
  }

  /** A running mission whose stream was reopened goes on: what was found meanwhile is news. */
  begin(hello: Hello): void {
    const about = JSON.stringify([hello.name, hello.rows, hello.columns, hello.end]);
    if (about === this.about && hello.end === null) return;
    this.about = about;
    this.known = undefined;
    this.close();
  }

  take(mission: Mission, frame: Frame): void {
    const cells = new Set(frame.declared.map((object) => object.cell));
    const dismissed = new Set(frame.dismissed.map((object) => object.cell));
    // A whole frame of a recording comes from another time of it.
    const isJump = mission.hello.end !== null && frame.is_whole;
    const known = isJump ? undefined : this.known;
    // A find whose dismissal is undone is no news.
    const isUndone = (object: Declared) => this.dismissed.has(object.cell) && object.operator !== "dismissed";
    const found = frame.declared.filter((object) => !isUndone(object)).map((object) => object.cell);
    const news = known === undefined ? [] : found.filter((cell) => !known.has(cell));
    this.fresh = isJump ? [] : [...this.fresh.filter((cell) => cells.has(cell)), ...news];
    const gone = known === undefined ? [] : [...known].filter((cell) => !cells.has(cell) && !dismissed.has(cell));
    this.withdrawn = isJump ? [] : [...this.withdrawn.filter((cell) => !cells.has(cell)), ...gone];
    [this.known, this.dismissed] = [cells, dismissed];
    if (news.length > 0) this.sound.play();
  }

  show(mission: Mission): void {
    const { declared, dismissed } = mission.frame ?? { declared: [], dismissed: [] };
    this.banner(mission, declared);
    const body = element("objects", HTMLTableElement).tBodies[0];
    if (body === undefined) return;
    const latest = [...declared].sort((a, b) => b.since - a.since || a.cell - b.cell);
    const objects: (Declared | Dismissed)[] = [...latest, ...dismissed];
    while (body.rows.length > objects.length) body.deleteRow(-1);
    objects.forEach((object, index) => this.row(mission, body.rows[index] ?? newRow(body), object));
    const pictures = objects.flatMap((it): [number, Picture][] => it.picture === undefined ? [] : [[it.cell, it.picture]]);
    const isOpen = (cell: number) =>
      mission.hello.end === null && declared.some((it) => it.cell === cell && it.operator !== "confirmed");
    this.pictures.update(mission, new Map(pictures), this.desk.reason, isOpen);
    element("none", HTMLElement).hidden = objects.length > 0;
    element("objects", HTMLElement).hidden = objects.length === 0;
  }

  private banner(mission: Mission, declared: Declared[]): void {
    const cell = this.fresh.at(-1);
    const object = declared.find((it) => it.cell === cell);
    const gone = this.withdrawn.map((it) => `${coordinates(mission.hello, mission.middle(it))} (cell ${mission.name(it)})`);
    const parts = [
      object === undefined ? "" : `Find at ${sentence(mission, object)}.`,
      this.fresh.length > 1 ? `${this.fresh.length - 1} more in the list.` : "",
      gone.length > 0 ? `Withdrawn, no longer a find: ${gone.join("; ")}.` : "",
    ].filter((part) => part !== "");
    element("find", HTMLElement).hidden = parts.length === 0;
    write(element("find-text", HTMLElement), parts.join(" "));
    this.thumbnail(mission, element("find-picture", HTMLButtonElement), object);
    for (const id of ["find-confirm", "find-dismiss"]) {
      const button = element(id, HTMLButtonElement);
      button.hidden = object === undefined;
      this.lock(button);
    }
  }

  private row(mission: Mission, row: HTMLTableRowElement, object: Declared | Dismissed): void {
    const [place, when, robot, chance] = row.cells;
    const button = place?.querySelector<HTMLButtonElement>(".go");
    const small = place?.querySelector<HTMLButtonElement>(".picture");
    if (place === undefined || !button || !small) return;
    this.thumbnail(mission, small, object);
    const where = mission.where(object.cell);
    write(button, `${coordinates(mission.hello, where)}${within(mission, object.cell)}`);
    const other = otherwise(mission.hello, where);
    const known = object.position === undefined ? "" : SURE;
    button.title = [`Show cell ${mission.name(object.cell)} on the map`, other, known].filter(Boolean).join("; ");
    button.onclick = () => this.goTo(object.cell);
    write(when, clock(object.since));
    write(robot, object.robot === null ? "operator" : String(object.robot));
    write(chance, "probability" in object ? certainty(object) : "–");
    const operator = "probability" in object ? object.operator : "dismissed";
    row.classList.toggle("dismissed", !("probability" in object));
    this.decision(place, object.cell, operator, "probability" in object, mission.hello.end === null);
  }

  private thumbnail(mission: Mission, button: HTMLButtonElement, object: Declared | Dismissed | undefined): void {
    const picture = object?.picture;
    thumbnail(button, picture, () => {
      if (object !== undefined && picture !== undefined) this.pictures.open(mission, object.cell, picture);
      this.show(mission);
    });
  }

  /** What is decided about a find, and the buttons to decide; a recording has none. */
  private decision(place: Element, cell: number, operator: Declared["operator"], isDeclared: boolean, isLive: boolean): void {
    const words = { confirmed: "✓ confirmed", dismissed: isDeclared ? "dismissed, and found again" : "✕ dismissed" };
    const line = place.querySelector(".decide") ?? newLine(place);
    const text = operator === null ? "" : words[operator];
    const isSettled = operator === "confirmed" || (operator === "dismissed" && !isDeclared);
    const wanted = BUTTONS.filter(([as]) => isLive && (as === "undone") === isSettled);
    const named = `${text} ${wanted.map(([, name]) => name).join(" ")}`;
    if (line.getAttribute("data-is") !== named) {
      line.setAttribute("data-is", named);
      line.replaceChildren(...(text === "" ? [] : [bold(text)]), ...wanted.map(([as, name]) => newButton(as, name)));
    }
    for (const button of line.querySelectorAll("button")) {
      button.onclick = () => this.decide(cell, button.value as Decision);
      this.lock(button);
    }
  }

  private lock(button: HTMLButtonElement): void {
    button.disabled = this.desk.reason !== undefined;
    button.title = this.desk.reason ?? "";
  }

  private decide(cell: number, as: Decision): void {
    this.fresh = this.fresh.filter((it) => it !== cell);
    this.desk.decide(cell, as);
  }

  private goTo(cell: number): void {
    this.map.goTo(cell);
    element("ground", HTMLElement).focus();
  }

  private close(): void {
    [this.fresh, this.withdrawn] = [[], []];
    element("find", HTMLElement).hidden = true;
  }
}

function sentence(mission: Mission, object: Declared): string {
  const place = `${coordinates(mission.hello, mission.where(object.cell))}${within(mission, object.cell)}`;
  const by = object.robot === null ? "" : ` by robot ${object.robot}`;
  return `${place} (cell ${mission.name(object.cell)}) at ${clock(object.since)}${by}, probability ${certainty(object)}`;
}

/** Most finds become certain: nines beyond the first three say nothing. */
function certainty(object: Declared): string {
  return object.probability > 0.999 ? "> 99.9 %" : percent(object.probability);
}

function newRow(body: HTMLTableSectionElement): HTMLTableRowElement {
  const row = body.insertRow();
  const [button, picture] = [document.createElement("button"), document.createElement("button")];
  [button.type, button.className] = ["button", "go"];
  [picture.type, picture.className, picture.hidden] = ["button", "picture", true];
  row.insertCell().append(button, picture);
  for (let column = 1; column < 4; column += 1) row.insertCell();
  return row;
}

function newLine(place: Element): Element {
  const line = place.appendChild(document.createElement("div"));
  line.className = "decide";
  return line;
}

function newButton(as: Decision, name: string): HTMLButtonElement {
  const button = document.createElement("button");
  [button.type, button.value, button.textContent] = ["button", as, name];
  return button;
}

function bold(text: string): HTMLElement {
  const part = document.createElement("b");
  part.textContent = text;
  return part;
}

function write(place: Element | undefined, text: string): void {
  if (place !== undefined && place.textContent !== text) place.textContent = text;
}
