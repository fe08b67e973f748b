// The page of motions: `at` is the index of the sample shown, on the clock that all subjects share.

const {subjects, panels, axis} = content, several = subjects.length > 1;
for (const subject of subjects) subject.x ??= subject.t;

// The times of all subjects, those that differ by rounding once; a single subject's own abscissa.
const clock = several ? union(subjects.map(subject => subject.t)) : subjects[0].x;
const times = several ? clock : subjects[0].t;
let at = 0, playing = false, moment = times[0], selected = 0;

function union(arrays) {
  const all = Float64Array.from(arrays.flatMap(values => [...values])).sort(), [low, high] = extent(arrays);
  return all.filter((x, k) => k === 0 || x - all[k - 1] > 1e-9 * (high - low));
}

const shownAt = (subject, index = at) => several ? nearest(subject.t, clock[index]) : index;
const abscissa = index => axis.scale * clock[index];
const where = () => `${axis.name} ${readable(abscissa(at))} ${axis.unit}`;

// The picture -----------------------------------------------------------------------------------------------------

const joint = (subject, k, index) =>
  subject.joints[k].map(x => typeof x === "number" ? x : x[index]);
const traced = subject => subject.joints[subject.traced].map(x =>
  typeof x === "number" ? new Float64Array(subject.t.length).fill(x) : x);
const columnsOf = k => subjects.flatMap(subject =>
  [...subject.joints.map(pair => typeof pair[k] === "number" ? [pair[k]] : pair[k]), ...(subject.reference ? [subject.reference[k]] : [])]);

// Each of several subjects has a colour and dashes; the ink is left to the joints while there are others.
const look = k => several ? [0, 1, 3, 4, 5, 2][k % 6] : k % 6;

const frame = document.getElementById("picture");
const scene = new Picture(frame, around(columnsOf(0), columnsOf(1)));
const mechanisms = subjects.map((subject, k) => {
  if (subject.reference && k === 0) scene.path(...subject.reference, several ? "--line" : "--c3", 6, [], {opacity: 0.7});
  scene.path(...traced(subject), several ? "--c" + look(k) : "--c4", 2, several ? dash(k) : [], {class: "trace"});
  return scene.mechanism({
    bars: subject.bars.map(([i, j, leg]) => [i, j, "--c" + (several ? look(k) : leg ?? 2)]),
    rails: subject.rails, blocks: subject.blocks, pins: subject.pins, grounded: subject.grounded, actuated: subject.actuated, traced: subject.traced,
    letters: subject.names, opacity: several ? 0.8 : 1, name: subject.name, mark: k % 2 ? "square" : "round",
  });
});
const state = element("span", {class: "state"});
frame.append(element("div", {class: "under"}, state,
  button("−", "picture: zoom out", () => magnify(1 / 2)), button("+", "picture: zoom in on the end-effector", () => magnify(2)),
  button("Fit", "picture: show all", () => magnify(0))));
frame.append(pathLegend());

function pathLegend() {
  const entry = (text, ink, width, dashes) => element("li", {}, element("span", {class: "entry"}, swatch(ink, width, dashes),
    element("span", {class: "name"}, text)));
  const entries = subjects.map((subject, k) => several ? entry(subject.name, "--c" + look(k), 2, dash(k)) : entry("path", "--c4", 2, []));
  if (subjects[0].reference) entries.push(entry("reference", several ? "--line" : "--c3", 6, []));
  if (!several && subjects[0].bars.some(bar => bar[2] !== null))
    entries.push(entry("left leg", "--c0", 6, []), entry("right leg", "--c1", 6, []));
  return element("ul", {class: "legend", "aria-label": "colours of the picture"}, ...entries);
}

function magnify(factor) {
  scene.zoom = factor ? Math.min(Math.max(scene.zoom * factor, 1), 1024) : 1;
  draw();
}

// The sample whose traced point is nearest to the pointer, within that many pixels of it.
function pointAtPath(event, within) {
  const box = scene.svg.getBoundingClientRect(), px = event.clientX - box.left, py = event.clientY - box.top;
  let best = within * within, found = null;
  subjects.forEach((subject, k) => {
    const [xs, ys] = traced(subject);
    for (let index = 0; index < xs.length; index++) {
      const [x, y] = scene.onScreen([xs[index], ys[index]]), far = (x - px) ** 2 + (y - py) ** 2;
      if (far < best) [best, found] = [far, several ? nearest(clock, subject.t[index]) : index];
    }
  });
  if (found !== null) go(found);
}
scene.svg.addEventListener("pointermove", event => pointAtPath(event, event.buttons ? 1e4 : 24));
scene.svg.addEventListener("pointerdown", event => pointAtPath(event, 1e4));
scene.svg.addEventListener("wheel", event => {
  if (!event.ctrlKey) return;
  event.preventDefault();
  magnify(event.deltaY < 0 ? 2 : 1 / 2);
}, {passive: false});

