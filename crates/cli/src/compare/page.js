
// The page: reads the pictures, then shows them as the controls say.

const at = (id) => document.getElementById(id);
const data = JSON.parse(at("data").textContent);
const [width, height] = data.shown;
const values = valuesOfCodes(data.lowest, data.stepsPerOctave);
const colours = palette();
const names = shortNames(data.pictures.map(({ name }) => name));

/** What is shown. */
const state = { view: "slider", errors: false, stops: data.stops, left: 0, right: 1, place: null, inset: 23 };

/** Of each picture, once it is read: its codes, and the logarithms of its errors. */
const pictures = [];
let decades = [-6, 0];
let bytes = bytesOfCodes(values, state.stops);

/** File names without folders, unless two are the same then. */
function shortNames(files) {
  const short = files.map((file) => file.split(/[\\/]/).pop());
  return new Set(short).size === short.length ? short : files;
}

const nameOf = (i) => `${i} ${names[i]}`;
const isReference = (i) => i === 0;

// Reading

async function readBytes(image) {
  await image.decode();
  const canvas = element("canvas");
  [canvas.width, canvas.height] = data.shown;
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(image, 0, 0);
  image.removeAttribute("src");
  return context.getImageData(0, 0, width, height).data;
}

async function readPictures() {
  const images = (kind) => [...at("bytes").getElementsByClassName(kind)];
  const [judged] = await Promise.all(images("judged").map(readBytes));
  const isJudged = Uint8Array.from({ length: width * height }, (_, pixel) => judged[pixel * 4]);
  const [high, low] = [images("high"), images("low")];
  const damaged = [];
  for (let i = 0; i < high.length; i += 1) {
    at("state").textContent = `Reading picture ${i + 1} of ${high.length} …`;
    const codes = joinBytes(await readBytes(high[i]), await readBytes(low[i]));
    if (sumOf(codes) !== data.pictures[i].sum) damaged.push(names[i]);
    const logs = logErrors(codes, i === 0 ? codes : pictures[0].codes, isJudged, values, data.epsilon);
    pictures.push({ codes, logs, histogram: histogramOf(logs) });
  }
  at("bytes").remove();
  return damaged;
}

// Drawing

let buffer = null;

/** Draws picture `i`, or its errors, into a canvas: whole, or `count` pixels in each direction around a place. */
function draw(canvas, i, centre = null, count = 0) {
  const [columns, rows] = centre ? [count, count] : [width, height];
  if (canvas.width !== columns || canvas.height !== rows) [canvas.width, canvas.height] = [columns, rows];
  const context = canvas.getContext("2d");
  const whole = buffer ??= context.createImageData(width, height);
  const pixels = centre ? context.createImageData(count, count) : whole;
  const out = new Uint32Array(pixels.data.buffer);
  const { codes, logs } = pictures[i];
  const colour = state.errors && !isReference(i)
    ? (pixel) => colourOfError(logs[pixel], decades, colours)
    : (pixel) => colourOfLight(codes, pixel * 3, bytes);
  if (!centre) {
    for (let pixel = 0; pixel < out.length; pixel += 1) out[pixel] = colour(pixel);
  } else {
    const [x0, y0] = centre.map((value) => value - (count - 1) / 2);
    for (let y = Math.max(y0, 0); y < Math.min(y0 + count, height); y += 1) {
      for (let x = Math.max(x0, 0); x < Math.min(x0 + count, width); x += 1) {
        out[(y - y0) * count + x - x0] = colour(y * width + x);
      }
    }
  }
  context.putImageData(pixels, 0, 0);
}

const waiting = new Set();

/** Does `work` before the next picture of the screen, once however often it was asked for. */
function soon(work) {
  if (waiting.size === 0) {
    requestAnimationFrame(() => {
      const todo = [...waiting];
      waiting.clear();
      todo.forEach((one) => one());
    });
  }
  waiting.add(work);
}

function drawView() {
  if (state.view === "slider") {
    draw(at("over"), state.left);
    draw(at("under"), state.right);
  } else {
    [...at("grid").getElementsByTagName("canvas")].forEach((canvas, i) => draw(canvas, i));
  }
}

function drawInsets() {
  const shown = state.inset > 0;
  at("insets").hidden = !shown;
  const centre = state.place ?? [Math.floor(width / 2), Math.floor(height / 2)];
  markPlace(shown && state.place !== null, centre);
  if (!shown) return;
  [...at("insets").children].forEach((inset, i) => {
    draw(inset.querySelector("canvas"), i, centre, state.inset);
    inset.querySelector(".values").textContent = describe(i, centre[1] * width + centre[0]);
    const side = `${100 / state.inset}%`;
    Object.assign(inset.querySelector(".centre").style, { width: side, height: side });
  });
}

