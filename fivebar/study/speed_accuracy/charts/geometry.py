"""The direct geometric model by every route that the sources take, one pose at a time, in batches,
and near Type 2.
"""

from __future__ import annotations

import ctypes
import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import root

from ....base.backend import EPS
from ....models.compiled import Buffered, compile
from ....models.geometry import dgm
from ....models.machine_code import library
from ....singularities.margins import singularity_margins
from ...pitfalls.newton_dgm import newton_dgm
from ..chart import LIMIT, OURS, Attempt, Chart, Failed, Method, Panel
from .dgm_routes import (
    ASSEMBLY,
    C_LOOP,
    ROBOT,
    arctg,
    elbows,
    equivalent_four_bar,
    ours,
    printed,
    tangent_half_angle,
)
from .exact import distance, exact_motion

if TYPE_CHECKING:
    from collections.abc import Callable

POSES, BATCH = 100, 10**6
TOLERANCES = tuple(10.0**-k for k in (1, 2, 3, 4, 6, 8, 10, 12, 14))
GAPS = tuple(
    10.0**-k for k in np.arange(1, 11.1, 0.5)
)  # how much shorter the span is than both distal bars
WARM, COLD = (
    (0.05, -0.04),
    (math.pi / 3, 2 * math.pi / 3),
)  # rad: off the solution; wherever the solution is
# Of the way to the other assembly mode's pose: a result as far off is of another branch, or of
# none.
WRONG = 0.25


@lru_cache(maxsize=32)
def poses(problem: str, gap: float | None = None) -> tuple:
    """(q (n, 2), exact xi, the other assembly mode's xi, the distal bars' angles (n, 2), 1 /
    sigma_min of A).
    """
    rng = np.random.default_rng(20)
    if problem == "singular":
        # Span between the elbows a little shorter than both bars: the right elbow on two circles.
        q1, span = (
            rng.uniform(-np.pi, np.pi, 4000),
            (ROBOT.l12 + ROBOT.l22) - gap * (ROBOT.l12 + ROBOT.l22),
        )
        x, y = (
            ROBOT.l11 * np.cos(q1) - ROBOT.d,
            ROBOT.l11 * np.sin(q1),
        )  # left elbow from the right base
        square = x * x + y * y
        with np.errstate(invalid="ignore"):
            along = (square + ROBOT.l21**2 - span**2) / (2 * square)
            across = np.sqrt(ROBOT.l21**2 / square - along**2)
        q = np.stack([q1, np.arctan2(along * y + across * x, along * x - across * y)], axis=-1)
    else:
        q = rng.uniform(-np.pi, np.pi, (4000, 2))
    pose = dgm(ROBOT, np.nan_to_num(q), ASSEMBLY, unreachable="nan")
    good = np.isfinite(pose.xi[:, 0]) & np.isfinite(q[:, 1])
    if problem != "singular":
        good &= np.abs(pose.det_A) > 0.3
    q = q[good][:POSES]
    pose = dgm(ROBOT, q, ASSEMBLY)
    exact, other = (
        [exact_motion(ROBOT, angles, assembly=a)[0] for angles in q] for a in (ASSEMBLY, -ASSEMBLY)
    )
    return (
        q,
        exact,
        np.array(other, dtype=float),
        pose.q + pose.q_passive,
        1 / singularity_margins(pose).sigma_min.A,
    )


def judged(problem: str, gap: float | None = None) -> Callable[..., dict[str, float]]:
    """xi (n, 2) -> largest error, m, near singularities beside the median of 1 / sigma; Failed
    where branches fail.
    """
    _, exact, other, _, inverse = poses(problem, gap)

    def judge(xi):
        xi = np.asarray(xi, dtype=float)[: len(exact)]
        if np.isnan(xi).any():
            raise Failed(f"nan in {np.isnan(xi).any(axis=1).mean():.0%}")
        errors = np.array([distance(*pair) for pair in zip(xi, exact)])
        wrong = errors > WRONG * np.linalg.norm(other - np.array(exact, dtype=float), axis=1)
        if wrong.any():
            raise Failed(f"wrong branch in {wrong.mean():.0%}")
        if problem == "singular":
            return {"error": errors.max(), "inverse_sigma": np.median(inverse)}
        return {"error": errors.max()}

    return judge


def closed(route: Callable) -> Callable[..., Attempt]:
    """prepare of a closed form: a loop over the poses, or arrays."""

    def prepare(problem, knob):
        gap = knob if problem == "singular" else None
        q = poses(problem, gap)[0]
        if problem == "one":
            pairs = [tuple(row) for row in q.tolist()]
            return Attempt(lambda: [route(*pair) for pair in pairs], judged(problem), len(pairs))
        if problem == "batch":
            q = _tiled(q)
        columns = np.ascontiguousarray(q[:, 0]), np.ascontiguousarray(q[:, 1])
        judge = judged(problem, gap)
        return Attempt(lambda: route(*columns), lambda xi: judge(np.stack(xi, axis=-1)), len(q))

    return prepare


