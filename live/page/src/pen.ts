// Draws tracks, plans, finds and other markers over the map.

import { robotColor } from "./colors.js";
import { type Mission, type RobotFrame, type Spot, due } from "./mission.js";
import { spread } from "./spread.js";
import type { View } from "./view.js";

/** From this number of robots on their lines are thinner. */
const CROWD = 9;

/** Draws markers at cells. */
export class Pen {
  constructor(
    private readonly context: CanvasRenderingContext2D,
    private readonly mission: Mission,
    private readonly view: View,
  ) {}

  private middle(cell: number): Spot {
    return this.view.at(this.mission.middle(cell));
  }

  private get robots(): RobotFrame[] {
    return this.mission.frame?.robots ?? [];
  }

  /** Size of markers, which hardly shrink with the map. */
  private get sign(): number {
    return Math.min(Math.max(this.view.size * 0.85, 12), 16);
  }

  /** Hatches no-go cells, if they are large enough. */
  hatch(): void {
    const { context, mission, view } = this;
    if (view.size < 4) return;
    context.strokeStyle = "rgba(60, 66, 76, 0.75)";
    context.lineWidth = Math.max(1, view.size / 14);
    context.beginPath();
    for (const cell of mission.blocked) {
      const [row, column] = mission.place(cell);
      const [x, y] = view.at([column, row]);
      if (x < -view.size || y < 0 || x > view.width || y > view.height + view.size) continue;
      context.moveTo(x, y);
      context.lineTo(x + view.size, y - view.size);
    }
    context.stroke();
  }

  /** The operator's zones: no-go is crossed in red, skipped is striped the other way than no-go ground. */
  zones(): void {
    const { context, mission, view } = this;
    const size = view.size;
    const [crossed, striped] = [new Path2D(), new Path2D()];
    for (const [cell, zone] of mission.zones) {
      const [row, column] = mission.place(cell);
      const [x, y] = view.at([column, row]);
      if (x < -size || y < 0 || x > view.width || y > view.height + size) continue;
      context.fillStyle = zone === 2 ? "rgba(200, 30, 40, 0.35)" : "rgba(255, 255, 255, 0.35)";
      context.fillRect(x, y - size, size, size);
      const lines = zone === 2 ? crossed : striped;
      lines.moveTo(x, y - size);
      lines.lineTo(x + size, y);
      if (zone !== 2) continue;
      lines.moveTo(x, y);
      lines.lineTo(x + size, y - size);
    }
    if (size < 4) return;
    context.lineWidth = Math.max(1, size / 14);
    context.strokeStyle = "rgba(165, 15, 30, 0.9)";
    context.stroke(crossed);
    context.strokeStyle = "rgba(40, 44, 52, 0.75)";
    context.stroke(striped);
  }

  tracks(): void {
    for (const robot of this.robots) this.line(this.mission.trails.get(robot.robot) ?? [], robot, []);
  }

  plans(): void {
    for (const robot of this.robots) {
      this.line(robot.cell === null ? robot.plan : [robot.cell, ...robot.plan], robot, [5, 4]);
      const goal = robot.plan.at(-1);
      if (goal === undefined) continue;
      const [x, y] = this.middle(goal);
      this.context.beginPath();
      this.context.arc(x, y, this.sign / 3, 0, 2 * Math.PI);
      this.casing(robotColor(robot.robot), 2, []);
      if (this.robots.length < CROWD) this.label(due(robot, -1, this.mission.frame?.time ?? 0), x, y - this.sign / 2);
    }
  }

  /** A text above a point, with a white edge. */
  private label(text: string, x: number, y: number): void {
    const { context } = this;
    context.font = "600 12px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "bottom";
    context.lineJoin = "round";
    context.lineWidth = 3;
    context.strokeStyle = "rgba(255, 255, 255, 0.85)";
    context.strokeText(text, x, y);
    context.fillStyle = "#111111";
    context.fillText(text, x, y);
  }

  private line(cells: number[], robot: RobotFrame, dash: number[]): void {
    if (cells.length < 2) return;
    this.trace(cells.map((cell) => this.middle(cell)));
    this.casing(robotColor(robot.robot), this.robots.length < CROWD ? 2.5 : 1.5, dash);
  }

  private trace(points: Spot[]): void {
    this.context.beginPath();
    points.forEach(([x, y], index) => (index === 0 ? this.context.moveTo(x, y) : this.context.lineTo(x, y)));
  }

  /** Strokes the current canvas path, with a white edge that contrasts with any ground. */
  private casing(color: string, width: number, dash: number[]): void {
    const { context } = this;
    context.lineJoin = "round";
    context.lineCap = dash.length > 0 ? "butt" : "round";
    context.setLineDash(dash);
    context.strokeStyle = "rgba(255, 255, 255, 0.85)";
    context.lineWidth = width + Math.min(2, width);
    context.stroke();
    context.strokeStyle = color;
    context.lineWidth = width;
    context.stroke();
    context.setLineDash([]);
  }

  finds(): void {
    const { context, mission, view } = this;
    for (const object of mission.frame?.declared ?? []) {
      const [x, y] = view.at(mission.where(object.cell));
      if (object.position !== undefined) {
        context.beginPath();
        context.arc(x, y, (object.position.accuracy_meters / mission.hello.cell_meters) * view.size, 0, 2 * Math.PI);
        this.casing("#c2410c", 1.5, [4, 3]);
      }
      const half = this.sign * 0.72;
      this.trace([[x, y - half], [x + half, y], [x, y + half], [x - half, y]]);
      context.closePath();
      context.fillStyle = "rgba(255, 255, 255, 0.9)";
      context.fill();
      this.casing("#c2410c", 2.5, []);
      if (object.operator === "confirmed") this.tick(x, y, half / 2);
    }
  }

