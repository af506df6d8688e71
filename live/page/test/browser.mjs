// The page in a real browser. Called by tests/live: `node browser.mjs CASE ADDRESS FOLDER`, with the address that the
// program printed and a folder for screenshots; exit code 0 if all holds.

import assert from "node:assert/strict";

import { utmOf } from "../dist/place.js";
import { spread } from "../dist/spread.js";
import { basemap, planOnBasemap } from "./basemap.mjs";
import {
  address, answered, bare, browse, cells, link, marks, moveTo, name, picture, probability, seconds, settle, shot, states, text,
  until,
} from "./browse.mjs";
import { cutOff, finds, pictured } from "./finds.mjs";
import { plan, planPhone } from "./planning.mjs";
import { replay, sound } from "./recording.mjs";

/** Screens that rescuers have: a phone, a tablet, a laptop. */
const SCREENS = [[390, 844], [1024, 768], [1440, 900]];

/** Robots move, stop when paused and go on; marks and areas count; all of it by keys alone. */
async function live() {
  // An area without new cells is rejected.
  await browse(address, { expected: [/status of 422/] }, async (page) => {
    const first = await cells(page);
    await until("a robot is expected", async () =>
      (await page.locator("#robots tbody td:nth-child(4)").allTextContents()).some((goal) => /^\[\d+, \d+\] in \d+:\d\d$/.test(goal)));
    await until("robots move", async () => (await cells(page)).some((cell, index) => cell !== first[index]));
    await until("the first picture is drawn", async () => (await seconds(page)) > 20);
    await shot(page, "live.png");

    await page.keyboard.press("p");
    await page.keyboard.press("Shift+P");
    await until("all robots are paused", async () => (await states(page)).every((state) => state === "paused"));
    const stopped = await cells(page);
    const since = await seconds(page);
    await until("time passes", async () => (await seconds(page)) > since + 30);
    assert.deepEqual(await cells(page), stopped, "a paused robot stays where it is");
    assert.equal(await text(page, "state"), "paused");
    assert.equal(await text(page, "pause"), "Resume all robots");
    await shot(page, "paused.png");

    await sendOne(page, stopped);

    // A mark: the belief of that cell rises. No robot observes meanwhile.
    await moveTo(page, 16, 19);
    const before = await probability(page);
    await marks(page, "c", "a glove");
    await until("a clue raises the belief", async () => (await probability(page)) > before);
    assert.equal(await text(page, "marks"), "1");

    // However many there are, they make no find: robots go and look.
    for (let times = 0; times < 3; times += 1) await marks(page, "c");
    await until("it is as likely as not", async () => (await probability(page)) > 45);
    assert.equal(await page.locator("#objects tbody tr", { hasText: "585 m east, 495 m north" }).count(), 0);
    const raised = await probability(page);
    await marks(page, "s");
    await until("a search of others lowers it", async () => (await probability(page)) < raised);

    await withdraws(page);

    // An area over cells that are not searched, drawn by keys.
    await moveTo(page, 4, 23);
    assert.match(await text(page, "cell"), /outside the search area/);
    await page.keyboard.press("a");
    for (const [row, column] of [[2, 22], [2, 25], [6, 25], [6, 22]]) {
      await moveTo(page, row, column);
      await page.keyboard.press("Enter");
    }
    await shot(page, "area.png");
    await answered(page, () => page.keyboard.press("f"), /20 cells are searched from now on/);
    await moveTo(page, 4, 23);
    await until("cells of an area are searched", async () => (await probability(page)) > 0);
    assert.match(await text(page, "cell"), /never looked at|probability of detection of \d+ %/);
    await page.keyboard.press("a");
    for (const [row, column] of [[10, 5], [10, 7], [12, 7]]) {
      await moveTo(page, row, column);
      await page.keyboard.press("Enter");
    }
    await answered(page, () => page.keyboard.press("f"), /searched already/);

    await zones(page);

    assert.equal(await text(page, "pause"), "Resume all robots");
    const held = await cells(page);
    await page.locator("#pause").click();
    await until("robots go on", async () => (await cells(page)).some((cell, index) => cell !== held[index]));
    assert.equal(await text(page, "state"), "live");
    await reach(page);
    await fits(page);
    await ends(page);
  });
}

