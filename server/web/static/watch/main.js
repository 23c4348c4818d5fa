// The player of one episode; without it, the page shows the step in its address.
import { Drive } from "./drive.js";
import { Source } from "./source.js";
import { Stage } from "./stage.js";

class Player {
  constructor(section) {
    this.section = section;
    this.texts = JSON.parse(section.dataset.texts);
    this.source = new Source(section, (turns) => this.grow(turns), () => this.vanish());
    this.stage = new Stage(section, this.source, this.texts);
    this.fields = this.stage.fields;
    this.drive = new Drive(this);
  }

  get last() { return this.source.last; }

  get live() { return this.source.live; }

  get notable() { return this.source.moments.filter((one) => one.marks.length).map((one) => one.step); }

  async open() {
    await this.source.open();
    this.stage.strip();
    await this.drive.begin();
  }

  ready(step) { return this.source.ready(step); }

  draw(step) { this.stage.show(step); }

  describe(step) {
    const moment = this.source.moments[step];
    return `${this.texts.phases[`${moment.turn}-${moment.phase}`]}, ${step}`;
  }

  address(step) { return this.source.film ? "" : `${this.section.dataset.page}?step=${step}`; }

  choose(kind) { this.source.kind = kind; }

  // While it plays live, the newest step is shown if the latest was.
  async grow(turns) {
    const wasLast = this.drive.step >= Number(this.fields.range.max);
    this.stage.strip();
    if (turns || !this.source.live) {
      if (!this.source.live) await this.source.ask(0);
      await this.stage.renew(this.drive.step);
    }
    this.stage.events();
    if (wasLast && !this.drive.isPlaying) this.drive.go(this.source.last, false);
    else this.stage.show(this.drive.step);
    if (this.source.live) return;
    if (this.fields.live) this.fields.live.hidden = true;
    if (this.source.next) {
      this.fields.onward.querySelector("a").href = this.source.next;
      this.fields.onward.hidden = false;
    }
  }

  // The run has been deleted or withdrawn meanwhile.
  vanish() {
    if (this.fields.live) this.fields.live.hidden = true;
    this.fields.gone.hidden = false;
  }
}

const section = document.getElementById("watch");
const player = new Player(section);
section.player = player;
player.open().catch(() => { player.fields.problem.hidden = false; });
