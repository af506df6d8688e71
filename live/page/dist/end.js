import { form } from "./form.js";
import { element } from "./panel.js";
import { named } from "./orders.js";
export class EndForm {
    dialog = form("end-form", () => this.given?.());
    given;
    open(mission, given) {
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
const FIRST = [
    "End the mission?",
    "All robots return to their bases. Once they are back the recording is finished, and nothing can be ordered any more. Until then any other order to all of them takes the end back.",
    "End mission",
];
function now(awaited) {
    const text = "The recording is finished, and nothing can be ordered any more. Robots that have the order still return to their bases; what they have not told is not recorded.";
    if (awaited.length === 0)
        return ["End now?", text, "End now"];
    return [`End now, without ${named(awaited)}?`, text, "End now"];
}
