// Draws one moment: frame, maps, facts, and the note that applies.

import { MARKS, element, include, markBars, phaseBars, put, way } from "./svg.js";

export class Stage {
  constructor(section, source, texts) {
    this.section = section;
    this.source = source;
    this.texts = texts;
    this.fields = {};
    this.find();
  }

  find() {
    const section = this.section;
    // Kept as one object, as others hold it.
    Object.assign(this.fields, Object.fromEntries([...section.querySelectorAll("[data-field]")].map((one) => [one.dataset.field, one])));
    this.maps = Object.fromEntries([...section.querySelectorAll("[data-map]")].map((one) => [one.dataset.map, one]));
  }

  // Takes maps and facts from the page as it is now: a new turn has other maps, and its end shows the truth.
  async renew(step) {
    const response = await fetch(`${this.section.dataset.page}?step=${step}`);
    if (!response.ok) return;
    const page = new DOMParser().parseFromString(await response.text(), "text/html");
    for (const part of [".watch-maps", ".watch-facts"]) {
      this.section.querySelector(part).replaceWith(page.querySelector(part));
    }
    this.find();
  }

  set(name, text) {
    const field = this.fields[name];
    if (field && field.textContent !== text) field.textContent = text;
  }

  show(step) {
    const moment = this.source.moments[step], key = `${moment.turn}-${moment.phase}`;
    this.fields.frame.src = this.source.address(step);
    this.fields.frame.alt = this.texts.frame.replace("{step}", step);
    this.set("phase", this.texts.phases[key]);
    this.set("instruction", this.texts.instructions[key]);
    for (const name of ["step", "left"]) this.set(name, String(moment[name]));
    this.set("last", String(this.source.last));
    for (const name of ["action", "answer", "carried"]) this.set(name, moment[name] || "–");
    for (const name of ["distance", "ndtw"]) this.set(name, moment[name]);
    this.map(step, moment, key);
    this.note(moment);
  }

  map(step, moment, key) {
    for (const [name, box] of Object.entries(this.maps)) box.hidden = name !== key;
    const box = this.maps[key];
    if (!box) return; // withheld while a person plays
    const agent = box.querySelector("[data-field=agent]"), scale = agent.dataset.scale;
    const points = way(this.source.moments, step);
    for (const line of box.querySelectorAll(".trail, [data-under]")) line.setAttribute("points", points);
    put(agent, moment.place, `rotate(${moment.heading}) scale(${scale})`);
    const goal = box.querySelector("[data-field=goal]"), note = this.source.notes[moment.note];
    put(goal, note?.goal, `scale(${scale})`);
    const svg = box.querySelector("svg.map");
    if (svg) include(svg, moment.place);
  }

  note(moment) {
    const note = this.source.notes[moment.note], box = this.fields.note;
    box.hidden = !note;
    if (!note) return;
    this.set("note-step", String(moment.note));
    const reading = this.source.notes[moment.reading]?.reading ?? [];
    this.fields.reading.hidden = !reading.length;
    this.fields.reading.replaceChildren(...reading.map((line, index) => {
      const item = element("li", line);
      if (index + 1 === note.step) item.setAttribute("aria-current", "step");
      return item;
    }));
    this.fields["note-facts"].replaceChildren(
      ...note.facts.flatMap(([name, text]) => [element("dt", name), element("dd", text)]),
    );
    this.set("note-text", note.text);
  }

  // The bar of phases and events above the slider.
  strip() {
    const moments = this.source.moments, last = this.source.last;
    const marks = moments.flatMap((moment) => markBars(moment, moment.step, last, 0));
    this.fields.strip.replaceChildren(...phaseBars(moments, 12), ...marks);
    this.fields.range.max = last;
    this.set("last", String(last));
  }

  // The list of what stands out. What is in it already stays, as it may have the focus.
  events() {
    const found = [];
    let blocked = -2;
    for (const { step, marks } of this.source.moments) {
      for (const mark of marks) {
        if (!MARKS.has(mark)) continue;
        const goesOn = mark === "blocked" && blocked === step - 1; // of blocked steps in a row the first
        if (mark === "blocked") blocked = step;
        if (!goesOn) found.push([step, mark]);
      }
    }
    const list = this.fields.events, kept = [...list.children];
    const texts = found.map(([step, mark]) => `${step}: ${this.texts.events[mark]}`);
    const same = kept.findIndex((item, index) => item.textContent !== texts[index]);
    const first = same < 0 ? kept.length : same;
    for (const item of kept.slice(first)) item.remove();
    list.append(...found.slice(first).map(([step, mark], index) => {
      const item = element("li", ""), link = element("a", texts[first + index]);
      item.className = `watch-mark mark-${mark}`;
      link.href = `${this.section.dataset.page}?step=${step}`;
      link.dataset.go = step;
      item.append(link);
      return item;
    }));
    list.hidden = !found.length;
    this.fields["no-events"].hidden = found.length > 0;
  }
}
