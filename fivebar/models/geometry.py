"""Positions: the direct and inverse geometric models, and the pose that both give."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from .._backend import atan2, check_modes, is_symbolic, pack, pack_matrix, sign, unpack
from ..checks import robot as must_be_robot
from ..described import one_line, single, table, vector
from .dyads import RRR, SINGULAR, cross
from .robots import KINDS
from .unreachable import refuse_open

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .robots import Drive, Robot

BLOCK = 8192  # poses


@dataclass(frozen=True, eq=False)
class DrivenLeg:
    """A leg whose drive is known: coordinate, the drive's direction, and how to get the distal bar's."""

    drive: object
    q: object
    direction: object
    distal_of: object

    @cached_property
    def distal(self):
        return self.distal_of()

    @cached_property
    def sine(self):
        return self.drive.sine(self.direction, self.distal)

    @cached_property
    def cosine(self):
        return self.drive.cosine(self.direction, self.distal)


@dataclass(frozen=True, eq=False)
class ReachedLeg:
    """A leg closed on a known end-effector: everything, its sine to full relative accuracy, is in its dyad."""

    drive: Drive
    dyad: Any

    @cached_property
    def q(self) -> np.ndarray:
        return self.drive.coordinate(self.direction)

    @cached_property
    def direction(self):
        return self.drive.held(self.dyad)

    @cached_property
    def distal(self):
        return self.drive.bar(self.dyad)

    @property
    def sine(self):
        return -self.dyad.sine

    @cached_property
    def cosine(self):
        return self.drive.cosine(self.direction, self.distal)


@dataclass(frozen=True, eq=False)
class Pose:
    """A complete pose of a robot, from `dgm` or `igm`; everything derived is computed when first read.

    robot; q (*batch, 2) rad (m for sliders); xi (*batch, 2) m; elbows (*batch, 2 legs, 2) m, of a biglide its feet;
    q_passive (*batch, 2) rad in (-pi, pi], of a biglide the bars' absolute angles;
    assembly (*batch,) and working (*batch, 2), int8, 0 where singular or unreachable; A, B (*batch, 2, 2);
    reach_margin (*batch,) m: how far the span of the bars is inside its limits, negative outside.
    """

    robot: Robot
    point: tuple
    _build: Callable  # () -> (legs, dyads closed: the one on the elbows, or one in each leg); late for a large batch
    _from_dgm: bool = False

    def __repr__(self) -> str:
        return one_line("Pose", *self._words())

    def _words(self):
        words, place = self.robot.words, [vector("xi", self.point, "m")]
        if single(self.point):
            modes = "working ({:+d}, {:+d}), assembly {:+d}".format(*map(int, self.working), int(self.assembly))
            place += [vector("q", tuple(leg.q for leg in self.legs), words.unit), modes]
        return (*place, words.title)

    def _repr_html_(self) -> str | None:
        if not single(self.point):
            return None
        words, passive = self.robot.words, zip(self.robot.words.passive, self.q_passive)
        angles = {name: f"{q:.6g} {words.unit}" for name, q in zip(words.joints, self.q)}
        angles |= {name: f"{angle:.6g} rad" for name, angle in passive}
        margins = {name: f"{value:.6g}" for name, value in zip(words.sines, (*self.sines, self.det_A))}
        return table(repr(self), angles | margins)

    @cached_property
    def _built(self):
        return self._build()

    @property
    def legs(self) -> tuple:
        return self._built[0]

    @property
    def _dyads(self):
        return self._built[1]

    @property
    def _proximal(self):
        return tuple(leg.direction for leg in self.legs)

    @property
    def u2(self) -> tuple:
        """Per leg the unit vector u_i2 along the distal bar, from its elbow, on components."""
        return tuple(leg.distal for leg in self.legs)

    @property
    def sines(self) -> tuple:
        """Per leg u_i2 . P_i' / |P_i'|; for a crank sin q_i2, for a slider sin phi_i."""
        return tuple(leg.sine for leg in self.legs)

    @cached_property
    def det_A(self) -> Any:
        """det A = sin(phi_2 - phi_1); the dyad on the elbows knows it with full relative accuracy."""
        return self._dyads[0].sine if self._from_dgm else cross(*self.u2)

    @cached_property
    def b(self) -> tuple:
        """Diagonal of B, per leg."""
        return tuple(along for along, _ in self._slopes)

    @cached_property
    def _slopes(self):
        """Per leg P_i' along and across the distal bar."""
        return tuple(drive.slopes(leg.sine, leg.cosine) for drive, leg in zip(self.robot.drives, self.legs))

    @cached_property
    def q(self) -> np.ndarray:
        return pack(*(leg.q for leg in self.legs))

    @cached_property
    def xi(self) -> np.ndarray:
        return pack(*self.point)

    @cached_property
    def elbows(self) -> np.ndarray:
        (x1, y1), (x2, y2) = (drive.pivot(u) for drive, u in zip(self.robot.drives, self._proximal))
        return pack_matrix(x1, y1, x2, y2)

    @cached_property
    def q_passive(self) -> np.ndarray:
        return pack(*(atan2(leg.sine, leg.cosine) for leg in self.legs))  # AMORO eq. 5, 6

    @cached_property
    def assembly(self) -> np.ndarray:
        return -sign(self.det_A, SINGULAR)

    @cached_property
    def working(self) -> np.ndarray:
        modes = tuple(-sign(s, SINGULAR) for s in self.sines)
        return pack(*modes) if is_symbolic(modes[0]) else np.stack(modes, axis=-1)

    @cached_property
    def A(self) -> np.ndarray:
        (x1, y1), (x2, y2) = self.u2
        return pack_matrix(x1, y1, x2, y2)  # AMORO eq. 13

    @cached_property
    def B(self) -> np.ndarray:
        zero = 0.0 * self.b[0]
        return pack_matrix(self.b[0], zero, zero, self.b[1])  # AMORO eq. 13

    @cached_property
    def reach_margin(self) -> np.ndarray:
        margins = [clearance for dyad in self._dyads for clearance in dyad.clearances]
        if is_symbolic(margins[0]):
            import casadi

            return casadi.mmin(casadi.vertcat(*margins))
        return np.minimum.reduce(np.broadcast_arrays(*margins))


