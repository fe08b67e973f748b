"""Charts: which coordinates of the motion are integrated. The dynamics is the bar-force form in
every one of them.

A chart's state is (c, c'), `size` coordinates and their rates; its modes are the signs that its
coordinates leave open. It is regular where none of its `margins` is zero, columns of (sin q12, sin
q22, det A). `BarAngles`, the state of every pose, has none; `Task` is the fastest where the motion
is regular; `Joint` is what others integrate in.
"""

from dataclasses import dataclass
from typing import Any

from ..base.backend import sign
from .dyads import SINGULAR, dot
from .four_joints import bars_of, bars_rates, closed
from .geometry import joint_pose, task_pose
from .kinematics import Rates, solve_a
from .physics import loads_of


@dataclass(frozen=True)
class BarAngles:
    """The angles of all four bars (q1, phi1, q2, phi2), no mode. Regular everywhere but with all of
    them parallel.
    """

    name = "bars"
    size = 4
    wraps = False
    margins = ()

    def rates(self, robot, c, c_dot, modes):
        return bars_rates(robot, c, c_dot)

    def turned(self, robot, c, c_dot, modes):
        """Return rates with the same accelerations: a robot of cranks seen from its left distal bar
        has three directions.

        Not under gravity, which has a direction of its own.
        """
        turns = robot.turns and not loads_of(robot).has_gravity
        return bars_rates(
            robot, (c[0] - c[1], 0.0, c[2] - c[1], c[3] - c[1]) if turns else c, c_dot
        )

    def joints(self, c, rates):
        """Return q of coordinates c; their Rates may be `turned`."""
        return c[0], c[2]

    def accelerations(self, accelerations):
        (q1, q2), (turn1, turn2) = accelerations._q_ddot, accelerations.phi_ddot
        return q1, turn1, q2, turn2

    def coordinates(self, rates):
        return *bars_of(rates), (0, 0)

    def closed(self, robot, c, c_dot, modes):
        return closed(robot, c, c_dot)


class Minimal:
    """What charts of two coordinates share: they close by themselves."""

    size = 2
    wraps = False  # whether joint coordinates jump by a turn along a motion

    def turned(self, robot, c, c_dot, modes):
        return self.rates(robot, c, c_dot, modes)

    def joints(self, c, rates):
        return tuple(leg.q for leg in rates.pose.legs)

    def closed(self, robot, c, c_dot, modes):
        return c, c_dot, self.rates(robot, c, c_dot, modes)


@dataclass(frozen=True)
class JointChart(Minimal):
    """Active joint coordinates (q1, q2), mode: assembly. Regular away from Type 2."""

    name = "joint"
    margins = (2,)

    def rates(self, robot, c, c_dot, modes):
        pose = joint_pose(robot, c, modes[0])
        along = tuple(b * rate for b, rate in zip(pose.b, c_dot))
        return Rates(pose, c_dot, solve_a(pose, along, "the joint chart"))

    def accelerations(self, accelerations):
        return accelerations._q_ddot

    def coordinates(self, rates):
        """Return (c, c', modes) of this chart for a motion known in another."""
        return tuple(leg.q for leg in rates.pose.legs), rates._q_dot, (rates.pose.assembly, 0)


@dataclass(frozen=True)
class TaskChart(Minimal):
    """Task coordinates (x, y), modes: both working modes. Regular away from Type 1 of either leg;
    no sine in it.
    """

    name = "task"
    margins = (0, 1)
    wraps = True

    def rates(self, robot, c, c_dot, modes):
        pose = task_pose(robot, c, modes)
        return Rates(pose, tuple(dot(u2, c_dot) / b for u2, b in zip(pose.u2, pose.b)), c_dot)

    def accelerations(self, accelerations):
        return accelerations._xi_ddot

    def coordinates(self, rates):
        return (
            rates.pose.point,
            rates._xi_dot,
            tuple(-sign(sine, SINGULAR) for sine in rates.pose.sines),
        )


StateChart = BarAngles | TaskChart | JointChart


def halves(state: Any, chart: StateChart) -> tuple[tuple, tuple]:
    """Return (c, c') of a state of the chart, symbols, on components."""
    parts = tuple(state[k] for k in range(2 * chart.size))
    return parts[: chart.size], parts[chart.size :]


CHARTS: dict[str, StateChart] = {"auto": BarAngles(), "task": TaskChart(), "joint": JointChart()}
