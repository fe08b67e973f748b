// The page of a singularity map: the point pointed at, held in `at`, and the robot there in every mode of the map.

const {robot, layers, field, axes, loci} = content, task = content.space === "task";
const EPS = 2 ** -52, SINGULAR = 16 * EPS;
let chosen = layers.length - 1, held = false;
let at = start();

// The model, fivebar's own: bars r1 and r2 on two pivots, `span` from one to the other, and on them a robot of two legs.

function meet([x, y], r1, r2, branch) {
  const square = x * x + y * y, total = r1 + r2, difference = r1 - r2;
  const heron = (total * total - square) * (square - difference * difference);
  const open = heron < -32 * EPS * Math.max(r1, r2) ** 2 * square || !(square > (4 * EPS * total) ** 2);
  const moment = open ? NaN : Math.sqrt(Math.max(heron, 0)) * 0.5 * branch;
  const first = 0.5 * (square + total * difference), last = 0.5 * (square - total * difference);
  const a = 1 / square * (1 / r1), b = 1 / square * (1 / r2), distance = Math.sqrt(square);
  return {
    first: [(first * x - moment * y) * a, (first * y + moment * x) * a],
    last: [(last * x + moment * y) * b, (last * y - moment * x) * b],
    sine: moment * (1 / (r1 * r2)),
    gap: Math.max(distance - total, Math.abs(difference) - distance),
  };
}

const cross = (u, v) => u[0] * v[1] - u[1] * v[0], dot = (u, v) => u[0] * v[0] + u[1] * v[1];
const minusSign = x => x > SINGULAR ? -1 : x < -SINGULAR ? 1 : 0;
const along = ([x, y, length], [cosine, sine]) => [x + length * cosine, y + length * sine];

function igm(xi, working) {
  const dyads = robot.drives.map(([x, y, length], k) => meet([xi[0] - x, xi[1] - y], length, robot.distal[k], working[k]));
  const distal = dyads.map(dyad => dyad.last);
  return pose(xi, dyads.map(dyad => Math.atan2(dyad.first[1], dyad.first[0])), dyads.map(dyad => dyad.first), distal,
    dyads.map(dyad => -dyad.sine), cross(...distal), Math.max(...dyads.map(dyad => dyad.gap)));
}

function dgm(q, assembly) {
  const direction = q.map(angle => [Math.cos(angle), Math.sin(angle)]);
  const [p1, p2] = robot.drives.map((drive, k) => along(drive, direction[k]));
  const dyad = meet([p2[0] - p1[0], p2[1] - p1[1]], ...robot.distal, -assembly);
  const distal = [dyad.first, dyad.last.map(x => -x)];
  const xi = [p1[0] + robot.distal[0] * dyad.first[0], p1[1] + robot.distal[0] * dyad.first[1]];
  return pose(xi, q, direction, distal, direction.map((u, k) => cross(u, distal[k])), dyad.sine, dyad.gap);
}

function pose(xi, q, direction, distal, serial, parallel, gap) {
  const elbows = robot.drives.map((drive, k) => along(drive, direction[k]));
  return {
    xi, q, elbows, serial, parallel, gap, working: serial.map(minusSign), assembly: minusSign(parallel),
    transmission: Math.atan2(Math.abs(parallel), Math.abs(dot(...distal))), closes: Number.isFinite(parallel + xi[0] + serial[0]),
  };
}

const poseIn = layer => task ? igm(at, layers[layer].mode) : dgm(at, layers[layer].mode[0]);

// Where the page begins: the middle one of the nodes that close in the last mode.
function start() {
  const {values} = layers[chosen], nx = content.x.length;
  const good = Array.from(values.keys()).filter(node => Number.isFinite(values[node]));
  const node = good[good.length >> 1] ?? 0;
  return [content.x[node % nx], content.y[Math.floor(node / nx)]];
}

const signs = mode => mode.map(sign => sign > 0 ? "+1" : sign < 0 ? "−1" : "0").join(", ");
const kindOfMode = task ? "working modes" : "assembly mode";

// The picture -----------------------------------------------------------------------------------------------------

const frame = document.getElementById("picture");
const discs = robot.drives.map(([x, y, length], k) => [x, y, length + robot.distal[k]]), lengths = robot.drives.map(drive => drive[2]);
const most = (low, high) => [Math.max(...discs.map(low)), Math.min(...discs.map(high))];  // what both legs reach
const elbowsReach = k => robot.drives.flatMap((drive, leg) => [drive[k] - lengths[leg], drive[k] + lengths[leg]]);
const scene = new Picture(frame, around([[...most(([x, , r]) => x - r, ([x, , r]) => x + r), ...elbowsReach(0)]],
  [[...most(([, y, r]) => y - r, ([, y, r]) => y + r), ...elbowsReach(1)]]));
