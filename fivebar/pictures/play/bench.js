// The page of a linkage: the picture, its curves over the crank angle, and what is set.

const bench = new View(byId("bench")), plots = new View(byId("curves"));
const arrows = {velocity: true, acceleration: true};
const INKS_OF_LINKS = ["c0", "c1", "c3", "c2"];  // the coupler's triangle is one link
let benchBefore = 0;

function benchBounds() {
  const points = [];
  for (const sweep of [lab.sweep, lab.other])
    for (const row of sweep.rows) if (row) points.push(...row.points.filter((_, k) => wordsOf().pins.includes(k)));
  const xs = points.map(([x]) => x), ys = points.map(([, y]) => y);
  return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
}

function fitBench() {
  bench.measure();
  plots.measure();
  bench.fit(benchBounds(), 34);
}

const runsOf = (rows, place) => {
  const lines = [[]];
  for (const row of rows) if (row) lines[lines.length - 1].push(place(row)); else if (lines[lines.length - 1].length) lines.push([]);
  return lines;
};

function drawBench(pen = bench.front, alone = true) {
  if (alone) bench.begin(pen);
  const {bars, grounded, rails, blocks, traced, pins, names: letters, actuated} = wordsOf(), now = at_(lab.q);
  const put_ = point => bench.at(point), path = rows => runsOf(rows, row => put_(row.points[traced]));
  if (lab.ghost) pen.lines(path(lab.ghost), {ink: "quiet", width: 1.2, dash: [2, 4]});
  pen.lines(path(lab.other.rows), {ink: "c4", width: 1.4, dash: [7, 4], alpha: 0.5});
  pen.lines(path(lab.sweep.rows), {ink: "c4", width: 2});
  const preset = straight[lab.preset];
  if (preset && lab.kind === "four") {
    const {through: [x, y], direction: [ux, uy]} = preset, far = lab.values[0];
    pen.lines([[put_([x - far * ux, y - far * uy]), put_([x + far * ux, y + far * uy])]], {ink: "c3", width: 1.2, dash: [5, 4]});
  }
  if (lab.trail.length > 1) pen.lines([lab.trail.map(put_)], {ink: "c5", width: 2.4});
  const on = now.points.map(put_);
  for (const [i, j] of rails) pen.lines([[on[i], on[j]]], {ink: "line", width: 6});
  for (const k of grounded) if (pins.includes(k))
    pen.lines([[on[k], [on[k][0] - 9, on[k][1] + 15], [on[k][0] + 9, on[k][1] + 15]]], {ink: "quiet", fill: "line", closed: true});
  for (const [i, j] of blocks) pen.lines([[on[i], on[j]]], {ink: "quiet", width: 18});
  bars.forEach(([i, j], k) => pen.lines([[on[i], on[j]]], {ink: INKS_OF_LINKS[lab.kind === "four" && k > 2 ? 1 : k % 4], width: 6}));
  for (const k of pins) {
    pen.circle(on[k], actuated.includes(k) ? 8 : 6, k === traced ? {fill: "c4", ink: "ink", width: 2}
      : actuated.includes(k) ? {fill: "ink"} : {fill: "paper", ink: "ink", width: 2});
    pen.words(letters[k], [on[k][0] + 10, on[k][1] - 8], {size: 13});
  }
  const room = 0.22 * Math.min(bench.width, bench.height), size = Math.hypot(...now.velocity);
  const [ux, uy] = size ? now.velocity.map(x => x / size) : [0, 0], along = now.tangential;
  const across = [now.acceleration[0] - along * ux, now.acceleration[1] - along * uy];
  for (const [name, [x, y], ink, most] of [["velocity", now.velocity, "ink", lab.most[0]],
    ["acceleration", [along * ux, along * uy], "c5", lab.most[1]], ["acceleration", across, "c4", lab.most[1]]])
    if (arrows[name] && Number.isFinite(x + y))
      drawArrow(pen, on[traced], [on[traced][0] + room / most * x, on[traced][1] - room / most * y], ink, 2.6);
}

