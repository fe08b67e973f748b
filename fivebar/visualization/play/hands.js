// The pointer and the keys on the page of the five-bar: what is grasped, dragged, thrown.

let pointer = null;  // {what: "end", "left", "right", "sketch" or "joints", at, velocity}

// What the pointer takes hold of. A mouse takes the end-effector from anywhere; a finger that misses scrolls the page.
function grasp(view, event, byTouch) {
  const at = view.from(event), near = (byTouch ? 34 : 18) / view.scale;
  const far = point => Math.hypot(point[0] - at[0], point[1] - at[1]);
  if (view === joints) return byTouch && far(pose.q) > near ? "" : "joints";
  if (sketching.checked) return "sketch";
  const distances = [["end", far(pose.xi)], ["left", far(pose.elbows[0])], ["right", far(pose.elbows[1])]];
  const [what, distance] = distances.sort((a, b) => a[1] - b[1])[0];
  if (distance < near) return what;
  return byTouch ? "" : "end";
}

function down(view, event) {
  const what = grasp(view, event, event.pointerType === "touch");
  if (event.button > 0 || !what) return;
  wake();
  if (flying) halt();
  if (what !== "sketch") remember();
  pointer = {what, id: event.pointerId, time: performance.now(), velocity: [0, 0], at: [...pose.xi]};
  touching = -1;
  view.box.setPointerCapture(event.pointerId);
  if (what === "sketch") [sketch, checked] = [[], null];
  else trail = [];
  drag(view, event);
}

// Without a button: the aspect under the pointer, and the largest disc there.
function hover(event) {
  if (pointer || flying || event.pointerType === "touch") return;
  const under = event.type === "pointerleave" ? null : regionAt(parts, task.from(event), 0);
  const region = under ?? aspectAt(pose.xi, -pose.assembly);
  if (region === aspect) return;
  shade(region);
  ask({back: true});
}

function drag(view, event) {
  if (!pointer || pointer.id !== event.pointerId) return;
  const at = view.from(event), step = 2 / task.scale;
  if (pointer.what === "sketch") {
    if (!sketch.length || Math.hypot(at[0] - sketch[sketch.length - 1][0],
      at[1] - sketch[sketch.length - 1][1]) > step) sketch.push(at);
    return ask();
  }
  if (pointer.what === "end") moveTo(at, step);
  else if (pointer.what === "joints") turnTowards(at);
  else {
    const k = pointer.what === "left" ? 0 : 1, base = (k - 0.5) * p[4];
    turnTowards(pose.q.map((q, i) => i === k ? Math.atan2(at[1], at[0] - base) : q));
  }
  const now = performance.now(), passed = (now - pointer.time) / 1000;
  if (passed > 0.008) {
    pointer.velocity = [0, 1].map(k => 0.6 * pointer.velocity[k] + 0.4 * (pose.xi[k] - pointer.at[k]) / passed);
    [pointer.time, pointer.at] = [now, [...pose.xi]];
  }
  moved();
}

function up(event) {
  if (!pointer || pointer.id !== event.pointerId) return;
  const {what, velocity, time} = pointer;
  pointer = null;
  if (what === "sketch") {
    said = "";
    checkSketch();
    return ask();
  }
  if (throwing.checked && event.type === "pointerup") release(performance.now() - time < 120 ? velocity : [0, 0]);
  ask();
}

task.box.addEventListener("pointermove", hover);
task.box.addEventListener("pointerleave", hover);
for (const view of [task, joints]) {
  view.box.addEventListener("pointerdown", event => down(view, event));
  view.box.addEventListener("pointermove", event => drag(view, event));
  for (const end of ["pointerup", "pointercancel"]) view.box.addEventListener(end, up);
  // Only here can a touch still be kept from scrolling the page.
  view.box.addEventListener("touchstart", event => {
    if (event.touches.length === 1 && grasp(view, event.touches[0], true)) event.preventDefault();
  }, {passive: false});
}

onKeys(event => {
  const {target: {tagName}, target} = event, arrowsToo = !["BUTTON", "SUMMARY", "PRE"].includes(tagName);
  if (byId("five").hidden || tagName === "INPUT") return {};
  const fine = event.shiftKey ? 0.2 : 1, step = 4 * fine / task.scale, turn = 0.02 * fine;
  const held = action => () => { wake(); halt(); if (!event.repeat) remember(); action(); moved(); };
  const move = (x, y) => held(() => target === joints.box ? turnTowards([pose.q[0] + x * turn, pose.q[1] + y * turn])
    : moveTo([pose.xi[0] + x * step, pose.xi[1] + y * step], step));
  const motors = (left, right) => held(() => turnTowards([pose.q[0] + left * turn, pose.q[1] + right * turn]));
  return {
    ...(arrowsToo ? {ArrowRight: move(1, 0), ArrowLeft: move(-1, 0), ArrowUp: move(0, 1), ArrowDown: move(0, -1)} : {}),
    q: motors(1, 0), a: motors(-1, 0), w: motors(0, 1), s: motors(0, -1), u: undo,
    ...Object.fromEntries(ALL_MODES.map((mode, k) => [k + 1, held(() => toModes(mode))])),
    0: held(() => toAssembly(-pose.assembly)), g: () => flying ? halt() : release(), t: () => { trail = []; ask(); },
  };
});

addEventListener("keydown", event => {
  if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z") return;
  event.preventDefault();
  if (byId("five").hidden) undoLab(); else undo();
});
