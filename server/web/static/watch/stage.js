// Draws one moment: frame, maps, facts, and the note that applies.

const SVG = "http://www.w3.org/2000/svg";
const MARKS = new Set(["left", "back", "blocked", "about", "picked_up", "placed", "forced"]);

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

  // Takes maps, facts and events from the page as it is now: a new turn has other maps, and its end shows the truth.
  async renew(step) {
    const response = await fetch(`${this.section.dataset.page}?step=${step}`);
    if (!response.ok) return;
    const page = new DOMParser().parseFromString(await response.text(), "text/html");
    for (const part of [".watch-maps", ".watch-facts", ".watch-events"]) {
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
    const box = this.maps[key], agent = box.querySelector("[data-field=agent]"), scale = agent.dataset.scale;
    const trail = [];
    for (let n = step; n >= 0; n--) {
      const one = this.source.moments[n];
      if (one.turn !== moment.turn || one.phase !== moment.phase) break;
      trail.push(one.place.join(","));
    }
    box.querySelector(".trail").setAttribute("points", trail.reverse().join(" "));
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
    const moments = this.source.moments, last = Math.max(this.source.last, 1), parts = [];
    const at = (step) => (1000 * step) / last;
    let first = 0;
    for (let step = 1; step <= moments.length; step++) {
      const one = moments[step], begin = moments[first];
      if (one && one.turn === begin.turn && one.phase === begin.phase) continue;
      const end = one ? step : last;
      parts.push(shape("rect", { x: at(first), y: 12, width: Math.max(at(end) - at(first) - 2, 1), height: 8,
        class: `strip-${begin.phase}` }));
      first = step;
    }
    for (const moment of moments) {
      for (const mark of moment.marks) {
        if (MARKS.has(mark)) parts.push(shape("rect", { x: at(moment.step) - 1.5, y: 0, width: 3, height: 10, class: `mark-${mark}` }));
      }
    }
    this.fields.strip.replaceChildren(...parts);
    this.fields.range.max = this.source.last;
    this.set("last", String(this.source.last));
  }
}

function element(name, text) {
  const made = document.createElement(name);
  made.textContent = text; // notes are texts of strangers
  return made;
}

function shape(name, attributes) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

function put(group, place, more) {
  group.toggleAttribute("hidden", !place);
  if (place) group.setAttribute("transform", `translate(${place[0]} ${place[1]}) ${more}`);
}

// Widens a map whose agent walks off it, as it can while it plays.
function include(svg, [x, y]) {
  const box = svg.viewBox.baseVal, margin = 4;
  const left = Math.min(box.x, x - margin), top = Math.min(box.y, y - margin);
  const side = Math.max(box.x + box.width - left, box.y + box.height - top, x + margin - left, y + margin - top);
  if (left < box.x || top < box.y || side > box.width) svg.setAttribute("viewBox", `${left} ${top} ${side} ${side}`);
}
