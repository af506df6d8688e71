// Playback controls of a recording: play, stop, seek.

import { type Mission, clock } from "./mission.js";
import { element } from "./panel.js";
import type { Stream } from "./stream.js";

/** Seconds that a key moves back or forward. */
const JUMP = 10;

export class Player {
  private isPlaying = false;
  private isHeld = false;
  private time = 0;
  private end = 0;
  /** Times of finds, seconds. */
  private finds: number[] = [];
  private readonly slider = element("slider", HTMLInputElement);
  private readonly button = element("play", HTMLButtonElement);
  private readonly speed = element("speed", HTMLSelectElement);

  constructor(private readonly stream: Stream) {
    this.button.addEventListener("click", () => this.play(!this.isPlaying));
    this.speed.addEventListener("change", () => this.play(this.isPlaying));
    this.slider.addEventListener("pointerdown", () => (this.isHeld = true));
    // Also where the pointer leaves the slider before it is released.
    for (const event of ["pointerup", "pointercancel"]) addEventListener(event, () => (this.isHeld = false));
    element("find-before", HTMLButtonElement).addEventListener("click", () => this.jump(-1));
    element("find-after", HTMLButtonElement).addEventListener("click", () => this.jump(1));
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    document.addEventListener("keydown", (event) => this.key(event));
    element("player", HTMLFormElement).addEventListener("submit", (event) => event.preventDefault());
  }

  begin(end: number, finds: number[]): void {
    this.end = end;
    this.finds = finds;
    marks(finds);
    this.slider.max = String(end);
    element("player", HTMLElement).hidden = false;
    // The stream may have been reopened: it continues at the last time.
    this.stream.send({ seek: this.time, speed: this.isPlaying ? Number(this.speed.value) : 0 });
  }

  update(mission: Mission): void {
    this.time = mission.frame?.time ?? 0;
    if (!this.isHeld) this.slider.value = String(this.time);
    this.slider.setAttribute("aria-valuetext", clock(this.time));
    element("place", HTMLOutputElement).value = `${clock(this.time)} / ${clock(this.end)}`;
    // The server stops there too.
    if (this.isPlaying && this.time >= this.end) this.show(false);
    element("find-before", HTMLButtonElement).disabled = this.find(-1) === undefined;
    element("find-after", HTMLButtonElement).disabled = this.find(1) === undefined;
  }

  private play(isPlaying: boolean): void {
    if (isPlaying && this.time >= this.end) this.seek(0);
    this.show(isPlaying);
    this.stream.send({ speed: isPlaying ? Number(this.speed.value) : 0 });
  }

  private show(isPlaying: boolean): void {
    this.isPlaying = isPlaying;
    this.button.textContent = isPlaying ? "Stop" : "Play";
  }

  /** The time of the next find, or of the one before. */
  private find(direction: 1 | -1): number | undefined {
    return direction === 1 ? this.finds.find((time) => time > this.time) : this.finds.findLast((time) => time < this.time);
  }

  private jump(direction: 1 | -1): void {
    const time = this.find(direction);
    if (time !== undefined) this.seek(time);
  }

  private seek(seconds: number): void {
    this.time = Math.min(Math.max(seconds, 0), this.end);
    this.stream.send({ seek: this.time });
  }

  private key(event: KeyboardEvent): void {
    const target = event.target;
    const isOther = target instanceof HTMLElement && ["INPUT", "SELECT", "BUTTON", "SUMMARY"].includes(target.tagName);
    if (event.ctrlKey || event.altKey || event.metaKey || element("player", HTMLElement).hidden) return;
    if (event.key === " " && !isOther) {
      event.preventDefault();
      this.play(!this.isPlaying);
    }
    if (event.key === "[") this.jump(-1);
    if (event.key === "]") this.jump(1);
    if (event.key === ",") this.seek(this.time - JUMP);
    if (event.key === ".") this.seek(this.time + JUMP);
  }
}

/** Marks the finds on the slider. */
function marks(finds: number[]): void {
  const options = finds.map((time) => {
    const option = document.createElement("option");
    option.value = String(time);
    return option;
  });
  element("find-times", HTMLDataListElement).replaceChildren(...options);
}
