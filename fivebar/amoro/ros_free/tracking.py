"""How well a controller's script follows a control task of the lab, and what that is worth."""

import numpy as np

from .clock import STEP

# From, to (m) and duration (s), on a quintic law of time, as the handout has them.
TASKS = {"1": ((0.09, 0.06796322), (0.0, 0.1), 2.0), "2": ((0.09, 0.06796322), (0.05, 0.0), 4.0)}
MOST_LATE = 5  # samples after the first step at which the script's trajectory may begin
FULL, NONE, POINTS = 1e-3, 20e-3, 20  # largest errors that are worth all points, and none, m


def reference(task, t):
    """The task's points at times t, (n, 2), m."""
    start, goal, duration = TASKS[task]
    s = np.clip(t / duration, 0, 1)
    return np.array(start) + np.outer(s**3 * (10 - 15 * s + 6 * s**2), np.subtract(goal, start))


def tracking(task, kind, run):
    """Figures of a five-bar's tracking error, m, and its mark; the task begins at the sample where
    it fits best.
    """
    if kind != "five_bar" or run is None:
        raise ValueError(
            f"--mark {task}: "
            + ("nothing was stepped" if run is None else "it is a task of the five-bar")
        )
    after = TASKS[task][2] + MOST_LATE * STEP
    if run.t[-1] < after:
        raise ValueError(
            f"--mark {task}: the motion ends at {run.t[-1]:g} s, the task at {TASKS[task][2]:g} s"
            " (--until)"
        )
    kept = run.t <= after
    errors = [
        np.linalg.norm(run.xi[kept] - reference(task, run.t[kept] - late * STEP), axis=1)
        for late in range(MOST_LATE + 1)
    ]
    error = min(errors, key=np.max)
    largest = float(error.max())
    share = (
        np.clip(np.log(NONE / max(largest, 1e-12)) / np.log(NONE / FULL), 0, 1)
        if np.isfinite(largest)
        else 0.0
    )
    return {
        "task": task,
        "largest_error_m": largest,
        "rms_error_m": float(np.sqrt(np.mean(error**2))),
        "error_at_the_end_m": float(error[-1]),
        "points": round(POINTS * float(share), 1),
        "of": POINTS,
    }


def words(found):
    """The same in a line."""
    return (
        f"control task {found['task']}: errors at most {1e3 * found['largest_error_m']:.3g} mm, RMS"
        f" {1e3 * found['rms_error_m']:.3g} mm, at the end {1e3 * found['error_at_the_end_m']:.3g}"
        f" mm: {found['points']:g} of {found['of']} points ({1e3 * FULL:g} mm or less is worth all,"
        f" {1e3 * NONE:g} mm none)"
    )
