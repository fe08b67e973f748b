// The controls and keys of a map's page, and what is drawn and said of the point at hand.

const rows = layers.map((layer, k) => {
  const radio = element("input", {type: "radio", name: "mode", id: `mode${k}`, onchange: () => choose(k)});
  const cells = Array.from({length: 7}, () => element("td"));
  const label = element("label", {for: `mode${k}`}, ` ${signs(layer.mode)}`);
  const row = element("tr", {}, element("td", {}, radio, label), ...cells);
  return {radio, cells, row};
});
const [unitQ, scaleQ] = robot.turns ? ["deg", 180 / Math.PI] : ["mm", 1e3];
const titles = [...(task ? ["working modes", "assembly mode", ...robot.joints.map(name => `${name} (${unitQ})`)]
  : ["assembly mode", "working modes", "x (mm)", "y (mm)"]), ...robot.sines, "sin(φ2 − φ1)",
  "transmission angle (deg)"];
const head = element("thead", {}, element("tr", {}, ...titles.map(title => element("th", {scope: "col"}, title))));
const scroll = {id: "table", class: "scroll", tabindex: 0, role: "region", "aria-label": "the robot at this point in each mode"};
document.querySelector("main").append(element("div", scroll,
  element("table", {}, head, element("tbody", {}, ...rows.map(({row}) => row)))));
const fields = axes.map(([name, unit, scale], k) => {
  const input = element("input", {type: "number", step: "any", "aria-label": `${name} (${unit})`});
  input.onchange = () => go(at.map((x, own) => own === k ? +input.value / scale : x));
  return input;
});
const largest = scaled.map(values => Math.max(...extent([values]).map(Math.abs)));
const place = k => settled(axes[k][2] * at[k], largest[k]);
const hold = element("button", {type: "button", "aria-pressed": "false", onclick: () => keep(!held)}, "Keep this point");
byId("controls").append(
  ...fields.flatMap(input => [element("span", {"aria-hidden": "true"}, input.getAttribute("aria-label")), input]), hold,
  button("−", "zoom out", () => zoom(2)), button("+", "zoom in", () => zoom(0.5)),
  button("All", "show all", () => zoom(0)),
  button("PNG", "save this page as a picture (PNG)", () => savePng([scene.svg], state.textContent, [plot])),
  button("CSV", `save the nodes of this page as CSV; ${content.source} writes all`, table),
  element("details", {}, element("summary", {}, "More"),
    "Point at the map, or drag: the robot is shown in that pose, in the chosen mode, pale in the others. A click " +
    "keeps the point, another one follows the pointer again. Arrow keys move the point (with Shift finely), 1 2 3 4 " +
    "choose the mode, H keeps the point, + − 0 zoom. Ctrl and wheel zooms at the pointer." + (robot.turns
      ? " Working mode +1: the elbow is on the left of the line from its motor to the end-effector, and the sine is " +
        "negative. −1: on the right, and the sine is positive." : "")));

function keep(now) {
  held = now;
  hold.setAttribute("aria-pressed", held);
  hold.textContent = held ? "Follow the pointer" : "Keep this point";
}

const inside = (x, k) => Math.min(Math.max(x, spans[k][0] / axes[k][2]), spans[k][1] / axes[k][2]);

function go(point) {
  if (!point.every(Number.isFinite)) return draw();
  at = point.map(inside);
  draw();
}

function listen() {
  const {glass} = plot, point = event => { const [x, y] = plot.at(event); go([x / scaleX, y / scaleY]); };
  glass.addEventListener("pointermove", event => { if (!held || event.buttons) point(event); });
  glass.addEventListener("pointerdown", event => { glass.setPointerCapture(event.pointerId); point(event); });
  glass.addEventListener("click", () => keep(!held));
  glass.addEventListener("wheel", event => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    zoom(event.deltaY < 0 ? 0.8 : 1.25, plot.at(event));
  }, {passive: false});
}