// The plots -------------------------------------------------------------------------------------------------------

const whole = (([low, high]) => [axis.scale * low, axis.scale * high])(extent([clock]));
const time = new Range(whole);
const xs = subjects.map(subject => subject.x.map(x => axis.scale * x));
const plots = panels.map((panel, number) => {
  const last = number === panels.length - 1, unit = panel.unit && ` (${panel.unit})`;
  const legend = element("ul", {class: "legend", "aria-label": `curves of ${panel.title}`});
  const parent = element("figure", {}, element("figcaption", {}, element("h2", {}, panel.title, element("small", {}, unit)), legend));
  document.getElementById("plots").append(parent);
  const plot = new Plot(parent, {
    height: last ? 196 : 168, min_border_left: 70, min_border_right: 10, min_border_top: 4,
    x_axis_label: last ? `${axis.name} (${axis.unit})` : null,
  }, {x: time, y: new Range()});
  plot.title = panel.title + unit;
  plot.values = panel.curves.map(curve => subjects[curve.subject].columns[curve.key].map(value => panel.scale * value));
  plot.limits = panel.limits.map(limit => panel.scale * limit);
  plot.curves = panel.curves.map((curve, k) =>
    plot.curve(panel.step ? "step" : "line", k,
      {line_width: 1.4 + 1.2 * (1 - (k + 1) / panel.curves.length), ...(panel.step ? {mode: "after"} : {})}));
  // a limit far from the curves would flatten them
  plot.limits = extent(plot.values.map(values => values.map(Math.abs)))[1] > Math.max(...plot.limits) / 5 ? plot.limits : [];
  plot.rules = plot.limits.map(limit => new Bokeh.Span({location: limit, dimension: "width", line_dash: dash(2), line_width: 1.3}));
  plot.marks = subjects.flatMap(subject => subject.marks.map(([t]) =>
    new Bokeh.Span({location: axis.scale * t, dimension: "height", line_dash: [4, 4], line_width: 1.2})));
  for (const line of [...plot.rules, ...plot.marks]) plot.figure.add_layout(line);
  plot.outputs = panel.curves.map((curve, k) => {
    const output = element("output"), key = element("button", {type: "button", "aria-pressed": "true", title: "show or hide"},
      swatch("--c" + look(k), 2, dash(k)), element("span", {class: "name"}, curve.label), output);
    key.onclick = () => {
      plot.curves[k].visible = !plot.curves[k].visible;
      key.setAttribute("aria-pressed", plot.curves[k].visible);
      scaleUp(plot);
    };
    legend.append(element("li", {}, key));
    return output;
  });
  if (panel.limits.length) {
    const text = [...new Set(panel.limits.map(limit => "±" + readable(panel.scale * Math.abs(limit))))].join(", ");
    legend.append(element("li", {}, element("span", {class: "entry"}, ...(plot.limits.length ? [swatch("--c2", 2, dash(2))] : []),
      `limit ${text}${plot.limits.length ? "" : ", far outside"}`)));
  }
  plot.legend = () => panel.curves.map((curve, k) => ({text: curve.label, colour: colour(look(k)), dash: dash(k)}));
  plot.element.setAttribute("aria-label", `${plot.title} over ${axis.name}: ` + panel.curves.map((curve, k) =>
    `${curve.label} from ${extent([plot.values[k]]).map(readable).join(" to ")}`).join("; "));
  return plot;
});

// What is seen of the curves, and the ordinate's range for it; the limits too, unless zoomed in.
function scaleUp(plot) {
  const panel = panels[plots.indexOf(plot)], zoomedIn = time.end - time.start < 0.999 * (whole[1] - whole[0]);
  const inView = panel.curves.map((curve, k) => {
    const own = xs[curve.subject], [a, b] = [time.start, time.end].map(x => nearest(own, x)).sort((a, b) => a - b);
    const first = Math.max(0, a - 1), last = Math.min(own.length - 1, b + 1);
    plot.curves[k].data_source.data = seen(own, plot.values[k], first, last);
    return plot.curves[k].visible ? plot.values[k].subarray(first, last + 1) : [];
  });
  const [low, high] = extent(zoomedIn ? inView : [...inView, plot.limits]);
  const room = 0.07 * (high - low) || 0.1 * Math.abs(high) || 1;
  plot.ranges.y.set(low - room, high + room);
}

