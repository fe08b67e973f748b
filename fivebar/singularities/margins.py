"""Singularities of a pose: their types and their signed margins."""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base.backend import atan2, hypot, is_symbolic, maximum, minimum, pack, sqrt
from ..base.checks import not_negative, takes
from ..base.representation import one_line, vector
from ..models.dyads import dot
from ..models.geometry import Pose
from ..models.kinematics import a_pose


class Singularity(enum.IntFlag):
    """What is singular in a pose: NONE, SERIAL, PARALLEL, or both.

    ===== ======================= ==== ======== ================================= ==================
    value name                    type singular what is in line                   what is lost
    ===== ======================= ==== ======== ================================= ==================
    0     NONE                    -    -        -                                 -
    1     SERIAL                  1    B        a leg's proximal and distal bar   a motion of xi
    2     PARALLEL                2    A        the two distal bars               a force at xi
    3     SERIAL | PARALLEL       3    A and B  the distal bars, and a leg's      both
    ===== ======================= ==== ======== ================================= ==================

    A biglide is of Type 1 where a bar is across its guide.

    References
    ----------
    Gosselin and Angeles, Singularity analysis of closed-loop kinematic chains, 1990.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.singularity(fb.dgm(fb.FiveBar(), (0.0, 0.0))) == fb.Singularity.NONE
    True
    """

    NONE = 0
    SERIAL = 1
    PARALLEL = 2


@dataclass(frozen=True, eq=False)
class Margins:
    """How far a pose is from being singular, from `singularity_margins`; nan where the pose is.

    Of a pose of CasADi symbols each of them is an expression; at Type 2 some of these are nan.

    Attributes
    ----------
    serial : (*batch, 2)
        sin q_i2 of each leg, of a biglide sin phi_i (u_i2 . P_i' / |P_i'|): minus the working mode
        in sign, 0 at Type 1.
    parallel : (*batch,)
        sin(phi2 - phi1): minus the assembly mode in sign, 0 at Type 2.
    transmission_angle : (*batch,)
        The acute angle between the distal bars, rad.
    length : float
        Mean length of the proximal bars (1 of a biglide), by which B and J are divided, so that
        sigma_min and manipulability have no unit.
    manipulability : (*batch,)
        |det J|, inf at Type 2.
    sigma_min, condition : Matrices
        Smallest singular values and condition numbers of A, B and J.
    """

    pose: Pose

    def __repr__(self) -> str:
        names = self.pose.robot.words.sines
        return one_line(
            "Margins",
            vector(", ".join(names), (*self.pose.sines, self.pose.det_A), ""),
            repr(self.pose),
        )

    @cached_property
    def _b(self):
        return tuple(abs(b) / self.length for b in self.pose.b)

    @cached_property
    def _size(self):
        return abs(self.parallel)

    @cached_property
    def _cosine(self):
        return abs(_array(dot(*self.pose.u2)))

    @cached_property
    def length(self) -> float:
        return sum(drive.length for drive in self.pose.robot.drives) / 2

    @cached_property
    def serial(self) -> np.ndarray:
        return pack(*self.pose.sines)

    @cached_property
    def parallel(self) -> np.ndarray:
        return _array(self.pose.det_A)

    @cached_property
    def transmission_angle(self) -> np.ndarray:
        return atan2(self._size, self._cosine)

    @cached_property
    def manipulability(self) -> np.ndarray:
        return _ratio(self._b[0] * self._b[1], self._size)

    @cached_property
    def sigma_min(self) -> Matrices:
        return Matrices(self._sigma_min_a, self._sigma_min_b, self._sigma_min_j)

    @cached_property
    def condition(self) -> Matrices:
        return Matrices(self._condition_a, self._condition_b, self._condition_j)

    # A A^T = [[1, g], [g, 1]], g = cos(phi2 - phi1): sigma_max^2 = 1 + |g|, and
    # sigma_min sigma_max = |det A|.
    def _sigma_min_a(self):
        return self._size / sqrt(1 + self._cosine)

    def _condition_a(self):
        return _ratio(1 + self._cosine, self._size)

    def _sigma_min_b(self):
        return minimum(*self._b)

    def _condition_b(self):
        return _ratio(maximum(*self._b), minimum(*self._b))

    # J = A^-1 B has columns of lengths |b_i / det A|, so that with g^2 + det A^2 = 1
    # 2 (sigma_max det A)^2 = b1^2 + b2^2 + hypot(b1^2 - b2^2, 2 g b1 b2), and sigma_min sigma_max =
    # |b1 b2 / det A|.
    @cached_property
    def _stretch(self):
        """sigma_max |det A| of J."""
        b1, b2 = self._b
        difference = hypot((b1 - b2) * (b1 + b2), 2 * self._cosine * b1 * b2)
        return sqrt((b1 * b1 + b2 * b2 + difference) / 2)

    def _sigma_min_j(self):
        b1, b2 = self._b
        return b1 * b2 / _or_one(self._stretch)

    def _condition_j(self):
        return _ratio(self._stretch, self._sigma_min_j() * self._size)


