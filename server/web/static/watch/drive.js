// Slider, buttons, speeds and keys: which position is shown, and when.

const SETTLE_MS = 250; // before the address names a position

export class Drive {
  // shown: what is driven. It has `section`, `fields`, `texts`, `last`, `live`, `notable` (positions), `ready(position)` (a
  // promise), `draw(position)`, `describe(position)` (for the slider), and `address(position)` (empty for none).
  constructor(shown) {
    this.of = shown;
    this.fields = shown.fields;
    this.texts = shown.texts;
    this.section = shown.section;
    this.step = Number(this.section.dataset.step);
    this.shown = 0; // counts frames that were drawn: for measurements
    this.playing = 0; // changes with every start and stop
  }

  async begin() {
    this.fields.controls.hidden = false;
    this.fields.plain.hidden = true;
    this.fields.problem.hidden = true;
    this.listen();
    await this.go(this.step);
    this.section.dataset.ready = "";
  }

  async go(step, settle = true) {
    this.step = Math.max(0, Math.min(step, this.of.last));
    const wanted = this.step;
    this.fields.range.value = wanted;
    try {
      await this.of.ready(wanted);
    } catch {
      this.fields.problem.hidden = false;
    }
    if (wanted !== this.step) return; // meanwhile another was asked for
    this.of.draw(wanted);
    this.shown += 1;
    this.fields.range.setAttribute("aria-valuetext", this.of.describe(wanted));
    if (settle) this.settle();
  }

  settle() {
    clearTimeout(this.settling);
    this.settling = setTimeout(() => {
      const address = this.of.address(this.step);
      if (!address) return;
      this.fields.link.href = address;
      history.replaceState(history.state, "", address);
    }, SETTLE_MS);
  }

  async play() {
    const mine = ++this.playing;
    this.button(this.texts.pause);
    this.speak(false); // too fast to be read out
    if (this.step >= this.of.last && !this.of.live) await this.go(0);
    let due = performance.now();
    while (mine === this.playing) {
      due = Math.max(due + 1000 / Number(this.fields.speed.value), performance.now());
      await new Promise((done) => setTimeout(done, due - performance.now()));
      if (mine !== this.playing) return;
      if (this.step < this.of.last) await this.go(this.step + 1, false);
      else if (!this.of.live) this.stop();
    }
  }

  stop() {
    this.playing += 1;
    this.button(this.texts.play);
    this.speak(true);
    this.settle();
  }

  speak(aloud) {
    for (const one of this.section.querySelectorAll("[role=status]")) one.setAttribute("aria-live", aloud ? "polite" : "off");
  }

  button(text) {
    const button = this.section.querySelector("[data-do=play]");
    button.textContent = text;
    button.classList.toggle("is-playing", text === this.texts.pause);
  }

  get isPlaying() { return this.section.querySelector("[data-do=play]").classList.contains("is-playing"); }

  event(direction) {
    const steps = this.of.notable;
    const found = direction > 0 ? steps.find((one) => one > this.step) : steps.reverse().find((one) => one < this.step);
    if (found !== undefined) this.jump(found);
  }

  jump(step) {
    if (this.isPlaying) this.stop();
    return this.go(step);
  }

  do(what) {
    if (what === "play") return this.isPlaying ? this.stop() : this.play();
    return this.jump({ first: 0, back: this.step - 1, forth: this.step + 1, last: this.of.last }[what]);
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
      this.of.choose(this.fields.kind.value);
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
