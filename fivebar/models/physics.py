"""What a robot may have beyond the lab's base parameters: gravity, heavy bars, friction; one form
for every kind.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from ..base.backend import is_symbolic

Pair = tuple[Any, Any]
NOTHING = 0.0, 0.0


def named(value: object) -> bool:
    """Return whether a parameter is asked for: a symbol, or a number that is not 0."""
    return is_symbolic(value) or value != 0


def any_named(*values: Pair) -> bool:
    return any(named(value) for pair in values for value in pair)


@dataclass(frozen=True)
class Physics:
    """Of both legs, left and right; 0 where nothing is named, and then nothing is computed.

    gravity: m/s^2. levers, sides: first moments of the driven bodies along and across their
    direction, kg m (of a foot its mass, kg). turning: inertias that turn with the distal bars, kg
    m^2; across: their first moments across, kg m.
    viscous, coulomb: of the drives, N m s/rad and N m; elbows: viscous, of the elbows, N m s/rad.
    smoothing: rate, rad/s, by which Coulomb friction is smoothed, inside an optimisation.
    """

    gravity: Pair = NOTHING
    levers: Pair = NOTHING
    sides: Pair = NOTHING
    turning: Pair = NOTHING
    across: Pair = NOTHING
    viscous: Pair = NOTHING
    coulomb: Pair = NOTHING
    elbows: Pair = NOTHING
    smoothing: float = 0.0

    @property
    def asked(self) -> bool:
        """Whether any of it changes a motion."""
        return self.has_gravity or self.heavy or self.has_friction

    @cached_property
    def has_gravity(self) -> bool:
        return any_named(self.gravity)

    @cached_property
    def heavy(self) -> bool:
        """Whether distal bars carry more than forces along them."""
        return any_named(self.turning, self.across)

    @cached_property
    def has_friction(self) -> bool:
        return any_named(self.viscous, self.coulomb, self.elbows)

    @cached_property
    def sticks(self) -> bool:
        """Whether friction holds a drive that stands, as smoothed friction does not."""
        return any_named(self.coulomb) and not named(self.smoothing)


@dataclass(frozen=True)
class Smoothed:
    """A robot whose Coulomb friction is fs q' / sqrt(q'^2 + rate^2): what an optimisation can
    differentiate.

    It is less than the friction itself by half of (rate / q')^2 of it, and nothing where the drive
    stands.
    """

    robot: Any
    rate: float

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self.robot, name)

    @property
    def physics(self) -> Physics:
        return replace(self.robot.physics, smoothing=self.rate)


def smoothed(robot: Any, rate: float) -> Any:
    """Return the robot itself where nothing in it needs smoothing."""
    return Smoothed(robot, rate) if loads_of(robot).sticks else robot


def physics_of(robot: Any) -> Physics | None:
    """Return what a robot has beyond the lab's parameters; None: nothing."""
    return getattr(robot, "physics", None)


NO_LOADS = Physics()


def loads_of(robot: Any) -> Physics:
    """Return what a robot has beyond the lab's parameters, all 0 where it has nothing."""
    return physics_of(robot) or NO_LOADS
