// The page on which a worker follows a text, and the one of the placement test: the parts of the play page, and flags.
const source = document.getElementById("settings");
const settings = JSON.parse(source.textContent);
const play = source.dataset.play.replace("main.js", ""); // the folder has a digest in its name
const { texts, language } = settings;
const parts = ["connection", "game", "keys", "view"].map((name) => import(`${play}${name}.js`));
const [{ Connection }, { Game }, { listen }, { View }] = await Promise.all(parts);
const element = (id) => document.getElementById(id);
if (!settings.isTest) texts.picked_up = texts.picked_up_unnamed; // the practice names what is picked up
const view = new View(texts);
const slow = navigator.connection?.saveData || /2g|3g/.test(navigator.connection?.effectiveType ?? "");
const size = settings.sizes[slow ? 1 : 0];
const flags = settings.isTest ? null : new (await import("./flags.js")).Flags(settings);

let practiceRun = "";  // of the placement test, once it is opened
let run = null;        // as the server opened it
let lastEpisode = "";
let isSkipped = false; // whether the person has skipped the part of the practice that ended last

const game = new Game((message) => connection.send(message), {
  state: (state, context) => { flags?.show(state); view.state(state, context); },
  frame: (step, jpeg) => view.frame(jpeg, () => game.state?.step === step, () => {
    document.documentElement.dataset.drawn = `${game.state?.episode} ${step}`;
  }),
  phaseEnded: (phase) => view.status(phase.forced ? texts.step_limit : ""),
  ended: (ended, dropped) => {
    lastEpisode = ended.episode;
    run.ended = ended.ended;
    showProgress();
    if (dropped) view.status(view.droppedWords(dropped));
    view.clearStrip();
    if (settings.isTest && run.ended < run.episodes) connection.send({ type: "scores", episode: ended.episode });
  },
  problem: (problem, dropped) => view.status([view.say("problem", { message: problem.message }), view.droppedWords(dropped)].join(" ").trim()),
});

const connection = new Connection(settings.socket, hello, {
  message: take,
  frame: (step, jpeg) => game.takeFrame(step, jpeg),
  lost: () => { game.lose(); view.status(texts.lost); },
  refused,
});

function hello() {
  const first = { type: "hello", player: settings.player, token: "", size };
  const fresh = { split: settings.isTest ? "practice" : "text", language, episodes: settings.lessons };
  if (!settings.isTest) return { ...first, new: fresh };
  return { ...first, practice: true, ...(practiceRun ? { run: practiceRun } : { new: fresh }) };
}

function take(message) {
  switch (message.type) {
    case "opened":
      if (settings.isTest) practiceRun = message.run;
      run = message;
      view.opened(message);
      showProgress();
      view.status("");
      showGame(true);
      break;
    case "started": view.clearStrip(); break;
    case "scores":
      if (message.episode === lastEpisode && run.ended === run.episodes) endTest(message);
      else if (isSkipped) showSkipped();
      else view.lessonEnded(message.placed.every(Boolean), run.ended, run.episodes);
      isSkipped = false;
      break;
    case "run_ended":
      game.reset();
      showGame(false);
      if (settings.isTest) connection.send({ type: "scores", episode: lastEpisode });
      else { connection.stop(); flags.end(); }
      break;
    default: game.take(message);
  }
}

// Whether the part that is played is the last one: of the practice it is the test.
function isLast() { return run.ended + 1 >= run.episodes; }

function showProgress() {
  view.progress(run.ended, run.episodes);
  for (const one of [element("progress"), element("progress").previousElementSibling]) one.hidden = !settings.isTest; // one text
  if (!settings.isTest || !isLast()) return;
  element("progress").textContent = texts.test_progress;
  document.querySelector("#give-up + .soft").textContent = texts.test_note;
}

function showSkipped() {
  const said = view.say("lesson_skipped", { number: run.ended, all: run.episodes });
  view.status(isLast() ? `${said} ${texts.test_begins}` : said);
}

function endTest(message) {
  connection.stop();
  view.scores(message.html);
  const passed = message.placed.every(Boolean);
  view.status(passed ? texts.test_passed : texts.test_failed, passed);
  element(passed ? "go-on" : "repeat").hidden = false;
}

function refused(closed, isFinal) {
  game.lose();
  game.state = null; // keys wait until the page is connected again
  if (settings.isTest && closed.code === "NotFound" && practiceRun) { practiceRun = ""; connect(); return; } // kept in memory only
  const known = texts[`closed_${closed.code}`];
  view.status(known ? view.say(`closed_${closed.code}`, { message: closed.message }) : closed.message);
  if (!isFinal) return;
  element("again").hidden = !(closed.code === "Replaced" || closed.code === "TakenOver");
  if (element("again").hidden) showGame(false);
}

function showGame(plays) {
  element("game").hidden = !plays;
  document.body.classList.toggle("playing", plays);
  if (plays) element("frame").focus({ preventScroll: true });
}

function connect() {
  connection.stop();
  game.reset();
  view.status(texts.connecting);
  connection.open();
}

// Enter does nothing here: on the page of writing it leads to the text, and what is picked up cannot be put back.
listen(() => game.isPlaying, (action, repeated) => game.press(action, repeated), ["Enter", "NumpadEnter"]);
element("again").querySelector("button").addEventListener("click", () => { element("again").hidden = true; connect(); });
element("give-up").addEventListener("click", () => {
  const question = !settings.isTest ? texts.give_up_really : isLast() ? texts.skip_test_really : "";
  if (game.state && (!question || confirm(question))) {
    isSkipped = true;
    connection.send({ type: "give_up", episode: game.state.episode });
  }
  element("frame").focus({ preventScroll: true }); // so that the space bar does not press the button again
});
const begin = element("begin")?.querySelector("button");
begin?.addEventListener("click", () => { element("begin").hidden = true; connect(); });
if (begin) begin.disabled = false; // before this script, which waits for its parts, nothing would hear a click
else connect();
