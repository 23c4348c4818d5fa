// Notices when a text that had to be corrected, or was too long or too short, has become one that fits.
const LENGTHS = new Set(["few_words", "long", "too_long"]);

export class Fit {
  constructor() { this.states = new Map(); } // by part: what was wrong with its text, and the news about it

  // The text is too long even to be saved, so that there are no findings about it.
  overflow(part) { this.states.set(part, { isBlocked: true, isOfWrongLength: true, news: "" }); }

  // Take the findings about a part's text as it was saved. Returns the key of the news, "" for none: news stay for as
  // long as they are true.
  take(part, findings) {
    const before = this.states.get(part) ?? { isBlocked: false, isOfWrongLength: false, news: "" };
    const isBlocked = findings.some(({ severity }) => severity === "blocked");
    const isOfWrongLength = findings.some(({ check }) => LENGTHS.has(check));
    let news = isOfWrongLength || (isBlocked && before.news === "fits") ? "" : before.news;
    if (before.isBlocked && !isBlocked) news = "fits";
    else if (before.isOfWrongLength && !isOfWrongLength) news = "fits_in_length";
    this.states.set(part, { isBlocked, isOfWrongLength, news });
    return news;
  }
}
