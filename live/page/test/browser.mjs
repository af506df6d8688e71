// The page in a real browser. Called by tests/live: `node browser.mjs CASE ADDRESS FOLDER`, with the address that the
// program printed and a folder for screenshots; exit code 0 if all holds.

import assert from "node:assert/strict";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { chromium } from "playwright-core";

const FLAGS = [
  "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync",
];
const DESKTOP = { width: 1280, height: 900 };
const PHONE = { width: 375, height: 720 };

const [, , name, address, folder] = process.argv;
const bare = address.split("#")[0];

/** Opens the page in a browser with nothing in it, and closes both after. The browser logs no errors except
 * `expected` ones. */
async function browse(url, { expected = [], ...options }, act) {
  const profile = mkdtempSync(join(tmpdir(), "dragnet-page-"));
  const context = await chromium.launchPersistentContext(profile, {
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    headless: true, args: FLAGS, viewport: DESKTOP, ...options,
  });
  const page = context.pages()[0] ?? (await context.newPage());
  const complaints = [];
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("request", (request) => {
    if (!request.url().startsWith(bare)) complaints.push(`asked for ${request.url()}`);
  });
  try {
    await page.goto(url);
    await page.locator("#robots tbody tr").first().waitFor();
    await act(page);
    assert.deepEqual(complaints.filter((it) => !expected.some((pattern) => pattern.test(it))), []);
  } finally {
    await context.close();
    rmSync(profile, { recursive: true, force: true });
  }
}

const cells = (page) => page.locator("#robots tbody td:nth-child(3)").allTextContents();
const states = (page) => page.locator("#robots tbody tr").evaluateAll((rows) => rows.map((row) => row.dataset.state));
const seconds = (page) => page.locator("#time").textContent()
  .then((text) => text.split(":").reduce((sum, part) => 60 * sum + Number(part), 0));
const picture = (page) => page.locator("#canvas").evaluate((canvas) => canvas.toDataURL());
const shot = (page, file) => page.screenshot({ path: join(folder, file), fullPage: true });
const settle = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));

/** Waits for a condition, with a generous limit. */
async function until(what, holds) {
  for (let tries = 0; tries < 600; tries += 1) {
    if (await holds()) return;
    await new Promise((done) => setTimeout(done, 100));
  }
  assert.fail(`waited in vain: ${what}`);
}

async function answered(page, act, pattern) {
  await page.locator("#answer").evaluate((place) => (place.textContent = ""));
  await act();
  await until(`an answer like ${pattern}`, async () => pattern.test(await page.locator("#answer").textContent()));
}

/** Probability, percent, of the cell under the cursor. */
async function probability(page) {
  const text = await page.locator("#cell").textContent();
  return Number(/probability of an object (?:under |over )?([\d.]+) %/.exec(text)?.[1] ?? NaN);
}

/** Moves the cursor there by keys alone. */
async function moveTo(page, row, column) {
  await page.locator("#ground").focus();
  for (let tries = 0; tries < 400; tries += 1) {
    const here = /Cell \[(\d+), (\d+)\]/.exec(await page.locator("#cell").textContent());
    if (here && Number(here[1]) === row && Number(here[2]) === column) return;
    const [north, east] = here ? [row - Number(here[1]), column - Number(here[2])] : [1, 0];
    await page.keyboard.press(north > 0 ? "ArrowUp" : north < 0 ? "ArrowDown" : east > 0 ? "ArrowRight" : "ArrowLeft");
    await settle(page);
  }
  assert.fail(`the cursor does not come to [${row}, ${column}]`);
}

/** Robots move, stop when paused and go on; marks and areas count; all of it by keys alone. */
async function live() {
  // An area without new cells is rejected.
  await browse(address, { expected: [/status of 422/] }, async (page) => {
    const first = await cells(page);
    await until("robots move", async () => (await cells(page)).some((cell, index) => cell !== first[index]));
    await until("the first picture is drawn", async () => (await seconds(page)) > 20);
    await shot(page, "live.png");

    await page.keyboard.press("p");
    await until("all robots are paused", async () => (await states(page)).every((state) => state === "paused"));
    const stopped = await cells(page);
    const since = await seconds(page);
    await until("time passes", async () => (await seconds(page)) > since + 30);
    assert.deepEqual(await cells(page), stopped, "a paused robot stays where it is");
    assert.equal(await page.locator("#state").textContent(), "paused");
    assert.equal(await page.locator("#pause").textContent(), "Resume all robots");
    await shot(page, "paused.png");

    // A mark: the belief of that cell rises. No robot observes meanwhile.
    await moveTo(page, 16, 19);
    const before = await probability(page);
    await answered(page, () => page.keyboard.press("c"), /marked as a clue/);
    await until("a clue raises the belief", async () => (await probability(page)) > before);
    assert.equal(await page.locator("#marks").textContent(), "1");
    const raised = await probability(page);
    await answered(page, () => page.keyboard.press("s"), /marked as searched/);
    await until("a searched mark lowers it", async () => (await probability(page)) < raised);

    // An area over cells that are not searched, drawn by keys.
    await moveTo(page, 4, 23);
    assert.match(await page.locator("#cell").textContent(), /not searched/);
    await page.keyboard.press("a");
    for (const [row, column] of [[2, 22], [2, 25], [6, 25], [6, 22]]) {
      await moveTo(page, row, column);
      await page.keyboard.press("Enter");
    }
    await shot(page, "area.png");
    await answered(page, () => page.keyboard.press("f"), /20 cells are searched from now on/);
    await moveTo(page, 4, 23);
    await until("cells of an area are searched", async () => (await probability(page)) > 0);
    await page.keyboard.press("a");
    for (const [row, column] of [[10, 5], [10, 7], [12, 7]]) {
      await moveTo(page, row, column);
      await page.keyboard.press("Enter");
    }
    await answered(page, () => page.keyboard.press("f"), /searched already/);

    await page.locator("#pause").click();
    await until("robots go on", async () => (await cells(page)).some((cell, index) => cell !== stopped[index]));
    assert.equal(await page.locator("#state").textContent(), "live");
    await reach(page);
  });
}

