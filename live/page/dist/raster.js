import { mix, plainColors, probabilityColor, searchedColor } from "./colors.js";
const COVER = 0.65;
const OVER_MAP = 0.6;
export class Raster {
    canvas = document.createElement("canvas");
    key = "";
    isOnMap = false;
    mission;
    paint(mission, choice, isOnMap) {
        const plain = plainColors();
        const key = `${mission.version} ${choice.base} ${choice.no_go} ${isOnMap} ${plain.unsearched.join()}`;
        if (this.mission === mission && this.key === key)
            return;
        [this.mission, this.key] = [mission, key];
        const { rows, columns } = mission.hello;
        if (this.canvas.width !== columns || this.canvas.height !== rows) {
            this.canvas.width = columns;
            this.canvas.height = rows;
        }
        this.isOnMap = isOnMap;
        const image = new ImageData(columns, rows);
        const pixels = new Uint32Array(image.data.buffer);
        const colors = lookup(choice);
        const covered = choice.no_go ? colors.map((color) => mix(color, plain.blocked, COVER)) : colors;
        const [open, closed] = [colors.map(pixel), covered.map(pixel)];
        const unsearched = isOnMap ? 0 : pixel(plain.unsearched);
        const blocked = choice.no_go ? pixel(plain.blocked) : unsearched;
        const outOfReach = pixel(plain.outOfReach);
        const values = choice.base === "searched" ? mission.searched : mission.levels;
        for (let cell = 0; cell < rows * columns; cell += 1) {
            const isOpen = mission.isTraversable[cell] === 1;
            const value = values[cell] ?? 0;
            let color = isOpen ? unsearched : blocked;
            if (mission.levels[cell] !== 0)
                color = isOpen ? open[value] : closed[value];
            if (mission.isOutOfReach[cell] === 1)
                color = outOfReach;
            pixels[(rows - 1 - Math.floor(cell / columns)) * columns + (cell % columns)] = color ?? 0;
        }
        this.canvas.getContext("2d")?.putImageData(image, 0, 0);
    }
    draw(context, mission, view) {
        const { rows, columns } = mission.hello;
        const [x, y] = view.at([0, rows]);
        const within = (cells, most) => Math.min(Math.max(cells, 0), most);
        const [west, north] = [within(Math.floor(-x / view.size), columns), within(Math.floor(-y / view.size), rows)];
        const wide = within(Math.ceil((view.width - x) / view.size), columns) - west;
        const high = within(Math.ceil((view.height - y) / view.size), rows) - north;
        if (wide <= 0 || high <= 0)
            return;
        context.imageSmoothingEnabled = view.size < 1;
        const [left, top] = [x + west * view.size, y + north * view.size];
        context.globalAlpha = this.isOnMap ? OVER_MAP : 1;
        context.drawImage(this.canvas, west, north, wide, high, left, top, wide * view.size, high * view.size);
        context.globalAlpha = 1;
    }
}
function lookup(choice) {
    const color = choice.base === "searched" ? searchedColor : probabilityColor;
    return Array.from({ length: 256 }, (_, value) => color(value));
}
function pixel([red, green, blue]) {
    return ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
}
