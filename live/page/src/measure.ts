// Measuring distances along points that are tapped, or chosen by keys.

import type { Mission, Spot } from "./mission.js";
import { element } from "./panel.js";
import { distance } from "./place.js";

export class Measure {
  isOn = false;
  /** Cells east and north. */
  points: Spot[] = [];
  private readonly button = element("measure", HTMLButtonElement);

  constructor(
    private readonly cursor: () => Spot | undefined,
    private readonly redraw: () => void,
  ) {
    this.button.addEventListener("click", () => this.turn(!this.isOn));
    document.addEventListener("keydown", (event) => this.key(event));
  }

  turn(isOn: boolean): void {
    if (this.isOn === isOn) return;
    this.isOn = isOn;
    this.points = [];
    this.button.setAttribute("aria-pressed", String(isOn));
    this.redraw();
  }

  add(spot: Spot): void {
    this.points.push(spot);
    this.redraw();
  }

  /** The measured length in words. */
  text(mission: Mission): string {
    if (!this.isOn) return "";
    if (this.points.length < 2) return "Measuring: tap two or more points, or press Enter at the cursor.";
    return `Measured: ${distance(this.meters(mission))} along ${this.points.length} points.`;
  }

  private meters(mission: Mission): number {
    const legs = this.points.slice(1).map(([east, north], index) => {
      const from = this.points[index] ?? [east, north];
      return Math.hypot(east - from[0], north - from[1]);
    });
    return legs.reduce((sum, leg) => sum + leg, 0) * mission.hello.cell_meters;
  }

  private key(event: KeyboardEvent): void {
    const target = event.target;
    if (event.ctrlKey || event.altKey || event.metaKey || target instanceof HTMLSelectElement) return;
    if (event.key === "m") this.turn(!this.isOn);
    if (event.key === "Escape") this.turn(false);
    const spot = this.cursor();
    const isOnMap = target instanceof HTMLElement && target.id === "ground";
    if (event.key === "Enter" && this.isOn && isOnMap && spot !== undefined) this.add(spot);
  }
}
