// Draws what the page shows beside the view: parts, findings with their words marked, counts, messages.
const SHARP = 60;    // degrees from which a bend is more than a wriggle of the line
const FLASH = 2500;  // milliseconds
const element = (id) => document.getElementById(id);

export class PageView {
  // `targets` are the names of the object to write about, by part.
  constructor(texts, targets, language, maxCharacters) {
    Object.assign(this, { texts, targets, language, maxCharacters });
    this.canvas = element("view");
    this.context = this.canvas.getContext("2d");
  }

  say(key, values = {}) {
    return Object.entries(values).reduce((text, [name, value]) => text.replaceAll(`{${name}}`, value), this.texts[key] ?? key);
  }

  // A message above everything; empty for none. `action` names a button below it.
  status(text, action = "") {
    element("status").textContent = text;
    element("status").hidden = !text;
    element("again").hidden = action !== "again";
  }

  view(image) {
    this.context.drawImage(image, 0, 0, this.canvas.width, this.canvas.height);
  }

  moved({ move, outcome, bend, progress, bearing }, part) {
    element("outcome").textContent = bend.angle ? this.turned(move, outcome, bend) : this.texts[`outcome_${outcome}`] ?? "";
    this.flash(Math.abs(bend.angle) < SHARP ? "" : this.texts[`flash_${bendName(bend.angle)}`]);
    element("way").value = progress;
    element("way").hidden = part % 2 === 1;
    const arrow = element("arrow");
    arrow.toggleAttribute("hidden", bearing === null);
    element("where").hidden = bearing === null;
    if (bearing === null) return;
    arrow.querySelector("g").setAttribute("transform", `rotate(${bearing})`);
    const side = ["ahead", "right", "behind", "left"][Math.round(bearing / 90) % 4];
    element("where").textContent = this.texts[`${part % 2 ? "cell" : "target"}_${side}`];
  }

  // That the line turned the writer: who did not press a key to turn may not notice it. Of bends that follow each other
  // closely it says where they lead together, which is what a text has to say.
  turned(move, outcome, { angle, net, isLater }) {
    const here = bendName(angle), together = bendName(net);
    const bend = this.texts[`bend_${here}`];
    if (move === "back") return this.say("turned_back", { bend });
    const isFaced = outcome === "faced_line";
    const isStart = element("way").value === 0; // not yet that of this move
    if (here === together) return this.say(!isFaced ? "moved_bend" : isStart ? "begins_with_bend" : "faced_bend", { bend });
    if (here.startsWith("little") && together === "straight") return this.texts.moved_sway;
    const first = isStart ? "begins_with_bends" : "first_bend";
    const said = [this.say(isLater ? "later_bend" : first, { bend }), this.say(`together_${together}`)];
    return [...said, isFaced ? this.texts.press_again : ""].filter(Boolean).join(" ");
  }

  // A few words over the view, for a moment.
  flash(text = "") {
    const flash = element("flash");
    clearTimeout(this.flashing);
    flash.textContent = text;
    flash.classList.toggle("shown", Boolean(text));
    if (text) this.flashing = setTimeout(() => flash.classList.remove("shown"), FLASH);
  }

  // The small picture of the other phase of the same object.
  preview(address, part) {
    const isRoom = part % 2 === 1;
    element("preview-image").src = address;
    element("preview-words").textContent = this.texts[isRoom ? "preview_street" : "preview_room"];
    element("preview").hidden = false;
  }

  part(part, reached, states) {
    const isRoom = part % 2 === 1;
    element("heading").textContent = this.say(isRoom ? "room_part" : "street_part", { turn: Math.floor(part / 2) + 1 });
    element("ask").textContent = this.texts[isRoom ? "ask_room" : "ask_street"];
    element("target").textContent = this.targets[part];
    element("act").textContent = this.texts[!isRoom ? "pick_up" : part === states.length - 1 ? "place_last" : "place"];
    element("text").setAttribute("aria-label", element("heading").textContent);
    document.querySelectorAll("#parts button").forEach((button, i) => {
      button.disabled = i > reached;
      button.toggleAttribute("aria-current", i === part);
      button.dataset.state = states[i];
      button.querySelector(".hidden").textContent = this.texts[`state_${states[i]}`];
    });
    element("submit").hidden = reached < states.length;
    element("review-note").hidden = !states.includes("doubtful");
  }

  // The length of the text: not shown anew while it is composed.
  count(text) {
    const length = [...text].length;
    element("count").textContent = this.say("count", { length, most: this.maxCharacters });
    element("count").classList.toggle("over", length > this.maxCharacters);
  }

  // What has become better; "" for nothing. Screen readers would read the same words again if they were set again.
  news(key) {
    const words = this.texts[key] ?? "";
    if (element("news").textContent !== words) element("news").textContent = words;
  }

  saved(key) { element("saved").textContent = this.texts[key] ?? ""; }

  findings(text, findings) {
    element("findings").replaceChildren(...findings.map((finding) => this.finding(finding)));
    const marks = findings.flatMap(({ marks: places, severity }) => places.map(([start, end]) => ({ start, end, severity })));
    element("marked").hidden = marks.length === 0;
    element("marked").replaceChildren(...markedNodes(text, marks));
  }

  finding({ severity, message, marks }) {
    const item = document.createElement("li");
    item.className = severity;
    const kind = Object.assign(document.createElement("b"), { textContent: this.texts[`severity_${severity}`] });
    item.append(kind, " ", message);
    if (marks.length) {
      const button = Object.assign(document.createElement("button"), { type: "button", className: "quiet", textContent: this.texts.show });
      button.addEventListener("click", () => { element("text").focus(); element("text").setSelectionRange(...marks[0]); });
      item.append(" ", button);
    }
    return item;
  }

  aside(texts) {
    element("aside").hidden = texts.length === 0;
    element("aside").querySelector("ul").replaceChildren(...texts.map((text) => Object.assign(document.createElement("li"), { textContent: text, lang: this.language })));
  }
}

function markedNodes(text, marks) {
  const nodes = [];
  let done = 0;
  for (const { start, end, severity } of marks.sort((a, b) => a.start - b.start || b.end - a.end)) {
    if (start < done) continue;
    const mark = Object.assign(document.createElement("mark"), { className: severity, textContent: text.slice(start, end) });
    nodes.push(text.slice(done, start), mark);
    done = end;
  }
  return [...nodes, text.slice(done)];
}

function bendName(bend) {
  if (bend === 0) return "straight";
  if (Math.abs(bend) > 135) return "around";
  return `${Math.abs(bend) < SHARP ? "little_" : ""}${bend < 0 ? "left" : "right"}`;
}
