"""How far a point of the plane is from the nearest singularity locus: on the exact curves, not on
their polylines.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike

from ..base.backend import EPS, is_symbolic, pairs, unpack
from ..base.checks import modes, optional
from ..base.robot_uses import takes_robot
from ..models.geometry import igm
from ..models.robots import Biglide, FiveBar
from .loci import singularity_loci
from .locus import Locus
from .margins import Singularity
from .roots import rising_zeros


@takes_robot(working=optional(modes(2)))
def locus_distance(
    robot: FiveBar | Biglide, xi: ArrayLike, working: tuple[int, int] | None = None
) -> tuple[float | np.ndarray, Singularity | np.ndarray]:
    """Return the distance in task space to the nearest singularity locus, and its type.

    Parameters
    ----------
    robot : FiveBar or Biglide
    xi : (*batch, 2)
        Points, m, reachable or not.
    working : (2,), optional
        Only loci that are active in this working mode. None: of all modes.

    Returns
    -------
    distance : float or (*batch,), m
    type : Singularity or (*batch,) of int
        Of the piece on which the nearest point lies.

    Examples
    --------
    >>> import fivebar as fb
    >>> distance, kind = fb.locus_distance(fb.FiveBar(), (0.05, 0.09), (-1, -1))
    >>> round(distance, 4), kind.name
    (0.0386, 'SERIAL')
    """
    x, y = unpack(xi, "xi")
    if is_symbolic(x):
        raise TypeError("locus_distance: xi must be numbers, not CasADi symbols")
    points = np.ravel(np.asarray(x) + 1j * np.asarray(y))
    pieces, everywhere = _active(robot, working)
    if pieces[0].unbounded:
        distance, kind = _nearest_line(pieces, points)
    else:
        segments = _segments(robot, working)
        chunk = max(1, 2_000_000 // len(segments.start))
        found = [_nearest(segments, points[i : i + chunk]) for i in range(0, len(points), chunk)]
        empty = np.empty(0), np.empty(0, dtype=int)
        distance, kind = (np.concatenate(each) for each in zip(*found)) if found else empty
    for mode in everywhere:
        inside = ~np.isnan(igm(robot, pairs(points), mode, unreachable="nan").q[:, 0])
        distance = np.where(inside, 0.0, distance)
        kind = np.where(inside, int(Singularity.PARALLEL), kind)
    if np.ndim(x) == 0:
        return float(distance[0]), Singularity(int(kind[0]))
    return distance.reshape(np.shape(x)), kind.reshape(np.shape(x))


@dataclass(frozen=True, eq=False)
class _Segments:
    """Parameter intervals [t0, t1] of the loci's pieces, (n,), with the points at their ends and
    the piece's index.
    """

    pieces: tuple[Locus, ...]
    start: np.ndarray
    end: np.ndarray
    t0: np.ndarray
    t1: np.ndarray
    piece: np.ndarray

    @cached_property
    def size(self) -> float:
        return float(np.abs(self.end).max())

    @cached_property
    def chord(self) -> np.ndarray:
        return np.abs(self.end - self.start)

    def candidates(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return (row, segment) of all segments on which the point nearest to points[row] may lie,
        rows in order.
        """
        # Roughly by the squares of the distances to all starts, then each by its own length: a
        # segment that turns by less than 1 degree is hardly longer than its chord.
        product = pairs(points) @ pairs(self.start).T
        square = (
            np.abs(self.start) ** 2 - 2 * product
        )  # less that of the point itself, the same for all
        least = square.argmin(axis=1)
        more = 1.02 * self.chord.max() + 1e-7 * (
            self.size + np.abs(points)
        )  # 1e-7: rounding of the root of a square
        more *= more + 2 * np.abs(points - self.start[least])
        row, k = np.nonzero(
            square <= square[np.arange(len(points)), least][:, None] + more[:, None]
        )
        near = np.minimum(np.abs(points[row] - self.start[k]), np.abs(points[row] - self.end[k]))
        best = np.minimum.reduceat(near, np.searchsorted(row, np.arange(len(points))))
        keep = near - 0.51 * self.chord[k] <= best[row]
        return row[keep], k[keep]

    def slope(self, k: np.ndarray, t: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return (xi - x) . dxi/dt / |dxi/dt| and |xi - x| at parameters t of segments k."""
        slope = np.empty(len(t))
        distance = np.empty(len(t))
        piece = self.piece[k]
        for i in np.unique(piece):
            chosen = piece == i
            z, dz = self.pieces[i]._curve(t[chosen])
            away = z - x[chosen]
            speed = np.abs(dz)
            slope[chosen] = (away.conj() * dz).real / np.where(speed == 0, 1.0, speed)
            distance[chosen] = np.abs(away)
        return slope, distance


@lru_cache(maxsize=32)
def _active(robot, working):
    """Return the pieces of the loci, and the modes that are singular everywhere, that count in this
    working mode.
    """
    loci = singularity_loci(robot)
    pieces = tuple(p for p in loci.task if working is None or working in p.working)
    return pieces, tuple(m for m in loci.everywhere if working is None or working == m)


def _nearest_line(pieces, points):
    """Return distances and types of points (n,) from lines, whose tangents have length 1."""
    curves = np.array([piece._curve(0.0) for piece in pieces])
    start = curves[:, 0, None]
    along = curves[:, 1, None]
    distance = np.abs((along.conj() * (points - start)).imag)
    nearest = distance.argmin(axis=0)
    return (
        distance[nearest, np.arange(len(points))],
        np.array([int(piece.type) for piece in pieces])[nearest],
    )


@lru_cache(maxsize=32)
def _segments(robot, working):
    pieces = _active(robot, working)[0]
    parts = []
    for k, piece in enumerate(pieces):
        z = piece.points @ (1, 1j)
        t = piece.parameters
        first = last = slice(None)
        if len(t) > 1:
            first = slice(None, -1)
            last = slice(1, None)
        parts.append((z[first], z[last], t[first], t[last], np.full(len(t[first]), k)))
    return _Segments(pieces, *(np.concatenate(each) for each in zip(*parts)))


def _nearest(segments, points):
    """Return distances and types of points (n,): the feet of the normals on all candidate segments,
    by bracketing.
    """
    row, k = segments.candidates(points)
    x = points[row]
    low = segments.t0[k]
    high = segments.t1[k]
    rounding = np.full(len(x), 2 * EPS * segments.size)
    foot = rising_zeros(lambda i, t: segments.slope(k[i], t, x[i])[0], low, high, rounding)
    ends = np.minimum(np.abs(segments.start[k] - x), np.abs(segments.end[k] - x))
    distance = np.minimum(ends, segments.slope(k, np.where(np.isnan(foot), low, foot), x)[1])
    order = np.lexsort((distance, row))
    first = order[np.searchsorted(row, np.arange(len(points)))]
    kinds = np.array([int(piece.type) for piece in segments.pieces])
    return distance[first], kinds[segments.piece[k[first]]]
