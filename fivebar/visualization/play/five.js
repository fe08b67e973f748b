// The page of the five-bar: what is changed when, what is drawn then, and what it says.

const force = {angle: Math.PI / 2}, past = [];
let wanted = content.wanted, wantsDisc = false;  // radius of a disc, m, and whether it is to be checked
let dirty = {back: true, joints: true, front: true}, timer = 0, flying = null, lastWords = 0;
const costs = new Float64Array(4096);  // ms of the last frames' drawing, for benchmarks
let costCount = 0;

const frame = oncePerFrame(() => {
  const begun = performance.now();
  if (flying) fly(begun);
  if (idle) idleOn(begun);
  const {back, joints: jointsToo} = dirty;
  dirty = {back: false, joints: false, front: false};
  if (back) drawTaskBack();
  if (back || jointsToo) drawJointsBack();
  drawTaskFront();
  drawJointsFront();
  words(begun);
  costs[costCount++ % costs.length] = performance.now() - begun;
  if (flying || idle) frame();
});

function ask(parts = {}) {
  Object.assign(dirty, parts);
  frame();
}

// After a change of lengths or modes: coarse at once, fine when it rests.
function reshaped() {
  if (sketch.length) checkSketch();
  survey(false);
  const [x0, y0, x1, y1] = boundsOf(p), [a0, b0, a1, b1] = task.bounds, wide = x1 - x0, seen = a1 - a0;
  if (x0 < a0 || y0 < b0 || x1 > a1 || y1 > b1 || wide < 0.45 * seen) task.fit([x0, y0, x1, y1].map(x => 1.15 * x));
  ask({back: true});
  settle();
}

function settle() {
  clearTimeout(timer);
  timer = setTimeout(() => {
    if (!flying) fit();
    survey(true);
    ask({back: true});
    if (!flying) keepFragment();
  }, 160);
}

const MOST_TRACED = 20000;
let modesDrawn = "";
function moved() {  // after the pose changed
  const now = modes.join();
  if (now !== modesDrawn) {
    parts = regionsOf(loci, p, modes);
    showModes();
    if (sketch.length) checkSketch();
    modesDrawn = now;
    aspect = null;
  }
  const region = aspectAt(pose.xi, -pose.assembly);
  if (region !== aspect || (!disc && !flying)) {
    if (flying) [aspect, disc] = [region, null];
    else shade(region);
    ask({back: true, joints: true});
  }
  if (!flying) motion = null;
  leaveTrace();
  ask({front: true});
  if (!flying && !idle) keepFragment();
}

function leaveTrace(t = flying ? motion.t : performance.now() / 1000) {
  const last = trail[trail.length - 1], least = 0.5 / task.scale;
  if (last && Math.hypot(last.xi[0] - pose.xi[0], last.xi[1] - pose.xi[1]) < least) return;
  trail.push({t, xi: [...pose.xi], q: [...pose.q], tip: [...tipOf(pose)]});
  if (trail.length > MOST_TRACED) trail.splice(0, MOST_TRACED / 4);
}

let fragmentTimer = 0;
function keepFragment() {  // browsers allow some hundred changes a minute
  clearTimeout(fragmentTimer);
  fragmentTimer = setTimeout(() => {
    try { history.replaceState(null, "", writeFragment()); } catch { /* in a notebook's frame there is no address */ }
  }, 300);
}

const snapshot = () => JSON.stringify({robot, modes, xi: pose.xi, name: presetName});

function remember() {
  const now = snapshot();
  if (past[past.length - 1] !== now) past.push(now);
  if (past.length > 200) past.shift();
}

function undo() {
  halt();
  const now = snapshot();
  while (past.length && past[past.length - 1] === now) past.pop();
  if (!past.length) {
    said = "Nothing to undo.";
    return ask();
  }
  restore(JSON.parse(past.pop()));
}

