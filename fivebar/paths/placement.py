"""Where a drawing lies in the plane."""

from __future__ import annotations

import cmath
from dataclasses import dataclass, replace
from functools import partial
from typing import overload

import numpy as np
from numpy.typing import ArrayLike

from ..base.backend import finite_numbers, pairs
from ..base.checks import number, positive, shown, two_numbers
from ..base.representation import one_line, vector
from ..planning.trajectory import Trajectory
from .curve import Path


@dataclass(frozen=True)
class Placement:
    """A similarity of the plane: xi goes to shift + scale R(turn) xi.

    Attributes
    ----------
    shift : (2,)
        m.
    turn : float
        Angle, rad, to the left.
    scale : float
        Factor, > 0.

    Examples
    --------
    >>> import fivebar as fb
    >>> placement = fb.Placement(shift=(0.1, 0.0), scale=2.0)
    >>> placement((1.0, 1.0))
    array([2.1, 2. ])
    """

    shift: tuple[float, float] = (0.0, 0.0)
    turn: float = 0.0
    scale: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "shift", two_numbers(self.shift, "Placement: shift"))
        object.__setattr__(self, "turn", number(self.turn, "Placement: turn"))
        object.__setattr__(self, "scale", positive(self.scale, "Placement: scale"))

    def __repr__(self) -> str:
        return one_line(
            "Placement",
            vector("shift", self.shift, "m"),
            f"turn {self.turn:.6g} rad, scale {self.scale:.6g}",
        )

    @property
    def turned(self) -> complex:
        """Return the factor scale exp(i turn) of points x + i y, exact at right angles."""
        turn = cmath.exp(1j * self.turn)
        turn = complex(
            *(
                round(part) if abs(part - round(part)) < 1e-15 else part
                for part in (turn.real, turn.imag)
            )
        )
        return self.scale * turn

    @overload
    def __call__(self, what: Path) -> Path: ...

    @overload
    def __call__(self, what: Trajectory) -> Trajectory: ...

    @overload
    def __call__(self, what: ArrayLike) -> np.ndarray: ...

    def __call__(self, what: Path | Trajectory | ArrayLike) -> Path | Trajectory | np.ndarray:
        """Return a Path, a Trajectory or points (*batch, 2), m, placed."""
        if isinstance(what, Trajectory):
            return replace(what, _motion=partial(self._moved, what), origin=None)
        if isinstance(what, Path):
            return replace(what.moved(complex(*self.shift), self.turned), origin=None)
        points = finite_numbers(what, "Placement: points")
        if points.shape[-1:] != (2,):
            raise ValueError(f"Placement: points must be (*batch, 2), not {shown(points.shape)}")
        z = complex(*self.shift) + self.turned * (points @ (1, 1j))
        return pairs(z)

    def _moved(self, motion, t):
        moved = self.turned * (np.array(motion(t)) @ (1, 1j))
        moved[0] += complex(*self.shift)
        return np.concatenate(pairs(moved), axis=-1)

    def after(self, first: Placement) -> Placement:
        """Return the placement that does `first` and then this one."""
        z = complex(*self.shift) + self.turned * complex(*first.shift)
        return Placement((z.real, z.imag), self.turn + first.turn, self.scale * first.scale)

    @property
    def inverse(self) -> Placement:
        """Return the inverse placement."""
        z = -complex(*self.shift) / self.turned
        return Placement((z.real, z.imag), -self.turn, 1 / self.scale)
