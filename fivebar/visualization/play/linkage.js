// The linkage at hand: which, its lengths, branch and crank angle; what it can do, from its function swept over a turn.

const FUNCTIONS = {four, slider_guide, slider_crank, slider_rod, slider_slider, press};
const {kinds, straight} = content, SWEEP = 720;
const lab = {kind: "four", values: null, branch: [1], q: 0.6, speed: TURN, running: false, way: 1, trail: [], said: "",
  preset: "", sweep: null, ghost: null};
const wordsOf = () => kinds[lab.kind];
const at_ = (q, branch = lab.branch) => FUNCTIONS[lab.kind](q, lab.speed, branch, lab.values);
const deg = x => `${number(zeroBelow(x, 1) * 180 / Math.PI, 5)}°`;

// Row k of a sweep is at the crank angle -π + (k + 0.37) 2π / SWEEP, so that what is at a right angle is between two
// rows; null where it does not close.
function sweepOf(branch) {
  const rows = [], edges = [], ends = [], angleAt = k => -Math.PI + TURN * (k + 0.37) / SWEEP;
  const {angle: turns} = wordsOf(), still = 1e-9 * lab.speed * (turns ? 1 : Math.max(...lab.values.map(Math.abs)));
  let before = null;
  for (let k = 0; k <= SWEEP; k++) {
    const q = angleAt(k), found = at_(q, branch), row = found.closes ? {...found, q} : null;
    if (row && before && turns)  // a curve of the angle has no jump of a turn
      row.output[0] += TURN * Math.round((before.output[0] - row.output[0]) / TURN);
    if (k && Boolean(row) !== Boolean(before)) edges.push(edge(angleAt(k - 1), q, Boolean(before), branch));
    else if (row && before && row.output[1] * before.output[1] < 0 && Math.abs(row.output[1]) < 50 * lab.speed &&
      Math.min(Math.abs(row.output[1]), Math.abs(before.output[1])) > still)  // rounding has signs, too
      ends.push(turnOf(before, row, branch));
    rows.push(row);
    before = row;
  }
  const closing = rows.filter(Boolean), mean = closing.reduce((sum, {output}) => sum + output[0], 0) / closing.length;
  if (turns) for (const {output} of closing) output[0] -= TURN * Math.round(mean / TURN);
  return {rows, edges, ends, branch, full: rows.every(Boolean)};
}

// The crank angle at which it ceases to close, or begins to: by halving, to rounding.
function edge(low, high, closes, branch) {
  for (let k = 0; k < 60; k++) {
    const middle = (low + high) / 2;
    if (Boolean(at_(middle, branch).closes) === closes) low = middle; else high = middle;
  }
  return wrapped((low + high) / 2);
}

// A dead centre: where what the crank drives turns back.
function turnOf(a, b, branch) {
  let low = a.q, high = b.q;
  for (let k = 0; k < 60; k++) {
    const middle = (low + high) / 2;
    if (at_(middle, branch).output[1] * a.output[1] > 0) low = middle; else high = middle;
  }
  return {q: wrapped((low + high) / 2), output: at_((low + high) / 2, branch).output[0]};
}

// The least angle between the bars of the last dyad, folded below a right angle: at a minimum, or where the crank locks.
function leastTransmission({rows, edges, branch}) {
  const folded = ({transmission}) => Math.min(transmission, Math.PI - transmission), found = [], step = TURN / SWEEP;
  const at = q => { const row = at_(q, branch); return row.closes ? folded(row) : NaN; };
  // Beside a lock an angle is its last value and a root of the distance.
  for (const q of edges) for (const far of [-1e-10, 1e-10]) found.push(2 * at(q + far) - at(q + 4 * far));
  for (let k = 0; k < SWEEP; k++) {
    const [before, row, after_] = [k + SWEEP - 1, k, k + 1].map(each => rows[each % SWEEP]);
    if (!before || !row || !after_ || folded(row) > Math.min(folded(before), folded(after_))) continue;
    let low = row.q - step, high = row.q + step;
    for (let n = 0; n < 80; n++) {
      const third = (high - low) / 3;
      if (at(low + third) < at(high - third)) high -= third; else low += third;
    }
    found.push(at((low + high) / 2));
  }
  return Math.max(Math.min(...found.filter(Number.isFinite)), 0);
}

