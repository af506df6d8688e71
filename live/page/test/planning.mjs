// The planning page, as a search leader uses it.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { deflateRawSync } from "node:zlib";

import { groundOf, parseCorners, parsePosition } from "../dist/plan/drawing.js";
import { parseNumber } from "../dist/plan/entries.js";
import { address, browse, settle, shot, text, until } from "./browse.mjs";

const KML = readFileSync(new URL("../../../scenarios/maps/missing_person.kml", import.meta.url));
const DESKTOP = { width: 1440, height: 900 };
const PHONE = { width: 390, height: 844 };
const READY = "#state[data-is]";

const names = (page) => page.locator("#features .feature").allTextContents();
const answered = (page, what) => until(`the page says ${what}`, async () => what.test(await text(page, "answer")));
const ready = (page) => until("the plan is ready", async () => (await text(page, "state")) === "ready");
/** Sets a field, as a person does who leaves it afterwards. */
const put = async (page, id, value) => {
  await page.locator(`#${id}`).fill(value);
  await page.locator(`#${id}`).blur();
};

/** A zip archive of one file (APPNOTE 6.3): its local header and content, the directory, and the end of the directory. */
function archive(name, content) {
  const packed = deflateRawSync(content);
  const numbers = (...parts) => Buffer.concat(parts.map(([bytes, value]) => {
    const part = Buffer.alloc(bytes);
    part.writeUIntLE(value, 0, bytes);
    return part;
  }));
  const about = numbers([2, 20], [2, 0], [2, 8], [4, 0], [4, checksum(content)], [4, packed.length], [4, content.length], [2, name.length], [2, 0]);
  const local = Buffer.concat([numbers([4, 0x04034b50]), about, Buffer.from(name), packed]);
  const directory = Buffer.concat([numbers([4, 0x02014b50], [2, 20]), about, numbers([2, 0], [2, 0], [2, 0], [4, 0], [4, 0]), Buffer.from(name)]);
  const end = numbers([4, 0x06054b50], [2, 0], [2, 0], [2, 1], [2, 1], [4, directory.length], [4, local.length], [2, 0]);
  return Buffer.concat([local, directory, end]);
}

/** CRC-32 of IEEE 802.3. */
function checksum(bytes) {
  const step = (crc) => (crc & 1 ? (crc >>> 1) ^ 0xedb88320 : crc >>> 1);
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; bit += 1) crc = step(crc);
  }
  return ~crc >>> 0;
}

/** Coordinates as people write them. */
function positions() {
  const check = (written, [longitude, latitude]) => {
    const found = parsePosition(written);
    assert.ok(Math.abs(found[0] - longitude) < 1e-9 && Math.abs(found[1] - latitude) < 1e-9, `${written}: ${found}`);
  };
  check("49.236, -2.24", [-2.24, 49.236]);
  check("49.236 -2.24", [-2.24, 49.236]);
  check("49.236N 2.24W", [-2.24, 49.236]);
  check("49°14'24\"N, 2°14'24\"W", [-2.24, 49.24]);
  check("33 30 S; 151 15 E", [151.25, -33.5]);
  for (const wrong of ["", "49.236", "north", "49.2, 200", "89, 2", "49.2E, 2N", "49 75, 2", "-49 S, 2", "1e999, 2", "NaN, 2"]) {
    assert.equal(typeof parsePosition(wrong), "string", wrong);
  }
}

/** Numbers as people write them, and what is wrong with others, in the unit of the field. */
function numbers() {
  const hours = { isOptional: true, above: 0, most: 277777, unit: "hours" };
  const percent = { isOptional: true, least: 0, most: 100, unit: "%" };
  for (const [written, allowed, expected] of [
    ["0,5", hours, 0.5], [" 2 ", {}, 2], ["", hours, undefined], ["30 %", percent, 30], ["-3", {}, -3], ["1e3", { isWhole: true }, 1000],
  ]) assert.equal(parseNumber(written, allowed), expected, written);
  const wrong = (written, allowed, words) => assert.match(String(parseNumber(written, allowed)), words, written);
  wrong("-1", hours, /^-1 is not possible; allowed is a number above 0, up to 277777 hours\.$/);
  wrong("130", percent, /^130 is not possible; allowed is a number from 0 to 100 %\.$/);
  wrong("abc", percent, /^“abc” is no number/);
  wrong("2.5", { isWhole: true, least: 1, most: 1000 }, /^2\.5 is not possible; allowed is a whole number from 1 to 1000\.$/);
  wrong("", {}, /^A number is missing\.$/);
  for (const text of ["1e999", "Infinity", "0x10", "NaN", "1 2", "."]) wrong(text, {}, /is no number/);
  assert.deepEqual([900, 32_500, 1_300_000].map(groundOf), ["900 m²", "3.25 ha", "1.30 km²"]);
  assert.equal(parseCorners("49, 2\n49.1, 2", true), "An area has at least three corners.");
  assert.deepEqual(parseCorners("49, 2\n49.1, 2", false), [[2, 49], [2, 49.1]]);
}

