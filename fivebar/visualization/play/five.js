// The page of the five-bar: what is changed when, what is drawn then, and what it says.

const force = {angle: Math.PI / 2}, past = [];
let wanted = content.wanted, dirty = {back: true, joints: true, front: true}, timer = 0, flying = null, lastNumbers = 0;
const byId = id => document.getElementById(id);
const costs = new Float64Array(4096);  // ms of the last frames' drawing, for benchmarks
let costCount = 0;

const frame = oncePerFrame(() => {
  const begun = performance.now();
  if (flying) fly(begun);
  const {back, joints: jointsToo} = dirty;
  dirty = {back: false, joints: false, front: false};
  if (back) drawTaskBack();
  if (back || jointsToo) drawJointsBack();
  drawTaskFront();
  drawJointsFront();
  words(begun);
  costs[costCount++ % costs.length] = performance.now() - begun;
  if (flying) frame();
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

let modesDrawn = "";
function moved() {  // after the pose changed
  const now = modes.join();
  if (now !== modesDrawn) {
    if (modesDrawn) {
      resurvey(!flying);
      if (sketch.length) checkSketch();
      ask({back: true, joints: true});
    }
    modesDrawn = now;
  } else if (pose.assembly && (field.wanted !== -pose.assembly ||
    (!inPart(pose.xi) && field.sign[pixelAt(field, pose.xi)] === field.wanted))) {
    repart();
    ask({back: true, joints: true});
  }
  if (trail.length === 0 || Math.hypot(...trail[trail.length - 1].xi.map((x, k) =>
    x - pose.xi[k])) > 0.5 / task.scale) {
    trail.push({xi: [...pose.xi], q: [...pose.q]});
    if (trail.length > 3000) trail.splice(0, 500);
  }
  ask({front: true});
  if (!flying) keepFragment();
}

let fragmentTimer = 0;
function keepFragment() {  // browsers allow some hundred changes a minute
  clearTimeout(fragmentTimer);
  fragmentTimer = setTimeout(() => {
    try { history.replaceState(null, "", writeFragment()); } catch { /* in a notebook's frame there is no address */ }
  }, 300);
}

function snapshot() {
  return JSON.stringify({robot, modes, xi: pose.xi});
}

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
  showSliders();
  reshaped();
  moved();
}

// Words ---------------------------------------------------------------------------------------------------------------

const degrees = x => `${number(x * 180 / Math.PI)}°`;
const area = x => `≈ ${number(1e4 * x, 3)} cm²`;

function words(now) {
  const line = byId("said"), state = motion && flying
    ? `Moving by itself, ${number(motion.t, 3)} s.` +
      (motion.crossings ? ` Crossed Type 2 ${motion.crossings} times.` : "")
    : said || (noted.until > now && noted.words) || checked?.words ||
      `End-effector at (${number(1e3 * pose.xi[0])}, ${number(1e3 * pose.xi[1])}) mm, working mode ` +
      `${modes.map(sign).join(", ")}, assembly mode ${sign(pose.assembly)}.`;
  if (line.textContent !== state) line.textContent = state;
  line.classList.toggle("warned", Boolean(said));
  const verdict = byId("verdict"), radius = disc?.radius ?? 0, most = `${mm(+radius.toPrecision(3))}`;
  const text = loci.everywhere && modes[0] === modes[1]
    ? "Every pose of this working mode is Type 2: both legs coincide. Choose another mode."
    : !disc ? "The robot is at a singularity: move it off, to see its aspect."
      : radius >= wanted ? `✓ A disc of ${mm(wanted)} fits here, free of singularities: the largest has ≈ ${most}.`
        : `✗ A disc of ${mm(wanted)} does not fit here: the largest free of singularities has ≈ ${most}.`;
  if (verdict.textContent !== text) verdict.textContent = text;
  if (now - lastNumbers > 90 || !flying && !pointer) {
    lastNumbers = now;
    numbers_();
  }
  if (!flying) announce(() => `${state} ${text}`);
}

const rowsOfNumbers = new Map();
function put(name, value) {
  if (!rowsOfNumbers.has(name)) {
    const cell = element("dd");
    byId("numbers").append(element("dt", {}, name), cell);
    rowsOfNumbers.set(name, cell);
  }
  const cell = rowsOfNumbers.get(name);
  if (cell.textContent !== value) cell.textContent = value;
}

function numbers_() {
  const {J: [[a, b], [c, d]], torque} = gains(pose.xi, modes, [Math.cos(force.angle), Math.sin(force.angle)], p);
  const sum = a * a + b * b + c * c + d * d, det = Math.abs(a * d - b * c),
    root = Math.sqrt(Math.max(sum * sum - 4 * det * det, 0));
  const large = Math.sqrt((sum + root) / 2), small = large ? det / large : 0;
  const pair = (values, unit) => values.every(Number.isFinite) ? `${values.map(x => number(x, 3)).join(", ")} ${unit}`
    : "∞: Type 2";
  put("x, y", `${pose.xi.map(x => number(1e3 * x)).join(", ")} mm`);
  put("q1, q2", pose.q.map(degrees).join(", "));
  put("sin q12, sin q22 (Type 1)", pose.serial.map(x => number(x, 3)).join(", "));
  put("det A (Type 2)", number(pose.parallel, 3));
  put("transmission angle", degrees(pose.transmission));
  put("workspace, this mode", area(field.reached * field.step ** 2));
  put("this aspect", area(field.count * field.step ** 2));
  put("speed for 1 rad/s", Number.isFinite(large) ? `${number(small, 3)} to ${number(large, 3)} m/s` : "∞: Type 2");
  put("torque for 1 N", pair(torque, "N m"));
  if (robot.gravity.some(Boolean) && (robot.m || isHeavy()))
    put("torque against gravity", pair(holding(pose.xi, modes, allParameters()).torque, "N m"));
  else if (rowsOfNumbers.has("torque against gravity")) put("torque against gravity", "no gravity");
  if (motion) {
    const {kinetic, potential, total} = totalEnergy();
    put("energy: kinetic, potential", `${number(1e3 * kinetic, 3)}, ${number(1e3 * potential, 3)} mJ`);
    const torques = motion.torque.tau.some(Boolean), rubs = robot.fv1 || robot.fv2 || robot.fv12 || robot.fv22;
    put("energy gained", torques || rubs ? `${number(1e3 * (total - motion.first.total), 3)} mJ`
      : `${(1e3 * (total - motion.first.total)).toExponential(1).replaceAll("-", "−")} mJ (rounding)`);
  }
}

// Let go --------------------------------------------------------------------------------------------------------------

function release(velocity = [0, 0]) {
  const still = stillWords();
  if (still) {
    said = still;
    return ask();
  }
  remember();
  said = "";
  trail = [];
  letGo(velocity, {tau: torqueInputs.map(input => +input.value || 0), wave: torqueKind.value === "wave"});
  if (torqueKind.value === "none") motion.torque.tau = [0, 0];
  flying = {before: performance.now()};
  goButton.textContent = "Hold it";
  goButton.setAttribute("aria-pressed", "true");
  frame();
}

function halt(why = "") {
  if (!flying) return;
  flying = null;
  goButton.textContent = "Let go";
  goButton.setAttribute("aria-pressed", "false");
  if (!take(igm(pose.xi, modes, p))) take({...pose, closes: 1});
  said = why;
  settle();
}

function fly(now) {
  const duration = Math.min(Math.max(now - flying.before, 0), 34) / 1000 * +paceInput.value;
  flying.before = now;
  if (duration && !flow(duration)) return halt("The motion became too fast to be followed: held here.");
  pose = poseOfMotion();
  moved();
}
