"""Motions of which all four joints are given: nothing is solved for, so no mode is asked and nothing is singular."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from .._backend import cos, sin
from .geometry import DrivenLeg, Pose
from .kinematics import Rates

if TYPE_CHECKING:
    from .robots import Robot


def four_joint_pose(robot: Robot, q: tuple, q_passive: tuple) -> Pose:
    """The pose with all four joint angles given, on components; the end-effector is the left leg's (AMORO eq. 4)."""
    legs = []
    for drive, own, passive in zip(robot.drives, q, q_passive):
        phi = drive.absolute(passive, own)
        legs.append(DrivenLeg(drive, own, drive.direction(own), lambda phi=phi: (cos(phi), sin(phi))))
    x, y = robot.drives[0].pivot(legs[0].direction)
    ux, uy = legs[0].distal
    return Pose(robot, (x + robot.distal[0] * ux, y + robot.distal[0] * uy), lambda: (tuple(legs), ()))


@dataclass(frozen=True, eq=False)
class FourJointRates(Rates):
    """Rates with the passive joints' given; nothing is asked of the end-effector's velocity."""

    _passive_dot: tuple = field(kw_only=True)

    @property
    def _swing(self):
        robot = self.pose.robot
        legs = zip(robot.drives, robot.distal, self._passive_dot, self._q_dot)
        return tuple(bar * drive.absolute(passive, q_dot) for drive, bar, passive, q_dot in legs)


def four_joint_rates(pose: Pose, q_dot: tuple, q_passive_dot: tuple) -> FourJointRates:
    """Rates of which the four joints' are known, on components; the end-effector's velocity is not to be read."""
    return FourJointRates(pose, q_dot, (0.0, 0.0), _passive_dot=q_passive_dot)
