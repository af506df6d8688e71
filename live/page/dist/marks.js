import { form } from "./form.js";
import { clock } from "./mission.js";
import { element } from "./panel.js";
import { coordinates } from "./place.js";
const TITLES = { clue: "Clue", searched: "Searched by others" };
export class MarkForm {
    dialog = form("mark", () => this.given?.(this.said()));
    given;
    kind = "clue";
    open(kind, place, given) {
        [this.kind, this.given] = [kind, given];
        element("mark-title", HTMLElement).textContent = `${TITLES[kind]}: ${place}`;
        this.offer(["mark-ratio", "mark-radius"], kind === "clue");
        this.offer(["mark-pod"], kind === "searched");
        this.dialog.querySelector("form")?.reset();
        this.dialog.returnValue = "";
        this.dialog.showModal();
        element("mark-note", HTMLInputElement).focus();
    }
    offer(ids, isOffered) {
        for (const id of ids) {
            const field = document.getElementById(id);
            if (field instanceof HTMLInputElement || field instanceof HTMLSelectElement)
                field.disabled = !isOffered;
            const label = field?.closest("label");
            if (label)
                label.hidden = !isOffered;
        }
    }
    said() {
        const note = element("mark-note", HTMLInputElement).value.trim();
        const number = (id) => Number(element(id, HTMLInputElement).value);
        if (this.kind === "searched")
            return { note, pod: number("mark-pod") / 100 };
        return { note, ratio: Number(element("mark-ratio", HTMLSelectElement).value), radius_meters: number("mark-radius") };
    }
}
export function showMarks(mission, map, desk) {
    const marks = [...mission.marks].reverse();
    element("marked-title", HTMLElement).hidden = marks.length === 0;
    const list = element("marked", HTMLUListElement);
    while (list.children.length > marks.length)
        list.lastElementChild?.remove();
    marks.forEach((mark, index) => show(list.children[index] ?? newItem(list), mark, mission, map, desk));
}
function show(item, mark, mission, map, desk) {
    const [place, said, button] = item.children;
    if (!(place instanceof HTMLButtonElement && said instanceof HTMLElement && button instanceof HTMLButtonElement))
        return;
    const cell = cellOf(mission, mark);
    write(place, cell === undefined ? "no cell" : coordinates(mission.hello, mission.middle(cell)));
    place.onclick = () => {
        if (cell === undefined)
            return;
        map.goTo(cell);
        element("ground", HTMLElement).focus();
    };
    write(said, ` ${clock(mark.time)} ${described(mark)} `);
    button.hidden = mission.hello.end !== null;
    button.disabled = desk.reason !== undefined;
    button.title = desk.reason ?? "";
    button.onclick = () => desk.withdraw(mark.id);
}
export function described(mark) {
    const note = mark.note === "" ? "" : `: ${mark.note}`;
    if (mark.pod !== undefined)
        return `searched by others, ${(100 * mark.pod).toFixed(0)} %${note}`;
    const radius = mark.radius_meters ?? 0;
    return `clue, ${mark.ratio} times${radius > 0 ? ` within ${radius} m` : ""}${note}`;
}
function cellOf(mission, mark) {
    if (mark.cell !== undefined)
        return mark.cell;
    const runs = mark.cells ?? [];
    if (runs.length === 0)
        return undefined;
    const middles = runs.map(([first, count]) => mission.middle(first + (count >> 1)));
    const mean = (axis) => middles.reduce((sum, middle) => sum + middle[axis], 0) / middles.length;
    return mission.cellAt([mean(0), mean(1)]);
}
function newItem(list) {
    const item = list.appendChild(document.createElement("li"));
    const [place, said, button] = [document.createElement("button"), document.createElement("span"), document.createElement("button")];
    [place.type, place.className, place.title] = ["button", "go", "Show on the map"];
    [button.type, button.textContent] = ["button", "Withdraw"];
    item.append(place, said, button);
    return item;
}
function write(place, text) {
    if (place.textContent !== text)
        place.textContent = text;
}
