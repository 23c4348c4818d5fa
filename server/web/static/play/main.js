// The play page: connects what the browser keeps, the connection, the game and the view.
import { Connection } from "./connection.js";
import { Game } from "./game.js";
import { listen, listenForCommands } from "./keys.js";
import { Looking } from "./looking.js";
import { Memory } from "./memory.js";
import { StartForm } from "./start.js";
import { listenForSwipes } from "./swipes.js";
import { View } from "./view.js";

const settings = JSON.parse(document.getElementById("settings").textContent);
const { texts, language } = settings;
const element = (id) => document.getElementById(id);
const memory = new Memory();
const view = new View(texts);
const slow = navigator.connection?.saveData || /2g|3g/.test(navigator.connection?.effectiveType ?? "");

const LOW = 480; // pixels of height below which the game is scrolled to

let size = slow ? settings.sizes[1] : settings.sizes[0];
let wanted = null;  // a new run to create; null to continue the one that is kept
let practice = memory.practice(language) || null; // null outside the tutorial; in it the id of its run, empty before it is opened
let beganAnew = false; // whether the page says that the tutorial had to begin again
let lastPractised = ""; // the last episode of the tutorial, whose scores are the placement test
let hasProblem = false; // whether a refused message is shown
let revisited = ""; // an ended run that is shown again
let lastDropped = ""; // of the keys that were pressed after the last episode had ended
let current = null; // the run, as the server opened it

const form = new StartForm(memory, language, size, (run, imageSize) => {
  size = imageSize;
  wanted = run;
  begin(null);
});

const game = new Game((message) => connection.send(message), {
  state: (state, context) => {
    if (context.isNew) looking.end();
    const isOld = context.isNew && (hasProblem || (beganAnew && state.step > 0)); // what the status says
    if (isOld) view.status("");
    if (isOld) hasProblem = beganAnew = false;
    view.state(state, context);
  },
  frame: (step, jpeg) => view.frame(jpeg, () => game.state?.step === step, () => {
    document.documentElement.dataset.drawn = `${game.state?.episode} ${step}`;
    if (game.sentAt) performance.measure("key to frame", { start: game.sentAt, end: performance.now() });
  }),
  look: (step, jpeg) => view.look(jpeg, () => game.isWaitingForKey && game.state.step === step, () => {
    document.documentElement.dataset.looked = String(looking.degrees);
  }),
  phaseEnded: (phase) => view.status(phase.forced ? texts[`step_limit_${phase.phase}`] : ""),
  ended: (ended, dropped) => {
    current.ended = ended.ended;
    lastPractised = practice !== null ? ended.episode : "";
    view.progress(current.ended, current.episodes);
    lastDropped = view.droppedWords(dropped);
    view.status([view.say("ended", { cause: texts[`cause_${ended.cause}`] ?? ended.cause }), lastDropped].join(" ").trim());
    hasProblem = beganAnew = false;
    view.clearStrip();
    if (current.ended < current.episodes) pause();
    if (!current.is_hidden) connection.send({ type: "scores", episode: ended.episode });
  },
  problem: (problem, dropped) => {
    hasProblem = true;
    view.status([view.say("problem", { message: problem.message }), view.droppedWords(dropped)].join(" ").trim());
  },
});

const connection = new Connection(settings.socket, hello, {
  message: take,
  frame: (step, jpeg, isLook) => game.takeFrame(step, jpeg, isLook),
  lost: () => {
    game.lose();
    view.status(texts.lost);
  },
  refused,
});

const looking = new Looking((degrees) => {
  if (!current?.aids.look_around || !game.isWaitingForKey) return false;
  return connection.send({ type: "look", episode: game.state.episode, step: game.state.step, degrees });
}, (degrees) => view.looking(degrees));

function hello() {
  const first = { type: "hello", player: memory.player, token: memory.token, size, pauses: true };
  if (practice !== null) {
    const lessons = { new: { split: "practice", language, episodes: 0 } };
    return { ...first, practice: true, ...(practice ? { run: practice } : lessons) };
  }
  const kept = revisited || memory.run(language);
  if (kept && !wanted) return { ...first, run: kept };
  return { ...first, new: { ...wanted, language, participant: memory.name, earlier: memory.earlier } };
}

