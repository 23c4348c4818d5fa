// Swipes over the view as actions: up to step forward, sideways to turn. Off until the person turns them on.
import { FORWARD, LEFT, RIGHT } from "./keys.js";

const LEAST = 30; // pixels

// Calls `act(action)` for each swipe over `area` while `isOn()`.
export function listenForSwipes(area, isOn, act) {
  let from = null;
  area.addEventListener("pointerdown", (event) => {
    from = isOn() && event.pointerType !== "mouse" && event.isPrimary ? [event.clientX, event.clientY] : null;
  });
  area.addEventListener("pointercancel", () => { from = null; });
  area.addEventListener("pointerup", (event) => {
    if (!from) return;
    const action = actionOf(event.clientX - from[0], event.clientY - from[1]);
    from = null;
    if (action !== null) act(action);
  });
}

export function actionOf(x, y) {
  if (Math.max(Math.abs(x), Math.abs(y)) < LEAST) return null;
  if (Math.abs(x) > Math.abs(y)) return x < 0 ? LEFT : RIGHT;
  return y < 0 ? FORWARD : null;
}
