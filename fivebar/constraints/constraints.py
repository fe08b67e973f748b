"""Constraints on a motion: limits on torques and rates, ranges, regions, margins, collisions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.backend import finite_numbers, wrap
from ..base.checks import instance, named_functions, not_negative, number, share, shown
from ..base.errors import warn
from ..base.representation import one_line
from ..base.robot_uses import freed, left_out, uses
from ..models.geometry import Pose
from ..models.motors import Motor, both_motors
from .link_collisions import LinkCollisions, point_segment_distance, segment_distance

PER_JOINT = "motors", "torque", "joint_speed", "joint_acceleration"
OF_END_EFFECTOR = "speed", "acceleration", "jerk"
MARGINS = "det_A", "sin"
ON_POSES = "joints", "half_planes", "region", *MARGINS, "collisions"


@dataclass(frozen=True, kw_only=True)
class Constraints:
    """All that a motion must keep. What is not named is free.

    `plan`, `time_path`, `place`, `check_path`, `largest_disc`, `largest_rectangle`, `certify` and
    `Tracker` take it. Each of them says which constraints it keeps. Others that are named for the
    call are refused; those of a `Machine` are left out with a warning.

    Parameters
    ----------
    motors : Motor, name in MOTORS, or (2,) of these, optional
        Both motors, or each: the torque that is left at a speed. `torque` is then at most theirs.
    torque, joint_speed, joint_acceleration : float or (2,), optional
        Largest torque, N m, speed, rad/s, and acceleration, rad/s^2, of both joints or of each. Of
        a biglide N, m/s and m/s^2.
    speed, acceleration, jerk : float, optional
        Largest values of the end-effector, m/s, m/s^2 and m/s^3.
    joints : ((low, high) or None, (low, high) or None), optional
        Ranges of q11 and q21, rad (of a biglide m). An angle and its full turns are the same, so a
        range is at most a full turn.
    half_planes : sequence of (a, b, c)
        The end-effector stays where a x + b y >= c, m. y > 0 is (0, 1, 0).
    region : (n, 2), optional
        Corners, m, of a polygon whose sides do not cross. The end-effector stays inside.
    det_A, sin : float
        Least |det A| and least |sin q_i2| (of a biglide |sin phi_i|), from 0 to 1.
    clearance : float
        Least distance, m, from singularities and from the borders of the other constraints.
    collisions : LinkCollisions, optional
        Links that must not meet.
    functions : dict, optional
        {name: function} of your own for `plan`, each of which must be >= 0. It gets a motion's
        quantities, as the functions of `plan`'s objective, and returns one number near 1 where
        there is much room: 1 - tau[0] / 0.1 for a torque of at most 0.1 N m.

    Raises
    ------
    ValueError, TypeError
        A value is no such limit; the message names it.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.Constraints(torque=0.05, det_A=0.2, half_planes=[(0, 1, 0.01)])
    <Constraints: torque (0.05, 0.05), half_planes ((0.0, 1.0, 0.01),), det_A 0.2>
    """

    motors: Any = None  # a tuple of two Motors once checked
    torque: ArrayLike | None = None
    joint_speed: ArrayLike | None = None
    joint_acceleration: ArrayLike | None = None
    speed: float | None = None
    acceleration: float | None = None
    jerk: float | None = None
    joints: Sequence[Sequence[float] | None] | None = None
    half_planes: Sequence[Sequence[float]] = ()
    region: Sequence[Sequence[float]] | None = None
    det_A: float = 0.0
    sin: float = 0.0
    clearance: float = 0.0
    collisions: LinkCollisions | None = None
    functions: Any = ()  # pairs of name and function once checked
    _of_robot: Any = field(default=None, compare=False, repr=False)  # by name; None: of a call

    def __post_init__(self) -> None:
        for name, check in CHECKS.items():
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, check(value, f"Constraints: {name}"))
        if self.motors is not None:
            given: Any = (math.inf, math.inf) if self.torque is None else self.torque
            least = tuple(min(limit, m.torque) for limit, m in zip(given, self.motors))
            object.__setattr__(self, "torque", least)

    def __repr__(self) -> str:
        return one_line("Constraints", *(f"{name} {self._shown(name)}" for name in self.named))

    def _shown(self, name):
        value = getattr(self, name)
        return ", ".join(dict(value)) if name == "functions" else value

    @property
    def named(self) -> tuple[str, ...]:
        """Names of the constraints that are not free."""
        return tuple(f.name for f in fields(self) if f.compare and self._is_named(f))

    def _is_named(self, field):
        return getattr(self, field.name) != field.default

    @property
    def of_robot(self) -> Constraints:
        """The same constraints, as those of a robot's file: see `used_by`."""
        return replace(self, _of_robot={name: getattr(self, name) for name in self.named})

    def under(self, others: Constraints | None) -> Constraints:
        """Return these constraints with those over them that others name."""
        others = Constraints() if others is None else instance(Constraints)(others, "constraints")
        return replace(self, **{name: getattr(others, name) for name in others.named})

    def used_by(self, user: str) -> tuple[Constraints, str]:
        """Return the constraints that a command or function keeps, and in words which of the
        robot's own it leaves out.

        Raises
        ------
        ValueError
            It does not keep one that was named for this call, not in the robot's file.
        """
        use = uses()[1][user]
        others = [name for name in self.named if name not in use.used]
        own = self._of_robot or {}
        for name in others:
            if getattr(self, name) != own.get(name):
                kept = ", ".join(name for name in use.used if name in CHECKS)
                raise ValueError(
                    f"{user.removeprefix('fb.')}: the constraint {name} is not kept here, leave it"
                    f" out; kept are {kept}"
                )
        return freed(self, others), left_out(user, others)[1]

    def torque_share(self, tau: ArrayLike, q_dot: Any) -> np.ndarray:
        """Return the largest share (*batch,) of the allowed torque that is used, 0 if it is free.

        It is the larger one of both joints' |tau| / torque and, of motors, |tau / stall + q' /
        speed|, at torques tau, N m, and joint speeds q_dot, rad/s, (*batch, 2).
        """
        tau = np.asarray(tau, float)
        if self.torque is None:
            return np.zeros(tau.shape[:-1])
        shares = np.abs(tau) / self.torque
        if self.motors is not None:
            stall, speed = at_joints(self.motors)
            shares = np.maximum(shares, np.abs(tau / stall + np.asarray(q_dot) / speed))
        return shares.max(axis=-1)

    def clearances(self, pose: Pose) -> dict[str, np.ndarray]:
        """Return how far each constraint on poses is from being violated.

        Parameters
        ----------
        pose : Pose
            One pose or a batch.

        Returns
        -------
        dict
            (*batch,) arrays by constraint, in m, in rad, or a difference of sines: negative where
            the constraint is violated, nan where the pose is.
        """
        x = np.asarray(pose.point[0])
        y = np.asarray(pose.point[1])
        result = {}
        for leg, limits in enumerate(self.joints or ()):
            if limits:
                clearance = _range_clearance(limits, pose.legs[leg].q, pose.robot.turns)
                result[f"joint limits of q{leg + 1}1"] = clearance
        for a, b, c in self.half_planes:
            result[plane_words(a, b, c)] = a * x + b * y - c
        if self.region:
            corners = np.array(self.region) @ (1, 1j)
            result["region"] = distance_inside(corners, x + 1j * y)
        if self.det_A:
            name = f"|det A| >= {self.det_A:g}"
            result[name] = np.abs(pose.det_A) - self.det_A
        if self.sin:
            smallest = np.abs(pose.sines).min(axis=0)
            name = f"|sin q_i2| >= {self.sin:g}"
            result[name] = smallest - self.sin
        if self.collisions:
            result |= self.collisions.clearances(pose)
        return result

    def smooth(self, pose: Pose, length: float) -> list:
        """Return differentiable clearances of CasADi symbols, >= 0 where the constraint holds.

        They are those of joints, half-planes, a convex region and collisions. Distances are divided
        by `length`, m.
        """
        x, y = pose.point
        result = []
        for leg, limits in enumerate(self.joints or ()):
            if not limits:
                continue
            low, high = limits
            if pose.robot.turns:
                middle = (low + high) / 2
                half = (high - low) / 2
                ux, uy = pose.legs[leg].direction
                cosine = ux * math.cos(middle) + uy * math.sin(middle)
                result.append(cosine - math.cos(half))
            else:
                q = pose.legs[leg].q
                result += [(q - low) / length, (high - q) / length]
        planes = [*self.half_planes, *self._sides_of_convex_region()]
        for a, b, c in planes:
            distance = a * x + b * y - c
            result.append(distance / length)
        if self.collisions:
            result += [clearance / length for clearance in self.collisions.smooth(pose)]
        return result

    def _sides_of_convex_region(self) -> list[list[float]]:
        """Return the half-planes (a, b, c) of a convex region's sides; [] if it is not convex."""
        if not self.region:
            return []
        corners = np.array(self.region) @ (1, 1j)
        sides = np.roll(corners, -1) - corners
        turns = (sides.conj() * np.roll(sides, -1)).imag
        if (turns < 0).any() and (turns > 0).any():
            return []
        inwards = 1j * np.sign(turns.sum())
        normals = inwards * sides / np.abs(sides)
        offsets = (normals.conj() * corners).real
        planes = np.stack([normals.real, normals.imag, offsets], axis=1)
        return planes.tolist()

    def satisfied(self, pose: Pose) -> np.ndarray:
        """Return whether all constraints on poses hold, bool (*batch,), False for poses of nan."""
        closes = np.isfinite(pose.det_A)
        clearances = list(self.clearances(pose).values())
        if clearances:
            least = np.min(clearances, axis=0)
            return closes & (least >= 0)
        return closes


