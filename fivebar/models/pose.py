"""A complete pose of a robot, its legs, and what follows from them when it is read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.backend import atan2, is_symbolic, pack, pack_matrix, sign
from ..base.representation import one_line, single, vector
from .dyads import SINGULAR, cross

if TYPE_CHECKING:
    from .robots import Drive, Robot


def _same(value):
    return value


@dataclass(frozen=True, eq=False)
class DrivenLeg:
    """A leg whose drive is known: coordinate, the drive's direction, and how to get the distal
    bar's.
    """

    drive: object
    q: object
    direction: object
    distal_of: object

    def __getstate__(self):
        return {**self.__dict__, "distal_of": partial(_same, self.distal)}

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
    """A leg closed on a known end-effector: everything, its sine to full relative accuracy, is in
    its dyad.
    """

    drive: Drive
    dyad: Any

    @cached_property
    def q(self) -> np.ndarray:
        return self.drive.coordinate(self.direction)

    @cached_property
    def direction(self):
        return self.drive.direction_in(self.dyad)

    @cached_property
    def distal(self):
        return self.drive.distal_in(self.dyad)

    @property
    def sine(self):
        return -self.dyad.sine

    @cached_property
    def cosine(self):
        return self.drive.cosine(self.direction, self.distal)


@dataclass(frozen=True, eq=False)
class Pose:
    """A complete pose of a robot, from `dgm` or `igm`. What is derived is computed when first read.

    Attributes
    ----------
    robot : FiveBar or Biglide
    q : (*batch, 2)
        Active joint coordinates, rad (biglide: m).
    xi : (*batch, 2)
        Position of the end-effector, m.
    elbows : (*batch, 2 legs, 2)
        m, of a biglide its feet.
    q_passive : (*batch, 2)
        Passive joint angles, rad in (-pi, pi]; of a biglide the bars' absolute angles.
    assembly : (*batch,)
    working : (*batch, 2)
        Modes, int8; 0 where singular or unreachable.
    A, B, J : (*batch, 2, 2)
        A xi' = B q', J = A^-1 B.
    reach_margin : (*batch,)
        How far the span of the bars is inside its limits, m; negative outside.

    Examples
    --------
    >>> import fivebar as fb
    >>> pose = fb.dgm(fb.FiveBar(), (0.0, 0.0))
    >>> pose.working.tolist(), int(pose.assembly)
    ([-1, -1], -1)
    """

    robot: Robot
    point: tuple
    # () -> (legs, dyads closed: the one on the elbows, or one in each leg); late for a large batch.
    _build: Callable
    _from_dgm: bool = False

    def __getstate__(self) -> dict:
        # A pose that is sent to another process is complete.
        return {**self.__dict__, "_build": partial(_same, self._build())}

    def __repr__(self) -> str:
        return one_line("Pose", *self._words())

    def _words(self):
        words = self.robot.words
        place = [vector("xi", self.point, "m")]
        if single(self.point):
            modes = "working ({:+d}, {:+d}), assembly {:+d}".format(
                *map(int, self.working), int(self.assembly)
            )
            place += [vector("q", tuple(leg.q for leg in self.legs), words.unit), modes]
        return (*place, words.title)

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
    def u2(self) -> tuple:
        """Per leg the unit vector u_i2 along the distal bar, from its elbow, on components."""
        return tuple(leg.distal for leg in self.legs)

    @property
    def sines(self) -> tuple:
        """Per leg u_i2 . P_i' / |P_i'|; for a crank sin q_i2, for a slider sin phi_i."""
        return tuple(leg.sine for leg in self.legs)

    @cached_property
    def det_A(self) -> Any:
        """det A = sin(phi_2 - phi_1); the dyad on the elbows knows it with full relative
        accuracy.
        """
        if self._from_dgm:
            return self._dyads[0].sine
        return cross(*self.u2)

    @cached_property
    def b(self) -> tuple:
        """Diagonal of B, per leg."""
        return tuple(along for along, _ in self._velocity_coefficients)

    @cached_property
    def _velocity_coefficients(self):
        """Per leg P_i' along and across the distal bar."""
        return tuple(
            drive.velocity_coefficients(leg.sine, leg.cosine)
            for drive, leg in zip(self.robot.drives, self.legs)
        )

    @property
    def tangents(self) -> tuple:
        """Per leg P_i'(q_i), on components."""
        return tuple(
            drive.tangent(leg.direction) for drive, leg in zip(self.robot.drives, self.legs)
        )

    @cached_property
    def q(self) -> np.ndarray:
        return pack(*(leg.q for leg in self.legs))

    @cached_property
    def xi(self) -> np.ndarray:
        return pack(*self.point)

    @cached_property
    def elbows(self) -> np.ndarray:
        (x1, y1), (x2, y2) = (
            drive.pivot(leg.direction) for drive, leg in zip(self.robot.drives, self.legs)
        )
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
        if is_symbolic(modes[0]):
            return pack(*modes)
        return np.stack(modes, axis=-1)

    @cached_property
    def A(self) -> np.ndarray:
        (x1, y1), (x2, y2) = self.u2
        return pack_matrix(x1, y1, x2, y2)  # AMORO eq. 13

    @cached_property
    def B(self) -> np.ndarray:
        zero = 0.0 * self.b[0]
        return pack_matrix(self.b[0], zero, zero, self.b[1])  # AMORO eq. 13

    @cached_property
    def J(self) -> np.ndarray:
        """Jacobian xi' = J q', J = A^-1 B (AMORO eq. 25), (*batch, 2, 2); nan at Type 2."""
        determinant = self.det_A
        if not is_symbolic(determinant):
            determinant = np.where(np.abs(determinant) <= SINGULAR, np.nan, determinant)
        (x1, y1), (x2, y2) = self.u2
        left, right = (b / determinant for b in self.b)
        return pack_matrix(y2 * left, -y1 * right, -x2 * left, x1 * right)

    @cached_property
    def reach_margin(self) -> np.ndarray:
        margins = [clearance for dyad in self._dyads for clearance in dyad.clearances]
        if is_symbolic(margins[0]):
            import casadi

            return casadi.mmin(casadi.vertcat(*margins))
        return np.minimum.reduce(np.broadcast_arrays(*margins))
