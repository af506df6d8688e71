const STALE_MS = 3000;
const DEAD_MS = 10_000;
const QUIET_SECONDS = 30;
const CHECK_MS = 500;
export class Watch {
    watcher;
    heard = new Date();
    heardMs = performance.now();
    quietSeconds = 0;
    isClosed = false;
    reopenedMs = 0;
    constructor(watcher) {
        this.watcher = watcher;
        setInterval(() => this.check(), CHECK_MS);
    }
    hear(quietSeconds) {
        this.heard = new Date();
        this.heardMs = performance.now();
        this.quietSeconds = quietSeconds;
        this.isClosed = false;
    }
    close() {
        this.isClosed = true;
    }
    get freshness() {
        if (this.isClosed)
            return { kind: "closed", since: this.heard };
        if (this.silence() > STALE_MS)
            return { kind: "stale", since: this.heard };
        if (this.quietSeconds <= QUIET_SECONDS)
            return { kind: "fresh" };
        return { kind: "quiet", since: new Date(this.heard.getTime() - 1000 * this.quietSeconds) };
    }
    silence() {
        return performance.now() - this.heardMs;
    }
    check() {
        if (this.freshness.kind === "fresh")
            return;
        this.watcher.changed();
        const silence = Math.min(this.silence(), performance.now() - this.reopenedMs);
        if (silence < DEAD_MS)
            return;
        this.reopenedMs = performance.now();
        this.watcher.dead();
    }
}
