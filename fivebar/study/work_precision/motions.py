"""Motions of the AMORO robot without torque, their ends known to 20 digits."""

from dataclasses import dataclass

from ...geometry import dgm
from ...kinematics import Rates, dkm
from ...robots import FiveBar
from ..joint_space import free_start

ROBOT = FiveBar()
DURATION = 2.0  # s


@dataclass(frozen=True)
class FreeMotion:
    """Where a motion begins, a function of the robot to Rates, and the end-effector (2,) m after DURATION.

    The end is by extrapolation with 40 digits in redundant coordinates; tests compute it again.
    """

    words: str
    start: object
    end: tuple

    def begin(self) -> Rates:
        return self.start(ROBOT)


def from_home(*q_dot):
    return lambda robot: dkm(dgm(robot, (0.0, 0.0)), q_dot)


MOTIONS = {
    "regular": FreeMotion(
        "regular motion", from_home(-0.3, 1.1), (-0.07056483037979482713031, 0.0864695450628668164328)
    ),
    "grazing": FreeMotion(
        "motion that grazes Type 2", from_home(1.0, -1.728), (-0.06751875805022503989051, -0.03602829464741189173294)
    ),
    "through": FreeMotion("motion through Type 2", free_start, (0.008761892391526353677414, 0.1480740333256244810279)),
}
