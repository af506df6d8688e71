import { robotColor } from "../colors.js";
import { element } from "../panel.js";
import { KINDS, closed, kindOf, kindsOf, lines, parseCorners, parsePosition, written } from "./drawing.js";
import { parseNumber, parseQuartiles } from "./entries.js";
import { sentence } from "./store.js";
const POA = { isOptional: true, least: 0, most: 100, unit: "%" };
const LIKELY = new Set(["prior", "last_known_position", "linear_feature"]);
const SPREAD = { above: 0, most: 100_000, unit: "m" };
export class List {
    entries;
    events;
    list = element("features", HTMLUListElement);
    plan;
    constructor(entries, events) {
        this.entries = entries;
        this.events = events;
    }
    draw(state, selected, mayChange) {
        this.plan = state.plan;
        const focused = document.activeElement instanceof HTMLElement && this.list.contains(document.activeElement) ? document.activeElement : undefined;
        const { features } = state.plan;
        let starts = 0;
        const rows = features.map((feature, index) => {
            if (kindOf(feature) === "start")
                starts += 1;
            const row = this.row(state, feature, index, starts);
            if (index === selected)
                row.append(this.form(feature, index, mayChange));
            return row;
        });
        this.list.replaceChildren(...rows);
        if (focused !== undefined)
            resume(focused);
        element("no-features", HTMLElement).hidden = features.length > 0;
    }
    row(state, feature, index, start) {
        const row = document.createElement("li");
        const kind = kindOf(feature);
        const button = make("button", feature.properties?.name ?? "(no name)");
        button.type = "button";
        button.id = `feature-${index}`;
        button.className = `feature ${kind}`;
        button.addEventListener("click", () => {
            this.events.select(index);
            this.events.show(index);
        });
        if (kind === "start") {
            const isUsed = start <= state.plan.scenario.robots.count;
            const sign = make("b", isUsed ? String(start) : "");
            sign.className = "sign robot";
            if (isUsed)
                sign.style.borderColor = robotColor(start);
            button.prepend(sign);
        }
        row.append(button, make("span", this.effect(state, feature, start), "effect"));
        const problems = state.review.problems.filter(({ at }) => typeof at === "object" && "feature" in at && at.feature === index);
        row.append(...problems.map(({ message }) => make("p", sentence(message), "problem")));
        return row;
    }
    effect(state, feature, start) {
        const kind = kindOf(feature);
        const { count } = state.plan.scenario.robots;
        if (kind === "start")
            return start > count ? "no robot starts here" : `start of robot ${start}`;
        const isOf = (effect) => effect.name === feature.properties?.name && (effect.kind === kind || (effect.kind === "prior" && kind === "last_known_position"));
        const cells = state.review.effects.find(isOf)?.cells;
        const poa = feature.properties?.poa;
        const parts = [
            KINDS[kind].toLowerCase(),
            ...(poa === undefined ? [] : [`${Number((100 * poa).toFixed(1))} %`]),
            ...(cells === undefined ? [] : [kind === "no_go" ? `closes ${cells} cells` : `${cells} cells`]),
        ];
        return parts.join(", ");
    }
    form(feature, index, mayChange) {
        const form = document.createElement("fieldset");
        form.disabled = !mayChange;
        const kind = kindOf(feature);
        const set = (act) => this.events.change((plan) => {
            const it = plan.features[index];
            if (it !== undefined)
                act(it);
        });
        const property = (values) => set((it) => (it.properties = { ...it.properties, ...values }));
        form.append(input(`name-${index}`, "Name", feature.properties?.name ?? "", (value) => property({ name: value })));
        form.append(choice(`kind-${index}`, "What it is", kindsOf(feature), kind, (value) => set((it) => turn(it, value))));
        if (LIKELY.has(kind)) {
            const { poa } = feature.properties ?? {};
            const shown = poa === undefined ? "" : String(Number((100 * poa).toFixed(4)));
            form.append(this.entry(index, `poa-${index}`, "Probability that the person or object is here, %", shown, (text) => parseNumber(text, POA), (value) => property({ poa: value === undefined ? undefined : Number((value / 100).toFixed(9)) })));
        }
        const { quartiles_meters } = feature.properties ?? {};
        if (kind === "last_known_position" && quartiles_meters === undefined) {
            const spread = feature.properties?.spread_meters;
            form.append(this.entry(index, `spread-${index}`, "Within how many meters (39 % of the probability)", spread === undefined ? "" : String(spread), (text) => parseNumber(text, SPREAD), (value) => property({ spread_meters: value })));
        }
        if (kind === "last_known_position" || kind === "linear_feature") {
            const isPoint = kind === "last_known_position";
            const label = `${isPoint ? "Or w" : "W"}ithin how many meters 25, 50, 75 and 95 % are found`;
            form.append(this.entry(index, `quartiles-${index}`, label, (quartiles_meters ?? []).join(", "), (text) => parseQuartiles(text, isPoint), (value) => property({ quartiles_meters: value, ...(isPoint ? { spread_meters: value === undefined ? 200 : undefined } : {}) })));
        }
        this.coordinates(form, feature, index, set);
        const remove = make("button", "Delete");
        remove.type = "button";
        remove.id = `delete-${index}`;
        remove.addEventListener("click", () => {
            this.events.select(undefined);
            this.events.change((plan) => plan.features.splice(index, 1));
        });
        form.append(remove);
        return form;
    }
    entry(index, id, label, shown, parse, act) {
        return input(id, label, this.entries.text(id) ?? shown, (text) => this.enter(index, id, text, parse(text), act));
    }
    enter(index, id, text, value, act) {
        this.entries.take(id, { feature: index }, this.plan, (plan) => JSON.stringify(plan.features[index]), text, value, act);
    }
    coordinates(form, feature, index, set) {
        const { geometry } = feature;
        if (geometry?.type === "Point") {
            form.append(this.entry(index, `at-${index}`, "Latitude, longitude", written(geometry.coordinates), parsePosition, (at) => set((it) => (it.geometry = { type: "Point", coordinates: at }))));
            return;
        }
        const all = lines(geometry);
        const [only] = all;
        if (only === undefined || all.length !== 1)
            return;
        const corners = only.isRing ? only.corners.slice(0, -1) : only.corners;
        const label = make("label", "Corners: latitude, longitude, one in each line");
        const area = document.createElement("textarea");
        const id = `corners-${index}`;
        [area.id, area.rows, area.defaultValue] = [id, Math.min(corners.length + 1, 8), this.entries.text(id) ?? corners.map(written).join("\n")];
        area.addEventListener("change", () => this.enter(index, id, area.value, parseCorners(area.value, only.isRing), (positions) => set((it) => {
            const line = lines(it.geometry)[0];
            line?.corners.splice(0, line.corners.length, ...(line.isRing ? closed(positions) : positions));
        })));
        label.append(area);
        form.append(label);
    }
}
function turn(feature, kind) {
    const { name, poa, spread_meters } = feature.properties ?? {};
    const isLikely = LIKELY.has(kind);
    feature.properties = {
        ...(name === undefined ? {} : { name }), kind,
        ...(isLikely && poa !== undefined ? { poa } : {}),
        ...(kind === "last_known_position" ? { spread_meters: spread_meters ?? 200 } : {}),
    };
}
function resume(before) {
    const now = document.getElementById(before.id);
    now?.focus();
    const isText = (it) => it instanceof HTMLInputElement || it instanceof HTMLTextAreaElement;
    if (!isText(now) || !isText(before) || before.value === before.defaultValue)
        return;
    now.value = before.value;
    now.setSelectionRange(before.selectionStart, before.selectionEnd);
    let isReported = false;
    now.addEventListener("change", () => (isReported = true));
    now.addEventListener("blur", () => {
        if (!isReported)
            now.dispatchEvent(new Event("change"));
    });
}
function make(tag, text, className = "") {
    const made = document.createElement(tag);
    made.textContent = text;
    if (className !== "")
        made.className = className;
    return made;
}
function input(id, label, value, changed) {
    const [around, field] = [make("label", label), document.createElement("input")];
    [field.id, field.defaultValue] = [id, value];
    field.addEventListener("change", () => changed(field.value));
    around.append(field);
    return around;
}
function choice(id, label, kinds, value, changed) {
    const [around, select] = [make("label", label), document.createElement("select")];
    select.id = id;
    for (const kind of kinds)
        select.add(new Option(KINDS[kind], kind, false, kind === value));
    select.addEventListener("change", () => changed(select.value));
    around.append(select);
    return around;
}
