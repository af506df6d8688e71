// The layers of the map that the viewer switches, and the legend.

import { BANDS, NEVER, css, placeOnScale, plainColors, shade } from "./colors.js";
import { fit } from "./chart.js";
import type { Hello } from "./mission.js";
import { element } from "./panel.js";
import { type Notation, note, noted } from "./place.js";

/** Labels of the scale of probability. */
const TICKS_PERCENT = [0.001, 0.01, 0.1, 1, 10, 50, 90, 99];

const OVERLAYS = ["basemap", "no_go", "prior", "areas", "tracks", "plans", "grid"] as const;

/** What the map shows. */
export type Choice = { base: "probability" | "searched" } & Record<(typeof OVERLAYS)[number], boolean>;

export class Layers {
  readonly choice: Choice = {
    base: "probability", basemap: true, no_go: true, prior: true, areas: true, tracks: true, plans: true, grid: false,
  };

  constructor(private readonly changed: () => void) {
    for (const base of ["probability", "searched"] as const) {
      element(`base-${base}`, HTMLInputElement).addEventListener("change", () => this.choose({ base }));
    }
    for (const id of OVERLAYS) {
      const box = element(`layer-${id}`, HTMLInputElement);
      box.addEventListener("change", () => this.choose({ [id]: box.checked }));
    }
    const notation = element("notation", HTMLSelectElement);
    notation.value = noted();
    notation.addEventListener("change", () => {
      note(notation.value as Notation);
      this.changed();
    });
    document.addEventListener("keydown", (event) => this.key(event));
    this.show();
  }

  /** A map that is not on the earth has a metric grid instead; layers that it lacks are not offered. */
  begin(hello: Hello): void {
    const has = (kinds: string[]) => hello.areas.some((area) => kinds.includes(area.kind));
    element("layer-prior", HTMLInputElement).disabled = !has(["prior", "last_known_position"]);
    element("layer-areas", HTMLInputElement).disabled = hello.areas.length === 0;
    element("notation-choice", HTMLElement).hidden = hello.earth === null;
    this.choose({ grid: hello.earth === null });
  }

  /** Draws what depends on sizes and on the color scheme. */
  show(): void {
    const { base } = this.choice;
    element("legend-probability", HTMLElement).hidden = base !== "probability";
    element("legend-searched", HTMLElement).hidden = base !== "searched";
    if (base === "probability") drawScale(element("scale", HTMLCanvasElement));
    else drawBands(element("bands", HTMLElement));
    const plain = plainColors();
    for (const [id, color] of [["unsearched", plain.unsearched], ["unreachable", plain.outOfReach]] as const) {
      element(`sign-${id}`, HTMLElement).style.backgroundColor = css(color);
    }
  }

  private choose(change: Partial<Choice>): void {
    Object.assign(this.choice, change);
    element(`base-${this.choice.base}`, HTMLInputElement).checked = true;
    for (const id of OVERLAYS) element(`layer-${id}`, HTMLInputElement).checked = this.choice[id];
    this.show();
    this.changed();
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target instanceof HTMLSelectElement) return;
    if (event.key === "l") this.choose({ base: this.choice.base === "searched" ? "probability" : "searched" });
  }
}

/** The color scale from certainly empty to certainly an object. */
function drawScale(canvas: HTMLCanvasElement): void {
  const context = fit(canvas);
  for (let x = 0; x < canvas.clientWidth; x += 1) {
    context.fillStyle = css(shade(x / canvas.clientWidth));
    context.fillRect(x, 0, 1.5, canvas.clientHeight);
  }
  element("ticks", HTMLElement).replaceChildren(...TICKS_PERCENT.map(tick));
}

function tick(percent: number): HTMLElement {
  const mark = document.createElement("i");
  mark.textContent = percent === TICKS_PERCENT[0] ? `${percent} %` : String(percent);
  mark.style.left = `${100 * placeOnScale(percent / 100)}%`;
  return mark;
}

/** The bands of the probability of detection. */
function drawBands(list: HTMLElement): void {
  if (list.childElementCount > 0) return;
  const text = (index: number) => {
    const [from, to] = [BANDS[index]?.from ?? 0, BANDS[index + 1]?.from ?? 100];
    return index === 0 ? `under ${to} %` : `${from}–${to} %`;
  };
  const entries = [["never looked at", NEVER] as const, ...BANDS.map((band, index) => [text(index), band.color] as const)];
  for (const [name, color] of entries) {
    const [entry, sign] = [document.createElement("li"), document.createElement("b")];
    sign.className = "sign";
    sign.style.backgroundColor = css(color);
    entry.append(sign, name);
    list.append(entry);
  }
}
