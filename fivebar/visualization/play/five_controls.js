// What the page of the five-bar is set by: lengths, modes, what happens at singularities, motion, files.

const field_ = (title, ...parts) => element("fieldset", {}, element("legend", {}, title), ...parts);
const check = (text, checked, action = () => {}) => {
  const input = element("input", {type: "checkbox", ...(checked ? {checked: ""} : {})});
  input.onchange = () => action(input.checked);
  return {input, label: element("label", {class: "check"}, input, element("span", {}, text))};
};

// Lengths: a slider and a number each, mm.
const names = {l11: "left proximal bar", l12: "left distal bar", l21: "right proximal bar", l22: "right distal bar",
  d: "base"};
const sliders = LENGTHS.map((name, k) => lengthSlider(name, name, `${name}, ${names[name]}`, () => p[k], value => {
  const next = p.map((x, i) => i === k || (mirror.input.checked && i < 4 && i === (k + 2) % 4 && k < 4) ? value : x);
  if (reshape(next)) said = "";
}));
let slidingTop = 0;

function lengthSlider(name, label, title, get, set) {
  const range = element("input", {type: "range", min: 0, max: 1000, step: "any", "aria-label": `${title}, mm`});
  const input = element("input", {type: "number", step: "any", min: 0, "aria-label": `${title}, mm`});
  const [low, high] = name === "d" ? LIMITS.d : LIMITS.length;
  const change = value => {
    if (!Number.isFinite(value)) return;
    halt();
    set(Math.min(Math.max(value, low), high));
    reshaped();
    showSliders(range);
    moved();
  };
  let begun = false;
  range.oninput = () => {
    if (!begun) remember();
    begun = true;
    change(Math.round(2 * range.value) * slidingTop / 2e6);  // of 200 mm, whole tenths
  };
  range.onchange = () => { begun = false; showSliders(); };
  input.onchange = () => {
    remember();
    if (input.value === "" || !(+input.value >= 1e3 * low && +input.value <= 1e3 * high)) {
      said = `${name} must be between ${mm(low)} and ${mm(high)}: kept as it was.`;
      showSliders();
      return ask();
    }
    change(+input.value / 1e3);
    showSliders();
  };
  return {get, range, input, row: element("div", {class: "slide", title}, element("span", {"aria-hidden": "true"},
    label), range, input)};
}

function showSliders(but) {
  const largest = Math.max(...p, wanted);
  if (!but) slidingTop = [50, 100, 150, 200, 300, 500, 800, 1200, 2000, 4000, 8000, 20000].find(top =>
    top >= 1.6e3 * largest) ?? 2e4;
  for (const {get, range, input} of [...sliders, wantedSlider]) {
    if (range !== but) range.value = 1e6 * get() / slidingTop;
    if (document.activeElement !== input || !but) input.value = +(1e3 * get()).toPrecision(6);
  }
  for (const [k, button_] of modeButtons.entries()) button_.setAttribute("aria-pressed",
    ALL_MODES[k].join() === modes.join());
}

const mirror = check("both legs alike", LENGTHS.slice(0, 2).every((name, k) => robot[name] === robot[LENGTHS[k + 2]]),
  on => {
  if (!on) return;
  remember();
  reshape([p[0], p[1], p[0], p[1], p[4]]);
  showSliders();
  reshaped();
});
const wantedSlider = lengthSlider("disc", "radius", "wanted disc, radius", () => wanted, value => { wanted = value; });
const preset = element("select", {"aria-label": "robot by name"}, element("option", {value: ""}, "named robots …"),
  ...Object.keys(content.presets).map(name => element("option", {value: name}, name)));
const source = element("p", {class: "source"});
preset.onchange = () => {
  const chosen = content.presets[preset.value];
  if (!chosen) return;
  remember();
  halt();
  sketch = [];
  checked = null;
  wanted = chosen.wanted;
  restore({robot: chosen.robot, modes: chosen.working, xi: chosen.xi});
  mirror.input.checked = p[0] === p[2] && p[1] === p[3];
  source.textContent = `${chosen.source}.${chosen.robot.dry ? " Its dry friction is left out here." : ""}`;
};

const signs = mode => mode.map(each => each > 0 ? "+" : "−").join("");
const modeButtons = ALL_MODES.map((mode, k) => button(signs(mode),
  `working mode ${mode.map(sign).join(", ")} (key ${k + 1})`, () => {
  remember();
  halt();
  toModes(mode);
  moved();
  showSliders();
}));
const assemblyButton = button("other assembly", "the other assembly mode of the same motor angles (key 0)", () => {
  remember();
  halt();
  toAssembly(-pose.assembly);
  moved();
  showSliders();
});
byId("panel").append(
  field_("Robot, lengths in mm", element("div", {class: "row"}, preset, button("Undo", "undo (Ctrl Z)", undo)), source,
    ...sliders.map(({row}) => row), mirror.label),
  field_("Wanted disc (mm)", wantedSlider.row),
  field_("Working mode, left and right leg", element("div", {class: "row"}, ...modeButtons, assemblyButton),
    check("Type 1: passing it changes the working mode", false, on => { choices.type1 = on; }).label,
    check("Type 2: let it pass (else it is a border)", false, on => { choices.type2 = on; }).label,
    check("show the other modes' loci, pale", true, on => { shown.others = on; ask({back: true}); }).label));

// What else: force, motion, path, files.
const ellipses = check("ellipses of velocity (solid) and force (dashed), and the force", false, on =>
  { shown.ellipses = on; ask(); });
