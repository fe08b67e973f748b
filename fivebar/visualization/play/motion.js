// "Let go": the robot moves by its inertias, gravity, friction and torques, from the pose at hand. A worker integrates
// the motion, or where the browser makes none, the page.

const BEYOND = ["mx11", "my11", "mx21", "my21", "zz12", "zz22", "my12", "my22"];
const FRICTIONS = ["fv1", "fv2", "fv12", "fv22"];
// friction: more viscous friction of both motors than the robot's own, N m s/rad.
const allParameters = (friction = 0) => [...p, robot.zz1, robot.zz2, robot.m, ...BEYOND.map(name => robot[name]),
  ...robot.gravity, robot.fv1 + friction, robot.fv2 + friction, robot.fv12, robot.fv22];
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
  motion = {p, state: Float64Array.from(closeLoop(state, p).closed), t: 0, length: 0.002, whole: allParameters(friction),
    torque, crossings: 0};
  motion.seen = closeLoop(motion.state, p);
  motion.first = totalEnergy();
}

function totalEnergy() {
  const {kinetic, potential} = energies(motion.state, motion.whole);
  return {kinetic, potential, total: kinetic + potential};
}

// The pose of a motion at one time, as the page shows poses.
function poseOfMotion({closed: state, xi, serial, parallel} = motion.seen) {
  const found = dgm([wrapped(state[0]), wrapped(state[2])], parallel > 0 ? -1 : 1, p);
  const minus = x => x > 0 ? -1 : x < 0 ? 1 : 0, working = serial.map(minus);
  modes = working.map((mode, k) => mode || modes[k]);
  const reached = igm(xi, modes, p);
  return {...found, ...(reached.closes ? reached : {}), xi, serial, parallel, elbows: found.elbows, working, closes: 1,
    assembly: minus(parallel), q: [wrapped(state[0]), wrapped(state[2])], clear: reached.clear};
}
