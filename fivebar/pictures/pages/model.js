// The model, fivebar's own: bars r1 and r2 on two pivots, one of them [x, y] from the other, and robots of two legs.

const {robot} = content, EPS = 2 ** -52, SINGULAR = 16 * EPS;

function meet([x, y], r1, r2, branch) {
  const square = x * x + y * y, total = r1 + r2, difference = r1 - r2;
  const heron = (total * total - square) * (square - difference * difference);
  const open = heron < -32 * EPS * Math.max(r1, r2) ** 2 * square || !(square > (4 * EPS * total) ** 2);
  const moment = open ? NaN : Math.sqrt(Math.max(heron, 0)) * 0.5 * branch;
  const first = 0.5 * (square + total * difference), last = 0.5 * (square - total * difference);
  const a = 1 / square * (1 / r1), b = 1 / square * (1 / r2), distance = Math.sqrt(square);
  return {
    first: [(first * x - moment * y) * a, (first * y + moment * x) * a],
    last: [(last * x + moment * y) * b, (last * y - moment * x) * b],
    sine: moment * (1 / (r1 * r2)),
    gap: Math.max(distance - total, Math.abs(difference) - distance),
  };
}

const cross = (u, v) => u[0] * v[1] - u[1] * v[0], dot = (u, v) => u[0] * v[0] + u[1] * v[1];
const minusSign = x => x > SINGULAR ? -1 : x < -SINGULAR ? 1 : 0;

// The leg k of a robot, closed on the end-effector; its drive is a crank or a slider along y.
function leg(k, xi, working) {
  const [x, y, length] = robot.drives[k], bar = robot.distal[k];
  if (robot.turns) {
    const {first, last, sine, gap} = meet([xi[0] - x, xi[1] - y], length, bar, working);
    return {q: Math.atan2(first[1], first[0]), elbow: [x + length * first[0], y + length * first[1]], distal: last,
      serial: -sine, gap};
  }
  const height = x - xi[0], square = (bar - height) * (bar + height);
  const reach = square < -8 * EPS * bar * bar ? NaN : Math.sqrt(Math.max(square, 0)) * working;
  const q = reach - (y - xi[1]);
  return {q, elbow: [x, y + q], distal: [-height / bar, -reach / bar], serial: -reach / bar,
    gap: Math.abs(height) - bar};
}

function igm(xi, working) {
  const legs = working.map((mode, k) => leg(k, xi, mode));
  return pose(xi, legs.map(({q}) => q), legs.map(({elbow}) => elbow), legs.map(({distal}) => distal),
    legs.map(({serial}) => serial), cross(legs[0].distal, legs[1].distal), Math.max(...legs.map(({gap}) => gap)));
}

function dgm(q, assembly) {
  const direction = q.map(angle => [Math.cos(angle), Math.sin(angle)]);
  const [p1, p2] = robot.drives.map(([x, y, length], k) =>
    robot.turns ? [x + length * direction[k][0], y + length * direction[k][1]] : [x, y + q[k]]);
  const dyad = meet([p2[0] - p1[0], p2[1] - p1[1]], ...robot.distal, -assembly);
  const distal = [dyad.first, dyad.last.map(x => -x)];
  const xi = [p1[0] + robot.distal[0] * dyad.first[0], p1[1] + robot.distal[0] * dyad.first[1]];
  const serial = distal.map((bar, k) => robot.turns ? cross(direction[k], bar) : bar[1]);
  return pose(xi, q, [p1, p2], distal, serial, dyad.sine, dyad.gap);
}

function pose(xi, q, elbows, distal, serial, parallel, gap) {
  return {
    xi, q, elbows, serial, parallel, gap, working: serial.map(minusSign), assembly: minusSign(parallel),
    transmission: Math.atan2(Math.abs(parallel), Math.abs(dot(...distal))),
    closes: Number.isFinite(parallel + xi[0] + serial[0]),
  };
}
