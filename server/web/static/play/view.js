// Draws what the page shows: frame, texts, clocks, and the aids that the run has.
import { aheadWords, stateWords, whyNotWords } from "./words.js";

const STRIP = 4;  // frames in the strip
const FEW_STEPS = 20;
const WARNINGS = [20, 5]; // steps left in a part at which the page warns
const FLASH_TIME = 1600; // milliseconds, and more for long messages
const MAP_MARGIN = 4, MAP_LEAST = 30; // metres of streets around a way, and at least shown
const MAP_SCALE = 11; // pixels a metre at most, so that names are no larger than other text
const SVG = "http://www.w3.org/2000/svg";
const element = (id) => document.getElementById(id);

export class View {
  constructor(texts) {
    this.texts = texts;
    this.canvas = element("frame");
    this.context = this.canvas.getContext("2d");
    this.aids = {};
    this.clock = null;
    this.drawing = Promise.resolve();
    setInterval(() => this.tick(), 500);
    drawGrid(document.querySelector("#landing .grid"));
    this.landingCaption = document.querySelector("#landing figcaption").textContent;
  }

  say(key, values = {}) {
    return Object.entries(values).reduce((text, [name, value]) => text.replaceAll(`{${name}}`, value), this.texts[key] ?? key);
  }

  // A message for the person above the game; empty for none.
  status(text, isGood = false) {
    element("status").textContent = text;
    element("status").classList.toggle("good", isGood);
    element("status").hidden = !text;
  }

  // The message that is shown is a good one.
  praise() { element("status").classList.add("good"); }

  // How many key presses were not carried out; empty if all were.
  droppedWords(dropped) { return dropped ? this.say("dropped", { number: dropped }) : ""; }

  opened(run) {
    this.aids = run.aids;
    this.isPractice = run.split === "practice";
    this.canvas.width = this.canvas.height = run.size;
    element("strip").hidden = !run.aids.frame_strip;
    for (const one of document.querySelectorAll(".compass")) one.hidden = !run.aids.compass;
    element("instruction").lang = run.language;
    element("look").hidden = !run.aids.look_around;
    element("zoom").hidden = !run.aids.zoom;
    element("names")?.toggleAttribute("hidden", !run.aids.pictured_names); // other pages with the game have none
    for (const one of document.querySelectorAll(".ahead")) one.hidden = !run.aids.ahead;
    if (!run.aids.zoom) this.zoom(false);
    this.progress(run.ended, run.episodes);
  }

  progress(ended, episodes) {
    element("progress").textContent = this.say(this.isPractice ? "practice_progress" : "progress", { number: Math.min(ended + 1, episodes), all: episodes });
  }

  // What came of a part of the practice, and that the test is next.
  lessonEnded(isRight, number, all) {
    const said = this.say(isRight ? "lesson_done" : "lesson_missed", { number, all });
    this.status(number + 1 === all ? `${said} ${this.texts.test_begins}` : said, isRight);
  }

  // What came of the placement test; it can be taken again if it was not passed.
  testEnded(isPassed) {
    this.status(isPassed ? this.texts.practice_passed : this.texts.practice_failed, isPassed);
    element("practise-again").hidden = isPassed;
  }

  state(state, { isNew, before, action, dropped }) {
    const isRoom = state.phase === "assembly";
    element("phase").textContent = this.say(isRoom ? "place_phase" : "walk_phase", { turn: state.turn });
    const instruction = element("instruction");
    if (instruction.textContent !== state.instruction) instruction.textContent = state.instruction;
    element("carried").textContent = !state.carries ? this.texts.carries_nothing : state.carried || this.texts.carries_something;
    element("steps").textContent = String(state.steps_left);
    element("steps").classList.toggle("few", state.steps_left <= FEW_STEPS);
    element("interact").textContent = this.texts[isRoom ? "place" : "pick_up"];
    this.clock = state.seconds_left === undefined ? null : { ...state, at: performance.now() };
    for (const one of document.querySelectorAll(".clock")) one.hidden = this.clock === null;
    this.tick();
    if (isNew) this.outcome(state, before, action, this.droppedWords(dropped));
    if (this.aids.compass && state.heading !== undefined) this.compass(state.heading);
    element("ahead").textContent = aheadWords((...of) => this.say(...of), state.ahead);
    this.landing(state.landing, state.ahead);
    element("described").textContent = "";
    if (before && before.phase !== state.phase) this.clearStrip();
  }

