// The robot in the plane and in the space of its joints: what is drawn of it.

const DASHES2 = {stretched: [7, 3], folded: [9, 3, 2, 3], "self-motion": [2, 3]};
const NAMES2 = {stretched: "Type 2: distal bars stretched", folded: "Type 2: distal bars folded",
  "self-motion": "Type 2: elbows coincide"};
const ALL_MODES = [[1, 1], [1, -1], [-1, 1], [-1, -1]];
const task = new View(byId("plane")), joints = new View(byId("joints"));
// parts: of the workspace in this working mode; aspect: the shaded one of them; disc: its largest.
let loci = null, parts = null, aspect = null, disc = null, trail = [], sketch = [], checked = null;
const shown = {ellipses: false, others: true};

// [x0, y0, x1, y1] of what both legs and the elbows reach.
function boundsOf([l11, l12, l21, l22, d]) {
  const r1 = l11 + l12, r2 = l21 + l22, high = Math.max(l11, l21, Math.min(r1, r2));
  return [Math.min(-d / 2 - l11, Math.max(-d / 2 - r1, d / 2 - r2)), -high,
    Math.max(d / 2 + l21, Math.min(-d / 2 + r1, d / 2 + r2)), high];
}

function fit() {
  for (const view of [task, joints]) view.measure();
  task.fit(boundsOf(p));
  joints.fit([-Math.PI, -Math.PI, Math.PI, Math.PI], joints.width < 300 ? 20 : 26);
}

// All that depends on the lengths and the mode. fine: whether there is time for the largest disc's last digits.
function survey(fine) {
  loci = lociOf(p);
  resurvey(fine);
}

function resurvey(fine) {
  parts = regionsOf(loci, p, modes);
  shade(aspectAt(pose.xi, -pose.assembly), fine);
}

const aspectAt = (point, sign) => sign ? regionAt(parts, point, sign) : null;

// Which aspect is shaded: that of the robot, or of a point that the pointer rests on.
function shade(region, fine = true) {
  aspect = region;
  disc = largestDisc(aspect, loci.holes.filter(hole => inMode(hole, modes)), fine);
  if (disc) disc.fine = fine;
}

function drawTaskBack(pen = task.back) {
  task.begin(pen);
  for (const region of parts.regions) {
    const polygons = polygonsOf(region).map(points => points.map(({x, y}) => task.at([x, y])));
    const look = region === aspect ? {fill: "c3", alpha: 0.29} : {fill: "ink", alpha: region.sign > 0 ? 0.09 : 0.04};
    pen.lines(polygons, {...look, closed: true});
  }
  if (shown.others) drawType2(pen, piece => !inMode(piece, modes), 0.3, 1.2);
  pen.lines(loci.arcs.map(arc => arc.points.map(point => task.at(point))), {ink: "ink", width: 1.6});
  drawType2(pen, piece => inMode(piece, modes), 1, 2.2);
  drawRule(pen);
}

function drawType2(pen, wanted, alpha, width) {
  for (const [kind, dash] of Object.entries(DASHES2)) {
    const lines = loci.task.filter(piece => piece.kind === kind && wanted(piece)).map(({rows}) =>
      rows.map(row => task.at(row)));
    if (lines.length) pen.lines(lines, {ink: "c4", width, dash, alpha});
  }
}

function drawRule(pen) {
  const {length, text} = scaleBar(0.25 * task.width / task.scale), y = task.height - 10;
  pen.lines([[[12, y - 5], [12, y], [12 + length * task.scale, y], [12 + length * task.scale, y - 5]]], {ink: "quiet"});
  pen.words(text, [18, y - 5], {ink: "quiet", size: 12});
}

// Of the trace what is drawn: all that a hand made, the last second that the robot moved by itself.
const shownTrail = () => motion ? trail.filter(({t}) => t > motion.t - 1) : trail;