/** Import, draw, place, set, forecast, cancel, save, overwrite and simulate. */
export async function plan() {
  positions();
  numbers();
  // The page of the simulation is another server's.
  await browse(address, { expected: [/status of (409|422)/, /^asked for http:\/\/127\.0\.0\.1:/], ready: READY, viewport: DESKTOP }, async (page, context) => {
    assert.equal(await text(page, "state"), "not ready yet");
    assert.match(await text(page, "review"), /no search area yet/i);
    assert.ok((await page.locator(".plan-degree").allTextContents()).includes("30°"), "an empty map has degrees");
    await shot(page, "plan_empty.png");

    await imports(page);
    await draws(page);
    await settings(page);
    await entries(page);
    await unseen(page);
    await twoWindows(page, context);
    await forecasts(page);
    await saves(page);
    await page.locator("#simulate").click();
    await page.locator("#robots tbody tr").first().waitFor();
    assert.equal(await text(page, "name"), "moor");
    await until("the simulation runs", async () => (await page.locator("#robots tbody tr[data-state=searching]").count()) > 0);
    await shot(page, "plan_simulation.png");
  });
}

/** Files of areas are read; others say what is wrong. */
async function imports(page) {
  const send = (name, content) => page.locator("#file").setInputFiles({ name, mimeType: "text/plain", buffer: Buffer.from(content) });
  await send("picture.png", "no areas");
  await answered(page, /picture\.png: unknown extension; allowed are/);
  await send("broken.kml", "<kml><Placemark>");
  await answered(page, /broken\.kml/);
  assert.deepEqual(await names(page), []);
  await page.locator("#replaces").check();
  await send("empty.geojson", JSON.stringify({ type: "FeatureCollection", features: [] }));
  await answered(page, /empty\.geojson: holds no area/);
  await page.locator("#replaces").uncheck();
  await send("truncated.kmz", archive("doc.kml", KML).subarray(0, 300));
  await answered(page, /truncated\.kmz: not a KMZ archive/);
  await send("missing_person.kmz", archive("doc.kml", KML));
  await answered(page, /missing_person\.kmz: \d areas? and \d places? read/);
  assert.ok((await names(page)).includes("Quarry pond"));
  await ready(page);
  assert.match(await text(page, "review"), /cells, \d+ searched: 1\.\d\d km²/);
  await settle(page);
  await shot(page, "plan_imported.png");
}

/** A no-go area drawn by taps, a start placed by typed coordinates, and both changed. */
async function draws(page) {
  const box = await page.locator("#ground").boundingBox();
  const tap = (east, south) => page.mouse.click(box.x + box.width * east, box.y + box.height * south);
  const before = (await names(page)).length;
  await page.locator("#draw-no_go").click();
  for (const [east, south] of [[0.55, 0.55], [0.6, 0.55], [0.6, 0.65]]) await tap(east, south);
  await shot(page, "plan_drawing.png");
  await page.locator("#finish").click();
  await until("it is in the list", async () => (await names(page)).length === before + 1);
  assert.match(await page.locator("#features li").last().textContent(), /No-go area 1.*closes [1-9]\d* cells/);

  await page.locator(`#name-${before}`).fill("Cliff");
  await page.locator(`#name-${before}`).blur();
  await until("it has its name", async () => (await names(page)).includes("Cliff"));

  // A likely region has no probability before somebody gives it one.
  await page.locator("#draw-prior").click();
  for (const [east, south] of [[0.4, 0.6], [0.45, 0.6], [0.45, 0.7]]) await tap(east, south);
  await page.locator("#finish").click();
  await until("its probability is missing", async () => /poa is missing/.test(await page.locator("#features li").last().textContent()));
  assert.equal(await text(page, "state"), "not ready yet");
  await shot(page, "plan_problem.png");
  await put(page, `poa-${before + 1}`, "10");
  await ready(page);

  await page.locator("#draw-start").click();
  await page.locator("#typed").fill("49.24, -200");
  await page.locator("#typed-button").click();
  await answered(page, /longitude of -200 is not possible/);
  await page.locator("#typed").fill("49.2385, -2.2380");
  await page.locator("#typed-button").click();
  await until("it is there", async () => /no robot starts here|start of robot 2/.test(await page.locator("#features li").last().textContent()));
  await page.locator("#features .feature").last().click();
  await page.locator(`#delete-${before + 2}`).click();
  await until("it is gone", async () => (await names(page)).length === before + 2);
  await page.locator("#undo").click();
  await until("it is back", async () => (await names(page)).length === before + 3);
  await page.locator("#whole").click();
}

