// One WebSocket at a time. It is opened again when it breaks or falls silent, with growing delays, until the server refuses.
const FIRST_DELAY = 300, LONGEST_DELAY = 5000;
// Of a half-open connection: the server pings, but a page cannot see that. A first answer may have to wait for a scene.
const ANSWER_TIMEOUT = 10000, OPENING_TIMEOUT = 30000;
const LOOK = 1 << 31; // marks a view in another heading

// The server refuses for good: only the person can do something about it.
const FINAL = new Set(["Replaced", "TakenOver", "NotFound", "Forbidden", "Unauthenticated", "OverQuota", "BadInput", "Conflict"]);

export class Connection {
  // `hello` returns the first message; `on` has open, message, frame, lost and refused.
  constructor(address, hello, on) {
    Object.assign(this, { address, hello, on });
    this.socket = null;
    this.delay = FIRST_DELAY;
    this.timer = null;
    this.waiting = null;
    this.stopped = true;
  }

  open() {
    this.stopped = false;
    clearTimeout(this.timer);
    const socket = new WebSocket(new URL(this.address, location.href.replace(/^http/, "ws")));
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.expectAnswer(OPENING_TIMEOUT);
    socket.onopen = () => socket.send(JSON.stringify(this.hello()));
    socket.onmessage = (event) => { if (socket === this.socket) this.take(event.data); };
    socket.onclose = () => { if (socket === this.socket) this.lose(); };
  }

  take(data) {
    this.answered();
    if (typeof data !== "string") {
      const header = new DataView(data).getUint32(0, true);
      this.on.frame(header & ~LOOK, data.slice(4), (header & LOOK) !== 0);
      return;
    }
    const message = JSON.parse(data);
    if (message.type === "closed") {
      if (FINAL.has(message.code)) this.stop();
      this.on.refused(message, this.stopped);
      return;
    }
    if (message.type === "opened") this.delay = FIRST_DELAY;
    this.on.message(message);
  }

  // Whether the message left; if not, the page sends it again after it has come back to its step.
  send(message, { answered = true } = {}) {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    if (answered) this.expectAnswer();
    return true;
  }

  expectAnswer(milliseconds = ANSWER_TIMEOUT) {
    clearTimeout(this.waiting);
    this.waiting = setTimeout(() => { this.socket?.close(); this.lose(); }, milliseconds);
  }

  answered() { clearTimeout(this.waiting); }

  lose() {
    this.answered();
    this.socket = null;
    if (this.stopped) return;
    this.on.lost();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.open(), this.delay * (0.75 + Math.random() / 2));
    this.delay = Math.min(2 * this.delay, LONGEST_DELAY);
  }

  // Nothing more is to be played: the connection is used while it lasts, and not opened again.
  finish() { this.stopped = true; }

  stop() {
    this.stopped = true;
    clearTimeout(this.timer);
    this.answered();
    const socket = this.socket;
    this.socket = null;
    socket?.close();
  }
}
