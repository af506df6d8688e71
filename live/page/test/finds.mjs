// Finds that the operator confirms and dismisses, and who has the commands.

import assert from "node:assert/strict";

import { address, answered, browse, cells, marks, moveTo, shot, states, text, until } from "./browse.mjs";

const row = (page, name) => page.locator("#objects tbody tr", { hasText: name });
const press = (page, name, button) => row(page, name).getByRole("button", { name: button, exact: true }).click();
const commands = (page) => page.locator("#orders li").allTextContents();

/** Marks a cell until it is a find. */
async function find(page, line, column) {
  await moveTo(page, line, column);
  for (let times = 0; times < 4; times += 1) await marks(page, "c");
}

/** One find is confirmed in the list and stays; another is dismissed in the banner, undone, and dismissed again. */
export async function finds() {
  await browse(address, {}, async (page) => {
    await until("robots search", async () => (await states(page)).every((state) => state === "searching"));
    await page.keyboard.press("Shift+P");
    await until("all robots are paused", async () => (await states(page)).every((state) => state === "paused"));
    await until("all have the pause", async () => (await text(page, "acknowledged")) === "All robots have it.");
    assert.match((await commands(page))[0], /^\d+:\d\d Pause: all robots have it$/);

    await find(page, 16, 19);
    const stays = "585 m east, 495 m north";
    await until("the first find", async () => (await row(page, stays).count()) === 1);
    await answered(page, () => press(page, stays, "Confirm"), /\[16, 19\] is confirmed/);
    await until("it is confirmed", async () => /✓ confirmed/.test(await row(page, stays).textContent()));
    await until("all have it", async () => /Find \[16, 19\] confirmed: all robots have it/.test((await commands(page))[0]));
    for (let times = 0; times < 9; times += 1) await marks(page, "s");
    await until("the marks count", async () => (await text(page, "marks")) === "13");
    assert.match(await row(page, stays).textContent(), /✓ confirmed.*> 99\.9 %/, "nothing withdraws it");
    assert.match(await text(page, "cell"), /found, confirmed by hand/);

    await find(page, 2, 3);
    const goes = "105 m east, 75 m north";
    await until("a banner", async () => /cell \[2, 3\]/.test(await text(page, "find-text")));
    await shot(page, "find_decide.png");
    await answered(page, () => page.locator("#find-dismiss").click(), /\[2, 3\] is dismissed/);
    await until("it is dismissed", async () => /✕ dismissed/.test(await row(page, goes).textContent()));
    assert.ok(await page.locator("#find").isHidden(), "the operator knows");
    assert.match(await text(page, "cell"), /a find there was dismissed by hand/);
    await answered(page, () => press(page, goes, "Undo"), /\[2, 3\] is open again/);
    await until("it is a find again", async () => (await row(page, goes).getByRole("button", { name: "Confirm" }).count()) === 1);
    assert.ok(await page.locator("#find").isHidden(), "which is no news");
    await answered(page, () => press(page, goes, "Dismiss"), /\[2, 3\] is dismissed/);
    await until("all have it", async () => /Find \[2, 3\] dismissed: all robots have it/.test((await commands(page))[0]));
    assert.equal((await commands(page)).length, 5);
    await shot(page, "finds.png");

    // A recording and other programs get no unknown finds.
    const ask = (body) => page.evaluate((body) => fetch("command", {
      method: "POST", headers: { Authorization: `Bearer ${new URLSearchParams(location.hash.slice(1)).get("token")}` }, body,
    }).then((it) => it.status), body);
    assert.equal(await ask('{"command":"find","row":2,"column":3,"as":"undone"}'), 200);
    await until("undone from elsewhere", async () => !/dismissed/.test(await row(page, goes).textContent()));
    assert.equal(await ask('{"command":"find","row":2,"column":3,"as":"dismissed"}'), 200);
    await until("dismissed from elsewhere", async () => /✕ dismissed/.test(await row(page, goes).textContent()));

    const stopped = await cells(page);
    await page.locator("#pause").click();
    await until("robots go on", async () => (await cells(page)).some((cell, index) => cell !== stopped[index]));
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
