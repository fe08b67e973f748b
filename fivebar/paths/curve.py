"""A path: a curve xi(s) through the plane, piece by piece, and where a motion along it must
rest.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import instance, not_negative, number, optional, positive, shown, whole
from ..base.columns import Origin
from ..base.presentation import Plotted
from ..base.representation import one_line, vector
from .pieces import ORDERS, Arc, Line, Piece, Polynomial, derivatives, on_arcs

if TYPE_CHECKING:
    from .tool import MountedTool

GAP = 1e-9  # of the path's size, m: between the end of a piece and the start of the next
DEVIATION = 2e-5  # m, within which corners of a drawing are rounded, where nobody says it
SMOOTH = 1e-6  # by which xi_s may jump where the motion goes on


class Stop(NamedTuple):
    """Where a motion must come to rest: at s, m, for so many seconds."""

    s: float
    seconds: float


@dataclass(frozen=True, eq=False)
class Path(Plotted):
    """A curve xi(s) in the plane, s from 0 to `length`, m, with exact derivatives by s.

    Call it with s, a number or (n,), for (xi, xi_s, xi_ss, xi_sss), each (2,) or (n, 2). At a knot
    between pieces xi_s is continuous within 1e-6, or the motion rests there. Further derivatives
    may jump: a call then gives those of the piece that begins, `on` those of either.

    Attributes
    ----------
    pieces : tuple of Line, Arc, Polynomial
        Each starts where the one before ends.
    pen : tuple of bool
        For each piece, whether the pen is down; by default always.
    dwells : {s: seconds}
        Rests at knots.
    feed : tuple of float
        Largest speed on each piece, m/s; by default inf.
    notes : tuple of str
        What was left out or converted when a file was read.
    lines : tuple of int or None
        Line of the file that each piece comes from.
    tool : MountedTool, optional
        Then the pieces are the path of a tool, and xi is that of joint C, which leads it along
        them: `Tool.path`.
    stops : tuple of Stop
        Where a motion must come to rest: (s, seconds).
    rests_for_pen : bool
        Whether it rests where the pen goes down or up.
    origin : Origin, optional
        As of a Trajectory.

    Raises
    ------
    ValueError
        The pieces do not join, or a dwell is not at a knot.

    Examples
    --------
    >>> import fivebar as fb
    >>> path = fb.path([(0.0, 0.0), (0.03, 0.0), (0.03, 0.04)])
    >>> path.length
    0.07
    >>> [stop.s for stop in path.stops]
    [0.0, 0.03, 0.07]
    """

    pieces: tuple[Piece, ...]
    pen: tuple[bool, ...] = None  # type: ignore[assignment]  # filled in __post_init__
    dwells: Mapping[float, float] = field(default_factory=dict)
    feed: tuple[float, ...] = None  # type: ignore[assignment]  # filled in __post_init__
    notes: tuple[str, ...] = ()
    lines: tuple[int | None, ...] = None  # type: ignore[assignment]  # as above
    tool: MountedTool | None = None
    rests_for_pen: bool = True
    origin: Origin | None = None
    stops: tuple[Stop, ...] = field(init=False)

    def __post_init__(self) -> None:
        pieces = _listed(self.pieces, "pieces")
        notes = _listed(self.notes, "notes")
        if not pieces:
            raise ValueError("Path: no pieces: a path needs at least one")
        for k, piece in enumerate(pieces):
            if not isinstance(piece, Line | Arc | Polynomial):
                raise TypeError(
                    f"Path: pieces[{k}] must be a Line, an Arc or a Polynomial, not {shown(piece)}"
                )
        n = len(pieces)
        pen = _each(self.pen, True, _true_or_false, n, "pen")
        feed = _each(self.feed, np.inf, _speed, n, "feed")
        lines = _each(self.lines, None, optional(whole(1, 10**12)), n, "lines")
        for name, value in (
            ("pieces", pieces),
            ("pen", pen),
            ("feed", feed),
            ("notes", notes),
            ("lines", lines),
            ("rests_for_pen", _true_or_false(self.rests_for_pen, "Path: rests_for_pen")),
        ):
            object.__setattr__(self, name, value)
        optional(instance(Origin))(self.origin, "Path: origin")
        order = np.arange(n)
        starts = self._on_pieces(order, np.zeros(n))[0]
        ends = self._on_pieces(order, np.array([piece.length for piece in pieces]))[0]
        gap = np.linalg.norm(starts[1:] - ends[:-1], axis=-1)
        if gap.max(initial=0.0) > GAP * (np.abs(ends).max() + self.length):
            k = int(gap.argmax())
            raise ValueError(
                f"Path: pieces[{k + 1}] starts {gap[k]:.3g} m from where pieces[{k}] ends"
            )
        rests = {0.0: 0.0, self.length: 0.0, **dict.fromkeys(self._rests().tolist(), 0.0)}
        if not isinstance(self.dwells, Mapping):
            raise TypeError(f"Path: dwells must be {{s: seconds}}, not {shown(self.dwells)}")
        for s, seconds in self.dwells.items():
            s = number(s, "Path: s of dwells")
            k = int(np.abs(self._edges - s).argmin())
            if not abs(self._edges[k] - s) <= 1e-9 * self.length:
                raise ValueError(
                    f"Path: a dwell at s = {s!r} m is at no knot; the nearest one is"
                    f" {self._edges[k]:.9g}"
                )
            knot = float(self._edges[k])
            rests[knot] = rests.get(knot, 0.0) + not_negative(seconds, "Path: seconds of dwells")
        object.__setattr__(
            self, "dwells", {s: seconds for s, seconds in sorted(rests.items()) if seconds}
        )
        object.__setattr__(self, "stops", tuple(Stop(*each) for each in sorted(rests.items())))
        if self.tool is not None:
            instance("MountedTool")(self.tool, "Path: tool")
            self.tool.refuse_unreached(self)

    def __repr__(self) -> str:
        carried = "" if self.tool is None else repr(self.tool.tool)
        ends = (
            vector("from", tuple(self.pieces[0].start), "m"),
            vector("to", tuple(self.pieces[-1].end), "m"),
        )
        down = sum(piece.length for piece, down in zip(self.pieces, self.pen) if down)
        if all(self.pen):
            drawn = ""
        else:
            drawn = f"{down:.6g} m of it drawn"
        if len(self.stops) > 2:
            rests = f"{len(self.stops) - 2} stops on the way"
        else:
            rests = ""
        return one_line(
            "Path",
            f"{len(self.pieces)} pieces",
            f"{self.length:.6g} m",
            drawn,
            *ends,
            rests,
            carried,
        )

    @cached_property
    def _edges(self) -> np.ndarray:
        return np.concatenate([[0.0], np.cumsum([piece.length for piece in self.pieces])])

    @property
    def knots(self) -> np.ndarray:
        """s (k + 1,) m where the k pieces begin and, last, where the path ends."""
        return self._edges

    @property
    def length(self) -> float:
        return float(self._edges[-1])

    def __call__(self, s: ArrayLike) -> tuple[np.ndarray, ...]:
        s = np.asarray(s, float)
        slack = 1e-9 * self.length
        inside = np.clip(s, 0.0, self.length)
        outside = ~(np.abs(s - inside) <= slack)
        if outside.any():
            raise ValueError(
                f"Path: s must be from 0 to {self.length:g} m, not {shown(s[outside].tolist())}"
            )
        k = np.clip(np.searchsorted(self._edges, inside, side="right") - 1, 0, len(self.pieces) - 1)
        return self.on(k, inside - self._edges[k])

    def on(self, k: ArrayLike, s: ArrayLike) -> tuple[np.ndarray, ...]:
        """As path(s), on pieces[k] at s from 0 to its own length; k, s: numbers or (n,)."""
        k, s = np.broadcast_arrays(np.asarray(k), np.asarray(s, float))
        found = self._on_pieces(k.ravel(), s.ravel())
        if self.tool is not None:
            found = self.tool.carried(found)
        return tuple(found.reshape(ORDERS, *k.shape, 2))

    def _on_pieces(self, k, s):
        arcs, tables, lengths, is_arc, own = self._packed
        found = np.empty((ORDERS, len(k), 2))
        for at in (is_arc[k], ~is_arc[k]):
            if not at.any():
                continue
            if is_arc[k[at][0]]:
                found[:, at] = on_arcs(arcs[own[k[at]]], s[at])
            else:
                u = s[at] / lengths[own[k[at]]]
                powers = u[:, None] ** np.arange(tables.shape[2])
                found[:, at] = np.einsum("nj,nojc->onc", powers, tables[own[k[at]]])
        return found

    @cached_property
    def drawn(self) -> Path:
        """The path that is drawn: that of the tool, and without a tool this one."""
        return self if self.tool is None else replace(self, tool=None)

    def moved(self, by: complex, turned: complex) -> Path:
        """All points z = x + i y put to by + turned z; speeds asked for and dwells stay."""
        return self.rebuilt([(piece.moved(by, turned), k) for k, piece in enumerate(self.pieces)])

    def rebuilt(self, rows: Iterable[tuple[Piece, int]]) -> Path:
        """Return the path of other pieces, each with the number of the piece here in whose place it
        comes, or begins: it has the pen, speed and line of that one, and the dwell at its start.
        """
        pieces, numbers = zip(*rows)
        edges = np.concatenate([[0.0], np.cumsum([piece.length for piece in pieces])])
        dwells = {}
        for s, seconds in self.dwells.items():
            knot = np.abs(self._edges - s).argmin()
            dwells[float(edges[np.searchsorted(numbers, knot)])] = seconds
        pen, feed, lines = (
            tuple(each[k] for k in numbers) for each in (self.pen, self.feed, self.lines)
        )
        return replace(self, pieces=pieces, pen=pen, feed=feed, lines=lines, dwells=dwells)

    def line_of(self, s: float) -> int | None:
        """The line of the file that the piece at s comes from."""
        return self.lines[
            min(int(np.searchsorted(self._edges, s, side="right")), len(self.pieces)) - 1
        ]

    @property
    def at_unit_speed(self) -> AtUnitSpeed:
        """The path as a motion with s_dot = 1 m/s, for what asks for a motion and looks at its
        places: `check_path`.
        """
        return AtUnitSpeed(self)

    @cached_property
    def _packed(self):
        """All arcs (a, 5), all others' tables (p, 4, terms, 2) and lengths (p,), which piece is an
        arc, its row.
        """
        is_arc = np.array([isinstance(piece, Arc) for piece in self.pieces])
        arcs = np.array(
            [[*p.centre, p.radius, p.angle0, p.side] for p in self.pieces if isinstance(p, Arc)]
        )
        others = [p for p in self.pieces if not isinstance(p, Arc)]
        terms = max((len(p.coefficients) for p in others), default=1)
        tables = np.zeros((len(others), ORDERS, terms, 2))
        for table, piece in zip(tables, others):
            table[:, : len(piece.coefficients)] = derivatives(piece.coefficients, piece.length)
        own = np.where(is_arc, np.cumsum(is_arc), np.cumsum(~is_arc)) - 1
        return arcs, tables, np.array([p.length for p in others]), is_arc, own

    def _rests(self):
        """s where xi_s jumps, or the pen changes, if the motion rests for that."""
        n = len(self.pieces)
        before = np.arange(n - 1)
        after = np.arange(1, n)
        lengths = np.array([piece.length for piece in self.pieces])
        jump = np.linalg.norm(
            self._on_pieces(after, np.zeros(n - 1))[1] - self._on_pieces(before, lengths[:-1])[1],
            axis=-1,
        )
        changes = (np.diff(self.pen) != 0) & self.rests_for_pen
        return self._edges[1:-1][(jump > SMOOTH) | changes]


@dataclass(frozen=True, eq=False)
class AtUnitSpeed:
    """t -> (xi, xi_dot, xi_ddot) along a path with s = t, which does not stop at corners."""

    path: Path
    start = 0.0

    @property
    def duration(self) -> float:
        return self.path.length

    def __call__(self, t: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        xi, xi_dot, xi_ddot, _ = self.path(t)
        return xi, xi_dot, xi_ddot


def _listed(given, name):
    if isinstance(given, list | tuple) or (isinstance(given, np.ndarray) and given.ndim):
        return tuple(given)
    raise TypeError(f"Path: {name} must be a list or a tuple, not {shown(given)}")


def _speed(value, name):
    if isinstance(value, float | np.floating) and value == math.inf:
        return math.inf
    return positive(value, name)


def _true_or_false(value, name):
    if not isinstance(value, bool | int | np.bool_) or value not in (0, 1):
        raise ValueError(f"{name} must be True or False, not {shown(value)}")
    return bool(value)


def _each(given: Iterable | None, usual, rule, n, name):
    if given is None:
        values = (usual,) * n
    else:
        values = tuple(rule(each, f"Path: {name}") for each in _listed(given, name))
    if len(values) != n:
        raise ValueError(f"Path: {name} has {len(values)} values for {n} pieces")
    return values