/** The mission ends once all robots are back, if that is what the operator wants. */
async function ends(page) {
  await page.locator("#end").click();
  await shot(page, "end.png");
  await page.keyboard.press("Escape");
  assert.equal(await text(page, "state"), "live");
  await page.locator("#end").click();
  await answered(page, () => page.locator("#end-done").click(), /^The mission ends once all robots are back at their bases\./);
  await until("it is ending", async () => (await text(page, "state")) === "ending");
  assert.match(await text(page, "trouble"), /^The mission ends once robots? \d.* (is|are) back\.$/);
  assert.equal(await text(page, "end"), "End now");
  await until("it is over", async () => (await text(page, "state")) === "mission over");
  assert.ok((await states(page)).every((state) => state === "recalled"), "all are back");
  assert.ok(await page.locator("#end").isDisabled());
}

/** A clue with a radius, in the list with its note, is withdrawn: the belief is what it was. */
async function withdraws(page) {
  await moveTo(page, 5, 5);
  const before = await probability(page);
  await page.keyboard.press("c");
  await page.locator("#mark-note").fill("tracks, keys acnk typed");
  await page.locator("#mark-radius").fill("90");
  await shot(page, "mark.png");
  await answered(page, () => page.keyboard.press("Enter"), /10 times higher there, 6\.5 times at 90 m/);
  const item = page.locator("#marked li").first();
  await until("it is listed", async () => /clue, 10 times within 90 m: tracks, keys acnk typed/.test(await item.textContent()));
  await until("it counts", async () => (await probability(page)) > before);
  await shot(page, "clue.png");
  await page.keyboard.press("c");
  await page.keyboard.press("Escape");
  assert.ok(await page.locator("#mark").isHidden(), "nothing is marked");
  const count = await page.locator("#marked li").count();
  await answered(page, () => item.getByRole("button", { name: "Withdraw" }).click(), /The clue is withdrawn/);
  await until("it is off the list", async () => (await page.locator("#marked li").count()) === count - 1);
  await until("it counts no longer", async () => (await probability(page)) === before);
  const first = page.locator("#orders li").first();
  await until("each robot has it", async () => /Mark \[5, 5\] withdrawn: all robots have it$/.test(await first.textContent()));

  await page.keyboard.press("a");
  for (const [row, column] of [[10, 5], [10, 7], [12, 7], [12, 5]]) {
    await moveTo(page, row, column);
    await page.keyboard.press("Enter");
  }
  await page.keyboard.press("s");
  await page.locator("#mark-note").fill("team 2");
  await answered(page, () => page.locator("#mark-done").click(), /cells are marked as searched by others: they found nothing, and would have found 80\.0 %/);
  await until("it is listed", async () => /searched by others, 80 %: team 2/.test(await item.textContent()));
}

/** Draws an area by keys, and says what it is by another. */
async function drawn(page, corners, key, answer) {
  await page.keyboard.press("a");
  for (const [row, column] of corners) {
    await moveTo(page, row, column);
    await page.keyboard.press("Enter");
  }
  await answered(page, () => page.keyboard.press(key), answer);
}