/** Values and error of a pixel. */
function describe(i, pixel) {
  const { codes, logs } = pictures[i];
  const lines = ["R", "G", "B"].map((channel, c) => {
    const code = codes[pixel * 3 + c];
    const value = code === NOT_FINITE ? "not finite" : number(values[code]);
    return `${channel} ${(code & BRIGHTEST) === BRIGHTEST ? "beyond " : ""}${value}`;
  });
  const log = logs[pixel];
  if (!isReference(i)) lines.push(log === log ? `error ${number(10 ** log)}` : "not judged");
  return lines.join("\n");
}

function number(value) {
  const size = Math.abs(value);
  return value === 0 ? "0" : size >= 0.001 && size < 10000 ? value.toPrecision(4) : value.toExponential(2);
}

/** Frames what the insets show in every picture. */
function markPlace(shown, [x, y]) {
  for (const frame of document.querySelectorAll(".place")) {
    frame.hidden = !shown;
    const half = (state.inset - 1) / 2;
    frame.style.left = `${(x - half) / width * 100}%`;
    frame.style.top = `${(y - half) / height * 100}%`;
    frame.style.width = `${state.inset / width * 100}%`;
    frame.style.height = `${state.inset / height * 100}%`;
  }
}

function drawLegend() {
  at("legend").hidden = !state.errors;
  at("unjudged").hidden = data.leftOut === 0;
  const context = at("colours").getContext("2d");
  const pixels = context.createImageData(256, 1);
  new Uint32Array(pixels.data.buffer).set(colours);
  context.putImageData(pixels, 0, 0);
  const [first, last] = decades;
  at("ticks").replaceChildren(...Array.from({ length: last - first + 1 }, (_, i) => {
    const tick = element("span", power(first + i));
    tick.style.left = `${i / (last - first) * 100}%`;
    return tick;
  }));
}

// Changes

function update() {
  soon(drawView);
  soon(drawInsets);
}

function expose(stops) {
  const range = at("exposure");
  state.stops = Math.min(Math.max(stops, Number(range.min)), Number(range.max));
  range.value = state.stops;
  at("stops").textContent = `${state.stops < 0 ? "−" : "+"}${Math.abs(state.stops).toFixed(2)} stops`;
  bytes = bytesOfCodes(values, state.stops);
  update();
}

function choose(view, errors) {
  Object.assign(state, { view, errors });
  at("show-slider").setAttribute("aria-pressed", view === "slider");
  at("show-grid").setAttribute("aria-pressed", view === "grid");
  at("show-light").setAttribute("aria-pressed", !errors);
  at("show-errors").setAttribute("aria-pressed", errors);
  at("slider").hidden = at("pair").hidden = view !== "slider";
  at("grid").hidden = view !== "grid";
  drawLegend();
  update();
  soon(fit);
}

function pick(side, i) {
  if (i >= pictures.length) return;
  state[side] = i;
  at(side).value = i;
  [...at("grid").children].forEach((figure, k) => figure.classList.toggle("picked", k === state.right));
  if (state.view === "grid" && side === "right") at("grid").children[i].scrollIntoView({ block: "nearest" });
  update();
}

function moveWipe(share) {
  const left = Math.min(Math.max(share, 0), 1) * 100;
  at("over").style.clipPath = `inset(0 ${100 - left}% 0 0)`;
  at("divider").style.left = `${left}%`;
}

/** Fits the pictures to the window. Pixels shown larger than they are have sharp edges, smaller ones are smoothed. */
function fit() {
  if (state.view === "grid") arrangeGrid();
  for (const stage of document.querySelectorAll(".stage")) {
    stage.classList.toggle("sharp", stage.clientWidth * devicePixelRatio > width);
  }
}

