import { element } from "./panel.js";
export function dialog(id, closed) {
    const dialog = element(id, HTMLDialogElement);
    dialog.addEventListener("keydown", (event) => event.stopPropagation());
    dialog.addEventListener("close", () => closed(dialog.returnValue));
    return dialog;
}
export function form(id, done) {
    return dialog(id, (by) => {
        if (by === "done")
            done();
    });
}
