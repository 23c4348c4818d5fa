// Keys that walk, and keys that lead from walking to writing and back. None walks while somebody types.
const MOVES = {
  ArrowUp: "forward", ArrowDown: "back", ArrowLeft: "left", ArrowRight: "right",
  KeyW: "forward", KeyS: "back", KeyA: "left", KeyD: "right", Space: "act",
};

// `on` has move(name, isRepeated), write() and walk().
export function listen(text, view, on) {
  document.addEventListener("keydown", (event) => {
    // An input method owns its keys, Escape too; 229 is what some of them send without the flag.
    if (event.isComposing || event.keyCode === 229 || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target === text) {
      if (event.key === "Escape") { event.preventDefault(); on.walk(); }
      return;
    }
    if (event.target.closest("input, select, textarea, [contenteditable]")) return;
    const ofButton = event.target.closest("button, a, summary") !== null;
    if (event.key === "Escape") { event.preventDefault(); on.walk(); return; }
    if (event.key === "Enter" && !ofButton) { event.preventDefault(); on.write(); return; }
    const move = MOVES[event.code];
    if (move === undefined || (move === "act" && ofButton)) return;
    event.preventDefault();
    if (event.target !== view && !event.target.closest("button")) on.walk();
    on.move(move, event.repeat);
  });
  for (const button of document.querySelectorAll("[data-move]")) {
    button.addEventListener("click", (event) => {
      on.move(button.dataset.move, false);
      // After a mouse or a finger the keys walk again, and a phone's keyboard makes room for the view.
      if (event.detail > 0) view.focus({ preventScroll: true });
    });
  }
}
