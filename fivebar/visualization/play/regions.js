// The parts of the workspace without singularities in a working mode: their areas, and which one holds a point. Exact.
// A line sweeps over the exact curves. Between two neighbouring ends or turning points of curves, the order of the
// curves along the line stays the same: the gap between two of them is a cell. Cells that share a piece of the line
// are one part.

const SWEEP_X = Math.cos(0.7), SWEEP_Y = Math.sin(0.7);  // askew: no robot is symmetric about this direction

const placed = (x, y, t) => ({x, y, t, s: x * SWEEP_X + y * SWEEP_Y, n: y * SWEEP_X - x * SWEEP_Y});

// Where f changes its sign between a and b, by the Illinois rule of false position.
function signChange(f, a, b, fa = f(a), fb = f(b)) {
  let side = 0, root = a;
  for (let k = 0; k < 100 && fa !== fb; k++) {
    const next = (fa * b - fb * a) / (fa - fb), value = f(next);
    if (value === 0 || Math.abs(next - root) <= 2 * EPSILON * (Math.abs(next) + 1)) return next;
    root = next;
    if (value * fb > 0) {
      [b, fb] = [next, value];
      if (side < 0) fa /= 2;
      side = -1;
    } else {
      [a, fa] = [next, value];
      if (side > 0) fb /= 2;
      side = 1;
    }
  }
  return root;
}

// {at(t), rows}: the curves that bound the parts in this working mode, sampled where they bend.
function boundaryCurves({arcs, task: pieces}, p, modes) {
  const seen = new Array(SEEN);
  const circles = arcs.map(({x, radius, from, to, points}) => {
    const at = t => placed(x + radius * Math.cos(t), radius * Math.sin(t), t), last = points.length - 1;
    return {at, rows: points.map((_, k) => at(from + (to - from) * k / last))};
  });
  return [...circles, ...pieces.filter(piece => inMode(piece, modes)).map(({chain, rows}) => ({
    at(t) {
      seenAt(chain, p, t, seen);
      return placed(seen[0], seen[1], t);
    },
    rows: rows.map(row => placed(row[0], row[1], row.t)),
  }))];
}

// A curve cut where it turns back in the sweep: strands, each with its rows in the order of the sweep.
function strandsOf({at, rows}, size) {
  const h = 1e-6, climb = t => at(t + h).s - at(t - h).s;
  const strands = [];
  let strand = [rows[0]], before = climb(rows[0].t);
  const end = () => {
    if (strand[strand.length - 1].s < strand[0].s) strand.reverse();
    if (strand[strand.length - 1].s - strand[0].s > SAME * size) strands.push(strandOf(at, strand));
  };
  for (let k = 1; k < rows.length; k++) {
    const now = climb(rows[k].t);
    if (before * now < 0) {
      const turn = at(signChange(climb, rows[k - 1].t, rows[k].t, before, now));
      strand.push(turn);
      end();
      strand = [turn];
    }
    strand.push(rows[k]);
    before = now;
  }
  end();
  return strands;
}

// areas[k]: the integral of n over s up to row k.
function strandOf(at, rows) {
  const areas = [0];
  for (let k = 1; k < rows.length; k++) areas.push(areas[k - 1] + areaBetween(at, rows[k - 1], rows[k]));
  return {at, rows, areas, cuts: []};
}

// The integral of n over s between two points of a curve: parabolas through its middle and through its quarters, as in
// Richardson's extrapolation.
function areaBetween(at, a, b) {
  const middle = at((a.t + b.t) / 2), quarter = at((a.t + middle.t) / 2), last = at((middle.t + b.t) / 2);
  const halves = areaOfParabola(a, quarter, middle) + areaOfParabola(middle, last, b);
  return halves + (halves - areaOfParabola(a, middle, b)) / 15;
}

function areaOfParabola(a, middle, b) {
  const bulge = (b.s - a.s) * (middle.n - a.n) - (b.n - a.n) * (middle.s - a.s);
  return (b.s - a.s) * (a.n + b.n) / 2 + 2 / 3 * bulge;
}

// Where a strand meets the sweeping line at s: {row: how many of its rows come before, point, area up to there}.
function cutAt(strand, s) {
  const {at, rows, areas} = strand;
  let low = 0, high = rows.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (rows[middle].s <= s) low = middle; else high = middle;
  }
  const a = rows[low], b = rows[high];
  if (s <= a.s) return {row: low, point: a, area: areas[low]};
  if (s >= b.s) return {row: high, point: b, area: areas[high]};
  const point = at(signChange(t => at(t).s - s, a.t, b.t, a.s - s, b.s - s));
  return {row: high, point, area: areas[low] + areaBetween(at, a, point)};
}

