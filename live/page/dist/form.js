import { element } from "./panel.js";
export function form(id, done) {
    const dialog = element(id, HTMLDialogElement);
    dialog.addEventListener("keydown", (event) => event.stopPropagation());
    dialog.addEventListener("close", () => {
        if (dialog.returnValue === "done")
            done();
    });
    return dialog;
}