const machine = opacity => scene.mechanism({
  bars: [[0, 1, "--c0"], [1, 2, "--c0"], [4, 3, "--c1"], [3, 2, "--c1"]], pins: opacity < 1 ? [] : [0, 1, 2, 3, 4],
  grounded: [0, 4], actuated: opacity < 1 ? [] : [0, 4], traced: 2, opacity,
});
const ghosts = layers.map(() => machine(0.22)), mechanism = machine(1);
const state = element("span", {class: "state"});
frame.append(element("div", {class: "under"}, state));
frame.append(element("ul", {class: "legend", "aria-label": "colours of the picture"}, ...[["left leg", "--c0"], ["right leg", "--c1"]].map(
  ([text, ink]) => element("li", {}, element("span", {class: "entry"}, swatch(ink, 6, []), text))),
  element("li", {}, element("span", {class: "entry"}, "pale: the other modes"))));

// The map ---------------------------------------------------------------------------------------------------------

const [[nameX, unitX, scaleX], [nameY, unitY, scaleY]] = axes;
const scaled = [content.x.map(x => scaleX * x), content.y.map(y => scaleY * y)];
const spans = scaled.map(values => {
  const half = (values[values.length - 1] - values[0]) / (values.length - 1) / 2;  // nodes are the middles of pixels
  return [values[0] - half, values[values.length - 1] + half];
});
const heading = element("h2"), legend = element("ul", {class: "legend", "aria-label": "singularity loci"});
const parent = element("figure", {class: "map"}, element("figcaption", {}, heading, legend));
const plotSection = document.getElementById("plots");
plotSection.append(parent);
const ranges = {x: new Range(spans[0]), y: new Range(spans[1])};
const plot = new Plot(parent, {
  height: innerWidth > 820 ? 520 : 340, min_border_left: 62, x_axis_label: `${nameX} (${unitX})`, y_axis_label: `${nameY} (${unitY})`,
  background_fill_color: "#ececec",
}, ranges);
const crossbar = element("div", {class: "cross"});
plot.glass.append(crossbar);

const mapper = new Bokeh[field.logarithmic ? "LogColorMapper" : "LinearColorMapper"]({
  palette: palette(field.palette), low: field.limits[0], high: field.limits[1], nan_color: "rgba(0, 0, 0, 0)"});
const {ndarray} = Bokeh.require("core/util/ndarray");
const images = layers.map(layer => ndarray(layer.values.map(value => value === Infinity ? 1e12 : field.factor * value),
  {dtype: "float32", shape: [content.y.length, content.x.length]}));
const image = plot.figure.image({image: {field: "image"}, x: spans[0][0], y: spans[1][0], dw: spans[0][1] - spans[0][0],
  dh: spans[1][1] - spans[1][0], color_mapper: mapper, source: new Bokeh.ColumnDataSource({data: {image: [images[chosen]]}})});
const bar = new Bokeh.ColorBar({color_mapper: mapper, width: 14, padding: 4, background_fill_color: null, bar_line_color: null});
plot.figure.add_layout(bar, "right");

// Lines differ by their dashes, points by their shapes; drawn dark on the map's own pale ground in either theme.
const INK = "#1a1a1a";
const STYLES = {
  "Type 1: a leg in line": {}, "Type 2: distal bars stretched": {line_dash: [7, 3]},
  "Type 2: distal bars folded": {line_dash: [8, 3, 2, 3]}, "Type 2: elbows coincide, self-motion": {line_dash: [2, 2]},
  "Type 3": {marker: "diamond"}, "Type 1 in a point: a leg folded on its base": {marker: "x"},
  "Type 2 in a point: elbows coincide, self-motion": {marker: "cross"},
};
const drawn = Object.entries(STYLES).filter(([kind]) => loci.some(locus => locus.kind === kind)).map(([kind, style]) => {
  const source = new Bokeh.ColumnDataSource({data: {x: [], y: []}}), place = {x: {field: "x"}, y: {field: "y"}, source};
  const renderer = style.marker
    ? plot.figure.scatter({...place, size: 8, fill_color: "#ffffff", line_color: INK, ...style})
    : plot.figure.line({...place, line_color: INK, line_width: 1.6, ...style});
  legend.append(element("li", {}, element("span", {class: "entry"},
    style.marker ? element("span", {"aria-hidden": "true"}, {diamond: "◇", x: "×", cross: "+"}[style.marker]) : swatch("--ink", 2, style.line_dash ?? []),
    kind)));
  return {kind, source, renderer};
});

