// Figures and lists beside the map.

import { drawChart } from "./chart.js";
import { robotColor } from "./colors.js";
import { percent } from "./describe.js";
import { type Mission, type RobotFrame, type SubjectFrame, clock, due } from "./mission.js";
import { showSegments } from "./segments.js";

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
  awaited: "… not heard yet",
  lost: "✕ lost",
  searching: "▶ searching",
  paused: "❚❚ paused",
  cleared: "✓ finished",
  spent: "■ budget spent",
  stuck: "▲ cannot move on",
  waiting: "◷ waiting for others",
  returning: "⌂ returning to base",
  recalled: "⌂ called back to base",
  sent: "➤ goes, as ordered",
  holding: "◆ holds until ordered",
  leaving: "➤ leaves a no-go area",
  giving_way: "➤ makes way for others",
};

export function showPanel(mission: Mission, goTo: (cell: number) => void): void {
  const frame = mission.frame;
  if (frame === undefined) return;
  const objects = mission.hello.objects;
  write("name", mission.hello.name);
  document.title = `${mission.hello.name} – Dragnet`;
  write("time", clock(frame.time));
  const sought = (frame.subject?.number ?? 1) > 1 ? `, of ${frame.subject?.number} subjects` : "";
  write("progress-name", objects === null ? `Finds${sought}` : `Found of ${objects} (simulated) objects`);
  write("progress-title", objects === null ? "Finds over time" : "Share of the objects found, over time");
  write("progress", objects === null ? String(frame.declared.length) : percent(frame.progress));
  write("pod", `${(100 * frame.pod).toFixed(0)} %`);
  write("expected", frame.expected.toFixed(frame.subject === undefined ? 1 : 2));
  element("subject", HTMLElement).hidden = frame.subject === undefined;
  if (frame.subject !== undefined) showSubjects(frame.subject);
  write("active", `${frame.robots.filter((robot) => robot.state === "searching").length} of ${frame.robots.length}`);
  write("entropy", `${frame.entropy.toFixed(1)} nats`);
  write("messages", frame.messages.toFixed(1));
  write("observations", String(frame.observations));
  write("marks", String(frame.marks));
  showRobots(mission, frame.robots, goTo);
  drawChart(element("progress-chart", HTMLCanvasElement), mission, 2, objects === null ? undefined : 1);
  if (element("engineering", HTMLDetailsElement).open) {
    drawChart(element("entropy-chart", HTMLCanvasElement), mission, 1, undefined);
    showSegments(mission);
  }
}

/** Updates the table; only changed cells are touched, so that a screen reader keeps its position. */
function showSubjects({ number, found, rest_of_world }: SubjectFrame): void {
  const isOne = number === 1;
  const place = isOne ? "The subject is at a find" : `Of ${number} subjects expected at finds`;
  const text = (count: number): string => (isOne ? `${(100 * count).toFixed(0)} %` : count.toFixed(2));
  write("subject-title", `${place}; outside of the area`);
  write("subject-found", text(found));
  write("rest-of-world", text(rest_of_world));
}

function showRobots(mission: Mission, robots: RobotFrame[], goTo: (cell: number) => void): void {
  const body = element("robots", HTMLTableElement).tBodies[0];
  if (body === undefined) return;
  while (body.rows.length > robots.length) body.deleteRow(-1);
  robots.forEach((robot, index) => {
    const row = body.rows[index] ?? newRow(body);
    const state = robot.is_doubled ? "doubled" : robot.stands_for === null ? robot.state : "stands";
    if (row.dataset["state"] !== state) row.dataset["state"] = state;
    const button = row.cells[0]?.querySelector("button");
    if (button) {
      button.onclick = () => robot.cell !== null && goTo(robot.cell);
      button.disabled = robot.cell === null;
      const title = `Show robot ${robot.robot} on the map`;
      if (button.title !== title) button.title = title;
      if (button.textContent !== String(robot.robot)) {
        button.textContent = String(robot.robot);
        button.style.borderColor = robotColor(robot.robot);
      }
    }
    robotRow(mission, robot).forEach((text, column) => {
      const cell = row.cells[column + 1];
      if (cell !== undefined && cell.textContent !== text) cell.textContent = text;
    });
  });
}

function newRow(body: HTMLTableSectionElement): HTMLTableRowElement {
  const row = body.insertRow();
  const button = document.createElement("button");
  button.type = "button";
  button.className = "sign robot";
  row.insertCell().append(button);
  for (let column = 1; column < 5; column += 1) row.insertCell();
  return row;
}

function robotRow(mission: Mission, robot: RobotFrame): string[] {
  const goal = robot.plan.at(-1);
  const sign = robot.stands_for === null ? SIGNS[robot.state] : `▲ has not moved for ${clock(robot.stands_for)}`;
  return [
    robot.is_doubled ? `⚠ duplicate, ${sign}` : sign,
    robot.cell === null ? "–" : mission.name(robot.cell),
    goal === undefined ? "–" : `${mission.name(goal)} ${due(robot, -1, mission.frame?.time ?? 0)}`.trim(),
    `${robot.meters.toFixed(0)} m`,
  ];
}