const angle = element("input", {type: "range", min: 0, max: 360, value: 90, step: 1,
  "aria-label": "direction of the force, degrees"});
angle.oninput = () => { force.angle = +angle.value * Math.PI / 180; ask(); };
const torqueKind = element("select", {"aria-label": "torque while it moves"},
  ...[["wave", "torque to and fro, cos 2πt"],
  ["constant", "constant torque"], ["none", "no torque"]].map(([value, text]) => element("option", {value}, text)));
const torqueInputs = [0.02, -0.016].map((value, k) =>
  element("input", {type: "number", step: "any", value, "aria-label": `torque of motor ${k + 1}, N m`}));
const goButton = button("Let go", "let the robot move by itself (key G)", () => flying ? halt() : release());
goButton.setAttribute("aria-pressed", "false");
const paceInput = element("select", {"aria-label": "pace"}, ...[1, 0.3, 0.1].map(pace =>
  element("option", {value: pace}, `${pace} × time`)));
const throws = check("throw it: what is dragged and released flies on", false), throwing = throws.input;
const gravity = check("gravity, downwards", robot.gravity.some(Boolean), on => {
  remember();
  halt();
  robot.gravity = on ? [0, -9.81] : [0, 0];
  ask();
  keepFragment();
});
const inertias = ["zz1", "zz2", "m"].map(name => {
  const input = element("input", {type: "number", step: "any", min: 0, value: robot[name],
    "aria-label": `${name}, ${name === "m" ? "kg" : "kg m²"}`});
  input.onchange = () => {
    const value = +input.value;
    if (input.value === "" || !(value >= 0 && value <= 1e6)) said = `${name} must be 0 or more: kept as it was.`;
    else {
      remember();
      halt();
      robot[name] = value;
      keepFragment();
    }
    input.value = robot[name];
    ask();
  };
  return element("label", {class: "slide few"}, element("span", {}, `${name} (${name === "m" ? "kg" : "kg m²"})`),
    input);
});
const sketchBox = check("draw a path with the pointer: it is checked at once", false), sketching = sketchBox.input;
const python = element("pre", {tabindex: 0, "aria-label": "as Python"});
const pythonBox = element("details", {}, element("summary", {}, "as Python"), python);
pythonBox.ontoggle = () => { python.textContent = asPython(); };

function pictureSvg() {
  const pen = new SvgPen();
  drawTaskBack(pen);
  drawTaskFront(pen, false);
  return pen.text();
}

function picturePng() {
  const canvas = document.createElement("canvas"), pen = new CanvasPen(canvas), [ratio, scale] = [task.ratio, 2];
  task.ratio = scale;
  drawTaskBack(pen);
  pen.pen.globalCompositeOperation = "destination-over";
  pen.pen.globalAlpha = 1;
  pen.pen.fillStyle = inks.paper;
  pen.pen.fillRect(0, 0, task.width, task.height);
  pen.pen.globalCompositeOperation = "source-over";
  drawTaskFront(pen, false);
  task.ratio = ratio;
  canvas.toBlob(blob => save(blob, ".png"), "image/png");
}

async function copy(text, what) {
  let words = `${what} copied.`;
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    words = `The browser allows no copying here: the ${what} is ` +
      `${what === "link" ? "the address" : "in its box below"}.`;
  }
  if (byId("five").hidden) { lab.said = words; benchFrame(); } else { said = words; ask(); }
}

const legendEntry = (ink, width, dashes, text) => element("li", {}, element("span", {class: "entry"},
  swatch(ink, width, dashes), text));
byId("more").append(
  element("ul", {class: "legend", "aria-label": "colours"}, legendEntry("--ink", 2, [], "Type 1: a leg in line"),
    ...Object.entries(DASHES2).map(([kind, dash_]) => legendEntry("--c4", 2.2, dash_, NAMES2[kind])),
    legendEntry("--c3", 2.2, [], "largest disc; shaded: this aspect (approximate)"), legendEntry("--c5", 2, [],
      "trace")),
  element("div", {class: "row"}, button("Clear trace", "clear the trace (key T)", () => { trail = []; ask(); }),
    button("Clear path", "clear the drawn path", () => { sketch = []; checked = null; ask(); }),
    button("PNG", "save the picture as PNG", picturePng),
    button("SVG", "save the picture as SVG", () => save(new Blob([pictureSvg()], {type: "image/svg+xml"}), ".svg")),
    button("Copy link", "copy the link to this state", () => copy(location.href.split("#")[0] + writeFragment(),
      "link")),
    button("Copy Python", "copy the lines that make this robot", () => copy(asPython(), "Python"))),
  sketchBox.label, ellipses.label, element("div", {class: "slide"}, element("span", {"aria-hidden": "true"},
    "force towards"), angle),
  field_("Let go", element("div", {class: "row"}, goButton, paceInput, torqueKind),
    element("div", {class: "slide few"}, element("span", {"aria-hidden": "true"}, "torques (N m)"), ...torqueInputs),
    throws.label, gravity.label, ...inertias),
  pythonBox,
  element("details", {id: "help"}, element("summary", {}, "Pointer and keys"),
    "Drag the end-effector or an elbow, or the point in joint space. Arrow keys move the end-effector (in joint " +
    "space the motors), with Shift finely; Q A and W S turn the left and the right motor; 1 2 3 4 choose the " +
    "working mode, 0 the other assembly; G lets go and holds, T clears the trace, U or Ctrl Z undoes. Point at " +
    "another part of the plane: its aspect is shaded. Aspect, areas and disc are of " +
    "pixels; the curves are exact."));
