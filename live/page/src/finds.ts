// Finds: a banner and a sound for each new one, and the list.

import { percent } from "./describe.js";
import type { MapView } from "./map.js";
import { type Declared, type Frame, type Hello, type Mission, clock } from "./mission.js";
import { element } from "./panel.js";
import { coordinates, mgrs } from "./place.js";
import type { Sound } from "./sound.js";

export class Finds {
  /** Cells of the finds at the last frame; undefined before the first. */
  private known: Set<number> | undefined;
  /** The finds that the banner shows, the latest last. */
  private fresh: number[] = [];
  /** Cells of finds that were withdrawn since: further observations speak against them. */
  private withdrawn: number[] = [];
  private about = "";

  constructor(
    private readonly map: MapView,
    private readonly sound: Sound,
  ) {
    element("find-show", HTMLButtonElement).addEventListener("click", () => {
      const cell = this.fresh.at(-1) ?? this.withdrawn.at(-1);
      if (cell !== undefined) this.goTo(cell);
    });
    element("find-dismiss", HTMLButtonElement).addEventListener("click", () => this.dismiss());
  }

  /** A running mission whose stream was reopened goes on: what was found meanwhile is news. */
  begin(hello: Hello): void {
    const about = JSON.stringify([hello.name, hello.rows, hello.columns, hello.end]);
    if (about === this.about && hello.end === null) return;
    this.about = about;
    this.known = undefined;
    this.dismiss();
  }

  take(mission: Mission, frame: Frame): void {
    const cells = new Set(frame.declared.map((object) => object.cell));
    // A whole frame of a recording comes from another time of it.
    const isJump = mission.hello.end !== null && frame.is_whole;
    const known = isJump ? undefined : this.known;
    const news = known === undefined ? [] : [...cells].filter((cell) => !known.has(cell));
    this.fresh = isJump ? [] : [...this.fresh.filter((cell) => cells.has(cell)), ...news];
    const gone = known === undefined ? [] : [...known].filter((cell) => !cells.has(cell));
    this.withdrawn = isJump ? [] : [...this.withdrawn.filter((cell) => !cells.has(cell)), ...gone];
    this.known = cells;
    if (news.length > 0) this.sound.play();
  }

  show(mission: Mission): void {
    const declared = mission.frame?.declared ?? [];
    this.banner(mission, declared);
    const body = element("objects", HTMLTableElement).tBodies[0];
    if (body === undefined) return;
    while (body.rows.length > declared.length) body.deleteRow(-1);
    const latest = [...declared].sort((a, b) => b.since - a.since || a.cell - b.cell);
    latest.forEach((object, index) => this.row(mission, body.rows[index] ?? newRow(body), object));
    element("none", HTMLElement).hidden = declared.length > 0;
    element("objects", HTMLElement).hidden = declared.length === 0;
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
  }

  private row(mission: Mission, row: HTMLTableRowElement, object: Declared): void {
    const [place, when, robot, chance] = row.cells;
    const button = place?.querySelector("button");
    if (button === null || button === undefined) return;
    write(button, coordinates(mission.hello, mission.middle(object.cell)));
    const square = mgrs(mission.hello, mission.middle(object.cell));
    button.title = [`Show cell ${mission.name(object.cell)} on the map`, square].filter(Boolean).join("; ");
    button.onclick = () => this.goTo(object.cell);
    write(when, clock(object.since));
    write(robot, object.robot === null ? "operator" : String(object.robot));
    write(chance, certainty(object));
  }

  private goTo(cell: number): void {
    this.map.goTo(cell);
    element("ground", HTMLElement).focus();
  }

  private dismiss(): void {
    [this.fresh, this.withdrawn] = [[], []];
    element("find", HTMLElement).hidden = true;
  }
}

function sentence(mission: Mission, object: Declared): string {
  const place = coordinates(mission.hello, mission.middle(object.cell));
  const by = object.robot === null ? "" : ` by robot ${object.robot}`;
  return `${place} (cell ${mission.name(object.cell)}) at ${clock(object.since)}${by}, probability ${certainty(object)}`;
}

/** Most finds become certain: nines beyond the first three say nothing. */
function certainty(object: Declared): string {
  return object.probability > 0.999 ? "> 99.9 %" : percent(object.probability);
}

function newRow(body: HTMLTableSectionElement): HTMLTableRowElement {
  const row = body.insertRow();
  const button = document.createElement("button");
  button.type = "button";
  button.className = "go";
  row.insertCell().append(button);
  for (let column = 1; column < 4; column += 1) row.insertCell();
  return row;
}

function write(place: Element | undefined, text: string): void {
  if (place !== undefined && place.textContent !== text) place.textContent = text;
}
