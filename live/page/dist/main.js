import { Controls } from "./controls.js";
import { MapView, describe, drawScale } from "./map.js";
import { Mission } from "./mission.js";
import { element, reset, showPanel } from "./panel.js";
import { Player } from "./player.js";
import { Stream } from "./stream.js";
let mission;
let isLost = false;
let isDue = false;
const map = new MapView(element("ground", HTMLElement), element("canvas", HTMLCanvasElement), {
    moved: () => draw(),
    tapped: (spot) => controls.tapped(spot),
});
const controls = new Controls(map, draw);
const stream = new Stream({ received, lost }, controls.token);
const player = new Player(stream);
function received(message) {
    isLost = false;
    if (message.kind === "hello")
        begin(message);
    else if (message.kind === "over")
        over();
    else
        mission?.take(message);
    draw();
}
function begin(hello) {
    mission = new Mission(hello);
    reset();
    document.body.dataset["shows"] = hello.end === null ? "live" : "replay";
    if (hello.end === null)
        void controls.begin();
    else
        player.begin(hello.end);
}
function over() {
    if (mission !== undefined)
        mission.isOver = true;
}
function lost(seconds) {
    isLost = true;
    const again = `trying again in ${seconds} s`;
    trouble(`The connection to the coordinator is lost; ${again}. The page shows the last received state. The robots continue to search.`);
    badge("off", "not connected");
}
function trouble(text) {
    const place = element("trouble", HTMLElement);
    place.hidden = text === undefined;
    if (place.textContent !== (text ?? ""))
        place.textContent = text ?? "";
}
function badge(is, text) {
    const place = element("state", HTMLElement);
    place.dataset["is"] = is;
    if (place.textContent !== text)
        place.textContent = text;
}
function draw() {
    if (isDue)
        return;
    isDue = true;
    requestAnimationFrame(() => {
        isDue = false;
        if (mission?.frame !== undefined)
            show(mission);
    });
}
function show(mission) {
    map.show(mission);
    showPanel(mission);
    const cell = element("cell", HTMLElement);
    if (map.cursor !== undefined) {
        const text = describe(mission, map.cursor);
        if (cell.textContent !== text)
            cell.textContent = text;
    }
    if (mission.hello.end === null)
        controls.update(mission);
    else
        player.update(mission);
    if (!isLost)
        showState(mission);
}
function showState(mission) {
    trouble(doubles(mission));
    if (mission.hello.end !== null)
        badge("replay", "recording");
    else if (mission.isOver)
        badge("over", "mission over");
    else if (mission.frame?.is_paused === true)
        badge("paused", "paused");
    else
        badge("live", "live");
}
function doubles(mission) {
    const numbers = (mission.frame?.robots ?? []).filter((robot) => robot.is_doubled).map((robot) => robot.robot);
    if (numbers.length === 0)
        return undefined;
    const each = numbers.map((number) => `Two robots have the number ${number}.`).join(" ");
    return `${each} The one that started later is stopped: give it its own number, or shut it down.`;
}
drawScale(element("scale", HTMLCanvasElement));
addEventListener("resize", () => {
    drawScale(element("scale", HTMLCanvasElement));
    draw();
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
