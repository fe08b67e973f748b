// What the page of the five-bar is set by: lengths, modes, what happens at singularities, motion, files.

const field_ = (title, ...parts) => element("fieldset", {}, element("legend", {}, title), ...parts);
const check = (words_, checked, action = () => {}) => {
  const input = element("input", {type: "checkbox", ...(checked ? {checked: ""} : {})});
  const text = element("span", {}, words_);
  input.onchange = () => action(input.checked);
  return {input, text, label: element("label", {class: "check"}, input, text)};
};

// Lengths: a slider and a number each, mm.
const names = {l11: "left proximal bar", l12: "left distal bar", l21: "right proximal bar", l22: "right distal bar",
  d: "base"};
const sliders = LENGTHS.map((name, k) => lengthSlider(name, name, `${name}, ${names[name]}`, () => p[k], value => {
  const next = p.map((x, i) => i === k || (mirror.input.checked && i < 4 && i === (k + 2) % 4 && k < 4) ? value : x);
  if (!reshape(next)) return;
  said = "";
  namePreset("");
}));
let slidingTop = 0;

function lengthSlider(name, label, title, get, set) {
  const range = element("input", {type: "range", min: 0, max: 1000, step: "any", "aria-label": `${title}, mm`});
  const input = element("input", {type: "number", step: "any", min: 0, "aria-label": `${title}, mm`});
  const [low, high] = name === "d" ? LIMITS.d : LIMITS.length;
  const change = value => {
    if (!Number.isFinite(value)) return;
    wake();
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
      said = `${name} must be between ${lengthText(low)} and ${lengthText(high)}: kept as it was.`;
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
    range.setAttribute("aria-valuetext", `${number(1e3 * get(), 6)} mm`);
    if (document.activeElement !== input || !but) input.value = +(1e3 * get()).toPrecision(6);
  }
  mirror.input.checked &&= p[0] === p[2] && p[1] === p[3];
  discCheck.input.checked = wantsDisc;
  wantedSlider.row.hidden = !wantsDisc;
  showParameters();
  showModes();
}

function showModes() {
  modeButtons.forEach((made, k) => made.setAttribute("aria-pressed", ALL_MODES[k].join() === modes.join()));
}

// What moves the robot: its inertias, gravity and friction, as they are now.
function showParameters() {
  for (const [name, input] of inertias) input.value = robot[name];
  const [gx, gy] = robot.gravity, some = gx !== 0 || gy !== 0, b = addedFriction();
  gravity.input.checked = some;
  gravity.text.textContent = gx === 0 ? `gravity, ${number(some ? -gy : 9.81)} m/s² downwards`
    : `gravity (${number(gx)}, ${number(gy)}) m/s²`;
  friction.input.disabled = hasFriction();
  friction.text.textContent = hasFriction() ? "viscous friction of the robot's own (below)"
    : `viscous friction of both motors, ${number(b)} N m s/rad`;
  const more = [...BEYOND, ...FRICTIONS].filter(name => robot[name] !== 0);
  const values = more.map(name => `${name} = ${number(robot[name])}`).join(", ");
  moreParameters.textContent = values && `Also: ${values} (SI units).`;
}

function suggestTorques() {
  suggestedTorques().forEach((tau, k) => { torqueInputs[k].value = tau; });
}

const mirror = check("same lengths in both legs", p[0] === p[2] && p[1] === p[3], on => {
  if (!on) return;
  remember();
  reshape([p[0], p[1], p[0], p[1], p[4]]);
  namePreset("");
  showSliders();
  reshaped();
});
const discCheck = check("check whether a disc fits", false, on => {
  wantsDisc = on;
  showSliders();
  ask();
  keepFragment();
});
const wantedSlider = lengthSlider("disc", "radius", "radius of the disc", () => wanted, value => { wanted = value; });
const preset = element("select", {"aria-label": "robot by name"}, element("option", {value: ""}, "named robots …"),
  ...Object.keys(content.presets).map(name => element("option", {value: name}, name)));
const source = element("p", {class: "source"});

