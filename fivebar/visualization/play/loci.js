// The exact singularity loci of the robot at hand: which closed four-bars there are is told apart here as in
// singularities/four_bar_motion.py, their points are those of the generated functions.

const EPSILON = 2 ** -52;
const SAME = 1e-9;  // of the robot's size: what is nearer together is one
const unit = ([x, y]) => { const size = Math.hypot(x, y); return [x / size, y / size]; };
const times = ([a, b], [c, d]) => [a * c - b * d, a * d + b * c];

// A motion is {period, at(t, out)}: at gives the unit vectors e1, e2, u of base + r2 e2 = r1 e1 + c u into six numbers.
function turning(start, turns) {
  return {period: TURN, at(t, out) {
    const turn = [Math.cos(t), Math.sin(t)];
    start.forEach((e, k) => { [out[2 * k], out[2 * k + 1]] = turns[k] ? times(e, turn) : e; });
    return out;
  }};
}

function triangle(a, b, c, tolerance) {
  if (a + b < c - tolerance || Math.abs(a - b) > c + tolerance) return [];
  if (a + b <= c + tolerance) return [[1, 0]];
  if (Math.abs(a - b) >= c - tolerance) return [[-1, 0]];
  const x = Math.sqrt((c - (a - b)) * (c + (a - b))), y = Math.sqrt((a + b - c) * (a + b + c));
  const e = unit([x * x - y * y, 2 * x * y]);
  return [e, [e[0], -e[1]]];
}

function closures(base, r1, c, r2) {
  const tolerance = 8 * EPSILON * (base + r1 + c + r2), along = (e, size, more) => [size + more * e[0], more * e[1]];
  if (base <= tolerance) {
    if (c <= tolerance) return Math.abs(r1 - r2) <= tolerance ? [turning([[1, 0], [1, 0], [1, 0]], [1, 1, 0])] : [];
    if (Math.min(r1, r2) <= tolerance) return [];
    return triangle(r1, c, r2, tolerance).map(u => turning([[1, 0], unit(along(u, r1, c)), u], [1, 1, 1]));
  }
  if (c <= tolerance)
    return triangle(base, r2, r1, tolerance).map(e => turning([unit(along(e, base, r2)), e, [1, 0]], [0, 0, 1]));
  if (r1 <= tolerance)
    return triangle(base, r2, c, tolerance).map(e => turning([[1, 0], e, unit(along(e, base, r2))], [1, 0, 0]));
  if (r2 <= tolerance)
    return triangle(base, r1, c, tolerance).map(e =>
      turning([[-e[0], -e[1]], [1, 0], unit(along(e, base, r1))], [0, 1, 0]));
  const sides = [[base, r1, c, r2], [base, r2, c, r1]];
  const shortest = sides.map(s => Math.max(Math.abs(s[0] - s[3]), Math.abs(s[1] - s[2])));
  if (Math.max(...shortest) <= tolerance)
    return [turning([[1, 0], [1, 0], [1, 0]], [1, 1, 0]), turning([[1, 0], [-1, 0], [-1, 0]], [1, 0, 1]),
      turning([[1, 0], [1, 0], [1, 0]], [0, 1, 1])];
  const mirrored = shortest[1] > shortest[0];
  return components(sides[+mirrored], mirrored, tolerance);
}

function components(sides, mirrored, tolerance) {
  const [base, r1, c, r2] = sides;
  const lows = [Math.abs(base - r2), Math.abs(r1 - c)], highs = [base + r2, r1 + c];
  const low = Math.max(...lows), high = Math.min(...highs);
  if (high < low - tolerance) return [];
  if (high - low <= tolerance) {  // it closes in one flat pose
    const e2 = highs[0] - high <= tolerance ? 1 : -1, passive = highs[1] - high <= tolerance ? 1 : -1;
    const e1 = Math.sign(base + r2 * e2) * Math.sign(r1 + c * passive);
    const flat = mirrored ? [-e2, -e1, e1 * passive] : [e1, e2, e1 * passive];
    return [turning(flat.map(e => [e, 0]), [0, 0, 0])];
  }
  const slack = (values, limit) =>
    values.map(x => Math.abs(x - limit) <= tolerance ? 0 : Math.abs(x - limit) * (x + limit));
  const below = slack(lows, low), above = slack(highs, high);
  const whole = below.every((b, k) => (b === 0) === (above[k] === 0));
  const signs = !whole ? [[1, 1]] : below[0] === 0 ? [[1, 1], [1, -1]] : [[1, 1], [-1, 1]];
  const span = (high - low) * (high + low), gaps = [below[0], above[0], below[1], above[1]];
  return signs.map(own => ({period: whole ? Math.PI : TURN,
    at: (t, out) => fourBarMotion(t, sides, span, gaps, own, +mirrored, out)}));
}

