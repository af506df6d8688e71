// Dialogs that ask for something before it is done.

import { element } from "./panel.js";

/** The dialog of an id; `closed` is called with the value of the button that has closed it. */
export function dialog(id: string, closed: (by: string) => void): HTMLDialogElement {
  const dialog = element(id, HTMLDialogElement);
  // What is typed here is no command.
  dialog.addEventListener("keydown", (event) => event.stopPropagation());
  dialog.addEventListener("close", () => closed(dialog.returnValue));
  return dialog;
}

/** The same, in which `done` is called when it is closed by its button with the value `done`. */
export function form(id: string, done: () => void): HTMLDialogElement {
  return dialog(id, (by) => {
    if (by === "done") done();
  });
}