const rescale = oncePerFrame(() => { plots.forEach(scaleUp); draw(); });

function zoom(factor, about = abscissa(at)) {
  if (factor) zoomed(time, factor, about, whole, 1e-5);
  else time.set(...whole);
  rescale();
}

function listen(plot) {
  const {glass} = plot;
  let from = null, box = null;
  glass.addEventListener("pointerdown", event => {
    selected = plots.indexOf(plot);
    glass.setPointerCapture(event.pointerId);
    if (event.shiftKey) {
      from = plot.at(event)[0];
      glass.append(box = element("div", {class: "box"}));
    } else point(event);
  });
  glass.addEventListener("pointermove", event => {
    if (!box) return point(event);
    const [a, b] = [from, plot.at(event)[0]].map(x => plot.pixels(x)[0]).sort((a, b) => a - b);
    Object.assign(box.style, {left: a + "px", width: b - a + "px"});
  });
  const end = event => {
    if (!box) return;
    const [a, b] = [from, plot.at(event)[0]].map(x => Math.min(Math.max(x, whole[0]), whole[1])).sort((a, b) => a - b);
    box.remove();
    box = null;
    if (b - a < 1e-5 * (whole[1] - whole[0])) return;
    time.set(a, b);
    rescale();
  };
  glass.addEventListener("pointerup", end);
  glass.addEventListener("pointercancel", () => { box?.remove(); box = null; });
  glass.addEventListener("dblclick", () => zoom(0));
  glass.addEventListener("wheel", event => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    zoom(event.deltaY < 0 ? 0.8 : 1.25, plot.at(event)[0]);
  }, {passive: false});
  const point = event => go(nearest(clock, plot.at(event)[0] / axis.scale));
}

// The controls ----------------------------------------------------------------------------------------------------

const play = button("Play", "play", () => { playing ? pause() : start(); });
const slider = element("input", {type: "range", min: 0, max: clock.length - 1, step: 1, value: 0, "aria-label": axis.name});
const output = element("output", {id: "clock"});
const speed = element("select", {"aria-label": "speed"}, ...[0.1, 0.25, 0.5, 1, 2, 4].map(factor =>
  element("option", {value: factor, ...(factor === 1 ? {selected: ""} : {})}, `${factor} ×`)));
slider.oninput = () => go(+slider.value);
const marks = subjects.flatMap(subject => subject.marks.map(([t, text]) => {
  const label = `${several ? subject.name + ": " : ""}${text} at ${readable(t)} s`;
  return button(label, `go to ${label}`, () => go(nearest(clock, t)));
}));
document.getElementById("controls").append(play, slider, output, speed, ...marks,
  button("−", "zoom out", () => zoom(2)), button("+", "zoom in", () => zoom(0.5)), button("All", "show all", () => zoom(0)),
  button("PNG", "save this page as a picture (PNG)", () => savePng(scene.svg, plots)),
  button("CSV", `save the samples of this page as CSV; ${content.source} writes all`, table),
  element("details", {}, element("summary", {}, "Keys and pointer"),
    "Point at a plot or at the path, or drag: the mechanism is shown in that state. ← → move on (with Shift by one sample), " +
    "Page Up and Page Down by a tenth, Home and End to the ends, Space plays, + − 0 zoom. Shift and drag zooms into a stretch, " +
    "Ctrl and wheel zooms at the pointer, a double click shows all."));

function start() {
  playing = true;
  if (at === lastIndex()) go(firstIndex());
  moment = times[at];
  let before = performance.now();
  play.textContent = "Pause";
  play.setAttribute("aria-label", "pause");
  const next = now => {
    if (!playing) return;
    moment += Math.max(0, now - before) / 1000 * +speed.value;
    before = now;
    if (moment >= times[times.length - 1]) moment = times[0];
    go(nearest(times, moment), true);
    requestAnimationFrame(next);
  };
  requestAnimationFrame(next);
}

function pause() {
  playing = false;
  play.textContent = "Play";
  play.setAttribute("aria-label", "play");
}

const firstIndex = () => 0, lastIndex = () => clock.length - 1;

