// Figures and lists beside the map, and announcements for screen readers.

import { drawChart } from "./chart.js";
import { percent } from "./map.js";
import { type Mission, type RobotFrame, clock } from "./mission.js";

export function element<T extends HTMLElement>(id: string, kind: new () => T): T {
  const found = document.getElementById(id);
  if (!(found instanceof kind)) throw new Error(`the page has no ${id}`);
  return found;
}

function write(id: string, text: string): void {
  const place = element(id, HTMLElement);
  if (place.textContent !== text) place.textContent = text;
}

const SIGNS: Record<RobotFrame["state"], string> = {
  awaited: "… awaited",
  lost: "✕ lost",
  searching: "▶ searching",
  paused: "❚❚ paused",
  cleared: "✓ cleared",
  spent: "■ budget spent",
  stuck: "▲ stuck",
  waiting: "◷ waiting for teammates",
};

/** Declared cells at the last update; undefined before the first. */
let known: Set<number> | undefined;

export function reset(): void {
  known = undefined;
}

export function showPanel(mission: Mission): void {
  const frame = mission.frame;
  if (frame === undefined) return;
  const objects = mission.hello.objects;
  const title = objects === null ? "Objects declared" : "Recall (the simulation knows the objects)";
  write("name", mission.hello.name);
  document.title = `${mission.hello.name} – Dragnet`;
  write("time", clock(frame.time));
  write("progress-name", objects === null ? "Objects declared" : `Recall of ${objects} objects`);
  write("progress-title", title);
  write("progress", objects === null ? String(frame.declared.length) : percent(frame.progress));
  write("entropy", `${frame.entropy.toFixed(1)} nats`);
  write("expected", frame.expected.toFixed(2));
  write("messages", frame.messages.toFixed(1));
  write("observations", String(frame.observations));
  write("marks", String(frame.marks));
  rows("robots", frame.robots.map((robot) => [robot.is_doubled ? "doubled" : robot.state, robotRow(mission, robot)]));
  rows("objects", frame.declared.map((object) => [
    "declared",
    [mission.name(object.cell), percent(object.probability), clock(object.since)],
  ]));
  element("none", HTMLElement).hidden = frame.declared.length > 0;
  announce(mission);
  drawChart(element("progress-chart", HTMLCanvasElement), mission, 2, objects === null ? undefined : 1);
  drawChart(element("entropy-chart", HTMLCanvasElement), mission, 1, undefined);
}

function robotRow(mission: Mission, robot: RobotFrame): string[] {
  const goal = robot.plan.at(-1);
  return [
    String(robot.robot),
    robot.is_doubled ? `⚠ duplicate, ${SIGNS[robot.state]}` : SIGNS[robot.state],
    robot.cell === null ? "–" : mission.name(robot.cell),
    goal === undefined ? "–" : mission.name(goal),
    `${robot.meters.toFixed(0)} m`,
  ];
}

/** Updates the rows of a table; only changed cells are touched, so that a screen reader keeps its position. */
function rows(id: string, wanted: [string, string[]][]): void {
  const body = element(id, HTMLTableElement).tBodies[0];
  if (body === undefined) return;
  while (body.rows.length > wanted.length) body.deleteRow(-1);
  wanted.forEach(([state, texts], index) => {
    const row = body.rows[index] ?? body.insertRow();
    if (row.dataset["state"] !== state) row.dataset["state"] = state;
    texts.forEach((text, column) => {
      const cell = row.cells[column] ?? row.insertCell();
      if (cell.textContent !== text) cell.textContent = text;
    });
  });
}

function announce(mission: Mission): void {
  const declared = mission.frame?.declared ?? [];
  const news = known === undefined ? [] : declared.filter((object) => !known?.has(object.cell));
  known = new Set(declared.map((object) => object.cell));
  if (news.length > 0) {
    const cells = news.map((object) => `${mission.name(object.cell)}, ${percent(object.probability)}`);
    write("finds", `Object declared at ${cells.join("; ")}`);
  }
}
