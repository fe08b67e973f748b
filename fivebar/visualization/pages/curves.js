// The plots of a page of motions: their curves over the clock, and the pointer on them.

const whole = (([low, high]) => [axis.scale * low, axis.scale * high])(extent([clock]));
const time = new Range(whole);
const xs = subjects.map(subject => subject.x.map(x => axis.scale * x));
const plots = panels.map((panel, number) => {
  const last = number === panels.length - 1, unit = panel.unit && ` (${panel.unit})`;
  const legend = element("ul", {class: "legend", "aria-label": `curves of ${panel.title}`});
  const heading = element("h2", {}, panel.title, element("small", {}, unit));
  const parent = element("figure", {}, element("figcaption", {}, heading, legend));
  byId("plots").append(parent);
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
  const [, largest] = extent(plot.values.map(values => values.map(Math.abs)));
  if (largest < Math.max(...plot.limits) / 5) plot.limits = [];
  plot.largest = largest;
  plot.rules = plot.limits.map(limit =>
    new Bokeh.Span({location: limit, dimension: "width", line_dash: dash(2), line_width: 1.3}));
  plot.marks = subjects.flatMap(subject => subject.marks.map(([t]) =>
    new Bokeh.Span({location: axis.scale * t, dimension: "height", line_dash: [4, 4], line_width: 1.2})));
  for (const line of [...plot.rules, ...plot.marks]) plot.figure.add_layout(line);
  plot.outputs = panel.curves.map((curve, k) => {
    const output = element("output"), name = element("span", {class: "name"}, curve.label);
    const key = element("button", {type: "button", "aria-pressed": "true", title: "show or hide this curve"},
      swatch("--c" + look(k), 2, dash(k)), name);
    key.onclick = () => {
      plot.curves[k].visible = !plot.curves[k].visible;
      key.setAttribute("aria-pressed", plot.curves[k].visible);
      scaleUp(plot);
    };
    legend.append(element("li", {}, key, output));
    return output;
  });
  if (panel.limits.length) {
    const text = [...new Set(panel.limits.map(limit => "±" + readable(panel.scale * Math.abs(limit))))].join(", ");
    legend.append(plot.limits.length
      ? entry(swatch("--c2", 2, dash(2)), `limit ${text}`)
      : entry(`limit ${text}, far outside`));
  }
  plot.pointed = () => Object.assign([plot.pixels(abscissa(at))[0]], {ink: theme("--ink")});
  plot.legend = () => panel.curves.map((curve, k) => ({text: curve.label, colour: colour(look(k)), dash: dash(k)}));
  plot.element.setAttribute("aria-label", `${plot.title} over ${axis.name}: ` + panel.curves.map((curve, k) =>
    `${curve.label} from ${extent([plot.values[k]]).map(value => readable(value, largest)).join(" to ")}`).join("; "));
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
  // what is constant but for rounding stays flat, with ordinates that can be read
  const room = Math.max(0.07 * (high - low), 2e-5 * Math.max(-low, high)) || 1;
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
