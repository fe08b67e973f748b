// The largest disc in a part of the workspace: searched by halving squares, then solved for on the exact curves.

const MOST_CONTACTS = 16;  // in the centre of a circle all of its points are contacts
const MOST_GROWN = 40;  // in a band of one width everywhere each square could hold the largest disc
const CHORDAL = 0.01, SMALL = 0.15;  // shares of the radius: chords may be off by, squares are searched down to

// The borders of a part: runs of points along the strands above and below its cells.
function wallsOf({cells}) {
  const walls = [];
  for (const side of ["below", "above"]) {
    const runs = new Map();
    for (const cell of cells) {
      const strand = cell[side], run = runs.get(strand);
      if (run && run.to === cell.slab) run.to++;
      else {
        if (run) walls.push(run);
        runs.set(strand, {strand, from: cell.slab, to: cell.slab + 1});
      }
    }
    walls.push(...runs.values());
  }
  return walls.map(({strand, from, to}) => ({at: strand.at, points: rowsBetween(strand, from, to)}));
}

// A wall with more points, so that it is nowhere farther than `most` m from its chords.
function refined({at, points}, most) {
  const found = [points[0]];
  const divide = (a, b, depth) => {
    const middle = at((a.t + b.t) / 2), bulge = Math.hypot(middle.x - (a.x + b.x) / 2, middle.y - (a.y + b.y) / 2);
    if (bulge > most && depth < 12) {
      divide(a, middle, depth + 1);
      divide(middle, b, depth + 1);
    } else found.push(b);
  };
  for (let k = 1; k < points.length; k++) divide(points[k - 1], points[k], 0);
  return {at, points: found};
}

function lengthOf(points) {
  let length = 0;
  for (let k = 1; k < points.length; k++)
    length += Math.hypot(points[k].x - points[k - 1].x, points[k].y - points[k - 1].y);
  return length;
}

// Distance of a point from the walls' chords, m; negative outside of them.
function clearanceAt(walls, x, y) {
  let nearest = Infinity, inside = false;
  for (const {points} of walls)
    for (let k = 1; k < points.length; k++) {
      const ax = points[k - 1].x - x, ay = points[k - 1].y - y, bx = points[k].x - x, by = points[k].y - y;
      const dx = bx - ax, dy = by - ay, along = -(ax * dx + ay * dy) / (dx * dx + dy * dy || 1);
      const share = along < 0 ? 0 : along > 1 ? 1 : along;
      nearest = Math.min(nearest, (ax + share * dx) ** 2 + (ay + share * dy) ** 2);
      if (ay > 0 !== by > 0 && ax * by > bx * ay === by > ay) inside = !inside;
    }
  return (inside ? 1 : -1) * Math.sqrt(nearest);
}

// The points of the walls that are nearest to (x, y) among their neighbours: {distance, ux, uy}, u away from them.
function contactsOf(walls, holes, x, y) {
  const contacts = [], far = point => (point.x - x) ** 2 + (point.y - y) ** 2;
  const add = point => {
    const distance = Math.sqrt(far(point));
    contacts.push({distance, ux: (x - point.x) / distance, uy: (y - point.y) / distance});
  };
  holes.forEach(add);
  for (const {at, points} of walls) {
    const squares = points.map(far), h = 1e-6, away = t => far(at(t + h)) - far(at(t - h));
    for (let k = 0; k < points.length; k++) {
      if (squares[k] > squares[k - 1] || squares[k] > squares[k + 1]) continue;
      const a = points[Math.max(k - 1, 0)].t, b = points[Math.min(k + 1, points.length - 1)].t;
      const da = away(a), db = away(b), falls = (b - a) * da < 0, rises = (b - a) * db > 0;
      add(falls && rises ? at(signChange(away, a, b, da, db)) : points[k]);
    }
  }
  return contacts;
}

const leastOf = contacts => Math.min(...contacts.map(({distance}) => distance));

