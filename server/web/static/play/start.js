// The form that starts a run; a page without episodes has none.
const element = (id) => document.getElementById(id);
const MOST_EPISODES = 100;

export class StartForm {
  // `memory` fills it in; `start(run, size)` is called with a new run and the size of its images.
  constructor(memory, language, size, start) {
    Object.assign(this, { memory, language, form: element("start") });
    if (!this.form) return;
    const { elements } = this.form;
    elements.token.value = memory.token;
    elements.participant.value = memory.name;
    elements.size.value = String(size);
    elements.split.addEventListener("change", () => this.prepare());
    element("forget").addEventListener("click", () => { memory.end(language); this.prepare(); });
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      memory.keepPerson(elements.token.value.trim(), elements.participant.value.trim());
      const episodes = this.isHidden ? 0 : Number(elements.episodes.value);
      start({ split: elements.split.value, episodes }, Number(elements.size.value));
    });
  }

  get chosen() { return this.form.elements.split.selectedOptions[0].dataset; }

  get isHidden() { return "hidden" in this.chosen; }

  // What can be chosen, and which runs there are.
  prepare() {
    if (!this.form) return;
    const { episodes, token } = this.form.elements;
    episodes.disabled = this.isHidden;
    episodes.max = Math.min(MOST_EPISODES, Number(this.chosen.episodes));
    element("hidden-note").hidden = !this.isHidden;
    token.required = "needed" in token.dataset;
    element("forget").hidden = !this.memory.run(this.language);
    element("last").hidden = !this.memory.last(this.language);
  }
}
