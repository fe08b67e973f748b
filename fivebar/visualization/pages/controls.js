// The controls and keys of a page of motions, and what is drawn and said of the sample at hand.

const player = new Player({
  duration: times[times.length - 1] - times[0], start: times[0], loop: !content.plays,
  show(time) {
    at = nearest(times, times[0] + time);
    draw();
  },
  text: clockText, words: where,
});
byId("controls").append(...player.controls(),
  button("−", "zoom out", () => zoom(2)), button("+", "zoom in", () => zoom(0.5)),
  button("All", "show all", () => zoom(0)),
  button("PNG", "save this page as a picture (PNG)", () => savePng(pictures.map(({svg}) => svg), state.textContent, plots)),
  button("CSV", `save the samples of this page as CSV; ${content.source} writes all`, table),
  element("details", {}, element("summary", {}, "More"),
    "Point at a plot or at the path, or drag: the mechanism is shown in that state. ← → move on (with Shift by one " +
    "sample), Page Up and Page Down by a tenth, Home and End to the ends, Space plays, L over and over, + − 0 zoom. " +
    "Shift and drag zooms into a stretch, Ctrl and wheel zooms at the pointer, a double click shows all. Link is the " +
    "address of the moment shown: open it, or copy it."));

function go(index) {
  const next = Math.min(Math.max(index, 0), clock.length - 1);
  if (next !== at || player.playing) player.go(times[next] - times[0]);
}

onKeys(({shiftKey, target}) => {
  const right = clock[0] <= clock[clock.length - 1] ? 1 : -1, seen = (time.end - time.start) / (whole[1] - whole[0]);
  const step = shiftKey ? 1 : Math.max(1, Math.round(seen * clock.length / 400));
  const tenth = Math.max(1, Math.round(seen * clock.length / 10)), inField = target.tagName === "INPUT";
  return {
    ...player.keys(),
    ArrowRight: () => go(at + right * step), ArrowUp: () => inField && go(at + step),
    ArrowLeft: () => go(at - right * step), ArrowDown: () => inField && go(at - step),
    PageUp: () => go(at + right * tenth), PageDown: () => go(at - right * tenth),
    "+": () => zoom(0.5), "=": () => zoom(0.5), "-": () => zoom(2), 0: () => zoom(0),
  };
});

// What is seen ----------------------------------------------------------------------------------------------------

const draw = oncePerFrame(() => {
  const missing = [];
  subjects.forEach((subject, k) => {
    const index = shownAt(subject), points = subject.joints.map((_, point) => joint(subject, point, index));
    if (!sceneOf(k).place(mechanisms[k], points)) missing.push(subject.name);
  });
  for (const own of pictures)
    if (own.zoom > 1 || own.drawn !== own.zoom) {
      own.fit(own.mechanisms.find(({points}) => points.length)?.points[subjects[0].traced]);
      own.drawn = own.zoom;
    }
  const x = abscissa(at);
  plots.forEach((plot, number) => {
    plot.cursor.style.transform = `translateX(${plot.pixels(x)[0] - 1}px)`;
    panels[number].curves.forEach((curve, k) => {
      plot.outputs[k].textContent = readable(plot.values[k][shownAt(subjects[curve.subject])], plot.largest);
    });
  });
  state.textContent = missing.length ? `no pose here${several ? ": " + missing.join(", ") : ""}` : where();
  if (!player.playing) announce(summary);
});

const summary = () => `${where()}. ` + panels.map((panel, number) => `${panel.title}: ` + panel.curves.map((curve, k) =>
  `${curve.label} ${plots[number].outputs[k].textContent} ${panel.unit}`).join(", ")).join(". ");

function table() {
  const extra = axis.name === "time" ? [] : ["q (rad)"], named = several ? ["run"] : [];
  const head = [...named, "t (s)", ...extra, ...content.table.map(([, title]) => title)];
  const rows = subjects.flatMap(subject => Array.from(subject.t, (t, k) =>
    [...named.map(() => subject.name), t, ...extra.map(() => subject.x[k]),
      ...content.table.map(([key]) => subject.columns[key][k])]));
  saveCsv(`fivebar page: ${content.title}; SI units; the samples held by the page, ${content.source} writes all`,
    [head, ...rows]);
}

function paint() {
  for (const own of pictures) own.paint();
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
  player.begin(content.plays);
}
begin();