/** As few columns as show all pictures at once, unless they become too small to see anything. */
function arrangeGrid() {
  const [gap, caption, least] = [16, 28, 250];
  const inner = at("grid").clientWidth;
  const taken = [document.querySelector("header"), at("controls"), at("choices"), at("insets")];
  const free = Math.max(taken.reduce((left, part) => left - part.offsetHeight, innerHeight - gap * 2), least);
  const sizeOf = (columns) => {
    const rows = Math.ceil(pictures.length / columns);
    const high = (free / rows - caption - gap) * width / height;
    return { wide: (inner + gap) / columns - gap, high };
  };
  const tooHigh = (columns) => sizeOf(columns).wide > sizeOf(columns).high && sizeOf(columns + 1).wide >= least;
  let columns = 1;
  while (columns < pictures.length && tooHigh(columns)) columns += 1;
  const { wide, high } = sizeOf(columns);
  const side = Math.floor(Math.min(wide, Math.max(high, least), largest()));
  at("grid").style.gridTemplateColumns = `repeat(${columns}, ${side}px)`;
}

/** Width that no picture exceeds: larger pixels show no more. */
const largest = () => Math.max(width * 4, 320);

// Building

/** Insets follow the pointer over `stage`; `dragged` is told the share of its width that a pressed pointer is at. */
function follow(stage, dragged = () => {}) {
  const look = (event) => {
    const box = stage.getBoundingClientRect();
    const share = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
    const pixel = (part, count) => Math.min(Math.max(Math.floor(part * count), 0), count - 1);
    state.place = [pixel(share[0], width), pixel(share[1], height)];
    if (event.buttons & 1) dragged(share[0]);
    soon(drawInsets);
  };
  stage.addEventListener("pointermove", look);
  stage.addEventListener("pointerdown", (event) => {
    stage.setPointerCapture(event.pointerId);
    look(event);
  });
}

function buildGrid() {
  const column = data.table.head.indexOf("rmse");
  at("grid").replaceChildren(...pictures.map((_, i) => {
    const stage = element("div", "", [element("canvas"), element("div")]);
    stage.className = "stage";
    stage.lastChild.className = "place";
    stage.lastChild.hidden = true;
    follow(stage);
    const measured = data.pictures[i].role === "image" && column >= 0;
    const note = measured ? `rmse ${data.table.rows[i - 1][1][column]}` : data.pictures[i].role;
    const caption = element("figcaption", "", [element("span", nameOf(i)), element("span", note)]);
    caption.title = data.pictures[i].name;
    const figure = element("figure", "", [stage, caption]);
    stage.addEventListener("pointerdown", () => pick("right", i));
    return figure;
  }));
}

function buildInsets() {
  at("insets").replaceChildren(...pictures.map((_, i) => {
    const parts = ["view", "name", "values"].map((name) => {
      const part = element("div", name === "name" ? nameOf(i) : "");
      part.className = name;
      return part;
    });
    const centre = element("div");
    centre.className = "centre";
    parts[0].append(element("canvas"), centre);
    const inset = element("div", "", parts);
    inset.className = "inset";
    inset.title = data.pictures[i].name;
    return inset;
  }));
}

function buildControls() {
  const range = at("exposure");
  range.min = Math.round(data.stops) - 12;
  range.max = Math.round(data.stops) + 12;
  range.addEventListener("input", () => expose(Number(range.value)));
  at("reset").addEventListener("click", () => expose(data.stops));
  at("show-slider").addEventListener("click", () => choose("slider", state.errors));
  at("show-grid").addEventListener("click", () => choose("grid", state.errors));
  at("show-light").addEventListener("click", () => choose(state.view, false));
  at("show-errors").addEventListener("click", () => choose(state.view, true));
  at("inset-size").addEventListener("change", (event) => {
    state.inset = Number(event.target.value);
    soon(drawInsets);
    soon(fit);
  });
  for (const side of ["left", "right"]) {
    at(side).replaceChildren(...pictures.map((_, i) => {
      const option = element("option", nameOf(i));
      option.value = i;
      return option;
    }));
    at(side).addEventListener("change", (event) => pick(side, Number(event.target.value)));
  }
  follow(at("wipe"), moveWipe);
  addEventListener("keydown", press);
  addEventListener("resize", () => soon(fit));
}

const STEPS = { ArrowLeft: -0.25, ArrowRight: 0.25, ArrowDown: -1, ArrowUp: 1 };

function press(event) {
  const busy = event.target.matches("select, input") && event.key.startsWith("Arrow");
  if (busy || event.ctrlKey || event.altKey || event.metaKey) return;
  const digit = /^(?:Digit|Numpad)(\d)$/.exec(event.code);
  const keys = {
    s: () => choose("slider", state.errors),
    g: () => choose("grid", state.errors),
    p: () => choose(state.view, false),
    e: () => choose(state.view, true),
    r: () => expose(data.stops),
  };
  const act = event.key in STEPS ? () => expose(state.stops + STEPS[event.key])
    : digit ? () => pick(event.shiftKey ? "left" : "right", Number(digit[1]))
      : keys[event.key.toLowerCase()];
  if (act === undefined) return;
  event.preventDefault();
  act();
}

