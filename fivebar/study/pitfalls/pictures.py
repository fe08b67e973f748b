"""Figures of the cases, where a method fails beside the one that does not: Matplotlib's, saved by
their `savefig`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ...visualization.style import AMBER, BLUE, INK, ORANGE, PINK, SKY
from .differentiation import OURS as OURS_BOUND
from .joint_space import FREE_END
from .sampled import boundary

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from .crossing import Crossing
    from .differentiation import Differentiation
    from .energy_drift import Drift
    from .joint_space import FreeRun, StepSizes
    from .redundant import Redundant
    from .sampled import MeasuredLimit

# What survives is ink; the others are told apart by dashes too.
OTHERS = (
    dict(color=ORANGE, ls="--"),
    dict(color=BLUE, ls="-."),
    dict(color=PINK, ls=":"),
    dict(color=AMBER, ls=(0, (6, 2, 1, 2, 1, 2))),
    dict(color=SKY, ls=(0, (1, 1))),
)
OURS = dict(color=INK, ls="-")
FLOOR = 1e-17  # an error of zero is drawn here


def _figure(panels=1, height=4.6, width=6.4):
    figure = Figure(figsize=(width * panels, height), layout="constrained")
    axes = figure.subplots(1, panels, squeeze=False)[0]
    for each in axes:
        each.grid(alpha=0.25)
    return figure, axes if panels > 1 else axes[0]


def _legend(axes, columns=2):
    axes.legend(
        loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=columns, fontsize=8, frameon=False
    )


def _labelled(name):
    return {"label": name, "lw": 2.2 if name == "fivebar" else 1.5}


def differentiation(curve: Differentiation) -> Figure:
    """Error of velocities and accelerations by differences against the step: truncation, then
    rounding.
    """
    figure, axes = _figure()
    for name, error, style, side in (
        ("velocity", curve.velocity, OTHERS[1], "top"),
        ("acceleration", curve.acceleration, OTHERS[0], "bottom"),
    ):
        best = int(np.argmin(error))
        axes.loglog(curve.step, error, **style, **_labelled(f"{name}, by differences"))
        axes.plot(curve.step[best], error[best], "o", color=style["color"], ms=7)
        axes.annotate(
            f"best {error[best]:.1g}\nat {curve.step[best]:.0e} s",
            (curve.step[best], error[best]),
            fontsize=8,
            xytext=(0, -10 if side == "top" else 18),
            textcoords="offset points",
            ha="center",
            va=side,
        )
    axes.axhline(
        OURS_BOUND, color=INK, lw=2.2, label="fivebar's rates, which need no step: at most"
    )
    axes.set(
        xlabel="step between the positions (s)",
        ylabel="relative error",
        ylim=(1e-16, 1e2),
        title="Rates by differences of positions",
    )
    _legend(axes)
    return figure


def free_motion(
    attempts: Sequence[FreeRun], ours: FreeRun, naive_steps: StepSizes, our_steps: StepSizes
) -> Figure:
    """The free motion by SciPy's solvers and RK4 in joint coordinates, and the energy error over
    fixed step sizes.
    """
    figure, (left, right) = _figure(2)
    for size, attempt, style in zip(
        (13, 11, 9, 7, 5), attempts, OTHERS
    ):  # marks that coincide are both seen
        fine = np.isfinite(attempt.xi[:, 1])
        t, y = attempt.t[fine], 1e3 * attempt.xi[fine, 1]
        claim = '"success"' if attempt.success else "gave up"
        left.plot(
            t, y, **style, **_labelled(f"{attempt.name}: {claim}{'' if fine.all() else ', nan'}")
        )
        left.plot(t[-1:], y[-1:], "x", color=style["color"], ms=size, mew=2)
    left.plot(ours.t, 1e3 * ours.xi[:, 1], **OURS, **_labelled("fivebar"))
    left.plot(2.0, 1e3 * FREE_END[1], "o", color=INK, mfc="white", ms=7, label="true end")
    left.set(
        xlabel="time (s)",
        ylabel="y of the end-effector (mm)",
        title="Joint coordinates meet Type 2 at 0.1164 s",
    )
    _legend(left)
    finite = np.isfinite(naive_steps.energy_error)
    right.set_yscale("log")
    milliseconds = 1e3 * naive_steps.step
    right.plot(
        milliseconds[finite],
        np.abs(naive_steps.energy_error[finite]),
        "^",
        color=ORANGE,
        ms=6,
        label=f"joint coordinates, RK4: {finite.sum()} finished, without a word",
    )
    right.plot(
        milliseconds[~finite],
        np.full((~finite).sum(), 1e2),
        "|",
        color=ORANGE,
        ms=9,
        label=f"joint coordinates, RK4: {(~finite).sum()} of {len(finite)} ended in nan",
    )
    right.plot(1e3 * our_steps.step, our_steps.energy_error, ".", color=INK, ms=5, label="fivebar")
    right.set(
        xlabel="step (ms)", ylabel="relative error of the energy", title="RK4 with fixed steps, 2 s"
    )
    _legend(right, 1)
    return figure


def energy(drifts: Iterable[Drift]) -> Figure:
    """Relative error of the energy against time, one curve for each integrator."""
    figure, axes = _figure()
    others = iter(OTHERS)
    for drift in drifts:
        style = OURS if drift.name == "fivebar" else next(others)
        error = np.maximum(np.maximum.accumulate(np.abs(drift.error)), FLOOR)
        label = f"{drift.name} ({drift.evaluations} evaluations)"
        axes.semilogy(drift.t, error, **style, **(_labelled(drift.name) | {"label": label}))
    axes.set(
        xlabel="time (s)",
        ylabel="largest relative error so far",
        title="Energy of a motion without torque",
    )
    _legend(axes)
    return figure


def closure(motions: dict[str, Redundant], ours: tuple[np.ndarray, np.ndarray]) -> Figure:
    """How far the bars are from their lengths against time. motions: {name: Redundant}; ours: (t,
    closure).
    """
    figure, axes = _figure()
    for (name, motion), style in zip(motions.items(), OTHERS):
        axes.semilogy(motion.t, np.maximum(motion.closure, FLOOR), **style, **_labelled(name))
    axes.semilogy(ours[0], np.maximum(ours[1], FLOOR), **OURS, label="fivebar", lw=0.7)
    axes.set(
        xlabel="time (s)",
        ylabel="error of a bar's length (m)",
        title="Closure of the loop, free motion",
    )
    _legend(axes)
    return figure


def crossing(naive: Crossing, compliant: Crossing) -> Figure:
    """Torques of the lab's task 2 and of a motion made to cross, against the time to the
    singularity.
    """
    figure, (before, after) = _figure(2)
    for axes, side, title in (
        (before, -1, "before the crossing"),
        (after, 1, "after the crossing"),
    ):
        for case, name, style in (
            (naive, "quintic line of task 2", OTHERS[0]),
            (compliant, "compliant polynomial", OURS),
        ):
            here = np.sign(case.offset) == side
            largest = np.abs(case.torque[here]).max(axis=1)
            axes.loglog(np.abs(case.offset[here]), largest, **style, lw=2, label=name)
        axes.set(
            xlabel=f"time {title} (s)", ylabel="larger torque (N m)", ylim=(1e-4, 1e2), title=title
        )
        _legend(axes)
    before.invert_xaxis()
    figure.suptitle("Exact torque through a Type-2 singularity")
    return figure


def stability(limits: Sequence[MeasuredLimit]) -> Figure:
    """The limits of stability in the plane of the gains, exact and as measured on the simulated
    robot.
    """
    figure, panels = _figure(len(limits))
    for axes, limit in zip(np.atleast_1d(panels), limits):
        axes.fill(*boundary(limit.delay).T, color=SKY, alpha=0.3, label="stable, exact")
        axes.plot(
            *limit.measured.T,
            "o",
            color=INK,
            mfc="white",
            ms=6,
            label="limit on the simulated robot",
        )
        s = np.linspace(0, 0.6 if limit.delay else 1.0, 50)
        axes.plot(s**2, 2 * s, color=ORANGE, ls="--", lw=1.5, label="critically damped")
        delay = "one sample of delay" if limit.delay else "no delay"
        axes.set(
            xlabel="Kp h² (no unit)",
            ylabel="Kd h (no unit)",
            xlim=(0, None),
            ylim=(0, None),
            title=f"{delay}: agrees within {100 * limit.worst:.2g} %",
        )
        _legend(axes, 3)
    return figure