function drawTaskFront(pen = task.front, alone = true) {
  if (alone) task.begin(pen);
  if (disc) {
    pen.circle(task.at([disc.x, disc.y]), disc.radius * task.scale, {ink: "c3", width: 2.2});
  }
  pen.lines([shownTrail().map(({tip}) => task.at(tip))], {ink: "c5", width: 1.8});
  drawSketch(pen);
  const left = task.at([-p[4] / 2, 0]), right = task.at([p[4] / 2, 0]), end = task.at(pose.xi);
  const [e1, e2] = pose.elbows.map(elbow => task.at(elbow));
  for (const [x, y] of [left, right])
    pen.lines([[[x, y], [x - 9, y + 15], [x + 9, y + 15]]], {ink: "quiet", fill: "line", closed: true});
  if (shown.ellipses) drawEllipses(pen, end);
  [[left, e1, end], [right, e2, end]].forEach((joints, leg) =>
    content.legs[leg].forEach((ink, k) => drawBar(pen, joints.slice(k, k + 2), ink)));
  const tip = task.at(tipOf(pose));
  if (robot.leg) drawBar(pen, [end, tip], content.legs[robot.leg - 1][1]);
  const label = (text, [x0, y0], [x1, y1]) => {
    const size = Math.hypot(x1 - x0, y1 - y0);
    if (size < 40) return;
    const ux = (y1 - y0) / size, uy = (x0 - x1) / size, out = uy > 0 ? -1 : 1;
    pen.words(text, [(x0 + x1) / 2 + 15 * out * ux, (y0 + y1) / 2 + 15 * out * uy + 4], {ink: "quiet", size: 12,
      align: "center"});
  };
  [["l11", left, e1], ["l12", e1, end], ["l21", right, e2], ["l22", e2, end]].forEach(each => label(...each));
  if (right[0] - left[0] > 40) pen.words("d", [(left[0] + right[0]) / 2, left[1] + 15], {ink: "quiet", size: 12,
    align: "center"});
  for (const joint of [left, right]) pen.circle(joint, 7, {fill: "ink"});
  for (const elbow of [e1, e2]) pen.circle(elbow, 7, {fill: "paper", ink: "ink", width: 2.5});
  if (robot.leg) {
    pen.circle(tip, 5, {fill: "c5", ink: "ink", width: 2});
    pen.words("tool", [tip[0] + 10, tip[1] + 4], {ink: "quiet", size: 12});
  }
  pen.circle(end, 9, {fill: "c4", ink: "ink", width: 2.5});
  const bars = [[left, e1], [e1, end], [right, e2], [e2, end]];
  if (disc) bars.push(labelDisc(pen, bars));
  if (idle && alone) {
    const [x, y] = end, half = 60;  // px, of the words
    const far = ([u, v]) => Math.min(u - half, task.width - u - half, ...[-half, 0, half].flatMap(
      across => bars.map(bar => distanceToBar([u + across, v], bar))));
    const places = [-1, 1].flatMap(side => [-22, 0, 26].map(down => [x + side * (half + 18), y + down]));
    places.push([x, y - 26], [x, y + 34]);
    pen.words("Drag this point", places.reduce((best, place) => far(place) > far(best) ? place : best),
      {size: 15, align: "center"});
  }
}

// The radius, inside of the disc or, if it is small, above or below it: where it is farthest from all bars. Returns the
// line along it.
function labelDisc(pen, bars) {
  const [x, y] = task.at([disc.x, disc.y]), radius = disc.radius * task.scale, far = Math.abs(radius - 14);
  const places = [[x, y - far], [x, y + far]];
  if (radius < 30) places.splice(0, 2, [x, y - radius - 14], [x, y + radius + 14]);
  else if (radius > 60) places.push([x, y], [x - radius + 34, y], [x + radius - 34, y]);
  const clear = place => Math.min(...bars.map(bar => distanceToBar(place, bar)));
  const [u, v] = places.reduce((best, place) => clear(place) > clear(best) ? place : best);
  pen.words(radiusText(), [u, v + 4], {ink: "c3", align: "center"});
  return [[u - 34, v], [u + 34, v]];
}

