"""Motors with their gears: the torque that is left at a speed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ..base.backend import is_symbolic
from ..base.checks import not_negative, optional, positive, share, shown
from ..base.representation import one_line
from ..base.tables import named

RPM = 2 * math.pi / 60  # rad/s


@dataclass(frozen=True)
class Motor:
    """A motor and its gear, by the line of its data sheet.

        |tau| <= torque        |tau / stall + q' / speed| <= 1

    The back EMF takes as much torque from a motor that drives as it turns fast. One that brakes is
    limited by its current alone, so by `torque`. These three are at the joint.

    Parameters
    ----------
    stall_torque : float
        Of the motor at rest, N m.
    no_load_speed : float
        At which no torque is left, rad/s.
    largest_torque : float, optional
        That its drive allows, N m; the stall torque by default.
    rotor_inertia : float
        kg m^2, of the rotor about its axis.
    gear : float
        Turns of the motor for one of the joint. Data sheets of servos are of the joint: 1.
    efficiency : float
        Of the gear, up to 1: the share of the torque that reaches the joint. Braking is counted
        with the same share, which is on the safe side up to the speed without load.
    source : str
        Of the numbers.

    Raises
    ------
    ValueError, TypeError
        A value is no such number; the message names it.

    References
    ----------
    Spong, Hutchinson, Vidyasagar: Robot Modeling and Control, 2nd ed., section 8.3.

    Examples
    --------
    >>> import fivebar as fb
    >>> motor = fb.Motor(stall_torque=0.1, no_load_speed=300.0, gear=20.0, efficiency=0.8)
    >>> round(motor.torque, 9), motor.speed
    (1.6, 15.0)
    >>> [round(float(bound), 3) for bound in motor.bounds(7.5)]
    [-1.6, 0.8]
    """

    stall_torque: float
    no_load_speed: float
    largest_torque: float | None = None
    rotor_inertia: float = 0.0
    gear: float = 1.0
    efficiency: float = 1.0
    source: str = ""

    def __post_init__(self) -> None:
        for name, check in CHECKS.items():
            object.__setattr__(self, name, check(getattr(self, name), f"Motor: {name}"))
        if not self.efficiency:
            raise ValueError("Motor: efficiency must be above 0: no torque would reach the joint")

    def __repr__(self) -> str:
        return one_line(
            "Motor",
            f"at the joint {self.stall:.6g} N m at rest, {self.speed:.6g} rad/s without load",
            f"at most {self.torque:.6g} N m" if self.torque < self.stall else "",
        )

    @property
    def stall(self) -> float:
        """Torque at rest at the joint, N m, if the drive allowed it."""
        return self.stall_torque * self.gear * self.efficiency

    @property
    def torque(self) -> float:
        """Largest torque at the joint, N m."""
        largest = self.stall_torque if self.largest_torque is None else self.largest_torque
        return min(largest, self.stall_torque) * self.gear * self.efficiency

    @property
    def speed(self) -> float:
        """Speed without load at the joint, rad/s."""
        return self.no_load_speed / self.gear

    @property
    def inertia(self) -> float:
        """Rotor inertia at the joint, kg m^2: what zz1 or zz2 of a robot has more with it."""
        return self.rotor_inertia * self.gear**2

    def bounds(self, q_dot: Any) -> tuple[Any, Any]:
        """Return the least and the largest torque, N m, at joint speeds (*batch,) rad/s.

        CasADi expressions are taken, too.
        """
        if is_symbolic(q_dot):
            import casadi

            least: Callable = casadi.fmin
            largest: Callable = casadi.fmax
        else:
            q_dot, least, largest = np.asarray(q_dot, float), np.minimum, np.maximum
        high = self.stall * (1 - q_dot / self.speed)
        low = self.stall * (-1 - q_dot / self.speed)
        torque = self.torque
        return (least(largest(low, -torque), torque), least(largest(high, -torque), torque))


def motor_of(value: object, name: str) -> Motor:
    """Return a Motor, one of MOTORS by its name, or one by a table of its parameters."""
    if isinstance(value, Motor):
        return value
    if isinstance(value, str):
        if value not in MOTORS:
            raise ValueError(f"{name}: no motor {value!r}; the known ones are {', '.join(MOTORS)}")
        return MOTORS[value]
    if not isinstance(value, Mapping):
        raise TypeError(
            f"{name} must be a Motor, a motor's name or a table of its parameters, not"
            f" {shown(value)}"
        )
    known = [field.name for field in fields(Motor)]
    if unknown := sorted(set(value) - set(known)):
        raise ValueError(f"{name}: no {', '.join(unknown)} of a motor; it has {', '.join(known)}")
    if missing := [each for each in known[:2] if each not in value]:
        raise ValueError(f"{name} needs {' and '.join(missing)} too")
    with named(name):
        return Motor(**value)


def both_motors(value: object, name: str) -> tuple[Motor, Motor]:
    """Return both motors, from one for both or from two, each as `motor_of` takes it."""
    motors = value if isinstance(value, tuple | list) else (value, value)
    if len(motors) != 2:
        raise ValueError(f"{name} must be a Motor or two of them, not {shown(value)}")
    return motor_of(motors[0], name), motor_of(motors[1], name)


def torque_bounds(limit: float | tuple[Motor, Motor], q_dot: np.ndarray) -> tuple:
    """Return the least and the largest torques (*batch, 2) at joint speeds (*batch, 2)."""
    if not isinstance(limit, tuple):
        return -limit, limit
    bounds = [motor.bounds(q_dot[..., k]) for k, motor in enumerate(limit)]
    low, high = (np.stack(each, axis=-1) for each in zip(*bounds))
    return low, high


CHECKS: dict[str, Callable] = {
    "stall_torque": positive,
    "no_load_speed": positive,
    "largest_torque": optional(positive),
    "rotor_inertia": not_negative,
    "gear": positive,
    "efficiency": share,
}
# Stall torque and no-load speed at 12 V as printed, both at the horn, behind the gear. The makers
# print no rotor inertia and no efficiency; they advise a load of a fifth of the stall torque.
MANUAL = "ROBOTIS e-Manual, emanual.robotis.com/docs/en/dxl/"
MOTORS = {
    "ax-12a": Motor(1.5, 59 * RPM, source=MANUAL + "ax/ax-12a, at 12 V and 1.5 A, gear 254 : 1"),
    "xh430-w350": Motor(
        3.4, 30 * RPM, source=MANUAL + "x/xh430-w350, at 12 V and 1.3 A, gear 353.5 : 1"
    ),
    "xl430-w250": Motor(
        1.5, 61 * RPM, source=MANUAL + "x/xl430-w250, at 12 V and 1.4 A, gear 258.5 : 1"
    ),
    "xm540-w270": Motor(
        10.6, 30 * RPM, source=MANUAL + "x/xm540-w270, at 12 V and 4.4 A, gear 272.5 : 1"
    ),
}