def dgm(robot: Robot, q: ArrayLike, assembly: ArrayLike = -1, unreachable: str = "raise") -> Pose:
    """Direct geometric model: the pose in which the active joints are at q (AMORO eq. 1-3, general lengths).

    q: (*batch, 2) rad (m for sliders), or a CasADi 2 x 1 vector. assembly: +1 or -1, an int or an array of the batch's
    shape.
    unreachable: "raise" an UnreachableError, or give "nan" there. Coincident elbows (feet) of equal distal bars leave
    these free to turn: SingularityError, or nan.
    """
    if type(robot) not in KINDS:
        must_be_robot(robot, "robot")
    q = unpack(q, "q")
    q, (branch,) = _with_modes(q, assembly, "assembly", count=1)
    pose = joint_pose(robot, q, branch)
    _refuse_open(unreachable, pose.point[0], pose)
    return pose


def joint_pose(robot: Robot, q: tuple, assembly) -> Pose:
    """`dgm` on components, unchecked: nan where it does not close."""
    if isinstance(q[0], np.ndarray) and q[0].size > BLOCK:
        xi = _joint_xi_in_blocks(robot, q, assembly)
        return Pose(robot, xi, lambda: _close_on_elbows(robot, q, assembly)[1:], True)
    xi, *parts = _close_on_elbows(robot, q, assembly)
    return Pose(robot, xi, lambda: parts, True)


def _close_on_elbows(robot, q, assembly):
    """End-effector, legs and the dyad on the two elbows."""
    left, right = robot.drives
    directions = left.direction(q[0]), right.direction(q[1])
    p1, p2 = left.pivot(directions[0]), right.pivot(directions[1])
    l12, l22 = robot.distal
    extent = left.extent(directions[0]) + right.extent(directions[1])
    dyad = RRR((p2[0] - p1[0], p2[1] - p1[1]), l12, l22, -assembly, extent)
    xi = p1[0] + l12 * dyad.first[0], p1[1] + l12 * dyad.first[1]
    first = DrivenLeg(left, q[0], directions[0], lambda: dyad.first)
    legs = first, DrivenLeg(right, q[1], directions[1], lambda: dyad.second)
    return xi, legs, (dyad,)


