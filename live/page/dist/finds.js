import { percent } from "./describe.js";
import { clock } from "./mission.js";
import { element } from "./panel.js";
import { PictureView, thumbnail } from "./picture.js";
import { coordinates, otherwise, within } from "./place.js";
const BUTTONS = [["confirmed", "Confirm"], ["dismissed", "Dismiss"], ["undone", "Undo"]];
const SURE = "95 of 100 objects are within that distance of the coordinates";
export class Finds {
    map;
    sound;
    desk;
    known;
    dismissed = new Set();
    fresh = [];
    withdrawn = [];
    about = "";
    pictures;
    constructor(map, sound, desk) {
        this.map = map;
        this.sound = sound;
        this.desk = desk;
        element("find-show", HTMLButtonElement).addEventListener("click", () => {
            const cell = this.fresh.at(-1) ?? this.withdrawn.at(-1);
            if (cell !== undefined)
                this.goTo(cell);
        });
        for (const [id, as] of [["find-confirm", "confirmed"], ["find-dismiss", "dismissed"]]) {
            element(id, HTMLButtonElement).addEventListener("click", () => {
                const cell = this.fresh.at(-1);
                if (cell !== undefined)
                    this.decide(cell, as);
            });
        }
        element("find-close", HTMLButtonElement).addEventListener("click", () => this.close());
        this.pictures = new PictureView((cell, as) => this.decide(cell, as));
    }
    begin(hello) {
        const about = JSON.stringify([hello.name, hello.rows, hello.columns, hello.end]);
        if (about === this.about && hello.end === null)
            return;
        this.about = about;
        this.known = undefined;
        this.close();
    }
    take(mission, frame) {
        const cells = new Set(frame.declared.map((object) => object.cell));
        const dismissed = new Set(frame.dismissed.map((object) => object.cell));
        const isJump = mission.hello.end !== null && frame.is_whole;
        const known = isJump ? undefined : this.known;
        const isUndone = (object) => this.dismissed.has(object.cell) && object.operator !== "dismissed";
        const found = frame.declared.filter((object) => !isUndone(object)).map((object) => object.cell);
        const news = known === undefined ? [] : found.filter((cell) => !known.has(cell));
        this.fresh = isJump ? [] : [...this.fresh.filter((cell) => cells.has(cell)), ...news];
        const gone = known === undefined ? [] : [...known].filter((cell) => !cells.has(cell) && !dismissed.has(cell));
        this.withdrawn = isJump ? [] : [...this.withdrawn.filter((cell) => !cells.has(cell)), ...gone];
        [this.known, this.dismissed] = [cells, dismissed];
        if (news.length > 0)
            this.sound.play();
    }
    show(mission) {
        const { declared, dismissed } = mission.frame ?? { declared: [], dismissed: [] };
        this.banner(mission, declared);
        const body = element("objects", HTMLTableElement).tBodies[0];
        if (body === undefined)
            return;
        const latest = [...declared].sort((a, b) => b.since - a.since || a.cell - b.cell);
        const objects = [...latest, ...dismissed];
        while (body.rows.length > objects.length)
            body.deleteRow(-1);
        objects.forEach((object, index) => this.row(mission, body.rows[index] ?? newRow(body), object));
        const pictures = objects.flatMap((it) => it.picture === undefined ? [] : [[it.cell, it.picture]]);
        const isOpen = (cell) => mission.hello.end === null && declared.some((it) => it.cell === cell && it.operator !== "confirmed");
        this.pictures.update(mission, new Map(pictures), this.desk.reason, isOpen);
        element("none", HTMLElement).hidden = objects.length > 0;
        element("objects", HTMLElement).hidden = objects.length === 0;
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
        this.thumbnail(mission, element("find-picture", HTMLButtonElement), object);
        for (const id of ["find-confirm", "find-dismiss"]) {
            const button = element(id, HTMLButtonElement);
            button.hidden = object === undefined;
            this.lock(button);
        }
    }
    row(mission, row, object) {
        const [place, when, robot, chance] = row.cells;
        const button = place?.querySelector(".go");
        const small = place?.querySelector(".picture");
        if (place === undefined || !button || !small)
            return;
        this.thumbnail(mission, small, object);
        const where = mission.where(object.cell);
        write(button, `${coordinates(mission.hello, where)}${within(mission, object.cell)}`);
        const other = otherwise(mission.hello, where);
        const known = object.position === undefined ? "" : SURE;
        button.title = [`Show cell ${mission.name(object.cell)} on the map`, other, known].filter(Boolean).join("; ");
        button.onclick = () => this.goTo(object.cell);
        write(when, clock(object.since));
        write(robot, object.robot === null ? "operator" : String(object.robot));
        write(chance, "probability" in object ? certainty(object) : "–");
        const operator = "probability" in object ? object.operator : "dismissed";
        row.classList.toggle("dismissed", !("probability" in object));
        this.decision(place, object.cell, operator, "probability" in object, mission.hello.end === null);
    }
    thumbnail(mission, button, object) {
        const picture = object?.picture;
        thumbnail(button, picture, () => {
            if (object !== undefined && picture !== undefined)
                this.pictures.open(mission, object.cell, picture);
            this.show(mission);
        });
    }
    decision(place, cell, operator, isDeclared, isLive) {
        const words = { confirmed: "✓ confirmed", dismissed: isDeclared ? "dismissed, and found again" : "✕ dismissed" };
        const line = place.querySelector(".decide") ?? newLine(place);
        const text = operator === null ? "" : words[operator];
        const isSettled = operator === "confirmed" || (operator === "dismissed" && !isDeclared);
        const wanted = BUTTONS.filter(([as]) => isLive && (as === "undone") === isSettled);
        const named = `${text} ${wanted.map(([, name]) => name).join(" ")}`;
        if (line.getAttribute("data-is") !== named) {
            line.setAttribute("data-is", named);
            line.replaceChildren(...(text === "" ? [] : [bold(text)]), ...wanted.map(([as, name]) => newButton(as, name)));
        }
        for (const button of line.querySelectorAll("button")) {
            button.onclick = () => this.decide(cell, button.value);
            this.lock(button);
        }
    }
    lock(button) {
        button.disabled = this.desk.reason !== undefined;
        button.title = this.desk.reason ?? "";
    }
    decide(cell, as) {
        this.fresh = this.fresh.filter((it) => it !== cell);
        this.desk.decide(cell, as);
    }
    goTo(cell) {
        this.map.goTo(cell);
        element("ground", HTMLElement).focus();
    }
    close() {
        [this.fresh, this.withdrawn] = [[], []];
        element("find", HTMLElement).hidden = true;
    }
}
function sentence(mission, object) {
    const place = `${coordinates(mission.hello, mission.where(object.cell))}${within(mission, object.cell)}`;
    const by = object.robot === null ? "" : ` by robot ${object.robot}`;
    return `${place} (cell ${mission.name(object.cell)}) at ${clock(object.since)}${by}, probability ${certainty(object)}`;
}
function certainty(object) {
    return object.probability > 0.999 ? "> 99.9 %" : percent(object.probability);
}
function newRow(body) {
    const row = body.insertRow();
    const [button, picture] = [document.createElement("button"), document.createElement("button")];
    [button.type, button.className] = ["button", "go"];
    [picture.type, picture.className, picture.hidden] = ["button", "picture", true];
    row.insertCell().append(button, picture);
    for (let column = 1; column < 4; column += 1)
        row.insertCell();
    return row;
}
function newLine(place) {
    const line = place.appendChild(document.createElement("div"));
    line.className = "decide";
    return line;
}
function newButton(as, name) {
    const button = document.createElement("button");
    [button.type, button.value, button.textContent] = ["button", as, name];
    return button;
}
function bold(text) {
    const part = document.createElement("b");
    part.textContent = text;
    return part;
}
function write(place, text) {
    if (place !== undefined && place.textContent !== text)
        place.textContent = text;
}
