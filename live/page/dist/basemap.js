import { degrees, spotAt } from "./place.js";
import { Sheet } from "./view.js";
export const TILE_URL = "basemap/{z}/{x}/{y}";
const SIDE = 256;
const MOST_IN_VIEW = 120;
const MOST_KEPT = 400;
const COARSER = 4;
const EQUATOR_METERS = 40_075_016.686;
const MOST_LATITUDE = 85.05;
export async function basemap() {
    try {
        const answer = await fetch("basemap");
        const about = answer.ok ? (await answer.json()) : null;
        if (about === null)
            return undefined;
        const line = document.getElementById("attribution");
        if (line !== null)
            line.textContent = about.attribution;
        return about;
    }
    catch {
        return undefined;
    }
}
export class BaseMap {
    changed;
    sheet;
    tiles = new Map();
    about;
    constructor(map, changed) {
        this.changed = changed;
        this.sheet = new Sheet(map, "basemap", 300);
        void basemap().then((about) => {
            this.about = about;
            changed();
        });
    }
    isFor(mission) {
        return this.about !== undefined && mission.hello.earth !== null;
    }
    draw(mission, view, isShown) {
        const context = this.sheet.begin();
        if (!isShown || this.about === undefined || mission.hello.earth === null)
            return;
        const seen = this.inView(this.about, mission, view);
        if (seen === undefined)
            return;
        const { zoom, west, east, north, south } = seen;
        for (let row = north; row <= south; row += 1) {
            for (let column = west; column <= east; column += 1)
                this.drawTile(context, mission, view, [zoom, column, row]);
        }
        for (const key of this.tiles.keys()) {
            if (this.tiles.size <= MOST_KEPT)
                break;
            this.tiles.delete(key);
        }
    }
    inView(about, mission, view) {
        const corners = [[0, 0], [view.width, 0], [0, view.height], [view.width, view.height]];
        const [x, y] = view.at([0, 0]);
        const place = ([right, down]) => degrees(mission.hello, [(right - x) / view.size, (y - down) / view.size]) ?? [0, 0];
        const places = corners.map(place);
        const latitudes = places.map(([latitude]) => Math.min(Math.max(latitude, -MOST_LATITUDE), MOST_LATITUDE));
        const longitudes = places.map(([, longitude]) => longitude);
        const middle = ((Math.min(...latitudes) + Math.max(...latitudes)) / 2) * (Math.PI / 180);
        const pixelMeters = mission.hello.cell_meters / view.size;
        const fitting = Math.round(Math.log2((EQUATOR_METERS * Math.cos(middle)) / (SIDE * pixelMeters * (window.devicePixelRatio || 1))));
        const zoom = Math.min(Math.max(fitting, about.min_zoom), about.max_zoom);
        const columns = longitudes.map((it) => column(it, zoom));
        const rows = latitudes.map((it) => row(it, zoom));
        const most = 2 ** zoom - 1;
        const within = (value) => Math.min(Math.max(Math.floor(value), 0), most);
        const seen = {
            zoom, west: within(Math.min(...columns)), east: within(Math.max(...columns)),
            north: within(Math.min(...rows)), south: within(Math.max(...rows)),
        };
        const count = (seen.east - seen.west + 1) * (seen.south - seen.north + 1);
        return count <= MOST_IN_VIEW ? seen : undefined;
    }
    drawTile(context, mission, view, [zoom, x, y]) {
        const corner = (east, south) => {
            const spot = spotAt(mission.hello, [latitude(y + south, zoom), longitude(x + east, zoom)]);
            return spot === undefined ? undefined : view.at(spot);
        };
        const [at, right, below] = [corner(0, 0), corner(1, 0), corner(0, 1)];
        if (at === undefined || right === undefined || below === undefined)
            return;
        this.load(zoom, x, y);
        for (let up = 0; up <= COARSER && zoom - up >= 0; up += 1) {
            const image = this.tiles.get(`${zoom - up}/${x >> up}/${y >> up}`);
            if (image === undefined || !image.complete || image.naturalWidth === 0)
                continue;
            const [wide, high, parts] = [image.naturalWidth, image.naturalHeight, 2 ** up];
            const [left, top] = [(x % parts) * (wide / parts), (y % parts) * (high / parts)];
            context.save();
            context.transform(right[0] - at[0], right[1] - at[1], below[0] - at[0], below[1] - at[1], at[0], at[1]);
            context.drawImage(image, left, top, wide / parts, high / parts, 0, 0, 1.003, 1.003);
            context.restore();
            return;
        }
    }
    load(zoom, x, y) {
        const key = `${zoom}/${x}/${y}`;
        const known = this.tiles.get(key);
        if (known !== undefined) {
            this.tiles.delete(key);
            this.tiles.set(key, known);
            return;
        }
        const image = new Image();
        this.tiles.set(key, image);
        image.addEventListener("load", this.changed);
        image.src = `basemap/${key}`;
    }
}
function column(degrees, zoom) {
    return ((degrees + 180) / 360) * 2 ** zoom;
}
function row(degrees, zoom) {
    return ((1 - Math.asinh(Math.tan(degrees * (Math.PI / 180))) / Math.PI) / 2) * 2 ** zoom;
}
function longitude(column, zoom) {
    return (column / 2 ** zoom) * 360 - 180;
}
function latitude(row, zoom) {
    return Math.atan(Math.sinh(Math.PI * (1 - (2 * row) / 2 ** zoom))) * (180 / Math.PI);
}
