// The end of the mission: it is asked for twice, so that no mission ends by accident.

import { form } from "./form.js";
import { element } from "./panel.js";
import type { Mission } from "./mission.js";
import { named } from "./orders.js";

/** Asks whether the mission is to end. */
export class EndForm {
  private readonly dialog = form("end-form", () => this.given?.());
  private given: (() => void) | undefined;

  /** Opens the form; `given` is called if the mission is to end: at once, if it is ending already. */
  open(mission: Mission | undefined, given: () => void): void {
    this.given = given;
    const awaited = mission?.frame?.ending;
    const [title, text, done] = awaited === undefined ? FIRST : now(awaited);
    element("end-title", HTMLElement).textContent = title;
    element("end-text", HTMLElement).textContent = text;
    element("end-done", HTMLButtonElement).textContent = done;
    this.dialog.returnValue = "";
    this.dialog.showModal();
    element("end-cancel", HTMLButtonElement).focus();
  }
}

type Words = readonly [title: string, text: string, done: string];

const FIRST: Words = [
  "End the mission?",
  "All robots return to their bases. Once they are back the recording is finished, and nothing can be ordered any more. Until then any other order to all of them takes the end back.",
  "End mission",
];

function now(awaited: number[]): Words {
  const text = "The recording is finished, and nothing can be ordered any more. Robots that have the order still return to their bases; what they have not told is not recorded.";
  if (awaited.length === 0) return ["End now?", text, "End now"];
  return [`End now, without ${named(awaited)}?`, text, "End now"];
}
