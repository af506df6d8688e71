// The plan on the page: what the server keeps, and changes to it, one after the other.

import { Api, type Plan, Refusal, type State } from "./api.js";

/** Time between two questions for news, milliseconds. */
const NEWS_MS = 1000;
/** Number of changes that can be undone. */
const MOST_UNDO = 50;

export interface Listener {
  /** The plan, its review, the forecast, or what can be done has changed. */
  changed(): void;
  /** Something to say, or that went wrong. */
  said(message: string, isWrong: boolean): void;
}

export class Store {
  state: State | undefined;
  mayChange = false;
  private readonly api = new Api();
  private past: Plan[] = [];
  /** The last request; the next one waits for it. */
  private last: Promise<unknown> = Promise.resolve();
  private waiting = 0;
  private isLost = false;

  constructor(private readonly listener: Listener) {}

  async begin(): Promise<void> {
    this.mayChange = await this.api.mayChange();
    await this.load();
    if (!this.mayChange) this.listener.said("Read-only: open the address with its token to change the plan.", true);
    setInterval(() => void this.ask(), NEWS_MS);
  }

  get canUndo(): boolean {
    return this.past.length > 0;
  }

  /** Changes the plan; `act` changes a copy of it. */
  change(act: (plan: Plan) => void): Promise<void> {
    return this.request(async (state) => {
      const plan = structuredClone(state.plan);
      act(plan);
      const next = await this.api.post<State>("change", { revision: state.revision, plan });
      if (next.revision !== state.revision) this.past = [...this.past, state.plan].slice(-MOST_UNDO);
      return next;
    });
  }

  undo(): Promise<void> {
    return this.request(async (state) => {
      const plan = this.past.pop();
      return plan === undefined ? state : this.api.post<State>("change", { revision: state.revision, plan });
    });
  }

  import(name: string, content: string, replaces: boolean): Promise<void> {
    return this.request(async (state) => {
      const next = await this.api.post<State>("import", { revision: state.revision, name, content, replaces });
      this.past = [...this.past, state.plan].slice(-MOST_UNDO);
      return next;
    });
  }

  forecast(robots: number, missions: number): Promise<void> {
    return this.request(() => this.api.post<State>("forecast", { robots, missions }));
  }

  cancel(): Promise<void> {
    return this.request(() => this.api.post<State>("cancel", {}));
  }

  /** Saves the plan; `refused` is told of files that exist. */
  save(overwrite: boolean, refused: (existing: string[]) => void): Promise<void> {
    return this.request(async (state) => {
      try {
        return await this.api.post<State>("save", { revision: state.revision, overwrite });
      } catch (error) {
        if (error instanceof Refusal && error.existing.length > 0) refused(error.existing);
        throw error;
      }
    });
  }

  /** Starts a simulation of the saved plan, and leads to its page. */
  simulate(): Promise<void> {
    return this.request(async (state) => {
      const { address } = await this.api.post<{ address: string }>("simulate", {});
      const there = new URL(address);
      // The same computer, by the name by which this page is reached.
      there.hostname = location.hostname;
      location.assign(there);
      return state;
    });
  }

  /** Requests run one after the other, each on what the one before has left. */
  private request(act: (state: State) => Promise<State>): Promise<void> {
    this.waiting += 1;
    const run = async () => {
      try {
        if (this.state === undefined) return;
        this.state = await act(this.state);
        this.listener.said(this.state.message ?? "", false);
      } catch (error) {
        this.listener.said(error instanceof Error ? sentence(error.message) : String(error), true);
        // Of another window: the page shows what is.
        if (error instanceof Refusal && error.status === 409 && error.existing.length === 0) await this.load();
      } finally {
        this.waiting -= 1;
        this.listener.changed();
      }
    };
    const next = this.last.then(run);
    this.last = next;
    return next;
  }

  private async load(): Promise<void> {
    try {
      this.state = await this.api.state();
    } catch (error) {
      this.listener.said(String(error instanceof Error ? error.message : error), true);
    }
    this.listener.changed();
  }

  private async ask(): Promise<void> {
    if (this.waiting > 0 || this.state === undefined) return;
    try {
      const news = await this.api.news();
      if (this.waiting > 0) return;
      if (this.isLost) this.listener.said("", false);
      this.isLost = false;
      if (news.revision !== this.state.revision) await this.load();
      else if (JSON.stringify(news.forecast) !== JSON.stringify(this.state.forecast)) {
        this.state.forecast = news.forecast;
        this.listener.changed();
      }
    } catch (error) {
      if (!this.isLost) this.listener.said(error instanceof Error ? error.message : String(error), true);
      this.isLost = true;
    }
  }
}

/** A message of the server as a sentence; a file's name at its beginning stays as it is. */
export function sentence(text: string): string {
  const whole = /^\p{L}+ /u.test(text) ? text.charAt(0).toUpperCase() + text.slice(1) : text;
  return /[.?!]$/.test(whole) ? whole : `${whole}.`;
}
