// The robot at hand, its pose, and how it is moved: by the end-effector, by an elbow, by both motors. A move goes in
// small steps and stops, or slides along, where the robot cannot follow; `said` tells why.

const LENGTHS = ["l11", "l12", "l21", "l22", "d"];
const LIMITS = {length: [0.005, 10], d: [0, 20], tool: [-10, 10]};  // m
const robot = {...content.robot};  // all parameters by name; gravity: [x, y]
let p = lengths();
let modes = [...content.working], pose = igm(content.xi, modes, p);
let said = "", touching = -1, noted = {words: "", until: 0};  // said now; said for some seconds
const choices = {type1: false, type2: false};  // whether Type 1 changes the mode, whether Type 2 is passed

function lengths(of = robot) { return LENGTHS.map(name => of[name]); }
// Where a tool on the distal bar of leg 1 or 2 is, `along` the bar from the joint and `across` to its left; the
// end-effector without one.
function tipOf({xi, elbows}) {
  const {leg, along, across} = robot;
  if (!leg) return xi;
  const [x, y] = elbows[leg - 1], size = Math.hypot(xi[0] - x, xi[1] - y), ux = (xi[0] - x) / size, uy = (xi[1] - y) / size;
  return [xi[0] + along * ux - across * uy, xi[1] + along * uy + across * ux];
}
const sizeOf = (l = p) => l[0] + l[1] + l[2] + l[3] + l[4];

// Numbers as text: rounding errors are 0, units go by size.
const zeroBelow = (x, scale) => Math.abs(x) < SAME * scale ? 0 : x;
const number = (x, digits = 4) => String(+x.toPrecision(digits)).replaceAll("-", "−");
const inUnits = (zero, ...units) => (x, digits = 4) => {
  const [unit, factor] = units.find(([, , least]) => Math.abs(x) >= least) ?? [];
  return unit ? `${number(x / factor, digits)} ${unit}` : zero;
};
const lengthText = inUnits("0 mm", ["km", 1e3, 1e3], ["m", 1, 10], ["mm", 1e-3, 1e-3], ["µm", 1e-6, 1e-12]);
const areaText = inUnits("0 cm²", ["m²", 1, 1], ["cm²", 1e-4, 1e-4], ["mm²", 1e-6, 1e-12]);
const energyText = inUnits("0 mJ", ["J", 1, 1], ["mJ", 1e-3, 1e-3], ["µJ", 1e-6, 1e-9]);
const angleText = x => `${number(zeroBelow(x, 1) * 180 / Math.PI)}°`;
const decimals = (x, count) => String(+x.toFixed(count)).replaceAll("-", "−");
const sign = x => x > 0 ? "+1" : x < 0 ? "−1" : "0";

// By how much a closed chain of these lengths cannot close, and why; "" where it can.
function openWords(l) {
  const names = ["l11", "l12", "l21", "l22", "d"], longest = l.indexOf(Math.max(...l));
  const rest = l.reduce((sum, x) => sum + x, 0) - l[longest];
  return l[longest] <= rest ? "" : `These bars can never close: ${names[longest]} is ${lengthText(l[longest] - rest)} longer ` +
    "than all others together.";
}

function legWords(k, clear) {
  return `the ${k ? "right" : "left"} leg is ${clear[2 * k] <= clear[2 * k + 1] ? "stretched" : "folded"}`;
}

function note(passed) {
  if (passed.length) noted = {words: passed.join(" "), until: performance.now() + 5000};
}

// What keeps the end-effector from a point in these modes: {kind: "reach", leg} or {kind: "type 2"}; null: nothing.
function hindrance(found, assembly) {
  if (!found.closes) {
    const worst = found.clear.indexOf(Math.min(...found.clear));
    const isBoth = Math.max(found.clear[0], found.clear[2]) <= 0;
    return {kind: "reach", leg: worst >> 1, words: isBoth ? "both legs are stretched" : legWords(worst >> 1, found.clear)};
  }
  if (!choices.type2 && assembly && found.assembly !== assembly) return {kind: "type 2"};
  return null;
}

// How far a point is on the allowed side of a hindrance, to be slid along.
function allowance(point, kind, assembly) {
  const found = igm(point, modes, p);
  return kind === "reach" ? -found.gap : -assembly * found.parallel;
}

