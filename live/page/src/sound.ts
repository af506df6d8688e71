// The sound of a find, which the viewer can switch off.

import { keep, kept } from "./kept.js";
import { element } from "./panel.js";

const KEPT = "sound";
/** Two rising tones: hertz, and when each starts, seconds. */
const TONES = [[660, 0], [880, 0.18]] as const;
const TONE_SECONDS = 0.16;

export class Sound {
  private isOn = kept(KEPT) !== "off";
  private context: AudioContext | undefined;
  private readonly button = element("sound", HTMLButtonElement);

  constructor() {
    this.button.addEventListener("click", () => this.turn(!this.isOn));
    // Browsers make no sound before the viewer has touched the page; asking them earlier is an error.
    for (const event of ["pointerdown", "keydown"]) addEventListener(event, () => this.open(), { once: true });
    this.show();
  }

  play(): void {
    if (!this.isOn || this.context === undefined) return;
    for (const [hertz, after] of TONES) this.tone(this.context, hertz, this.context.currentTime + after);
  }

  private tone(context: AudioContext, hertz: number, start: number): void {
    const [oscillator, gain] = [context.createOscillator(), context.createGain()];
    oscillator.frequency.value = hertz;
    gain.gain.setValueAtTime(0.25, start);
    gain.gain.exponentialRampToValueAtTime(0.001, start + TONE_SECONDS);
    oscillator.connect(gain).connect(context.destination);
    oscillator.start(start);
    oscillator.stop(start + TONE_SECONDS);
  }

  private open(): void {
    this.context ??= new AudioContext();
    this.show();
  }

  private turn(isOn: boolean): void {
    this.isOn = isOn;
    keep(KEPT, isOn ? "on" : "off");
    this.show();
    this.play();
  }

  private show(): void {
    this.button.setAttribute("aria-pressed", String(this.isOn));
    this.button.textContent = this.isOn ? "Sound on" : "Sound off";
    const waits = this.isOn && this.context === undefined;
    this.button.title = waits ? "Browsers allow sound after the first click or key on the page" : "Sound of a find";
  }
}
