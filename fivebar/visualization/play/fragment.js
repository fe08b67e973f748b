// The state in the address: read strictly, as numbers and signs of known names only; never run, never shown as HTML.

const NUMBER = /^-?\d{1,7}(\.\d{1,25})?(e-?\d{1,2})?$/;
const ANY = [-1e6, 1e6];
const TOOL = ["leg", "along", "across"];
const RANGES = {
  l11: LIMITS.length, l12: LIMITS.length, l21: LIMITS.length, l22: LIMITS.length, d: LIMITS.d, zz1: ANY, zz2: ANY,
  m: ANY, gx: [-1e3, 1e3], gy: [-1e3, 1e3], x: [-100, 100], y: [-100, 100], disc: LIMITS.length,
  leg: [1, 2], along: LIMITS.tool, across: LIMITS.tool,
  ...Object.fromEntries(BEYOND.map(name => [name, ANY])), ...Object.fromEntries(FRICTIONS.map(name => [name, [0, 1e6]])),
};

// {state} or {words}: what is wrong with it.
function readFragment(text) {
  const found = {};
  if (text.length > 2000) return {words: "it is longer than any link that this page writes"};
  for (const pair of text.replace(/^#/, "").split("&")) {
    const [key, value, more] = pair.split("=");
    if (value === undefined || more !== undefined) return {words: "it is not a list of name=value"};
    if (Object.hasOwn(found, key)) return {words: "it names something twice"};
    if (key === "working") {
      if (!/^[+-][+-]$/.test(value)) return {words: "working is two signs, as +- or --"};
      found.working = [...value].map(each => each === "+" ? 1 : -1);
    } else if (Object.hasOwn(RANGES, key)) {
      if (!NUMBER.test(value)) return {words: `${key} is no number`};
      const x = Number(value), [low, high] = RANGES[key];
      if (!(x >= low && x <= high)) return {words: `${key} is not between ${low} and ${high}`};
      found[key] = x;
    } else return {words: "it names something that this page does not know"};
  }
  const missing = [...LENGTHS, "x", "y", "working"].filter(key => !Object.hasOwn(found, key));
  if (missing.length) return {words: `${missing.join(", ")} ${missing.length > 1 ? "are" : "is"} missing`};
  const named = TOOL.filter(key => Object.hasOwn(found, key));
  if (named.length && !(named.length === 3 && Number.isInteger(found.leg)))
    return {words: "of a tool it needs leg, which is 1 or 2, along and across"};
  const l = lengths(found), open = openWords(l);
  if (open) return {words: open};
  if (!igm([found.x, found.y], found.working,
    l).closes) return {words: "its point is out of reach in its working mode"};
  return {state: found};
}

const plain = x => {  // all digits, without the e+ that an address would read as a space
  const text = String(x).replace("e+", "e");
  return NUMBER.test(text) ? text : x.toFixed(12);
};

function writeFragment() {
  const numbers = {...Object.fromEntries(LENGTHS.map((name, k) => [name, p[k]])), zz1: robot.zz1, zz2: robot.zz2,
    m: robot.m, gx: robot.gravity[0], gy: robot.gravity[1], x: pose.xi[0], y: pose.xi[1]};
  for (const name of [...BEYOND, ...FRICTIONS]) if (robot[name]) numbers[name] = robot[name];
  if (robot.leg) for (const name of TOOL) numbers[name] = robot[name];
  if (wantsDisc) numbers.disc = wanted;
  return "#" + Object.entries(numbers).map(([key, x]) => `${key}=${plain(x)}`).join("&") +
    `&working=${modes.map(mode => mode > 0 ? "+" : "-").join("")}`;
}

function applyState(state) {
  for (const name of [...LENGTHS, "zz1", "zz2", "m"]) if (name in state) robot[name] = state[name];
  for (const name of [...BEYOND, ...FRICTIONS, ...TOOL]) robot[name] = state[name] ?? 0;  // an address says all that is not 0
  robot.gravity = [state.gx ?? 0, state.gy ?? 0];
  wantsDisc = "disc" in state;
  wanted = state.disc ?? wanted;
  p = lengths();
  modes = [...state.working];
  take(igm([state.x, state.y], modes, p));
}

// The lines that make this robot and pose in Python.
function asPython() {
  const given = {...Object.fromEntries(LENGTHS.map((name, k) => [name, p[k]])), zz1: robot.zz1, zz2: robot.zz2,
    m: robot.m};
  for (const name of [...BEYOND, ...FRICTIONS]) if (robot[name]) given[name] = robot[name];
  const parts = Object.entries(given).map(([name, x]) => `${name}=${x}`);
  if (robot.gravity.some(Boolean)) parts.push(`gravity=(${robot.gravity.join(", ")})`);
  const tool = robot.leg ? `, tool=fb.Tool(${TOOL.map(name => robot[name]).join(", ")})` : "";
  return `import fivebar as fb

robot = fb.FiveBar(${parts.join(", ")})
pose = fb.igm(robot, xi=(${pose.xi.join(", ")}), working=(${modes.join(", ")}))
fb.singularity_loci(robot), fb.aspects(robot)  # the curves and regions of this page
fb.play(robot, pose${tool})  # this page
`;
}
