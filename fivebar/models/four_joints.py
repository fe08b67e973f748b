"""Motions of which all four joints are given: nothing is solved for, so no mode is asked and nothing is singular."""

from dataclasses import dataclass, field

from .._backend import cos, sin
from .geometry import DrivenLeg, Pose
from .kinematics import Rates


def four_joint_pose(robot, q, q_passive):
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


def four_joint_rates(pose, q_dot, q_passive_dot):
    """Rates of which the four joints' are known, on components; the end-effector's velocity is not to be read."""
    return FourJointRates(pose, q_dot, (0.0, 0.0), _passive_dot=q_passive_dot)