// The chains of a robot [l11, l12, l21, l22, d]: for u11, u12, u21, u22 which of (e1, e2, u) it is, and its sign.
function chainsOf(p) {
  const [l11, l12, l21, l22, d] = p, found = [];
  const add = (type, kind, motions, bars) => { for (const motion of motions) found.push({type, kind, motion, bars}); };
  for (const [kind, reach, side] of [["stretched", l12 + l22, -1], ["folded", l12 - l22, 1]]) {
    const equal = Math.abs(reach) <= 8 * EPSILON * (l12 + l22), sign = reach < 0 ? -1 : 1;
    add(2, equal ? "self-motion" : kind, closures(d, l11, equal ? 0 : Math.abs(reach), l21),
      [[0, 1], [2, sign], [1, 1], [2, side * sign]]);
  }
  for (const side of [1, -1]) {
    const kind = side > 0 ? "stretched" : "folded", left = l11 + side * l12, right = l21 + side * l22;
    let sign = left < 0 ? -1 : 1;
    add(1, "left " + kind, closures(d, Math.abs(left), l22, l21), [[0, sign], [0, side * sign], [1, 1], [2, -1]]);
    sign = right < 0 ? -1 : 1;
    add(1, "right " + kind, closures(d, l11, l12, Math.abs(right)), [[0, 1], [2, 1], [1, sign], [1, side * sign]]);
  }
  return found;
}

// Coaxial motors and equal legs: working modes (1, 1) and (-1, -1) are Type 2 in every pose.
const everywhere = ([l11, l12, l21, l22, d]) => Math.max(d, Math.abs(l11 - l21), Math.abs(l12 - l22)) <=
  8 * EPSILON * (l11 + l12 + l21 + l22 + d);

const six = new Float64Array(6), eight = new Float64Array(8);
const SEEN = 7;  // x, y, q1, q2, both serial sines, det A

function seenAt(chain, p, t, out) {
  chain.motion.at(t, six);
  chain.bars.forEach(([which, sign], k) => {
    eight[2 * k] = sign * six[2 * which];
    eight[2 * k + 1] = sign * six[2 * which + 1];
  });
  return inLine(eight, p, out);
}

// Rows of SEEN numbers along a chain: even steps, halved where the path in the plane turns by more than `bend`.
function traced(chain, p, bend = 0.035, least = 96) {
  const size = p[0] + p[1] + p[2] + p[3] + p[4], step = chain.motion.period / least, rows = [];
  const row = t => Object.assign(seenAt(chain, p, t, new Array(SEEN)), {t});
  const bends = (a, m, b) => {
    const x0 = m[0] - a[0], y0 = m[1] - a[1], x1 = b[0] - m[0], y1 = b[1] - m[1];
    return Math.abs(Math.atan2(x0 * y1 - y0 * x1, x0 * x1 + y0 * y1)) > bend &&
      Math.abs(x0) + Math.abs(y0) + Math.abs(x1) + Math.abs(y1) > 2e-3 * size;
  };
  const divide = (a, b, depth) => {
    const m = row((a.t + b.t) / 2);
    if (depth < 6 && bends(a, m, b)) { divide(a, m, depth + 1); rows.push(m); divide(m, b, depth + 1); }
    else if (depth === 0 || bends(a, m, b)) rows.push(m);
  };
  let before = row(0);
  rows.push(before);
  for (let k = 1; k <= least; k++) {
    const next = row(k * step);
    divide(before, next, 0);
    rows.push(next);
    before = next;
  }
  return rows;
}

// Where one of its columns changes sign between two rows: by halving, to rounding.
function rowWhere(chain, p, a, b, column) {
  let low = a.t, high = b.t;
  const out = new Array(SEEN), sign = Math.sign(a[column]);
  for (let k = 0; k < 60 && high - low > 4 * EPSILON * (Math.abs(high) + 1); k++) {
    const middle = (low + high) / 2;
    if (Math.sign(seenAt(chain, p, middle, out)[column]) === sign) low = middle; else high = middle;
  }
  return Object.assign(seenAt(chain, p, (low + high) / 2, out), {t: (low + high) / 2});
}

