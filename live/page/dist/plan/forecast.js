import { drawAxes } from "../chart.js";
import { robotColor } from "../colors.js";
import { clock } from "../mission.js";
import { element } from "../panel.js";
import { parseNumber } from "./entries.js";
const MOST_ROBOTS = 1000;
export class ForecastView {
    isSet = false;
    constructor(events) {
        element("forecast", HTMLButtonElement).addEventListener("click", () => {
            const robots = enteredRobots();
            if (robots !== undefined)
                events.forecast(robots, Number(element("forecast-missions", HTMLSelectElement).value));
        });
        element("forecast-robots", HTMLInputElement).addEventListener("change", enteredRobots);
        element("cancel", HTMLButtonElement).addEventListener("click", () => events.cancel());
    }
    draw({ plan, review, revision, forecast }, mayChange) {
        const robots = element("forecast-robots", HTMLInputElement);
        if (!this.isSet)
            robots.value = String(Math.max(plan.scenario.robots.count, 4));
        this.isSet = true;
        const isRunning = forecast?.state === "running";
        element("forecast", HTMLButtonElement).disabled = !mayChange || review.problems.length > 0;
        element("cancel", HTMLButtonElement).hidden = !isRunning || !mayChange;
        const bar = element("forecast-progress", HTMLProgressElement);
        bar.hidden = !isRunning;
        if (isRunning)
            [bar.value, bar.max] = [forecast.progress[0], Math.max(forecast.progress[1], 1)];
        const isOld = forecast !== null && forecast.revision !== revision;
        element("forecast-old", HTMLElement).hidden = !isOld || isRunning;
        element("forecast-state", HTMLElement).textContent = forecast === null ? "No forecast yet." : forecast.state === "failed"
            ? `No forecast: ${forecast.why}.`
            : isRunning ? `${forecast.progress[0]} of ${forecast.progress[1]} simulated missions${left(forecast.minutes_left)}.${isOld ? " The plan has changed since they began." : ""}` : "";
        const teams = forecast?.state === "done" ? forecast.teams : [];
        const results = element("forecast-results", HTMLElement);
        results.hidden = teams.length === 0;
        results.classList.toggle("old", isOld);
        if (teams.length > 0)
            show(teams);
    }
}
function enteredRobots() {
    const field = element("forecast-robots", HTMLInputElement);
    const robots = parseNumber(field.value, { isWhole: true, least: 1, most: MOST_ROBOTS });
    const isWrong = typeof robots === "string";
    const said = element("forecast-robots-problem", HTMLElement);
    [said.textContent, said.hidden] = [isWrong ? robots : "", !isWrong];
    field.setAttribute("aria-invalid", String(isWrong));
    return isWrong ? undefined : robots;
}
function left(minutes) {
    if (minutes === null)
        return "";
    return minutes <= 1 ? ", about a minute left" : `, about ${minutes} minutes left`;
}
function show(teams) {
    const body = element("forecast-table", HTMLTableElement).tBodies[0];
    body?.replaceChildren(...teams.map(row));
    const first = teams[0];
    if (first === undefined)
        return;
    const beyond = first.on_map < 1 ? ` ${percent(1 - first.on_map)} of the probability is outside of the area and is never found.` : "";
    element("forecast-note", HTMLElement).textContent =
        `Mean of ${first.missions} simulated missions for each team; in parentheses its 95 % interval, which more missions make narrower.${beyond} Simulations assume that the probabilities and the sensor are as given.`;
    drawCurves(teams, first.budget_seconds);
    drawTeams(teams);
}
function row(team) {
    const made = document.createElement("tr");
    const sign = document.createElement("b");
    [sign.className, sign.textContent] = ["sign robot", String(team.robots)];
    sign.style.borderColor = robotColor(team.robots);
    made.insertCell().append(sign);
    for (const seconds of team.seconds_to)
        made.insertCell().textContent = seconds === null ? "never" : clock(seconds);
    const { mean, low, high } = team.success;
    made.insertCell().textContent = `${percent(mean)} (${(100 * low).toFixed(0)}–${(100 * high).toFixed(0)})`;
    return made;
}
const percent = (share) => `${(100 * share).toFixed(0)} %`;
const LEVELS = [0, 0.5, 0.8, 0.95];
function drawCurves(teams, until) {
    const canvas = element("forecast-chart", HTMLCanvasElement);
    const axes = drawAxes(canvas, { right: until, top: 1, levels: LEVELS, level: percent, ends: ["0:00", clock(until)] });
    for (const team of teams)
        line(axes, team.curve, robotColor(team.robots));
}
function drawTeams(teams) {
    const canvas = element("teams-chart", HTMLCanvasElement);
    const most = Math.max(...teams.map((team) => team.robots), 2);
    const axes = drawAxes(canvas, { left: 1, right: most, top: 1, levels: LEVELS, level: percent, ends: ["1 robot", `${most} robots`] });
    line(axes, teams.map((team) => [team.robots, team.success.mean]), axes.color("--accent"));
    for (const team of teams) {
        line(axes, [[team.robots, team.success.low], [team.robots, team.success.high]], robotColor(team.robots));
        axes.context.beginPath();
        axes.context.arc(axes.x(team.robots), axes.y(team.success.mean), 4, 0, 2 * Math.PI);
        axes.context.fillStyle = robotColor(team.robots);
        axes.context.fill();
    }
}
function line({ context, x, y }, points, color) {
    context.strokeStyle = color;
    context.lineWidth = 2;
    context.beginPath();
    points.forEach(([across, up], index) => (index === 0 ? context.moveTo(x(across), y(up)) : context.lineTo(x(across), y(up))));
    context.stroke();
    context.lineWidth = 1;
}
