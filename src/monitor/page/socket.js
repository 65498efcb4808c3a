// The connection to the run: JSON and binary messages in, requests out.

import { decode } from "./frames.js";

const AGAIN_MS = 1500;

export class Connection {
  /** `take` gets every message, `changed` the state: "live", "closed", "lost". */
  constructor(take, changed) {
    this.take = take;
    this.changed = changed;
    this.asked = {};
    this.open();
  }

  open() {
    const address = new URL("socket", location.href);
    address.protocol = "ws:";
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => {
      this.changed("live");
      this.socket.send(JSON.stringify(this.asked));
    };
    this.socket.onmessage = ({ data }) => this.take(typeof data === "string" ? JSON.parse(data) : decode(data));
    this.socket.onclose = ({ code }) => {
      // 1000: the run has ended and said so. Anything else may be a network that comes back.
      if (code === 1000) return this.changed("closed");
      this.changed("lost");
      setTimeout(() => this.open(), AGAIN_MS);
    };
  }

  /** What is shown: remembered for a new connection. */
  show(what) {
    Object.assign(this.asked, what);
    this.send(what);
  }

  send(what) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(what));
  }
}
