// Two runs of one episode side by side, driven by one slider. `data-pairs` has the steps of both at each of its positions.
import { Drive } from "./drive.js";
import { Source } from "./source.js";
import { include, markBars, phaseBars, put, way } from "./svg.js";

const FACTS = ["action", "answer", "carried", "distance", "ndtw"];

// One of the two runs: its moments and frames, and its part of the page.
class Side {
  constructor(part) {
    this.part = part;
    this.source = new Source(part, () => {}, () => {});
    this.fields = fieldsOf(part);
  }

  show(step, alt) {
    const moment = this.source.moments[step];
    this.fields.frame.src = this.source.address(step);
    this.fields.frame.alt = alt;
    this.fields.step.textContent = step;
    this.fields.own.href = `${this.part.dataset.page}?step=${step}`;
    for (const name of FACTS) this.fields[name].textContent = moment[name] || "–";
    return moment;
  }
}

class Pair {
  constructor(section) {
    this.section = section;
    this.texts = JSON.parse(section.dataset.texts);
    this.pairs = JSON.parse(section.dataset.pairs);
    this.sides = [...section.querySelectorAll("[data-side]")].map((part) => new Side(part));
    this.fields = fieldsOf(section, "[data-field]:not([data-side] *)");
    this.maps = [...section.querySelectorAll("[data-map]")];
    this.drive = new Drive(this);
  }

  get last() { return this.pairs.length - 1; }

  get live() { return false; }

  get notable() { return [...new Set(this.marked.map(([position]) => position))]; }

  async open() {
    await Promise.all(this.sides.map((side) => side.source.open()));
    this.marked = this.marks();
    this.strip();
    await this.drive.begin();
  }

  ready(position) {
    return Promise.all(this.sides.map((side, n) => side.source.ready(this.pairs[position][n])));
  }

  choose(kind) { for (const side of this.sides) side.source.kind = kind; }

  address(position) { return `${this.section.dataset.page}&step=${position}`; }

  describe(position) {
    const [a, b] = this.pairs[position];
    return `${this.texts.phases[this.phase(position)]}, A ${a}, B ${b}`;
  }

  moments(position) { return this.sides.map((side, n) => side.source.moments[this.pairs[position][n]]); }

  // The moment of the run that has come further.
  leader(position) {
    const rank = (one) => 2 * one.turn + (one.phase === "assembly" ? 1 : 0);
    const [a, b] = this.moments(position);
    return rank(b) > rank(a) ? b : a;
  }

  phase(position) {
    const { turn, phase } = this.leader(position);
    return `${turn}-${phase}`;
  }

  draw(position) {
    const key = this.phase(position);
    this.fields.phase.textContent = this.texts.phases[key];
    for (const said of this.section.querySelectorAll("[data-said]")) said.textContent = JSON.parse(said.dataset.said)[key];
    for (const box of this.maps) box.hidden = box.dataset.map !== key;
    const box = this.maps.find((one) => one.dataset.map === key), svg = box.querySelector("svg.map");
    this.sides.forEach((side, n) => {
      const step = this.pairs[position][n];
      const alt = this.texts.frame.replace("{name}", "AB"[n]).replace("{step}", step);
      const moment = side.show(step, alt), isHere = `${moment.turn}-${moment.phase}` === key;
      const agent = box.querySelector(`[data-agent="${n}"]`);
      box.querySelector(`[data-trail="${n}"]`).setAttribute("points", isHere ? way(side.source.moments, step) : "");
      put(agent, isHere && moment.place, `rotate(${moment.heading}) scale(${agent.dataset.scale})`);
      if (svg && isHere) include(svg, moment.place);
    });
  }

  // Positions at which something stands out in one of the runs: [position, run, moment], in order.
  marks() {
    const found = this.sides.flatMap((side, n) => {
      const first = new Map();
      this.pairs.forEach((pair, position) => { if (!first.has(pair[n])) first.set(pair[n], position); });
      return side.source.moments.filter((one) => one.marks.length).map((one) => [first.get(one.step), n, one]);
    });
    return found.sort((a, b) => a[0] - b[0]);
  }

  strip() {
    const phases = this.pairs.map((_, position) => this.leader(position));
    const marks = this.marked.flatMap(([position, n, moment]) => markBars(moment, position, this.last, 22 * n));
    this.fields.strip.replaceChildren(...phaseBars(phases, 12), ...marks);
  }
}

function fieldsOf(part, selector = "[data-field]") {
  return Object.fromEntries([...part.querySelectorAll(selector)].map((one) => [one.dataset.field, one]));
}

const section = document.getElementById("watch");
const pair = new Pair(section);
section.player = pair;
pair.open().catch(() => { pair.fields.problem.hidden = false; });
