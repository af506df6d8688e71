// Compiles the page, and copies its libraries beside it, unchanged and with their licenses.
//
// Usage: npm run build [-- --outDir FOLDER]; the folder is `dist` unless it is given.

import { execFileSync } from "node:child_process";
import { copyFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { parseArgs } from "node:util";

const FILES = {
  "leaflet/dist/leaflet.js": "leaflet.js",
  "leaflet/dist/leaflet.css": "leaflet.css",
  "leaflet/LICENSE": "leaflet.LICENSE.txt",
  "mgrs/dist/mgrs.esm.js": "mgrs.js",
  "mgrs/license.md": "mgrs.LICENSE.txt",
};

const { values } = parseArgs({ options: { outDir: { type: "string", default: "dist" } } });
const folder = resolve(values.outDir);
execFileSync("tsc", ["--project", "tsconfig.json", "--outDir", folder], { stdio: "inherit" });
for (const [from, to] of Object.entries(FILES)) {
  copyFileSync(join("node_modules", from), join(folder, to));
}
