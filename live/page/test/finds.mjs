// Finds that the operator confirms and dismisses, and who has the commands.

import assert from "node:assert/strict";

import { address, answered, browse, marks, moveTo, shot, states, text, until } from "./browse.mjs";

const row = (page, name) => page.locator("#objects tbody tr", { hasText: name });
const press = (page, name, button) => row(page, name).getByRole("button", { name: button, exact: true }).click();
const commands = (page) => page.locator("#orders li").allTextContents();

/** The finds of the list, the newest first: what their places are called, and their cells. */
const listed = (page) => page.locator("#objects tbody .go").evaluateAll((all) =>
  all.map((it) => [it.textContent, /cell (\[\d+, \d+\])/.exec(it.title)[1]]));

/** Moves the cursor to a cell, `[3, 4]`. */
const goTo = (page, cell) => moveTo(page, ...JSON.parse(cell));

/** One find is confirmed in the list and stays; another is dismissed in the banner, undone, and dismissed again. */
export async function finds() {
  await browse(address, {}, async (page) => {
    const said = () => text(page, "find-text");
    await until("robots find", async () => (await listed(page)).length > 1 && /^Find at /.test(await said()));
    await page.keyboard.press("Shift+P");
    await until("all robots are paused", async () => (await states(page)).every((state) => state === "paused"));
    await until("all have the pause", async () => (await text(page, "acknowledged")) === "All robots have it.");
    assert.match((await commands(page))[0], /^\d+:\d\d Pause: all robots have it$/);

    const [, second] = /cell (\[\d+, \d+\])/.exec(await said());
    const [goes] = (await listed(page)).find(([, cell]) => cell === second);
    const [stays, first] = (await listed(page)).find(([, cell]) => cell !== second);
    await goTo(page, first);
    await answered(page, () => press(page, stays, "Confirm"), /The find in cell .* is confirmed/);
    await until("it is confirmed", async () => /✓ confirmed/.test(await row(page, stays).textContent()));
    const has = async (what) => (await commands(page))[0].endsWith(`${what}: all robots have it`);
    await until("all have it", () => has(`Find ${first} confirmed`));
    for (let times = 0; times < 9; times += 1) await marks(page, "s");
    await until("the marks count", async () => (await text(page, "marks")) === "9");
    assert.match(await row(page, stays).textContent(), /✓ confirmed.*> 99\.9 %/, "nothing withdraws it");
    assert.match(await text(page, "cell"), /found, confirmed by hand/);

    await goTo(page, second);
    await shot(page, "find_decide.png");
    await answered(page, () => page.locator("#find-dismiss").click(), /is dismissed/);
    await until("it is dismissed", async () => /✕ dismissed/.test(await row(page, goes).textContent()));
    const place = `cell ${second}`;
    assert.ok(!(await said()).includes(place), "the operator knows");
    assert.match(await text(page, "cell"), /a find there was dismissed by hand/);
    await answered(page, () => press(page, goes, "Undo"), /is open again/);
    await until("it is a find again", async () => (await row(page, goes).getByRole("button", { name: "Confirm" }).count()) === 1);
    assert.ok(!(await said()).includes(place), "which is no news");
    await answered(page, () => press(page, goes, "Dismiss"), /is dismissed/);
    await until("all have it", () => has(`Find ${second} dismissed`));
    assert.equal((await commands(page)).length, 5);
    await shot(page, "finds.png");

    // A recording and other programs get no unknown finds.
    const ask = (body) => page.evaluate((body) => fetch("command", {
      method: "POST", headers: { Authorization: `Bearer ${new URLSearchParams(location.hash.slice(1)).get("token")}` }, body,
    }).then((it) => it.status), body);
    const [line, column] = JSON.parse(second);
    assert.equal(await ask(JSON.stringify({ command: "find", row: line, column, as: "undone" })), 200);
    await until("undone from elsewhere", async () => !/dismissed/.test(await row(page, goes).textContent()));
    assert.equal(await ask(JSON.stringify({ command: "find", row: line, column, as: "dismissed" })), 200);
    await until("dismissed from elsewhere", async () => /✕ dismissed/.test(await row(page, goes).textContent()));
  });
}

/** Of three robots only the first is there: it has the pause, and the others are waited for. */
export async function cutOff() {
  await browse(address, {}, async (page) => {
    await until("robot 1 is heard", async () => (await states(page))[0] === "searching");
    await page.keyboard.press("Shift+P");
    await until("robot 1 has the pause", async () => (await text(page, "acknowledged")) === "Robot 1 has it; waiting for 2, 3.");
    assert.match((await commands(page))[0], /^\d+:\d\d Pause: robot 1 has it; waiting for 2, 3$/);
    await shot(page, "cut_off.png");
  });
}

/** A find has a picture, which is shown large, and in which the operator decides. */
export async function pictured() {
  await browse(address, {}, async (page) => {
    await page.keyboard.press("Shift+P");
    const small = page.locator("#find-picture img");
    await small.waitFor();
    await until("it is loaded", async () => (await small.evaluate((it) => it.naturalWidth)) === 120);
    assert.match(await text(page, "find-text"), /^Find at .* within (0\.5|1) m \(cell \[0, 0\]\) .* by robot 1/);
    const go = page.locator("#objects tbody .go");
    assert.match(await go.textContent(), / within (0\.5|1) m$/);
    assert.match(await go.getAttribute("title"), /95 of 100 objects are within that distance/);
    await shot(page, "find_picture.png");
    for (const [width, height] of [[390, 844], [1440, 900]]) {
      await page.setViewportSize({ width, height });
      await page.locator("#find-picture").click();
      const large = page.locator("#picture-image");
      assert.ok(await large.isVisible());
      assert.match(await text(page, "picture-text"), /^person, 0\.91; .* \(cell \[0, 0\]\), by robot 1's camera front at \d:\d\d$/);
      const inside = await page.locator("#picture").evaluate((it) => it.scrollWidth <= it.clientWidth && it.getBoundingClientRect().height <= innerHeight);
      assert.ok(inside, `it fits ${width} x ${height}`);
      await shot(page, `picture_${width}.png`);
      await page.keyboard.press("Escape");
      assert.ok(await large.isHidden());
    }
    assert.ok(await page.locator("#find").isVisible(), "closing decides nothing");
    await page.locator("#find-close").click();
    const file = await page.locator("#objects .picture img").getAttribute("src");
    const [status, type] = await page.evaluate((it) => fetch(it).then((got) => [got.status, got.headers.get("content-type")]), file);
    assert.deepEqual([status, type], [200, "image/jpeg"]);
    await page.locator("#objects .picture").click();
    await answered(page, () => page.locator("#picture-confirm").click(), /The find in cell .* is confirmed/);
    await until("it is confirmed", async () => /✓ confirmed/.test(await page.locator("#objects tbody tr").textContent()));
    await page.locator("#objects .picture").click();
    assert.ok(await page.locator("#picture-confirm").isHidden(), "it is decided");
    await page.locator("#picture-close").click();
  });
}
