// Fields of pixels over the plane: what is reached in the working mode, of which sign det A is, which part hangs
// together with the point at hand, and the largest disc there. Approximate, as fine as its pixels.

const fields = new Map();  // by size, used again and again: nothing is allocated while a slider moves

function fieldOf(size) {
  if (!fields.has(size)) {
    const count = size * size;
    fields.set(size, {size, sign: new Int8Array(count), part: new Uint8Array(count), stack: new Int32Array(count),
      square: new Float64Array(count), line: new Float64Array(size), hull: new Int32Array(size),
      cuts: new Float64Array(size + 1), out: new Float64Array(1), point: new Float64Array(2)});
  }
  return fields.get(size);
}

// bounds [x0, y0, x1, y1], a square; fills `sign` (0 out of reach) in this working mode.
function fillField(field, p, modes, [x0, y0, x1]) {
  const {size, sign, out, point} = field, step = (x1 - x0) / size;
  Object.assign(field, {x0, y0, step, reached: 0});
  for (let j = 0, k = 0; j < size; j++) {
    point[1] = y0 + (j + 0.5) * step;
    for (let i = 0; i < size; i++, k++) {
      point[0] = x0 + (i + 0.5) * step;
      const value = sense(point, modes, p, out)[0];
      sign[k] = value > 0 ? 1 : value < 0 ? -1 : 0;
      if (sign[k]) field.reached++;
    }
  }
  return field;
}

const pixelAt = ({size, x0, y0, step}, [x, y]) => {
  const i = Math.floor((x - x0) / step), j = Math.floor((y - y0) / step);
  return i >= 0 && j >= 0 && i < size && j < size ? j * size + i : -1;
};

// `part`: 1 where the aspect of the point is. The point may be a pixel off: its neighbours are tried.
function fillPart(field, point) {
  const {size, sign, part, stack} = field, at = pixelAt(field, point);
  part.fill(0);
  field.count = 0;
  const wanted = field.wanted, near = [0, 1, -1, size, -size].map(shift => at + shift)
    .find(k => at >= 0 && k >= 0 && k < size * size && sign[k] === wanted);
  if (near === undefined) return field;
  let top = 0;
  stack[top++] = near;
  part[near] = 1;
  while (top) {
    const k = stack[--top], i = k % size;
    field.count++;
    if (i > 0 && !part[k - 1] && sign[k - 1] === wanted) { part[k - 1] = 1; stack[top++] = k - 1; }
    if (i < size - 1 && !part[k + 1] && sign[k + 1] === wanted) { part[k + 1] = 1; stack[top++] = k + 1; }
    if (k >= size && !part[k - size] && sign[k - size] === wanted) { part[k - size] = 1; stack[top++] = k - size; }
    if (k < size * (size - 1) && !part[k + size] && sign[k + size] === wanted) {
      part[k + size] = 1;
      stack[top++] = k + size;
    }
  }
  return field;
}

// One dimension of the squared distance transform of Felzenszwalb and Huttenlocher, in place.
function lower(field, start, stride) {
  const {size, square, line, hull, cuts} = field;
  let last = 0;
  for (let i = 0; i < size; i++) line[i] = square[start + i * stride];
  hull[0] = 0;
  cuts[0] = -Infinity;
  cuts[1] = Infinity;
  for (let i = 1; i < size; i++) {
    let at;
    do {
      const h = hull[last];
      at = (line[i] + i * i - line[h] - h * h) / (2 * (i - h));
    } while (at <= cuts[last] && --last >= 0);
    hull[++last] = i;
    cuts[last] = at;
    cuts[last + 1] = Infinity;
  }
  for (let i = 0, k = 0; i < size; i++) {
    while (cuts[k + 1] < i) k++;
    square[start + i * stride] = (i - hull[k]) ** 2 + line[hull[k]];
  }
}

// The largest disc in the part, {x, y, radius} in m: found by pixels, then by the distance to the curves.
function largestDisc(field, loci, modes) {
  const {size, part, square, step, x0, y0} = field;
  if (!field.count) return null;
  const far = 4 * size * size;
  for (let k = 0; k < part.length; k++) square[k] = part[k] ? far : 0;
  for (let i = 0; i < size; i++) {  // what is beyond the field is no part of it
    square[i] = Math.min(square[i], 1);
    square[i + size * (size - 1)] = Math.min(square[i + size * (size - 1)], 1);
    square[i * size] = Math.min(square[i * size], 1);
    square[i * size + size - 1] = Math.min(square[i * size + size - 1], 1);
  }
  for (let i = 0; i < size; i++) lower(field, i, size);
  for (let j = 0; j < size; j++) lower(field, j * size, 1);
  let best = 0;
  for (let k = 1; k < square.length; k++) if (square[k] > square[best]) best = k;
  const active = loci.task.filter(piece => inMode(piece, modes)), room = (x, y) => roomAt(x, y, loci.arcs, active);
  // From the pixel's middle uphill on the distance to the curves themselves, no farther than the disc holds.
  let x = x0 + (best % size + 0.5) * step, y = y0 + (Math.floor(best / size) + 0.5) * step, radius = room(x, y);
  for (let h = Math.min(step, radius / 2), left = 40; h > step / 50 && left > 0; left--) {
    let better = false;
    for (const [dx, dy] of [[h, 0], [-h, 0], [0, h], [0, -h]]) {
      const next = room(x + dx, y + dy);
      if (next > radius) [x, y, radius, better] = [x + dx, y + dy, next, true];
    }
    if (!better) h /= 2;
  }
  return {x, y, radius};
}

// Distance to the arcs, exact, and to the chords of the pieces, m.
function roomAt(x, y, arcs, pieces) {
  let nearest = Infinity;
  for (const {x: cx, radius, from, to, points} of arcs) {
    const turn = Math.atan2(y, x - cx) - from, within = turn - TURN * Math.floor(turn / TURN) <= to - from;
    if (within) nearest = Math.min(nearest, (Math.hypot(x - cx, y) - radius) ** 2);
    else for (const [px, py] of [points[0], points[points.length - 1]])
      nearest = Math.min(nearest, (px - x) ** 2 + (py - y) ** 2);
  }
  for (const {rows} of pieces)
    for (let k = 1; k < rows.length; k++) {
      const ax = rows[k - 1][0], ay = rows[k - 1][1], dx = rows[k][0] - ax, dy = rows[k][1] - ay;
      const along = ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1), share = along < 0 ? 0 : along > 1 ? 1
        : along;
      nearest = Math.min(nearest, (ax + share * dx - x) ** 2 + (ay + share * dy - y) ** 2);
    }
  return Math.sqrt(nearest);
}
