// Whether what the page shows is up to date: a link can freeze without breaking.

/** The server says something each second; after this silence the page is out of date. */
const STALE_MS = 3000;
/** Silence after which the stream is opened anew, again and again. */
const DEAD_MS = 10_000;
/** Without a report for so long the viewer should know, seconds: robots report more often than that. */
const QUIET_SECONDS = 30;
const CHECK_MS = 500;

/** Out of date since then, or the link works. */
export type Freshness = { kind: "fresh" } | { kind: "quiet" | "stale" | "closed"; since: Date };

export interface Watcher {
  /** The freshness has changed, or a second has passed since it was lost. */
  changed(): void;
  /** Nothing has come for so long that the stream should be opened anew. */
  dead(): void;
}

export class Watch {
  private heard = new Date();
  /** The same by the monotonic clock, milliseconds. */
  private heardMs = performance.now();
  private quietSeconds = 0;
  private isClosed = false;
  /** When the stream was last opened anew, milliseconds. */
  private reopenedMs = 0;

  constructor(private readonly watcher: Watcher) {
    setInterval(() => this.check(), CHECK_MS);
  }

  /** Something has come; `quietSeconds` is how long nothing was reported. */
  hear(quietSeconds: number): void {
    this.heard = new Date();
    this.heardMs = performance.now();
    this.quietSeconds = quietSeconds;
    this.isClosed = false;
  }

  close(): void {
    this.isClosed = true;
  }

  get freshness(): Freshness {
    if (this.isClosed) return { kind: "closed", since: this.heard };
    if (this.silence() > STALE_MS) return { kind: "stale", since: this.heard };
    if (this.quietSeconds <= QUIET_SECONDS) return { kind: "fresh" };
    return { kind: "quiet", since: new Date(this.heard.getTime() - 1000 * this.quietSeconds) };
  }

  private silence(): number {
    return performance.now() - this.heardMs;
  }

  private check(): void {
    if (this.freshness.kind === "fresh") return;
    this.watcher.changed();
    const silence = Math.min(this.silence(), performance.now() - this.reopenedMs);
    if (silence < DEAD_MS) return;
    this.reopenedMs = performance.now();
    this.watcher.dead();
  }
}
