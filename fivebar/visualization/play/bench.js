// The page of a linkage: the picture, its curves over the crank angle, and what is set.

const bench = new View(byId("bench")), plots = new View(byId("curves"));
const arrows = {velocity: true, acceleration: true};
const benchPace = speedChoice([0.1, 0.25, 0.5, 1], "speed of the motion", 0.25);
let benchBefore = 0;

function benchBounds() {
  const points = [];
  for (const sweep of [lab.sweep, lab.other])
    for (const row of sweep.rows) if (row) points.push(...row.points.filter((_, k) => wordsOf().pins.includes(k)));
  const xs = points.map(([x]) => x), ys = points.map(([, y]) => y);
  return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
}

// The arrows at a pose, in pixels from its traced point: [name, x, y to the right and down, colour].
function arrowsAt({velocity, acceleration, tangential}) {
  const room = 0.22 * Math.min(bench.width, bench.height), size = Math.hypot(...velocity);
  const along = velocity.map(x => size ? tangential * x / size : 0), across = acceleration.map((x, k) => x - along[k]);
  const [fastest, strongest] = lab.most;
  return [["velocity", velocity, "ink", fastest], ["acceleration", along, "c5", strongest],
    ["acceleration", across, "c4", strongest]].map(([name, [x, y], ink, most]) => {
    const scale = room / Math.max(most, Math.hypot(x, y));  // near a lock they grow without bound
    return [name, scale * x, -scale * y, ink];
  }).filter(([name, x, y]) => arrows[name] && Number.isFinite(x + y));
}

// The linkage on both branches, and its arrows, which are as long on the screen at any scale.
function fitBench() {
  bench.measure();
  plots.measure();
  const [x0, y0, x1, y1] = benchBounds(), rows = lab.sweep.rows.filter(Boolean), {traced} = wordsOf();
  bench.fit([x0, y0, x1, y1], 34);
  for (let pass = 0; pass < 3; pass++) {
    const tips = rows.flatMap(row => arrowsAt(row).map(([, right, down]) =>
      [row.points[traced][0] + right / bench.scale, row.points[traced][1] - down / bench.scale]));
    const [xs, ys] = [0, 1].map(k => tips.map(tip => tip[k]));
    bench.fit([Math.min(x0, ...xs), Math.min(y0, ...ys), Math.max(x1, ...xs), Math.max(y1, ...ys)], 34);
  }
}

const runsOf = (rows, place) => {
  const lines = [[]];
  for (const row of rows) if (row) lines[lines.length - 1].push(place(row));
    else if (lines[lines.length - 1].length) lines.push([]);
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
    pen.lines([[put_([x - far * ux, y - far * uy]), put_([x + far * ux, y + far * uy])]], {ink: "c3", width: 1.2,
      dash: [5, 4]});
  }
  if (lab.trail.length > 1) pen.lines([lab.trail.map(put_)], {ink: "c5", width: 2.4});
  const on = now.points.map(put_);
  for (const [i, j] of rails) pen.lines([[on[i], on[j]]], {ink: "line", width: 6});
  for (const k of grounded) if (pins.includes(k))
    pen.lines([[on[k], [on[k][0] - 9, on[k][1] + 15], [on[k][0] + 9, on[k][1] + 15]]], {ink: "quiet", fill: "line",
      closed: true});
  for (const [i, j] of blocks) pen.lines([[on[i], on[j]]], {ink: "quiet", width: 18});
  bars.forEach(([i, j], k) => drawBar(pen, [on[i], on[j]], content.links[lab.kind === "four" && k > 2 ? 1 : k % 4]));
  for (const k of pins) {
    pen.circle(on[k], actuated.includes(k) ? 8 : 6, k === traced ? {fill: "c4", ink: "ink", width: 2}
      : actuated.includes(k) ? {fill: "ink"} : {fill: "paper", ink: "ink", width: 2});
    pen.words(letters[k], [on[k][0] + 10, on[k][1] - 8], {size: 13});
  }
  const [x, y] = on[traced];
  for (const [, right, down, ink] of arrowsAt(now)) drawArrow(pen, [x, y], [x + right, y + down], ink, 2.6);
}