const sentence = text => text[0].toUpperCase() + text.slice(1).replace(/\.$/, "");
let presetName = "";  // of the robot at hand, "" for one without a name

function namePreset(name) {
  preset.value = presetName = name;
  const known = content.presets[name];
  const dry = known?.robot.dry ? " Its dry friction is left out here." : "";
  source.textContent = known ? `${sentence(known.source)}.${dry}` : "";
}

preset.onchange = () => {
  const {value} = preset, chosen = content.presets[value];
  if (!chosen) return;
  wake();
  remember();
  halt();
  sketch = [];
  checked = null;
  wanted = chosen.wanted;
  restore({robot: chosen.robot, modes: chosen.working, xi: chosen.xi, name: value});
  suggestTorques();
  mirror.input.checked = p[0] === p[2] && p[1] === p[3];
};
const signs = mode => mode.map(each => each > 0 ? "+" : "−").join("");
const onPose = action => () => {
  wake();
  remember();
  halt();
  action();
  moved();
};
const modeButtons = ALL_MODES.map((mode, k) => button(signs(mode),
  `${signs(mode)}: working mode ${mode.map(sign).join(", ")} (key ${k + 1})`, onPose(() => toModes(mode))));
const assemblyButton = button("other assembly mode", "other assembly mode of the same motor angles (key 0)",
  onPose(() => toAssembly(-pose.assembly)));
const modeWords = element("p", {class: "source"}, "+ : the elbow is on the left of the line from its motor to the " +
  "end-effector (sin q12 or sin q22 < 0); − : on the right (sine > 0).");
byId("panel").append(
  field_("Robot, lengths in mm", element("div", {class: "row"}, preset), source, ...sliders.map(({row}) => row),
    mirror.label),
  field_("Working mode, left and right leg", element("div", {class: "row"}, ...modeButtons, assemblyButton), modeWords,
    check("pass Type 1: the working mode changes", false, on => { choices.type1 = on; }).label,
    check("pass Type 2: the assembly mode changes", false, on => { choices.type2 = on; }).label,
    check("show the loci of the other working modes, pale", true, on => {
      shown.others = on;
      ask({back: true});
    }).label),
  field_("Disc", discCheck.label, wantedSlider.row));

// What else: force, motion, path, files.
const ellipses = check("ellipses of velocity (solid) and force (dashed), and the force", false, on =>
  { shown.ellipses = on; ask(); });
const angle = element("input", {type: "range", min: 0, max: 360, value: 90, step: 1,
  "aria-label": "direction of the force", "aria-valuetext": "90°"});
const angleValue = element("output", {}, "90°");
angle.oninput = () => {
  force.angle = +angle.value * Math.PI / 180;
  angleValue.value = `${angle.value}°`;
  angle.setAttribute("aria-valuetext", angleValue.value);
  ask();
};
const torqueKind = element("select", {"aria-label": "motor torques while it moves"},
  ...[["wave", "sinusoidal torques, cos 2πt"], ["constant", "constant torques"], ["none", "no torques"]]
    .map(([value, text]) => element("option", {value}, text)));
const torqueInputs = [0, 1].map(k =>
  element("input", {type: "number", step: "any", "aria-label": `torque of motor ${k + 1}, N m`}));
const goButton = button("Let go", "Let go: the robot moves by itself (key G)", () => {
  wake();
  if (flying) halt(); else release();
});
goButton.id = "go";
const paceInput = speedChoice([0.1, 0.25, 0.5, 1], "speed of the motion");
const throws = check("throw: released while it moves, the end-effector keeps its velocity", false);
const throwing = throws.input;

function changeParameters(change) {
  wake();
  remember();
  halt();
  change();
  namePreset("");
  showParameters();
  ask();
  keepFragment();
}

