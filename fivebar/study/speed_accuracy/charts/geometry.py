"""The direct geometric model by every route of the sources: one pose, a batch, near Type 2."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.optimize import root

from ....base.backend import EPS
from ....models.compiled import Buffered, compile
from ....models.dyads import RRR
from ....models.geometry import dgm
from ....models.machine_code import library
from ....singularities.margins import singularity_margins
from ...pitfalls.newton_dgm import newton_dgm
from ..chart import LIMIT, OURS, Attempt, Chart, Failed, Method, Panel
from ..machine import lacks_c_compiler
from . import dgm_routes as routes
from .dgm_routes import ASSEMBLY, ROBOT
from .exact import distance, exact_motion

POSES = 100
BATCH = 10**6
TOLERANCES = tuple(10.0**-k for k in (1, 2, 3, 4, 6, 8, 10, 12, 14))
# How much shorter the span between the elbows is than both distal bars, in parts of them.
GAPS = tuple(10.0**-k for k in np.arange(1, 11.1, 0.5))
WARM = 0.05, -0.04  # rad from the solution
COLD = math.pi / 3, 2 * math.pi / 3  # rad, wherever the solution is
# Of the distance to the pose of the other assembly mode: a result as far off is of another branch.
WRONG = 0.25
FORMS = "closed forms"  # the family of formulas as sources print them


@dataclass(frozen=True, eq=False)
class Poses:
    """q (n, 2), exact positions of both assembly modes, angles of the distal bars (n, 2), 1 / the
    smallest singular value of A (n,).
    """

    q: np.ndarray
    exact: list
    other: np.ndarray
    phi: np.ndarray
    inverse_sigma: np.ndarray


@lru_cache(maxsize=32)
def poses(problem: str, gap: float = 0.0) -> Poses:
    """Return random poses of a problem: with |det A| above 0.3, or near Type 2 by the gap."""
    q = np.random.default_rng(20).uniform(-np.pi, np.pi, (4000, 2))
    if problem == "singular":
        q = _near_type_2(np.random.default_rng(20).uniform(-np.pi, np.pi, 4000), gap)
    pose = dgm(ROBOT, np.nan_to_num(q), ASSEMBLY, unreachable="nan")
    good = np.isfinite(pose.xi[:, 0]) & np.isfinite(q[:, 1])
    if problem != "singular":
        good &= np.abs(pose.det_A) > 0.3
    q = q[good][:POSES]
    pose = dgm(ROBOT, q, ASSEMBLY)
    exact = [exact_motion(ROBOT, angles)[0] for angles in q]
    other = [exact_motion(ROBOT, angles, assembly=-ASSEMBLY)[0] for angles in q]
    inverse_sigma = 1 / singularity_margins(pose).sigma_min.A
    return Poses(q, exact, np.array(other, float), pose.q + pose.q_passive, inverse_sigma)


def _near_type_2(q1, gap):
    """Return q with the elbows a gap less than both distal bars apart; nan if there is none.

    The right elbow closes a dyad of that span and the right crank.
    """
    span = (1 - gap) * (ROBOT.l12 + ROBOT.l22)
    from_left = ROBOT.d - ROBOT.l11 * np.cos(q1), -ROBOT.l11 * np.sin(q1)
    x, y = RRR(from_left, span, ROBOT.l21, -1).second
    return np.stack([q1, np.arctan2(y, x)], axis=-1)


def judged(problem: str, gap: float = 0.0) -> Callable[..., dict[str, float]]:
    """Return judge: xi (n, 2) -> largest error, m; Failed where branches fail."""
    known = poses(problem, gap)
    apart = np.linalg.norm(known.other - np.array(known.exact, dtype=float), axis=1)

    def judge(xi):
        xi = np.asarray(xi, dtype=float)[: len(apart)]
        lost = np.isnan(xi).any(axis=1)
        if lost.any():
            raise Failed(f"nan in {lost.mean():.0%}")
        errors = np.array([distance(*pair) for pair in zip(xi, known.exact)])
        wrong = errors > WRONG * apart
        if wrong.any():
            raise Failed(f"wrong branch in {wrong.mean():.0%}")
        return {"error": errors.max(), "inverse_sigma": np.median(known.inverse_sigma)}

    return judge


def closed(route: Callable) -> Callable[..., Attempt]:
    """Return prepare of a closed form: a loop over the poses, or arrays."""

    def prepare(problem, gap):
        q = _tiled(problem, poses(problem, gap).q)
        judge = judged(problem, gap)
        if problem == "one":
            pairs = q.tolist()
            return Attempt(lambda: [route(*pair) for pair in pairs], judge, len(q))
        columns = [np.ascontiguousarray(column) for column in q.T]
        return Attempt(lambda: route(*columns), lambda xi: judge(np.stack(xi, axis=-1)), len(q))

    return prepare


def _tiled(problem, q):
    return np.resize(q, (BATCH, 2)) if problem == "batch" else q


def in_casadi(jit: bool) -> Callable[..., Attempt]:
    """Return prepare of the compiled model: called once a pose, or for a batch by one call."""

    def prepare(problem, _):
        q = poses(problem).q
        function = compile(ROBOT, ["q"], ["xi"], ASSEMBLY, jit=jit)
        if problem == "batch":
            q = _tiled(problem, q)
            batch = Buffered(function.map(len(q)))
            return Attempt(lambda: batch(q)[0], judged(problem), len(q))
        call = Buffered(function)
        return Attempt(lambda: [call(row)[0].copy() for row in q], judged(problem), len(q))

    return prepare


def c_loop(problem: str, _: float) -> Attempt:
    """Prepare the loop in C, called once for all poses."""
    q = _tiled(problem, poses(problem).q)
    xi = np.empty_like(q)
    loop = ctypes.CDLL(str(library(routes.C_LOOP))).dgm

    def call():
        loop(ctypes.c_long(len(q)), ctypes.c_void_p(q.ctypes.data), ctypes.c_void_p(xi.ctypes.data))
        return xi

    return Attempt(call, judged(problem), len(q))


def iterated(solve: Callable, warm: bool) -> Callable[..., Attempt]:
    """Return prepare of solve(q, angles of the distal bars to start from, tolerance) -> xi or None.

    Its knob is the tolerance; near Type 2 that is the smallest.
    """

    def prepare(problem, knob):
        gap, tolerance = (knob, 1e-14) if problem == "singular" else (0.0, knob)
        known = poses(problem, gap)
        judge = judged(problem, gap)
        starts = known.phi + WARM if warm else np.tile(COLD, (len(known.q), 1))
        jobs = list(zip(known.q.tolist(), starts.tolist()))

        def judge_converged(points):
            diverged = np.mean([xi is None for xi in points])
            if diverged:
                raise Failed(f"diverged in {diverged:.0%}")
            return judge(points)

        return Attempt(lambda: [solve(*job, tolerance) for job in jobs], judge_converged, len(jobs))

    return prepare


def newton(q: list, start: list, tolerance: float) -> tuple | None:
    """Newton's method of the pitfalls."""
    pose = newton_dgm(ROBOT, q, start, tolerance)
    return pose.xi if pose.converged else None