function restore(state) {
  Object.assign(robot, state.robot);
  p = lengths();
  modes = [...state.modes];
  take(igm(state.xi, modes, p));
  trail = [];
  said = "";
  namePreset(state.name ?? "");
  showSliders();
  reshaped();
  moved();
}

// Words ---------------------------------------------------------------------------------------------------------------

const pointText = point => `(${point.map(x => number(1e3 * zeroBelow(x, sizeOf()))).join(", ")}) mm`;
const countText = count => count === 1 ? "once" : `${count} times`;

function stateWords(now) {
  if (motion && flying) return `Moving by itself, ${motion.t.toFixed(1)} s.` +
    (motion.crossings ? ` Crossed Type 2 ${countText(motion.crossings)}.` : "") +
    (flying.worker ? "" : " This browser starts no worker here: the page computes the motion itself.");
  const brief = noted.until > now && noted.words;
  return said || brief || checked?.words || `End-effector at ${pointText(pose.xi)}, working mode ` +
    `${modes.map(sign).join(", ")}, assembly mode ${sign(pose.assembly)}.`;
}

const radiusText = (digits = 4) => disc.fine ? lengthText(disc.radius, digits) : `≈ ${lengthText(disc.radius, 3)}`;

function verdictWords() {
  if (flying) return "";
  if (loci.everywhere && modes[0] === modes[1])
    return "Every pose of this working mode is Type 2: both legs coincide. Choose another mode.";
  if (!parts.regions.length) return "These bars close in single points only: the workspace has no area.";
  if (!disc) return "The robot is at a singularity: move it away to see its aspect.";
  if (!wantsDisc) return `The largest disc free of singularities in this aspect has a radius of ${radiusText()}.`;
  const fits = disc.radius >= wanted * (1 - 1e-9);
  // As many digits as tell the two radii apart.
  const digits = [4, 5, 6, 7].find(count => lengthText(wanted, count) !== lengthText(disc.radius, count)) ?? 4;
  return `${fits ? "✓" : "✗"} A disc of radius ${lengthText(wanted, digits)} ${fits ? "fits" : "does not fit"} in ` +
    `this aspect: the largest free of singularities has ${radiusText(digits)}.`;
}

function words(now) {
  guideOn();
  if (now - lastWords <= 90 && (flying || pointer || idle)) return ask();  // all at once, or they would differ
  lastWords = now;
  const line = byId("said"), state = stateWords(now), verdict = byId("verdict"), text = verdictWords();
  if (line.textContent !== state) line.textContent = state;
  line.classList.toggle("warned", Boolean(said));
  if (verdict.textContent !== text) verdict.textContent = text;
  showNumbers();
  if (equationsBox.open) showEquations();
  if (!flying && !idle) announce(() => `${state} ${text}`);
}

const rowsOfNumbers = new Map();
function put(name, value) {
  if (!rowsOfNumbers.has(name)) {
    const row = [element("dt", {}, name), element("dd")];
    byId("numbers").append(...row);
    rowsOfNumbers.set(name, row);
  }
  const row = rowsOfNumbers.get(name);
  for (const part of row) part.hidden = !value;
  if (row[1].textContent !== value) row[1].textContent = value;
}

// Least and largest singular value of J: the end-effector's speeds at unit speed of the motors together.
function speedsOf([[a, b], [c, d]]) {
  const sum = a * a + b * b + c * c + d * d, det = Math.abs(a * d - b * c);
  const large = Math.sqrt((sum + Math.sqrt(Math.max(sum * sum - 4 * det * det, 0))) / 2);
  return [large ? det / large : 0, large];
}