def plane_words(a: float, b: float, c: float) -> str:
    """Return the name of a half plane."""
    a, b, c = (round(value, 12) + 0.0 for value in (a, b, c))
    return f"{a:.6g} x + {b:.6g} y >= {c:.6g} m"


def at_joints(motors: tuple[Motor, Motor]) -> tuple[tuple, tuple]:
    """Return both motors' torques at rest and speeds without load, at the joints."""
    return (tuple(motor.stall for motor in motors), tuple(motor.speed for motor in motors))


def kept_by(user: str) -> Callable:
    """Rule: Constraints, or None; those of a robot's file that a function does not keep are left
    out with a warning, others are refused.
    """

    def rule(value, name):
        if value is not None:
            value, note = instance(Constraints)(value, name).used_by(user)
            if note:
                warn(note)
        return value

    return rule


def distance_inside(corners: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return the distance of points (*batch,) from the sides of a polygon, corners (n,) complex.

    It is negative outside.
    """
    start = corners
    end = np.roll(corners, -1)
    point = np.asarray(z)[..., None]
    distances = point_segment_distance(point, start, end)
    distance = distances.min(axis=-1)
    # A point is inside if a ray along x meets an odd number of sides.
    side = end - start
    starts_above = start.imag > point.imag
    ends_above = end.imag > point.imag
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (point.imag - start.imag) / side.imag
        x = start.real + share * side.real
    meets = (starts_above != ends_above) & (x > point.real)
    inside = meets.sum(axis=-1) % 2 == 1
    return np.where(inside, distance, -distance)


def _range_clearance(limits, q, turns):
    low, high = limits
    if not turns:
        return np.minimum(q - low, high - q)
    middle = (low + high) / 2
    half = (high - low) / 2
    turned = wrap(q - middle)
    return half - np.abs(turned)


def _limit(value, name):
    # SI; a robot of micrometres has torques of 1e-18 N m.
    return number(value, name, 1e-24, 1e24)


def _per_joint(value, name):
    try:
        numbers = finite_numbers(value, name)
    except TypeError:
        numbers = np.empty(0)
    if numbers.shape not in ((), (1,), (2,)):
        raise ValueError(f"{name} must be one number or one per joint, not {shown(value)}")
    limits = tuple(_limit(each, name) for each in numbers.ravel().tolist())
    if len(limits) == 1:
        return limits * 2
    return limits


def _joints(joints, name):
    if not isinstance(joints, tuple | list) or len(joints) != 2:
        raise ValueError(f"{name} must be two ranges (low, high) or None, not {shown(joints)}")
    left, right = joints
    return (_range(left, f"{name} of q11"), _range(right, f"{name} of q21"))


def _range(limits, name):
    if limits is None:
        return None
    values = finite_numbers(limits, name)
    is_range = False
    if values.shape == (2,):
        low, high = values
        is_range = 0 < high - low <= 2 * math.pi
    if not is_range:
        raise ValueError(
            f"{name} must be (low, high), low < high and at most a full turn apart, not"
            f" {shown(limits)}"
        )
    return tuple(values.tolist())


def _half_planes(planes, name):
    if not isinstance(planes, tuple | list | np.ndarray):
        raise ValueError(f"{name} must be a list of (a, b, c), not {shown(planes)}")
    values = finite_numbers(planes, name)
    if not values.size:
        values = np.empty((0, 3))
    are_triples = values.ndim == 2 and values.shape[1] == 3
    if are_triples:
        lengths = np.hypot(values[:, 0], values[:, 1])
    if not are_triples or not lengths.all():
        raise ValueError(
            f"{name} must be (a, b, c) each, a x + b y >= c, a or b not 0, not {shown(planes)}"
        )
    # Of unit normals a x + b y - c is a distance.
    values = values / lengths[:, None]
    return tuple(map(tuple, values.tolist()))


def _polygon(region, name):
    corners = finite_numbers(region, name)
    are_pairs = corners.ndim == 2 and corners.shape[1] == 2
    if not are_pairs or len(corners) < 3:
        raise ValueError(
            f"{name} must be the corners (n, 2) of a polygon, n >= 3, not {shown(region)}"
        )
    z = corners @ (1, 1j)
    ends = np.roll(z, -1)
    if (ends == z).any():
        raise ValueError(f"{name} has the same corner twice in a row")
    for k in range(len(z)):
        for m in range(k + 2, len(z) - (k == 0)):
            distance = segment_distance(z[k], ends[k], z[m], ends[m])
            if distance <= 0:
                raise ValueError(f"Constraints: sides {k + 1} and {m + 1} of the region meet")
    return tuple(map(tuple, corners.tolist()))


CHECKS: dict[str, Callable] = {
    "motors": both_motors,
    **dict.fromkeys(PER_JOINT[1:], _per_joint),
    **dict.fromkeys(OF_END_EFFECTOR, _limit),
    **dict.fromkeys(MARGINS, share),
    "joints": _joints,
    "half_planes": _half_planes,
    "region": _polygon,
    "clearance": not_negative,
    "collisions": instance(LinkCollisions),
    "functions": named_functions,
}
