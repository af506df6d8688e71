import { fit } from "./chart.js";
export function viewOf(map, hello) {
    const corner = map.latLngToContainerPoint([0, 0]);
    const size = hello.cell_meters * 2 ** map.getZoom();
    const { x: width, y: height } = map.getSize();
    return { size, width, height, at: ([east, north]) => [corner.x + east * size, corner.y - north * size] };
}
export class Sheet {
    map;
    canvas = document.createElement("canvas");
    constructor(map, id, zIndex) {
        this.map = map;
        const pane = map.createPane(id);
        pane.style.zIndex = String(zIndex);
        pane.style.pointerEvents = "none";
        this.canvas.id = id;
        pane.append(this.canvas);
    }
    begin() {
        const { x, y } = this.map.getSize();
        L.DomUtil.setPosition(this.canvas, this.map.containerPointToLayerPoint([0, 0]));
        this.canvas.style.width = `${x}px`;
        this.canvas.style.height = `${y}px`;
        const context = fit(this.canvas);
        context.clearRect(0, 0, x, y);
        return context;
    }
}