function take(message) {
  switch (message.type) {
    case "opened":
      wanted = null;
      current = message;
      if (practice === null) memory.begin(language, message.run);
      else memory.keepPractice(language, practice = message.run);
      view.opened(message);
      view.status(beganAnew ? texts.practice_anew : "");
      for (const button of gameButtons()) button.disabled = false;
      // Without these aids it says only what is written there; the key X stays for screen readers.
      element("describe").hidden = !(message.aids.scene_words || message.aids.ahead);
      showGame(true);
      break;
    case "started":
      view.clearStrip();
      element("result").replaceChildren();
      view.status(beganAnew ? texts.practice_anew : "");
      showGame(true);
      break;
    case "look": break; // its view follows
    case "scores":
      view.scores(message.html, message.episode === "");
      element("onward").hidden = element("begin").hidden;
      if (practice === null && !element("next").hidden) view.status(lastDropped); // the result says how the episode ended, too
      if (practice === null && lastPractised && message.episode === lastPractised) {
        view.testEnded(message.placed.every(Boolean));
      } else if (!message.episode && message.placed.length && message.placed.every(Boolean)) view.praise();
      else if (practice !== null) view.lessonEnded(message.placed.every(Boolean), current.ended, current.episodes);
      break;
    case "published":
      element("publish").hidden = true;
      memory.keepLast(language, "");
      form.prepare();
      view.published(`/${language}/runs/${message.run}`);
      break;
    case "run_ended":
      game.reset();
      connection.finish();
      if (practice !== null) {
        endPractice();
        memory.notePractice();
        showGame(false);
        view.status(texts.practice_ended);
        break;
      }
      memory.end(language);
      memory.keepLast(language, message.run);
      revisited = lastPractised = "";
      showGame(false);
      view.status(view.say("run_ended", { ended: message.ended }));
      element("publish").hidden = message.state !== "COMPLETE";
      for (const [number, note] of element("publish").querySelectorAll("span").entries()) note.hidden = Boolean(memory.token) !== (number === 1);
      connection.send({ type: "scores", episode: "" });
      break;
    default: game.take(message);
  }
}

function refused(closed, isFinal) {
  game.lose();
  game.state = null; // keys wait until the page is connected again
  const known = texts[`closed_${closed.code}`];
  view.status(known ? view.say(`closed_${closed.code}`, { message: closed.message }) : closed.message);
  if (!isFinal) return;
  const movedOn = closed.code === "Replaced" || closed.code === "TakenOver";
  element("again").hidden = !movedOn;
  for (const button of gameButtons()) button.disabled = movedOn;
  if (revisited && !movedOn) memory.keepLast(language, "");
  revisited = "";
  if (practice !== null && closed.code === "NotFound") { beginAnew(); return; } // it was kept in memory only
  if (practice !== null && !movedOn) endPractice();
  else if (closed.code === "NotFound" && !wanted) memory.end(language);
  if (!movedOn) showGame(false);
}

function endPractice() {
  practice = null;
  beganAnew = false;
  memory.keepPractice(language, "");
}

// The server has forgotten the practice.
function beginAnew() {
  practice = "";
  beganAnew = true;
  connect();
}

// Leaves the practice, or the run, which is then over for this browser.
function leave() {
  const isPractice = practice !== null;
  if (!isPractice && !confirm(texts.leave_really)) return;
  if (isPractice) endPractice();
  else memory.end(language);
  connection.stop();
  game.reset();
  element("result").replaceChildren();
  showGame(false);
  view.status(texts[isPractice ? "left_practice" : "left_run"]);
}

// One beside the game, and one between two episodes.
function leaveButtons() { return document.querySelectorAll(".leave"); }

function gameButtons() { return element("game").querySelectorAll("button"); }

