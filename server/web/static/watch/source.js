// Moments, notes and frames of an episode: from the server, or embedded in a file that stands alone.

const AHEAD = 8; // frames loaded before they are shown
const LIVE_MS = 400; // between two requests for new steps

export class Source {
  // section: the element with the addresses. onGrow: called when there are new moments, with whether the turn changed.
  // onVanish: called when an episode that was followed is there no more.
  constructor(section, onGrow, onVanish) {
    this.section = section;
    this.onGrow = onGrow;
    this.onVanish = onVanish;
    this.moments = [];
    this.notes = {};
    this.live = false;
    this.next = "";
    this.kind = "rgb";
    this.loading = new Map();
    const embedded = document.getElementById("watch-film");
    this.film = embedded ? JSON.parse(embedded.textContent) : null;
  }

  get last() { return this.moments.length - 1; }

  async open() {
    if (this.film) this.take(this.film.data);
    else await this.ask(0);
    if (this.live) this.follow();
  }

  async ask(first) {
    const response = await fetch(`${this.section.dataset.moments}?from=${first}`);
    if (!response.ok) throw Object.assign(new Error(`moments: ${response.status}`), { gone: response.status === 404 });
    this.take(await response.json());
  }

  take(data) {
    this.moments.length = data.first;
    this.moments.push(...data.moments);
    Object.assign(this.notes, data.notes);
    this.live = data.live;
    this.next = data.next;
  }

  // Asks again and again while the episode is played; the last moment is asked for again, as its action was not known.
  async follow() {
    let wait = LIVE_MS;
    while (this.live) {
      await new Promise((done) => setTimeout(done, wait));
      if (document.hidden) continue;
      const before = this.last, turn = this.moments[before].turn;
      try {
        await this.ask(Math.max(before, 0));
        wait = LIVE_MS;
      } catch (error) {
        if (error.gone) {
          this.live = false;
          this.onVanish();
          return;
        }
        wait = Math.min(wait * 2, 10000); // the server may be restarting
        continue;
      }
      if (this.last > before || !this.live) await this.onGrow(this.moments[this.last].turn !== turn);
    }
  }

  address(step) {
    if (this.film) return this.film.frames[step];
    const kind = this.kind === "rgb" ? "" : `?kind=${this.kind}`;
    return `${this.section.dataset.frames}${step}.jpg${kind}`;
  }

  // Resolves once the frame of a step can be drawn without a flash, and loads the next ones.
  async ready(step) {
    for (let n = step + 1; n <= Math.min(step + AHEAD, this.last); n++) this.load(n);
    await this.load(step);
  }

  load(step) {
    const address = this.address(step);
    let found = this.loading.get(address);
    if (!found) {
      const image = new Image();
      image.src = address;
      found = image.decode().then(() => image, (error) => { this.loading.delete(address); throw error; });
      found.catch(() => {}); // whoever shows it handles the error
      this.loading.set(address, found);
      if (this.loading.size > 4 * AHEAD) this.loading.delete(this.loading.keys().next().value);
    }
    return found;
  }
}