/** Settings, with what is wrong beside them. */
async function settings(page) {
  await put(page, "field-name", "the moor");
  await until("the name is refused", async () => /letters, digits/.test(await text(page, "field-name-problem")));
  await put(page, "field-name", "moor");
  await put(page, "field-robots", "0");
  await until("no robots are refused", async () => /0 is not possible; allowed is a whole number from 1 to 1000/.test(await text(page, "field-robots-problem")));
  await put(page, "field-robots", "2");
  await put(page, "field-cell", "60");
  await until("a cell is suggested", async () => /Suggested for this area: 20 m/.test(await text(page, "cell-note")));
  await put(page, "field-hours", "0.5");
  await put(page, "field-objects", "2");
  await put(page, "field-remaining", "0.02");
  await until("what the end means is said", async () => /Of all missing 99 % are expected/.test(await text(page, "remaining-note")));
  await put(page, "field-remaining", "0.05");
  const elsewhere = page.locator("#field-elsewhere");
  assert.ok(await elsewhere.isEnabled(), "each of two may be elsewhere");
  await put(page, "field-objects", "101");
  await until("so many are not counted", async () => elsewhere.isDisabled());
  await put(page, "field-objects", "1");
  await until("one is somewhere in the area", async () => (await elsewhere.isEnabled()) && (await elsewhere.inputValue()) === "0");
  await put(page, "field-elsewhere", "20");
  const state = () => page.evaluate(async () => (await fetch("plan/state")).json());
  await until("a fifth is elsewhere", async () => (await state()).plan.scenario.prior.rest_of_world === 0.2);
  await ready(page);
  await put(page, "field-elsewhere", "0");
  await ready(page);
  assert.ok(!(await page.locator("#suggested").isChecked()));
}

/** What is wrong stands below its field, in its unit; nothing wrong is sent, and all of it is shown somewhere. */
async function entries(page) {
  const refused = (id, words) => until(`${id} is refused`, async () => words.test(await text(page, `${id}-problem`)));
  const mended = async (id) => {
    await ready(page);
    assert.ok(await page.locator(`#${id}-problem`).isHidden(), id);
  };
  assert.match(await text(page, "sensor-note"), /^Sees 300 m: 5 cells of 60 m\.$/);
  for (const [id, wrong, words, right] of [
    ["field-hours", "", /allowed is a time budget, a distance/, "0.5"],
    ["field-hours", "-1", /^-1 is not possible; .*hours/, "0.5"],
    ["field-robots", "2.5", /^2\.5 is not possible; allowed is a whole number/, "2"],
    ["field-remaining", "-1", /^-1 is not possible/, "0.05"],
    ["field-speed", "", /^A number is missing/, "2"],
    ["field-radius", "abc", /^“abc” is no number/, "5"],
  ]) {
    await page.locator(`#${id}`).evaluate((it) => it.closest("details")?.setAttribute("open", ""));
    await put(page, id, wrong);
    await refused(id, words);
    assert.equal(await page.locator(`#${id}`).inputValue(), wrong);
    assert.equal(await text(page, "state"), "not ready yet");
    assert.ok(await page.locator("#save").isDisabled());
    await put(page, id, right);
    await mended(id);
  }
  // Undo takes back what was not sent first.
  await put(page, "field-robots", "two");
  await refused("field-robots", /“two” is no number/);
  await page.locator("#undo").click();
  await mended("field-robots");
  assert.equal(await page.locator("#field-robots").inputValue(), "2");

  const hut = (await names(page)).indexOf("Car park");
  await page.locator(`#feature-${hut}`).click();
  await page.locator(`#poa-${hut}`).waitFor();
  const poa = await page.locator(`#poa-${hut}`).inputValue();
  for (const wrong of ["130", "abc"]) {
    await put(page, `poa-${hut}`, wrong);
    await until("it is refused in percent", async () => (await page.locator("#features li").nth(hut).textContent()).includes("allowed is a number from 0 to 100 %"));
    assert.equal(await page.locator(`#poa-${hut}`).inputValue(), wrong);
  }
  await put(page, `poa-${hut}`, poa);
  await ready(page);

  await put(page, "forecast-robots", "abc");
  await page.locator("#forecast").click();
  await refused("forecast-robots", /“abc” is no number; allowed is a whole number from 1 to 1000/);
  await put(page, "forecast-robots", "4");
  assert.ok(await page.locator("#forecast-robots-problem").isHidden());

  // A setting that the page does not show.
  const set = (limit) => page.evaluate(async (limit) => {
    const headers = { Authorization: `Bearer ${new URLSearchParams(location.hash.slice(1)).get("token")}` };
    const { revision, plan } = await (await fetch("plan/state")).json();
    plan.scenario.mission.detection_threshold = limit;
    await fetch("plan/change", { method: "POST", headers, body: JSON.stringify({ revision, plan }) });
    return (await (await fetch("plan/state")).json()).review.problems;
  }, limit);
  const { mission } = (await page.evaluate(async () => (await fetch("plan/state")).json())).plan.scenario;
  assert.equal((await set(7))[0].at.key, "mission.detection_threshold");
  await until("it is shown", async () => /mission\.detection_threshold: 7 is not possible/i.test(await text(page, "review")));
  await set(mission.detection_threshold);
  await ready(page);
}

