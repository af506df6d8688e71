import { percent } from "./describe.js";
import { clock } from "./mission.js";
import { element } from "./panel.js";
import { coordinates, mgrs } from "./place.js";
export class Finds {
    map;
    sound;
    known;
    fresh = [];
    withdrawn = [];
    about = "";
    constructor(map, sound) {
        this.map = map;
        this.sound = sound;
        element("find-show", HTMLButtonElement).addEventListener("click", () => {
            const cell = this.fresh.at(-1) ?? this.withdrawn.at(-1);
            if (cell !== undefined)
                this.goTo(cell);
        });
        element("find-dismiss", HTMLButtonElement).addEventListener("click", () => this.dismiss());
    }
    begin(hello) {
        const about = JSON.stringify([hello.name, hello.rows, hello.columns, hello.end]);
        if (about === this.about && hello.end === null)
            return;
        this.about = about;
        this.known = undefined;
        this.dismiss();
    }
    take(mission, frame) {
        const cells = new Set(frame.declared.map((object) => object.cell));
        const isJump = mission.hello.end !== null && frame.is_whole;
        const known = isJump ? undefined : this.known;
        const news = known === undefined ? [] : [...cells].filter((cell) => !known.has(cell));
        this.fresh = isJump ? [] : [...this.fresh.filter((cell) => cells.has(cell)), ...news];
        const gone = known === undefined ? [] : [...known].filter((cell) => !cells.has(cell));
        this.withdrawn = isJump ? [] : [...this.withdrawn.filter((cell) => !cells.has(cell)), ...gone];
        this.known = cells;
        if (news.length > 0)
            this.sound.play();
    }
    show(mission) {
        const declared = mission.frame?.declared ?? [];
        this.banner(mission, declared);
        const body = element("objects", HTMLTableElement).tBodies[0];
        if (body === undefined)
            return;
        while (body.rows.length > declared.length)
            body.deleteRow(-1);
        const latest = [...declared].sort((a, b) => b.since - a.since || a.cell - b.cell);
        latest.forEach((object, index) => this.row(mission, body.rows[index] ?? newRow(body), object));
        element("none", HTMLElement).hidden = declared.length > 0;
        element("objects", HTMLElement).hidden = declared.length === 0;
    }
    banner(mission, declared) {
        const cell = this.fresh.at(-1);
        const object = declared.find((it) => it.cell === cell);
        const gone = this.withdrawn.map((it) => `${coordinates(mission.hello, mission.middle(it))} (cell ${mission.name(it)})`);
        const parts = [
            object === undefined ? "" : `Find at ${sentence(mission, object)}.`,
            this.fresh.length > 1 ? `${this.fresh.length - 1} more in the list.` : "",
            gone.length > 0 ? `Withdrawn, no longer a find: ${gone.join("; ")}.` : "",
        ].filter((part) => part !== "");
        element("find", HTMLElement).hidden = parts.length === 0;
        write(element("find-text", HTMLElement), parts.join(" "));
    }
    row(mission, row, object) {
        const [place, when, robot, chance] = row.cells;
        const button = place?.querySelector("button");
        if (button === null || button === undefined)
            return;
        write(button, coordinates(mission.hello, mission.middle(object.cell)));
        const square = mgrs(mission.hello, mission.middle(object.cell));
        button.title = [`Show cell ${mission.name(object.cell)} on the map`, square].filter(Boolean).join("; ");
        button.onclick = () => this.goTo(object.cell);
        write(when, clock(object.since));
        write(robot, object.robot === null ? "operator" : String(object.robot));
        write(chance, certainty(object));
    }
    goTo(cell) {
        this.map.goTo(cell);
        element("ground", HTMLElement).focus();
    }
    dismiss() {
        [this.fresh, this.withdrawn] = [[], []];
        element("find", HTMLElement).hidden = true;
    }
}
function sentence(mission, object) {
    const place = coordinates(mission.hello, mission.middle(object.cell));
    const by = object.robot === null ? "" : ` by robot ${object.robot}`;
    return `${place} (cell ${mission.name(object.cell)}) at ${clock(object.since)}${by}, probability ${certainty(object)}`;
}
function certainty(object) {
    return object.probability > 0.999 ? "> 99.9 %" : percent(object.probability);
}
function newRow(body) {
    const row = body.insertRow();
    const button = document.createElement("button");
    button.type = "button";
    button.className = "go";
    row.insertCell().append(button);
    for (let column = 1; column < 4; column += 1)
        row.insertCell();
    return row;
}
function write(place, text) {
    if (place !== undefined && place.textContent !== text)
        place.textContent = text;
}