def scipy_root(q: list, start: list, xtol: float) -> tuple:
    """SciPy's root with its defaults (hybr)."""
    x1, y1, dx, dy = routes.elbows(*q)
    l1 = ROBOT.l12
    l2 = ROBOT.l22

    def loop(phi):
        return [
            l1 * math.cos(phi[0]) - dx - l2 * math.cos(phi[1]),
            l1 * math.sin(phi[0]) - dy - l2 * math.sin(phi[1]),
        ]

    angle = root(loop, start, tol=xtol).x[0]
    return x1 + l1 * math.cos(angle), y1 + l1 * math.sin(angle)


def chart() -> Chart:
    """Return the chart of the direct geometric model."""
    single = {"one": (0,), "batch": (0,)}
    everywhere = single | {"singular": GAPS}
    both = {"one": TOLERANCES, "singular": GAPS}
    cold = {"one": TOLERANCES}
    machine = (lacks_c_compiler,)
    loops = "iterations"
    methods = (
        Method("fivebar: RRR dyad, NumPy", OURS, closed(routes.ours), everywhere),
        Method("fivebar: CasADi VM", OURS, in_casadi(False), single),
        Method("fivebar: CasADi, compiled C", OURS, in_casadi(True), single, machine),
        Method("C loop by hand (the limit)", LIMIT, c_loop, single, machine),
        Method("closed form as printed (AMORO eq. 1-3)", FORMS, closed(routes.printed), everywhere),
        Method("Newton, warm start", loops, iterated(newton, True), both),
        Method("Newton, cold start", loops, iterated(newton, False), cold),
        Method("SciPy root, warm start", loops, iterated(scipy_root, True), both),
    )
    labels: dict[str, Any] = {
        "ylabel": "largest error of the position (m)",
        "xlabel": "time per pose (s)",
    }
    one = Panel(
        "one", "one pose at a time, called from Python", levels=(1e-3, 1e-9, 1e-15), **labels
    )
    batch = Panel("batch", "10⁶ poses at once", levels=(1e-12, 1e-15), **labels)
    labels["xlabel"] = "1 / σ, σ the smallest singular value of A (no unit)"
    guide = ROBOT.l12 * EPS, "1/σ × rounding of a bar's length"
    near = Panel("singular", "near a Type-2 singularity", x="inverse_sigma", guide=guide, **labels)
    return Chart(
        name="geometry",
        title=(
            "Where is the end-effector? Direct geometric model of the five-bar: error against time"
        ),
        reading=(
            f"Left and middle: each point is a method; errors are the largest of {POSES} poses of"
            " the whole joint space, against 50 digits. Iterations have one point for each"
            " tolerance; the loop in C is called once for all poses. Right: the same error where"
            " the distal bars approach one line (Type 2), against 1/σ, the amplification of joint"
            " errors there; the dotted line is what rounding of the given angles alone must cost."
        ),
        problems={panel.problem: panel.title for panel in (one, batch, near)},
        methods=methods,
        panels=((one, batch, near),),
    )
