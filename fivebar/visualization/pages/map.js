// The page of a singularity map: the point pointed at, held in `at`, and the robot there in every mode of the map.

const {layers, field, axes, loci, robot} = content, task = content.space === "task";
let chosen = layers.length - 1, held = false;
let at = start();

const poseIn = layer => task ? igm(jointIn(layer), layers[layer].mode) : dgm(at, layers[layer].mode[0]);

// Where joint C is with the tool at the point: the tool closes a dyad of its own on its leg, as in MountedTool.joint.
function jointIn(layer) {
  if (!robot.tool) return at;
  const {leg, reach, factor: [re, im], branches} = robot.tool, [baseX, baseY, length] = robot.drives[leg];
  const x = at[0] - baseX, y = at[1] - baseY, square = x * x + y * y;
  const along = (1 + (length * length - reach * reach) / square) / 2;
  const across = branches[layer] * Math.sqrt(length * length / square - along * along);  // NaN out of reach
  const barX = x - (along * x - across * y), barY = y - (along * y + across * x);
  const jointX = x + re * barX - im * barY, jointY = y + re * barY + im * barX;
  const distalX = barX + re * barX - im * barY, distalY = barY + re * barY + im * barX;
  const folded = layers[layer].mode[leg] * (jointX * distalY - jointY * distalX) >= 0;
  return folded ? [NaN, NaN] : [baseX + jointX, baseY + jointY];
}

// Where the page begins: a node that closes in the last mode.
function start() {
  const {values} = layers[chosen], nx = content.x.length;
  const good = Array.from(values.keys()).filter(node => !Number.isNaN(values[node]));
  const node = good[Math.floor(0.7 * good.length)] ?? 0;
  return [content.x[node % nx], content.y[Math.floor(node / nx)]];
}

const signs = mode => mode.map(sign => sign > 0 ? "+1" : sign < 0 ? "−1" : "0").join(", ");
const kindOfMode = task ? "working modes" : "assembly mode";

// The picture -----------------------------------------------------------------------------------------------------

const frame = byId("picture");
const discs = robot.drives.map(([x, y, length], k) => [x, y, length + robot.distal[k]]);
const most = (low, high) => [Math.max(...discs.map(low)), Math.min(...discs.map(high))];  // what both legs reach
const elbowsReach = k => robot.drives.flatMap(drive => [drive[k] - drive[2], drive[k] + drive[2]]);
const feet = robot.drives.map(([x]) => x);
const bounds = robot.turns
  ? around([[...most(([x, , r]) => x - r, ([x, , r]) => x + r), ...elbowsReach(0)]],
    [[...most(([, y, r]) => y - r, ([, y, r]) => y + r), ...elbowsReach(1)]])
  : around([feet.flatMap((x, k) => [x - robot.distal[k], x + robot.distal[k]])], [robot.rail]);
const scene = new Picture(byId("scenes"), bounds, "the robot at the point");
if (!robot.turns) for (const x of feet) scene.path([x, x], robot.rail, "--line", 6);
const machine = opacity => scene.mechanism({...content.body, opacity, ...(opacity < 1 ? {pins: [], actuated: []} : {})});
// Base joint, elbow, end-effector, elbow, base joint, perhaps the tool; with sliders foot, end-effector, foot.
const joints = ({xi, elbows: [left, right]}) => robot.turns
  ? [robot.drives[0].slice(0, 2), left, xi, right, robot.drives[1].slice(0, 2), ...robot.tool ? [at] : []]
  : [left, xi, right];
const ghosts = layers.map(() => machine(0.22)), mechanism = machine(1);
const state = element("span", {class: "state"});
frame.append(element("div", {class: "under"}, state));
frame.append(element("ul", {class: "legend", "aria-label": "colours of the picture"},
  ...content.body.key.map(([name, inks]) => entry(swatch(inks, 6), name)), entry("pale: other modes")));

// The map ---------------------------------------------------------------------------------------------------------

const [[nameX, unitX, scaleX], [nameY, unitY, scaleY]] = axes;
const scaled = [content.x.map(x => scaleX * x), content.y.map(y => scaleY * y)];
const spans = scaled.map(values => {
  const half = (values[values.length - 1] - values[0]) / (values.length - 1) / 2;  // nodes are the middles of pixels
  return [values[0] - half, values[values.length - 1] + half];
});
const heading = element("h2"), legend = element("ul", {class: "legend", "aria-label": "singularity loci"});
const parent = element("figure", {class: "map"}, element("figcaption", {}, heading, legend));
const plotSection = byId("plots");
plotSection.append(parent);
const ranges = {x: new Range(spans[0]), y: new Range(spans[1])};
const plot = new Plot(parent, {
  height: innerWidth > 820 ? Math.max(340, Math.min(520, innerHeight - 380)) : 340, min_border_left: 62,
  x_axis_label: `${nameX} (${unitX})`, y_axis_label: `${nameY} (${unitY})`,
}, ranges);
const crossbar = element("div", {class: "cross"});
plot.glass.append(crossbar);

const mapper = new Bokeh[field.logarithmic ? "LogColorMapper" : "LinearColorMapper"]({
  palette: palette(field.palette), low: field.limits[0], high: field.limits[1], nan_color: "rgba(0, 0, 0, 0)"});
const {ndarray} = Bokeh.require("core/util/ndarray");
const images = layers.map(layer => ndarray(layer.values.map(value => value === Infinity ? 1e12 : field.factor * value),
  {dtype: "float32", shape: [content.y.length, content.x.length]}));