// Three plots over the crank angle, the cursor at the one at hand.
function drawCurves() {
  const pen = plots.front, {rows} = lab.sweep, {angle: turns, output} = wordsOf();
  plots.begin(pen);
  const panels = [
    {title: `${output} (${turns ? "deg" : "mm"})`, curves: [[row => row.output[0] * (turns ? 180 / Math.PI : 1e3),
      "c2", []]]},
    {title: "speed and accelerations (scaled)", range: [-1.2, 1.2], curves: [
      [row => Math.hypot(...row.velocity) / lab.most[0], "c2", []], [row => row.tangential / lab.most[1], "c5", [6, 3]],
      [row => row.normal / lab.most[1], "c4", [2, 3]]]},
    {title: "transmission angle (deg)", curves: [[row => row.transmission * 180 / Math.PI, "c3", []]], range: [0, 180]},
  ];
  const height = (plots.height - 14) / panels.length, left = 44, wide = plots.width - left - 8;
  panels.forEach(({title, curves, range}, n) => {
    const values = curves.flatMap(([of]) => rows.filter(Boolean).map(of)).filter(Number.isFinite);
    const [low, high] = range ?? [Math.min(...values), Math.max(...values)], span = high - low || 1;
    const top = n * height + 20, tall = height - 28, x = row => left + wide * (row.q + Math.PI) / TURN;
    pen.lines([[[left, top], [left + wide, top], [left + wide, top + tall], [left, top + tall]]],
      {ink: "line", width: 1, closed: true});
    pen.words(title, [left, top - 6], {size: 12});
    for (const [value, y] of [[high, top + 10], [low, top + tall]])
      pen.words(number(Math.abs(value) < 1e-3 * span ? 0 : value, 3), [left - 4, y], {ink: "quiet", size: 11,
        align: "right"});
    for (const [of, ink, dash_] of curves)
      for (const line of runsOf(rows, row => [x(row), top + tall - tall * Math.min(Math.max((of(row) - low) / span,
        -0.02), 1.02)]))
        pen.lines([line.filter(([, y]) => Number.isFinite(y))], {ink, width: 1.8, dash: dash_});
    const at = left + wide * (lab.q + Math.PI) / TURN;
    pen.lines([[[at, top], [at, top + tall]]], {ink: "ink", width: 1.5});
  });
  for (const [text, share, align] of [["−180°", 0, "left"], ["crank 0°", 0.5, "center"], ["180°", 1, "right"]])
    pen.words(text, [left + wide * share, plots.height - 5], {ink: "quiet", size: 11, align});
}

const benchFrame = oncePerFrame(() => {
  if (byId("linkage").hidden) return;
  const now = performance.now();
  if (lab.running) {
    const step = lab.way * lab.speed * Math.min(now - benchBefore, 40) / 1000 * +benchPace.value;
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
  const size = Math.max(...lab.values.map(Math.abs));
  const radiusText = x => x < 1e3 * size ? lengthText(x, 3) : `over ${lengthText(1e3 * size, 3)}: almost straight`;
  set("crank", deg(lab.q));
  set("output", `${output} ${turns ? deg(now.output[0]) : lengthText(zeroBelow(now.output[0], size))}`);
  set("rate of the output", turns ? `${number(zeroBelow(now.output[1], lab.speed), 3)} rad/s`
    : `${number(zeroBelow(now.output[1], lab.speed * size), 3)} m/s`);
  set("speed of the point", `${number(zeroBelow(Math.hypot(...now.velocity), lab.speed * size), 3)} m/s`);
  set("tangential acceleration", `${number(zeroBelow(now.tangential, lab.speed ** 2 * size), 3)} m/s²`);
  set("normal acceleration", `${number(zeroBelow(now.normal, lab.speed ** 2 * size), 3)} m/s²`);
  set("radius of curvature", radiusText(now.radius));
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
