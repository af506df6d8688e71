// The operator's last commands, and which robots are known to have them.

import { type Mission, type OrderFrame, clock } from "./mission.js";
import { element } from "./panel.js";

/** Fills the list of the last commands. */
export function showOrders(mission: Mission): void {
  element("orders-title", HTMLElement).hidden = mission.orders.length === 0;
  const list = element("orders", HTMLUListElement);
  while (list.children.length > mission.orders.length) list.lastElementChild?.remove();
  mission.orders.forEach((order, index) => {
    const item = list.children[index] ?? list.appendChild(document.createElement("li"));
    const text = `${clock(order.time)} ${said(mission, order)}: ${acknowledged(mission, order)}`;
    if (item.textContent !== text) item.textContent = text;
  });
}

function said(mission: Mission, order: OrderFrame): string {
  const cell = order.cell === null ? "" : ` ${mission.name(order.cell)}`;
  const cells = `an area of ${order.cells} cell${order.cells === 1 ? "" : "s"}`;
  const names: Record<OrderFrame["what"], string> = {
    pause: "Pause",
    resume: "Resume",
    return: "Return to base",
    end: "End of the mission",
    go: `Go to${cell}`,
    area: `Search ${cells}`,
    open: `Open again ${cells}`,
    skip: `Skip ${cells}`,
    no_go: `No-go ${cells}`,
    searched: `Searched by others: ${cells}`,
    clue: `Clue${cell}`,
    withdraw: `Mark${cell} withdrawn`,
    confirmed: `Find${cell} confirmed`,
    dismissed: `Find${cell} dismissed`,
    undone: `Decision about find${cell} undone`,
  };
  const name = names[order.what];
  return order.robot === null ? name : `Robot ${order.robot}: ${name}`;
}

/** `robots 1, 3 have it; waiting for 2 (lost)`. */
export function acknowledged(mission: Mission, { has, waits, robot }: OrderFrame): string {
  if (waits.length === 0 && robot !== null) return `robot ${robot} has it`;
  if (waits.length === 0) return has.length === 1 ? "the robot has it" : "all robots have it";
  const lost = new Set((mission.frame?.robots ?? []).filter((robot) => robot.state === "lost").map((robot) => robot.robot));
  const groups = [[waits.filter((robot) => !lost.has(robot)), ""], [waits.filter((robot) => lost.has(robot)), " (lost)"]] as const;
  const waiting = groups.filter(([robots]) => robots.length > 0).map(([robots, note]) => `${numbers(robots)}${note}`).join(", ");
  if (has.length === 0) return `waiting for robot${waits.length === 1 ? "" : "s"} ${waiting}`;
  return `${named(has)} ${has.length === 1 ? "has" : "have"} it; waiting for ${waiting}`;
}

/** `robot 2`, or `robots 2, 4–7`. */
export function named(robots: readonly number[]): string {
  return `robot${robots.length === 1 ? "" : "s"} ${numbers(robots)}`;
}

/** Ascending numbers, with runs of more than two as `4–17`. */
export function numbers(robots: readonly number[]): string {
  const runs: [number, number][] = [];
  for (const robot of robots) {
    const last = runs.at(-1);
    if (last !== undefined && last[1] + 1 === robot) last[1] = robot;
    else runs.push([robot, robot]);
  }
  return runs.flatMap(([from, to]) => (to - from > 1 ? [`${from}–${to}`] : to > from ? [`${from}`, `${to}`] : [`${from}`])).join(", ");
}
