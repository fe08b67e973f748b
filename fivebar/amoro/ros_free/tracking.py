"""How well a controller's script follows a control task of the lab, and what that is worth."""

import numpy as np

from .clock import STEP

# From, to (m) and duration (s), on a quintic law of time: of the five-bar as the handout has them,
# of the biglide as labs/amoro/control.py.
TASKS = {
    "five_bar": {
        "1": ((0.09, 0.06796322), (0.0, 0.1), 2.0),
        "2": ((0.09, 0.06796322), (0.05, 0.0), 4.0),
    },
    "biglide": {"1": ((0.0, 0.2), (0.06, 0.25), 2.0)},
}
MOST_LATE = 5  # samples after the first step at which the script's trajectory may begin
FULL, NONE, POINTS = 1e-3, 20e-3, 20  # largest errors that are worth all points, and none, m


def reference(line, t):
    """Return the points of a task at times t, (n, 2), m."""
    start, goal, duration = line
    s = np.clip(t / duration, 0, 1)
    return np.array(start) + np.outer(s**3 * (10 - 15 * s + 6 * s**2), np.subtract(goal, start))


def tracking(task, kind, run):
    """Return a robot's tracking error, m, and its mark; the task begins where it fits best."""
    if run is None:
        raise ValueError("the robot did not move")
    if task not in TASKS[kind]:
        raise ValueError(f"the {kind} has no control task {task}")
    line = TASKS[kind][task]
    duration = line[2]
    end = duration + MOST_LATE * STEP
    if run.t[-1] < end:
        raise ValueError(
            f"the motion ends at {run.t[-1]:g} s, before the {duration:g} s of the task"
        )
    kept, errors = run.t <= end, []
    for late in range(MOST_LATE + 1):
        points = reference(line, run.t[kept] - late * STEP)
        errors.append(np.linalg.norm(run.xi[kept] - points, axis=1))
    error = min(errors, key=np.max)
    largest = float(error.max())
    share = np.log(NONE / max(largest, 1e-12)) / np.log(NONE / FULL)
    return {
        "task": task,
        "largest_error_m": largest,
        "rms_error_m": float(np.sqrt(np.mean(error**2))),
        "error_at_the_end_m": float(error[-1]),
        "points": round(POINTS * float(np.clip(np.nan_to_num(share), 0, 1)), 1),
        "of": POINTS,
    }


def words(marks):
    """Return the same in a line."""
    names = "largest_error_m", "rms_error_m", "error_at_the_end_m"
    largest, rms, last = (1e3 * marks[name] for name in names)
    return (
        f"control task {marks['task']}: errors at most {largest:.3g} mm, RMS {rms:.3g} mm, at the"
        f" end {last:.3g} mm: {marks['points']:g} of {marks['of']} points ({1e3 * FULL:g} mm or"
        f" less is worth all, {1e3 * NONE:g} mm none)"
    )
