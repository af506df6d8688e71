// Copies the libraries of the page, unchanged, with their licenses, beside the compiled page.

import { copyFileSync } from "node:fs";

const FILES = {
  "leaflet/dist/leaflet.js": "leaflet.js",
  "leaflet/dist/leaflet.css": "leaflet.css",
  "leaflet/LICENSE": "leaflet.LICENSE.txt",
  "mgrs/dist/mgrs.esm.js": "mgrs.js",
  "mgrs/license.md": "mgrs.LICENSE.txt",
};

for (const [from, to] of Object.entries(FILES)) {
  copyFileSync(new URL(`node_modules/${from}`, import.meta.url), new URL(`dist/${to}`, import.meta.url));
}
