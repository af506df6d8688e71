// The stream of frames, which is reopened whenever it breaks.

import type { Message } from "./mission.js";

/** Time before the stream is reopened, milliseconds; doubled after each failure, up to the last. */
const FIRST_WAIT = 500;
const LAST_WAIT = 8000;

export interface Listener {
  received(message: Message): void;
  /** The stream has broken and is reopened after a while. */
  lost(): void;
}

export class Stream {
  private socket: WebSocket | undefined;
  private wait = FIRST_WAIT;

  constructor(
    private readonly listener: Listener,
    private readonly token: string | null,
  ) {
    this.open();
  }

  send(message: unknown): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  /** Gives up a stream that is silent, if there is one: over a frozen link it would never break, nor open. */
  reopen(): void {
    const socket = this.socket;
    if (socket === undefined) return;
    [socket.onmessage, socket.onclose] = [null, null];
    socket.close();
    this.broken();
  }

  private broken(): void {
    this.socket = undefined;
    this.listener.lost();
    setTimeout(() => this.open(), this.wait);
    this.wait = Math.min(2 * this.wait, LAST_WAIT);
  }

  private open(): void {
    const address = new URL("stream", location.href.replace(/^http/, "ws").split("#")[0]);
    // The token reserves a permit beyond the limit of viewers.
    const socket = new WebSocket(address, this.token === null ? ["dragnet"] : ["dragnet", `token.${this.token}`]);
    socket.onmessage = (event) => {
      this.wait = FIRST_WAIT;
      this.listener.received(JSON.parse(String(event.data)));
    };
    socket.onclose = () => this.broken();
    this.socket = socket;
  }
}
