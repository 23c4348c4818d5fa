// The player: buttons, slider and keys; without it, the page shows the step in its address.
import { Source } from "./source.js";
import { Stage } from "./stage.js";

const SETTLE_MS = 250; // before the address names a step

class Player {
  constructor(section) {
    this.section = section;
    this.texts = JSON.parse(section.dataset.texts);
    this.source = new Source(section, (turns) => this.grow(turns));
    this.stage = new Stage(section, this.source, this.texts);
    this.fields = this.stage.fields;
    this.step = Number(section.dataset.step);
    this.shown = 0; // counts frames that were drawn: for measurements
    this.playing = 0; // changes with every start and stop
  }

  async open() {
    await this.source.open();
    this.fields.controls.hidden = false;
    this.fields.plain.hidden = true;
    this.fields.problem.hidden = true;
    this.stage.strip();
    this.listen();
    await this.go(this.step);
    this.section.dataset.ready = "";
  }

  async go(step, settle = true) {
    this.step = Math.max(0, Math.min(step, this.source.last));
    const wanted = this.step;
    this.fields.range.value = wanted;
    try {
      await this.source.ready(wanted);
    } catch {
      this.fields.problem.hidden = false;
    }
    if (wanted !== this.step) return; // meanwhile another was asked for
    this.stage.show(wanted);
    this.shown += 1;
    this.fields.range.setAttribute("aria-valuetext", `${this.texts.phases[this.phase()]}, ${wanted}`);
    if (settle) this.settle();
  }

  phase() {
    const moment = this.source.moments[this.step];
    return `${moment.turn}-${moment.phase}`;
  }

  settle() {
    clearTimeout(this.settling);
    this.settling = setTimeout(() => {
      if (this.source.film) return;
      const address = `${this.section.dataset.page}?step=${this.step}`;
      this.fields.link.href = address;
      history.replaceState(history.state, "", address);
    }, SETTLE_MS);
  }

  async play() {
    const mine = ++this.playing;
    this.button(this.texts.pause);
    this.fields.answer.setAttribute("aria-live", "off"); // too fast to be read out
    if (this.step >= this.source.last && !this.source.live) await this.go(0);
    let due = performance.now();
    while (mine === this.playing) {
      due = Math.max(due + 1000 / Number(this.fields.speed.value), performance.now());
      await new Promise((done) => setTimeout(done, due - performance.now()));
      if (mine !== this.playing) return;
      if (this.step < this.source.last) await this.go(this.step + 1, false);
      else if (!this.source.live) this.stop();
    }
  }

  stop() {
    this.playing += 1;
    this.button(this.texts.play);
    this.fields.answer.setAttribute("aria-live", "polite");
    this.settle();
  }

  button(text) {
    const button = this.section.querySelector("[data-do=play]");
    button.textContent = text;
    button.classList.toggle("is-playing", text === this.texts.pause);
  }

  get isPlaying() { return this.section.querySelector("[data-do=play]").classList.contains("is-playing"); }

  // While it plays live, the newest step is shown if the latest was.
  async grow(turns) {
    const wasLast = this.step >= Number(this.fields.range.max);
    this.stage.strip();
    if (turns || !this.source.live) {
      if (!this.source.live) await this.source.ask(0);
      await this.stage.renew(this.step);
    }
    if (wasLast && !this.isPlaying) this.go(this.source.last, false);
    else this.stage.show(this.step);
    if (this.source.live) return;
    if (this.fields.live) this.fields.live.hidden = true;
    if (this.source.next) {
      this.fields.onward.querySelector("a").href = this.source.next;
      this.fields.onward.hidden = false;
    }
  }

  event(direction) {
    const steps = this.source.moments.filter((one) => one.marks.length).map((one) => one.step);
    const found = direction > 0 ? steps.find((one) => one > this.step) : steps.reverse().find((one) => one < this.step);
    if (found !== undefined) this.jump(found);
  }

  jump(step) {
    if (this.isPlaying) this.stop();
    return this.go(step);
  }

  do(what) {
    if (what === "play") return this.isPlaying ? this.stop() : this.play();
    return this.jump({ first: 0, back: this.step - 1, forth: this.step + 1, last: this.source.last }[what]);
  }

  listen() {
    this.section.addEventListener("click", (event) => {
      const button = event.target.closest("[data-do]"), link = event.target.closest("[data-go]");
      if (button) this.do(button.dataset.do);
      if (link && !(event.ctrlKey || event.metaKey || event.shiftKey || event.button)) {
        event.preventDefault();
        this.jump(Number(link.dataset.go));
      }
    });
    this.fields.range.addEventListener("input", () => this.jump(Number(this.fields.range.value)));
    this.fields.kind?.addEventListener("change", () => {
      this.source.kind = this.fields.kind.value;
      this.go(this.step);
    });
    addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target.closest("input:not([type=range]), select, textarea, summary, .scroll")) return;
    if (event.key === " " && event.target.closest("button, a")) return; // it presses that
    const keys = { " ": "play", ArrowLeft: "back", ArrowRight: "forth", Home: "first", End: "last" };
    const key = event.key.toLowerCase();
    if (keys[event.key]) this.do(keys[event.key]);
    else if (key === "n" || key === "p") this.event(key === "n" ? 1 : -1);
    else return;
    event.preventDefault();
  }
}

const section = document.getElementById("watch");
const player = new Player(section);
section.player = player;
player.open().catch(() => { player.fields.problem.hidden = false; });
