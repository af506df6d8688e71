import { clock } from "./mission.js";
import { element } from "./panel.js";
const JUMP = 10;
export class Player {
    stream;
    isPlaying = false;
    isHeld = false;
    time = 0;
    end = 0;
    finds = [];
    slider = element("slider", HTMLInputElement);
    button = element("play", HTMLButtonElement);
    speed = element("speed", HTMLSelectElement);
    constructor(stream) {
        this.stream = stream;
        this.button.addEventListener("click", () => this.play(!this.isPlaying));
        this.speed.addEventListener("change", () => this.play(this.isPlaying));
        this.slider.addEventListener("pointerdown", () => (this.isHeld = true));
        for (const event of ["pointerup", "pointercancel"])
            addEventListener(event, () => (this.isHeld = false));
        element("find-before", HTMLButtonElement).addEventListener("click", () => this.jump(-1));
        element("find-after", HTMLButtonElement).addEventListener("click", () => this.jump(1));
        this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
        document.addEventListener("keydown", (event) => this.key(event));
        element("player", HTMLFormElement).addEventListener("submit", (event) => event.preventDefault());
    }
    begin(end, finds) {
        this.end = end;
        this.finds = finds;
        marks(finds);
        this.slider.max = String(end);
        element("player", HTMLElement).hidden = false;
        this.stream.send({ seek: this.time, speed: this.isPlaying ? Number(this.speed.value) : 0 });
    }
    update(mission) {
        this.time = mission.frame?.time ?? 0;
        if (!this.isHeld)
            this.slider.value = String(this.time);
        this.slider.setAttribute("aria-valuetext", clock(this.time));
        element("place", HTMLOutputElement).value = `${clock(this.time)} / ${clock(this.end)}`;
        if (this.isPlaying && this.time >= this.end)
            this.show(false);
        element("find-before", HTMLButtonElement).disabled = this.find(-1) === undefined;
        element("find-after", HTMLButtonElement).disabled = this.find(1) === undefined;
    }
    play(isPlaying) {
        if (isPlaying && this.time >= this.end)
            this.seek(0);
        this.show(isPlaying);
        this.stream.send({ speed: isPlaying ? Number(this.speed.value) : 0 });
    }
    show(isPlaying) {
        this.isPlaying = isPlaying;
        this.button.textContent = isPlaying ? "Stop" : "Play";
    }
    find(direction) {
        return direction === 1 ? this.finds.find((time) => time > this.time) : this.finds.findLast((time) => time < this.time);
    }
    jump(direction) {
        const time = this.find(direction);
        if (time !== undefined)
            this.seek(time);
    }
    seek(seconds) {
        this.time = Math.min(Math.max(seconds, 0), this.end);
        this.stream.send({ seek: this.time });
    }
    key(event) {
        const target = event.target;
        const isOther = target instanceof HTMLElement && ["INPUT", "SELECT", "BUTTON", "SUMMARY"].includes(target.tagName);
        if (event.ctrlKey || event.altKey || event.metaKey || element("player", HTMLElement).hidden)
            return;
        if (event.key === " " && !isOther) {
            event.preventDefault();
            this.play(!this.isPlaying);
        }
        if (event.key === "[")
            this.jump(-1);
        if (event.key === "]")
            this.jump(1);
        if (event.key === ",")
            this.seek(this.time - JUMP);
        if (event.key === ".")
            this.seek(this.time + JUMP);
    }
}
function marks(finds) {
    const options = finds.map((time) => {
        const option = document.createElement("option");
        option.value = String(time);
        return option;
    });
    element("find-times", HTMLDataListElement).replaceChildren(...options);
}
