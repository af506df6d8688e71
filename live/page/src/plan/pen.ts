// Drawing: taps and typed coordinates become an area or a place.

import { element } from "../panel.js";
import type { Kind, Position } from "./api.js";
import { FEW_CORNERS, KINDS, isPlace, parsePosition } from "./drawing.js";
import type { PlanMap } from "./map.js";

export interface Drawn {
  /** An area or a place was drawn; `corners` are longitudes and latitudes. */
  drawn(kind: Kind, corners: Position[]): void;
  said(message: string, isWrong: boolean): void;
}

/** The button of each kind. */
const BUTTONS: Record<string, Kind> = {
  "draw-search": "search", "draw-no_go": "no_go", "draw-prior": "prior", "draw-last_known_position": "last_known_position",
  "draw-start": "start",
};

export class Pen {
  private kind: Kind | undefined;
  private corners: Position[] = [];
  private readonly typed = element("typed", HTMLInputElement);

  constructor(private readonly map: PlanMap, private readonly events: Drawn) {
    for (const [id, kind] of Object.entries(BUTTONS)) {
      element(id, HTMLButtonElement).addEventListener("click", () => this.begin(this.kind === kind ? undefined : kind));
    }
    const press = (id: string, act: () => void) => element(id, HTMLButtonElement).addEventListener("click", act);
    press("finish", () => this.finish());
    press("back", () => this.back());
    press("discard", () => this.begin(undefined));
    element("typing", HTMLFormElement).addEventListener("submit", (event) => {
      event.preventDefault();
      this.type();
    });
    document.addEventListener("keydown", (event) => this.key(event));
    this.show();
  }

  tapped(at: Position): void {
    if (this.kind === undefined) return;
    this.corners.push(at);
    if (isPlace(this.kind)) this.finish();
    else this.show();
  }

  private begin(kind: Kind | undefined): void {
    this.kind = kind;
    this.corners = [];
    this.events.said("", false);
    this.show();
  }

  private back(): void {
    this.corners.pop();
    this.show();
  }

  /** Typed coordinates are a corner or a place while one is drawn; otherwise the map goes there. */
  private type(): void {
    const at = parsePosition(this.typed.value);
    if (typeof at === "string") {
      this.events.said(at, true);
      return;
    }
    this.events.said("", false);
    this.typed.value = "";
    this.map.goTo(at);
    this.tapped(at);
  }

  private finish(): void {
    const { kind, corners } = this;
    if (kind === undefined) return;
    if (!isPlace(kind) && corners.length < 3) {
      this.events.said(`${FEW_CORNERS} Tap them on the map, or type their coordinates.`, true);
      return;
    }
    this.begin(undefined);
    this.events.drawn(kind, corners);
  }

  private key(event: KeyboardEvent): void {
    if (this.kind === undefined) return;
    if (event.key === "Escape") this.begin(undefined);
    const isTyping = event.target instanceof HTMLElement && event.target.matches("input, select, textarea, button");
    if (isTyping) return;
    if (event.key === "Enter") this.finish();
    if (event.key === "Backspace") this.back();
  }

  private show(): void {
    const { kind } = this;
    this.map.isDrawing = kind !== undefined;
    this.map.sketchOf(this.corners);
    for (const [id, of] of Object.entries(BUTTONS)) element(id, HTMLButtonElement).setAttribute("aria-pressed", String(of === kind));
    const isArea = kind !== undefined && !isPlace(kind);
    element("finish", HTMLButtonElement).hidden = !isArea;
    element("back", HTMLButtonElement).hidden = !isArea || this.corners.length === 0;
    element("discard", HTMLButtonElement).hidden = kind === undefined;
    element("typed-button", HTMLButtonElement).textContent = kind === undefined ? "Go there" : isArea ? "Add corner" : "Place it";
    const what = kind === undefined ? "" : isArea
      ? `${KINDS[kind]}: tap its corners on the map, then Finish. ${this.corners.length} so far.`
      : `${KINDS[kind]}: tap its place on the map, or type its coordinates.`;
    element("drawing", HTMLElement).textContent = what;
  }
}
