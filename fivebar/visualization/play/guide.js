// The opening: the robot moves by itself until it is touched, then three short tasks, one sentence each.

let idle = null;  // {start, centre, began}: the end-effector goes round a circle inside the aspect
let guideStep = -1;  // of the guide: -1 before it begins, GUIDE.length after it
const GUIDE = [
  {words: "Drag the large point onto a dashed curve of its colour: there the distal bars are parallel (Type 2), and the robot " +
    "stops.",
    done: () => Math.abs(pose.parallel) < 1e-3},
  {words: "Press another working mode, such as + −: the same point, with an elbow on the other side.",
    done: () => guideModes !== modes.join()},
  {words: "Press Let go: inertia and the motors' torques now move the robot, also across the curves.",
    done: () => Boolean(flying)},
];
let guideModes = "";

function beginIdle() {
  if (!aspect) return;
  if (matchMedia("(prefers-reduced-motion: reduce)").matches) return showGuide(0);
  const [x, y] = pose.xi, radius = 0.4 * clearanceAt(wallsOf(aspect), x, y);
  const away = Math.atan2(disc.y - y, disc.x - x);
  if (radius > 0)
    idle = {away, radius, centre: [x + radius * Math.cos(away), y + radius * Math.sin(away)], began: performance.now()};
}

const IDLE_PERIOD = 7000;  // ms

function idleOn(now) {
  const {centre: [x, y], radius, away, began} = idle, angle = away + Math.PI + TURN * (now - began) / IDLE_PERIOD;
  take(igm([x + radius * Math.cos(angle), y + radius * Math.sin(angle)], modes, p));
  if (trail.length > 1 && now - began > IDLE_PERIOD) trail.shift();
  moved();
}

// The first touch ends the motion and begins the guide.
function wake() {
  if (!idle) return;
  idle = null;
  trail = [];
  showGuide(0);
}

function showGuide(next) {
  guideStep = next;
  guideModes = modes.join();
  const step = GUIDE[guideStep];
  guideBox.hidden = !step;
  guideText.textContent = step ? `${guideStep + 1} of ${GUIDE.length}. ${step.words}` : "";
}

function guideOn() {
  if (GUIDE[guideStep]?.done() && !pointer) showGuide(guideStep + 1);
}

const guideText = element("span"), guideBox = byId("guide");
guideBox.append(guideText, button("Skip", "Skip this task", () => showGuide(guideStep + 1)));
