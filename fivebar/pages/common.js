"use strict";
// What every page needs: its content, elements, colours by theme, numbers as text, files to save.

const content = JSON.parse(document.getElementById("content").textContent, (key, value) =>
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

const DASHES = [[], [8, 4], [2, 3], [10, 3, 2, 3], [14, 5], [5, 5]];
const dash = k => DASHES[k % DASHES.length];
const colour = k => theme("--c" + k);
const theme = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const dark = matchMedia("(prefers-color-scheme: dark)");

function readable(value) {
  if (!Number.isFinite(value)) return Number.isNaN(value) || value === undefined ? "none" : value > 0 ? "∞" : "−∞";
  const size = Math.abs(value);
  const text = size !== 0 && (size < 1e-3 || size >= 1e6) ? value.toExponential(3) : String(+value.toPrecision(5));
  return text.replaceAll("-", "−");
}

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

// [least, largest] of the finite ones of those numbers.
function extent(arrays, first = 0, last = Infinity) {
  let low = Infinity, high = -Infinity;
  for (const values of arrays)
    for (let k = first; k <= last && k < values.length; k++)
      if (Number.isFinite(values[k])) {
        low = Math.min(low, values[k]);
        high = Math.max(high, values[k]);
      }
  return low <= high ? [low, high] : [0, 1];
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

let waiting;
function announce(text) {  // once the state has come to rest, or a screen reader would never end
  clearTimeout(waiting);
  waiting = setTimeout(() => { document.getElementById("status").textContent = text(); }, 400);
}

function save(blob, ending) {
  const name = document.title.normalize("NFKD").replace(/[^\w]+/g, "-").replace(/^-+|-+$/g, "").slice(0, 60);
  const link = element("a", {href: URL.createObjectURL(blob), download: (name || "fivebar") + ending});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

const cell = text => /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
const saveCsv = (first, rows) =>
  save(new Blob([`# ${first.replace(/\s+/g, " ")}\n`, ...rows.map(row => row.join(",") + "\n")], {type: "text/csv"}), ".csv");

function button(text, label, action) {
  return element("button", {type: "button", title: label, "aria-label": label, onclick: action}, text);
}

function swatch(ink, width, dashes) {
  return element("svg", {width: 30, height: 10, "aria-hidden": "true"},
    element("line", {x1: 1, x2: 29, y1: 5, y2: 5, "stroke-width": width, "stroke-dasharray": dashes.join(" "),
      style: `stroke: var(${ink})`}));
}

// The page as one picture: the scene, then each plot with its title and legend; on the page's own paper.
async function savePng(scene, plots) {
  const width = 1100, scale = 2, gap = 14, shown = plots.map(plot => plot.picture());
  const box = scene.getBoundingClientRect(), side = 480, high = side * box.height / box.width;
  const heights = shown.map(plot => 40 + plot.canvas.height / plot.canvas.width * (width - side - 3 * gap));
  const canvas = element("canvas");
  canvas.width = scale * width;
  canvas.height = scale * (50 + gap + Math.max(high, heights.reduce((sum, height) => sum + height + gap, 0)));
  const pen = canvas.getContext("2d");
  pen.scale(scale, scale);
  pen.fillStyle = theme("--paper");
  pen.fillRect(0, 0, width, canvas.height);
  pen.fillStyle = theme("--ink");
  pen.font = "600 18px system-ui, sans-serif";
  pen.fillText(document.title, gap, 30, width - 2 * gap);
  const image = new Image(), copy = scene.cloneNode(true);
  copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  copy.setAttribute("width", box.width);
  copy.setAttribute("height", box.height);
  image.src = "data:image/svg+xml;charset=utf-8," + encodeURIComponent(new XMLSerializer().serializeToString(copy));
  await image.decode();
  pen.drawImage(image, gap, 50, side, high);
  let y = 50;
  shown.forEach((plot, k) => {
    const left = side + 2 * gap;
    pen.font = "600 14px system-ui, sans-serif";
    pen.fillStyle = theme("--ink");
    pen.fillText(plot.title, left, y + 12, width - left - gap);
    pen.font = "13px system-ui, sans-serif";
    let x = left;
    for (const entry of plot.legend) {
      pen.strokeStyle = entry.colour;
      pen.lineWidth = 2;
      pen.setLineDash(entry.dash);
      pen.beginPath();
      pen.moveTo(x, y + 28);
      pen.lineTo(x + 28, y + 28);
      pen.stroke();
      pen.fillStyle = theme("--ink");
      pen.fillText(entry.text, x + 33, y + 32, 240);
      x += 33 + Math.min(240, pen.measureText(entry.text).width) + 16;
    }
    pen.setLineDash([]);
    pen.drawImage(plot.canvas, left, y + 40, width - left - gap, heights[k] - 40);
    y += heights[k] + gap;
  });
  save(await new Promise(done => canvas.toBlob(done, "image/png")), ".png");
}

function readNotes() {
  document.getElementById("notes").append(...content.notes.map(note => element("li", {}, note)));
}
