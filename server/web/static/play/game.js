// The state of play: which step is shown, which key waits for its answer, and which were pressed meanwhile.
const MOST_WAITING = 8; // keys that are kept while one is answered
const REFUSED = new Set(["STEP_AHEAD", "STEP_BEHIND", "NOT_YOUR_EPISODE"]); // of keys
const EXPECTED = new Set(["moved", "turned"]); // after anything else the person did not know where the next key leads

export class Game {
  // `send` sends a message, and returns whether it left; `show` has state, frame, phaseEnded, ended and problem.
  constructor(send, show) {
    Object.assign(this, { send, show });
    this.reset();
  }

  reset() {
    this.state = null;    // the latest state, or null before the first and between episodes
    this.pending = null;  // {episode, step, action} that was sent and is not answered
    this.waiting = [];    // actions that were pressed meanwhile, oldest first
    this.dropped = 0;     // number of presses that are not carried out, which the person has yet to be told
    this.isLost = false;  // whether the connection is lost: until a state comes no key is kept
  }

  get isPlaying() { return this.state !== null; }

  // A key is sent for the step that is shown; some more are kept while it is answered. A key that is held adds none to them,
  // so that no step is taken after it is released.
  press(action, repeated = false) {
    if (!this.state) return;
    if (!this.pending) {
      this.pending = { type: "key", episode: this.state.episode, step: this.state.step, action };
      this.sentAt = performance.now();
      this.send(this.pending);
    } else if (!repeated) {
      if (this.isLost || this.waiting.length >= MOST_WAITING) this.dropped += 1;
      else this.waiting.push(action);
    }
  }

  // What waits was meant for another place.
  drop() {
    this.dropped += this.waiting.length;
    this.waiting = [];
  }

  // The connection is lost. The key that waits for its answer is sent again once there is one.
  lose() {
    this.isLost = true;
    this.drop();
  }

  // Number of presses that were dropped and not yet told.
  takeDropped() {
    const dropped = this.dropped;
    this.dropped = 0;
    return dropped;
  }

  take(message) {
    switch (message.type) {
      case "state": this.enter(message); break;
      case "phase_ended":
        this.drop();
        this.show.phaseEnded(message);
        break;
      case "episode_ended": {
        this.drop();
        const dropped = this.takeDropped();
        this.reset();
        this.show.ended(message, dropped);
        break;
      }
      case "problem":
        if (REFUSED.has(message.code)) this.drop();
        if (message.code === "STEP_AHEAD" || message.code === "NOT_YOUR_EPISODE") this.pending = null;
        this.show.problem(message, this.pending ? 0 : this.takeDropped());
        break;
    }
  }

  enter(state) {
    const before = this.state, pending = this.pending;
    const isNew = !before || before.episode !== state.episode || before.step !== state.step;
    if (before && before.episode === state.episode && state.step < before.step) return; // older than what is shown
    if (before && before.phase !== state.phase) this.drop();
    this.state = state;
    this.isLost = false;
    if (!pending) { this.show.state(state, { isNew, before, action: null, dropped: this.takeDropped() }); return; }
    if (pending.episode === state.episode && pending.step === state.step) {
      // The connection broke before the key arrived: it is sent again. If it had arrived, this would be the next step.
      this.show.state(state, { isNew, before, action: null, dropped: 0 });
      this.send(pending);
      return;
    }
    this.pending = null;
    if (!EXPECTED.has(state.outcome)) this.drop();
    const isSettled = this.waiting.length === 0;
    const milliseconds = performance.now() - this.sentAt, dropped = isSettled ? this.takeDropped() : 0;
    this.show.state(state, { isNew, before, action: pending.action, milliseconds, dropped });
    if (!isSettled) this.press(this.waiting.shift());
  }

  // Whether the person may look around: not while a key is answered.
  get isWaitingForKey() { return this.state !== null && this.pending === null; }

  takeFrame(step, jpeg, isLook = false) {
    if (!this.state || this.state.step !== step) return; // late
    if (!isLook) this.show.frame(step, jpeg);
    else if (this.isWaitingForKey) this.show.look(step, jpeg);
  }
}