/** Areas are closed to robots, skipped and opened again; each robot has it, and the map shows it. */
async function zones(page) {
  const corners = [[10, 5], [10, 7], [12, 7], [12, 5]];
  const at = () => text(page, "cell");
  const first = () => page.locator("#orders li").first().textContent();
  await drawn(page, corners, "n", /^\d+ cells are no-go: /);
  await moveTo(page, 11, 6);
  await until("the cell is no-go", async () => /no-go by your order/.test(await at()));
  await until("each robot has it", async () => /No-go an area of \d+ cells: all robots have it$/.test(await first()));
  await page.locator("#whom").selectOption({ label: "robot 2" });
  await answered(page, () => page.locator("#go").click(), /Not done: cell \[11, 6\] is no-go by your order: open it again first/);
  await page.locator("#whom").selectOption({ label: "all robots" });
  await shot(page, "no_go.png");
  await drawn(page, corners, "n", /Not done: all cells in it are no-go already/);
  await drawn(page, corners, "k", /^\d+ cells are skipped: robots do not search there, and may drive through/);
  await moveTo(page, 11, 6);
  await until("the cell is skipped", async () => /skipped by your order/.test(await at()));
  await shot(page, "skipped.png");
  await drawn(page, corners, "o", /^\d+ cells are open again/);
  await moveTo(page, 11, 6);
  await until("the cell is open", async () => !/by your order/.test(await at()));
  await until("each robot has that", async () => /Open again an area of \d+ cells: all robots have it$/.test(await first()));
}

/** One of the paused robots is sent to where another stands, and holds there. */
async function sendOne(page, stopped) {
  const there = /\[(\d+), (\d+)\]/.exec(stopped[0]).slice(1).map(Number);
  await moveTo(page, ...there);
  assert.equal(await page.locator("#go").getAttribute("title"), "Choose one robot first");
  await page.locator("#whom").selectOption({ label: "robot 2" });
  assert.equal(await text(page, "pause"), "Resume robot 2");
  await answered(page, () => page.locator("#go").click(), /Robot 2 is sent to cell \[\d+, \d+\], as far as .*, and stays there/);
  await until("it has it", async () => (await text(page, "acknowledged")) === "Robot 2 has it.");
  await until("it goes, and can be paused", async () =>
    (await states(page))[1] === "holding" || (await text(page, "pause")) === "Pause robot 2");
  await shot(page, "sent.png");
  await until("it is there, and holds", async () => (await states(page))[1] === "holding");
  assert.ok((await states(page)).every((state, index) => index === 1 || state === "paused"), "no other robot goes");
  assert.equal((await cells(page))[1], stopped[0]);
  assert.match(await page.locator("#orders li").first().textContent(), /Robot 2: Go to \[\d+, \d+\]: robot 2 has it$/);
  await page.locator("#whom").selectOption({ label: "all robots" });
}

/** Every control is reached by Tab, and shows that it is. */
async function reach(page) {
  await page.evaluate(() => document.activeElement?.blur());
  const reached = new Set();
  for (let tries = 0; tries < 90; tries += 1) {
    await page.keyboard.press("Tab");
    reached.add(await page.evaluate(() => document.activeElement?.id));
  }
  const controls = ["sound", "ground", "zoom-in", "zoom-out", "whole", "measure", "base-probability", "whom", "pause", "return", "searched", "clue", "area"];
  for (const id of controls) assert.ok(reached.has(id), `${id} by Tab`);
  const unnamed = await page.locator("button:visible, input:visible, select:visible").evaluateAll((all) =>
    all.filter((it) => !(it.textContent.trim() || it.labels?.length || it.ariaLabel)).map((it) => it.id));
  assert.deepEqual(unnamed, []);
}

/** The commands and a map worth its name are on each screen without scrolling. */
async function fits(page) {
  for (const [width, height] of SCREENS) {
    await page.setViewportSize({ width, height });
    await page.evaluate(() => scrollTo(0, 0));
    // Robots go on meanwhile: the banner of a find takes place until it is read, and another may come before the screen is measured.
    let boxes = [];
    do {
      if (await page.locator("#find").isVisible()) await page.locator("#find-close").click();
      await settle(page);
      boxes = await page.locator("#controls button:visible, #whom:visible, #stage").evaluateAll((all) =>
        all.map((it) => [it.id, it.getBoundingClientRect()].map((part) => part.toJSON?.() ?? part)));
    } while (await page.locator("#find").isVisible());
    for (const [id, box] of boxes) {
      assert.ok(box.top >= 0 && box.left >= 0 && box.bottom <= height && box.right <= width, `${id} on ${width} x ${height}`);
    }
    assert.equal(boxes.length, 9, "the map, seven commands, and whom they are to");
    const stage = boxes.find(([id]) => id === "stage")[1];
    assert.ok(stage.height > 0.45 * height, `${stage.height} pixels of map on ${width} x ${height}`);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(wide <= width, `${wide} pixels on a screen of ${width}`);
    for (const colorScheme of ["light", "dark"]) {
      await page.emulateMedia({ colorScheme });
      await settle(page);
      await shot(page, `${width}_${colorScheme}.png`);
    }
  }
}

