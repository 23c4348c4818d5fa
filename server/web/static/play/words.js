// What the run's aids and the screen reader's key say, as text. Pure: `say(key, values)` returns a text of the page.

// What a pick-up would take, or the cell ahead in the room.
export function aheadWords(say, ahead) {
  if (!ahead) return "";
  if ("in_reach" in ahead) {
    return ahead.in_reach ? say("in_reach", { object: ahead.object || say("carries_something") }) : say("out_of_reach");
  }
  if (!ahead.cell) return say(ahead.why === "wall" ? "cell_wall" : "cell_oblique");
  const [column, row] = ahead.cell, place = { column: column + 1, row: row + 1 };
  if (!ahead.objects.length) return say("cell_free", place);
  const objects = ahead.objects.map((name) => name || say("carries_something")).join(", ");
  return say("cell_taken", { ...place, objects });
}

// What kept the person from stepping or placing; `why` as in a state's message.
export function whyNotWords(say, outcome, why) {
  if (!why) return say(outcome);
  return say(why.reason === "thing" ? `blocked_${why.side}` : `${outcome}_${why.reason}`, { name: why.name });
}

// The visible things, third by third.
export function sceneWords(say, scene) {
  if (!scene) return "";
  const sides = ["left", "ahead", "right"].map((side) => {
    const things = scene.filter((thing) => thing.side === side).map(({ name, steps }) => say("thing", { name, steps }));
    return things.length ? say(`scene_${side}`, { things: things.join("; ") }) : "";
  });
  return sides.filter(Boolean).join(" ") || say("scene_nothing");
}

// All that the page knows of a state.
export function stateWords(say, state) {
  const isRoom = state.phase === "assembly";
  const phase = say(isRoom ? "place_phase" : "walk_phase", { turn: state.turn });
  const carried = !state.carries ? say("carries_nothing") : state.carried || say("carries_something");
  return [
    say("said_facts", { phase, carried, steps: state.steps_left }),
    aheadWords(say, state.ahead),
    sceneWords(say, state.scene),
  ].filter(Boolean).join(" ");
}