/** Ground that no robot sees is hatched, and its place said. */
async function unseen(page) {
  assert.ok(await page.locator("#unseen").isHidden());
  await put(page, "field-radius", "1");
  await put(page, "field-cell", "20");
  // Nobody looks over this water.
  await until("ground is out of sight", async () => (await page.locator(".plan-unseen").count()) > 0);
  assert.ok(await page.locator("#unseen").isVisible());
  assert.match(await text(page, "review"), /out of every robot's sight, the first one at 49\.\d{5}, -2\.\d{5}/);
  await settle(page);
  await shot(page, "plan_unseen.png");
  await put(page, "field-radius", "5");
  await put(page, "field-cell", "60");
  await until("all is in sight", () => page.locator("#unseen").isHidden());
}

/** What another window changes is shown here, and nothing is overwritten. */
async function twoWindows(page, context) {
  const other = await context.newPage();
  await other.goto(address);
  await until("it shows the same", async () => (await text(other, "name")) === "moor");
  await put(other, "field-speed", "3");
  await until("the first window follows", async () => (await page.locator("#field-speed").inputValue()) === "3");
  await other.close();
}

/** A forecast is cancelled, made, and out of date when the plan changes. */
async function forecasts(page) {
  await page.locator("#forecast-missions").selectOption("200");
  await page.locator("#feature-0").click();
  await page.locator("#forecast").click();
  await page.locator("#cancel").waitFor();
  // News of it leave what is being typed as it is.
  await page.locator("#name-0").fill("Typed meanwhile");
  await until("the rest of the time is estimated", async () => /\d+ of 800 simulated missions, about (a minute|\d+ minutes) left\./.test(await text(page, "forecast-state")));
  assert.equal(await page.locator("#name-0").inputValue(), "Typed meanwhile");
  await page.locator("#cancel").click();
  await until("it was sent", async () => (await names(page)).includes("Typed meanwhile"));
  await page.locator("#undo").click();
  await until("it was taken back", async () => !(await names(page)).includes("Typed meanwhile"));
  await until("it is cancelled", async () => (await text(page, "forecast-state")) === "No forecast yet.");
  await page.locator("#forecast-robots").fill("3");
  await page.locator("#forecast-missions").selectOption("10");
  await page.locator("#forecast").click();
  await until("it is made", async () => (await page.locator("#forecast-table tbody tr").count()) === 3 && page.locator("#forecast-results").isVisible());
  const rows = await page.locator("#forecast-table tbody tr").allTextContents();
  assert.match(rows[0], /^1(never|\d+:\d\d)/);
  assert.match(rows[2], /\d+ % \(\d+–\d+\)$/);
  assert.ok(await page.locator("#forecast-old").isHidden());
  await page.locator("#forecast-results").scrollIntoViewIfNeeded();
  await shot(page, "plan_forecast.png");
  await put(page, "field-speed", "2");
  await until("it is out of date", () => page.locator("#forecast-old").isVisible());
}

/** Saved under a name, and over files of others only after a question. */
async function saves(page) {
  await put(page, "field-name", "hall");
  await ready(page);
  await page.locator("#save").click();
  await answered(page, /hall\.toml in .* exists already/);
  assert.match(await text(page, "overwrite"), /Overwrite hall\.toml/);
  await put(page, "field-name", "moor");
  await until("the question is gone", () => page.locator("#overwrite").isHidden());
  assert.ok(await page.locator("#simulate").isDisabled(), "nothing is saved");
  await page.locator("#save").click();
  await answered(page, /Saved: moor\.geojson and moor\.toml/);
  await until("it can be simulated", () => page.locator("#simulate").isEnabled());
  await page.locator("#save").scrollIntoViewIfNeeded();
  await shot(page, "plan_saved.png");
}

/** All of it fits a phone, and can be used without a mouse. */
export async function planPhone() {
  await browse(address, { ready: READY, viewport: PHONE, hasTouch: true, isMobile: true }, async (page) => {
    await ready(page);
    const width = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(width <= 390, `${width} pixels wide`);
    await shot(page, "plan_phone.png");
    await page.locator("#features .feature", { hasText: "Car park" }).tap();
    await page.locator("#poa-4").waitFor();
    await page.locator("#features").scrollIntoViewIfNeeded();
    await shot(page, "plan_phone_list.png");
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 390);
  });
}
