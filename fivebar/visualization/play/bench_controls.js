// What the page of a linkage is set by, and what it gives away.

// Undo: the states before each change, as their addresses.
const labPast = [];
const rememberLab = () =>
  { if (lab.values && labPast[labPast.length - 1] !== linkageFragment()) labPast.push(linkageFragment()); };

function undoLab() {
  const now = linkageFragment();
  while (labPast.length && labPast[labPast.length - 1] === now) labPast.pop();
  if (!labPast.length) {
    lab.said = "Nothing to undo.";
    return benchFrame();
  }
  const {kind, values, branch, q} = readLinkage(labPast.pop()).state;
  chooseKind(kind, values, branch, q);
}

function linkagePython() {
  const v = lab.values, sign_ = lab.branch.length > 1 ? `(${lab.branch.join(", ")})` : lab.branch[0];
  const made = lab.kind === "four" ? `linkages.FourBar(${v.slice(0, 4).join(", ")}, point=(${v[4]}, ${v[5]}))`
    : lab.kind === "press" ? "replace(linkages.PRESSES[\"repaired\"][0], " +
      `${["l2", "l3", "l4", "l5", "l11"].map((name, k) => `${name}=${v[k]}`).join(", ")})`
      : `linkages.SliderCrank(${v.join(", ")}, held="${lab.kind.slice(7)}")`;
  return `${lab.kind === "press" ? "from dataclasses import replace\n" : ""}from fivebar import linkages

linkage = ${made}
print(*linkages.verdict(linkage, ${sign_}), sep="\\n")
motion = linkages.move(linkage, ${lab.q}, branch=${sign_})
study = linkages.study(linkage, branch=${sign_}${lab.sweep.full ? "" : ', drive="swing"'})
study.page("study.html")
`;
}

function chooseKind(kind, values = kinds[kind].parameters.map(({value}) => value), branch = kinds[kind].branch,
  q = lab.q) {
  Object.assign(lab, {kind, branch: [...branch], q, trail: [], ghost: null, preset: ""});
  if (!refit(values)) return false;
  buildBench();
  relabbed();
  return true;
}

function arrowCheck(name, text, inks) {
  const made = check(text, arrows[name], on => { arrows[name] = on; fitBench(); benchFrame(); });
  made.text.append(...inks.flatMap(([ink, word]) => [" ", swatch(ink, 3), ` ${word}`]));
  return made.label;
}

// What a length is called where its own name says too little.
const LENGTH_WORDS = {along: "M along BC", across: "M off BC", l2: "l2, crank", l3: "l3, coupler", l4: "l4, rocker",
  l5: "l5, bar CE", l11: "l11, ground"};

