// The page of motions: `at` is the index of the sample shown, on the clock that all subjects share.

const {subjects, panels, axis} = content, several = subjects.length > 1;
for (const subject of subjects) subject.x ??= subject.t;

// The times of all subjects, those that differ by rounding once; a single subject's own abscissa.
const clock = several ? union(subjects.map(subject => subject.t)) : subjects[0].x;
const times = several ? clock : subjects[0].t;
let at = 0;

function union(arrays) {
  const all = Float64Array.from(arrays.flatMap(values => [...values])).sort(), [low, high] = extent(arrays);
  return all.filter((x, k) => k === 0 || x - all[k - 1] > 1e-9 * (high - low));
}

const shownAt = (subject, index = at) => several ? nearest(subject.t, clock[index]) : index;
const abscissa = index => axis.scale * clock[index];
const largestX = Math.max(...extent([clock]).map(Math.abs)) * axis.scale;
const clockText = () => `${readable(settled(abscissa(at), largestX))} ${axis.unit}`;
const where = () => `${axis.name} ${clockText()}`;

// The picture -----------------------------------------------------------------------------------------------------

const differs = (a, b) =>
  a.some((values, k) => values.length !== b?.[k].length || values.some((x, n) => x !== b[k][n]));
const joint = (subject, k, index) =>
  subject.joints[k].map(x => typeof x === "number" ? x : x[index]);
const traced = subject => subject.joints[subject.traced].map(x =>
  typeof x === "number" ? new Float64Array(subject.t.length).fill(x) : x);
const columnsOf = (of, k) => of.flatMap(subject =>
  [...subject.joints, ...(subject.reference ? [subject.reference] : [])].map(([...pair]) =>
    typeof pair[k] === "number" ? [pair[k]] : pair[k]));

// Each of several subjects, and of a linkage's curves, has a colour and dashes; the ink is left to the joints while
// there are others.
const look = k => several || subjects[0].names.length ? [0, 1, 3, 4, 5, 2][k % 6] : k % 6;

// All subjects in one picture, or each in its own, apart, in the colours of its links.
const frame = byId("picture"), {apart} = content, together = several && !apart;
const bounds = around(columnsOf(subjects, 0), columnsOf(subjects, 1));  // of all: pictures apart have one scale
const pictures = (apart ? subjects : [{}]).map(({name}) => {
  const own = element("div", {}, ...(apart ? [element("h2", {title: name}, name)] : []));
  byId("scenes").append(own);
  return new Picture(own, bounds, name || content.title);
});
const scene = pictures[0], sceneOf = k => pictures[apart ? k : 0];
document.body.classList.toggle("apart", !!apart);
const mechanisms = subjects.map((subject, k) => {
  const own = sceneOf(k);
  if (subject.reference && (apart || k === 0 || differs(subject.reference, subjects[0].reference)))
    own.path(...subject.reference, together ? "--line" : "--c3", 6, [], {opacity: 0.7});
  own.path(...traced(subject), together ? "--c" + look(k) : "--c4", 2, together ? dash(k) : [], {class: "trace"});
  return own.mechanism({
    ...subject, bars: subject.bars.map(([i, j, ink]) => [i, j, together ? "--c" + look(k) : ink]),
    letters: subject.names, opacity: together ? 0.8 : 1, mark: k % 2 ? "square" : "round",
  });
});
const state = element("span", {class: "state"});
frame.append(element("div", {class: "under"}, state,
  button("−", "picture: zoom out", () => magnify(1 / 2)),
  button("+", "picture: zoom in on the point of the path", () => magnify(2)),
  button("Fit", "picture: fit all in", () => magnify(0))));
frame.append(pathLegend());
const marks = subjects.flatMap(subject => subject.marks.map(([t, text]) => {
  const label = `${several ? subject.name + ": " : ""}${text} at ${readable(t)} s`;
  return button(label, `go to ${label}`, () => go(nearest(clock, t)));
}));
if (marks.length)
  frame.append(element("div", {class: "under", role: "group", "aria-label": "singularities"}, ...marks));

function pathLegend() {
  const named = (text, ink, width, dashes = []) =>
    entry(swatch(ink, width, dashes), element("span", {class: "name"}, text));
  const entries = together
    ? subjects.map((subject, k) => named(subject.name, "--c" + look(k), 2, dash(k)))
    : [named("path", "--c4", 2)];
  if (subjects.some(subject => subject.reference)) entries.push(named("reference", together ? "--line" : "--c3", 6));
  if (!together) entries.push(...subjects[0].key.map(([name, inks]) => named(name, inks, 6)));
  return element("ul", {class: "legend", "aria-label": "colours of the picture"}, ...entries);
}

function magnify(factor) {
  for (const own of pictures) own.zoom = factor ? Math.min(Math.max(own.zoom * factor, 1), 1024) : 1;
  draw();
}

// The sample whose traced point is nearest to the pointer, within that many pixels of it.
function pointAtPath(own, event, within) {
  const box = own.svg.getBoundingClientRect(), px = event.clientX - box.left, py = event.clientY - box.top;
  let best = within * within, found = null;
  for (const subject of subjects.filter((_, k) => sceneOf(k) === own)) {
    const [xs, ys] = traced(subject);
    for (let index = 0; index < xs.length; index++) {
      const [x, y] = own.onScreen([xs[index], ys[index]]), far = (x - px) ** 2 + (y - py) ** 2;
      if (far < best) [best, found] = [far, several ? nearest(clock, subject.t[index]) : index];
    }
  }
  if (found !== null) go(found);
}
for (const own of pictures) {
  own.svg.addEventListener("pointermove", event => pointAtPath(own, event, event.buttons ? 1e4 : 24));
  own.svg.addEventListener("pointerdown", event => pointAtPath(own, event, 1e4));
  own.svg.addEventListener("wheel", event => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    magnify(event.deltaY < 0 ? 2 : 1 / 2);
  }, {passive: false});
}