// Three plots over the crank angle, the cursor at the one at hand.
function drawCurves() {
  const pen = plots.front, {rows} = lab.sweep, {angle: turns, output} = wordsOf();
  plots.begin(pen);
  const panels = [
    {title: `${output} (${turns ? "deg" : "mm"})`, curves: [[row => row.output[0] * (turns ? 180 / Math.PI : 1e3), "c2", []]]},
    {title: "speed, a_t, a_n (scaled)", range: [-1.2, 1.2], curves: [
      [row => Math.hypot(...row.velocity) / lab.most[0], "c2", []], [row => row.tangential / lab.most[1], "c5", [6, 3]],
      [row => row.normal / lab.most[1], "c4", [2, 3]]]},
    {title: "transmission angle (deg)", curves: [[row => row.transmission * 180 / Math.PI, "c3", []]], range: [0, 180]},
  ];
  const height = plots.height / panels.length, left = 44, wide = plots.width - left - 8;
  panels.forEach(({title, curves, range}, n) => {
    const values = curves.flatMap(([of]) => rows.filter(Boolean).map(of)).filter(Number.isFinite);
    const [low, high] = range ?? [Math.min(...values), Math.max(...values)], span = high - low || 1;
    const top = n * height + 20, tall = height - 28, x = row => left + wide * (row.q + Math.PI) / TURN;
    pen.lines([[[left, top], [left + wide, top], [left + wide, top + tall], [left, top + tall]]], {ink: "line", width: 1, closed: true});
    pen.words(title, [left, top - 6], {size: 12});
    for (const [value, y] of [[high, top + 10], [low, top + tall]])
      pen.words(number(Math.abs(value) < 1e-3 * span ? 0 : value, 3), [left - 4, y], {ink: "quiet", size: 11, align: "right"});
    for (const [of, ink, dash_] of curves)
      for (const line of runsOf(rows, row => [x(row), top + tall - tall * Math.min(Math.max((of(row) - low) / span, -0.02), 1.02)]))
        pen.lines([line.filter(([, y]) => Number.isFinite(y))], {ink, width: 1.8, dash: dash_});
    const at = left + wide * (lab.q + Math.PI) / TURN;
    pen.lines([[[at, top], [at, top + tall]]], {ink: "ink", width: 1.5});
  });
}

const benchFrame = oncePerFrame(() => {
  if (byId("linkage").hidden) return;
  const now = performance.now();
  if (lab.running) {
    const step = lab.way * lab.speed * Math.min(now - benchBefore, 40) / 1000 * 0.25;
    if (!stepCrank(step)) lab.way = -lab.way;
    benchFrame();
  }
  benchBefore = now;
  drawBench();
  drawCurves();
  benchWords();
});

const benchRows = new Map();
function benchWords() {
  const now = at_(lab.q), line = byId("linkage-said"), {angle: turns, output} = wordsOf();
  const text = lab.said || verdictCache.join(" ");
  if (line.textContent !== text) line.textContent = text;
  line.classList.toggle("warned", Boolean(lab.said));
  const set = (name, value) => {
    if (!benchRows.has(name)) {
      const cell = element("dd");
      byId("linkage-numbers").append(element("dt", {}, name), cell);
      benchRows.set(name, cell);
    }
    if (benchRows.get(name).textContent !== value) benchRows.get(name).textContent = value;
  };
  const metres = x => Number.isFinite(x) ? `${number(x, 3)} m` : "straight";
  set("crank", deg(lab.q));
  set("output", `${output} ${turns ? deg(now.output[0]) : mm(now.output[0])}`);
  set("its rate", turns ? `${number(now.output[1], 3)} rad/s` : `${number(now.output[1], 3)} m/s`);
  set("speed of the point", `${number(Math.hypot(...now.velocity), 3)} m/s`);
  set("tangential acceleration", `${number(now.tangential, 3)} m/s²`);
  set("normal acceleration", `${number(now.normal, 3)} m/s²`);
  set("radius of curvature", metres(now.radius));
  set("transmission angle", deg(now.transmission));
  if (!lab.running) announce(() => `${text} Crank at ${deg(lab.q)}.`);
}

let verdictCache = [];
function relabbed(refitView = true) {  // after lengths, branch or kind changed
  const rows = lab.sweep.rows.filter(Boolean), high = of => {
    const values = rows.map(of).filter(Number.isFinite).sort((a, b) => a - b);
    return values[Math.floor(0.97 * (values.length - 1))] || 1;
  };
  lab.most = [high(row => Math.hypot(...row.velocity)), high(row => Math.hypot(...row.acceleration))];
  verdictCache = verdictLines();
  if (refitView) fitBench();
  benchFrame();
  clearTimeout(fragmentTimer);
  fragmentTimer = setTimeout(() => {
    if (byId("linkage").hidden) return;
    try { history.replaceState(null, "", linkageFragment()); } catch { /* no address in a frame */ }
  }, 300);
}

