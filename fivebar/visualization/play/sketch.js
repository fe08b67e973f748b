// A drawn path, checked at once in the working mode at hand: where the robot gets, where it crosses Type 2.

function checkSketch() {
  checked = null;
  if (sketch.length < 2) return;
  const good = [], open = [], marks = [];
  let length = 0, first = null, line = [], reached = null, before = null;
  const push = () => { if (line.length > 1) (reached ? good : open).push(line); };
  for (const point of dense(sketch, 1.5 / task.scale)) {
    const found = igm(point, modes, p), closes = Boolean(found.closes);
    if (before) length += Math.hypot(point[0] - before.point[0], point[1] - before.point[1]);
    if (reached !== null && closes !== reached) {
      const at = between(before.point, point, each => Boolean(igm(each, modes, p).closes) === reached);
      line.push(at);
      push();
      line = [at];
      if (reached && first === null) first = length;
    }
    if (closes && before?.closes && found.parallel * before.found.parallel < 0) {
      const sign = Math.sign(before.found.parallel);
      const at = between(before.point, point, each => Math.sign(igm(each, modes, p).parallel) === sign);
      const {elbows: [e1, e2]} = igm(at, modes, p), apart = Math.hypot(e1[0] - e2[0], e1[1] - e2[1]);
      marks.push({point: at, kind: apart < 1e-3 * sizeOf() ? "the elbows coincide"
        : apart > Math.max(p[1], p[3]) ? "the distal bars are stretched" : "the distal bars are folded"});
    }
    reached = closes;
    line.push(point);
    before = {point, closes, found};
  }
  push();
  const parts = [`Path of ${lengthText(length)} in working mode ${modes.map(sign).join(", ")}:`];
  if (open.length) parts.push(first === null ? "it begins out of reach;"
    : `it leaves the workspace after ${lengthText(first)};`);
  if (marks.length)
    parts.push(`it crosses Type 2 ${marks.length === 1 ? "once" : `${marks.length} times`}, at ` +
      marks.slice(0, 3).map(({point, kind}) =>
        `(${point.map(x => number(1e3 * x)).join(", ")}) mm, where ${kind}`).join("; ") +
      (marks.length > 3 ? " and so on." : "."));
  else parts.push(open.length ? "no crossing of Type 2 where it is reached."
    : "reached all along, free of singularities.");
  checked = {good, open, marks, words: parts.join(" ")};
}

// The polyline with points no farther apart than this.
function dense(points, step) {
  const found = [points[0]];
  for (let k = 1; k < points.length; k++) {
    const [x0, y0] = points[k - 1], [x1, y1] = points[k], count = Math.min(400,
      Math.ceil(Math.hypot(x1 - x0, y1 - y0) / step) || 1);
    for (let n = 1; n <= count; n++) found.push([x0 + (x1 - x0) * n / count, y0 + (y1 - y0) * n / count]);
  }
  return found;
}

// The last point on the way from a to b for which `holds`, by halving.
function between(a, b, holds) {
  let low = 0, high = 1;
  const at = share => [a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share];
  for (let k = 0; k < 48; k++) {
    const middle = (low + high) / 2;
    if (holds(at(middle))) low = middle; else high = middle;
  }
  return at(low);
}