  /** Clues, each with its radius. */
  clues(): void {
    const { context, mission, view } = this;
    for (const { cell, radius_meters = 0 } of mission.marks) {
      if (cell === undefined) continue;
      const [x, y] = this.middle(cell);
      const half = this.sign * 0.6;
      context.beginPath();
      context.arc(x, y, (radius_meters / mission.hello.cell_meters) * view.size, 0, 2 * Math.PI);
      this.casing("#6d28d9", 1.5, [4, 3]);
      context.beginPath();
      context.arc(x, y, half, 0, 2 * Math.PI);
      context.fillStyle = "#ffffff";
      context.fill();
      this.casing("#6d28d9", 2, []);
      this.number("!", [x, y], half);
    }
  }

  private tick(x: number, y: number, half: number): void {
    this.trace([[x - half, y], [x - half / 3, y + 0.7 * half], [x + half, y - 0.7 * half]]);
    this.casing("#1d6b3c", 2.5, []);
  }

  /** Robots whose markers would overlap stand beside each other, with a line to where they are. */
  markers(): void {
    const known = this.robots.filter((robot) => robot.cell !== null);
    const places = known.map((robot) => this.middle(robot.cell ?? 0));
    const beside = spread(places, 1.5 * this.sign + 4);
    const pairs = places.map((from, index) => [from, beside[index] ?? from] as const);
    for (const [from, to] of pairs) this.leader(from, to);
    known.forEach((robot, index) => this.marker(robot, beside[index] ?? [0, 0]));
  }

  private leader(from: Spot, to: Spot): void {
    if (from[0] === to[0] && from[1] === to[1]) return;
    this.trace([from, to]);
    this.casing("#111111", 1, []);
  }

  /** A circle with the robot's number: round when it searches, square when it rests or is paused, crossed when lost,
   * ringed when its number is used twice. */
  private marker(robot: RobotFrame, [x, y]: Spot): void {
    const { context } = this;
    const half = this.sign * 0.75;
    context.beginPath();
    if (robot.state === "searching" || robot.state === "lost") context.arc(x, y, half, 0, 2 * Math.PI);
    else context.rect(x - half, y - half, 2 * half, 2 * half);
    context.fillStyle = "#ffffff";
    context.fill();
    context.setLineDash(robot.state === "lost" ? [3, 2] : []);
    context.strokeStyle = robotColor(robot.robot);
    context.lineWidth = 4;
    context.stroke();
    context.setLineDash([]);
    context.strokeStyle = "#111111";
    context.lineWidth = 1.2;
    context.stroke();
    this.number(String(robot.robot), [x, y], half);
    if (robot.is_doubled) this.twice(x, y, half);
    if (robot.state === "lost") this.cross(x, y, half);
    if (robot.state === "paused") this.bars(x + half, y - half);
  }

  private number(text: string, [x, y]: Spot, half: number): void {
    const { context } = this;
    context.fillStyle = "#111111";
    context.font = `600 ${Math.round(half * (text.length < 3 ? 1.2 : 0.9))}px system-ui, sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillText(text, x, y + 0.5);
  }

  /** A second ring, in the color of warnings. */
  private twice(x: number, y: number, half: number): void {
    this.context.beginPath();
    this.context.arc(x, y, 1.5 * half, 0, 2 * Math.PI);
    this.casing("#c2410c", 2.5, []);
  }

  private cross(x: number, y: number, half: number): void {
    this.context.beginPath();
    this.context.moveTo(x - half, y - half);
    this.context.lineTo(x + half, y + half);
    this.context.moveTo(x + half, y - half);
    this.context.lineTo(x - half, y + half);
    this.casing("#111111", 2, []);
  }

  private bars(x: number, y: number): void {
    const { context } = this;
    context.fillStyle = "#ffffff";
    context.fillRect(x - 5, y - 5, 10, 10);
    context.fillStyle = "#111111";
    context.fillRect(x - 3, y - 4, 2.2, 8);
    context.fillRect(x + 0.8, y - 4, 2.2, 8);
  }

  /** The outline of an area that is being drawn. */
  area(corners: Spot[]): void {
    if (corners.length === 0) return;
    const { context } = this;
    const points = corners.map((corner) => this.view.at(corner));
    this.trace(points);
    if (points.length > 2) context.closePath();
    context.fillStyle = "rgba(11, 92, 173, 0.25)";
    context.fill();
    this.casing("#0b5cad", 2, [6, 4]);
    this.handles(points, "#0b5cad");
  }

  /** The line that is measured. */
  measure(spots: Spot[]): void {
    const points = spots.map((spot) => this.view.at(spot));
    this.trace(points);
    this.casing("#111111", 2, []);
    this.handles(points, "#111111");
  }

  private handles(points: Spot[], color: string): void {
    this.context.fillStyle = color;
    for (const [x, y] of points) this.context.fillRect(x - 4, y - 4, 8, 8);
  }

  cursor(cell: number): void {
    const { size } = this.view;
    const [row, column] = this.mission.place(cell);
    const [x, y] = this.view.at([column, row + 1]);
    const grow = Math.max(0, (9 - size) / 2);
    this.context.beginPath();
    this.context.rect(x - grow, y - grow, size + 2 * grow, size + 2 * grow);
    this.casing("#111111", 2, []);
  }
}
