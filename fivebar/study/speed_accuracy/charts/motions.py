"""Free motions of the AMORO robot, their ends known to 20 digits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ....models.geometry import dgm
from ....models.kinematics import Rates, dkm
from ....models.robots import FiveBar, Robot
from ...pitfalls.joint_space import free_start

ROBOT = FiveBar()
DURATION = 2.0  # s


@dataclass(frozen=True)
class FreeMotion:
    """A motion without torque: in words, where it begins, and the end-effector after DURATION, m.

    Ends are by extrapolation with 40 digits in redundant coordinates; tests compute them again.
    """

    words: str
    start: Callable[[Robot], Rates]
    end: tuple[float, float]

    def begin(self) -> Rates:
        """Return the state at the start."""
        return self.start(ROBOT)

    def torque(self, t: float) -> tuple[float, float]:
        """Return the torques at t, N m."""
        return 0.0, 0.0


def from_home(*q_dot: float) -> Callable[[Robot], Rates]:
    """Return the start at q = (0, 0) with these rates, rad/s."""
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