// The move of at most `step` after which the nearest contact would be farthest, if all of them were straight lines.
function bestMove(contacts, step) {
  let best = [0, 0], most = leastOf(contacts);
  const active = contacts.filter(({distance}) => distance <= most + 2 * step)
    .sort((one, other) => one.distance - other.distance).slice(0, MOST_CONTACTS);
  const consider = (dx, dy) => {
    if (!(Math.hypot(dx, dy) <= step * (1 + 1e-9))) return;
    const least = Math.min(...active.map(({distance, ux, uy}) => distance + ux * dx + uy * dy));
    if (least > most) [best, most] = [[dx, dy], least];
  };
  active.forEach((one, i) => {
    consider(step * one.ux, step * one.uy);
    for (let j = 0; j < i; j++) {
      const other = active[j], ax = one.ux - other.ux, ay = one.uy - other.uy, a = other.distance - one.distance;
      const square = ax * ax + ay * ay, left = step * step - a * a / square;
      if (left < 0) continue;
      for (const sign of [1, -1]) {
        const along = sign * Math.sqrt(left / square);
        consider(a * ax / square - along * ay, a * ay / square + along * ax);
      }
      for (let k = 0; k < j; k++) {
        const third = active[k], bx = one.ux - third.ux, by = one.uy - third.uy, b = third.distance - one.distance;
        const det = ax * by - ay * bx;
        consider((a * by - b * ay) / det, (ax * b - bx * a) / det);
      }
    }
  });
  return {move: best, most};
}

// From a point inside uphill to a disc that nothing lets grow.
function grownDisc(walls, holes, x, y) {
  let contacts = contactsOf(walls, holes, x, y), radius = leastOf(contacts), step = radius / 2;
  for (let round = 0; round < 200; round++) {
    const {move: [dx, dy], most} = bestMove(contacts, step);
    if (most - radius <= 1e-12 * radius) break;
    const next = contactsOf(walls, holes, x + dx, y + dy), least = leastOf(next);
    if (least > radius) [x, y, contacts, radius] = [x + dx, y + dy, next, least];
    else step /= 3;
  }
  return {x, y, radius};
}

const QUARTERS = [[-1, -1], [-1, 1], [1, -1], [1, 1]];

// {x, y, radius} in m of the largest disc, null where there is no part. holes: single points to keep away from.
// fine: whether discs are grown from all small squares in which a larger one could be, or from the best ones only.
function largestDisc(region, holes, fine) {
  if (!region) return null;
  const coarse = wallsOf(region), length = coarse.reduce((sum, wall) => sum + lengthOf(wall.points), 0);
  const bulge = CHORDAL * region.area / length;  // no disc is smaller than area by length
  const walls = coarse.map(wall => refined(wall, bulge)), points = walls.flatMap(wall => wall.points);
  const xs = points.map(({x}) => x), ys = points.map(({y}) => y);
  const [x0, x1, y0, y1] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  let best = {x: x0, y: y0, radius: 0};
  const grow = ({x, y}) => {
    const disc = grownDisc(walls, holes, x, y);
    if (disc.radius > best.radius) best = disc;
  };
  const look = (x, y) => ({x, y, clearance: Math.min(clearanceAt(walls, x, y), ...holes.map(hole =>
    Math.hypot(hole.x - x, hole.y - y)))});
  // Not centred: a ray along the axis of symmetry would meet ends of walls.
  let half = 0.513 * Math.max(x1 - x0, y1 - y0);
  let squares = [look((x0 + x1) / 2 + 0.009 * half, (y0 + y1) / 2 + 0.007 * half)];
  const couldBeLarger = ({clearance}) => clearance + half * Math.SQRT2 + bulge > best.radius;
  while (squares.length && half > SMALL * best.radius) {
    half /= 2;
    squares = squares.flatMap(({x, y}) => QUARTERS.map(([i, j]) => look(x + i * half, y + j * half)));
    const largest = squares.reduce((one, other) => one.clearance > other.clearance ? one : other);
    if (largest.clearance > best.radius) grow(largest);
    squares = squares.filter(couldBeLarger);
  }
  squares.sort((one, other) => other.clearance - one.clearance);
  for (const square of squares.slice(0, fine ? MOST_GROWN : 0))
    if (square.clearance > 0 && couldBeLarger(square)) grow(square);
  return best;
}
