import { keep, kept } from "./kept.js";
import { element } from "./panel.js";
const KEPT = "sound";
const TONES = [[660, 0], [880, 0.18]];
const TONE_SECONDS = 0.16;
export class Sound {
    isOn = kept(KEPT) !== "off";
    context;
    button = element("sound", HTMLButtonElement);
    constructor() {
        this.button.addEventListener("click", () => this.turn(!this.isOn));
        for (const event of ["pointerdown", "keydown"])
            addEventListener(event, () => this.open(), { once: true });
        this.show();
    }
    play() {
        if (!this.isOn || this.context === undefined)
            return;
        for (const [hertz, after] of TONES)
            this.tone(this.context, hertz, this.context.currentTime + after);
    }
    tone(context, hertz, start) {
        const [oscillator, gain] = [context.createOscillator(), context.createGain()];
        oscillator.frequency.value = hertz;
        gain.gain.setValueAtTime(0.25, start);
        gain.gain.exponentialRampToValueAtTime(0.001, start + TONE_SECONDS);
        oscillator.connect(gain).connect(context.destination);
        oscillator.start(start);
        oscillator.stop(start + TONE_SECONDS);
    }
    open() {
        this.context ??= new AudioContext();
        this.show();
    }
    turn(isOn) {
        this.isOn = isOn;
        keep(KEPT, isOn ? "on" : "off");
        this.show();
        this.play();
    }
    show() {
        this.button.setAttribute("aria-pressed", String(this.isOn));
        this.button.textContent = this.isOn ? "Sound on" : "Sound off";
        const waits = this.isOn && this.context === undefined;
        this.button.title = waits ? "Browsers allow sound after the first click or key on the page" : "Sound of a find";
    }
}
