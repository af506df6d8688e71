import { BANDS, NEVER, css, placeOnScale, plainColors, shade } from "./colors.js";
import { fit } from "./chart.js";
import { element } from "./panel.js";
import { note, noted } from "./place.js";
const TICKS_PERCENT = [0.001, 0.01, 0.1, 1, 10, 50, 90, 99];
const OVERLAYS = ["basemap", "no_go", "prior", "areas", "tracks", "plans", "grid"];
export class Layers {
    changed;
    choice = {
        base: "probability", basemap: true, no_go: true, prior: true, areas: true, tracks: true, plans: true, grid: false,
    };
    constructor(changed) {
        this.changed = changed;
        for (const base of ["probability", "searched"]) {
            element(`base-${base}`, HTMLInputElement).addEventListener("change", () => this.choose({ base }));
        }
        for (const id of OVERLAYS) {
            const box = element(`layer-${id}`, HTMLInputElement);
            box.addEventListener("change", () => this.choose({ [id]: box.checked }));
        }
        const notation = element("notation", HTMLSelectElement);
        notation.value = noted();
        notation.addEventListener("change", () => {
            note(notation.value);
            this.changed();
        });
        document.addEventListener("keydown", (event) => this.key(event));
        this.show();
    }
    begin(hello) {
        const has = (kinds) => hello.areas.some((area) => kinds.includes(area.kind));
        element("layer-prior", HTMLInputElement).disabled = !has(["prior", "last_known_position"]);
        element("layer-areas", HTMLInputElement).disabled = hello.areas.length === 0;
        element("notation-choice", HTMLElement).hidden = hello.earth === null;
        this.choose({ grid: hello.earth === null });
    }
    show() {
        const { base } = this.choice;
        element("legend-probability", HTMLElement).hidden = base !== "probability";
        element("legend-searched", HTMLElement).hidden = base !== "searched";
        if (base === "probability")
            drawScale(element("scale", HTMLCanvasElement));
        else
            drawBands(element("bands", HTMLElement));
        const plain = plainColors();
        for (const [id, color] of [["unsearched", plain.unsearched], ["unreachable", plain.outOfReach]]) {
            element(`sign-${id}`, HTMLElement).style.backgroundColor = css(color);
        }
    }
    choose(change) {
        Object.assign(this.choice, change);
        element(`base-${this.choice.base}`, HTMLInputElement).checked = true;
        for (const id of OVERLAYS)
            element(`layer-${id}`, HTMLInputElement).checked = this.choice[id];
        this.show();
        this.changed();
    }
    key(event) {
        if (event.ctrlKey || event.altKey || event.metaKey || event.target instanceof HTMLSelectElement)
            return;
        if (event.key === "l")
            this.choose({ base: this.choice.base === "searched" ? "probability" : "searched" });
    }
}
function drawScale(canvas) {
    const context = fit(canvas);
    for (let x = 0; x < canvas.clientWidth; x += 1) {
        context.fillStyle = css(shade(x / canvas.clientWidth));
        context.fillRect(x, 0, 1.5, canvas.clientHeight);
    }
    element("ticks", HTMLElement).replaceChildren(...TICKS_PERCENT.map(tick));
}
function tick(percent) {
    const mark = document.createElement("i");
    mark.textContent = percent === TICKS_PERCENT[0] ? `${percent} %` : String(percent);
    mark.style.left = `${100 * placeOnScale(percent / 100)}%`;
    return mark;
}
function drawBands(list) {
    if (list.childElementCount > 0)
        return;
    const text = (index) => {
        const [from, to] = [BANDS[index]?.from ?? 0, BANDS[index + 1]?.from ?? 100];
        return index === 0 ? `under ${to} %` : `${from}–${to} %`;
    };
    const entries = [["never looked at", NEVER], ...BANDS.map((band, index) => [text(index), band.color])];
    for (const [name, color] of entries) {
        const [entry, sign] = [document.createElement("li"), document.createElement("b")];
        sign.className = "sign";
        sign.style.backgroundColor = css(color);
        entry.append(sign, name);
        list.append(entry);
    }
}
