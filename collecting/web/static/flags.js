// Flags of the texts: boxes beside the game for the text that is shown, and all of them when the episode has ended.
const element = (id) => document.getElementById(id);

export class Flags {
  constructor(settings) {
    this.settings = settings;
    this.saving = Promise.resolve();
    this.form = element("flags");
    this.form.addEventListener("change", () => this.save());
  }

  // Shows the boxes of the text that is followed, beside the game.
  show(state) {
    const part = `${state.turn}-${state.phase}`;
    for (const group of this.form.querySelectorAll("fieldset")) {
      group.hidden = group.dataset.part !== part;
      if (!group.hidden) group.querySelector(".said").textContent = state.instruction;
    }
    element("flags").hidden = false;
    this.form.classList.add("live");
  }

  // The episode has ended: all boxes, and the button that hands the task in; to give the task back would only lose it.
  end() {
    this.form.classList.remove("live");
    for (const group of this.form.querySelectorAll("fieldset")) group.hidden = false;
    this.form.hidden = false;
    element("flags-later").hidden = element("give-back").hidden = true;
    element("hand-in").hidden = false;
    element("hand-in").scrollIntoView({ block: "nearest" });
    element("done").hidden = false;
    element("done").focus();
  }

  get chosen() { return [...this.form.querySelectorAll("input:checked")].map((box) => box.value); }

  // Saves one after the other, so that the latest choice is the one that stays.
  save() {
    this.saving = this.saving.then(async () => {
      const answer = await fetch(this.settings.flagsAddress, {
        method: "POST",
        headers: { "Content-Type": "application/json", [this.settings.csrfHeader]: this.settings.csrf },
        body: JSON.stringify({ flags: this.chosen }),
      });
      element("flags-problem").hidden = answer.ok;
    }).catch(() => { element("flags-problem").hidden = false; });
    return this.saving;
  }
}
