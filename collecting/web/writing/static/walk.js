// Where the writer is, and what they see there. The server computes every move; the position is all that it needs to know.
const RETRY = 2000;

export class Walk {
  // `show` has view(bitmap), moved(facts), left(position) before a part is left, and lost().
  constructor(server, size, show) {
    Object.assign(this, { server, size, show });
    this.position = "";
    this.isBusy = false;
    this.next = null; // a move that was made meanwhile
  }

  get part() { return Number(this.position.split(".")[0]); }
  get reached() { return Number(this.position.split(".")[5]); }

  start(position) {
    this.position = position;
    return this.request({});
  }

  // One move is under way, one more is kept; further ones of a held key are ignored.
  move(move, isRepeated = false) {
    if (this.isBusy) {
      if (!isRepeated) this.next = { move };
      return;
    }
    this.request({ move });
  }

  enter(part) {
    if (this.isBusy) this.next = { part }; else this.request({ part });
  }

  async request(change) {
    this.isBusy = true;
    try {
      const response = await this.server.get("view", { at: this.position, size: this.size, ...change });
      const before = this.position;
      this.position = response.headers.get("Arramon-Position");
      const bearing = response.headers.get("Arramon-Bearing");
      const image = await createImageBitmap(await response.blob());
      this.show.view(image);
      image.close();
      this.show.moved({
        before,
        move: change.move,
        outcome: response.headers.get("Arramon-Outcome"),
        bend: readBend(response.headers.get("Arramon-Bend")),
        progress: Number(response.headers.get("Arramon-Progress")),
        bearing: bearing ? Number(bearing) : null,
      });
    } catch (error) {
      if (error.status && !error.isTemporary) { this.isBusy = false; this.show.refused(error); return; }
      this.show.lost();
      setTimeout(() => this.request(change), RETRY);
      return;
    }
    this.isBusy = false;
    const next = this.next;
    this.next = null;
    if (next) this.request(next);
  }
}

// How the line turned the writer, from a header such as "-90 90 first": here, together with the bends close to it, and
// whether one of these came before.
function readBend(header) {
  const [angle, net, place] = header.split(" ");
  return { angle: Number(angle), net: Number(net), isLater: place === "later" };
}
