// Counts of what may mean that a text was not typed: pasted, put in silently, the tab left. They decide nothing by themselves.
const SUDDEN = 25; // characters that appear at once without a paste: more than a keyboard's suggestion or a spelling correction

export class Evidence {
  constructor(counts) {
    this.counts = { pastes: 0, pasted_characters: 0, insertions: 0, inserted_characters: 0, leaves: 0, away_seconds: 0 };
    Object.assign(this.counts, counts);
    this.isComposing = false;
    this.length = 0;
    this.leftAt = null;
  }

  watch(text) {
    text.addEventListener("compositionstart", () => { this.isComposing = true; });
    text.addEventListener("compositionend", () => { this.isComposing = false; this.length = text.value.length; });
    text.addEventListener("paste", (event) => {
      if (this.isComposing) return;
      this.counts.pastes += 1;
      this.counts.pasted_characters += event.clipboardData?.getData("text").length ?? 0;
    });
    text.addEventListener("input", (event) => {
      const grown = text.value.length - this.length;
      this.length = text.value.length;
      if (this.isComposing || event.isComposing || grown < SUDDEN) return;
      if (/^(insertFromPaste|insertCompositionText|insertReplacementText|history)/.test(event.inputType ?? "")) return;
      this.counts.insertions += 1;
      this.counts.inserted_characters += grown;
    });
    document.addEventListener("visibilitychange", () => {
      if (document.hidden) { this.leftAt = performance.now(); this.counts.leaves += 1; return; }
      if (this.leftAt !== null) this.counts.away_seconds += Math.round((performance.now() - this.leftAt) / 1000);
      this.leftAt = null;
    });
  }

  // The text was changed by the page itself.
  changed(text) { this.length = text.value.length; }
}