def _tiled(q):
    return np.tile(q, (-(-BATCH // len(q)), 1))[:BATCH]


def in_casadi(jit: bool) -> Callable[..., Attempt]:
    """prepare of the compiled model: called once a pose, or for a batch by one call."""

    def prepare(problem, _):
        q, function = poses(problem)[0], compile(ROBOT, ["q"], ["xi"], ASSEMBLY, jit=jit)
        if problem == "batch":
            q = _tiled(q)
            call = Buffered(function.map(len(q)))
            return Attempt(lambda: call(q)[0], judged(problem), len(q))
        call = Buffered(function)
        return Attempt(lambda: [call(row)[0].copy() for row in q], judged(problem), len(q))

    return prepare


def c_loop(problem: str, _: float) -> Attempt:
    q = _tiled(poses(problem)[0]) if problem == "batch" else poses(problem)[0]
    xi, pointer = np.empty_like(q), ctypes.POINTER(ctypes.c_double)
    loop = ctypes.CDLL(str(library(C_LOOP))).dgm
    arguments = ctypes.c_long(len(q)), q.ctypes.data_as(pointer), xi.ctypes.data_as(pointer)

    def call():
        loop(*arguments)
        return xi

    return Attempt(call, judged(problem), len(q))


def newton(warm: bool) -> Callable[..., Attempt]:
    """prepare of Newton's method; its knob is the residual at which it stops, near Type 2 the
    smallest that it has.
    """

    def prepare(problem, knob):
        gap, tolerance = (knob, 1e-14) if problem == "singular" else (None, knob)
        q, _, _, phi, _ = poses(problem, gap)
        starts = phi + WARM if warm else np.tile(COLD, (len(q), 1))
        pairs, judge = list(zip(q.tolist(), starts.tolist())), judged(problem, gap)

        def judge_converged(found):
            if not all(pose.converged for pose in found):
                raise Failed(f"diverged in {np.mean([not pose.converged for pose in found]):.0%}")
            return judge([pose.xi for pose in found])

        return Attempt(
            lambda: [newton_dgm(ROBOT, *pair, tolerance) for pair in pairs], judge_converged, len(q)
        )

    return prepare


def scipy_root(problem: str, knob: float) -> Attempt:
    """SciPy's root with its defaults (hybr), warm start, xtol the knob."""
    gap, xtol = (knob, 1e-14) if problem == "singular" else (None, knob)
    q, _, _, phi, _ = poses(problem, gap)
    jobs, judge = (
        list(zip([elbows(*row) for row in q.tolist()], (phi + WARM).tolist())),
        judged(problem, gap),
    )
    l1, l2 = ROBOT.l12, ROBOT.l22

    def solve(ends, start):
        x1, y1, dx, dy = ends

        def loop(phi):
            return [
                l1 * math.cos(phi[0]) - dx - l2 * math.cos(phi[1]),
                l1 * math.sin(phi[0]) - dy - l2 * math.sin(phi[1]),
            ]

        angle = root(loop, start, tol=xtol).x[0]
        return x1 + l1 * math.cos(angle), y1 + l1 * math.sin(angle)

    return Attempt(lambda: [solve(*job) for job in jobs], judge, len(q))


def chart() -> Chart:
    single = {"one": (0,), "batch": (0,)}
    everywhere = single | {"singular": GAPS}
    iterated = {"one": TOLERANCES, "singular": GAPS}
    machine = ("C compiler",)
    methods = (
        Method("fivebar: RRR dyad, NumPy", OURS, closed(ours), everywhere),
        Method("fivebar: CasADi VM", OURS, in_casadi(False), single),
        Method("fivebar: CasADi, compiled C", OURS, in_casadi(True), single, machine),
        Method("C loop by hand (the limit)", LIMIT, c_loop, single, machine),
        Method(
            "closed form as printed (AMORO eq. 1-3)", "closed forms", closed(printed), everywhere
        ),
        Method("tangent half-angle", "closed forms", closed(tangent_half_angle), everywhere),
        Method(
            "equivalent four-bar (MechAnalyzer eq. 17-21)",
            "closed forms",
            closed(equivalent_four_bar),
            everywhere,
        ),
        Method("arctg angles (vector method eq. 9)", "closed forms", closed(arctg), single),
        Method("Newton, warm start", "iterations", newton(True), iterated),
        Method("Newton, cold start", "iterations", newton(False), {"one": TOLERANCES}),
        Method("SciPy root, warm start", "iterations", scipy_root, iterated),
    )
    size = "largest error of the position (m)"
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
        problems={
            "one": "one pose at a time",
            "batch": "10⁶ poses at once",
            "singular": "near Type 2",
        },
        methods=methods,
        panels=(
            (
                Panel(
                    "one",
                    "one pose at a time, called from Python",
                    ylabel=size,
                    xlabel="time per pose (s)",
                    levels=(1e-3, 1e-9, 1e-15),
                ),
                Panel(
                    "batch",
                    "10⁶ poses at once",
                    ylabel=size,
                    xlabel="time per pose (s)",
                    levels=(1e-12, 1e-15),
                ),
                Panel(
                    "singular",
                    "near a Type-2 singularity",
                    ylabel=size,
                    x="inverse_sigma",
                    xlabel="1 / σ, σ the smallest singular value of A (no unit)",
                    guide=(ROBOT.l12 * EPS, "1/σ × rounding of a bar's length"),
                ),
            ),
        ),
    )
