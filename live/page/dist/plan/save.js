import { element } from "../panel.js";
const MOST_BYTES = 16 * 1024 * 1024;
export class Files {
    events;
    overwrite = element("overwrite", HTMLButtonElement);
    revision = 0;
    constructor(events) {
        this.events = events;
        const file = element("file", HTMLInputElement);
        element("open", HTMLButtonElement).addEventListener("click", () => file.click());
        file.addEventListener("change", () => {
            for (const it of file.files ?? [])
                void this.open(it);
            file.value = "";
        });
        const stage = element("stage", HTMLElement);
        stage.addEventListener("dragover", (event) => event.preventDefault());
        stage.addEventListener("drop", (event) => {
            event.preventDefault();
            for (const it of event.dataTransfer?.files ?? [])
                void this.open(it);
        });
        element("save", HTMLButtonElement).addEventListener("click", () => this.save(false));
        this.overwrite.addEventListener("click", () => this.save(true));
        element("simulate", HTMLButtonElement).addEventListener("click", () => events.simulate());
    }
    draw({ saved, folder, review, revision, plan }, mayChange) {
        if (revision !== this.revision)
            this.overwrite.hidden = true;
        this.revision = revision;
        const canSave = mayChange && review.problems.length === 0;
        element("save", HTMLButtonElement).disabled = !canSave;
        element("simulate", HTMLButtonElement).disabled = !canSave || saved?.is_current !== true;
        element("open", HTMLButtonElement).disabled = !mayChange;
        const name = `${plan.scenario.name}.toml`;
        const state = saved === null ? `Not saved yet. ${name} and its areas go to ${folder}.`
            : saved.is_current ? `Saved as ${saved.scenario} in ${folder}. Search with: dragnet run ${saved.scenario}`
                : `Changed since it was saved as ${saved.scenario}.`;
        element("saved", HTMLElement).textContent = state;
    }
    save(overwrite) {
        this.overwrite.hidden = true;
        this.events.save(overwrite, (existing) => {
            this.overwrite.hidden = false;
            this.overwrite.textContent = `Overwrite ${existing.join(" and ")}`;
        });
    }
    async open(file) {
        if (file.size > MOST_BYTES) {
            this.events.said(`${file.name} has ${file.size} bytes; allowed are at most ${MOST_BYTES}.`, true);
            return;
        }
        const replaces = element("replaces", HTMLInputElement).checked;
        this.events.opened(file.name, await base64(file), replaces);
    }
}
function base64(file) {
    return new Promise((done, failed) => {
        const reader = new FileReader();
        reader.onload = () => done(String(reader.result).split(",")[1] ?? "");
        reader.onerror = () => failed(reader.error);
        reader.readAsDataURL(file);
    });
}
