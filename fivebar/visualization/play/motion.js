// "Let go": the robot moves by its inertias, gravity, friction and torques, from the pose at hand, by steps of order 8
// that choose their length (Dormand and Prince, as in SciPy) on the state of all four bars, through singularities.

const {A: TABLEAU, B: WEIGHTS, C: PLACES, E3, E5} = content.tableau;
const STAGES = WEIGHTS.length, TOLERANCE = 1e-10, stages = Array.from({length: STAGES + 1}, () => new Float64Array(8));
const stage = new Float64Array(8), after = new Float64Array(8);
let motion = null;  // {state, t, length, whole, slope, energy, crossings}

const BEYOND = ["mx11", "my11", "mx21", "my21", "zz12", "zz22", "my12", "my22"];
const FRICTIONS = ["fv1", "fv2", "fv12", "fv22"];
// friction: more viscous friction of both motors than the robot's own, N m s/rad.
const allParameters = (friction = 0) => [...p, robot.zz1, robot.zz2, robot.m, ...BEYOND.map(name => robot[name]),
  ...robot.gravity, robot.fv1 + friction, robot.fv2 + friction, robot.fv12, robot.fv22];
const lightParameters = friction => [...p, robot.zz1, robot.zz2, robot.m, ...robot.gravity, robot.fv1 + friction,
  robot.fv2 + friction];
const isHeavy = () => [...BEYOND, "fv12", "fv22"].some(name => robot[name] !== 0);

// About what one motor turns: its own inertia and the load on its bar, kg m².
const typicalInertia = () => (robot.zz1 + robot.zz2) / 2 + robot.m * ((p[0] + p[2]) / 2) ** 2;
const oneDigit = x => +x.toPrecision(1);
const hasFriction = () => FRICTIONS.some(name => robot[name] > 0);
const addedFriction = () => hasFriction() ? 0 : oneDigit(typicalInertia() / 1.5);  // 1.5 s: how long a motion lasts
const suggestedTorques = () => [1, -0.8].map(share => +(share * oneDigit(3 * typicalInertia())).toPrecision(2));

// Why this robot cannot move by itself, "" where it can.
function noMotionWords() {
  if (!isHeavy() && !(robot.zz1 > 0 && robot.zz2 > 0))
    return "This robot names no inertias of its motors: set zz1 and zz2 above 0 to let it go.";
  return "";
}

function letGo(velocity, torque, friction = 0) {
  let state = begin(pose.xi, modes, velocity, p).state;
  if (!state.every(Number.isFinite)) state = begin(pose.xi, modes, [0, 0], p).state;
  if (!state.every(Number.isFinite)) {  // a leg in line: the angles are known all the same, the rates are none
    const {q, elbows, xi} = pose;
    const far = elbows.map(([x, y]) => Math.atan2(xi[1] - y, xi[0] - x));
    state = [q[0], far[0], q[1], far[1], 0, 0, 0, 0];
  }
  const heavy = isHeavy(), whole = heavy ? allParameters(friction) : lightParameters(friction);
  motion = {state: Float64Array.from(closeLoop(state, p).closed), t: 0, length: 0.002, whole, all: allParameters(),
    torque, slope: heavy ? slopeHeavy : slope, crossings: 0};
  motion.seen = closeLoop(motion.state, p);
  motion.first = totalEnergy();
}

function totalEnergy() {
  const {kinetic, potential} = energies(motion.state, motion.all);
  return {kinetic, potential, total: kinetic + potential};
}

const torqueAt = t => motion.torque.wave ? motion.torque.tau.map(x => x * Math.cos(TURN * t)) : motion.torque.tau;

// Move on by `duration` s; false where the motion is too fast to be followed.
function flow(duration) {
  const end = motion.t + duration;
  for (let k = 0; motion.t < end - 1e-13; k++) {
    if (k > 3000) return false;
    const length = Math.min(motion.length, end - motion.t, motion.torque.wave ? 0.01 : Infinity);
    const error = tried(length);
    if (error <= 1) {
      const next = closeLoop(after, p), before = motion.seen;
      if (!next.closed.every(Number.isFinite)) return false;
      for (let i = 0; i < 8; i++) motion.state[i] = next.closed[i];
      motion.t += length;
      motion.seen = next;
      if (before.parallel * next.parallel < 0) motion.crossings++;
    } else if (length < 1e-11) return false;
    const factor = error > 0 ? Math.min(Math.max(0.9 * error ** -0.125, 0.2), 8) : 8;
    if (error > 1 || length === motion.length) motion.length = length * (Number.isFinite(factor) ? factor : 0.2);
  }
  return true;
}

function tried(length) {
  const {state, whole, slope: rightSide, t} = motion;
  for (let s = 0; s < STAGES; s++) {
    stage.set(state);
    TABLEAU[s].forEach((weight, r) => {
      if (weight) for (let i = 0; i < 8; i++) stage[i] += length * weight * stages[r][i];
    });
    rightSide(stage, torqueAt(t + PLACES[s] * length), whole, stages[s]);
  }
  after.set(state);
  for (let s = 0; s < STAGES; s++)
    if (WEIGHTS[s]) for (let i = 0; i < 8; i++) after[i] += length * WEIGHTS[s] * stages[s][i];
  rightSide(after, torqueAt(t + length), whole, stages[STAGES]);
  let fifth = 0, third = 0;
  for (let i = 0; i < 8; i++) {
    const scale = i < 4 ? 1 : 1 + Math.abs(state[i]);
    let five = 0, three = 0;
    for (let s = 0; s <= STAGES; s++) {
      five += (E5[s] ?? 0) * stages[s][i];
      three += (E3[s] ?? 0) * stages[s][i];
    }
    fifth += (five / scale) ** 2;
    third += (three / scale) ** 2;
  }
  const error = length * fifth / Math.sqrt(Math.max(8 * (fifth + 0.01 * third), 1e-300)) / TOLERANCE;
  return Number.isFinite(error) ? error : Infinity;
}

// The pose of the motion now, as the page shows poses.
function poseOfMotion() {
  const {closed: state, xi, serial, parallel} = motion.seen;
  const found = dgm([wrapped(state[0]), wrapped(state[2])], parallel > 0 ? -1 : 1, p);
  const minus = x => x > 0 ? -1 : x < 0 ? 1 : 0, working = serial.map(minus);
  modes = working.map((mode, k) => mode || modes[k]);
  const reached = igm(xi, modes, p);
  return {...found, ...(reached.closes ? reached : {}), xi, serial, parallel, elbows: found.elbows, working, closes: 1,
    assembly: minus(parallel), q: [wrapped(state[0]), wrapped(state[2])], clear: reached.clear};
}
