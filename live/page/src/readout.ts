// What is at the cursor and under the pointer: probability, cell and coordinates.

import { describe } from "./describe.js";
import type { Mission, Spot } from "./mission.js";
import { element } from "./panel.js";
import { coordinates, otherwise } from "./place.js";

export class Readout {
  private coordinates = "";
  private readonly copy = element("copy", HTMLButtonElement);
  private hovered: { spot: Spot; pixels: Spot } | undefined;

  constructor() {
    this.copy.addEventListener("click", () => void this.put());
  }

  hover(spot: Spot | undefined, pixels: Spot): void {
    this.hovered = spot === undefined ? undefined : { spot, pixels };
  }

  show(mission: Mission, cursor: number | undefined): void {
    this.showHovered(mission);
    if (cursor === undefined) return;
    const spot = mission.middle(cursor);
    const text = describe(mission, cursor);
    const cell = element("cell", HTMLElement);
    if (cell.textContent !== text) cell.textContent = text;
    this.coordinates = coordinates(mission.hello, spot);
    const place = [this.coordinates, otherwise(mission.hello, spot)].filter(Boolean).join(" · ");
    const output = element("coordinates", HTMLElement);
    if (output.textContent !== place) {
      output.textContent = place;
      this.copy.textContent = "Copy";
    }
    this.copy.hidden = false;
  }

  private showHovered(mission: Mission): void {
    const box = element("hover", HTMLElement);
    const cell = this.hovered === undefined ? undefined : mission.cellAt(this.hovered.spot);
    box.hidden = cell === undefined;
    if (this.hovered === undefined || cell === undefined) return;
    const { spot, pixels } = this.hovered;
    const text = `${describe(mission, cell)}\n${coordinates(mission.hello, spot)}`;
    if (box.textContent !== text) box.textContent = text;
    const stage = element("ground", HTMLElement);
    const left = pixels[0] + 16 + box.offsetWidth > stage.clientWidth ? pixels[0] - 12 - box.offsetWidth : pixels[0] + 16;
    const top = pixels[1] + 16 + box.offsetHeight > stage.clientHeight ? pixels[1] - 12 - box.offsetHeight : pixels[1] + 16;
    box.style.transform = `translate(${Math.max(left, 0)}px, ${Math.max(top, 0)}px)`;
  }

  /** Browsers give the clipboard only to pages of this computer or with TLS; elsewhere the text is selected. */
  private async put(): Promise<void> {
    try {
      await navigator.clipboard.writeText(this.coordinates);
      this.copy.textContent = "Copied";
    } catch {
      getSelection()?.selectAllChildren(element("coordinates", HTMLElement));
      this.copy.textContent = "Selected: press Ctrl+C";
    }
  }
}