function gradient(point, kind, assembly, h) {
  const at = (dx, dy) => allowance([point[0] + dx, point[1] + dy], kind, assembly);
  const here = at(0, 0), slope = (plus, minus) => Number.isFinite(plus) && Number.isFinite(minus)
    ? (plus - minus) / (2 * h)
    : Number.isFinite(plus) ? (plus - here) / h : (here - minus) / h;
  return [slope(at(h, 0), at(-h, 0)), slope(at(0, h), at(0, -h))];
}

// Move the end-effector towards a point, in steps of at most `step` m.
function moveTo(target, step) {
  said = "";
  const distance = Math.hypot(target[0] - pose.xi[0], target[1] - pose.xi[1]);
  if (!(distance > 0) || !Number.isFinite(distance)) return;
  const count = Math.min(600, Math.max(1, Math.ceil(distance / step)));
  const passed = [];
  for (let k = 0; k < count; k++) {
    const share = 1 / (count - k), delta = [0, 1].map(i => (target[i] - pose.xi[i]) * share);
    if (!advance(delta, passed)) break;
  }
  note(passed);
}

// One small step of the end-effector; whether anything moved.
function advance(delta, passed) {
  const assembly = pose.assembly, from = pose.xi, to = [from[0] + delta[0], from[1] + delta[1]];
  const next = igm(to, modes, p);
  if (!hindrance(next, assembly)) {
    if (next.assembly && assembly && next.assembly !== assembly)
      passed.push("Passed Type 2: for a moment no motor held the end-effector; assembly mode now " +
        `${sign(next.assembly)}.`);
    take(next);
    if (touching >= 0 && next.clear[2 * touching] > 2e-3 * sizeOf() && next.clear[2 * touching + 1] > 2e-3 * sizeOf())
      touching = -1;
    return true;
  }
  const {share, held} = stopAt(from, delta, assembly), rest = delta.map(x => x * (1 - share));
  if (held.kind === "reach" && choices.type1 && touching !== held.leg) {
    touching = held.leg;
    const other = modes.map((mode, k) => k === held.leg ? -mode : mode), flipped = igm(pose.xi, other, p);
    if (flipped.closes) {
      modes = other;
      take(flipped);
      passed.push(`Type 1: ${held.words}; its working mode is now ${sign(modes[held.leg])}.`);
    }
  }
  said = held.kind === "reach" ? `Stopped at the border (Type 1): ${held.words}.`
    : "Stopped at Type 2: the distal bars are parallel, and the motors cannot hold the end-effector there.";
  return slide(pose.xi, rest, held.kind, assembly) || share > 1e-3;
}

function slide(from, delta, kind, assembly) {
  const h = 1e-6 * sizeOf(), [gx, gy] = gradient(from, kind, assembly, h), size = Math.hypot(gx, gy);
  if (size > 0 && Number.isFinite(size)) {
    const n = [gx / size, gy / size], across = n[0] * delta[0] + n[1] * delta[1];
    let to = [from[0] + delta[0] - across * n[0], from[1] + delta[1] - across * n[1]];
    const floor = kind === "reach" ? 1e-7 * sizeOf() : 1e-6;
    for (let k = 0; k < 4; k++) {
      const room = allowance(to, kind, assembly);
      if (room >= floor || !Number.isFinite(room)) break;
      to = [to[0] + n[0] * (1.5 * floor - room) / size, to[1] + n[1] * (1.5 * floor - room) / size];
    }
    const next = igm(to, modes, p), gain = Math.hypot(to[0] - from[0], to[1] - from[1]);
    if (!hindrance(next, assembly) && gain > 1e-9 * sizeOf() && gain < 3 * Math.hypot(...delta)) {
      take(next);
      return true;
    }
  }
  return false;
}

// As far along delta as there is nothing in the way: which share of it that is, and what holds it there, which at the
// end of delta may be something else.
function stopAt(from, delta, assembly) {
  const at = share => igm([from[0] + share * delta[0], from[1] + share * delta[1]], modes, p);
  let low = 0, high = 1, held = hindrance(at(1), assembly);
  for (let k = 0; k < 30; k++) {
    const middle = (low + high) / 2, met = hindrance(at(middle), assembly);
    if (met) [high, held] = [middle, met]; else low = middle;
  }
  if (low > 0) take(at(low));
  return {share: low, held};
}

function take(found) {
  if (!found.closes) return false;
  pose = found;
  return true;
}

const wrapped = angle => angle - TURN * Math.ceil(angle / TURN - 0.5);

