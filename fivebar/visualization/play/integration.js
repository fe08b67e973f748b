// "Let go" is integrated by steps of order 8 that choose their length (Dormand and Prince, as in SciPy) on the state of
// all four bars, through singularities. The page runs this script, and so does the worker that it starts for a motion.

const {A: TABLEAU, B: WEIGHTS, C: PLACES, E3, E5} = DOP853, TURN = 2 * Math.PI;
const STAGES = WEIGHTS.length, TOLERANCE = 1e-10, stages = Array.from({length: STAGES + 1}, () => new Float64Array(8));
const stage = new Float64Array(8), after = new Float64Array(8);
let motion = null;  // {p, whole, torque, state, t, length, seen, crossings, first}

const LONGEST_CHORD = 1 / 120;  // s between two points of the trace

// Answer a request of the page: move on by `duration` s. path: what was seen on the way; followed: false where the
// motion is too fast.
function integrate({motion: begun, duration}) {
  motion = begun;
  const count = Math.ceil(duration / LONGEST_CHORD), path = [];
  let followed = true;
  for (let k = 0; k < count && followed; k++) {
    followed = flow(duration / count);
    if (followed) path.push({t: motion.t, ...motion.seen});
  }
  return {motion, path, followed};
}

if (typeof document === "undefined") onmessage = ({data}) => postMessage(integrate(data));

const torqueAt = t => motion.torque.wave ? motion.torque.tau.map(x => x * Math.cos(TURN * t)) : motion.torque.tau;

// Move on by `duration` s; false where the motion is too fast to be followed.
function flow(duration) {
  const end = motion.t + duration;
  for (let k = 0; motion.t < end - 1e-13; k++) {
    if (k > 3000) return false;
    const length = Math.min(motion.length, end - motion.t, motion.torque.wave ? 0.01 : Infinity);
    const error = tried(length);
    if (error <= 1) {
      const next = closeLoop(after, motion.p), before = motion.seen;
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
  const {state, whole, t} = motion;
  for (let s = 0; s < STAGES; s++) {
    stage.set(state);
    TABLEAU[s].forEach((weight, r) => {
      if (weight) for (let i = 0; i < 8; i++) stage[i] += length * weight * stages[r][i];
    });
    slope(stage, torqueAt(t + PLACES[s] * length), whole, stages[s]);
  }
  after.set(state);
  for (let s = 0; s < STAGES; s++)
    if (WEIGHTS[s]) for (let i = 0; i < 8; i++) after[i] += length * WEIGHTS[s] * stages[s][i];
  slope(after, torqueAt(t + length), whole, stages[STAGES]);
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