function resweep() {
  lab.sweep = sweepOf(lab.branch);
  lab.sweep.least = leastTransmission(lab.sweep);
  lab.other = sweepOf(wordsOf().branches === 1 ? [-lab.branch[0]] : [-lab.branch[0], lab.branch[1]]);
}

const GRASHOF = {ground: "double-crank (drag link)", crank: "crank-rocker", coupler: "Grashof double-rocker",
  rocker: "rocker-crank"};

// The verdict in words, line by line.
function verdictLines() {
  const lines = [], {edges, ends, full, least} = lab.sweep;
  if (lab.kind === "four" || lab.kind === "press") {
    const sides = lab.kind === "four" ? lab.values.slice(0, 4) : [lab.values[4], ...lab.values.slice(0, 3)];
    const [s, a, b, l] = [...sides].sort((x, y) => x - y), excess = l - b - (a - s), tiny = 8 * EPSILON * (s + a + b +
      l);
    const kind = excess > tiny ? "non-Grashof triple-rocker" : excess >= -tiny ? "change point"
      : GRASHOF[Object.keys(GRASHOF)[sides.indexOf(s)]];
    lines.push(`${sentence(kind)}: shortest + longest is ${Math.abs(excess) <= tiny ? "equal to" : `${lengthText(Math.abs(excess))} ` +
      `${excess > 0 ? "more" : "less"} than`} the two others together, so ${excess > tiny ? "no link"
        : "one link"} can turn fully.`);
  } else {
    const [s, a, l] = lab.values.map(Math.abs).sort((x, y) => x - y);
    if (l - a - s <= 8 * EPSILON * (a + l))
      lines.push("Change point: of crank, rod and offset the longest is equal to the two others together, " +
        "so it can pass to the other branch.");
  }
  if (full) lines.push("The crank turns through full turns.");
  else if (!edges.length) lines.push("On this branch the crank closes at no angle.");
  else lines.push(`The crank locks at ${edges.map(deg).join(", ")}.`);
  const value = x => wordsOf().angle ? deg(x) : lengthText(x), out = wordsOf().output;
  for (const end of ends) lines.push(`Dead centre: ${out} at ${value(end.output)}, crank at ${deg(end.q)}.`);
  if (full && ends.length === 2) {
    const stroke = ((ends[1].q - ends[0].q) % TURN + TURN) % TURN, slow = Math.max(stroke, TURN - stroke);
    const reach = Math.abs(wordsOf().angle ? wrapped(ends[1].output - ends[0].output)
      : ends[1].output - ends[0].output);
    lines.push(`The ${out} ${wordsOf().angle ? "swings" : "goes"} by ${value(reach)}, ` +
      `time ratio ${number(slow / (TURN - slow), 5)}.`);
  }
  if (Number.isFinite(least)) lines.push(`Transmission angle down to ${deg(least)}.`);
  const line = straightWords();
  return line ? [...lines, line] : lines;
}

// How straight the coupler point of the straight-line mechanism goes over its usual stroke, as it is now.
function straightWords() {
  const preset = straight[lab.preset];
  if (!preset || lab.kind !== "four") return "";
  const {through: [x0, y0], direction: [ux, uy], stroke: [from, to]} = preset, along = [], across = [];
  for (let k = 0; k <= 400; k++) {
    const found = at_(from + (to - from) * k / 400);
    if (!found.closes) continue;
    const [x, y] = found.points[wordsOf().traced];
    along.push((x - x0) * ux + (y - y0) * uy);
    across.push((y - y0) * ux - (x - x0) * uy);
  }
  if (along.length < 300) return "";
  const span = values => Math.max(...values) - Math.min(...values), stroke = span(along), band = span(across);
  return `Straight over ${lengthText(stroke)}: a band of ${lengthText(band)}, ${number(100 * band / stroke, 3)} % of the stroke.`;
}

