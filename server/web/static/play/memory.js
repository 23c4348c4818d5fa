// What the browser keeps: its player name, the token, and the ids of its runs. Without storage it keeps them until reload.
// The run of the practice is kept by the window alone: another one may begin a practice of its own.
const KEY = "arramon-play", PRACTICE = "arramon-practice-";
const MOST_RUNS = 100;

export class Memory {
  constructor() {
    this.kept = { player: randomHex(), token: "", name: "", runs: [], current: {} };
    try {
      const found = JSON.parse(localStorage.getItem(KEY));
      if (found && typeof found === "object") Object.assign(this.kept, found);
    } catch { /* no storage, or not ours: a new player begins */ }
    if (!/^[0-9a-f]{16,64}$/.test(this.kept.player)) this.kept.player = randomHex();
    if (!Array.isArray(this.kept.runs)) this.kept.runs = [];
    if (!this.kept.current || typeof this.kept.current !== "object") this.kept.current = {};
    this.save();
  }

  get player() { return this.kept.player; }
  get token() { return String(this.kept.token ?? ""); }
  get name() { return String(this.kept.name ?? ""); }
  get earlier() { return this.kept.runs.slice(-MOST_RUNS); }

  get hasPractised() { return Boolean(this.kept.practised); }

  get swipes() { return Boolean(this.kept.swipes); }

  keepSwipes(swipes) { this.kept.swipes = swipes; this.save(); }

  notePractice() { this.kept.practised = true; this.save(); }

  keepPerson(token, name) { Object.assign(this.kept, { token, name }); this.save(); }

  // The run in play in a language.
  run(language) { return this.kept.current[language] ?? ""; }

  // The last run that ended in a language, until it is published.
  last(language) { return this.kept.last?.[language] ?? ""; }

  keepLast(language, run) {
    this.kept.last = { ...this.kept.last, [language]: run };
    this.save();
  }

  begin(language, run) {
    this.kept.current[language] = run;
    if (!this.kept.runs.includes(run)) this.kept.runs = [...this.kept.runs, run].slice(-MOST_RUNS);
    this.save();
  }

  end(language) { delete this.kept.current[language]; this.save(); }

  // The run of the practice that is played in this window in a language; empty for none.
  practice(language) {
    try { return sessionStorage.getItem(PRACTICE + language) ?? ""; } catch { return ""; }
  }

  keepPractice(language, run) {
    try { sessionStorage.setItem(PRACTICE + language, run); } catch { /* private windows have no storage */ }
  }

  save() {
    try { localStorage.setItem(KEY, JSON.stringify(this.kept)); } catch { /* private windows have no storage */ }
  }
}

function randomHex() {
  return [...crypto.getRandomValues(new Uint8Array(16))].map((one) => one.toString(16).padStart(2, "0")).join("");
}
