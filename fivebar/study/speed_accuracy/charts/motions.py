"""Motions of the AMORO robot, free and driven, their ends known to 20 digits."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ....base.backend import cos
from ....models.geometry import dgm
from ....models.kinematics import Rates, dkm
from ....models.robots import FiveBar, Robot
from ...pitfalls.joint_space import free_start

if TYPE_CHECKING:
    from collections.abc import Callable

ROBOT = FiveBar()
DURATION = 2.0  # s


@dataclass(frozen=True)
class _Motion:
    """Where a motion begins, a function of the robot to Rates, and where it is after DURATION.

    Ends are by extrapolation with 40 digits in redundant coordinates; tests compute them again.
    """

    words: str
    start: Callable[[Robot], Rates]
    end: tuple[float, float]

    def begin(self) -> Rates:
        return self.start(ROBOT)


class FreeMotion(_Motion):
    """A motion without torque; its end is that of the end-effector, m."""

    def torque(self, t: float) -> tuple[float, float]:
        return 0.0, 0.0


def from_home(*q_dot: float) -> Callable[[Robot], Rates]:
    return lambda robot: dkm(dgm(robot, (0.0, 0.0)), q_dot)


MOTIONS = {
    "regular": FreeMotion(
        "regular motion",
        from_home(-0.3, 1.1),
        (-0.07056483037979482713031, 0.0864695450628668164328),
    ),
    "grazing": FreeMotion(
        "motion that grazes Type 2",
        from_home(1.0, -1.728),
        (-0.06751875805022503989051, -0.03602829464741189173294),
    ),
    "through": FreeMotion(
        "motion through Type 2", free_start, (0.008761892391526353677414, 0.1480740333256244810279)
    ),
}


@dataclass(frozen=True)
class DrivenMotion(_Motion):
    """torque: t -> (2,) N m, of floats and of CasADi's symbols; the end is that of the active
    joints, rad.
    """

    torque: Callable[[float], tuple]


def swinging(t: float) -> tuple:
    wave = cos(2 * math.pi * t)
    return 0.02 * wave, -0.016 * wave


DRIVEN = {
    "forced": DrivenMotion(
        "driven by (0.02, −0.016) cos 2πt N m",
        from_home(0.0, 0.0),
        (-0.4412563579119373769925, 0.4231774641911981802441),
        swinging,
    ),
    "through": DrivenMotion(
        "free motion through Type 2",
        free_start,
        (0.7014519181150669347598, 2.416130451821391023409),
        MOTIONS["through"].torque,
    ),
}