function buildBench() {
  const {parameters, title} = wordsOf();
  const rows = parameters.map(({name: own, signed}, k) => {
    const name = LENGTH_WORDS[own] ?? own;
    const most = Math.max(...lab.values.map(Math.abs), 0.1) * 2;
    const range = element("input", {type: "range", min: signed ? -most : 0.002, max: most, step: "any",
      "aria-label": `${name}, mm`});
    const input = element("input", {type: "number", step: "any", "aria-label": `${name}, mm`});
    const show = () => {
      range.value = lab.values[k];
      range.setAttribute("aria-valuetext", `${number(1e3 * lab.values[k])} mm`);
      input.value = +(1e3 * lab.values[k]).toPrecision(6);
    };
    const change = value => {
      if (!(Math.abs(value) <= 10) || (!signed && !(value >= 0.001)))
        lab.said = `${name} must be between ${signed ? "−10000" : "1"} and 10000 mm: kept as it was.`;
      else refit(lab.values.map((x, i) => i === k ? value : x));
    };
    range.oninput = () => {
      if (!lab.ghost) rememberLab();
      lab.ghost ??= lab.sweep.rows;
      change(Math.round(+range.value * 1e6) / 1e6);
      show();
      relabbed(false);
    };
    range.onchange = () => { lab.ghost = null; show(); relabbed(); };
    input.onchange = () => { rememberLab(); change(input.value === "" ? NaN : +input.value / 1e3); show(); relabbed();
      };
    show();
    return element("div", {class: "slide"}, element("span", {"aria-hidden": "true"}, name), range, input);
  });
  const run = button(lab.running ? "Pause" : "Run", "Run or Pause: the crank turns, back and forth where it locks (space)", toggleRun);
  run.id = "run";
  const four = lab.kind === "four", slider_ = lab.kind.startsWith("slider");
  const preset = element("select", {"aria-label": "linkage by name"}, element("option", {value: ""}, "named linkages …"),
    ...[...Object.keys(straight), "crank-rocker"].map(name => element("option", {value: name}, name)));
  preset.onchange = () => {
    const own = straight[preset.value];
    rememberLab();
    if (!own) return chooseKind("four");
    lab.q = (own.stroke[0] + own.stroke[1]) / 2;
    Object.assign(lab, {kind: "four", branch: [...own.branch], trail: [], ghost: null});
    refit([...own.values]);
    lab.preset = preset.value;
    buildBench();
    relabbed();
  };
  const held = ["guide", "crank", "rod", "slider"].map(name => {
    const made = button(name, `fix the ${name}`, () => { rememberLab(); chooseKind(`slider_${name}`, [...lab.values]);
      });
    made.setAttribute("aria-pressed", lab.kind === `slider_${name}`);
    return made;
  });
  const sign_ = which => button(lab.branch.length > 1 ? `branch ${which + 1}` : "other branch",
    "the other branch of the same crank angle", () => {
    const branch = lab.branch.map((each, k) => k === which ? -each : each);
    if (!at_(lab.q, branch).closes) lab.said = "At this crank angle that branch does not close.";
    else {
      lab.branch = branch;
      lab.trail = [];
      resweep();
    }
    relabbed();
  });
  const printed = button("crank of 202 mm", "crank of 202 mm, as in the paper on this press: it cannot turn fully", () => {
    rememberLab();
    chooseKind("press", [0.202, ...lab.values.slice(1)]);
  });
  const python_ = element("pre", {tabindex: 0, "aria-label": "as Python"});
  const pythonBox_ = element("details", {}, element("summary", {}, "as Python"), python_);
  pythonBox_.ontoggle = () => { python_.textContent = linkagePython(); };
  const curves = element("ul", {class: "legend", "aria-label": "curves"},
    legendEntry("--c4", 2, [], "path of the point"), legendEntry("--c4", 1.4, [7, 4], "on the other branch"));
  byId("linkage-panel").replaceChildren(
    field_(`${title[0].toUpperCase()}${title.slice(1)}, lengths in mm`,
      ...(four ? [element("div", {class: "row"}, preset)] : []),
      ...(slider_ ? [element("div", {class: "row"}, element("span", {}, "fixed link:"), ...held)] : []), ...rows),
    field_("Motion", element("div", {class: "row"}, run, benchPace, sign_(0), ...(lab.branch.length > 1 ? [sign_(1)] : []),
      ...(four ? [button("fix the next link", "fix the next link, and drive the one after it (inversion)", () => {
        rememberLab();
        if (invert()) { buildBench(); relabbed(); }
      })] : []), ...(lab.kind === "press" ? [printed] : []),
      button("Clear trace", "clear the trace", () => { lab.trail = []; benchFrame(); }))),
    field_("Curves and arrows", curves, arrowCheck("velocity", "velocity of the point", [["--ink", ""]]),
      arrowCheck("acceleration", "its acceleration:", [["--c5", "tangential"], ["--c4", "normal"]])),
    element("div", {class: "row"}, button("Undo", "undo (Ctrl Z)", undoLab),
      button("PNG", "save the linkage's picture as PNG", () => savePicture(bench, drawBench, true)),
      button("SVG", "save the linkage's picture as SVG", () => savePicture(bench, drawBench, false)),
      button("Copy link", "Copy link to this linkage", () => copyLink(linkageFragment()))),
    pythonBox_,
    element("details", {id: "linkage-help"}, element("summary", {}, "Pointer and keys"),
      "Drag to turn the crank" + (four ? "; drag the coupler point M to place it" : "") +
        ". ← → turn the crank, with Shift " +
      "finely; space runs and pauses. Solid: the path of the traced point; dashed: on the other branch; dotted: " +
      "before the change. Speeds and accelerations are those at one turn a second; 0.25 × shows it four times slower."));
}

function toggleRun() {
  lab.running = !lab.running;
  byId("run").textContent = lab.running ? "Pause" : "Run";
  benchBefore = performance.now();
  benchFrame();
}

function showLinkage(id) {
  if (!lab.values) {
    Object.assign(lab, {values: kinds.four.parameters.map(({value}) => value)});
    resweep();
  }
  const wantedKind = {four: "four", slider: "slider_guide", press: "press"}[id];
  if (wantedKind && !lab.kind.startsWith(wantedKind.split("_")[0])) chooseKind(wantedKind);
  else if (lab.values) { buildBench(); relabbed(); }
}
