const FIRST_WAIT = 500;
const LAST_WAIT = 8000;
export class Stream {
    listener;
    token;
    socket;
    wait = FIRST_WAIT;
    constructor(listener, token) {
        this.listener = listener;
        this.token = token;
        this.open();
    }
    send(message) {
        if (this.socket?.readyState === WebSocket.OPEN)
            this.socket.send(JSON.stringify(message));
    }
    reopen() {
        const socket = this.socket;
        if (socket === undefined)
            return;
        [socket.onmessage, socket.onclose] = [null, null];
        socket.close();
        this.broken();
    }
    broken() {
        this.socket = undefined;
        this.listener.lost();
        setTimeout(() => this.open(), this.wait);
        this.wait = Math.min(2 * this.wait, LAST_WAIT);
    }
    open() {
        const address = new URL("stream", location.href.replace(/^http/, "ws").split("#")[0]);
        const socket = new WebSocket(address, this.token === null ? ["dragnet"] : ["dragnet", `token.${this.token}`]);
        socket.onmessage = (event) => {
            this.wait = FIRST_WAIT;
            this.listener.received(JSON.parse(String(event.data)));
        };
        socket.onclose = () => this.broken();
        this.socket = socket;
    }
}
