// Looking around: the view in other headings, without steps. The next state ends it.
const TURN = 30;

export class Looking {
  // `request(degrees)` asks for a view, and returns whether it may; `show(degrees)` shows how far one looks, 0 for ahead.
  constructor(request, show) {
    Object.assign(this, { request, show, degrees: 0 });
  }

  turn(steps) {
    const degrees = (this.degrees + TURN * steps + 360) % 360;
    if (!this.request(degrees)) return;
    this.degrees = degrees;
    this.show(degrees);
  }

  end() {
    if (this.degrees) this.show(0);
    this.degrees = 0;
  }
}
