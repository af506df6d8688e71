// The page: applies the messages of the stream and draws, at most once per animation frame.

import { Controls } from "./controls.js";
import { Finds } from "./finds.js";
import { Watch } from "./fresh.js";
import { Layers } from "./layers.js";
import { MapView } from "./map.js";
import { showMarks } from "./marks.js";
import { showOrders } from "./orders.js";
import { Measure } from "./measure.js";
import { type Hello, type Message, Mission, type Spot } from "./mission.js";
import { element, showPanel } from "./panel.js";
import { Player } from "./player.js";
import { Readout } from "./readout.js";
import { Sound } from "./sound.js";
import { showStatus } from "./status.js";
import { Stream } from "./stream.js";

let mission: Mission | undefined;
let isDue = false;

const readout = new Readout();
const layers = new Layers(draw);
const map = new MapView(element("ground", HTMLElement), { changed: draw, tapped, hovered });
const measure = new Measure(() => map.cursorSpot(), () => {
  if (measure.isOn && controls.isDrawing) controls.draw(false);
  draw();
});
const controls = new Controls(map, draw, () => measure.turn(false));
const finds = new Finds(map, new Sound(), controls);
const watch = new Watch({ changed: draw, dead: () => stream.reopen() });
const stream = new Stream({ received, lost }, controls.token);
const player = new Player(stream);

function received(message: Message): void {
  watch.hear(message.kind === "beat" ? message.quiet_seconds : 0);
  if (message.kind === "hello") begin(message);
  else if (message.kind === "over" && mission !== undefined) mission.isOver = true;
  else if (message.kind === "frame" && mission !== undefined) {
    mission.take(message);
    finds.take(mission, message);
  }
  draw();
}

function begin(hello: Hello): void {
  mission = new Mission(hello);
  document.body.dataset["shows"] = hello.end === null ? "live" : "replay";
  layers.begin(hello);
  finds.begin(hello);
  map.begin(mission);
  if (hello.end === null) void controls.begin();
  else player.begin(hello.end, hello.finds);
}

function lost(): void {
  watch.close();
  draw();
}

function tapped(spot: Spot): void {
  if (measure.isOn) measure.add(spot);
  else controls.tapped(spot);
}

function hovered(spot: Spot | undefined, pixels: Spot): void {
  readout.hover(spot, pixels);
  draw();
}

function draw(): void {
  if (isDue) return;
  isDue = true;
  requestAnimationFrame(() => {
    isDue = false;
    const { freshness } = watch;
    showStatus(mission, freshness);
    controls.connect(freshness.kind === "fresh" || freshness.kind === "quiet");
    if (mission?.frame !== undefined) show(mission);
  });
}

function show(mission: Mission): void {
  map.measured = measure.points;
  map.draw(mission, layers.choice);
  showPanel(mission, (cell) => map.goTo(cell));
  finds.show(mission);
  showMarks(mission, map, controls);
  showOrders(mission);
  readout.show(mission, map.cursor);
  const measured = element("measured", HTMLElement);
  measured.textContent = measure.text(mission);
  if (mission.hello.end === null) controls.update(mission);
  else player.update(mission);
}

function restyle(): void {
  layers.show();
  draw();
}

addEventListener("resize", restyle);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", restyle);
element("engineering", HTMLDetailsElement).addEventListener("toggle", draw);