  outcome(state, before, action, dropped) {
    const say = (...of) => this.say(...of);
    const done = state.outcome ? say(state.outcome, { object: state.carried || this.texts.carries_something }) : "";
    const isRefused = state.outcome === "blocked" || state.outcome === "cannot_place";
    const text = this.counted(isRefused ? whyNotWords(say, state.outcome, state.why) : done, isRefused || state.outcome === "nothing_in_reach");
    const warning = before && before.phase === state.phase && WARNINGS.includes(state.steps_left) ? say("steps_warning", { steps: state.steps_left }) : "";
    const quiet = state.outcome === "moved" || state.outcome === "turned";
    const turned = { 1: "left", 2: "right" }[action];
    const said = state.outcome === "turned" && turned ? this.texts[`turned_${turned}`] : text;
    const isNear = state.ahead && (state.ahead.in_reach || state.phase === "assembly");
    const ahead = isNear ? aheadWords(say, state.ahead) : "";
    element("outcome").textContent = [said, ahead, dropped, warning].filter(Boolean).join(" ");
    // What is shown over the picture need not stand below it, too: there it is for screen readers.
    element("outcome").classList.toggle("unseen", !quiet && !ahead);
    this.flash([quiet ? "" : text, dropped, warning].filter(Boolean).join(" "));
  }

  // A refusal that comes again at once has its number behind it, so that it is seen to be a new one.
  counted(text, isRefused) {
    const times = isRefused && this.refusal?.text === text ? this.refusal.times + 1 : 1;
    this.refusal = isRefused ? { text, times } : null;
    return times > 1 ? `${text} (${times})` : text;
  }

  flash(text) {
    const flash = element("flash");
    clearTimeout(this.flashing);
    flash.textContent = text;
    flash.classList.remove("shown");
    if (!text) return;
    void flash.offsetWidth; // so that the same message is seen to come again
    flash.classList.add("shown");
    this.flashing = setTimeout(() => this.unflash(), FLASH_TIME + 30 * text.length);
  }

  // The message moves from the picture to the line below it.
  unflash() {
    element("flash").classList.remove("shown");
    element("outcome").classList.remove("unseen");
  }

  tick() {
    if (!this.clock) return;
    const passed = (performance.now() - this.clock.at) / 1000;
    const step = this.clock.seconds_left - passed, bank = this.clock.bank_left + Math.min(step, 0);
    element("clock").textContent = step > 0
      ? this.say("clock_step", { seconds: Math.ceil(step) })
      : this.say("clock_bank", { minutes: Math.max(0, Math.ceil(bank / 60)) });
  }

  // Frames are decoded one after the other, so that an older one never covers a newer one.
  frame(jpeg, isCurrent, drawn) {
    this.drawing = this.drawing.then(async () => {
      if (!isCurrent()) return;
      const image = await createImageBitmap(new Blob([jpeg], { type: "image/jpeg" }));
      if (isCurrent()) {
        this.keepInStrip();
        this.context.drawImage(image, 0, 0, this.canvas.width, this.canvas.height);
        drawn();
      }
      image.close();
    }).catch((error) => { this.status(this.texts.no_frame); console.warn(error); });
  }

  // A view in another heading covers the frame until the next one. `isCurrent` as for `frame`.
  look(jpeg, isCurrent, drawn) {
    this.drawing = this.drawing.then(async () => {
      const image = await createImageBitmap(new Blob([jpeg], { type: "image/jpeg" }));
      if (isCurrent()) {
        this.lastFrame ??= this.thumbnail();
        this.context.drawImage(image, 0, 0, this.canvas.width, this.canvas.height);
        drawn();
      }
      image.close();
    }).catch((error) => { this.status(this.texts.no_frame); console.warn(error); });
  }

  // How far the person looks to the right, in degrees; 0 for straight ahead.
  looking(degrees) {
    const side = degrees > 180 ? "looking_left" : "looking_right";
    element("looking").textContent = degrees ? this.say(side, { degrees: degrees > 180 ? 360 - degrees : degrees }) : "";
  }