const gravity = check("gravity", false, on => changeParameters(() => { robot.gravity = on ? [0, -9.81] : [0, 0]; }));
const friction = check("viscous friction", true);
const moreParameters = element("p", {class: "source"});
const inertias = ["zz1", "zz2", "m"].map(name => {
  const unit = name === "m" ? "kg" : "kg m²";
  const input = element("input", {type: "number", step: "any", min: 0, "aria-label": `${name} (${unit})`});
  input.onchange = () => {
    const value = +input.value;
    if (input.value !== "" && value >= 0 && value <= 1e6) return changeParameters(() => {
      robot[name] = value;
      if (torqueInputs.every(torque => +torque.value === 0)) suggestTorques();
    });
    said = `${name} must be between 0 and 10⁶ ${unit}: kept as it was.`;
    input.value = robot[name];
    ask();
  };
  return [name, input, element("label", {class: "slide few"}, element("span", {}, `${name} (${unit})`), input)];
});
const sketchBox = check("draw a path with the pointer: it is checked at once", false), sketching = sketchBox.input;
const python = element("pre", {tabindex: 0, "aria-label": "as Python"});
const pythonBox = element("details", {}, element("summary", {}, "as Python"), python);
pythonBox.ontoggle = () => { python.textContent = asPython(); };
const equations = element("pre", {tabindex: 0, "aria-label": "equations of this pose"});
const equationsBox = element("details", {}, element("summary", {}, "Equations of this pose"), equations);
equationsBox.ontoggle = showEquations;

// A, B and det A of the pose at hand in the lab's notation, letters and numbers.
function showEquations() {
  const [[ax, ay], [bx, by]] = pose.elbows.map(([x, y], k) => unit([pose.xi[0] - x, pose.xi[1] - y]));
  const at = (x, scale = 1) => (zeroBelow(x, scale) < 0 ? "" : " ") + zeroBelow(x, scale).toFixed(4).replace("-", "−");
  const b = pose.serial.map((sine, k) => p[2 * k] * sine), {J} = gains(pose.xi, modes, [0, 0], p);
  equations.textContent = [
    "A ξ̇ = B q̇      ξ = (x, y), q = (q1, q2)", "",
    "A: rows u12ᵀ, u22ᵀ, the unit vectors of the distal bars",
    `A = [ ${at(ax)} ${at(ay)} ]`, `    [ ${at(bx)} ${at(by)} ]`, "",
    "B = diag(l11 sin q12, l21 sin q22), m",
    `B = [ ${at(b[0])} ${at(0)} ]`, `    [ ${at(0)} ${at(b[1])} ]`, "",
    `det A = sin(φ2 − φ1) = ${at(pose.parallel).trim()}`,
    `det B = ${number(zeroBelow(b[0] * b[1], p[0] * p[2]), 4)} m²`, "",
    ...J.flat().every(Number.isFinite) ? ["J = A⁻¹ B, m", `J = [ ${at(J[0][0])} ${at(J[0][1])} ]`,
      `    [ ${at(J[1][0])} ${at(J[1][1])} ]`] : ["det A = 0 (Type 2): A has no inverse, and J does not exist"],
  ].join("\n");
}

function saveTrace() {
  if (!trail.length) {
    said = "There is no trace yet: drag the robot, or let it go.";
    return ask();
  }
  const from = trail[0].t, ends = robot.leg ? ["x_tip", "y_tip"] : [];
  const rows = trail.map(({t, xi, q, tip}) => [t - from, ...q, ...xi, ...robot.leg ? tip : []]);
  saveCsv(`trace of ${document.title}: t in s, q1 and q2 in rad, x and y in m`,
    [["t", "q1", "q2", "x", "y", ...ends], ...rows]);
}

const drawPicture = pen => { drawTaskBack(pen); drawTaskFront(pen, false); };

async function copyText(text, done, failed) {
  let words = done;
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    words = failed;
  }
  if (byId("five").hidden) { lab.said = words; benchFrame(); } else { said = words; ask(); }
}

// A page at an address is shared by it; of a file only the part that says the state makes sense elsewhere.
function copyLink(fragment) {
  const address = location.href.split("#")[0];
  if (/^https?:/.test(address))
    return copyText(address + fragment, "Link copied.",
      "The browser does not allow copying here: copy the address instead.");
  return copyText(fragment, "This page is a file, so a link works only beside it. The part after the file's name, " +
    "#…, is copied. `fivebar play --site DIR` makes a page to put online.",
  "The browser does not allow copying here. The state is in the address, after #.");
}