// All parts: {lines: where the sweep stops, slabs: of each gap its cells from below, regions}.
function regionsOf(loci, p, modes) {
  const size = sizeOf(p), strands = boundaryCurves(loci, p, modes).flatMap(curve => strandsOf(curve, size));
  const stops = strands.flatMap(({rows}) => [rows[0].s, rows[rows.length - 1].s]), lines = [];
  stops.push(...touchingPoints(loci.arcs, size));
  for (const s of stops.sort((a, b) => a - b)) if (!(s - lines[lines.length - 1] <= SAME * size)) lines.push(s);
  for (const strand of strands) {
    const {rows} = strand, last = rows.length - 1;
    strand.first = nearest(lines, rows[0].s);
    strand.last = nearest(lines, rows[last].s);
    strand.cuts[strand.first] = {row: 0, point: rows[0], area: 0};
    strand.cuts[strand.last] = {row: last, point: rows[last], area: strand.areas[last]};
    for (let k = strand.first + 1; k < strand.last; k++) strand.cuts[k] = cutAt(strand, lines[k]);
  }
  const slabs = lines.slice(1).map((_, k) => cellsOf(strands, lines, k, p, modes, size));
  for (let k = 1; k < slabs.length; k++)
    for (const one of slabs[k - 1]) for (const other of slabs[k]) if (areConnected(one, other, k, size)) unite(one, other);
  const regions = new Map();
  for (const cell of slabs.flat()) {
    const root = rootOf(cell);
    if (!regions.has(root)) regions.set(root, {sign: cell.sign, area: 0, cells: []});
    cell.region = regions.get(root);
    cell.region.area += cell.area;
    cell.region.cells.push(cell);
  }
  return {lines, slabs, regions: [...regions.values()]};
}

// Where two circles of Type 1 touch, which is on the line of the bases: there the workspace is as thin as a point.
function touchingPoints(arcs, size) {
  const ends = leg => arcs.filter(arc => arc.leg === leg).flatMap(({x, radius}) => [x - radius, x + radius]);
  const right = ends(1);
  return ends(0).filter(x => right.some(other => Math.abs(x - other) <= SAME * size)).map(x => placed(x, 0, 0).s);
}

// The cells between two lines, from below; the workspace's only.
function cellsOf(strands, lines, k, p, modes, size) {
  const s = lines[k] + 0.46 * (lines[k + 1] - lines[k]), out = new Float64Array(1);  // no special point of symmetry
  const crossed = strands.filter(({first, last}) => first <= k && k < last)
    .map(strand => ({strand, n: cutAt(strand, s).point.n})).sort((one, other) => one.n - other.n);
  const cells = [];
  for (let i = 1; i < crossed.length; i++) {
    const {strand: below, n: low} = crossed[i - 1], {strand: above, n: high} = crossed[i];
    if (high - low <= SAME * size) continue;
    const n = low + 0.47 * (high - low), point = [s * SWEEP_X - n * SWEEP_Y, s * SWEEP_Y + n * SWEEP_X];
    const det = sense(point, modes, p, out)[0];
    if (!(Math.abs(det) > FLATTENED)) continue;
    const area = above.cuts[k + 1].area - above.cuts[k].area - below.cuts[k + 1].area + below.cuts[k].area;
    cells.push({below, above, slab: k, sign: Math.sign(det), area, joined: null});
  }
  return cells;
}

// Whether two cells on both sides of a line share more than a point of it.
function areConnected(one, other, k, size) {
  const n = strand => strand.cuts[k].point.n;
  const low = Math.max(n(one.below), n(other.below)), high = Math.min(n(one.above), n(other.above));
  return one.sign === other.sign && high - low > SAME * size;
}

function rootOf(cell) {
  while (cell.joined) cell = cell.joined;
  return cell;
}

function unite(one, other) {
  const [a, b] = [rootOf(one), rootOf(other)];
  if (a !== b) a.joined = b;
}

// The part that holds a point, or null; `sign`: of det A there, so that a point on a border is told from its neighbour.
function regionAt({lines, slabs}, [x, y], sign) {
  const {s, n} = placed(x, y, 0);
  let best = null, gap = 1e-3 * (lines[lines.length - 1] - lines[0]);
  slabs.forEach((cells, k) => {
    const beside = Math.max(lines[k] - s, s - lines[k + 1], 0);
    if (!(beside < gap)) return;
    const line = Math.min(Math.max(s, lines[k]), lines[k + 1]);
    for (const cell of cells) {
      if (sign && cell.sign !== sign) continue;
      const low = cutAt(cell.below, line).point.n, high = cutAt(cell.above, line).point.n;
      const far = Math.hypot(beside, Math.max(low - n, n - high, 0));
      if (far < gap) [best, gap] = [cell.region, far];
    }
  });
  return best;
}

// The rows of a strand between two lines, with its points on them.
function rowsBetween(strand, from, to) {
  const {rows, cuts} = strand, a = cuts[from], b = cuts[to];
  const inner = rows.slice(a.point === rows[a.row] ? a.row + 1 : a.row, b.row);
  return [a.point, ...inner, b.point];
}

// A region's cells as polygons of points.
const polygonsOf = ({cells}) => cells.map(({below, above, slab}) =>
  [...rowsBetween(below, slab, slab + 1), ...rowsBetween(above, slab, slab + 1).reverse()]);