/** Without the token nothing can be changed, and the page says why. */
async function readOnly() {
  await browse(bare, { expected: [/status of 401/] }, async (page) => {
    await until("the page says why", async () => /Read-only/.test(await text(page, "answer")));
    for (const id of ["pause", "searched", "clue", "area"]) {
      assert.ok(await page.locator(`#${id}`).isDisabled(), id);
      assert.match(await page.locator(`#${id}`).getAttribute("title"), /token/);
    }
    await page.keyboard.press("Shift+P");
    const status = await page.evaluate(() => fetch("command", { method: "POST", body: '{"command":"pause"}' }).then((it) => it.status));
    assert.equal(status, 401);
  });
}

/** Fits a phone in the dark: nothing is wider than the screen. */
async function phone() {
  const viewport = { width: 375, height: 720 };
  await browse(address, { viewport, colorScheme: "dark", hasTouch: true, isMobile: true }, async (page) => {
    await until("robots are drawn", async () => (await seconds(page)) > 0);
    const [wide, screen] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
    assert.ok(wide <= screen, `${wide} pixels on a screen of ${screen}`);
    await page.locator("#ground").tap();
    await until("a tap chooses a cell", async () => /Cell \[/.test(await text(page, "cell")));
    const low = await page.locator("#controls button:visible, .tools button").evaluateAll((all) => all.filter((it) => it.clientHeight < 38).map((it) => it.id));
    assert.deepEqual(low, [], "buttons that a finger misses");
    await shot(page, "phone.png");
  });
}

/** A map of the earth: names, coordinates, distances, layers, zoom. */
async function earth() {
  await browse(address, { permissions: ["clipboard-read", "clipboard-write"] }, async (page) => {
    await until("robots are drawn", async () => (await seconds(page)) > 20);
    const names = await page.locator(".area-name").allTextContents();
    for (const wanted of ["Search area", "Quarry pond", "Stream, 30 %", "Car park, 40 %"]) assert.ok(names.includes(wanted), `${wanted} in ${names}`);

    // The south-western cell of 30 m, from the corner of the map file.
    await moveTo(page, 0, 0);
    const [, latitude, longitude] = /^([\d.-]+), ([\d.-]+) · 30U WV \d{5} \d{5}$/.exec(await text(page, "coordinates"));
    assert.ok(Math.abs(latitude - (49.236 + 15 / 111_200)) < 2e-5 && Math.abs(longitude - (-2.24 + 15 / 72_900)) < 2e-5, `${latitude}, ${longitude}`);
    await page.locator("#copy").click();
    await until("it is copied", async () => (await text(page, "copy")) === "Copied");
    assert.equal(await page.evaluate(() => navigator.clipboard.readText()), `${latitude}, ${longitude}`);

    await page.locator("#ground").focus();
    await page.keyboard.press("m");
    await page.keyboard.press("Enter");
    await moveTo(page, 4, 3);
    await page.keyboard.press("Enter");
    await until("five cells of 30 m", async () => /Measured: 150 m/.test(await text(page, "measured")));
    await shot(page, "earth_measured.png");
    await page.keyboard.press("Escape");
    await until("measuring ends", async () => (await text(page, "measured")) === "");

    await notations(page);
    await zooms(page);
    await layers(page);
  });
}

/** Places on both hemispheres, in zones that are wider, and near the equator, by the package `utm` 0.9 for Python: meters rounded down. */
const UTM = [
  [[49.2365, -2.23959], "30U 555354E 5454025N"],
  [[-33.8688, 151.2093], "56H 334368E 6250948N"],
  [[60.39, 5.32], "32V 297230E 6700510N"],
  [[78.22, 15.65], "33X 514813E 8683004N"],
  [[0.0001, -78.5], "17N 778276E 11N"],
  [[-0.0001, 36.8], "37M 255134E 9999988N"],
  [[-54.8, -68.3], "19F 545000E 3927239N"],
];

/** Coordinates are written as the viewer chooses, and so again when the page is opened anew. */
async function notations(page) {
  for (const [point, expected] of UTM) assert.equal(utmOf(point), expected);
  await moveTo(page, 0, 0);
  const [degrees, square] = (await text(page, "coordinates")).split(" · ");
  const [, , east, north] = square.split(" ");
  const choose = async (notation) => {
    await page.locator("#layers summary").click();
    await page.locator("#notation").selectOption(notation);
    await page.locator("#layers summary").click();
  };
  await choose("utm");
  const utm = new RegExp(`^30U \\d${east}E \\d\\d${north}N · ${degrees}$`);
  await until("UTM", async () => utm.test(await text(page, "coordinates")));
  await page.reload();
  await until("robots are drawn", async () => (await seconds(page)) > 20);
  await moveTo(page, 0, 0);
  await until("UTM again", async () => utm.test(await text(page, "coordinates")));
  await choose("mgrs");
  await until("MGRS", async () => (await text(page, "coordinates")) === `${square} · ${degrees}`);
  await choose("degrees");
  await until("degrees", async () => (await text(page, "coordinates")) === `${degrees} · ${square}`);
}

async function zooms(page) {
  const scale = () => page.locator(".leaflet-control-scale-line").textContent();
  const whole = await scale();
  await page.locator("#zoom-in").click();
  await page.locator("#zoom-in").click();
  await page.locator("#zoom-in").click();
  const near = await scale();
  assert.notEqual(near, whole, "the scale bar follows the zoom");
  const place = () => page.locator(".area-name").first().boundingBox();
  const before = await place();
  const box = await page.locator("#ground").boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await until("the pointer reads a cell", async () => /Cell \[\d+, \d+\].*\n49\.\d{5}, -2\.\d{5}/.test(await text(page, "hover")));
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + 80, box.y + box.height / 2 + 40, { steps: 5 });
  await page.mouse.up();
  const after = await place();
  assert.ok(Math.abs(after.x - before.x - 80) < 12, `${before.x} ${after.x}`);
  await page.locator("#whole").click();
  assert.equal(await scale(), whole);
}

