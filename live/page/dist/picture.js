import { dialog } from "./form.js";
import { clock } from "./mission.js";
import { element } from "./panel.js";
import { coordinates, within } from "./place.js";
function caption(mission, cell, picture) {
    const seen = picture.seen === "" ? "" : `${picture.seen}; `;
    const place = `${coordinates(mission.hello, mission.where(cell))}${within(mission, cell)} (cell ${mission.name(cell)})`;
    return `${seen}${place}, by robot ${picture.robot}'s camera ${picture.camera} at ${clock(picture.time)}`;
}
export function thumbnail(button, picture, open) {
    button.hidden = picture === undefined;
    if (picture === undefined)
        return;
    let image = button.querySelector("img");
    if (image === null) {
        image = button.appendChild(document.createElement("img"));
        image.alt = "Picture of the find: show it large";
    }
    if (image.getAttribute("src") !== picture.file)
        image.src = picture.file;
    button.onclick = open;
}
export class PictureView {
    dialog;
    cell;
    constructor(decide) {
        this.dialog = dialog("picture", (as) => {
            if (this.cell !== undefined && (as === "confirmed" || as === "dismissed"))
                decide(this.cell, as);
            this.cell = undefined;
        });
    }
    open(mission, cell, picture) {
        this.cell = cell;
        this.dialog.returnValue = "";
        this.show(mission, cell, picture);
        this.dialog.showModal();
    }
    update(mission, pictures, reason, isOpen) {
        if (this.cell === undefined)
            return;
        const picture = pictures.get(this.cell);
        if (picture !== undefined)
            this.show(mission, this.cell, picture);
        for (const id of ["picture-confirm", "picture-dismiss"]) {
            const button = element(id, HTMLButtonElement);
            button.hidden = !isOpen(this.cell);
            button.disabled = reason !== undefined;
            button.title = reason ?? "";
        }
    }
    show(mission, cell, picture) {
        const image = element("picture-image", HTMLImageElement);
        if (image.getAttribute("src") !== picture.file)
            image.src = picture.file;
        const text = caption(mission, cell, picture);
        image.alt = text;
        element("picture-text", HTMLElement).textContent = text;
    }
}
