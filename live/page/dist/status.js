import { clock } from "./mission.js";
import { named } from "./orders.js";
import { element } from "./panel.js";
const RESTS = new Set(["cleared", "spent", "stuck", "recalled"]);
const AWAY = new Set(["lost", "awaited"]);
const HELD = new Set(["paused", "holding"]);
export function showStatus(mission, freshness) {
    const isOver = mission?.isOver === true;
    const isStale = !isOver && (freshness.kind === "stale" || freshness.kind === "closed");
    document.body.classList.toggle("stale", isStale && mission !== undefined);
    age(isOver ? { kind: "fresh" } : freshness);
    if (mission === undefined) {
        if (isStale) {
            badge("off", "not connected");
            trouble("The coordinator does not answer; trying again.");
        }
        return;
    }
    trouble([link(mission, freshness), doubles(mission), standing(mission), ending(mission), held(mission)].filter(Boolean).join(" "));
    if (isOver)
        badge("over", "mission over");
    else if (freshness.kind === "closed")
        badge("off", "not connected");
    else if (freshness.kind === "stale")
        badge("off", "stale");
    else if (mission.hello.end !== null)
        badge("replay", "recording");
    else if (freshness.kind === "quiet")
        badge("off", "no reports");
    else if (mission.frame?.ending !== undefined)
        badge("paused", "ending");
    else if (mission.frame?.is_paused === true)
        badge("paused", "paused");
    else if (mission.frame?.is_called_back === true)
        badge("paused", "called back");
    else
        badge("live", "live");
}
function link(mission, freshness) {
    if (mission.isOver)
        return over(mission, freshness);
    if (freshness.kind === "fresh")
        return "";
    const since = freshness.since.toLocaleTimeString(undefined, { hour12: false });
    if (freshness.kind === "quiet") {
        return `The link works, but no robot has reported since ${since}.`;
    }
    const goOn = mission.hello.end === null ? " The robots continue to search." : "";
    const source = mission.hello.end === null ? "the coordinator" : "the program with the recording";
    return `No news from ${source} since ${since}. The page shows what was known then: ${last(mission)}.${goOn}`;
}
function over(mission, freshness) {
    const awaited = mission.frame?.ending ?? [];
    const without = awaited.length === 0 ? "" : `The mission was ended without ${named(awaited)}. `;
    return without + (freshness.kind === "closed" ? `The page shows its end: ${last(mission)}.` : "");
}
function last(mission) {
    const { time, robots, declared } = mission.frame ?? { time: 0, robots: [], declared: [] };
    const count = (number, what) => `${number} ${what}${number === 1 ? "" : "s"}`;
    return `mission time ${clock(time)}, ${count(robots.length, "robot")}, ${count(declared.length, "find")}`;
}
function doubles(mission) {
    const numbers = (mission.frame?.robots ?? []).filter((robot) => robot.is_doubled).map((robot) => robot.robot);
    if (numbers.length === 0)
        return "";
    const each = numbers.map((number) => `Two robots have the number ${number}.`).join(" ");
    return `${each} The one that started later is stopped: give it its own number, or shut it down.`;
}
function standing(mission) {
    if (mission.isOver || mission.hello.end !== null)
        return "";
    const robots = (mission.frame?.robots ?? []).filter(({ stands_for }) => stands_for !== null);
    if (robots.length === 0)
        return "";
    const [have, their] = robots.length === 1 ? ["has", "its"] : ["have", "their"];
    const who = named(robots.map(({ robot }) => robot)).replace(/^r/, "R");
    return `${who} ${have} not moved for over a minute: see that nothing is in ${their} way.`;
}
function ending(mission) {
    const awaited = mission.frame?.ending;
    if (awaited === undefined || mission.isOver || mission.hello.end !== null)
        return "";
    const away = (mission.frame?.robots ?? []).filter(({ robot, state }) => awaited.includes(robot) && AWAY.has(state)).map(({ robot }) => robot);
    const are = (robots) => (robots.length === 1 ? "is" : "are");
    const lost = away.length === 0 ? "" : ` Out of reach ${are(away)} ${named(away)}.`;
    if (awaited.length > 0)
        return `The mission ends once ${named(awaited)} ${are(awaited)} back.${lost}`;
    return "All robots are back from the mission that was ended: resume them, or end it now.";
}
function held(mission) {
    const here = (mission.frame?.robots ?? []).filter(({ state }) => !AWAY.has(state));
    const waits = here.filter(({ state }) => HELD.has(state)).map((robot) => robot.robot);
    const isOver = waits.length < here.length && here.every(({ state }) => HELD.has(state) || RESTS.has(state));
    if (mission.isOver || mission.hello.end !== null || waits.length === 0 || !isOver)
        return "";
    const [are, they] = waits.length === 1 ? ["is", "it"] : ["are", "them"];
    return `The search waits for ${named(waits)}, which ${are} held by your order: resume ${they}, or call ${they} back.`;
}
function trouble(text) {
    element("alert", HTMLElement).hidden = text === "";
    const place = element("trouble", HTMLElement);
    if (place.textContent !== text)
        place.textContent = text;
}
function age(freshness) {
    const seconds = freshness.kind === "fresh" ? 0 : (Date.now() - freshness.since.getTime()) / 1000;
    element("age", HTMLElement).textContent = freshness.kind === "fresh" ? "" : `${clock(seconds)} ago`;
}
function badge(is, text) {
    const place = element("state", HTMLElement);
    place.dataset["is"] = is;
    if (place.textContent !== text)
        place.textContent = text;
}
