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
const along = ([x, y, length], [cosine, sine]) => [x + length * cosine, y + length * sine];

function igm(xi, working) {
  const dyads = robot.drives.map(([x, y, length], k) =>
    meet([xi[0] - x, xi[1] - y], length, robot.distal[k], working[k]));
  const distal = dyads.map(dyad => dyad.last);
  return pose(xi, dyads.map(dyad => Math.atan2(dyad.first[1], dyad.first[0])), dyads.map(dyad => dyad.first), distal,
    dyads.map(dyad => -dyad.sine), cross(...distal), Math.max(...dyads.map(dyad => dyad.gap)));
}

function dgm(q, assembly) {
  const direction = q.map(angle => [Math.cos(angle), Math.sin(angle)]);
  const [p1, p2] = robot.drives.map((drive, k) => along(drive, direction[k]));
  const dyad = meet([p2[0] - p1[0], p2[1] - p1[1]], ...robot.distal, -assembly);
  const distal = [dyad.first, dyad.last.map(x => -x)];
  const xi = [p1[0] + robot.distal[0] * dyad.first[0], p1[1] + robot.distal[0] * dyad.first[1]];
  return pose(xi, q, direction, distal, direction.map((u, k) => cross(u, distal[k])), dyad.sine, dyad.gap);
}

function pose(xi, q, direction, distal, serial, parallel, gap) {
  const elbows = robot.drives.map((drive, k) => along(drive, direction[k]));
  return {
    xi, q, elbows, serial, parallel, gap, working: serial.map(minusSign), assembly: minusSign(parallel),
    transmission: Math.atan2(Math.abs(parallel), Math.abs(dot(...distal))),
    closes: Number.isFinite(parallel + xi[0] + serial[0]),
  };
}
