import { probability } from "./colors.js";
import { due } from "./mission.js";
export function describe(mission, cell) {
    const robots = (mission.frame?.robots ?? []).filter((robot) => robot.cell === cell);
    const here = robots.map((robot) => `robot ${robot.robot} is here${robot.is_doubled ? ", with a duplicate number" : ""}`);
    const found = (mission.frame?.declared ?? []).find((object) => object.cell === cell);
    const isDismissed = (mission.frame?.dismissed ?? []).some((object) => object.cell === cell);
    const facts = [
        chance(mission, cell),
        found === undefined ? "" : found.operator === "confirmed" ? "found, confirmed by hand" : "found",
        isDismissed ? "a find there was dismissed by hand" : "",
        searched(mission, cell),
        mission.isOutOfReach[cell] === 1 ? "out of reach: no robot can observe it" : "",
        mission.isTraversable[cell] === 1 ? "" : "no-go",
        ["", "skipped by your order", "no-go by your order"][mission.zones.get(cell) ?? 0] ?? "",
        ...here,
        ...expected(mission, cell),
    ];
    return `Cell ${mission.name(cell)}: ${facts.filter((fact) => fact !== "").join(", ")}`;
}
function expected(mission, cell) {
    const { robots, time } = mission.frame ?? { robots: [], time: 0 };
    const planned = robots.filter((robot) => robot.plan.includes(cell) && robot.expected.length > 0);
    return planned.map((robot) => `robot ${robot.robot} expected ${due(robot, robot.plan.indexOf(cell), time)}`);
}
function chance(mission, cell) {
    const level = mission.levels[cell] ?? 0;
    return level === 0 ? "outside the search area" : `probability of an object ${bounded(level)}`;
}
function searched(mission, cell) {
    if (mission.levels[cell] === 0)
        return "";
    const level = mission.searched[cell] ?? 0;
    return level === 0 ? "never looked at" : `searched with a probability of detection of ${level - 1} %`;
}
function bounded(level) {
    if (level === 1)
        return `under ${percent(probability(2))}`;
    if (level === 255)
        return `over ${percent(probability(254))}`;
    return percent(probability(level));
}
export function percent(share) {
    if (share > 0 && share < 0.001)
        return `${(100 * share).toFixed(share < 0.00001 ? 5 : 3)} %`;
    const isEven = share === 0 || share === 1;
    const digits = isEven ? 0 : share < 0.01 || share > 0.99 ? 2 : 1;
    return `${(100 * share).toFixed(digits)} %`;
}
