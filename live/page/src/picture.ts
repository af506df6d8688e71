// Pictures of finds: a small one where the find is, and a large one in a dialog, in which the operator decides.

import { dialog } from "./form.js";
import { type Mission, type Picture, clock } from "./mission.js";
import { element } from "./panel.js";
import { coordinates, within } from "./place.js";

type Decision = "confirmed" | "dismissed";

/** What a picture shows, in words. */
function caption(mission: Mission, cell: number, picture: Picture): string {
  const seen = picture.seen === "" ? "" : `${picture.seen}; `;
  const place = `${coordinates(mission.hello, mission.where(cell))}${within(mission, cell)} (cell ${mission.name(cell)})`;
  return `${seen}${place}, by robot ${picture.robot}'s camera ${picture.camera} at ${clock(picture.time)}`;
}

/** Shows a picture on its button, or hides that. */
export function thumbnail(button: HTMLButtonElement, picture: Picture | undefined, open: () => void): void {
  button.hidden = picture === undefined;
  if (picture === undefined) return;
  let image = button.querySelector("img");
  if (image === null) {
    image = button.appendChild(document.createElement("img"));
    image.alt = "Picture of the find: show it large";
  }
  if (image.getAttribute("src") !== picture.file) image.src = picture.file;
  button.onclick = open;
}

/** The dialog with one picture. */
export class PictureView {
  private readonly dialog: HTMLDialogElement;
  private cell: number | undefined;

  constructor(decide: (cell: number, as: Decision) => void) {
    this.dialog = dialog("picture", (as) => {
      if (this.cell !== undefined && (as === "confirmed" || as === "dismissed")) decide(this.cell, as);
      this.cell = undefined;
    });
  }

  open(mission: Mission, cell: number, picture: Picture): void {
    this.cell = cell;
    this.dialog.returnValue = "";
    this.show(mission, cell, picture);
    this.dialog.showModal();
  }

  /** A find has another picture, or decisions are possible no more. */
  update(mission: Mission, pictures: Map<number, Picture>, reason: string | undefined, isOpen: (cell: number) => boolean): void {
    if (this.cell === undefined) return;
    const picture = pictures.get(this.cell);
    if (picture !== undefined) this.show(mission, this.cell, picture);
    for (const id of ["picture-confirm", "picture-dismiss"]) {
      const button = element(id, HTMLButtonElement);
      button.hidden = !isOpen(this.cell);
      button.disabled = reason !== undefined;
      button.title = reason ?? "";
    }
  }

  private show(mission: Mission, cell: number, picture: Picture): void {
    const image = element("picture-image", HTMLImageElement);
    if (image.getAttribute("src") !== picture.file) image.src = picture.file;
    const text = caption(mission, cell, picture);
    image.alt = text;
    element("picture-text", HTMLElement).textContent = text;
  }
}
