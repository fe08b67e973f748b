"""Motions of which all four joints or bars are given: nothing is solved for, so no mode is asked
for.

The state of every pose: the four bars, a = (q1, phi1, q2, phi2), and their rates. Directions,
end-effector, sines and modes follow without a root, a branch or a division, and so do the
accelerations by the bar forces, regular at Type 1 and Type 2, where a leg is folded on its base
joint, and in corners of the workspace. Singular are only poses in which
all four bars are parallel: they lie along the base then, so that +-l11 +-l12 +-l21 +-l22 = d, which
change-point robots alone can do (a biglide where both bars are across the guides: l1 +-l2 = +-d).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ..base.backend import atan2, cos, sin
from .dyads import dot
from .kinematics import Rates
from .pose import DrivenLeg, Pose

if TYPE_CHECKING:
    from .robots import Robot


def four_joint_pose(robot: Robot, q: tuple, q_passive: tuple) -> Pose:
    """Return the pose with all four joint angles given, on components; the end-effector is the left
    leg's (AMORO eq. 4).
    """
    phi = (drive.absolute(passive, own) for drive, own, passive in zip(robot.drives, q, q_passive))
    return _pose(robot, q, phi)


def bars_pose(robot: Robot, a: tuple) -> Pose:
    """Return the pose in which the bars are at a = (q1, phi1, q2, phi2), rad (q in m for sliders),
    on components.
    """
    return _pose(robot, a[::2], a[1::2])


def _pose(robot, q, phi):
    legs = []
    for drive, own, angle in zip(robot.drives, q, phi):
        legs.append(
            DrivenLeg(
                drive, own, drive.direction(own), lambda angle=angle: (cos(angle), sin(angle))
            )
        )
    x, y = robot.drives[0].pivot(legs[0].direction)
    ux, uy = legs[0].distal
    return Pose(
        robot, (x + robot.distal[0] * ux, y + robot.distal[0] * uy), lambda: (tuple(legs), ())
    )


@dataclass(frozen=True, eq=False)
class FourJointRates(Rates):
    """Rates with the distal bars' given."""

    _turns: tuple = field(kw_only=True)  # phi_i'

    @property
    def _transverse_velocity(self):
        return tuple(bar * turn for bar, turn in zip(self.pose.robot.distal, self._turns))


def four_joint_rates(pose: Pose, q_dot: tuple, q_passive_dot: tuple) -> FourJointRates:
    """Return rates of which the four joints' are known, on components; the end-effector's velocity
    is not to be read.
    """
    turns = tuple(
        drive.absolute(p, q) for drive, p, q in zip(pose.robot.drives, q_passive_dot, q_dot)
    )
    return FourJointRates(pose, q_dot, (0.0, 0.0), _turns=turns)


def bars_rates(robot: Robot, a: tuple, a_dot: tuple) -> FourJointRates:
    """Return rates in which the bars are as in `bars_pose`, and turn at a_dot; that they close the
    loop is not checked.
    """
    return _rates(bars_pose(robot, a), a_dot)


def _rates(pose, a_dot):
    (tx, ty), (vx, vy) = _columns(pose)[0]
    xi_dot = tx * a_dot[0] + vx * a_dot[1], ty * a_dot[0] + vy * a_dot[1]
    return FourJointRates(pose, tuple(a_dot[::2]), xi_dot, _turns=tuple(a_dot[1::2]))


def bars_of(rates: Rates) -> tuple:
    """Return (a, a') of a motion known in any other way, on components."""
    legs = zip(rates.pose.legs, rates._q_dot, rates.phi_dot)
    (q1, phi1, *first), (q2, phi2, *second) = (
        (leg.q, atan2(leg.distal[1], leg.distal[0]), q_dot, turn) for leg, q_dot, turn in legs
    )
    return (q1, phi1, q2, phi2), (*first, *second)


def _columns(pose):
    """Return per leg the end-effector's velocity for q_i' = 1, P_i', and phi_i' = 1, l_i2 v_i2."""
    legs = zip(pose.robot.drives, pose.legs, pose.robot.distal)
    return tuple(
        (drive.tangent(leg.direction), (-bar * leg.distal[1], bar * leg.distal[0]))
        for drive, leg, bar in legs
    )


def rates_from_joint_state(robot: Robot, q: Any, xi: Any, q_dot: Any, xi_dot: Any) -> Rates:
    """Return a motion of which joints and end-effector are both known, on components: nothing is
    solved for, no mode asked.
    """
    legs = []
    for drive, own, bar in zip(robot.drives, q, robot.distal):
        direction = drive.direction(own)
        x, y = drive.pivot(direction)
        unit = (xi[0] - x) * (1 / bar), (xi[1] - y) * (1 / bar)
        legs.append(DrivenLeg(drive, own, direction, lambda unit=unit: unit))
    return Rates(Pose(robot, xi, lambda: (tuple(legs), ())), q_dot, xi_dot)


def loop_gap(pose: Pose) -> tuple:
    """From where the right leg ends to where the left one does, m, on components; 0 in a pose that
    closes.
    """
    drive = pose.robot.drives[1]
    leg = pose.legs[1]
    bar = pose.robot.distal[1]
    x, y = drive.pivot(leg.direction)
    return pose.point[0] - x - bar * leg.distal[0], pose.point[1] - y - bar * leg.distal[1]


def closed(robot: Robot, a: tuple, a_dot: tuple, free: tuple | None = None) -> tuple:
    """Return (a, a', their Rates) moved the least that closes the loop: a Newton step for
    positions, then rates tangent to it.

    On components. Quadratic: a gap of 1e-8 of the bars is rounding afterwards. free: per drive 1,
    or 0 where it is not to be moved.
    """
    pose = bars_pose(robot, a)
    a = _least(_movable(pose, free), a, loop_gap(pose))
    pose = bars_pose(robot, a)
    columns = _movable(pose, free)
    whole = columns if free is None else closure_columns(pose)
    a_dot = _least(columns, a_dot, gap_rate(whole, a_dot))
    return a, a_dot, _rates(pose, a_dot)


def closure_columns(pose: Pose) -> tuple:
    """Return columns of d(gap) / d(q1, phi1, q2, phi2)."""
    first, second = _columns(pose)
    return *first, *((-x, -y) for x, y in second)


def gap_rate(columns: tuple, a_dot: tuple) -> tuple:
    """Of `loop_gap`, m/s, on components, by its columns; 0 in a motion that keeps the loop
    closed.
    """
    x = sum(column[0] * rate for column, rate in zip(columns, a_dot))
    y = sum(column[1] * rate for column, rate in zip(columns, a_dot))
    return x, y


def _movable(pose, free):
    """Return the columns, those of drives that are not free 0."""
    first, *rest = closure_columns(pose)
    if free is None:
        return first, *rest
    (x1, y1), (x2, y2) = first, rest[1]
    return (free[0] * x1, free[0] * y1), rest[0], (free[1] * x2, free[1] * y2), rest[2]


def _least(columns, values, gap):
    """values less the vector of least norm that the columns take to the gap."""
    xx = sum(column[0] * column[0] for column in columns)
    xy = sum(column[0] * column[1] for column in columns)
    yy = sum(column[1] * column[1] for column in columns)
    inverse = 1.0 / (xx * yy - xy * xy)
    share = (yy * gap[0] - xy * gap[1]) * inverse, (xx * gap[1] - xy * gap[0]) * inverse
    return tuple(value - dot(column, share) for value, column in zip(values, columns))
