// The page: applies the messages of the stream and draws, at most once per animation frame.

import { Controls } from "./controls.js";
import { MapView, describe, drawScale } from "./map.js";
import { type Frame, type Hello, Mission, type Over } from "./mission.js";
import { element, reset, showPanel } from "./panel.js";
import { Player } from "./player.js";
import { Stream } from "./stream.js";

let mission: Mission | undefined;
let isLost = false;
let isDue = false;

const map = new MapView(element("ground", HTMLElement), element("canvas", HTMLCanvasElement), {
  moved: () => draw(),
  tapped: (spot) => controls.tapped(spot),
});
const controls = new Controls(map, draw);
const stream = new Stream({ received, lost }, controls.token);
const player = new Player(stream);

function received(message: Hello | Frame | Over): void {
  isLost = false;
  if (message.kind === "hello") begin(message);
  else if (message.kind === "over") over();
  else mission?.take(message);
  draw();
}

function begin(hello: Hello): void {
  mission = new Mission(hello);
  reset();
  document.body.dataset["shows"] = hello.end === null ? "live" : "replay";
  if (hello.end === null) void controls.begin();
  else player.begin(hello.end);
}

function over(): void {
  if (mission !== undefined) mission.isOver = true;
}

function lost(seconds: number): void {
  isLost = true;
  const again = `trying again in ${seconds} s`;
  trouble(`The connection to the coordinator is lost; ${again}. The page shows the last received state. The robots continue to search.`);
  badge("off", "not connected");
}

function trouble(text: string | undefined): void {
  const place = element("trouble", HTMLElement);
  place.hidden = text === undefined;
  // An unchanged text is not announced again.
  if (place.textContent !== (text ?? "")) place.textContent = text ?? "";
}

function badge(is: string, text: string): void {
  const place = element("state", HTMLElement);
  place.dataset["is"] = is;
  if (place.textContent !== text) place.textContent = text;
}

function draw(): void {
  if (isDue) return;
  isDue = true;
  requestAnimationFrame(() => {
    isDue = false;
    if (mission?.frame !== undefined) show(mission);
  });
}

function show(mission: Mission): void {
  map.show(mission);
  showPanel(mission);
  const cell = element("cell", HTMLElement);
  if (map.cursor !== undefined) {
    const text = describe(mission, map.cursor);
    if (cell.textContent !== text) cell.textContent = text;
  }
  if (mission.hello.end === null) controls.update(mission);
  else player.update(mission);
  if (!isLost) showState(mission);
}

function showState(mission: Mission): void {
  trouble(doubles(mission));
  if (mission.hello.end !== null) badge("replay", "recording");
  else if (mission.isOver) badge("over", "mission over");
  else if (mission.frame?.is_paused === true) badge("paused", "paused");
  else badge("live", "live");
}

/** Advice about robots with the same number. */
function doubles(mission: Mission): string | undefined {
  const numbers = (mission.frame?.robots ?? []).filter((robot) => robot.is_doubled).map((robot) => robot.robot);
  if (numbers.length === 0) return undefined;
  const each = numbers.map((number) => `Two robots have the number ${number}.`).join(" ");
  return `${each} The one that started later is stopped: give it its own number, or shut it down.`;
}

drawScale(element("scale", HTMLCanvasElement));
addEventListener("resize", () => {
  drawScale(element("scale", HTMLCanvasElement));
  draw();
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