// Undo: the states before each change, as their addresses.
const labPast = [];
const rememberLab = () => { if (lab.values && labPast[labPast.length - 1] !== linkageFragment()) labPast.push(linkageFragment()); };

function undoLab() {
  const now = linkageFragment();
  while (labPast.length && labPast[labPast.length - 1] === now) labPast.pop();
  if (!labPast.length) {
    lab.said = "Nothing to undo.";
    return benchFrame();
  }
  const {kind, values, branch, q} = readLinkage(labPast.pop()).state;
  chooseKind(kind, values, branch, q);
}

function linkagePython() {
  const v = lab.values, sign_ = lab.branch.length > 1 ? `(${lab.branch.join(", ")})` : lab.branch[0];
  const made = lab.kind === "four" ? `linkages.FourBar(${v.slice(0, 4).join(", ")}, point=(${v[4]}, ${v[5]}))`
    : lab.kind === "press" ? "replace(linkages.PRESSES[\"repaired\"][0], " +
      `${["l2", "l3", "l4", "l5", "l11"].map((name, k) => `${name}=${v[k]}`).join(", ")})`
      : `linkages.SliderCrank(${v.join(", ")}, held="${lab.kind.slice(7)}")`;
  return `${lab.kind === "press" ? "from dataclasses import replace\n" : ""}from fivebar import linkages

linkage = ${made}
print(*linkages.verdict(linkage, ${sign_}), sep="\n")
motion = linkages.move(linkage, ${lab.q}, branch=${sign_})
study = linkages.study(linkage, branch=${sign_})  # the curves as numbers; study.page("study.html")
`;
}

function benchPicture(png) {
  if (!png) {
    const pen = new SvgPen();
    bench.begin(pen);
    drawBench(pen, false);
    return save(new Blob([pen.text()], {type: "image/svg+xml"}), ".svg");
  }
  const canvas = document.createElement("canvas"), pen = new CanvasPen(canvas);
  pen.begin(bench.width, bench.height, 2);
  pen.pen.fillStyle = inks.paper;
  pen.pen.fillRect(0, 0, bench.width, bench.height);
  drawBench(pen, false);
  canvas.toBlob(blob => save(blob, ".png"), "image/png");
}

function chooseKind(kind, values = kinds[kind].parameters.map(({value}) => value), branch = kinds[kind].branch, q = lab.q) {
  Object.assign(lab, {kind, branch: [...branch], q, trail: [], ghost: null, preset: ""});
  if (!refit(values)) return false;
  buildBench();
  relabbed();
  return true;
}

