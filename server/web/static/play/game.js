// The state of play: which step is shown, which key waits for its answer, and which was pressed meanwhile.
export class Game {
  // `send` sends a message, and returns whether it left; `show` has state, frame, phaseEnded, ended and problem.
  constructor(send, show) {
    Object.assign(this, { send, show });
    this.reset();
  }

  reset() {
    this.state = null;    // the latest state, or null before the first and between episodes
    this.pending = null;  // {episode, step, action} that was sent and is not answered
    this.next = null;     // an action that was pressed meanwhile
  }

  get isPlaying() { return this.state !== null; }

  // A key is sent for the step that is shown; one more is kept while it is answered, further ones are ignored.
  press(action, repeated = false) {
    if (!this.state) return;
    if (this.pending) {
      if (!repeated) this.next = action;
      return;
    }
    this.pending = { type: "key", episode: this.state.episode, step: this.state.step, action };
    this.sentAt = performance.now();
    this.send(this.pending);
  }

  take(message) {
    switch (message.type) {
      case "state": this.enter(message); break;
      case "phase_ended":
        this.next = null; // it was meant for the other place
        this.show.phaseEnded(message);
        break;
      case "episode_ended":
        this.reset();
        this.show.ended(message);
        break;
      case "problem":
        if (message.code === "STEP_AHEAD" || message.code === "NOT_YOUR_EPISODE") this.pending = this.next = null;
        this.show.problem(message);
        break;
    }
  }

  enter(state) {
    const before = this.state, pending = this.pending;
    const isNew = !before || before.episode !== state.episode || before.step !== state.step;
    if (before && before.episode === state.episode && state.step < before.step) return; // older than what is shown
    if (before && before.phase !== state.phase) this.next = null;
    this.state = state;
    if (!pending) { this.show.state(state, { isNew, before, action: null }); return; }
    if (pending.episode === state.episode && pending.step === state.step) {
      // The connection broke before the key arrived: it is sent again. If it had arrived, this would be the next step.
      this.show.state(state, { isNew, before, action: null });
      this.send(pending);
      return;
    }
    this.pending = null;
    this.show.state(state, { isNew, before, action: pending.action, milliseconds: performance.now() - this.sentAt });
    const next = this.next;
    this.next = null;
    if (next !== null) this.press(next);
  }

  // Whether the person may look around: not while a key is answered.
  get isWaitingForKey() { return this.state !== null && this.pending === null; }

  takeFrame(step, jpeg, isLook = false) {
    if (!this.state || this.state.step !== step) return; // late
    if (!isLook) this.show.frame(step, jpeg);
    else if (this.isWaitingForKey) this.show.look(step, jpeg);
  }
}
