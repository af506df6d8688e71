// Dialogs that ask for something before it is done.

import { element } from "./panel.js";

/** The dialog of an id; `done` is called when it is closed by its button with the value `done`. */
export function form(id: string, done: () => void): HTMLDialogElement {
  const dialog = element(id, HTMLDialogElement);
  // What is typed here is no command.
  dialog.addEventListener("keydown", (event) => event.stopPropagation());
  dialog.addEventListener("close", () => {
    if (dialog.returnValue === "done") done();
  });
  return dialog;
}
