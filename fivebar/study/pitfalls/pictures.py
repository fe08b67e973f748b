"""Matplotlib figures of the cases, where a method fails beside the one that does not."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ...visualization.plot.panels import finish
from ...visualization.plot.sheets import new_figure
from ...visualization.style import AMBER, BLUE, INK, ORANGE, PINK, SKY
from .crossing import Crossing
from .differentiation import OURS as OURS_BOUND
from .differentiation import Differentiation
from .energy_drift import Drift
from .joint_space import FREE_END, FreeRun, StepSizes
from .redundant import Redundant
from .sampled import MeasuredLimit, boundary

# What survives is ink; the others are told apart by dashes too.
OTHERS: tuple[dict[str, Any], ...] = (
    {"color": ORANGE, "ls": "--", "lw": 1.5},
    {"color": BLUE, "ls": "-.", "lw": 1.5},
    {"color": PINK, "ls": ":", "lw": 1.5},
    {"color": AMBER, "ls": (0, (6, 2, 1, 2, 1, 2)), "lw": 1.5},
    {"color": SKY, "ls": (0, (1, 1)), "lw": 1.5},
)
OURS: dict[str, Any] = {"color": INK, "ls": "-", "lw": 2.2}
FLOOR = 1e-17  # an error of zero is drawn here


def _panels(number=1):
    """Return a figure and its axes, side by side."""
    figure = new_figure(6.4 * number, 4.6)
    return figure, figure.subplots(1, number, squeeze=False)[0]


def _finish(axes, xlabel, ylabel, title, **options):
    """Label axes, with a legend below them."""
    finish(axes, 2, xlabel=xlabel, ylabel=ylabel, title=title, **options)


def differentiation(curve: Differentiation) -> Figure:
    """Draw the error of rates by differences against the step: truncation, then rounding."""
    figure, (axes,) = _panels()
    pairs = ("velocity", curve.velocity), ("acceleration", curve.acceleration)
    for (name, error), style in zip(pairs, OTHERS):
        best = np.argmin(error)
        label = f"{name}: best {error[best]:.1g} at {curve.step[best]:.0e} s"
        axes.loglog(curve.step, error, **style, label=label)
        axes.plot(curve.step[best], error[best], "o", color=style["color"], ms=7)
    axes.axhline(OURS_BOUND, **OURS, label="fivebar's rates, which need no step: at most")
    title = "Rates by differences of positions"
    _finish(axes, "step between the positions (s)", "relative error", title, ylim=(1e-16, 1e2))
    return figure


def free_motion(
    attempts: Sequence[FreeRun], ours: FreeRun, naive_steps: StepSizes, our_steps: StepSizes
) -> Figure:
    """Draw the free motion by other solvers in joint coordinates, and errors over fixed steps."""
    figure, (left, right) = _panels(2)
    for attempt, style in zip(attempts, OTHERS):
        finite = np.isfinite(attempt.xi[:, 1])
        t = attempt.t[finite]
        y = 1e3 * attempt.xi[finite, 1]
        claim = '"success"' if attempt.success else "gave up"
        label = f"{attempt.name}: {claim}{'' if finite.all() else ', nan'}"
        left.plot(t, y, **style, label=label)
        left.plot(t[-1:], y[-1:], "x", color=style["color"], ms=9, mew=2)
    left.plot(ours.t, 1e3 * ours.xi[:, 1], **OURS, label="fivebar")
    left.plot(2.0, 1e3 * FREE_END[1], "o", color=INK, mfc="white", ms=7, label="true end")
    title = "Joint coordinates meet Type 2 at 0.1164 s"
    _finish(left, "time (s)", "y of the end-effector (mm)", title)
    error = np.abs(naive_steps.energy_error)
    step = 1e3 * naive_steps.step
    finite = np.isfinite(error)
    name = "joint coordinates, RK4"
    label = f"{name}: {finite.sum()} finished, without a word"
    right.semilogy(step[finite], error[finite], "^", color=ORANGE, ms=6, label=label)
    label = f"{name}: {(~finite).sum()} of {len(finite)} ended in nan"
    lost = step[~finite]
    right.plot(lost, np.full_like(lost, 1e2), "|", color=ORANGE, ms=9, label=label)
    right.plot(1e3 * our_steps.step, our_steps.energy_error, ".", color=INK, ms=5, label="fivebar")
    _finish(right, "step (ms)", "relative error of the energy", "RK4 with fixed steps, 2 s")
    return figure


def energy(drifts: Iterable[Drift]) -> Figure:
    """Draw the relative error of the energy against time, one curve for each integrator."""
    figure, (axes,) = _panels()
    others = iter(OTHERS)
    for drift in drifts:
        style = OURS if drift.name == "fivebar" else next(others)
        error = np.maximum(np.maximum.accumulate(np.abs(drift.error)), FLOOR)
        label = f"{drift.name} ({drift.evaluations} evaluations)"
        axes.semilogy(drift.t, error, **style, label=label)
    title = "Energy of a motion without torque"
    _finish(axes, "time (s)", "largest relative error so far", title)
    return figure


def closure(motions: dict[str, Redundant], ours: tuple[np.ndarray, np.ndarray]) -> Figure:
    """Draw how far the bars are from their lengths against time; ours: (t, closure)."""
    figure, (axes,) = _panels()
    for (name, motion), style in zip(motions.items(), OTHERS):
        axes.semilogy(motion.t, np.maximum(motion.closure, FLOOR), **style, label=name)
    thin = OURS | {"lw": 0.7}  # it goes up and down by rounding
    axes.semilogy(ours[0], np.maximum(ours[1], FLOOR), **thin, label="fivebar")
    title = "Closure of the loop, free motion"
    _finish(axes, "time (s)", "error of a bar's length (m)", title)
    return figure


def crossing(naive: Crossing, compliant: Crossing) -> Figure:
    """Draw the torques of the lab's task 2 and of a motion made to cross, around the crossing."""
    figure, panels = _panels(2)
    cases = (
        (naive, "quintic line of task 2", OTHERS[0]),
        (compliant, "compliant polynomial", OURS),
    )
    for axes, side, when in zip(panels, (-1, 1), ("before", "after")):
        for case, name, style in cases:
            here = np.sign(case.offset) == side
            largest = np.abs(case.torque[here]).max(axis=1)
            axes.loglog(np.abs(case.offset[here]), largest, **style, label=name)
        words = f"{when} the crossing"
        _finish(axes, f"time {words} (s)", "larger torque (N m)", words, ylim=(1e-4, 1e2))
    panels[0].invert_xaxis()
    figure.suptitle("Exact torque through a Type-2 singularity")
    return figure


def stability(limits: Sequence[MeasuredLimit]) -> Figure:
    """Draw the limits of stability in the plane of the gains, exact and as measured."""
    figure, panels = _panels(len(limits))
    for axes, limit in zip(panels, limits):
        axes.fill(*boundary(limit.delay).T, color=SKY, alpha=0.3, label="stable, exact")
        label = "limit on the simulated robot"
        axes.plot(*limit.measured.T, "o", color=INK, mfc="white", ms=6, label=label)
        s = np.linspace(0, 0.6 if limit.delay else 1.0, 50)
        axes.plot(s**2, 2 * s, color=ORANGE, ls="--", lw=1.5, label="critically damped")
        delay = "one sample of delay" if limit.delay else "no delay"
        title = f"{delay}: agrees within {100 * limit.worst:.2g} %"
        limits_of_axes = {"xlim": (0, None), "ylim": (0, None)}
        _finish(axes, "Kp h² (no unit)", "Kd h (no unit)", title, **limits_of_axes)
    return figure
