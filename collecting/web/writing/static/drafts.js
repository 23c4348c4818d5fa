// Saves the draft by revision, keeps what is not saved yet in the browser, and notices when another window writes.
import { randomHex } from "./server.js";

const PAUSE = 700, FIRST_DELAY = 1000, LONGEST_DELAY = 15000;

export class Drafts {
  // `content` returns {position, texts, evidence}; `on` has saved(answer), waits(), unsaved(), takenOver(), refused(error).
  constructor(server, task, content, on) {
    Object.assign(this, { server, content, on });
    this.key = `arramon-write-${task}`;
    this.editor = randomHex();
    this.revision = 0;
    this.isDirty = this.isSaving = this.isStopped = false;
    this.timer = null;
    this.delay = FIRST_DELAY;
    this.channel = "BroadcastChannel" in globalThis ? new BroadcastChannel(this.key) : null;
    if (this.channel) this.channel.onmessage = () => this.look(); // says that another window of this browser has begun
    document.addEventListener("visibilitychange", () => { if (document.hidden) this.save(true); else this.look(); });
    addEventListener("focus", () => this.look());
  }

  // Make this the window that writes. Returns the draft, and the texts that this browser had not saved, if any.
  async open() {
    const answer = await this.server.post("open", { editor: this.editor });
    this.revision = answer.revision;
    this.isStopped = this.isDirty = false;
    this.channel?.postMessage("open");
    const kept = this.kept();
    this.forget();
    const isNewer = kept && kept.revision === answer.before; // nobody has saved since
    return { draft: answer, restored: isNewer ? kept : null, aside: kept && !isNewer ? kept : null };
  }

  // The content has changed.
  change() {
    if (this.isStopped) return;
    this.isDirty = true;
    this.keep();
    this.on.waits();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.save(), PAUSE);
  }

  async save(keepalive = false) {
    if (!this.isDirty || this.isSaving || this.isStopped) return;
    clearTimeout(this.timer);
    this.isSaving = true;
    this.isDirty = false;
    try {
      const answer = await this.server.post("draft", { revision: this.revision, editor: this.editor, ...this.content() }, { keepalive });
      this.revision = answer.revision;
      this.delay = FIRST_DELAY;
      if (!this.isDirty) this.forget();
      this.on.saved(answer);
    } catch (error) {
      this.isDirty = true;
      this.fail(error);
    }
    this.isSaving = false;
    if (this.isDirty && !this.isStopped) this.timer = setTimeout(() => this.save(), this.delay);
  }

  fail(error) {
    if (error.status === 409 && error.answer.newer) {
      const { revision, body } = error.answer.newer;
      if (body.editor === this.editor) { // an answer was lost: save again, on top of it
        this.revision = revision;
        this.delay = 0;
        return;
      }
      this.stop();
      this.on.takenOver();
    } else if (error.status && !error.isTemporary) {
      this.stop();
      this.on.refused(error);
    } else {
      this.delay = Math.min(2 * this.delay || FIRST_DELAY, LONGEST_DELAY);
      this.on.unsaved();
    }
  }

  // Whether another window has taken over since.
  async look() {
    if (this.isStopped || this.isSaving || !this.revision) return;
    try {
      const draft = await (await this.server.get("draft")).json();
      if (draft.editor === this.editor || this.isStopped) return;
      this.stop();
      this.on.takenOver();
    } catch { /* the next save says what is wrong */ }
  }

  stop() {
    this.isStopped = true;
    clearTimeout(this.timer);
  }

  keep() {
    try {
      const { texts, position } = this.content();
      localStorage.setItem(this.key, JSON.stringify({ revision: this.revision, texts, position }));
    } catch { /* private windows have no storage */ }
  }

  kept() {
    try {
      const found = JSON.parse(localStorage.getItem(this.key));
      return found && Array.isArray(found.texts) ? found : null;
    } catch { return null; }
  }

  forget() {
    try { localStorage.removeItem(this.key); } catch { /* as above */ }
  }
}
