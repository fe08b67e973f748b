"""Positions of a five-bar whose cranks turn, pose after pose, by pylinkage and by ours: which
branch each takes.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from fivebar.models.compiled import Buffered, compile
from fivebar.models.geometry import dgm
from fivebar.models.robots import FiveBar
from fivebar.study.speed_accuracy.chart import OURS, Attempt, Method
from fivebar.study.speed_accuracy.charts.exact import distance, exact_motion
from fivebar.study.speed_accuracy.machine import lacks_c_compiler, lacks_module

if TYPE_CHECKING:
    from collections.abc import Callable

TURNING = FiveBar(l12=0.16, l22=0.16)  # long enough bars for both cranks to turn
START, ASSEMBLY, POSES = (0.0, np.pi / 2), -1, 720


@cache
def poses(degrees: float) -> tuple:
    """Angles (n, 2) of cranks that turn by so much from pose to pose, their exact positions, and
    the other branch's.
    """
    q = np.add(START, np.radians(degrees) * np.arange(1, POSES + 1)[:, None])
    exact, other = (
        [exact_motion(TURNING, angles, assembly=a)[0] for angles in q]
        for a in (ASSEMBLY, -ASSEMBLY)
    )
    return q, exact, np.array(other, dtype=float)


def judged(degrees: float) -> Callable[..., dict[str, float]]:
    """xi (n, 2) -> largest error, m, and the share of the poses that are nearer to the other
    branch.
    """
    _, exact, other = poses(degrees)

    def judge(xi):
        errors = np.array([distance(*pair) for pair in zip(xi, exact)])
        wrong = errors > np.linalg.norm(xi - other, axis=1)
        return {"error": errors.max(), "wrong": wrong.mean()}

    return judge


def arrays(_: str, degrees: float) -> Attempt:
    q = poses(degrees)[0]
    return Attempt(lambda: dgm(TURNING, q, ASSEMBLY).xi, judged(degrees), POSES)


def in_casadi(jit: bool) -> Callable[..., Attempt]:
    """prepare of the compiled model, all poses by one call."""

    def prepare(_, degrees):
        q, call = (
            poses(degrees)[0],
            Buffered(compile(TURNING, ["q"], ["xi"], ASSEMBLY, jit=jit).map(POSES)),
        )
        return Attempt(lambda: call(q)[0].copy(), judged(degrees), POSES)

    return prepare


def pylinkage(fast: bool) -> Callable[..., Attempt]:
    """prepare of Ground, Crank and RRRDyad: step, as in its documentation, or step_fast, which
    numba compiles.
    """

    def prepare(_, degrees):
        from pylinkage import Crank, Ground, Linkage, RRRDyad

        bases = Ground(-TURNING.d / 2, 0.0), Ground(TURNING.d / 2, 0.0)
        lengths, turn = (TURNING.l11, TURNING.l21), np.radians(degrees)
        cranks = [Crank(*own, turn, q) for *own, q in zip(bases, lengths, START)]
        x, y = (float(value) for value in dgm(TURNING, START, ASSEMBLY).xi)
        tip = RRRDyad(*(crank.output for crank in cranks), TURNING.l12, TURNING.l22, x=x, y=y)
        linkage = Linkage([*bases, *cranks, tip])
        start = linkage.get_coords()

        def call():
            linkage.set_coords(start)
            if fast:
                return linkage.step_fast(POSES)[:, -1]
            return np.array([places[-1] for places in linkage.step(POSES)])

        return Attempt(call, judged(degrees), POSES)

    return prepare


def methods() -> tuple[Method, ...]:
    """Methods of the turning cranks."""
    degrees, other = (1.0, 5.0, 15.0, 20.0, 30.0, 45.0, 60.0, 90.0), "pylinkage"
    installed = lacks_module("pylinkage")
    return (
        Method("fivebar.dgm, arrays", OURS, arrays, degrees),
        Method("fivebar.compile, VM", OURS, in_casadi(False), degrees),
        Method("fivebar.compile, compiled", OURS, in_casadi(True), degrees, (lacks_c_compiler,)),
        Method("pylinkage step", other, pylinkage(False), degrees, (installed,)),
        Method(
            "pylinkage step_fast, numba",
            other,
            pylinkage(True),
            degrees,
            (installed, lacks_module("numba")),
        ),
    )