function palette(name) {
  const {PuOr11, Cividis256} = Bokeh.Palettes;
  const mixed = (colours, low, high) => Array.from({length: 257}, (_, k) => {
    const place = (low + (high - low) * k / 256) * (colours.length - 1), first = Math.min(Math.floor(place), colours.length - 2);
    const part = shift => [16, 8, 0].map(bits => colours[first + shift] >>> bits + 8 & 255);
    return "#" + part(0).map((a, c) => Math.round(a + (place - first) * (part(1)[c] - a)).toString(16).padStart(2, "0")).join("");
  });
  if (name === "diverging") return mixed(PuOr11, 0.14, 0.86).reverse();
  const rising = mixed(Cividis256, 0.35, 1);
  return name === "rising" ? rising : rising.reverse();
}

function choose(layer) {
  chosen = layer;
  heading.replaceChildren(field.words, element("small", {}, `, ${kindOfMode} ${signs(layers[layer].mode)}`));
  image.data_source.data = {image: [images[layer]]};
  for (const {kind, source} of drawn) {
    const xs = [], ys = [];
    for (const locus of loci)
      if (locus.kind === kind && locus.layers.includes(layer)) {
        xs.push(...locus.points[0].map(x => scaleX * x), NaN);
        ys.push(...locus.points[1].map(y => scaleY * y), NaN);
      }
    source.data = {x: xs, y: ys};
  }
  draw();
}

plot.title = field.words;
plot.legend = () => drawn.map(({kind}) => ({text: kind, colour: INK, dash: STYLES[kind].line_dash ?? []}));
plot.element.setAttribute("aria-label", `map of ${field.words} over ${nameX} and ${nameY}; the point is moved by the arrow keys`);

// In the plane a metre is as long across as up: the ranges grow on the side where there is room.
function shape() {
  if (!task) return;
  const {width, height} = plot.view.frame.bbox;
  if (!width) return;
  const perPixel = Math.max((ranges.x.end - ranges.x.start) / width, (ranges.y.end - ranges.y.start) / height);
  for (const [range, pixels] of [[ranges.x, width], [ranges.y, height]]) {
    const middle = (range.start + range.end) / 2;
    range.set(middle - perPixel * pixels / 2, middle + perPixel * pixels / 2);
  }
}

function zoom(factor, about = [scaleX * at[0], scaleY * at[1]]) {
  [ranges.x, ranges.y].forEach((range, k) => {
    if (!factor) return range.set(...spans[k]);
    const low = about[k] + (range.start - about[k]) * factor, high = about[k] + (range.end - about[k]) * factor;
    const whole = spans[k][1] - spans[k][0];
    if (high - low < 1e-6 * whole) return;
    range.set(...(high - low > (task ? 1.5 : 0.999) * whole && factor > 1 ? spans[k] : [low, high]));
  });
  shape();
  draw();
}

// The controls ----------------------------------------------------------------------------------------------------

const rows = layers.map((layer, k) => {
  const radio = element("input", {type: "radio", name: "mode", id: `mode${k}`, onchange: () => choose(k)});
  const cells = Array.from({length: 7}, () => element("td"));
  const row = element("tr", {}, element("td", {}, radio, element("label", {for: `mode${k}`}, ` ${signs(layer.mode)}`)), ...cells);
  return {radio, cells, row};
});
const titles = task
  ? ["working", "assembly", "q11 (deg)", "q21 (deg)", "sin q12", "sin q22", "sin(φ2 − φ1)", "transm. (deg)"]
  : ["assembly", "working", "x (mm)", "y (mm)", "sin q12", "sin q22", "sin(φ2 − φ1)", "transm. (deg)"];
plotSection.append(element("div", {class: "scroll", tabindex: 0, role: "region", "aria-label": "the robot at this point in each mode"}, element("table", {},
  element("thead", {}, element("tr", {}, ...titles.map(title => element("th", {scope: "col"}, title)))),
  element("tbody", {}, ...rows.map(({row}) => row)))));
const fields = axes.map(([name, unit], k) => element("input", {type: "number", step: "any", "aria-label": `${name} (${unit})`, style: "width: 7.5em",
  onchange: event => { const value = +event.target.value / axes[k][2]; go(k === 0 ? [value, at[1]] : [at[0], value]); }}));
const hold = element("button", {type: "button", "aria-pressed": "false", onclick: () => keep(!held)}, "Hold");
document.getElementById("controls").append(
  ...fields.flatMap((input, k) => [element("span", {"aria-hidden": "true"}, `${axes[k][0]} (${axes[k][1]})`), input]), hold,
  button("−", "zoom out", () => zoom(2)), button("+", "zoom in", () => zoom(0.5)), button("All", "show all", () => zoom(0)),
  button("PNG", "save this page as a picture (PNG)", () => savePng(scene.svg, [plot])),
  button("CSV", `save the nodes of this page as CSV; ${content.source} writes all`, table),
  element("details", {}, element("summary", {}, "Keys and pointer"),
    "Point at the map, or drag: the robot is shown in that pose, in the chosen mode, pale in the others. A click holds the pose, another " +
    "one lets it go. Arrow keys move the point (with Shift finely), 1 2 3 4 choose the mode, H holds, + − 0 zoom. Ctrl and wheel zooms at the pointer."));