function showNumbers() {
  const size = sizeOf(), {J, torque} = gains(pose.xi, modes, [Math.cos(force.angle), Math.sin(force.angle)], p);
  const singular = Math.abs(pose.parallel) < 5e-5;  // its four decimals are 0
  const torqueText = values => !singular && values.every(Number.isFinite)
    ? `${values.map(x => number(zeroBelow(x, size), 3)).join(", ")} N m` : "∞: Type 2";
  const [slow, fast] = speedsOf(J).map(x => zeroBelow(x, size));
  put("x, y", `${pose.xi.map(x => number(1e3 * zeroBelow(x, size))).join(", ")} mm`);
  put("q1, q2", pose.q.map(angleText).join(", "));
  put("sin q12, sin q22 (0: Type 1)", pose.serial.map(x => decimals(x, 4)).join(", "));
  put("det A (0: Type 2)", decimals(pose.parallel, 4));
  put("transmission angle", `${decimals(pose.transmission * 180 / Math.PI, 2)}°`);
  put("area of the workspace", areaText(parts.regions.reduce((sum, region) => sum + region.area, 0), 3));
  put("area of this aspect", aspect ? areaText(aspect.area, 3) : "none: at a singularity");
  put("speed at motor speed 1 rad/s", !singular && Number.isFinite(fast) ? `${number(slow, 3)} to ${number(fast, 3)} m/s`
    : "∞: Type 2");
  put("motor torques for a force of 1 N", torqueText(torque));
  put("motor torques against gravity", robot.gravity.some(Boolean) && (robot.m || isHeavy())
    ? torqueText(holding(pose.xi, modes, allParameters()).torque) : "");
  const now = motion && totalEnergy();
  put("kinetic energy", now ? energyText(now.kinetic, 3) : "");
  put("potential energy", now && robot.gravity.some(Boolean) ? energyText(now.potential, 3) : "");
  put("energy change since Let go", now ? energyText(now.total - motion.first.total, 3) : "");
}

// Let go --------------------------------------------------------------------------------------------------------------

function release(velocity = [0, 0]) {
  const reason = noMotionWords();
  if (reason) {
    said = reason;
    return ask();
  }
  remember();
  said = "";
  trail = [];
  const tau = torqueKind.value === "none" ? [0, 0] : torqueInputs.map(input => +input.value || 0);
  letGo(velocity, {tau, wave: torqueKind.value === "wave"}, friction.input.checked ? addedFriction() : 0);
  flying = {before: performance.now(), asked: false, worker: startWorker()};
  showFlying();
  frame();
}

function showFlying() {
  goButton.textContent = flying ? "Pause" : "Let go";
  goButton.setAttribute("aria-label", flying ? "Pause the motion (key G)"
    : "Let go: the robot moves by itself (key G)");
}

function halt(why = "") {
  if (!flying) return;
  flying.worker?.terminate();
  flying = null;
  showFlying();
  if (!take(igm(pose.xi, modes, p))) take({...pose, closes: 1});
  shade(aspectAt(pose.xi, -pose.assembly));
  said = why;
  settle();
}

const LONGEST_WAIT = 1;  // s: a page that slept longer goes on where it was

function fly(now) {
  if (flying.asked) return;  // the next request asks for all the time since
  const duration = Math.min(Math.max(now - flying.before, 0) / 1000, LONGEST_WAIT) * +paceInput.value;
  flying.before = now;
  if (!duration) return;
  flying.asked = true;
  if (flying.worker) flying.worker.postMessage({motion, duration}); else flown(integrate({motion, duration}));
}

function flown({motion: now, path, followed}) {
  flying.asked = false;
  motion = now;
  for (const seen of path) {
    pose = poseOfMotion(seen);
    leaveTrace(seen.t);
  }
  moved();
  if (!followed) halt("The motion became too fast to be followed: it is paused here.");
}

let workerAddress = "";  // one for all motions of the page

// A worker that integrates, from the page's own text; null where the browser starts none.
function startWorker() {
  workerAddress ||= URL.createObjectURL(new Blob([byId("models").textContent], {type: "text/javascript"}));
  try {
    const worker = new Worker(workerAddress), isCurrent = () => flying?.worker === worker;
    worker.onmessage = ({data}) => { if (isCurrent()) flown(data); };
    worker.onerror = () => { if (isCurrent()) Object.assign(flying, {worker: null, asked: false}); };
    return worker;
  } catch {
    return null;
  }
}