// Between two episodes: the person reads how the last one went.
function pause() {
  showGame(true);
  element("game").hidden = true;
  document.body.classList.remove("playing");
  element("next").hidden = element("leave").hidden = false;
  element("next").querySelector("span").hidden = !current.has_clocks;
  window.scrollTo(0, 0);
}

function showGame(plays) {
  element("game").hidden = !plays;
  element("begin").hidden = plays;
  for (const button of leaveButtons()) button.textContent = texts[practice === null ? "leave_run" : "leave_practice"];
  const isKnown = memory.hasPractised || memory.earlier.length > 0;
  element("practice").firstElementChild.hidden = isKnown;
  element("practice").classList.toggle("notice", !isKnown);
  element("practice").querySelector("button").classList.toggle("quiet", isKnown);
  for (const id of ["again", "publish", "next", "leave", "onward", "practise-again"]) element(id).hidden = true;
  if (!plays) { form.prepare(); window.scrollTo(0, 0); }
  document.body.classList.toggle("playing", plays);
  if (!plays) return;
  element("totals").replaceChildren();
  element("frame").focus({ preventScroll: true });
  if (innerHeight < LOW) element("game").scrollIntoView();
}

// Says that runs in other languages wait there.
function showElsewhere() {
  const others = [...document.querySelectorAll("header nav a[hreflang]")].filter((link) => memory.run(link.hreflang));
  element("elsewhere").textContent = others.map((link) => view.say("elsewhere", { language: link.textContent })).join(" ");
  element("elsewhere").hidden = !others.length;
}

// Begins the practice, or the run that is wanted.
function begin(lessons) {
  practice = lessons;
  revisited = "";
  element("result").replaceChildren();
  element("totals").replaceChildren();
  connect();
}

function connect() {
  connection.stop();
  game.reset();
  view.status(texts.connecting);
  connection.open();
}

listen(() => game.isPlaying, (action, repeated) => game.press(action, repeated));

listenForSwipes(document.querySelector(".frame"), () => memory.swipes && game.isPlaying, (action) => game.press(action));

const commands = {
  KeyQ: () => looking.turn(-1),
  KeyE: () => looking.turn(1),
  KeyZ: () => { if (current?.aids.zoom) view.zoom(); },
  KeyX: () => { if (game.state) view.describe(game.state); },
};
listenForCommands(() => game.isPlaying, commands);
for (const button of document.querySelectorAll("[data-command]")) {
  button.addEventListener("click", commands[button.dataset.command]);
}

element("swipes").hidden = false; // other pages with the game have none
function useSwipes() {
  document.querySelector(".frame").classList.toggle("swiped", memory.swipes);
  element("swipes").querySelector("input").checked = memory.swipes;
}
useSwipes();
element("swipes").querySelector("input").addEventListener("change", (event) => {
  memory.keepSwipes(event.target.checked);
  useSwipes();
});

for (const button of document.querySelectorAll("#practice button, #practise-again")) button.addEventListener("click", () => begin(""));
element("again").querySelector("button").addEventListener("click", () => { element("again").hidden = true; connect(); });
element("next").querySelector("button").addEventListener("click", () => {
  if (connection.send({ type: "next" })) element("next").hidden = true; // or the page comes back to it
});
element("publish").querySelector("button").addEventListener("click", () => {
  if (!connection.send({ type: "publish" })) showLast(); // it was closed long ago; the button is there again
});
element("last")?.querySelector("button").addEventListener("click", showLast);
function showLast() {
  revisited = memory.last(language);
  practice = null;
  element("result").replaceChildren();
  connect();
}
element("give-up").addEventListener("click", () => {
  if (game.state && confirm(texts.give_up_really)) connection.send({ type: "give_up", episode: game.state.episode });
});
for (const button of leaveButtons()) button.addEventListener("click", leave);
showElsewhere();
element("how")?.toggleAttribute("open", memory.earlier.length === 0);
if (practice || memory.run(language)) { element("begin").hidden = true; connect(); } else showGame(false);