// Turn the motors towards two angles, in steps of at most 0.01 rad; one stops, the other may go on.
function turnTowards(target) {
  said = "";
  const assembly = pose.assembly || -1, left = target.map((angle, k) => wrapped(angle - pose.q[k]));
  const count = Math.min(1000, Math.max(1, Math.ceil(Math.max(...left.map(Math.abs)) / 0.01)));
  const passed = [];
  for (let n = 0; n < count; n++) {
    const delta = target.map((angle, k) => wrapped(angle - pose.q[k]) / (count - n));
    if (!turned(delta, assembly, passed) && !turned([delta[0], 0], assembly, passed) &&
      !turned([0, delta[1]], assembly, passed)) break;
  }
  note(passed);
}

function turned(delta, assembly, passed) {
  if (!delta[0] && !delta[1]) return false;
  const next = dgm(pose.q.map((q, k) => wrapped(q + delta[k])), assembly, p);
  if (!next.closes) {
    said = "Stopped at Type 2: the elbows are as far apart, or as near, as the distal bars allow.";
    return false;
  }
  const changed = next.working.findIndex((mode, k) => mode && mode !== modes[k]);
  if (changed >= 0 && !choices.type1) {
    said = `Stopped at Type 1: the ${changed ? "right" : "left"} leg is in line; beyond, its working mode changes.`;
    return false;
  }
  if (changed >= 0) passed.push(`Type 1 passed: working modes now ${next.working.map(sign).join(", ")}.`);
  modes = next.working.map((mode, k) => mode || modes[k]);
  pose = {...next, clear: igm(next.xi, modes, p).clear};
  return true;
}

// Other lengths: the pose stays where it is if it closes, else it goes to the nearest point that does.
function reshape(next) {
  const words = openWords(next);
  if (words) {
    said = words;
    return false;
  }
  const before = p, from = pose.xi;
  p = next;
  let found = igm(from, modes, p);
  if (!found.closes) {
    const near = nearestReached(from);
    if (!near) {
      p = before;
      said = "With these lengths no point is reached in this working mode: kept as it was.";
      return false;
    }
    found = igm(near, modes, p);
  }
  LENGTHS.forEach((name, k) => { robot[name] = p[k]; });
  take(found);
  return true;
}

// The nearest point that both legs reach: onto each ring in turn, or else the border.
function nearestReached(from) {
  let [x, y] = from;
  const rings = [[-p[4] / 2, p[0], p[1]], [p[4] / 2, p[2], p[3]]], inset = 1e-6 * sizeOf();
  for (let k = 0; k < 60; k++) {
    for (const [cx, a, b] of rings) {
      const dx = x - cx, dy = y, r = Math.hypot(dx, dy) || 1e-12;
      const to = Math.min(Math.max(r, Math.abs(a - b) + inset), a + b - inset);
      [x, y] = [cx + (r < 1e-11 ? 0 : dx) * to / r, r < 1e-11 ? to : dy * to / r];
    }
    if (igm([x, y], modes, p).closes) return [x, y];
  }
  // Thin rings: the border itself, a hair's breadth inside or outside of it.
  const border = arcsOf(p).flatMap(({x: cx, radius, from: first, to: last}) => Array.from({length: 65}, (_, k) => {
    const angle = first + (last - first) * k / 64;
    return [cx, radius, Math.cos(angle), Math.sin(angle)];
  }));
  const far = ([cx, r, c, s]) => (cx + r * c - from[0]) ** 2 + (r * s - from[1]) ** 2;
  for (const [cx, radius, c, s] of border.sort((a, b) => far(a) - far(b)))
    for (const r of [radius - inset, radius + inset, radius]) {
      const to = [cx + r * c, r * s];
      if (igm(to, modes, p).closes) return to;
    }
  return null;
}

// The same point in other working modes, or the same motors in the other assembly mode; whether there is such a pose.
function toModes(next) {
  const found = igm(pose.xi, next, p);
  if (!found.closes) {
    said = "This point is not reached in those modes.";
    return false;
  }
  modes = [...next];
  touching = -1;
  said = "";
  return take(found);
}

function toAssembly(mode) {
  const found = dgm(pose.q, mode, p);
  if (!found.closes) {
    said = "With the motors there, no other assembly closes.";
    return false;
  }
  modes = found.working.map((each, k) => each || modes[k]);
  said = "";
  return take(igm(found.xi, modes, p)) || take({...found, clear: pose.clear});
}
