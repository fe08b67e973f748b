"""A linkage at given crank angles: the Motion, in which everything is read, and what it is made
of.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..base.backend import atan2, is_symbolic, pack, sqrt
from ..base.checks import inertia
from ..models.dyads import cross, dot
from .chain import Reach, Slot, angle
from .checks import check, pair

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from typing import TypeAlias

    from .chain import Heading, Number, Point
    from .five_bar import FiveBarLinkage
    from .four_bar import FourBar
    from .six_bar_press import SixBarPress
    from .slider_crank import SliderCrank

    CrankLinkage: TypeAlias = FourBar | SliderCrank | SixBarPress
    Linkage: TypeAlias = CrankLinkage | FiveBarLinkage

STRETCH = 8192  # poses that fit into the processor's cache
RAIL = ("G", "H")  # names of the ends of a guide
BLOCK = ("K", "L")  # names of the ends of a block on it


@dataclass(frozen=True)
class Body:
    """A link's mass and inertia.

    Parameters
    ----------
    mass : float
        kg.
    inertia : float
        About its centre of mass, kg m^2.
    centre : (2,), optional
        Centre of mass along and across the link from its first joint, m. None: the middle of the
        link.

    Examples
    --------
    >>> from fivebar import linkages
    >>> linkages.Body(mass=0.2, inertia=1e-4).centre is None
    True
    """

    mass: float = 0.0
    inertia: float = 0.0
    centre: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        for name in ("mass", "inertia"):
            object.__setattr__(self, name, inertia(getattr(self, name), f"a body's {name}"))
        check(self, pair, "centre")


@dataclass(frozen=True, eq=False)
class MovingLink:
    """A moving link: where it begins, its heading, its length (0: a block) and its body."""

    origin: Point
    heading: Heading
    length: float
    body: Body = Body()

    @cached_property
    def centre(self) -> Point:
        """The moving centre of mass."""
        along, across = self.body.centre or (self.length / 2, 0.0)
        return Reach(self.origin, self.heading, along, across) if along or across else self.origin


class Chain(NamedTuple):
    """What a linkage builds for `move`: points, links and scalar coordinates by name, and the dyads
    in their order.
    """

    points: dict[str, Point]
    links: dict[str, MovingLink]
    coordinates: dict
    dyads: tuple
    bars: tuple  # pairs of point names, for pictures
    grounded: tuple[str, ...]
    actuated: tuple[str, ...]
    traced: str
    rails: tuple = ()  # pairs: the ends of straight guides
    blocks: tuple = ()  # (end, end, joint on it), of what slides on them

    @property
    def found(self) -> Number:
        """A number per pose that is nan where the chain does not close."""
        last = self.dyads[-1]
        return last.u[0] if isinstance(last, Slot) else last.first[0]

    @property
    def marks(self) -> set[str]:
        """Names of the points that only mark the ends of guides and blocks."""
        return {name for ends in (*self.rails, *self.blocks) for name in ends[:2]}


@dataclass(frozen=True, eq=False)
class Motion:
    """A linkage moving through one pose or a batch, from `move`. All is computed when first read.

    With the q_dot = 1 and q_ddot = 0 of `move`, velocities and accelerations are analogs, by the
    crank angle.

    Attributes
    ----------
    linkage : Linkage
    q, q_dot, q_ddot : (*batch,)
        Of the drive, rad, rad/s, rad/s^2.
    branch : int or (2,)
    points, links : tuple of str
        Names of its points and links.

    Examples
    --------
    >>> from fivebar import linkages
    >>> linkages.move(linkages.FourBar(0.2, 0.06, 0.16, 0.14), 0.5).links
    ('crank', 'coupler', 'rocker')
    """

    linkage: Linkage
    q: Any
    q_dot: Any
    q_ddot: Any
    branch: int | tuple[int, int] | np.ndarray
    _build: Callable[
        [], Chain
    ]  # () -> Chain; late, for a large batch may need it a stretch at a time only
    _scale: tuple  # what the chain's own derivatives are multiplied by

    @cached_property
    def chain(self) -> Chain:
        return self._build()

    def stretches(self) -> Iterator[tuple[slice | None, Motion]]:
        """Yield (part of the flat batch, Motion) for stretches of a large batch with one drive;
        else (None, itself).

        What is computed in one is forgotten in the next, so that all of it stays in the processor's
        cache.
        """
        if not isinstance(self.q, np.ndarray) or self.q.size <= STRETCH:
            yield None, self
            return
        given = self.q, self.q_dot, self.q_ddot, self.branch
        for first in range(0, self.q.size, STRETCH):
            part = slice(first, first + STRETCH)
            yield part, self.linkage.start(*(stretch(x, self._shape, part) for x in given))

    @property
    def points(self) -> tuple[str, ...]:
        return tuple(self.chain.points)

    @property
    def links(self) -> tuple[str, ...]:
        return tuple(self.chain.links)

    @property
    def coordinates(self) -> tuple[str, ...]:
        return tuple(self.chain.coordinates)

    def position(self, point: str) -> np.ndarray:
        """Return (*batch, 2) m."""
        return self._full(*self._point(point).p)

    def velocity(self, point: str) -> np.ndarray:
        """Return (*batch, 2) m/s."""
        return self._full(*self._velocity(self._point(point)))

    def acceleration(self, point: str) -> np.ndarray:
        """Return (*batch, 2) m/s^2."""
        return self._full(*self._acceleration(self._point(point)))

    def angle(self, link: str) -> np.ndarray:
        """From +x, in (-pi, pi] rad: (*batch,)."""
        return self._full(angle(self._link(link).heading))

    def rate(self, link: str) -> np.ndarray:
        """Angular velocity, rad/s: (*batch,)."""
        return self._full(self._first(self._link(link).heading.rate))

    def angular_acceleration(self, link: str) -> np.ndarray:
        """rad/s^2: (*batch,)."""
        heading = self._link(link).heading
        return self._full(self._second(heading.rate, heading.acceleration))

    def coordinate(self, name: str) -> tuple[np.ndarray, ...]:
        """Return (value, rate, acceleration) of a scalar coordinate such as a slider's way: each
        (*batch,), m and s.
        """
        c = _named(self.chain.coordinates, name, "coordinate")
        return tuple(map(self._full, (c.p, self._first(c.v), self._second(c.v, c.a))))

    def speed(self, point: str) -> np.ndarray:
        """|v|, m/s: (*batch,)."""
        return self._full(self._path(point)[0])

    def tangential(self, point: str) -> np.ndarray:
        """Acceleration along the path, m/s^2: (*batch,); nan where the point rests."""
        speed, along, _ = self._path(point)
        return self._full(_ratio(along, speed))

    def normal(self, point: str) -> np.ndarray:
        """Size of the acceleration across the path, m/s^2: (*batch,); nan where the point rests."""
        speed, _, across = self._path(point)
        return self._full(_ratio(across, speed))

    def curvature_radius(self, point: str) -> np.ndarray:
        """|v|^3 / |v x a|, m: (*batch,); inf where the path is straight, nan where the point
        rests.
        """
        speed, _, across = self._path(point)
        return self._full(_ratio(speed * speed * speed, across))

    def transmission_angle(self) -> np.ndarray:
        """Between the bars of the last dyad, in [0, pi] rad: (*batch,); 0 and pi are its
        singularities.
        """
        dyad = self.chain.dyads[-1]
        if isinstance(dyad, Slot):
            return self._full(atan2(abs(dyad.slide), 0.0 * dyad.slide + abs(dyad.offset)))
        return self._full(atan2(abs(dyad.sine), dot(dyad.first, dyad.second)))

    def _path(self, point):
        v = self._velocity(self._point(point))
        a = self._acceleration(self._point(point))
        return sqrt(dot(v, v)), dot(v, a), abs(cross(v, a))

    def _point(self, name):
        return _named(self.chain.points, name, "point")

    def _link(self, name):
        return _named(self.chain.links, name, "link")

    def _first(self, x1):
        return x1 * self._scale[0]

    def _second(self, x1, x2):
        return x2 * (self._scale[0] * self._scale[0]) + x1 * self._scale[1]

    def _velocity(self, point):
        return tuple(map(self._first, point.v))

    def _acceleration(self, point):
        return tuple(map(self._second, point.v, point.a))

    @cached_property
    def _shape(self):
        return np.broadcast_shapes(*(np.shape(x) for x in (*self._moving_in, *self._scale)))

    @property
    def _moving_in(self):
        return self.q if isinstance(self.q, tuple) else (self.q,)

    def _full(self, *components):
        """Return components as a result of the batch's shape, what does not move included."""
        if any(is_symbolic(x) for x in (*components, *self._moving_in)):
            return pack(*components) if len(components) > 1 else components[0]
        components = [np.broadcast_to(x, self._shape) for x in components]
        if len(components) > 1:
            return np.stack(components, axis=-1)
        return float(components[0]) if self._shape == () else components[0]


def one_drive(
    linkage: CrankLinkage, q: Number, q_dot: Number, q_ddot: Number, branch: Any
) -> Motion:
    """Return the Motion of a linkage with one crank: the chain is solved in analogs."""
    return Motion(
        linkage, q, q_dot, q_ddot, branch, lambda: linkage.chain(q, branch), (q_dot, q_ddot)
    )


def stretch(x: Any, shape: tuple[int, ...], part: slice) -> Any:
    """Return the part of what is given for a flat batch; a number, or a pair of branches, is that
    of every part.
    """
    if isinstance(x, np.ndarray):
        return np.broadcast_to(x, shape).reshape(-1)[part]
    return x


def _named(table, name, what):
    try:
        return table[name]
    except KeyError:
        raise ValueError(f"no {what} {name!r}; the known ones are {', '.join(table)}") from None


def _ratio(x, y):
    if is_symbolic(x):
        return x / y
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.divide(x, y)