@dataclass(frozen=True, eq=False)
class Matrices:
    """One number (*batch,) for each of the matrices A, B and J = A^-1 B, computed when read."""

    _of_a: Callable
    _of_b: Callable
    _of_j: Callable

    @cached_property
    def A(self) -> np.ndarray:
        return self._of_a()

    @cached_property
    def B(self) -> np.ndarray:
        return self._of_b()

    @cached_property
    def J(self) -> np.ndarray:
        return self._of_j()


@takes(pose=a_pose)
def singularity_margins(pose: Pose) -> Margins:
    """Return the signed distances of a pose from its singularities, each computed when read.

    Parameters
    ----------
    pose : Pose
        One pose, a batch, or of CasADi symbols.

    Returns
    -------
    Margins

    Examples
    --------
    >>> import fivebar as fb
    >>> margins = fb.singularity_margins(fb.dgm(fb.FiveBar(), (0.0, 0.0)))
    >>> round(float(margins.parallel), 4)
    0.9901
    """
    return Margins(pose)


@takes(pose=a_pose, tol=not_negative)
def singularity(pose: Pose, tol: float = 1e-9) -> Singularity | np.ndarray:
    """Return the type of singularity of a pose.

    Parameters
    ----------
    pose : Pose
    tol : float
        Largest |sin| of the angle between two bars that count as in line. An end-effector at the
        limit of its reach has its sine to the root of rounding, 1e-8.

    Returns
    -------
    Singularity or (*batch,) of int
        NONE where the pose is nan.

    References
    ----------
    Gosselin and Angeles, Singularity analysis of closed-loop kinematic chains, 1990.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.singularity(fb.dgm(fb.FiveBar(), (0.0, 0.0))).name
    'NONE'
    """
    if is_symbolic(pose.point[0]):
        raise TypeError(
            "singularity needs a pose of numbers, not CasADi symbols: of these, singularity_margins"
        )
    s1, s2 = pose.sines
    serial = (np.abs(s1) <= tol) | (np.abs(s2) <= tol)
    kind = serial * int(Singularity.SERIAL) + (np.abs(pose.det_A) <= tol) * int(
        Singularity.PARALLEL
    )
    if np.ndim(kind) == 0:
        return Singularity(int(kind))
    return kind


def _array(x):
    return x if is_symbolic(x) else np.asarray(x)


def _or_one(x):
    """Return x, 1 where it is 0; symbols as they are."""
    return x if is_symbolic(x) else np.where(x == 0, 1.0, x)


def _ratio(x, y):
    """Return x / y, inf where y is 0; of symbols nan where both are."""
    return x / y if is_symbolic(y) else np.where(y == 0, np.inf, x / _or_one(y))