function buildBench() {
  const {parameters, title} = wordsOf();
  const rows = parameters.map(({name, signed}, k) => {
    const most = Math.max(...lab.values.map(Math.abs), 0.1) * 2;
    const range = element("input", {type: "range", min: signed ? -most : 0.002, max: most, step: "any", "aria-label": `${name}, m`});
    const input = element("input", {type: "number", step: "any", "aria-label": `${name}, mm`});
    const show = () => { range.value = lab.values[k]; input.value = +(1e3 * lab.values[k]).toPrecision(6); };
    const change = value => {
      if (!(Math.abs(value) <= 10) || (!signed && !(value >= 0.001)))
        lab.said = `${name} must be between ${signed ? "−10000" : "1"} and 10000 mm: kept as it was.`;
      else refit(lab.values.map((x, i) => i === k ? value : x));
    };
    range.oninput = () => {
      if (!lab.ghost) rememberLab();
      lab.ghost ??= lab.sweep.rows;
      change(Math.round(+range.value * 1e6) / 1e6);
      input.value = +(1e3 * lab.values[k]).toPrecision(6);
      relabbed(false);
    };
    range.onchange = () => { lab.ghost = null; show(); relabbed(); };
    input.onchange = () => { rememberLab(); change(input.value === "" ? NaN : +input.value / 1e3); show(); relabbed(); };
    show();
    return element("div", {class: "slide"}, element("span", {"aria-hidden": "true"}, name), range, input);
  });
  const run = button(lab.running ? "Hold" : "Run", "turn the crank, to and fro where it locks (space)", toggleRun);
  run.id = "run";
  const four = lab.kind === "four", slider_ = lab.kind.startsWith("slider");
  const preset = element("select", {"aria-label": "linkage by name"}, element("option", {value: ""}, "named …"),
    ...[...Object.keys(straight), "MechAnalyzer"].map(name => element("option", {value: name}, name)));
  preset.onchange = () => {
    const own = straight[preset.value];
    rememberLab();
    if (!own) return chooseKind("four");
    lab.q = (own.stroke[0] + own.stroke[1]) / 2;
    Object.assign(lab, {kind: "four", branch: [...own.branch], trail: [], ghost: null});
    refit([...own.values]);
    lab.preset = preset.value;
    buildBench();
    relabbed();
  };
  const held = ["guide", "crank", "rod", "slider"].map(name => {
    const made = button(name, `hold the ${name}`, () => { rememberLab(); chooseKind(`slider_${name}`, [...lab.values]); });
    made.setAttribute("aria-pressed", lab.kind === `slider_${name}`);
    return made;
  });
  const sign_ = which => button(lab.branch.length > 1 ? `branch ${which + 1}` : "other branch", "the other branch of the same crank angle", () => {
    const branch = lab.branch.map((each, k) => k === which ? -each : each);
    if (!at_(lab.q, branch).closes) lab.said = "At this crank angle that branch does not close.";
    else {
      lab.branch = branch;
      lab.trail = [];
      resweep();
    }
    relabbed();
  });
  const printed = button("as printed", "the paper's crank of 202 mm, which cannot turn", () => {
    rememberLab();
    chooseKind("press", [0.202, ...lab.values.slice(1)]);
  });
  const python_ = element("pre", {tabindex: 0, "aria-label": "as Python"});
  const pythonBox_ = element("details", {}, element("summary", {}, "as Python"), python_);
  pythonBox_.ontoggle = () => { python_.textContent = linkagePython(); };
  byId("linkage-panel").replaceChildren(
    field_(`${title[0].toUpperCase()}${title.slice(1)}, lengths in mm`, ...(four ? [element("div", {class: "row"}, preset)] : []),
      ...(slider_ ? [element("div", {class: "row"}, element("span", {}, "held:"), ...held)] : []), ...rows),
    field_("Motion", element("div", {class: "row"}, run, sign_(0), ...(lab.branch.length > 1 ? [sign_(1)] : []),
      ...(four ? [button("hold the next link", "another link is fixed, the next one driven", () => {
        rememberLab();
        if (invert()) { buildBench(); relabbed(); }
      })] : []), ...(lab.kind === "press" ? [printed] : []),
      button("Clear trace", "clear the trace", () => { lab.trail = []; benchFrame(); }))),
    field_("Arrows", check("velocity of the point (dark)", arrows.velocity, on => { arrows.velocity = on; benchFrame(); }).label,
      check("its acceleration: tangential (yellow), normal (pink)", arrows.acceleration, on => { arrows.acceleration = on; benchFrame(); }).label),
    element("div", {class: "row"}, button("Undo", "undo (Ctrl Z)", undoLab),
      button("PNG", "save the linkage's picture as PNG", () => benchPicture(true)),
      button("SVG", "save the linkage's picture as SVG", () => benchPicture(false)),
      button("Copy link", "copy the link to this linkage", () => copy(location.href.split("#")[0] + linkageFragment(), "link"))),
    pythonBox_,
    element("details", {id: "linkage-help"}, element("summary", {}, "Pointer and keys"),
      "Drag to turn the crank" + (four ? "; drag the coupler point M to place it" : "") + ". ← → turn the crank, with Shift " +
      "finely; space runs and holds. Solid: the path of the traced point; dashed: on the other branch; dotted: before the " +
      "change. One turn a second, shown four times slower."));
}

function toggleRun() {
  lab.running = !lab.running;
  byId("run").textContent = lab.running ? "Hold" : "Run";
  benchBefore = performance.now();
  benchFrame();
}

function showLinkage(id) {
  if (!lab.values) {
    Object.assign(lab, {values: kinds.four.parameters.map(({value}) => value)});
    resweep();
  }
  const wantedKind = {four: "four", slider: "slider_guide", press: "press"}[id];
  if (wantedKind && !lab.kind.startsWith(wantedKind.split("_")[0])) chooseKind(wantedKind);
  else if (lab.values) { buildBench(); relabbed(); }
}