/** Share of the pixels of the cells with this color. */
const colored = (page, color) => page.evaluate((wanted) => {
  const canvas = document.querySelector("canvas#cells");
  // From a copy: reading would make the browser complain about the canvas of the page.
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", { willReadFrequently: true });
  copy.drawImage(canvas, 0, 0);
  const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let at = 0; at < data.length; at += 4) count += wanted.every((part, index) => Math.abs(data[at + index] - part) < 3) ? 1 : 0;
  return (4 * count) / data.length;
}, color);

/** What was looked at and what not is told apart by color, and layers can be switched off. */
async function layers(page) {
  await page.keyboard.press("Shift+P");
  await until("all robots are paused", async () => (await states(page)).every((state) => state === "paused"));
  const never = [240, 138, 56];
  assert.equal(await colored(page, never), 0);
  await page.locator("#base-searched").check();
  await settle(page);
  const share = await colored(page, never);
  assert.ok(share > 0.05 && share < 0.9, `${share} of the picture was never looked at`);
  assert.ok(await page.locator("#legend-searched").isVisible() && !(await page.locator("#legend-probability").isVisible()));
  await shot(page, "earth_searched.png");
  await page.locator("#layers summary").click();
  await shot(page, "earth_layers.png");
  for (const id of ["no_go", "tracks", "grid"]) {
    const before = await picture(page);
    await page.locator(`#layer-${id}`).click();
    await settle(page);
    assert.notDeepEqual(await picture(page), before, id);
  }
  const pond = page.locator(".area-name", { hasText: "Quarry pond" });
  assert.equal(await pond.count(), 0, "with the no-go layer its names go");
  await page.locator("#layer-prior").uncheck();
  await until("likely regions go", async () => !(await page.locator(".area-name").allTextContents()).some((it) => /Stream/.test(it)));
}