// What is said

function sayFacts() {
  const images = data.pictures.filter(({ role }) => role === "image").length;
  const title = `${images === 1 ? names[1] : `${images} pictures`} against ${names[0]}`;
  at("title").textContent = title;
  document.title = `${title} – tamis compare`;
  const facts = [`${data.size.join("×")} pixels`, `ε = ${data.epsilon}`];
  const mask = data.mask === null ? "" : ` (mask ${data.mask})`;
  if (data.leftOut > 0) facts.push(`${data.leftOut} pixels not judged${mask}`);
  at("facts").textContent = facts.join(" · ");
}

function warnings(damaged) {
  const said = [];
  if (data.factor > 1) {
    said.push("The pictures are too large to be shown whole: each pixel here is the mean of "
      + `${data.factor}×${data.factor}. Error maps, insets and the histogram are those of the smaller pictures; the `
      + "measures are of all pixels.");
  }
  if (damaged.length > 0) {
    said.push("This browser changes the pixels that a page reads, perhaps against fingerprinting: "
      + `${damaged.join(", ")} cannot be shown as they are. The measures and settings below are right.`);
  }
  return said;
}

function tellMeasures() {
  fillTable(at("measures"), ["", ...data.table.head], data.table.rows.map(([file, cells]) => [file, ...cells]));
}

const shownValue = (value) => value === undefined ? "–" : typeof value === "string" ? value : JSON.stringify(value);

function tellSettings() {
  const spp = (found) => {
    if (found === null) return "none";
    const range = found.min === found.max ? "" : ` (${found.min} to ${found.max})`;
    return `${Number(found.mean.toFixed(2))}${range}`;
  };
  const preset = (found) => {
    if (found === null) return "none";
    if (found.changes.length === 0) return found.name;
    const list = found.changes.map(([key, value, usual]) =>
      element("li", `${key} = ${shownValue(value)} (${found.name}: ${shownValue(usual)})`));
    return element("div", `${found.name}, but for`, [element("ul", "", list)]);
  };
  const rows = data.pictures.map(({ name, found }) =>
    [name, found.software ?? "none", spp(found.spp), shownValue(found.seed ?? "none"), found.method ?? "none",
      preset(found.preset)]);
  const head = ["", "Program", "Samples per pixel", "Seed", "Method", "Nearest preset of this version"];
  fillTable(at("found"), head, rows);
  const known = data.pictures.filter(({ found }) => found.settings !== null);
  tellDifferences(known);
  at("all-settings").replaceChildren(...known.map(({ name, found }) => {
    const table = element("table");
    const settings = Object.entries(found.settings).map(([key, value]) => [key, shownValue(value)]);
    fillTable(table, ["Setting", "Value"], settings);
    return element("details", "", [element("summary", `All settings of ${name}`), table]);
  }));
}

function tellDifferences(known) {
  const keys = [...new Set(known.flatMap(({ found }) => Object.keys(found.settings)))];
  const row = (key) => known.map(({ found }) => shownValue(found.settings[key]));
  const different = keys.filter((key) => new Set(row(key)).size > 1);
  at("differences").hidden = different.length === 0;
  fillTable(at("different"), ["", ...known.map(({ name }) => name)], different.map((key) => [key, ...row(key)]));
}

async function begin() {
  sayFacts();
  tellMeasures();
  tellSettings();
  const damaged = await readPictures();
  at("warnings").replaceChildren(...warnings(damaged).map((text) => element("li", text)));
  const judged = pictures.slice(1).map(({ histogram }) => histogram);
  decades = commonDecades(judged);
  document.documentElement.style.setProperty("--aspect", width / height);
  document.documentElement.style.setProperty("--most", `${largest()}px`);
  buildControls();
  buildGrid();
  buildInsets();
  at("viewer").hidden = at("plots").hidden = false;
  at("state").hidden = true;
  drawHistogram(at("histogram"), judged);
  listLines(at("lines"), at("histogram"), names.slice(1), judged);
  moveWipe(0.5);
  pick("left", 0);
  pick("right", 1);
  expose(data.stops);
  choose("slider", false);
}

begin().catch((error) => { at("state").textContent = `The pictures cannot be shown: ${error.message}`; });
