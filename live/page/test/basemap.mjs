// Base maps: `tests/python/basemap.py` has painted a red disc on green tiles.

import assert from "node:assert/strict";

import { address, browse, shot, text, until } from "./browse.mjs";

/** Where the disc is, as the test in tests/live says. */
const [LATITUDE, LONGITUDE] = [49.2386, -2.2352];
/** A pixel of the page at these zooms is shorter, degrees. */
const NEAR = 6e-5;

/** Pixels of the middle of what is red on a map's canvas, or undefined. */
const disc = (page) => page.evaluate(() => {
  const canvas = document.querySelector("canvas#basemap");
  const { data, width, height } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const found = [];
  for (let index = 0; index < width * height; index += 1) {
    if (data[4 * index] > 200 && data[4 * index + 1] < 60 && data[4 * index + 3] > 200) found.push([index % width, Math.floor(index / width)]);
  }
  if (found.length === 0) return undefined;
  const ratio = canvas.clientWidth / width;
  return [0, 1].map((axis) => (found.reduce((sum, at) => sum + at[axis], 0) / found.length) * ratio);
});

/** The mission's page: the disc lies where the pointer reads its coordinates, at every zoom. */
export async function basemap() {
  // Of how this test reads pixels.
  await browse(address, { expected: [/willReadFrequently/] }, async (page) => {
    assert.equal(await text(page, "attribution"), "drawn by a test");
    const box = await page.locator("#ground").boundingBox();
    const lies = async () => {
      await until("the disc is drawn", async () => (await disc(page)) !== undefined);
      const [x, y] = await disc(page);
      await page.mouse.move(box.x + x, box.y + y);
      const read = () => text(page, "hover").then((it) => /(-?\d+\.\d{5}), (-?\d+\.\d{5})/.exec(it));
      await until("the pointer is over it", async () => {
        const [, latitude, longitude] = (await read()) ?? [];
        return Math.abs(latitude - LATITUDE) < NEAR && Math.abs(longitude - LONGITUDE) < NEAR;
      });
    };
    await lies();
    await shot(page, "basemap.png");
    await page.locator("#zoom-in").click();
    await lies();
    await page.locator("#layers summary").click();
    await page.locator("#layer-basemap").uncheck();
    await until("it can be left out", async () => (await disc(page)) === undefined);
    await page.locator("#layer-basemap").check();
    await until("and comes back", async () => (await disc(page)) !== undefined);
  });
}

/** The planning page: an empty plan begins where the base map is. */
export async function planOnBasemap() {
  await browse(address, { ready: "img.leaflet-tile-loaded" }, async (page) => {
    assert.equal(await text(page, "attribution"), "drawn by a test");
    const ground = await page.locator("#ground").boundingBox();
    await page.mouse.move(ground.x + ground.width / 2, ground.y + ground.height / 2);
    await until("it is over the base map", async () => {
      const [, latitude, longitude] = /(-?\d+\.\d+), (-?\d+\.\d+)/.exec(await text(page, "coordinates")) ?? [];
      return Math.abs(latitude - LATITUDE) < 0.05 && Math.abs(longitude - LONGITUDE) < 0.05;
    });
    await shot(page, "plan_basemap.png");
  });
}
