"""Velocity and acceleration of the end-effector along a known motion of the cranks: models,
differences, AD.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from ....models.compiled import Buffered, compile, compiled
from ....models.geometry import dgm, joint_pose
from ....models.robots import FiveBar
from ...pitfalls.differentiation import analytic, differences, swing
from ..chart import OURS, Attempt, Chart, Method, Panel
from .dgm_routes import printed
from .exact import distance, exact_motion

if TYPE_CHECKING:
    from collections.abc import Callable

ROBOT = FiveBar()
TIMES = np.linspace(0.0, 2.0, 100)
STEPS = tuple(10.0**-k for k in np.arange(1.5, 9.1, 0.5))
LONE_STEPS = (*STEPS, 1e-10, 1e-11, 1e-12, 1e-13)


@lru_cache(maxsize=1)
def _exact():
    """xi', xi'' at TIMES to 50 digits, and the largest of each."""
    motions = [exact_motion(ROBOT, *state) for state in zip(*swing(TIMES))]
    rates = [motion[1:] for motion in motions]
    return rates, [max(np.hypot(*map(float, at[order])) for at in rates) for order in (0, 1)]


def judge(found: tuple) -> dict[str, float]:
    """(xi', xi''), (n, 2) at TIMES -> largest errors, in parts of the largest rate."""
    exact, largest = _exact()
    errors = [
        [distance(row, at[order]) for row, at in zip(found[order], exact)] for order in (0, 1)
    ]
    return {"velocity": max(errors[0]) / largest[0], "acceleration": max(errors[1]) / largest[1]}


def position(t: np.ndarray) -> np.ndarray:
    return dgm(ROBOT, swing(t)[0]).xi


def central(t: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Of second order."""
    before, now, after = (position(t + k * step) for k in (-1, 0, 1))
    return (after - before) / (2 * step), (after - 2 * now + before) / step**2


def five_points(t: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Of fourth order."""
    a, b, now, d, e = (position(t + k * step) for k in (-2, -1, 0, 1, 2))
    return (a - 8 * b + 8 * d - e) / (12 * step), (-a + 16 * b - 30 * now + 16 * d - e) / (
        12 * step**2
    )


def backward(t: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """MechAnalyzer's: of first order."""
    return differences(ROBOT, t, step)


def complex_step(t: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """x' = Im x(t + ih) / h without a difference; x'' = 2 (x - Re x(t + ih)) / h^2 with one."""
    q, q_dot, q_ddot = swing(t)
    moved = q + 1j * step * q_dot - step**2 / 2 * q_ddot
    shifted, now = (np.stack(printed(angles[:, 0], angles[:, 1]), axis=-1) for angles in (moved, q))
    return shifted.imag / step, 2 * (now - shifted.real) / step**2


def model(t: np.ndarray, _: float) -> tuple[np.ndarray, np.ndarray]:
    return analytic(ROBOT, t)


def by(rule: Callable) -> Callable[..., Attempt]:
    """prepare of a rule (t, step) -> (xi', xi'')."""
    return lambda problem, step: Attempt(lambda: rule(TIMES, step), judge, len(TIMES))


def _in_casadi(function, jit):
    """The function of (q, q', q'') called for all times at once, the motion of the cranks
    included.
    """
    call = Buffered(compiled(function.map(len(TIMES)), jit))
    return Attempt(lambda: call(*swing(TIMES)), judge, len(TIMES))


def models_in_casadi(jit: bool) -> Callable[..., Attempt]:
    def prepare(*_):
        return _in_casadi(compile(ROBOT, ["q", "q_dot", "q_ddot"], ["xi_dot", "xi_ddot"]), jit)

    return prepare


def automatic(jit: bool) -> Callable[..., Attempt]:
    """prepare of CasADi's own differentiation of the position along the motion, twice."""

    def prepare(*_):
        q, q_dot, q_ddot, s = (*(ca.SX.sym(name, 2) for name in ("q", "v", "a")), ca.SX.sym("s"))
        at = q + q_dot * s + q_ddot * s * s / 2
        xi = ca.vertcat(*joint_pose(ROBOT, (at[0], at[1]), -1).point)
        first = ca.jacobian(xi, s)
        rates = ca.substitute([first, ca.jacobian(first, s)], [s], [ca.SX(0)])
        return _in_casadi(ca.Function("automatic", [q, q_dot, q_ddot], ca.cse(rates)), jit)

    return prepare


def chart() -> Chart:
    methods = (
        Method("fivebar: first- and second-order models, NumPy", OURS, by(model)),
        Method("fivebar: the same, CasADi VM", OURS, models_in_casadi(False)),
        Method(
            "fivebar: the same, compiled C", OURS, models_in_casadi(True), needs=("C compiler",)
        ),
        Method("CasADi AD of the position, VM", "differentiated by CasADi", automatic(False)),
        Method(
            "CasADi AD of the position, compiled C",
            "differentiated by CasADi",
            automatic(True),
            needs=("C compiler",),
        ),
        Method(
            "backward differences (MechAnalyzer eq. 23, 25)",
            "differences",
            by(backward),
            STEPS,
            order=1,
        ),
        Method("central differences, 3 points", "differences", by(central), STEPS, order=2),
        Method("central differences, 5 points", "differences", by(five_points), STEPS, order=4),
        Method("complex step", "complex step", by(complex_step), LONE_STEPS, order=2),
    )
    velocity, acceleration = (
        "largest error of the velocity (relative)",
        "largest error of the acceleration (relative)",
    )
    steps = "step Δt between the positions (s)"
    quantity = dict(problem="swing", rounding=1e-16, ceiling=10.0)
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
        step=lambda step: step,
        panels=(
            (
                Panel(
                    y="velocity",
                    title="velocity",
                    ylabel=velocity,
                    x="knob",
                    xlabel=steps,
                    **quantity,
                ),
                Panel(
                    y="acceleration",
                    title="acceleration",
                    ylabel=acceleration,
                    x="knob",
                    xlabel=steps,
                    **quantity,
                ),
            ),
            (
                Panel(
                    y="velocity",
                    title="velocity, against time",
                    ylabel=velocity,
                    xlabel="time for velocity and acceleration of one pose (s)",
                    levels=(1e-3, 1e-9, 1e-14),
                    **quantity,
                ),
                Panel(
                    y="acceleration",
                    title="acceleration, against time",
                    ylabel=acceleration,
                    xlabel="time for velocity and acceleration of one pose (s)",
                    levels=(1e-3, 1e-9, 1e-14),
                    **quantity,
                ),
            ),
        ),
    )
