"use strict";
// What every page needs: its content, elements, colours by theme, keys, files to save.

const byId = id => document.getElementById(id);
const content = JSON.parse(byId("content").textContent, (key, value) =>
  typeof value?.f8 === "string" ? numbers(value.f8, Float64Array) :
  typeof value?.f4 === "string" ? numbers(value.f4, Float32Array) : value);

function numbers(base64, Kind) {
  const text = atob(base64), bytes = new Uint8Array(text.length);
  for (let k = 0; k < bytes.length; k++) bytes[k] = text.charCodeAt(k);
  return new Kind(bytes.buffer);
}

// Text goes in as text nodes only, so that no name is ever read as HTML.
function element(tag, attributes = {}, ...children) {
  const svg = ["svg", "g", "line", "path", "text", "circle"].includes(tag);
  const made = svg ? document.createElementNS("http://www.w3.org/2000/svg", tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes))
    name.startsWith("on") ? made.addEventListener(name.slice(2), value) : made.setAttribute(name, value);
  made.append(...children);
  return made;
}

const theme = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const dark = matchMedia("(prefers-color-scheme: dark)");

// Index of the value nearest to x in an increasing or decreasing array.
function nearest(values, x) {
  const sign = values[0] <= values[values.length - 1] ? 1 : -1;
  let low = 0, high = values.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (sign * values[middle] <= sign * x) low = middle; else high = middle;
  }
  return Math.abs(x - values[low]) <= Math.abs(values[high] - x) ? low : high;
}

// At most one drawing per frame, however many events there are.
function oncePerFrame(draw) {
  let asked = false;
  return () => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; draw(); });
  };
}

// actions(event): what each key does. What a field or a button needs itself is left to it.
function onKeys(actions) {
  addEventListener("keydown", event => {
    const {key, target} = event, tag = target.tagName;
    if (event.ctrlKey || event.metaKey || event.altKey || tag === "SELECT" || target.type === "number") return;
    if (key === " " && ["BUTTON", "SUMMARY"].includes(tag)) return;
    const action = actions(event)[key.length === 1 ? key.toLowerCase() : key];
    if (action && action() !== false) event.preventDefault();
  });
}

// On paper all is as in the light, and so painted once more.
function paintForPaper() {
  for (const event of ["beforeprint", "afterprint"])
    addEventListener(event, () => {
      document.documentElement.classList.toggle("printed", event === "beforeprint");
      dark.dispatchEvent(new Event("change"));
    });
}

let waiting;
function announce(text) {  // once the state has come to rest, or a screen reader would never end
  clearTimeout(waiting);
  waiting = setTimeout(() => { byId("status").textContent = text(); }, 400);
}

function save(blob, ending) {
  const name = document.title.normalize("NFKD").replace(/[^\w]+/g, "-").replace(/^-+|-+$/g, "").slice(0, 60);
  const link = element("a", {href: URL.createObjectURL(blob), download: (name || "fivebar") + ending});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

function saveCanvas(canvas) {
  canvas.toBlob(blob => save(blob, ".png"), "image/png");
}

// Numbers as Python reads them, with all digits; text in quotes where it needs them.
function cell(value) {
  const text = String(value).replace(/^NaN$/, "nan").replace(/^(-?)Infinity$/, "$1inf");
  return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

function saveCsv(first, rows) {
  const lines = [`# ${first.replace(/\s+/g, " ")}`, ...rows.map(row => Array.from(row, cell).join(","))];
  save(new Blob(lines.map(line => line + "\n"), {type: "text/csv"}), ".csv");
}

function button(text, label, action) {
  return element("button", {type: "button", title: label, "aria-label": label, onclick: action}, text);
}

function speedChoice(factors, label, chosen = 1) {
  return element("select", {"aria-label": label}, ...factors.map(factor =>
    element("option", {value: factor, ...(factor === chosen ? {selected: ""} : {})}, `${factor} ×`)));
}

// The bar of a picture's scale: of at most this length, m, the largest of 1, 2, 5 times a power of ten, and its text.
function scaleBar(most) {
  const power = Math.floor(Math.log10(most)), factor = [5, 2, 1].find(each => each * 10 ** power <= most * (1 + 1e-9));
  const [unit, size] = power >= 0 ? ["m", 0] : power >= -3 ? ["mm", -3] : power >= -6 ? ["µm", -6] : ["nm", -9];
  return {length: factor * 10 ** power, text: `${+(factor * 10 ** (power - size)).toPrecision(1)} ${unit}`};
}

// A line of one colour, or of several one after the other; each a name of the theme, or a colour.
function swatch(inks, width, dashes = []) {
  return element("svg", {width: 30, height: 10, "aria-hidden": "true"}, ...[inks].flat().map((ink, k, {length}) =>
    element("line", {x1: 1 + 28 * k / length, x2: 1 + 28 * (k + 1) / length, y1: 5, y2: 5, "stroke-width": width,
      "stroke-dasharray": dashes.join(" "), style: `stroke: ${ink.startsWith("#") ? ink : `var(${ink})`}`})));
}

// A line of a legend: its sign, its text.
const entry = (...parts) => element("li", {}, element("span", {class: "entry"}, ...parts));
