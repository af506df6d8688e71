import { EndForm } from "./end.js";
import { MarkForm } from "./marks.js";
import { acknowledged } from "./orders.js";
import { element } from "./panel.js";
const BUTTONS = ["pause", "return", "go", "searched", "clue", "area", "corner", "close", "no_go", "skip", "open", "end"];
const TOO_FEW = "An area needs at least three corners";
const MISSING = {
    close: TOO_FEW,
    no_go: TOO_FEW,
    skip: TOO_FEW,
    open: TOO_FEW,
    return: "Called back already",
};
const DRIVES = new Set(["searching", "sent", "returning", "waiting"]);
export class Controls {
    map;
    redraw;
    began;
    mission;
    lock = "checking the token …";
    isConnected = false;
    isDrawing = false;
    form = new MarkForm();
    endForm = new EndForm();
    given;
    token = new URLSearchParams(location.hash.slice(1)).get("token");
    constructor(map, redraw, began) {
        this.map = map;
        this.redraw = redraw;
        this.began = began;
        const act = {
            pause: () => this.pause(),
            return: () => this.order("return"),
            go: () => this.go(),
            searched: () => this.searched(),
            clue: () => this.clue(),
            area: () => this.draw(!this.isDrawing),
            corner: () => this.corner(map.cursorSpot()),
            close: () => this.close("search"),
            no_go: () => this.close("no_go"),
            skip: () => this.close("skip"),
            open: () => this.close("open"),
            end: () => this.end(),
        };
        for (const id of BUTTONS)
            element(id, HTMLButtonElement).addEventListener("click", act[id]);
        element("whom", HTMLSelectElement).addEventListener("change", () => this.show());
        document.addEventListener("keydown", (event) => this.key(event));
    }
    async begin() {
        element("controls", HTMLElement).hidden = false;
        const readOnly = "Read-only: open the address with its token to change the mission.";
        if (this.token === null) {
            this.lock = readOnly;
        }
        else {
            const answer = await fetch("auth", { headers: this.headers() }).catch(() => undefined);
            this.lock = answer?.ok === true ? undefined : `${readOnly} The token in this address is wrong.`;
        }
        this.answer(this.lock ?? "");
        this.show();
    }
    update(mission) {
        this.mission = mission;
        if (mission.isOver && this.lock === undefined) {
            this.lock = "The mission is over.";
            this.draw(false);
            this.answer(this.lock);
        }
        this.acknowledge(mission);
        this.show();
    }
    acknowledge(mission) {
        const { what, time, robot } = this.given ?? { what: "", time: 0, robot: null };
        const order = mission.orders.find((it) => it.what === what && it.robot === robot && it.time >= time);
        const text = order === undefined ? "" : sentence(acknowledged(mission, order));
        const place = element("acknowledged", HTMLElement);
        place.hidden = text === "";
        if (place.textContent !== text)
            place.textContent = text;
    }
    connect(isConnected) {
        if (this.isConnected === isConnected)
            return;
        this.isConnected = isConnected;
        this.show();
    }
    get reason() {
        return this.lock ?? (this.isConnected ? undefined : "Not connected: what the page shows is out of date.");
    }
    get whom() {
        const { value } = element("whom", HTMLSelectElement);
        return value === "" ? null : Number(value);
    }
    get chosen() {
        const robots = this.mission?.frame?.robots ?? [];
        return this.whom === null ? robots : robots.filter((robot) => robot.robot === this.whom);
    }
    get isHeld() {
        const isHeld = ({ order, state }) => order === "pause" || (order !== "resume" && !DRIVES.has(state));
        return this.chosen.length > 0 && this.chosen.every(isHeld);
    }
    offerRobots() {
        const robots = this.mission?.frame?.robots ?? [];
        element("whom-choice", HTMLElement).hidden = robots.length < 2;
        const select = element("whom", HTMLSelectElement);
        if (select.options.length === robots.length + 1)
            return;
        const chosen = select.value;
        while (select.options.length > 1)
            select.remove(1);
        for (const { robot } of robots)
            select.add(new Option(`robot ${robot}`, String(robot)));
        select.value = chosen;
    }
    get one() {
        return this.chosen.length === 1 ? this.chosen[0]?.robot : undefined;
    }
    show() {
        this.offerRobots();
        const isClosable = this.map.corners.length > 2;
        const hasCursor = this.map.cursor !== undefined;
        const missing = { ...MISSING, ...(this.one === undefined ? { go: "Choose one robot first" } : {}) };
        const needs = {
            pause: true,
            return: this.chosen.some((robot) => robot.order !== "return"),
            go: hasCursor && this.one !== undefined,
            searched: this.isDrawing ? isClosable : hasCursor,
            clue: hasCursor,
            area: true,
            corner: hasCursor,
            close: isClosable,
            no_go: isClosable,
            skip: isClosable,
            open: isClosable,
            end: true,
        };
        for (const id of BUTTONS) {
            const button = element(id, HTMLButtonElement);
            button.disabled = this.reason !== undefined || !needs[id];
            button.title = this.reason ?? (needs[id] ? "" : missing[id] ?? "Choose a cell first");
        }
        const pause = element("pause", HTMLButtonElement);
        const whom = this.whom === null ? "all robots" : `robot ${this.whom}`;
        const text = `${this.isHeld ? "Resume" : "Pause"} ${whom}`;
        if (pause.textContent !== text)
            pause.textContent = text;
        const end = element("end", HTMLButtonElement);
        end.textContent = this.mission?.frame?.ending === undefined ? "End mission" : "End now";
        end.hidden = this.isDrawing;
        element("area", HTMLButtonElement).setAttribute("aria-pressed", String(this.isDrawing));
        for (const id of ["corner", "close", "no_go", "skip", "open"])
            element(id, HTMLButtonElement).hidden = !this.isDrawing;
    }
    tapped(spot) {
        if (this.isDrawing)
            this.corner(spot);
    }
    key(event) {
        const target = event.target;
        const isTyping = target instanceof HTMLSelectElement;
        if (this.reason !== undefined || isTyping || event.ctrlKey || event.altKey || event.metaKey)
            return;
        const act = {
            P: () => event.shiftKey && this.pause(),
            g: () => this.go(),
            s: () => this.searched(),
            c: () => this.clue(),
            a: () => this.draw(!this.isDrawing),
            f: () => this.close("search"),
            n: () => this.close("no_go"),
            k: () => this.close("skip"),
            o: () => this.close("open"),
            Escape: () => this.draw(false),
        };
        const isOnMap = target instanceof HTMLElement && target.id === "ground";
        if (event.key === "Enter" && isOnMap)
            this.corner(this.map.cursorSpot());
        else
            act[event.key]?.();
    }
    pause() {
        this.order(this.isHeld ? "resume" : "pause");
    }
    order(command) {
        const robot = this.whom;
        void this.ask(robot === null ? { command } : { command, robot }, command, robot);
    }
    end() {
        const isNow = this.mission?.frame?.ending !== undefined;
        this.endForm.open(this.mission, () => void this.ask({ command: "end", now: isNow }, "end"));
    }
    go() {
        const robot = this.one;
        if (robot === undefined || this.map.cursor === undefined || this.mission === undefined) {
            this.answer("Choose one robot, and a cell on the map, first.");
            return;
        }
        const [row, column] = this.mission.place(this.map.cursor);
        void this.ask({ command: "go", robot, row, column }, "go", robot);
    }
    clue() {
        const at = this.chosenCell();
        if (at === undefined)
            return;
        const [row, column] = at;
        this.mark("clue", `cell [${row}, ${column}]`, { row, column });
    }
    searched() {
        if (this.isDrawing) {
            const corners = this.closed();
            if (corners !== undefined)
                this.mark("searched", "the area", { corners });
            return;
        }
        const at = this.chosenCell();
        if (at === undefined)
            return;
        const [row, column] = at;
        const corners = [[column, row], [column + 1, row], [column + 1, row + 1], [column, row + 1]];
        this.mark("searched", `cell [${row}, ${column}]`, { corners });
    }
    mark(kind, place, where) {
        this.form.open(kind, place, (said) => void this.ask({ command: kind, ...where, ...said }, kind));
    }
    withdraw(mark) {
        void this.ask({ command: "withdraw", mark }, "withdraw");
    }
    chosenCell() {
        if (this.map.cursor !== undefined && this.mission !== undefined)
            return this.mission.place(this.map.cursor);
        this.answer("Choose a cell on the map first.");
        return undefined;
    }
    decide(cell, as) {
        if (this.mission === undefined)
            return;
        const [row, column] = this.mission.place(cell);
        void this.ask({ command: "find", row, column, as }, as);
    }
    draw(isDrawing) {
        if (this.isDrawing !== isDrawing && isDrawing)
            this.began();
        this.isDrawing = isDrawing;
        this.map.corners = [];
        this.answer(isDrawing ? "Tap the corners of the area, or move the cursor and press Enter at each; then say what it is." : "");
        this.show();
        this.redraw();
    }
    corner(spot) {
        if (!this.isDrawing || spot === undefined)
            return;
        const { rows, columns } = this.mission?.hello ?? { rows: 0, columns: 0 };
        const within = (value, most) => Math.min(Math.max(value, 0), most);
        this.map.corners.push([within(spot[0], columns), within(spot[1], rows)]);
        const count = this.map.corners.length;
        this.answer(`${count} corner${count === 1 ? "" : "s"}.`);
        this.show();
        this.redraw();
    }
    closed() {
        const corners = this.map.corners;
        if (corners.length > 2) {
            this.draw(false);
            return corners;
        }
        this.answer(`${TOO_FEW}.`);
        return undefined;
    }
    close(use) {
        const corners = this.isDrawing ? this.closed() : undefined;
        if (corners === undefined)
            return;
        if (use === "search")
            void this.ask({ command: "search", corners }, "area");
        else
            void this.ask({ command: "zone", corners, as: use }, use);
    }
    headers() {
        return { Authorization: `Bearer ${this.token ?? ""}` };
    }
    async ask(command, what, robot = null) {
        if (this.reason !== undefined)
            return;
        this.given = { what, time: this.mission?.frame?.time ?? 0, robot };
        try {
            const answer = await fetch("command", { method: "POST", headers: this.headers(), body: JSON.stringify(command) });
            const { message, error } = (await answer.json());
            this.answer(message ?? `Not done: ${error ?? answer.statusText}.`);
        }
        catch {
            this.answer("Not done: the coordinator cannot be reached.");
        }
    }
    answer(text) {
        element("answer", HTMLElement).textContent = text;
    }
}
function sentence(text) {
    return `${text.charAt(0).toUpperCase()}${text.slice(1)}.`;
}
