export class Refusal extends Error {
    status;
    existing;
    constructor(status, message, existing) {
        super(message);
        this.status = status;
        this.existing = existing;
    }
}
export class Api {
    token = new URLSearchParams(location.hash.slice(1)).get("token");
    async mayChange() {
        if (this.token === null)
            return false;
        const answer = await fetch("auth", { headers: this.headers() }).catch(() => undefined);
        return answer?.ok === true;
    }
    state() {
        return this.answer(fetch("plan/state"));
    }
    news() {
        return this.answer(fetch("plan/news"));
    }
    post(what, body) {
        return this.answer(fetch(`plan/${what}`, { method: "POST", headers: this.headers(), body: JSON.stringify(body) }));
    }
    headers() {
        return { Authorization: `Bearer ${this.token ?? ""}` };
    }
    async answer(asked) {
        const answer = await asked.catch(() => undefined);
        if (answer === undefined)
            throw new Refusal(0, "The program that serves this page does not answer. Is it still running?", []);
        if (answer.ok)
            return (await answer.json());
        const refused = (await answer.json().catch(() => ({})));
        throw new Refusal(answer.status, refused.error ?? `the server answers ${answer.status}`, refused.existing ?? []);
    }
}