function keep(now) {
  held = now;
  hold.setAttribute("aria-pressed", held);
  hold.textContent = held ? "Let go" : "Hold";
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

addEventListener("keydown", event => {
  const {key, target} = event;
  if (event.ctrlKey || event.metaKey || event.altKey || target.type === "number") return;
  const step = (event.shiftKey ? 1 / 2000 : 1 / 100) * (ranges.x.end - ranges.x.start);
  const move = (dx, dy) => { keep(true); go([at[0] + dx * step / scaleX, at[1] + dy * step / scaleY]); };
  const pick = layer => { if (layer < layers.length) choose(layer); };
  const actions = {
    ArrowRight: () => move(1, 0), ArrowLeft: () => move(-1, 0), ArrowUp: () => move(0, 1), ArrowDown: () => move(0, -1),
    1: () => pick(0), 2: () => pick(1), 3: () => pick(2), 4: () => pick(3), h: () => keep(!held), Escape: () => keep(false),
    "+": () => zoom(0.5), "=": () => zoom(0.5), "-": () => zoom(2), 0: () => zoom(0),
  };
  if (!(key in actions) || (target.type === "radio" && key.startsWith("Arrow"))) return;
  actions[key]();
  event.preventDefault();
});

// What is seen ----------------------------------------------------------------------------------------------------

const nodeAt = layer => layers[layer].values[nearest(content.y, at[1]) * content.x.length + nearest(content.x, at[0])];

const draw = oncePerFrame(() => {
  if (!plot.view) return;
  const degrees = 180 / Math.PI, poses = layers.map((_, k) => poseIn(k)), own = poses[chosen];
  const joints = ({xi, elbows}) => {
    const [left, right] = robot.drives.map(([x, y]) => [x, y]);
    return [left, elbows[0], xi, elbows[1], right];
  };
  poses.forEach((each, k) => scene.place(ghosts[k], k === chosen ? [[NaN, NaN]] : joints(each)));
  scene.place(mechanism, joints(own));
  poses.forEach((each, k) => {
    const {cells, row, radio} = rows[k], modes = task ? [each.assembly] : each.working;
    const lead = task ? each.q.map(angle => degrees * angle) : each.xi.map(x => 1e3 * x);
    const values = each.closes ? [...lead, ...each.serial, each.parallel, degrees * each.transmission].map(readable) : Array(6).fill("–");
    [each.closes ? signs(modes) : "–", ...values].forEach((text, c) => { cells[c].textContent = text; });
    row.className = k === chosen ? "chosen" : "";
    radio.checked = k === chosen;
  });
  const [x, y] = plot.pixels(scaleX * at[0], scaleY * at[1]);
  plot.cursor.style.transform = `translateX(${x}px)`;
  crossbar.style.transform = `translateY(${y}px)`;
  fields.forEach((input, k) => { if (document.activeElement !== input) input.value = +(axes[k][2] * at[k]).toPrecision(7); });
  state.textContent = own.closes ? `${kindOfMode} ${signs(layers[chosen].mode)}; ${field.name} at the nearest node: ${readable(field.factor * nodeAt(chosen))}`
    : `out of reach in ${kindOfMode} ${signs(layers[chosen].mode)}: the bars do not meet by ${readable(1e3 * own.gap)} mm`;
  announce(() => `${nameX} ${readable(scaleX * at[0])} ${unitX}, ${nameY} ${readable(scaleY * at[1])} ${unitY}. ${state.textContent}. ` +
    titles.slice(1).map((title, c) => `${title} ${rows[chosen].cells[c].textContent}`).join(", "));
});

function table() {
  const lines = [];
  content.y.forEach((y, j) => content.x.forEach((x, i) => {
    const values = layers.map(layer => layer.values[j * content.x.length + i]);
    if (!values.every(Number.isNaN)) lines.push([x, y, ...values].map(value => String(value).replace("NaN", "nan").replace("Infinity", "inf")));
  }));
  saveCsv(`fivebar page: ${content.title}; SI units; the nodes held by the page, values to 7 digits, ${content.source} writes all`,
    [content.columns.map(cell), ...lines]);
}

function paint() {
  scene.paint();
  plot.paint();
  for (const grid of [...plot.figure.xgrids, ...plot.figure.ygrids]) grid.grid_line_color = "#dcdcdc";
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