const EXPLAINED = {
  "Type 1": "A leg is in line, stretched or folded: det B = 0. The end-effector cannot move along the leg; two " +
    "working modes meet.",
  "Type 2": "The distal bars are parallel: det A = 0. The motors cannot hold the end-effector there; two assembly " +
    "modes meet.",
  "self-motion": "Both elbows coincide: the end-effector turns about them while the motors stand still (Type 2).",
  aspect: "A part of the workspace in one working mode without a singularity inside: the robot goes everywhere in it.",
  "working mode": "On which side each elbow is: one point of the end-effector, up to four pairs of motor angles.",
  "assembly mode": "On which side of the elbows' line the end-effector is: one pair of motor angles, up to two points.",
  "largest disc": "The largest circle inside the shaded aspect: how much free space there is.",
};
const legendEntry = (ink, width, dashes, text, word) => element("li", {title: EXPLAINED[word] ?? ""},
  element("span", {class: "entry"}, swatch(ink, width, dashes), text));
byId("tools").append(goButton, button("Undo", "Undo (Ctrl Z)", undo),
  button("Clear trace", "Clear trace (key T)", () => { trail = []; ask(); }));
byId("joints-legend").append(legendEntry("--c0", 2, [], "left leg in line (Type 1)", "Type 1"),
  legendEntry("--c1", 2, [], "right leg in line (Type 1)", "Type 1"),
  legendEntry("--c4", 2.2, [7, 3], "Type 2", "Type 2"),
  element("li", {}, "pale: in the other assembly mode"));
byId("more").append(
  element("ul", {class: "legend", "aria-label": "colours"},
    legendEntry("--ink", 2, [], "Type 1: a leg in line", "Type 1"),
    ...Object.entries(DASHES2).map(([kind, dash_]) =>
      legendEntry("--c4", 2.2, dash_, NAMES2[kind], kind === "self-motion" ? kind : "Type 2")),
    legendEntry("--c3", 2.2, [], "largest disc, in the shaded aspect (green)", "largest disc"),
    element("li", {}, "grey: other aspects, darker where det A > 0"),
    legendEntry("--c5", 2, [], "trace")),
  element("div", {class: "row"},
    button("Clear path", "Clear path that was drawn", () => { sketch = []; checked = null; ask(); }),
    button("PNG", "save the picture as PNG", () => savePicture(task, drawPicture, true)),
    button("SVG", "save the picture as SVG", () => savePicture(task, drawPicture, false)),
    button("CSV", "save the trace as CSV", saveTrace),
    button("Copy link", "Copy link to this state", () => copyLink(writeFragment())),
    button("Copy Python", "Copy Python lines that make this robot", () => copyText(asPython(), "Python lines copied.",
      "The browser does not allow copying here: open the box \"as Python\" below."))),
  sketchBox.label, ellipses.label, element("div", {class: "slide wide"}, element("span", {"aria-hidden": "true"},
    "direction of the force"), angle, angleValue),
  field_("Let go", element("div", {class: "row"}, paceInput, torqueKind),
    element("div", {class: "slide few"}, element("span", {"aria-hidden": "true"}, "torques (N m)"), ...torqueInputs),
    friction.label, gravity.label, throws.label, ...inertias.map(([, , label]) => label), moreParameters),
  equationsBox, pythonBox,
  element("details", {}, element("summary", {}, "Words: Type 1, Type 2, aspect"), element("dl", {class: "words"},
    ...Object.entries(EXPLAINED).flatMap(([word, text]) => [element("dt", {}, word), element("dd", {}, text)]))),
  element("details", {id: "help"}, element("summary", {}, "Pointer and keys"),
    "Drag the end-effector or an elbow, or the point in joint space. Arrow keys move the end-effector (in joint " +
    "space the motors), with Shift finely; Q A and W S turn the left and the right motor; 1 2 3 4 choose the " +
    "working mode, 0 the other assembly mode; G lets go and pauses, T clears the trace, U or Ctrl Z undoes. Point at " +
    "another part of the plane: its aspect is shaded."));
