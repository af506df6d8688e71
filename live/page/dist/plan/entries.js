const NUMBER = /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i;
export function parseNumber(text, allowed) {
    const { isWhole, isOptional, above = -Infinity, least = -Infinity, most = Infinity } = allowed;
    const trimmed = text.replace(/%\s*$/, "").trim();
    if (trimmed === "")
        return isOptional ? undefined : refusal("A number is missing", allowed);
    const plain = trimmed.replace(",", ".").replace("−", "-");
    const value = NUMBER.test(plain) ? Number(plain) : NaN;
    if (!Number.isFinite(value))
        return refusal(`“${trimmed}” is no number`, allowed);
    const isAllowed = value > above && value >= least && value <= most && (!isWhole || Number.isSafeInteger(value));
    return isAllowed ? value : refusal(`${trimmed} is not possible`, allowed);
}
export function parseQuartiles(text, isOptional) {
    const words = text.split(/[\s,;]+/).filter((word) => word !== "");
    if (words.length === 0 && isOptional)
        return undefined;
    const meters = words.map((word) => (NUMBER.test(word) ? Number(word) : NaN));
    const isAllowed = meters.length === 4 && meters.every((value, index) => value > (meters[index - 1] ?? 0) && value <= 100_000);
    return isAllowed ? meters : "Allowed are four distances in meters, such as 40, 150, 400, 1200: each above the one before, up to 100000 m.";
}
function refusal(what, { isWhole, above, least, most, unit }) {
    const limits = [
        ...(above === undefined ? [] : [` above ${above}`]),
        ...(least === undefined ? [] : [` from ${least}`]),
        ...(most === undefined ? [] : [`${above === undefined ? " to" : ", up to"} ${most}`]),
    ];
    const allowed = `a ${isWhole ? "whole " : ""}number${limits.join("")}${unit === undefined ? "" : ` ${unit}`}`;
    return allowed === "a number" ? `${what}.` : `${what}; allowed is ${allowed}.`;
}
export class Entries {
    changed;
    refused = new Map();
    constructor(changed) {
        this.changed = changed;
    }
    take(id, at, plan, shown, text, value, act) {
        if (typeof value !== "string") {
            this.refused.delete(id);
            act(value);
        }
        else if (plan !== undefined) {
            this.refused.set(id, { at, text, message: value, shown, before: shown(plan) });
            this.changed();
        }
    }
    problems(plan) {
        for (const [id, { shown, before }] of this.refused)
            if (shown(plan) !== before)
                this.refused.delete(id);
        return [...this.refused.values()].map(({ at, message }) => ({ at, message }));
    }
    text(id) {
        return this.refused.get(id)?.text;
    }
    get isEmpty() {
        return this.refused.size === 0;
    }
    clear() {
        this.refused.clear();
        this.changed();
    }
}