// Turn the crank towards an angle, the short way; it stops where it locks.
function turnCrank(target) {
  lab.said = "";
  const way = wrapped(target - lab.q), count = Math.max(1, Math.ceil(Math.abs(way) / 0.01)), step = way / count;
  for (let k = 0; k < count; k++)
    if (!stepCrank(step)) {
      lab.said = `The crank locks at ${deg(lab.q)}: bars come in line.`;
      return false;
    }
  return true;
}

function stepCrank(step) {
  const next = wrapped(lab.q + step);
  if (!at_(next).closes) {
    const last = edge(lab.q, lab.q + step, true, lab.branch), inside = wrapped(last - Math.sign(step) * 1e-9);
    if (at_(inside).closes) lab.q = inside;
    return false;
  }
  lab.q = next;
  const point = at_(lab.q).points[wordsOf().traced];
  lab.trail.push(point);
  if (lab.trail.length > 4000) lab.trail.splice(0, 1000);
  return true;
}

// Other lengths: taken where some crank angle closes, and the crank goes to the nearest one that does.
function refit(values) {
  const before = lab.values;
  lab.values = values;
  resweep();
  if (!lab.sweep.rows.some(Boolean)) {
    lab.values = before;
    resweep();
    lab.said = "With these lengths it closes at no crank angle on this branch: kept as it was.";
    return false;
  }
  lab.said = "";
  lab.trail = [];
  if (!at_(lab.q).closes)
    lab.q = lab.sweep.rows.filter(Boolean).reduce((best, row) =>
      Math.abs(wrapped(row.q - lab.q)) < Math.abs(wrapped(best.q - lab.q)) ? row : best).q;
  return true;
}

// The same four bars with another one held; the next one is driven.
function invert() {
  const [g, a, b, c] = lab.values;  // what was the rocker is the coupler then
  lab.preset = "";
  return refit([a, b, c, g, c / 2, 0]) && (lab.said = "Fixed now: what was the crank; driven: what was the coupler.");
}

const CLOSED_NUMBERS = /^-?\d{1,7}(\.\d{1,25})?(e-?\d{1,2})?(,-?\d{1,7}(\.\d{1,25})?(e-?\d{1,2})?){0,7}$/;

function linkageFragment() {
  return `#linkage=${lab.kind}&values=${lab.values.map(plain).join(",")}` +
    `&branch=${lab.branch.map(each => each > 0 ? "+" : "-").join("")}&crank=${plain(lab.q)}`;
}

// {state} or {words} of an address that is a linkage's; null for others.
function readLinkage(text) {
  if (!text.startsWith("#linkage=")) return null;
  if (text.length > 500) return {words: "it is longer than any link that this page writes"};
  const pairs = text.slice(1).split("&").map(pair => pair.split("="));
  if (pairs.map(([key]) => key).join() !== "linkage,values,branch,crank" || pairs.some(pair => pair.length !== 2))
    return {words: "it is not linkage=…&values=…&branch=…&crank=…"};
  const [kind, values, branch, crank] = pairs.map(([, value]) => value);
  if (!Object.hasOwn(kinds, kind)) return {words: "no linkage is called so"};
  if (!CLOSED_NUMBERS.test(values) || !NUMBER.test(crank)) return {words: "its values are no numbers"};
  const numbers = values.split(",").map(Number), {parameters, branches} = kinds[kind];
  if (numbers.length !== parameters.length || !/^[+-]{1,2}$/.test(branch) || branch.length !== branches)
    return {words: "it has too many numbers or signs, or too few"};
  const wrong = parameters.find(({signed}, k) => !(Math.abs(numbers[k]) <= 10) || (!signed && !(numbers[k] >= 0.001)));
  if (wrong) return {words: `${wrong.name} is not between ${wrong.signed ? -10 : 0.001} and 10 m`};
  return {state: {kind, values: numbers, branch: [...branch].map(each => each === "+" ? 1 : -1), q: Number(crank)}};
}
