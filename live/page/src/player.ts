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
  private readonly slider = element("slider", HTMLInputElement);
  private readonly button = element("play", HTMLButtonElement);
  private readonly speed = element("speed", HTMLSelectElement);

  constructor(private readonly stream: Stream) {
    this.button.addEventListener("click", () => this.play(!this.isPlaying));
    this.speed.addEventListener("change", () => this.play(this.isPlaying));
    this.slider.addEventListener("pointerdown", () => (this.isHeld = true));
    this.slider.addEventListener("pointerup", () => (this.isHeld = false));
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    document.addEventListener("keydown", (event) => this.key(event));
    element("player", HTMLFormElement).addEventListener("submit", (event) => event.preventDefault());
  }

  begin(end: number): void {
    this.end = end;
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
    if (this.isPlaying && this.time >= this.end) this.show(false);
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
    if (event.key === ",") this.seek(this.time - JUMP);
    if (event.key === ".") this.seek(this.time + JUMP);
  }
}
