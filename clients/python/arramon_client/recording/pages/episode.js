"use strict";
(() => {
  const { texts, steps, instructions, poses, obstacles, targets } = JSON.parse(document.getElementById("data").textContent);
  const get = (id) => document.getElementById(id);
  const slider = get("step"), play = get("play"), map = get("map");
  const fill = (text, values) => text.replace(/\{(\w+)\}/g, (_, name) => values[name]);
  let playing = 0;

  const draw = (name, attributes) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    map.append(element);
  };
  const points = (poses) => poses.map(([x, z]) => `${x},${-z}`).join(" ");
  const arrow = ([x, z, heading], size) =>
    draw("path", { class: "here", d: "M0,-1 L.7,.8 L0,.4 L-.7,.8 Z", transform: `translate(${x} ${-z}) rotate(${heading}) scale(${size})` });

  const outdoors = steps.filter((step) => step.phase === "navigation").map((step) => step.pose);
  const spread = (axis) => outdoors.map((pose) => pose[axis]);
  const span = (axis) => [Math.min(...spread(axis)), Math.max(...spread(axis))];
  const [left, right] = outdoors.length ? span(0) : [0, 0];
  const [low, high] = outdoors.length ? span(1) : [0, 0];
  const size = Math.ceil(Math.max(right - left, high - low, 4) * 1.15 + 2);

  const street = (at) => {
    const [x, z] = [(left + right) / 2, (low + high) / 2];
    map.setAttribute("viewBox", `${x - size / 2} ${-z - size / 2} ${size} ${size}`);
    for (const [ox, oz, halfWidth, halfLength, heading] of obstacles)
      draw("rect", { class: "roof", x: -halfWidth, y: -halfLength, width: 2 * halfWidth, height: 2 * halfLength,
        transform: `translate(${ox} ${-oz}) rotate(${heading})` });
    const turn = steps[at].turn;
    draw("polyline", { class: "rest", points: points(outdoors) });
    const past = steps.slice(0, at + 1).filter((step) => step.phase === "navigation" && step.turn === turn);
    draw("polyline", { class: "past", points: points(past.map((step) => step.pose)) });
    if (targets[turn - 1]) draw("circle", { class: "goal", cx: targets[turn - 1][0], cy: -targets[turn - 1][1], r: size / 40 });
    arrow(steps[at].pose, size / 30);
    get("map-place").textContent = fill(texts.street, { size });
    get("map-source").textContent = poses === "pose" ? texts.pose : texts.reckoned;
  };
  const room = (at) => {
    map.setAttribute("viewBox", "-0.6 -4.1 5.2 5.2");
    for (let column = 0; column < 5; column++)
      for (let row = 0; row < 4; row++)
        draw("rect", { class: "grid", x: column - 0.5, y: -row - 0.5, width: 1, height: 1 });
    const same = (step) => step.phase === "assembly" && step.turn === steps[at].turn;
    draw("polyline", { class: "rest", points: points(steps.filter(same).map((step) => step.pose)) });
    draw("polyline", { class: "past", points: points(steps.slice(0, at + 1).filter(same).map((step) => step.pose)) });
    arrow(steps[at].pose, 0.3);
    get("map-place").textContent = texts.room;
    get("map-source").textContent = poses === "pose" ? texts.pose : texts.reckoned_room;
  };

  const picture = (name, kind, data) => {
    get(`${name}-view`).hidden = !steps.some((step) => step[name]);
    if (data) get(name).src = `data:image/${kind};base64,${data}`;
    get(name).style.visibility = data ? "visible" : "hidden";
  };
  const show = (asked) => {
    const at = Math.max(0, Math.min(steps.length - 1, asked)), step = steps[at];
    slider.value = at;
    get("where").textContent = fill(texts.where, { step: step.step + 1, steps: steps[steps.length - 1].step + 1 });
    slider.setAttribute("aria-valuetext", get("where").textContent);
    get("phase").textContent = fill(texts.phase, { turn: step.turn, phase: texts[step.phase] || step.phase, number: step.phase_step + 1, left: step.steps_left });
    get("action").textContent = step.action === null ? texts.failed : texts.actions[step.action];
    get("instruction").textContent = instructions[step.instruction];
    picture("rgb", "jpeg", step.rgb);
    picture("depth", "png", step.depth);
    get("missing").hidden = Boolean(step.rgb || step.depth) || !steps.some((each) => each.rgb || each.depth);
    map.replaceChildren();
    (step.phase === "navigation" ? street : room)(at);
  };
  const stop = () => {
    clearInterval(playing);
    playing = 0;
    play.textContent = texts.play;
  };
  const toggle = () => {
    if (playing) return stop();
    if (Number(slider.value) === steps.length - 1) show(0);
    play.textContent = texts.pause;
    playing = setInterval(() => {
      show(Number(slider.value) + 1);
      if (Number(slider.value) === steps.length - 1) stop();
    }, 250);
  };
  const by = (number) => show(Number(slider.value) + number);
  const keys = {
    ArrowLeft: () => by(-1), ArrowRight: () => by(1), ArrowDown: () => by(-1), ArrowUp: () => by(1),
    PageUp: () => by(10), PageDown: () => by(-10), Home: () => show(0), End: () => show(steps.length - 1), " ": toggle,
  };

  slider.max = Math.max(0, steps.length - 1);
  slider.addEventListener("input", () => show(Number(slider.value)));
  get("back").addEventListener("click", () => by(-1));
  get("next").addEventListener("click", () => by(1));
  play.addEventListener("click", toggle);
  document.addEventListener("keydown", (event) => {
    const onSlider = event.target === slider;
    const scrolls = ["ArrowDown", "ArrowUp", " "].includes(event.key) && !onSlider;
    if (event.ctrlKey || event.altKey || event.metaKey || !keys[event.key] || scrolls) return;
    event.preventDefault();
    keys[event.key]();
  });
  if (steps.length) show(0);
  slider.focus({ preventScroll: true });
})();
