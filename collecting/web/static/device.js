// Measures the device once, before the first task: a key or a touch, the window, and the time from a key to its picture.
const settings = JSON.parse(document.getElementById("settings").textContent);
const element = (id) => document.getElementById(id);
const canvas = element("drawn"), context = canvas.getContext("2d");
const ROUNDS = 15;

// The time from now until a new frame of the game's size has been decoded and shown, in milliseconds.
async function oneFrame(jpeg) {
  const begun = performance.now();
  const image = await createImageBitmap(new Blob([jpeg], { type: "image/jpeg" }));
  context.drawImage(image, 0, 0, canvas.width, canvas.height);
  image.close();
  await new Promise((shown) => requestAnimationFrame(() => setTimeout(shown)));
  return performance.now() - begun;
}

function picture() {
  for (let i = 0; i < 60; i += 1) {
    context.fillStyle = `hsl(${(i * 47) % 360} 60% 50%)`;
    context.fillRect((i * 83) % 400, (i * 61) % 400, 60, 60);
  }
  return new Promise((made) => canvas.toBlob((blob) => blob.arrayBuffer().then(made), "image/jpeg", 0.9));
}

async function measure(keyboard) {
  const jpeg = await picture();
  const times = [];
  for (let i = 0; i < ROUNDS; i += 1) times.push(await oneFrame(jpeg));
  times.sort((one, other) => one - other);
  return {
    keyboard,
    touch: navigator.maxTouchPoints > 0 || matchMedia("(pointer: coarse)").matches,
    width: Math.round(innerWidth),
    height: Math.round(innerHeight),
    frame_ms: Math.round(100 * times[Math.floor(ROUNDS / 2)]) / 100,
  };
}

let isBusy = false;

async function report(keyboard) {
  if (isBusy) return;
  isBusy = true;
  canvas.hidden = false;
  try {
    const answer = await fetch(settings.address, {
      method: "POST",
      headers: { "Content-Type": "application/json", [settings.header]: settings.csrf },
      body: JSON.stringify(await measure(keyboard)),
    });
    const { problems, message } = await answer.json();
    const isFit = answer.ok && problems.length === 0;
    show(isFit ? settings.texts.fit : message, isFit);
    element("go-on").hidden = !isFit;
    element("retry").hidden = isFit;
  } catch {
    show(settings.texts.lost, false);
    element("retry").hidden = false;
  }
  element("measure").hidden = canvas.hidden = true;
  isBusy = false;
}

function show(text, isGood) {
  element("outcome").textContent = text;
  element("outcome").classList.toggle("good", isGood);
  element("outcome").hidden = false;
}

addEventListener("keydown", (event) => {
  if (element("measure").hidden || !/^(Arrow|Key[WAD]$)/.test(event.code)) return;
  event.preventDefault();
  report(true);
});
element("touch").addEventListener("click", () => report(false));
element("touch").disabled = false; // before this script nothing would hear it
element("retry").querySelector("button").addEventListener("click", () => {
  element("retry").hidden = element("outcome").hidden = true;
  element("measure").hidden = false;
  element("measure").focus();
});
