// The page of a recording.

import assert from "node:assert/strict";

import { address, browse, cells, picture, seconds, settle, shot, text, until } from "./browse.mjs";

/** A recording plays, stops, and shows the same at a time from any other time. */
export async function replay() {
  await browse(address, {}, async (page) => {
    assert.ok(await page.locator("#controls").isHidden());
    await page.locator("#engineering summary").click();
    const slider = page.locator("#slider");
    const end = Number(await slider.getAttribute("max"));
    const seek = async (share) => {
      const to = Math.round(end * share);
      await slider.fill(String(to));
      await until(`it is ${to} s`, async () => (await seconds(page)) === to && (await slider.inputValue()) === String(to));
      await settle(page);
      return [await picture(page), await cells(page), await text(page, "entropy"), await page.locator("#entropy-chart").evaluate((chart) => chart.toDataURL())];
    };
    const middle = await seek(0.5);
    await shot(page, "replay.png");
    const late = await seek(0.9);
    assert.notDeepEqual(late, middle);
    assert.deepEqual(await seek(0.5), middle, "back to the same picture");
    const early = await seek(0.1);
    assert.notDeepEqual(early, middle);
    await page.locator("#layers summary").click();
    await page.locator("#layer-plans").uncheck();
    await settle(page);
    assert.notDeepEqual(await picture(page), early[0], "without plans");
    await page.locator("#layer-plans").check();
    await page.locator("#layers summary").click();
    assert.deepEqual(await seek(0.5), middle, "on to the same picture");
    await page.locator("#speed").selectOption("50");
    await page.locator("#play").click();
    await until("it plays", async () => (await seconds(page)) > 0.5 * end + 20);
    await page.locator("#play").click();
    await slider.focus();
    await page.keyboard.press("Home");
    await until("a key moves the slider", async () => (await seconds(page)) === 0);
    await stays(page, seek, end);
    await jumps(page, end);
  });
}

/** After it has played to its end a recording stays where the viewer goes. */
async function stays(page, seek, end) {
  await seek(0.95);
  await page.locator("#speed").selectOption("500");
  await page.locator("#play").click();
  await until("it stops at its end", async () => (await text(page, "play")) === "Play" && (await seconds(page)) === Math.floor(end));
  await seek(0.3);
  // Longer than a silence that makes the page stale.
  await new Promise((done) => setTimeout(done, 4000));
  assert.equal(await seconds(page), Math.round(0.3 * end), "it does not run away");
  assert.equal(await text(page, "state"), "recording", "the server says that nothing changes");
}

/** From find to find, and from the list to the place on the map. */
async function jumps(page, end) {
  await page.locator("#slider").fill("0");
  await until("the start", async () => (await seconds(page)) === 0 && (await page.locator("#find-before").isDisabled()));
  const finds = () => page.locator("#objects tbody tr").count();
  assert.equal(await finds(), 0);
  await page.locator("#find-after").click();
  await until("the first find", async () => (await finds()) > 0);
  assert.ok(await page.locator("#find").isHidden(), "a jump is no news");
  const first = await seconds(page);
  assert.ok(first > 0 && first < end);
  await page.keyboard.press("]");
  await until("the second find", async () => (await seconds(page)) > first);
  await page.keyboard.press("[");
  await until("back to the first", async () => (await seconds(page)) === first);
  const before = await page.locator(".leaflet-control-scale-line").textContent();
  for (let times = 0; times < 4; times += 1) await page.locator("#zoom-out").click();
  await page.locator("#objects .go").first().click();
  await until("the cursor is there", async () => /found/.test(await text(page, "cell")));
  assert.match(await page.locator("#objects .go").first().textContent(), /^[\d.]+ m east, [\d.]+ m north$/);
  assert.match(await page.locator("#objects tbody tr").first().textContent(), /m north\d+:\d\d[123](> )?\d+/, "time and robot");
  await page.locator("#whole").click();
  assert.equal(await page.locator(".leaflet-control-scale-line").textContent(), before);
}

/** A find that plays raises a banner and a sound, unless that is off; the choice is kept. */
export async function sound() {
  const started = (page) => page.evaluate(() => window.tones);
  await browse(address, {}, async (page, context) => {
    await context.addInitScript(() => {
      window.tones = 0;
      const start = OscillatorNode.prototype.start;
      OscillatorNode.prototype.start = function count(...times) {
        window.tones += 1;
        return start.apply(this, times);
      };
    });
    await page.reload();
    await page.locator("#robots tbody tr").first().waitFor();
    const play = async () => {
      await page.locator("#slider").fill("0");
      await until("the start", async () => (await seconds(page)) === 0);
      assert.ok(await page.locator("#find").isHidden());
      await page.locator("#speed").selectOption("25");
      await page.locator("#play").click();
      await until("a find is announced", async () => /Find at .* m north \(cell \[\d+, \d+\]\) at \d+:\d\d by robot [123], probability (> )?9/.test(await text(page, "find-text")));
      await page.locator("#play").click();
    };
    await play();
    assert.ok((await started(page)) >= 2, "two tones");
    await shot(page, "find.png");
    await page.locator("#find-show").click();
    await until("the map goes there", async () => /found/.test(await text(page, "cell")));
    await page.locator("#find-close").click();
    assert.ok(await page.locator("#find").isHidden());

    await page.locator("#sound").click();
    assert.equal(await text(page, "sound"), "Sound off");
    await page.reload();
    await page.locator("#robots tbody tr").first().waitFor();
    assert.equal(await text(page, "sound"), "Sound off", "the choice is kept");
    await play();
    assert.equal(await started(page), 0);
  });
}