/** Every control is reached by Tab, and shows that it is. */
async function reach(page) {
  await page.evaluate(() => document.activeElement?.blur());
  const reached = new Set();
  for (let tries = 0; tries < 20; tries += 1) {
    await page.keyboard.press("Tab");
    reached.add(await page.evaluate(() => document.activeElement?.id));
  }
  for (const id of ["ground", "pause", "searched", "clue", "area"]) assert.ok(reached.has(id), `${id} by Tab`);
  const unnamed = await page.locator("button:visible, input:visible, select:visible").evaluateAll((all) =>
    all.filter((it) => !(it.textContent.trim() || it.labels?.length || it.ariaLabel)).map((it) => it.id));
  assert.deepEqual(unnamed, []);
}

/** Without the token nothing can be changed, and the page says why. */
async function readOnly() {
  await browse(bare, { expected: [/status of 401/] }, async (page) => {
    await until("the page says why", async () => /Read-only/.test(await page.locator("#answer").textContent()));
    for (const id of ["pause", "searched", "clue", "area"]) {
      assert.ok(await page.locator(`#${id}`).isDisabled(), id);
      assert.match(await page.locator(`#${id}`).getAttribute("title"), /token/);
    }
    await page.keyboard.press("p");
    const status = await page.evaluate(() => fetch("command", { method: "POST", body: '{"command":"pause"}' }).then((it) => it.status));
    assert.equal(status, 401);
  });
}

/** Fits a phone in the dark: nothing is wider than the screen. */
async function phone() {
  await browse(address, { viewport: PHONE, colorScheme: "dark", hasTouch: true, isMobile: true }, async (page) => {
    await until("robots are drawn", async () => (await seconds(page)) > 0);
    const [wide, screen] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
    assert.ok(wide <= screen, `${wide} pixels on a screen of ${screen}`);
    await page.locator("#ground").tap();
    await until("a tap chooses a cell", async () => /Cell \[/.test(await page.locator("#cell").textContent()));
    const low = await page.locator("#controls button:visible").evaluateAll((all) => all.filter((it) => it.clientHeight < 40).map((it) => it.id));
    assert.deepEqual(low, [], "buttons that a finger misses");
    await shot(page, "phone.png");
  });
}

/** A recording plays, stops, and shows the same at a time from any other time. */
async function replay() {
  await browse(address, {}, async (page) => {
    assert.ok(await page.locator("#controls").isHidden());
    const slider = page.locator("#slider");
    const end = Number(await slider.getAttribute("max"));
    const seek = async (share) => {
      const to = Math.round(end * share);
      await slider.fill(String(to));
      await until(`it is ${to} s`, async () => (await seconds(page)) === to && (await slider.inputValue()) === String(to));
      await settle(page);
      return [await picture(page), await cells(page), await page.locator("#entropy").textContent(), await page.locator("#entropy-chart").evaluate((chart) => chart.toDataURL())];
    };
    const middle = await seek(0.5);
    await shot(page, "replay.png");
    const late = await seek(0.9);
    assert.notDeepEqual(late, middle);
    assert.deepEqual(await seek(0.5), middle, "back to the same picture");
    const early = await seek(0.1);
    assert.notDeepEqual(early, middle);
    assert.deepEqual(await seek(0.5), middle, "on to the same picture");
    await page.locator("#speed").selectOption("50");
    await page.locator("#play").click();
    await until("it plays", async () => (await seconds(page)) > 0.5 * end + 20);
    await page.locator("#play").click();
    await slider.focus();
    await page.keyboard.press("Home");
    await until("a key moves the slider", async () => (await seconds(page)) === 0);
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

const CASES = { live, readOnly, phone, replay, doubled };
await CASES[name]();