  zoom(isOn = !this.canvas.classList.contains("zoomed")) {
    this.canvas.classList.toggle("zoomed", isOn);
    element("zoom").setAttribute("aria-pressed", String(isOn));
  }

  // Says all that the page knows of a state; again, if it is asked again.
  describe(state) {
    const described = element("described");
    described.textContent = "";
    setTimeout(() => { described.textContent = stateWords((...of) => this.say(...of), state); }, 50);
  }

  thumbnail() {
    const copy = document.createElement("canvas");
    copy.width = copy.height = 112;
    copy.getContext("2d").drawImage(this.canvas, 0, 0, 112, 112);
    return copy;
  }

  keepInStrip() {
    const last = this.lastFrame ?? this.thumbnail();
    this.lastFrame = null;
    if (!this.aids.frame_strip) return;
    if (!this.hasFrame) { this.hasFrame = true; return; }
    const strip = element("strip");
    strip.append(last);
    while (strip.children.length > STRIP) strip.firstChild.remove();
  }

  clearStrip() { element("strip").replaceChildren(); this.hasFrame = false; }

  compass(heading) {
    element("compass").querySelector("path").setAttribute("transform", `rotate(${heading})`);
    element("heading").textContent = this.say("heading", { degrees: heading });
    element("compass").setAttribute("aria-label", this.say("heading", { degrees: heading }));
  }

  landing(landing, ahead) {
    element("landing").hidden = !landing;
    if (!landing) return;
    const figure = element("landing"), cell = figure.querySelector(".cell");
    const [column, row] = landing.cell;
    const at = `translate(${10 * column + 5} ${40 - 10 * row - 5}) rotate(${landing.heading})`;
    figure.querySelector(".me").setAttribute("transform", at);
    cell.toggleAttribute("hidden", !landing.landing);
    cell.classList.toggle("taken", Boolean(ahead?.objects?.length));
    if (landing.landing) {
      cell.setAttribute("x", 10 * landing.landing[0]);
      cell.setAttribute("y", 30 - 10 * landing.landing[1]);
    }
    const words = landing.landing
      ? this.say("landing_cell", { column: landing.landing[0] + 1, row: landing.landing[1] + 1 })
      : this.texts.landing_none;
    figure.querySelector("svg").setAttribute("aria-label", words);
    figure.querySelector("figcaption").textContent = landing.landing ? this.landingCaption : this.texts.landing_oblique;
  }

  published(address) {
    const link = Object.assign(document.createElement("a"), { href: address, textContent: this.texts.published_link });
    element("status").replaceChildren(this.texts.published, " ", link);
    element("status").hidden = false;
  }

  // Shows scores as HTML; those of the whole run above those of its last episode.
  scores(html, isRun) {
    const place = element(isRun && element("totals") ? "totals" : "result");
    const page = new DOMParser().parseFromString(html, "text/html"); // runs no scripts
    place.replaceChildren(...page.body.childNodes);
    for (const map of place.querySelectorAll(".sight .map")) showRoute(map);
    // A person who plays on is not interrupted.
    if (element("game").hidden) place.querySelector("h2")?.focus({ preventScroll: true });
  }
}

// Shows of a map of the streets the part around the two ways, so that it fits a phone.
function showRoute(map) {
  const shown = map.querySelectorAll(".truth, .played, .target, .end, .names text");
  const boxes = [...shown].map((one) => one.getBBox());
  const left = Math.min(...boxes.map((box) => box.x)), top = Math.min(...boxes.map((box) => box.y));
  const right = Math.max(...boxes.map((box) => box.x + box.width)), bottom = Math.max(...boxes.map((box) => box.y + box.height));
  const least = Math.max(MAP_LEAST, map.clientWidth / MAP_SCALE);
  const width = Math.max(right - left + 2 * MAP_MARGIN, least), height = Math.max(bottom - top + 2 * MAP_MARGIN, 0.75 * least);
  map.setAttribute("viewBox", [(left + right - width) / 2, (top + bottom - height) / 2, width, height].join(" "));
}

function drawGrid(group) {
  const lines = [10, 20, 30, 40].map((x) => `M${x} 0V40`).concat([10, 20, 30].map((y) => `M0 ${y}H50`));
  const path = document.createElementNS(SVG, "path");
  path.setAttribute("d", lines.join(""));
  group.append(path);
}
