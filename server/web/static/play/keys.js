// Keys and buttons as actions: 0 forward, 1 left, 2 right, 3 pick up or place.
export const FORWARD = 0, LEFT = 1, RIGHT = 2, INTERACT = 3;

const KEYS = {
  ArrowUp: FORWARD, KeyW: FORWARD, ArrowLeft: LEFT, KeyA: LEFT, ArrowRight: RIGHT, KeyD: RIGHT, Space: INTERACT, Enter: INTERACT,
};

// Calls the function that `commands` has for a key's code, such as KeyX, while `isPlaying()`. A key that is held counts once.
export function listenForCommands(isPlaying, commands) {
  document.addEventListener("keydown", (event) => {
    const command = commands[event.code];
    if (!command || !isPlaying() || event.repeat || event.ctrlKey || event.metaKey || event.altKey || event.isComposing) return;
    if (event.target.closest("input, select, textarea")) return;
    event.preventDefault();
    command();
  });
}

// Calls `act(action, repeated)`, while `isPlaying()`, but not for the keys whose codes are in `ignored`.
export function listen(isPlaying, act, ignored = []) {
  document.addEventListener("keydown", (event) => {
    if (!isPlaying() || event.ctrlKey || event.metaKey || event.altKey || event.isComposing) return;
    const action = KEYS[event.code] ?? KEYS[event.key];
    if (action === undefined || ignored.includes(event.code) || event.target.closest("input, select, textarea, summary")) return;
    // A focused button or link keeps Enter and the space bar for itself.
    if (action === INTERACT && event.target.closest("button, a")) return;
    if (event.target.closest("[tabindex]:not(#frame):not(main)") && event.key.startsWith("Arrow")) return; // it scrolls
    event.preventDefault();
    act(action, event.repeat);
  });
  for (const button of document.querySelectorAll("[data-action]")) {
    button.addEventListener("click", (event) => {
      if (isPlaying()) act(Number(button.dataset.action), false);
    });
  }
  // After a mouse or a finger the keys are the game's again, so that the space bar does not repeat a button or clear a box.
  // A label passes the focus to its box after this event. A frame that is hidden takes none.
  document.addEventListener("click", (event) => {
    if (event.detail === 0 || !event.target.closest("button, label, summary, input[type=checkbox]")) return;
    setTimeout(() => { if (isPlaying()) document.getElementById("frame").focus({ preventScroll: true }); });
  });
}
