// The stream of frames, which is reopened whenever it breaks.

import type { Frame, Hello, Over } from "./mission.js";

/** Time before the stream is reopened, milliseconds; doubled after each failure, up to the last. */
const FIRST_WAIT = 500;
const LAST_WAIT = 8000;

export interface Listener {
  received(message: Hello | Frame | Over): void;
  /** The stream has broken and is reopened after this many seconds. */
  lost(seconds: number): void;
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

  private open(): void {
    const address = new URL("stream", location.href.replace(/^http/, "ws").split("#")[0]);
    // The token reserves a permit beyond the limit of viewers.
    const socket = new WebSocket(address, this.token === null ? ["dragnet"] : ["dragnet", `token.${this.token}`]);
    socket.onmessage = (event) => {
      this.wait = FIRST_WAIT;
      this.listener.received(JSON.parse(String(event.data)));
    };
    socket.onclose = () => {
      this.listener.lost(this.wait / 1000);
      setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(2 * this.wait, LAST_WAIT);
    };
    this.socket = socket;
  }
}