function distanceToBar([x, y], [[x0, y0], [x1, y1]]) {
  const dx = x1 - x0, dy = y1 - y0, along = ((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy || 1);
  const share = Math.min(Math.max(along, 0), 1);
  return Math.hypot(x - x0 - share * dx, y - y0 - share * dy);
}

// A rim in the colour of the text sets a bar off from every ground.
function drawBar(pen, ends, ink) {
  pen.lines([ends], {ink: "ink", width: 8.5});
  pen.lines([ends], {ink, width: 6});
}

// Ends of the motors' unit speeds and unit torques at the end-effector: ellipses of velocity and of force.
function drawEllipses(pen, end) {
  const {J} = gains(pose.xi, modes, [0, 0], p), [[a, b], [c, d]] = J, det = a * d - b * c;
  if (!Number.isFinite(det)) return;
  const ring = matrix => Array.from({length: 73}, (_, k) => {
    const x = Math.cos(TURN * k / 72), y = Math.sin(TURN * k / 72);
    return [matrix[0][0] * x + matrix[0][1] * y, matrix[1][0] * x + matrix[1][1] * y];
  });
  const placed = (points, most) => {
    const size = Math.max(...points.map(point => Math.hypot(...point))), scale = most / size;
    return points.map(([x, y]) => [end[0] + scale * x, end[1] - scale * y]);
  };
  const room = 0.2 * Math.min(task.width, task.height);
  pen.lines([placed(ring(J), room)], {ink: "c0", width: 2});
  if (det) pen.lines([placed(ring([[d / det, -c / det], [-b / det, a / det]]), room)], {ink: "c1", width: 2,
    dash: [5, 3]});
  const angle = force.angle, tip = [end[0] + room * Math.cos(angle), end[1] - room * Math.sin(angle)];
  drawArrow(pen, end, tip, "ink");
}

function drawArrow(pen, [x0, y0], [x1, y1], ink, width = 2.2) {
  const size = Math.hypot(x1 - x0, y1 - y0);
  if (!(size > 2)) return;
  const [ux, uy] = [(x1 - x0) / size, (y1 - y0) / size], head = Math.min(11, size / 2);
  pen.lines([[[x0, y0], [x1, y1]], [[x1 - head * ux - head / 2 * uy, y1 - head * uy + head / 2 * ux], [x1, y1],
    [x1 - head * ux + head / 2 * uy, y1 - head * uy - head / 2 * ux]]], {ink, width});
}

function drawSketch(pen) {
  if (sketch.length < 2) return;
  if (!checked) return pen.lines([sketch.map(point => task.at(point))], {ink: "quiet", width: 3, dash: [3, 4]});
  pen.lines(checked.good.map(line => line.map(point => task.at(point))), {ink: "c3", width: 3.2});
  pen.lines(checked.open.map(line => line.map(point => task.at(point))), {ink: "c1", width: 3.2, dash: [4, 5]});
  for (const {point} of checked.marks) {
    const [x, y] = task.at(point);
    pen.lines([[[x - 7, y - 7], [x + 7, y + 7]], [[x - 7, y + 7], [x + 7, y - 7]]], {ink: "paper", width: 6});
    pen.lines([[[x - 7, y - 7], [x + 7, y + 7]], [[x - 7, y + 7], [x + 7, y - 7]]], {ink: "c4", width: 3});
  }
}

// Joint space: lines broken where an angle jumps by a turn.
function unbroken(rows) {
  const lines = [];
  let line = [], x0 = NaN, y0 = NaN;
  for (const row of rows) {
    if (Math.abs(row[2] - x0) > 3 || Math.abs(row[3] - y0) > 3) { lines.push(line); line = []; }
    [x0, y0] = [row[2], row[3]];
    line.push(joints.at([x0, y0]));
  }
  lines.push(line);
  return lines;
}

function drawJointsBack(pen = joints.back) {
  joints.begin(pen);
  const [x0, y1] = joints.at([-Math.PI, -Math.PI]), [x1, y0] = joints.at([Math.PI, Math.PI]);
  pen.lines([[[x0, y0], [x1, y0], [x1, y1], [x0, y1]]], {ink: "line", closed: true});
  pen.lines([[joints.at([-Math.PI, 0]), joints.at([Math.PI, 0])], [joints.at([0, -Math.PI]), joints.at([0, Math.PI])]],
    {ink: "line", width: 1});
  const own = piece => piece.signs[2] === 0 || piece.signs[2] === -pose.assembly;
  for (const [mine, alpha] of [[false, 0.25], [true, 1]]) {
    const pieces = loci.joint.filter(piece => piece.type === 1 && own(piece) === mine);
    for (const [leg, dash] of [["left", []], ["right", []]])
      pen.lines(pieces.filter(({kind}) => kind.startsWith(leg)).flatMap(({rows}) => unbroken(rows)),
        {ink: leg === "left" ? "c0" : "c1", width: mine ? 1.6 : 1.1, dash, alpha});
  }
  for (const [kind, dash] of Object.entries(DASHES2))
    pen.lines(loci.joint.filter(piece => piece.type === 2 && piece.kind === kind).flatMap(({rows}) => unbroken(rows)),
      {ink: "c4", width: 2.2, dash});
  const size = joints.width < 300 ? 11 : 12;
  pen.words("q1", [x1 - 4, joints.at([0, 0])[1] - 5], {ink: "quiet", size, align: "right"});
  pen.words("q2", [joints.at([0, 0])[0] + 5, y0 + 14], {ink: "quiet", size});
}

function drawJointsFront(pen = joints.front, alone = true) {
  if (alone) joints.begin(pen);
  const lines = [[]];
  shownTrail().forEach(({q}, k, traced) => {
    const before = k ? traced[k - 1].q : q;
    if (q.some((x, i) => Math.abs(x - before[i]) > 3)) lines.push([]);
    lines[lines.length - 1].push(joints.at(q));
  });
  pen.lines(lines, {ink: "c5", width: 1.8});
  pen.circle(joints.at(pose.q), 8, {fill: "c4", ink: "ink", width: 2.5});
}
