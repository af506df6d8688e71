import { element } from "../panel.js";
import { mgrsOf } from "../place.js";
import { feature, groundOf, written } from "./drawing.js";
import { Entries } from "./entries.js";
import { Fields, hasPlace } from "./fields.js";
import { ForecastView } from "./forecast.js";
import { List } from "./list.js";
import { PlanMap } from "./map.js";
import { Pen } from "./pen.js";
import { Files } from "./save.js";
import { Store, sentence } from "./store.js";
let selected;
let isFirst = true;
const store = new Store({ changed: draw, said });
const entries = new Entries(draw);
const change = (act) => void store.change(act);
const map = new PlanMap(element("ground", HTMLElement), {
    tapped: (at) => pen.tapped(at),
    hovered,
    selected: select,
    changed: (index, by) => change((plan) => {
        const it = plan.features[index];
        if (it !== undefined)
            by(it);
    }),
});
const pen = new Pen(map, {
    drawn: (kind, corners) => {
        selected = store.state?.plan.features.length;
        void store.change((plan) => plan.features.push(feature(kind, corners, plan.features))).then(() => {
            if (kind === "prior" || kind === "last_known_position")
                document.getElementById(`poa-${selected}`)?.focus();
        });
    },
    said,
});
const list = new List(entries, { select, show: (index) => withFeature(index, (it) => map.show(it)), change });
const fields = new Fields(entries, change);
const forecast = new ForecastView({
    forecast: (robots, missions) => void store.forecast(robots, missions),
    cancel: () => void store.cancel(),
});
const files = new Files({
    opened: (name, content, replaces) => {
        selected = undefined;
        void store.import(name, content, replaces).then(() => map.whole(store.state?.plan.features ?? []));
    },
    save: (overwrite, refused) => void store.save(overwrite, refused),
    simulate: () => void store.simulate(),
    said,
});
element("whole", HTMLButtonElement).addEventListener("click", () => map.whole(store.state?.plan.features ?? []));
element("undo", HTMLButtonElement).addEventListener("click", () => {
    if (entries.isEmpty)
        void store.undo();
    else
        entries.clear();
});
addEventListener("resize", draw);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
void store.begin();
function withFeature(index, act) {
    const it = store.state?.plan.features[index];
    if (it !== undefined)
        act(it);
}
function select(index) {
    selected = index;
    draw();
}
function said(message, isWrong) {
    const answer = element("answer", HTMLElement);
    answer.textContent = message;
    answer.classList.toggle("problem", isWrong);
}
function hovered(at) {
    const mark = at === undefined ? undefined : mgrsOf([at[1] ?? 0, at[0] ?? 0]);
    element("coordinates", HTMLElement).textContent = at === undefined ? "" : [written(at), mark].filter((it) => it !== undefined).join("   ");
}
function draw() {
    const { state: kept, mayChange } = store;
    if (kept === undefined)
        return;
    const state = { ...kept, review: { ...kept.review, problems: [...entries.problems(kept.plan), ...kept.review.problems] } };
    if (selected !== undefined && selected >= state.plan.features.length)
        selected = undefined;
    element("name", HTMLElement).textContent = state.plan.scenario.name;
    document.title = `${state.plan.scenario.name} – plan – Dragnet`;
    map.draw(state, selected);
    list.draw(state, selected, mayChange);
    fields.draw(state, mayChange);
    forecast.draw(state, mayChange);
    files.draw(state, mayChange);
    element("undo", HTMLButtonElement).disabled = !mayChange || !(store.canUndo || !entries.isEmpty);
    for (const button of document.querySelectorAll("#draw button"))
        button.disabled = !mayChange;
    review(state.review);
    if (isFirst)
        map.whole(state.plan.features, true);
    isFirst = false;
}
function review({ problems, warnings, size, effects }) {
    const ofAll = problems.filter(({ at }) => !hasPlace(at))
        .map(({ at, message }) => (typeof at === "object" && "key" in at ? `${at.key}: ${message}` : message));
    const elsewhere = problems.length - ofAll.length;
    const state = element("state", HTMLElement);
    state.textContent = problems.length === 0 ? "ready" : "not ready yet";
    state.dataset["is"] = problems.length === 0 ? "live" : "off";
    const rest = effects.find(({ name }) => name === null);
    const lines = [
        ...ofAll.map((message) => ({ message: sentence(message), className: "problem" })),
        ...(elsewhere > 0 && ofAll.length === 0 ? [{ message: `${elsewhere} ${elsewhere === 1 ? "entry needs" : "entries need"} a change; see there.`, className: "problem" }] : []),
        ...(size === null ? [] : [{ message: `${size.rows} × ${size.columns} cells, ${size.searched} searched: ${groundOf(size.searched_square_meters)}.`, className: "" }]),
        ...(rest === undefined ? [] : [{
                message: `${Number((100 * (rest.poa ?? 0)).toFixed(1))} % of the probability is ${rest.cells === 0 ? "beyond the map" : "spread over the rest of the search area"}.`, className: "",
            }]),
        ...warnings.map((message) => ({ message: sentence(message), className: "warning" })),
    ];
    element("review", HTMLElement).replaceChildren(...lines.map(({ message, className }) => {
        const line = document.createElement("p");
        [line.textContent, line.className] = [message, className];
        return line;
    }));
}
