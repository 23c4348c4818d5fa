// The write page: connects the walk, the four texts, their drafts and the page.
import { Drafts } from "./drafts.js";
import { Evidence } from "./evidence.js";
import { Fit } from "./fit.js";
import { listen } from "./keys.js";
import { PageView } from "./page.js";
import { Server, randomHex } from "./server.js";
import { Walk } from "./walk.js";

const settings = JSON.parse(document.getElementById("settings").textContent);
const { texts: words, parts } = settings;
const element = (id) => document.getElementById(id);
const text = element("text");
const server = new Server(settings.base, settings.csrf);
const page = new PageView(words, parts.map(({ target }) => target), settings.language, settings.max_characters);
const evidence = new Evidence({});
const submission = randomHex();
const fit = new Fit();

let typed = parts.map(() => "");     // the texts, by part
let findings = parts.map(() => []);  // of what was last saved
let isComposing = false;
let isLost = false;                  // whether the page says that no view can be shown

const walk = new Walk(server, settings.size, {
  view: (image) => page.view(image),
  moved: (facts) => {
    if (isLost) page.status("");
    isLost = false;
    if (facts.move) element("passed")?.remove(); // the news of the test before is no news any more
    page.moved(facts, walk.part);
    document.documentElement.dataset.at = walk.position;
    if (facts.before !== walk.position) drafts.change();
    if (Number(facts.before.split(".")[0]) !== walk.part) enterPart();
    else showPart();
  },
  lost: () => { isLost = true; page.status(words.lost); },
  refused: (error) => { isLost = true; refuse(error); },
});

const drafts = new Drafts(server, settings.task, () => ({ position: walk.position, texts: typed, evidence: evidence.counts }), {
  saved: (answer) => {
    findings = answer.findings;
    page.saved(drafts.isDirty ? "unsaved" : "saved"); // something may have been typed meanwhile
    if (!isComposing) showFindings();
    if (!isComposing && !drafts.isDirty) page.news(noteFit()[walk.part]);
    showPart();
  },
  waits: () => page.saved("unsaved"),
  unsaved: () => page.saved("not_saved"),
  takenOver,
  refused: (error) => refuse(error),
});

// Another window writes this task now.
function takenOver() {
  drafts.stop();
  text.readOnly = true;
  page.status(words.taken_over, "again");
}

async function open() {
  let opened;
  page.status(words.loading);
  try {
    opened = await drafts.open();
  } catch (error) {
    if (error.status && !error.isTemporary) { refuse(error); return; }
    page.status(words.lost);
    setTimeout(open, 2000);
    return;
  }
  const { draft, restored, aside } = opened;
  const unsaved = aside ? aside.texts : [];
  typed = restored ? restored.texts : draft.texts;
  findings = draft.findings;
  noteFit();
  Object.assign(evidence.counts, draft.evidence);
  page.aside(unsaved.filter((one) => one && !draft.texts.includes(one)));
  text.readOnly = false;
  await walk.start(restored?.position || draft.position);
  if (!isLost) page.status("");
  enterPart();
  if (restored) drafts.change();
}

function refuse(error) {
  const known = { 401: "signed_out", 403: "signed_out", 404: "task_gone", 409: "task_gone" }[error.status];
  page.status(known ? words[known] : page.say("problem", { message: error.message }));
}

function stateOf(part) {
  if (!typed[part].trim()) return "empty";
  const isFound = (kind) => findings[part].some(({ severity }) => severity === kind);
  if (isFound("blocked")) return "blocked";
  return isFound("suspicious") ? "doubtful" : "written";
}

function showPart() {
  page.part(walk.part, walk.reached, parts.map((_, i) => stateOf(i)));
}

function enterPart() {
  page.preview(`${settings.base}/preview?at=${walk.position}`, walk.part);
  text.value = typed[walk.part];
  evidence.changed(text);
  page.count(text.value);
  page.news("");
  showFindings();
  showPart();
}

function showFindings() {
  page.findings(typed[walk.part], typed[walk.part].trim() ? findings[walk.part] : []);
}

// Returns by part whether its text now fits. An empty text is none that fits: it is as it was before.
function noteFit() {
  return parts.map((_, part) => (typed[part].trim() ? fit.take(part, findings[part]) : ""));
}

// A text as it stands counts only when the input method is done with it.
function takeText() {
  typed[walk.part] = text.value.normalize("NFC");
  page.count(text.value);
  showPart();
  if (text.value.length > settings.max_kept) {
    fit.overflow(walk.part);
    page.saved("too_large");
    page.news("");
  } else drafts.change();
}

text.addEventListener("compositionstart", () => { isComposing = true; });
text.addEventListener("compositionend", () => { isComposing = false; takeText(); });
text.addEventListener("input", (event) => { if (!isComposing && !event.isComposing) takeText(); });

text.addEventListener("focus", () => document.body.classList.add("writes"));
text.addEventListener("blur", () => document.body.classList.remove("writes"));
element("view").addEventListener("pointerdown", () => element("view").focus({ preventScroll: true }));

listen(text, element("view"), {
  move: (move, isRepeated) => walk.move(move, isRepeated),
  write: () => text.focus(),
  walk: () => element("view").focus({ preventScroll: true }),
});

document.querySelectorAll("#parts button").forEach((button, part) => {
  button.addEventListener("click", () => { if (part !== walk.part) walk.enter(part); });
});
element("again").querySelector("button").addEventListener("click", () => { element("again").hidden = true; open(); });
element("submit").addEventListener("click", submit);

async function submit() {
  const missing = parts.findIndex((_, i) => ["empty", "blocked"].includes(stateOf(i)));
  if (missing >= 0) {
    walk.enter(missing);
    page.status(words[stateOf(missing) === "empty" ? "write_first" : "mend_first"]);
    text.focus();
    return;
  }
  element("submit").disabled = true;
  drafts.stop();
  const content = { submission, editor: drafts.editor, position: walk.position, texts: typed, evidence: evidence.counts };
  try {
    const answer = await server.post("submit", content);
    drafts.forget();
    location.assign(answer.next);
  } catch (error) {
    element("submit").disabled = false;
    drafts.isStopped = false;
    if (error.status === 422) {
      findings = error.answer.findings;
      noteFit();
      const blocked = parts.findIndex((_, i) => findings[i].some(({ severity }) => severity === "blocked"));
      if (blocked >= 0 && blocked !== walk.part) walk.enter(blocked); else enterPart();
      page.status(words.mend_first);
    } else if (error.status === 409 && error.answer.newer) takenOver();
    else if (error.status && !error.isTemporary) refuse(error);
    else { page.status(words.not_submitted); drafts.change(); }
  }
}

evidence.watch(text);
element("view").width = element("view").height = settings.size;
open();
