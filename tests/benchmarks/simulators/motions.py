"""Driven motions of the AMORO robot, their ends known to 20 digits."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from fivebar.base.backend import cos
from fivebar.study.pitfalls.joint_space import free_start
from fivebar.study.speed_accuracy.charts.motions import (
    DURATION,
    MOTIONS,
    ROBOT,
    FreeMotion,
    from_home,
)

__all__ = ["DRIVEN", "DURATION", "ROBOT", "DrivenMotion"]


@dataclass(frozen=True)
class DrivenMotion(FreeMotion):
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
