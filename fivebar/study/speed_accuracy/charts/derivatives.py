"""Velocity and acceleration of the end-effector: models, differences, automatic differentiation."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial

import casadi as ca
import numpy as np

from ....models.compiled import Buffered, compile, compiled
from ....models.geometry import dgm, joint_pose
from ....models.robots import FiveBar
from ...pitfalls.differentiation import analytic, differences, swing
from ..chart import OURS, Attempt, Chart, Method, Panel
from ..machine import lacks_c_compiler
from .dgm_routes import printed
from .exact import distance, exact_motion

ROBOT = FiveBar()
TIMES = np.linspace(0.0, 2.0, 100)
STEPS = tuple(10.0**-k for k in np.arange(1.5, 9.1, 0.5))
LONE_STEPS = (*STEPS, 1e-10, 1e-11, 1e-12, 1e-13)


@lru_cache(maxsize=1)
def _exact():
    """Return xi', xi'' at TIMES to 50 digits."""
    motions = [exact_motion(ROBOT, *state) for state in zip(*swing(TIMES))]
    _, velocities, accelerations = zip(*motions)
    return velocities, accelerations


def judge(rates: tuple) -> dict[str, float]:
    """Return the largest errors of (xi', xi''), (n, 2) at TIMES, in parts of the largest rate."""
    errors = []
    for values, exact in zip(rates, _exact()):
        largest = np.linalg.norm(np.array(exact, dtype=float), axis=1).max()
        errors.append(max(map(distance, values, exact)) / largest)
    return {"velocity": errors[0], "acceleration": errors[1]}


def stencil(places: tuple, first: tuple, second: tuple) -> Callable:
    """Return the rule (t, step) -> (xi', xi'') of weighted positions at t + places * step."""

    def rule(t, step):
        xi = [dgm(ROBOT, swing(t + k * step)[0]).xi for k in places]
        return np.tensordot(first, xi, 1) / step, np.tensordot(second, xi, 1) / step**2

    return rule


central = stencil((-1, 0, 1), (-1 / 2, 0, 1 / 2), (1, -2, 1))
five_points = stencil(
    (-2, -1, 0, 1, 2),
    (1 / 12, -8 / 12, 0, 8 / 12, -1 / 12),
    (-1 / 12, 16 / 12, -30 / 12, 16 / 12, -1 / 12),
)
backward = partial(differences, ROBOT)


def complex_step(t: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """x' = Im x(t + ih) / h without a difference; x'' = 2 (x - Re x(t + ih)) / h^2 with one."""
    q, q_dot, q_ddot = swing(t)
    moved = q + 1j * step * q_dot - step**2 / 2 * q_ddot
    shifted, now = (np.stack(printed(*angles.T), axis=-1) for angles in (moved, q))
    return shifted.imag / step, 2 * (now - shifted.real) / step**2


def by(rule: Callable) -> Callable[..., Attempt]:
    """Return prepare of a rule (t, step) -> (xi', xi'')."""
    return lambda _, step: Attempt(lambda: rule(TIMES, step), judge, len(TIMES))


def in_casadi(make: Callable[[], ca.Function], jit: bool) -> Callable[..., Attempt]:
    """Return prepare of a function of (q, q', q''), called for all times at once."""

    def prepare(*_):
        call = Buffered(compiled(make().map(len(TIMES)), jit))
        return Attempt(lambda: call(*swing(TIMES)), judge, len(TIMES))

    return prepare


def models() -> ca.Function:
    """Return our models as one function."""
    return compile(ROBOT, ["q", "q_dot", "q_ddot"], ["xi_dot", "xi_ddot"])


def automatic() -> ca.Function:
    """Return CasADi's own differentiation of the position along the motion, twice."""
    q, q_dot, q_ddot, s = *(ca.SX.sym(name, 2) for name in "qva"), ca.SX.sym("s")
    moved = q + q_dot * s + q_ddot * s * s / 2
    xi = ca.vertcat(*joint_pose(ROBOT, (moved[0], moved[1]), -1).point)
    first = ca.jacobian(xi, s)
    rates = ca.substitute([first, ca.jacobian(first, s)], [s], [ca.SX(0)])
    return ca.Function("automatic", [q, q_dot, q_ddot], ca.cse(rates))


def chart() -> Chart:
    """Return the chart of derivatives."""
    compiler = (lacks_c_compiler,)
    ad = "differentiated by CasADi"
    by_step = "differences"
    mechanalyzer = "backward differences (MechAnalyzer eq. 23, 25)"
    methods = (
        Method(
            "fivebar: first- and second-order models, NumPy",
            OURS,
            by(lambda t, _: analytic(ROBOT, t)),
        ),
        Method("fivebar: the same, CasADi VM", OURS, in_casadi(models, False)),
        Method("fivebar: the same, compiled C", OURS, in_casadi(models, True), (0,), compiler),
        Method("CasADi AD of the position, VM", ad, in_casadi(automatic, False)),
        Method(
            "CasADi AD of the position, compiled C", ad, in_casadi(automatic, True), (0,), compiler
        ),
        Method(mechanalyzer, by_step, by(backward), STEPS, order=1),
        Method("central differences, 3 points", by_step, by(central), STEPS, order=2),
        Method("central differences, 5 points", by_step, by(five_points), STEPS, order=4),
        Method("complex step", "complex step", by(complex_step), LONE_STEPS, order=2),
    )
    step: tuple = "knob", "step Δt between the positions (s)", ()
    time: tuple = (
        "seconds",
        "time for velocity and acceleration of one pose (s)",
        (1e-3, 1e-9, 1e-14),
    )
    rows = []
    for suffix, (x, xlabel, levels) in (("", step), (", against time", time)):
        row = []
        for y in ("velocity", "acceleration"):
            label = f"largest error of the {y} (relative)"
            row.append(Panel("swing", y + suffix, y, label, x, xlabel, levels, 1e-16, ceiling=10.0))
        rows.append(tuple(row))
    return Chart(
        name="derivatives",
        title="Velocity and acceleration from positions: how much of them survives differencing",
        reading=(
            "Above: error against the step of the differences. Going left it first falls with the"
            " method's order, then rises as rounding is divided by Δt; models and AD have no step"
            " and are drawn as lines. Below: the same errors against time, one point for each step."
            " Errors are the largest of 100 times, against 50 digits."
        ),
        problems={"swing": "both cranks swing smoothly for 2 s"},
        methods=methods,
        panels=tuple(rows),
    )
