// The pointer and the keys on the page of a linkage.

let benchPointer = null;

function benchDrag(event) {
  if (!benchPointer) return;
  const at = bench.from(event), {actuated} = wordsOf(), points = at_(lab.q).points;
  if (benchPointer === "point") {
    const [b, c] = [points[1], points[2]], ux = (c[0] - b[0]) / lab.values[2], uy = (c[1] - b[1]) / lab.values[2];
    const along = (at[0] - b[0]) * ux + (at[1] - b[1]) * uy, across = (at[1] - b[1]) * ux - (at[0] - b[0]) * uy;
    lab.ghost ??= lab.sweep.rows;
    if (Math.abs(along) <= 10 && Math.abs(across) <= 10) refit([...lab.values.slice(0, 4), along, across]);
    return relabbed(false);
  }
  const pivot = points[actuated[0]];
  turnCrank(Math.atan2(at[1] - pivot[1], at[0] - pivot[0]));
  benchFrame();
}

// What the pointer takes hold of: the coupler point or the crank; a finger far from all joints scrolls the page.
function benchGrasp(event, byTouch) {
  const [x, y] = bench.from(event), {points} = at_(lab.q), near = byTouch ? 34 : 16;
  const isNear = point => Math.hypot(point[0] - x, point[1] - y) * bench.scale < near;
  if (lab.kind === "four" && isNear(points[wordsOf().traced])) return "point";
  return byTouch && !points.some(isNear) ? "" : "crank";
}

bench.box.addEventListener("pointerdown", event => {
  const what = benchGrasp(event, event.pointerType === "touch");
  if (event.button > 0 || !what) return;
  benchPointer = what;
  if (lab.running) toggleRun();
  rememberLab();
  bench.box.setPointerCapture(event.pointerId);
  benchDrag(event);
});
bench.box.addEventListener("touchstart", event => {
  if (event.touches.length === 1 && benchGrasp(event.touches[0], true)) event.preventDefault();
}, {passive: false});
bench.box.addEventListener("pointermove", benchDrag);
for (const end of ["pointerup", "pointercancel"]) bench.box.addEventListener(end, () => {
  if (benchPointer === "point") { lab.ghost = null; buildBench(); relabbed(); }
  benchPointer = null;
});
onKeys(({shiftKey, target}) => {
  if (byId("linkage").hidden || ["INPUT", "BUTTON", "SUMMARY"].includes(target.tagName)) return {};
  const step = (shiftKey ? 0.2 : 1) * Math.PI / 180, turn = by => { turnCrank(lab.q + by); benchFrame(); };
  return {ArrowLeft: () => turn(step), ArrowRight: () => turn(-step), " ": toggleRun};
});