const FLATTENED = 1e-9;  // a sine this small is 0; where it is so all along, a piece belongs to both modes

// {type, kind, signs of the two serial sines and det A (0: both), rows} along which the signs do not change.
function piecesOf(chain, p) {
  const rows = traced(chain, p), columns = [4, 5, 6], pieces = [], zero = x => Math.abs(x) < FLATTENED;
  const moving = columns.filter(c => !rows.every(row => zero(row[c])));
  let current = [rows[0]];
  const cut = at => {
    if (current.length > 1) {
      const middle = seenAt(chain, p, (current[0].t + at.t) / 2, new Array(SEEN));
      const signs = columns.map(c => moving.includes(c) ? Math.sign(middle[c]) : 0);
      pieces.push({chain, type: chain.type, kind: chain.kind, rows: current, signs});
    }
    current = [at];
  };
  for (let k = 1; k < rows.length; k++) {
    const a = rows[k - 1], b = rows[k];
    const cuts = moving.filter(c => !zero(a[c]) && !zero(b[c]) && Math.sign(a[c]) !== Math.sign(b[c]))
      .map(c => rowWhere(chain, p, a, b, c)).sort((one, other) => one.t - other.t);
    for (const at of cuts) {
      current.push(at);
      cut(at);
    }
    current.push(b);
    if (moving.some(c => zero(b[c]))) cut(b);
  }
  cut(rows[rows.length - 1]);
  return pieces;
}

// Type 1 in the plane: arcs [leg, side, x, radius, first, last] of circles about a base joint, angles from +x.
function arcsOf(p) {
  const [l11, l12, l21, l22, d] = p, found = [], tolerance = 1e-14 * (l11 + l12 + l21 + l22 + d);
  const legs = [[-d / 2, l11, l12], [d / 2, l21, l22]];
  legs.forEach(([x, l1, l2], leg) => {
    for (const side of [1, -1]) {
      const radius = Math.abs(l1 + side * l2), [, o1, o2] = legs[1 - leg];
      const low = Math.max(Math.abs(o1 - o2), Math.abs(d - radius)), high = Math.min(o1 + o2, d + radius);
      if (high < low - tolerance || radius <= tolerance) continue;
      let first = 0, last = Math.PI;
      if (d > tolerance) {
        if (low > Math.abs(d - radius) + tolerance) first = turnTo(low, d, radius).angle;
        if (high < d + radius - tolerance) last = turnTo(high, d, radius).angle;
      }
      const facing = leg ? Math.PI : 0, spans = first === 0 && last === Math.PI ? [[-Math.PI, Math.PI]]
        : first === 0 ? [[-last, last]] : last === Math.PI ? [[first, TURN - first]]
          : [[first, last], [-last, -first]];
      for (const [from, to] of spans) found.push({leg, side, x, radius, from: from + facing, to: to + facing});
    }
  });
  return found;
}

function arcPoints({x, radius, from, to}) {
  const count = Math.max(8, Math.ceil((to - from) / 0.03));
  return Array.from({length: count + 1}, (_, k) => {
    const angle = from + (to - from) * k / count;
    return [x + radius * Math.cos(angle), radius * Math.sin(angle)];
  });
}

// All of it: pieces of Type 2 for the plane, pieces of both types for the joints, arcs of Type 1.
function lociOf(p) {
  const pieces = chainsOf(p).flatMap(chain => piecesOf(chain, p)), size = sizeOf(p);
  const task = pieces.filter(({type, kind}) => type === 2 && !(kind === "self-motion" && everywhere(p)));
  const isPoint = ({rows}) => rows.every(row => Math.hypot(row[0] - rows[0][0], row[1] - rows[0][1]) < SAME * size);
  return {arcs: arcsOf(p).map(arc => ({...arc, points: arcPoints(arc)})), joint: pieces, task,
    holes: task.filter(isPoint).map(piece => ({...piece, x: piece.rows[0][0], y: piece.rows[0][1]})),
    everywhere: everywhere(p)};
}

// Whether a piece is singular in this working mode: a mode is minus the sine's sign.
const inMode = ({signs}, modes) => modes.every((mode, k) => signs[k] === 0 || signs[k] === -mode);
