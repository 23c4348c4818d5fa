// Elements that the watch pages make, and where they stand on a map.

const SVG = "http://www.w3.org/2000/svg";
export const MARKS = new Set(["left", "back", "blocked", "about", "picked_up", "placed", "forced"]);

export function element(name, text) {
  const made = document.createElement(name);
  made.textContent = text; // notes are texts of strangers
  return made;
}

export function shape(name, attributes) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

export function put(group, place, more) {
  group.toggleAttribute("hidden", !place);
  if (place) group.setAttribute("transform", `translate(${place[0]} ${place[1]}) ${more}`);
}

// Widens a map whose agent walks off it, as it can while it plays.
export function include(svg, [x, y]) {
  const box = svg.viewBox.baseVal, margin = 4;
  const left = Math.min(box.x, x - margin), top = Math.min(box.y, y - margin);
  const side = Math.max(box.x + box.width - left, box.y + box.height - top, x + margin - left, y + margin - top);
  if (left < box.x || top < box.y || side > box.width) svg.setAttribute("viewBox", `${left} ${top} ${side} ${side}`);
}

// The way of a phase up to a step, as points of a polyline.
export function way(moments, step) {
  const end = moments[step], points = [];
  for (let n = step; n >= 0; n--) {
    const one = moments[n];
    if (one.turn !== end.turn || one.phase !== end.phase) break;
    points.push(one.place.join(","));
  }
  return points.reverse().join(" ");
}

// Bars of the phases on the strip over a slider. `moments` are those at each of its positions.
export function phaseBars(moments, y) {
  const last = Math.max(moments.length - 1, 1), parts = [];
  let first = 0;
  for (let step = 1; step <= moments.length; step++) {
    const one = moments[step], begin = moments[first];
    if (one && one.turn === begin.turn && one.phase === begin.phase) continue;
    const from = (1000 * first) / last, to = (1000 * (one ? step : last)) / last;
    parts.push(shape("rect", { x: from, y, width: Math.max(to - from - 2, 1), height: 8, class: `strip-${begin.phase}` }));
    first = step;
  }
  return parts;
}

// Marks of a moment on the strip, at a position of `last`.
export function markBars(moment, position, last, y) {
  return moment.marks.filter((mark) => MARKS.has(mark)).map((mark) =>
    shape("rect", { x: (1000 * position) / Math.max(last, 1) - 1.5, y, width: 3, height: 10, class: `mark-${mark}` }));
}