def _joint_xi_in_blocks(robot, q, assembly):
    """The end-effector alone, a stretch of the batch at a time that stays in the processor's cache."""
    flat, modes = [np.ravel(component) for component in q], np.asarray(assembly)
    if modes.ndim:
        modes = np.broadcast_to(modes, q[0].shape).ravel()
    xi = np.empty((2, flat[0].size))
    for start in range(0, flat[0].size, BLOCK):
        part = slice(start, start + BLOCK)
        xi[:, part] = _close_on_elbows(
            robot, [component[part] for component in flat], modes[part] if modes.ndim else assembly
        )[0]
    return xi[0].reshape(q[0].shape), xi[1].reshape(q[0].shape)


def igm(robot: Robot, xi: ArrayLike, working: ArrayLike = (-1, -1), unreachable: str = "raise") -> Pose:
    """Inverse geometric model: the pose in which the end-effector is at xi (AMORO eq. 7-9, general lengths).

    xi: (*batch, 2) m, or a CasADi 2 x 1 vector. working: (2,) or (*batch, 2), +1 or -1 for the left and right leg.
    unreachable: "raise" an UnreachableError, or give "nan" there. A leg of equal bars folded on its base joint is free
    to turn: SingularityError, or nan. Active angles lie in (-pi, pi].
    """
    if type(robot) not in KINDS:
        must_be_robot(robot, "robot")
    xi = unpack(xi, "xi")
    xi, branches = _with_modes(xi, working, "working", count=2)
    pose = task_pose(robot, xi, branches)
    _refuse_open(unreachable, pose._dyads[0].first[0] + pose._dyads[1].first[0], pose)
    return pose


def task_pose(robot: Robot, xi: tuple, working: tuple) -> Pose:
    """`igm` on components, unchecked: nan where it does not close."""
    legs = tuple(reach(drive, xi, bar, mode) for drive, bar, mode in zip(robot.drives, robot.distal, working))
    return Pose(robot, xi, lambda: (legs, tuple(leg.dyad for leg in legs)))


def reach(drive, xi: tuple, bar: float, working) -> ReachedLeg:
    """The leg of this drive and distal bar that ends in xi."""
    return ReachedLeg(drive, drive.close(xi, bar, working))


def _with_modes(v, modes, name, count):
    """Components of v and `count` components of its modes; floats become arrays where the modes are a batch."""
    plain = (modes,) if count == 1 else modes
    if (
        isinstance(plain, tuple)
        and len(plain) == count
        and all(type(mode) is int and mode * mode == 1 for mode in plain)
    ):
        return v, plain  # the usual call, without the cost of arrays
    modes = check_modes(modes, name)
    if count == 2 and (modes.ndim == 0 or modes.shape[-1] != 2):
        raise ValueError(f"{name} must have shape (2,) or (*batch, 2), not {modes.shape}")
    if modes.ndim == count - 1:
        return v, tuple(int(m) for m in np.atleast_1d(modes))
    if is_symbolic(v[0]):
        raise ValueError(f"{name} must be plain ints for CasADi symbols, not a batch")
    split = (modes,) if count == 1 else (np.ascontiguousarray(modes[..., 0]), np.ascontiguousarray(modes[..., 1]))
    try:
        *v, _ = np.broadcast_arrays(*v, split[0])
    except ValueError:
        raise ValueError(f"{name} of shape {modes.shape} does not fit a batch of shape {np.shape(v[0])}") from None
    return tuple(v), split


def _refuse_open(unreachable, found, pose):
    """Raise for the first pose in which a dyad does not close (`found` is nan there)."""
    if not isinstance(unreachable, str) or unreachable not in ("raise", "nan"):
        raise ValueError(f'unreachable must be "raise" or "nan", not {unreachable!r}')
    if unreachable == "nan" or is_symbolic(found) or not np.any(found != found):
        return
    refuse_open(np.isnan(found), pose)
