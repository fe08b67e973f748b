"""The ten functions of the AMORO lab as questions: at any pose, and along the oscillation of the
lab's own tests.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from ..models.geometry import dgm, igm
from ..models.kinematics import Accelerations, dkm, dkm2, ikm, ikm2
from ..models.robots import Robot
from ..simulation.simulate import simulate
from .columns import Columns, batch, joint_motion, joints
from .samples import poses

TEN = "dgm igm dgm_passive dkm ikm dkm_passive dkm2 ikm2 dkm2_passive dynamic_model".split()
# What a function may call without paying for its mistakes. No two may call each other: the right
# one of either would answer for both.
USES = {
    "dgm_passive": ("dgm",),
    "ikm": ("dkm",),
    "dkm2": ("dkm",),
    "ikm2": ("dkm", "dkm2"),
    "dkm2_passive": ("dkm",),
    "dynamic_model": ("dkm", "dkm2"),
}
TOLERANCE = (
    1e-6  # of the largest right answer: what l = 0.2828427 in place of 0.2 sqrt(2) costs is right
)
THRESHOLD = 1e-3  # below it the lab's own tests print OK
SAMPLES, EVERY, PERIOD = 50, 10, 0.01  # of the oscillation, each so many steps of so many s


def columns_of(name: str, acc: Accelerations) -> Columns:
    """Return what a batch of motions (n,) asks one of the ten functions."""
    rates, pose = acc.rates, acc.rates.pose
    four = joints(pose)
    return {
        "dgm": (*pose.q.T, pose.assembly),
        "igm": (*pose.xi.T, *pose.working.T),
        "dgm_passive": (*pose.q.T, pose.assembly),
        "dkm": (*four, *rates.q_dot.T),
        "ikm": (*four, *rates.xi_dot.T),
        "dkm_passive": (*four, *rates.q_dot.T, *rates.xi_dot.T),
        "dkm2": (*joint_motion(rates), *acc.q_ddot.T),
        "ikm2": (*joint_motion(rates), *acc.xi_ddot.T),
        "dkm2_passive": (*joint_motion(rates), *acc.q_ddot.T, *acc.xi_ddot.T),
        "dynamic_model": joint_motion(rates),
    }[name]


def motions(robot: Robot, draw: np.random.Generator, n: int) -> Accelerations:
    """Return n motions in regular poses of all modes."""
    speed, most = (0.3, 2.0) if robot.turns else (0.5, 3.0)  # m/s, m/s^2
    rates = ikm(poses(robot, draw, n), draw.uniform(-speed, speed, (n, 2)))
    return ikm2(rates, draw.uniform(-most, most, (n, 2)))


@cache
def oscillation(robot: Robot) -> Accelerations:
    """Return states of the lab's oscillation from home: efforts +-, each turned when its joint has
    passed a limit.
    """
    effort, limit = (0.0002, 0.05) if robot.turns else (0.01, 0.01)  # N m and rad, N and m
    now = np.array([effort, -effort])

    def square(t, q, q_dot, reference):
        now[(now * q > 0) & (np.abs(q) > limit)] *= -1
        return now.copy()

    start = dkm(dgm(robot, (0.0, 0.0)), (0.0, 0.0))
    run = simulate(
        robot,
        square,
        duration=SAMPLES * EVERY * PERIOD,
        start=start,
        control_period=PERIOD,
        step=PERIOD,
    )
    rows = slice(EVERY // 2, None, EVERY)
    rates = dkm(dgm(robot, run.q[rows]), run.q_dot[rows])
    # q'' of M q'' + c = tau is not asked for here: any acceleration of this size tells as much.
    return dkm2(rates, np.gradient(run.q_dot, PERIOD, axis=0)[rows])


def evaluated(acc: Accelerations, name: str) -> Callable:
    """Return what the lab's own test compares, (n, 2), of the numbers (n, k) that a
    function gave.
    """
    if name != "dynamic_model":
        return lambda numbers: numbers
    q_ddot = acc.q_ddot
    return lambda numbers: (
        np.einsum("nij,nj->ni", numbers[:, :4].reshape(-1, 2, 2), q_ddot) + numbers[:, 4:]
    )


def unreachable(robot: Robot, name: str, draw: np.random.Generator, n: int) -> Columns:
    """Return questions of dgm or igm that have no answer."""
    if name == "dgm":
        most = np.pi if robot.turns else 1.0
        q = draw.uniform(-most, most, (400, 2))
        pose = dgm(robot, q, unreachable="nan")
        out_of_reach = np.isnan(pose.xi[:, 0])
        q11, q21 = q[out_of_reach][:n].T
        both_modes = np.tile([-1, 1], n)
        return q11, q21, both_modes[:n]
    xi = draw.uniform(-1, 1, (400, 2)) * 2.2 * sum(robot.distal)
    pose = igm(robot, xi, unreachable="nan")
    out_of_reach = np.isnan(pose.q).any(axis=1)
    x, y = xi[out_of_reach][:n].T
    gamma1, gamma2 = draw.choice([-1, 1], (2, n))
    return x, y, gamma1, gamma2


def checks() -> dict[str, Callable]:
    """Return the tests of a lab on the ten functions, by name: two that count for each; one of dgm
    and igm that does not.
    """
    found = {}
    for name in TEN:
        found[f"test_{name}_oscillating"] = _oscillating(name)
        found[f"test_{name}_all_over"] = _all_over(name)
        if name in ("dgm", "igm"):
            found[f"test_{name}_beyond"] = _beyond(name)
    return found


def _oscillating(name):
    @pytest.mark.points(1)
    def test(ask, robot, draw):
        acc = oscillation(robot)
        threshold = THRESHOLD, evaluated(acc, name)
        ask(name, *columns_of(name, acc), tolerance=TOLERANCE, threshold=threshold)

    test.__doc__ = f"{name}: along the lab's oscillation"
    return test


def _all_over(name):
    @pytest.mark.points(1)
    def test(ask, robot, draw):
        rows = columns_of(name, motions(robot, draw, 16))
        ask(name, *rows, tolerance=TOLERANCE)

    test.__doc__ = f"{name}: regular poses of all modes"
    return test


def _beyond(name):
    @pytest.mark.points(0)
    def test(ask, robot, draw):
        rows = batch(columns_of(name, motions(robot, draw, 8)), unreachable(robot, name, draw, 8))
        ask(name, *rows, tolerance=TOLERANCE, refuse=np.arange(16) >= 8)

    test.__doc__ = f"{name}: where no pose exists (not counted)"
    return test