onKeys(({shiftKey, target}) => {
  const step = (shiftKey ? 1 / 2000 : 1 / 100) * (ranges.x.end - ranges.x.start);
  const move = (dx, dy) => { keep(true); go([at[0] + dx * step / scaleX, at[1] + dy * step / scaleY]); };
  const pick = layer => { if (layer < layers.length) choose(layer); };
  return {
    ...(target.type === "radio" ? {} : {ArrowRight: () => move(1, 0), ArrowLeft: () => move(-1, 0),
      ArrowUp: () => move(0, 1), ArrowDown: () => move(0, -1)}),
    1: () => pick(0), 2: () => pick(1), 3: () => pick(2), 4: () => pick(3), h: () => keep(!held),
    Escape: () => keep(false),
    "+": () => zoom(0.5), "=": () => zoom(0.5), "-": () => zoom(2), 0: () => zoom(0),
  };
});

// What is seen ----------------------------------------------------------------------------------------------------

const nodeAt = layer => layers[layer].values[nearest(content.y, at[1]) * content.x.length + nearest(content.x, at[0])];

const draw = oncePerFrame(() => {
  if (!plot.view) return;
  const poses = layers.map((_, k) => poseIn(k)), own = poses[chosen];
  poses.forEach((each, k) => scene.place(ghosts[k], k === chosen ? [[NaN, NaN]] : joints(each)));
  scene.place(mechanism, joints(own));
  poses.forEach((each, k) => {
    const {cells, row, radio} = rows[k], modes = task ? [each.assembly] : each.working;
    const lead = task ? each.q.map(q => scaleQ * q) : each.xi.map(x => 1e3 * x);
    const measures = [...lead, 180 / Math.PI * each.transmission].map(value => readable(value, 100));
    const sines = [...each.serial, each.parallel].map(value => readable(value, 1));
    [signs(modes), ...measures.slice(0, -1), ...sines, measures.at(-1)].forEach((text, c) => { cells[c].textContent = each.closes ? text : "–"; });
    row.className = k === chosen ? "chosen" : "";
    radio.checked = k === chosen;
  });
  const [x, y] = plot.pixels(scaleX * at[0], scaleY * at[1]);
  plot.cursor.style.transform = `translateX(${x}px)`;
  crossbar.style.transform = `translateY(${y}px)`;
  fields.forEach((input, k) => {
    if (document.activeElement !== input) input.value = +place(k).toPrecision(5);
  });
  const mode = `${kindOfMode} ${signs(layers[chosen].mode)}`;
  state.textContent = own.closes
    ? `${mode}; ${field.words.split(",")[0]} at the nearest node: ${readable(settled(field.factor * nodeAt(chosen), field.limits[1]))}`
    : `out of reach in ${mode}: a gap of ${readable(1e3 * own.gap)} mm is left between the bars`;
  const point = axes.map(([name, unit], k) => `${name} ${readable(place(k))} ${unit}`).join(", ");
  announce(() => `${point}. ${state.textContent}. ` +
    titles.slice(1).map((title, c) => `${title} ${rows[chosen].cells[c].textContent}`).join(", "));
});

function table() {
  const lines = [];
  content.y.forEach((y, j) => content.x.forEach((x, i) => {
    const values = layers.map(layer => layer.values[j * content.x.length + i]);
    if (!values.every(Number.isNaN)) lines.push([x, y, ...values]);
  }));
  saveCsv(`fivebar page: ${content.title}; SI units; the nodes held by the page, values to 7 digits, ` +
    `${content.source} writes all`, [content.columns, ...lines]);
}

function paint() {
  scene.paint();
  plot.paint();
  plot.figure.background_fill_color = theme("--ground");
  for (const grid of [...plot.figure.xgrids, ...plot.figure.ygrids]) grid.grid_line_color = theme("--ground-grid");
  bar.setv({major_label_text_color: theme("--ink"), major_tick_line_color: INK});
}

async function begin() {
  readNotes();
  paint();
  dark.addEventListener("change", paint);
  await plot.show(oncePerFrame(() => { plot.layGlass(); shape(); draw(); }));
  listen();
  plot.layGlass();
  shape();
  choose(chosen);
  requestAnimationFrame(() => requestAnimationFrame(() => { document.body.dataset.ready = "yes"; }));
}
begin();
