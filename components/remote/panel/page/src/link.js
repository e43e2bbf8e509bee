// The socket: status, values, samples and commands.

import { RETRY_MS, Refusal, sessionKey } from "./http.js";
import { areJogsHeld, releaseAll } from "./hold.js";

/** Shortest time in ms between two messages that say that a person uses the page. */
const INPUT_MS = 30_000;

/** The connection to the server. A lost one is opened again, as a new client without the lease. */
export class Link {
  /** `on` has functions by message type: `status`, `values`, and `state` for the connection itself. */
  constructor(on) {
    this.on = on;
    this.nextId = 1;
    this.pending = new Map();
    this.watched = new Map();
    this.capturing = null;
    this.isOpen = false;
    this.isClosed = false;
    this.lastInput = 0;
    for (const name of ["pointerdown", "keydown"]) window.addEventListener(name, () => this.noteInput(), { capture: true, passive: true });
    // A browser may keep a page that was left, with its connection and its lease. When it is shown again, the connection is opened again.
    window.addEventListener("pagehide", () => this.socket.close());
    this.open();
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/api/v1/socket`);
    this.socket = socket;
    socket.onopen = () => socket.send(JSON.stringify({ type: "hello", key: sessionKey() }));
    socket.onmessage = (event) => this.receive(JSON.parse(event.data));
    socket.onclose = () => {
      releaseAll();
      this.isOpen = false;
      for (const { reject } of this.pending.values()) reject(new Refusal({ code: "no-server", text: this.lostText ?? "" }));
      this.pending.clear();
      this.capturing = null;
      this.on.state(false);
      if (!this.isClosed) setTimeout(() => this.open(), RETRY_MS);
    };
  }

  /** Ends the connection for good. */
  close() {
    this.isClosed = true;
    this.socket.close();
  }

  receive(message) {
    switch (message.type) {
      case "pulse":
        // A page that nobody sees holds no jog: hiding it has ended them. It is there all the same, while the link answers. A jog that
        // nothing holds ends by the machine's dead man too.
        if (areJogsHeld()) this.post({ type: "beat", n: message.n });
        break;
      case "hello":
        this.isOpen = true;
        this.on.state(true, message);
        if (this.watched.size > 0) this.sendWatch();
        break;
      case "reply":
      case "done":
        this.settle(message);
        break;
      case "samples":
        if (message.id === this.capturing?.id) this.capturing.receive(message);
        break;
      case "error":
        if (message.error?.code === "no-session") {
          this.isClosed = true;
          this.on.ended();
        }
        break;
      default:
        this.on[message.type]?.(message);
    }
  }

  settle({ id, ok, error, pending }) {
    const waiting = this.pending.get(id);
    if (!waiting) return;
    if (pending) {
      waiting.accepted?.(ok ?? {});
      return;
    }
    this.pending.delete(id);
    if (error) waiting.reject(new Refusal(error));
    else waiting.resolve(ok ?? {});
  }

  /** Says that a person uses the page, at most once in a while. */
  noteInput() {
    const now = Date.now();
    if (now - this.lastInput < INPUT_MS) return;
    this.lastInput = now;
    this.post({ type: "input" });
  }

  post(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  /** Sends a message that is answered; resolves at its end. */
  ask(message, accepted) {
    return new Promise((resolve, reject) => {
      if (!this.isOpen) {
        reject(new Refusal({ code: "no-server", text: this.lostText ?? "" }));
        return;
      }
      const id = this.nextId++;
      this.pending.set(id, { resolve, reject, accepted });
      this.post({ ...message, id });
    });
  }

  /** Executes a command of the table in API.md. */
  command(name, args = {}, accepted) {
    return this.ask({ type: "command", name, args }, accepted);
  }

  /** Watches names for one part of the page; `[]` ends it. */
  watch(part, names) {
    if (names.length === 0 && !this.watched.has(part)) return;
    if (names.length === 0) this.watched.delete(part);
    else this.watched.set(part, names);
    this.sendWatch();
  }

  sendWatch() {
    const names = [...new Set([...this.watched.values()].flat())].slice(0, 1000);
    if (this.isOpen) this.post({ type: "watch", names });
  }

  /** Starts a capture, which ends the one before; `receive` gets its samples. Resolves to its period, names and types. */
  async capture(capture, receive) {
    this.capturing = { id: this.nextId, receive };
    return this.ask({ type: "scope", capture });
  }

  /** Ends the capture. */
  endCapture() {
    this.capturing = null;
    if (this.isOpen) this.post({ type: "scope", id: this.nextId++ });
  }
}