const image = plot.figure.image({image: {field: "image"}, x: spans[0][0], y: spans[1][0], dw: spans[0][1] - spans[0][0],
  dh: spans[1][1] - spans[1][0], color_mapper: mapper,
  source: new Bokeh.ColumnDataSource({data: {image: [images[chosen]]}})});
const bar = new Bokeh.ColorBar(
  {color_mapper: mapper, width: 14, padding: 4, background_fill_color: null, bar_line_color: null});
plot.figure.add_layout(bar, "right");

// Lines differ by their dashes, points by their shapes; drawn dark on the map's own ground in either theme.
const INK = "#1a1a1a";
const STYLES = {
  "Type 1: a leg in line": {}, "Type 1: a bar across its guide": {},
  "Type 2: distal bars stretched": {line_dash: [7, 3]}, "Type 2: distal bars folded": {line_dash: [8, 3, 2, 3]},
  "Type 2: elbows coincide, self-motion": {line_dash: [2, 2]},
  "path, from ● to ■": {line_color: "#009E73", line_width: 2.6},
  "region that is left, inside its border": {line_color: "#B5508C", line_width: 2.2},
  "Type 3": {marker: "diamond"}, "Type 1 in a point: a leg folded on its base": {marker: "x"},
  "Type 2 in a point: elbows coincide, self-motion": {marker: "cross"},
};
const MARKS = {diamond: "◇", x: "×", cross: "+"};
const present = Object.entries(STYLES).filter(([kind]) => loci.some(locus => locus.kind === kind));
const drawn = present.map(([kind, style]) => {
  const source = new Bokeh.ColumnDataSource({data: {x: [], y: []}}), place = {x: {field: "x"}, y: {field: "y"}, source};
  const renderer = style.marker
    ? plot.figure.scatter({...place, size: 8, fill_color: "#ffffff", line_color: INK, ...style})
    : plot.figure.line({...place, line_color: INK, line_width: 1.6, line_join: "round", ...style});
  const mark = style.marker && element("span", {"aria-hidden": "true"}, MARKS[style.marker]);
  legend.append(entry(mark ?? swatch(style.line_color ?? "--ink", 2, style.line_dash ?? []), kind));
  return {kind, source, renderer};
});

// A path's ends, and the number of each aspect, on a disc.
const along = loci.find(({kind}) => kind.startsWith("path"))?.points.map(
  (values, k) => Float64Array.from(values, value => axes[k][2] * value));
if (along) {
  scene.path(...along.map((values, k) => values.map(value => value / axes[k][2])), "--c3", 3);
  for (const [marker, at] of [["circle", 0], ["square", along[0].length - 1]])
    plot.figure.scatter({x: [along[0][at]], y: [along[1][at]], marker, size: 9, fill_color: "#009E73", line_color: "#ffffff"});
}
const numbered = new Bokeh.ColumnDataSource({data: {x: [], y: [], text: []}});
const byNumber = {x: {field: "x"}, y: {field: "y"}, source: numbered};
plot.figure.scatter({...byNumber, size: 19, fill_color: "#ffffff", line_color: INK});
plot.figure.text({...byNumber, text: {field: "text"}, text_align: "center", text_baseline: "middle", text_color: INK,
  text_font: FONT, text_font_size: "12px", text_font_style: "bold"});

function palette(name) {
  const {Cividis256} = Bokeh.Palettes;
  const mixed = (colours, low, high) => Array.from({length: 257}, (_, k) => {
    const place = (low + (high - low) * k / 256) * (colours.length - 1);
    const first = Math.min(Math.floor(place), colours.length - 2);
    const part = shift => [24, 16, 8].map(bits => colours[first + shift] >>> bits & 255);  // of 0xRRGGBBAA
    const between = part(0).map((a, c) => Math.round(a + (place - first) * (part(1)[c] - a)));
    return "#" + between.map(value => value.toString(16).padStart(2, "0")).join("");
  });
  if (name === "diverging") return mixed(field.signed.map(colour => parseInt(colour.slice(1) + "ff", 16)), 0, 1);
  const rising = mixed(Cividis256, 0.35, 1);
  return name === "rising" ? rising : rising.reverse();
}

function choose(layer) {
  chosen = layer;
  plot.title = `${field.words}, ${kindOfMode} ${signs(layers[layer].mode)}`;
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
  const own = content.numbers.filter(number => number[3].includes(layer));
  numbered.data = {x: own.map(number => scaleX * number[1]), y: own.map(number => scaleY * number[2]),
    text: own.map(([number]) => String(number))};
  draw();
}

const legendOfNumbers = content.numbers.length ? [{text: "number of an aspect", mark: "①"}] : [];
legend.append(...legendOfNumbers.map(({text, mark}) => entry(element("span", {"aria-hidden": "true"}, mark), text)));

plot.legend = () => drawn.map(({kind}) => ({text: kind, colour: STYLES[kind].line_color ?? theme("--ink"),
  dash: STYLES[kind].line_dash ?? [], mark: MARKS[STYLES[kind].marker]})).concat(legendOfNumbers);
plot.pointed = () => Object.assign(plot.pixels(scaleX * at[0], scaleY * at[1]), {ink: INK});
plot.element.setAttribute("aria-label",
  `map of ${field.words} over ${nameX} and ${nameY}; the point is moved by the arrow keys`);

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