/** A frozen or broken link is shown, with what was known last; commands wait. */
async function stale() {
  const radio = await link();
  try {
    await browse(radio.address, { expected: [/WebSocket|ERR_/] }, async (page) => {
      await until("it is live", async () => (await text(page, "state")) === "live" && (await seconds(page)) > 0);
      await until("it takes commands", () => page.locator("#pause").isEnabled());
      const frozen = Date.now();
      radio.freeze();
      await until("it is stale", async () => (await text(page, "state")) === "stale");
      const took = (Date.now() - frozen) / 1000;
      assert.ok(took > 2 && took < 8, `${took} s`);
      assert.match(await text(page, "trouble"), /since \d+:\d\d:\d\d.*mission time \d+:\d\d, 3 robots, \d finds?/);
      for (const id of ["pause", "area"]) assert.ok(await page.locator(`#${id}`).isDisabled(), id);
      const at = await seconds(page);
      await page.keyboard.press("Shift+P");
      await shot(page, "stale.png");
      await until("the stream is given up", async () => (await text(page, "state")) === "not connected");
      radio.thaw();
      await until("it is live again, not paused", async () => (await text(page, "state")) === "live" && (await seconds(page)) > at);
      assert.ok(await page.locator("#pause").isEnabled());
      assert.ok(await page.locator("#alert").isHidden());
    });
  } finally {
    radio.close();
  }
}

/** Many robots on a large map: each has a marker and a color of its own. */
async function crowd() {
  const places = spread(Array.from({ length: 50 }, () => [300, 200]), 20);
  const gaps = places.flatMap((a, index) => places.slice(0, index).map((b) => Math.hypot(a[0] - b[0], a[1] - b[1])));
  assert.ok(Math.min(...gaps) >= 20 && Math.max(...places.map(([x]) => Math.abs(x - 300))) < 150, "apart, and near");
  assert.deepEqual(spread([[0, 0], [50, 0]], 20), [[0, 0], [50, 0]], "who is alone stays");
  await browse(address, {}, async (page) => {
    await until("all robots report", async () => (await states(page)).every((state) => state !== "awaited"));
    const colors = await page.locator("#robots .robot").evaluateAll((all) => all.map((it) => getComputedStyle(it).borderTopColor));
    assert.equal(colors.length, 50);
    assert.equal(new Set(colors).size, 50, "no two robots have one color");
    // 20 objects in 90 000 cells.
    await moveTo(page, 150, 150);
    assert.match(await text(page, "cell"), /probability of an object 0\.02\d %, never looked at/);
    await shot(page, "crowd.png");
  });
}

/** Two processes of robot 1 are marked and described. */
async function doubled() {
  await browse(bare, {}, async (page) => {
    await until("robot 1 is marked", async () => (await states(page))[0] === "doubled");
    assert.match(await page.locator("#robots tbody tr").first().locator("td").nth(1).textContent(), /duplicate/);
    assert.ok((await states(page)).slice(1).every((state) => state !== "doubled"));
    const trouble = page.locator("#trouble");
    await until("it is described", async () => /Two robots have the number 1\./.test(await trouble.textContent()));
    assert.ok(await trouble.isVisible());
    await shot(page, "doubled.png");
  });
}

const CASES = { live, finds, pictured, cutOff, readOnly, phone, replay, sound, earth, stale, crowd, doubled, plan, planPhone, basemap, planOnBasemap };
await CASES[name]();