function go(index, ownMotion = false) {
  if (!ownMotion && playing) pause();
  const next = Math.min(Math.max(index, 0), clock.length - 1);
  if (next === at && slider.value === String(at)) return;
  at = next;
  draw();
}

addEventListener("keydown", event => {
  const {key, target} = event, tag = target.tagName;
  if (event.ctrlKey || event.metaKey || event.altKey || tag === "SELECT") return;
  const right = clock[0] <= clock[clock.length - 1] ? 1 : -1, seen = (time.end - time.start) / (whole[1] - whole[0]);
  const step = event.shiftKey ? 1 : Math.max(1, Math.round(seen * clock.length / 400));
  const tenth = Math.max(1, Math.round(seen * clock.length / 10));
  const actions = {
    ArrowRight: () => go(at + right * step), ArrowUp: () => tag === "INPUT" && go(at + step),
    ArrowLeft: () => go(at - right * step), ArrowDown: () => tag === "INPUT" && go(at - step),
    PageUp: () => go(at + right * tenth), PageDown: () => go(at - right * tenth),
    Home: () => go(0), End: () => go(clock.length - 1),
    "+": () => zoom(0.5), "=": () => zoom(0.5), "-": () => zoom(2), 0: () => zoom(0), " ": () => play.click(),
  };
  if (!(key in actions) || (key === " " && ["BUTTON", "SUMMARY"].includes(tag))) return;
  if (actions[key]() !== false) event.preventDefault();
});

// What is seen ----------------------------------------------------------------------------------------------------

const draw = oncePerFrame(() => {
  const missing = [];
  subjects.forEach((subject, k) => {
    const index = shownAt(subject);
    if (!scene.place(mechanisms[k], subject.joints.map((_, point) => joint(subject, point, index)))) missing.push(subject.name);
  });
  const centre = mechanisms.find(({points}) => points.length)?.points[subjects[0].traced];
  if (scene.zoom > 1 || scene.drawn !== scene.zoom) {
    scene.fit(centre);
    mechanisms.forEach(mechanism => scene.write(mechanism));
    scene.drawn = scene.zoom;
  }
  const x = abscissa(at);
  plots.forEach((plot, number) => {
    plot.cursor.style.transform = `translateX(${plot.pixels(x)[0] - 1}px)`;
    panels[number].curves.forEach((curve, k) => {
      plot.outputs[k].textContent = readable(plot.values[k][shownAt(subjects[curve.subject])]);
    });
  });
  slider.value = at;
  slider.setAttribute("aria-valuetext", where());
  output.textContent = `${readable(x)} ${axis.unit}`;
  state.textContent = missing.length ? `no pose here${several ? ": " + missing.join(", ") : ""}` : where();
  if (!playing) announce(summary);
});

const summary = () => `${where()}. ` + panels.map((panel, number) => `${panel.title}: ` + panel.curves.map((curve, k) =>
  `${curve.label} ${plots[number].outputs[k].textContent} ${panel.unit}`).join(", ")).join(". ");

function table() {
  const head = [...(several ? ["run"] : []), "t (s)", ...(axis.name === "time" ? [] : ["q (rad)"]), ...content.table.map(([, title]) => title)];
  const rows = subjects.flatMap(subject => Array.from(subject.t, (t, k) => [
    ...(several ? [subject.name] : []), t, ...(axis.name === "time" ? [] : [subject.x[k]]),
    ...content.table.map(([key]) => String(subject.columns[key][k]).replace("NaN", "nan").replace("Infinity", "inf"))]));
  saveCsv(`fivebar page: ${content.title}; SI units; the samples held by the page, ${content.source} writes all`,
    [head, ...rows].map(row => row.map(value => cell(String(value)))));
}

function paint() {
  scene.paint();
  plots.forEach((plot, number) => {
    plot.paint();
    plot.curves.forEach((curve, k) => { curve.glyph.line_color = colour(look(k)); });
    for (const line of [...plot.rules, ...plot.marks]) line.line_color = theme("--ink");
  });
}

async function begin() {
  readNotes();
  paint();
  dark.addEventListener("change", paint);
  const laid = oncePerFrame(() => { plots.forEach(plot => plot.layGlass()); draw(); });
  plots.forEach(scaleUp);
  for (const plot of plots) await plot.show(laid);
  plots.forEach(listen);
  plots.forEach(plot => plot.layGlass());
  draw();
  requestAnimationFrame(() => requestAnimationFrame(() => { document.body.dataset.ready = "yes"; }));
}
begin();
