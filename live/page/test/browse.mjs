// Opens the page in a real browser, and reads it.

import assert from "node:assert/strict";
import { mkdtempSync, rmSync } from "node:fs";
import net from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { chromium } from "playwright-core";

const FLAGS = [
  "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync",
];
const DESKTOP = { width: 1280, height: 900 };

export const [, , name, address, folder] = process.argv;
export const bare = address.split("#")[0];

/** Opens the page in a browser with nothing in it, and closes both after. The browser logs no errors except
 * `expected` ones, and asks only the server of the page; it is there when the element `ready` is. */
export async function browse(url, { expected = [], ready = "#robots tbody tr", ...options }, act) {
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
    if (!request.url().startsWith(new URL(url).origin)) complaints.push(`asked for ${request.url()}`);
  });
  try {
    await page.goto(url);
    await page.locator(ready).first().waitFor();
    await act(page, context);
    assert.deepEqual(complaints.filter((it) => !expected.some((pattern) => pattern.test(it))), []);
  } finally {
    await context.close();
    rmSync(profile, { recursive: true, force: true });
  }
}

export const cells = (page) => page.locator("#robots tbody td:nth-child(3)").allTextContents();
export const states = (page) => page.locator("#robots tbody tr").evaluateAll((rows) => rows.map((row) => row.dataset.state));
export const seconds = (page) => page.locator("#time").textContent()
  .then((text) => text.split(":").reduce((sum, part) => 60 * sum + Number(part), 0));
/** A digest of the two canvases of the map: cells, and what is drawn over them. */
export const picture = (page) => page.evaluate(() => ["cells", "canvas"]
  .map((id) => document.querySelector(`canvas#${id}`).toDataURL())
  .map((data) => [...data].reduce((sum, letter) => (31 * sum + letter.charCodeAt(0)) | 0, 0)));
export const shot = (page, file) => page.screenshot({ path: join(folder, file) });
export const settle = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
export const text = (page, id) => page.locator(`#${id}`).textContent();

/** Waits for a condition, with a generous limit. */
export async function until(what, holds) {
  for (let tries = 0; tries < 1200; tries += 1) {
    if (await holds()) return;
    await new Promise((done) => setTimeout(done, 100));
  }
  assert.fail(`waited in vain: ${what}`);
}

export async function answered(page, act, pattern) {
  await page.locator("#answer").evaluate((place) => (place.textContent = ""));
  await act();
  await until(`an answer like ${pattern}`, async () => pattern.test(await text(page, "answer")));
}

/** Probability, percent, of the cell under the cursor. */
export async function probability(page) {
  return Number(/probability of an object (?:under |over )?([\d.]+) %/.exec(await text(page, "cell"))?.[1] ?? NaN);
}

/** Moves the cursor there by keys alone. */
export async function moveTo(page, row, column) {
  await page.locator("#ground").focus();
  for (let tries = 0; tries < 400; tries += 1) {
    const here = /Cell \[(\d+), (\d+)\]/.exec(await text(page, "cell"));
    if (here && Number(here[1]) === row && Number(here[2]) === column) return;
    const [north, east] = here ? [row - Number(here[1]), column - Number(here[2])] : [1, 0];
    await page.keyboard.press(north > 0 ? "ArrowUp" : north < 0 ? "ArrowDown" : east > 0 ? "ArrowRight" : "ArrowLeft");
    await settle(page);
  }
  assert.fail(`the cursor does not come to [${row}, ${column}]`);
}

/** A link to the server that freezes without breaking, as radio does. */
export async function link() {
  const target = new URL(bare);
  const pairs = new Set();
  let isFrozen = false;
  const server = net.createServer((near) => {
    const far = net.connect(Number(target.port), target.hostname);
    const pair = [near, far];
    pairs.add(pair);
    for (const [from, to] of [[near, far], [far, near]]) {
      from.on("data", (bytes) => isFrozen || to.write(bytes));
      from.on("error", () => to.destroy());
      from.on("close", () => (to.destroy(), pairs.delete(pair)));
    }
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  const cut = () => [...pairs].flat().forEach((socket) => socket.destroy());
  return {
    address: address.replace(target.host, `127.0.0.1:${server.address().port}`),
    freeze: () => (isFrozen = true),
    // What was lost meanwhile is lost: these streams cannot go on.
    thaw: () => ((isFrozen = false), cut()),
    close: () => (server.close(), cut()),
  };
}

/** Marks the cell of the cursor as a strong clue, or as searched by others. */
export async function marks(page, key, note = "") {
  const answer = key === "c" ? /^Clue in cell / : /marked as searched by others/;
  await answered(page, async () => {
    await page.keyboard.press(key);
    if (key === "c") await page.locator("#mark-ratio").selectOption("50");
    else await page.locator("#mark-pod").fill("98");
    await page.locator("#mark-note").fill(note);
    await page.keyboard.press("Enter");
  }, answer);
}
