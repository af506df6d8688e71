import { Api, Refusal } from "./api.js";
const NEWS_MS = 1000;
const MOST_UNDO = 50;
export class Store {
    listener;
    state;
    mayChange = false;
    api = new Api();
    past = [];
    last = Promise.resolve();
    waiting = 0;
    isLost = false;
    constructor(listener) {
        this.listener = listener;
    }
    async begin() {
        this.mayChange = await this.api.mayChange();
        await this.load();
        if (!this.mayChange)
            this.listener.said("Read-only: open the address with its token to change the plan.", true);
        setInterval(() => void this.ask(), NEWS_MS);
    }
    get canUndo() {
        return this.past.length > 0;
    }
    change(act) {
        return this.request(async (state) => {
            const plan = structuredClone(state.plan);
            act(plan);
            const next = await this.api.post("change", { revision: state.revision, plan });
            if (next.revision !== state.revision)
                this.past = [...this.past, state.plan].slice(-MOST_UNDO);
            return next;
        });
    }
    undo() {
        return this.request(async (state) => {
            const plan = this.past.pop();
            return plan === undefined ? state : this.api.post("change", { revision: state.revision, plan });
        });
    }
    import(name, content, replaces) {
        return this.request(async (state) => {
            const next = await this.api.post("import", { revision: state.revision, name, content, replaces });
            this.past = [...this.past, state.plan].slice(-MOST_UNDO);
            return next;
        });
    }
    forecast(robots, missions) {
        return this.request(() => this.api.post("forecast", { robots, missions }));
    }
    cancel() {
        return this.request(() => this.api.post("cancel", {}));
    }
    save(overwrite, refused) {
        return this.request(async (state) => {
            try {
                return await this.api.post("save", { revision: state.revision, overwrite });
            }
            catch (error) {
                if (error instanceof Refusal && error.existing.length > 0)
                    refused(error.existing);
                throw error;
            }
        });
    }
    simulate() {
        return this.request(async (state) => {
            const { address } = await this.api.post("simulate", {});
            const there = new URL(address);
            there.hostname = location.hostname;
            location.assign(there);
            return state;
        });
    }
    request(act) {
        this.waiting += 1;
        const run = async () => {
            try {
                if (this.state === undefined)
                    return;
                this.state = await act(this.state);
                this.listener.said(this.state.message ?? "", false);
            }
            catch (error) {
                this.listener.said(error instanceof Error ? sentence(error.message) : String(error), true);
                if (error instanceof Refusal && error.status === 409 && error.existing.length === 0)
                    await this.load();
            }
            finally {
                this.waiting -= 1;
                this.listener.changed();
            }
        };
        const next = this.last.then(run);
        this.last = next;
        return next;
    }
    async load() {
        try {
            this.state = await this.api.state();
        }
        catch (error) {
            this.listener.said(String(error instanceof Error ? error.message : error), true);
        }
        this.listener.changed();
    }
    async ask() {
        if (this.waiting > 0 || this.state === undefined)
            return;
        try {
            const news = await this.api.news();
            if (this.waiting > 0)
                return;
            if (this.isLost)
                this.listener.said("", false);
            this.isLost = false;
            if (news.revision !== this.state.revision)
                await this.load();
            else if (JSON.stringify(news.forecast) !== JSON.stringify(this.state.forecast)) {
                this.state.forecast = news.forecast;
                this.listener.changed();
            }
        }
        catch (error) {
            if (!this.isLost)
                this.listener.said(error instanceof Error ? error.message : String(error), true);
            this.isLost = true;
        }
    }
}
export function sentence(text) {
    const whole = /^\p{L}+ /u.test(text) ? text.charAt(0).toUpperCase() + text.slice(1) : text;
    return /[.?!]$/.test(whole) ? whole : `${whole}.`;
}
