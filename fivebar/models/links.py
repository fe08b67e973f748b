"""Bars as they are built, and what of them the dynamics needs: their grouping into base parameters.

A distal bar of length l with mass m2, centre of mass (x, y) in its own frame from the elbow and
inertia zz about the elbow moves as a mass m2 - m2 x / l at the elbow, a mass m2 x / l at the
end-effector, an inertia j = zz - m2 x l that turns with it, and a first moment m2 y across it: with
E the elbow, xi the end-effector, phi the bar's angle, u, v the unit vectors along and across it,

    T = 1/2 (m2 - m2 x/l) |E'|^2 + 1/2 (m2 x/l) |xi'|^2 + 1/2 j phi'^2 - m2 y phi' u . E'
    V = -(m2 - m2 x/l) g . E - (m2 x/l) g . xi - m2 y g . v
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from ..base.checks import inertia, number, positive, shown, size

T = TypeVar("T")
NAMES = "11", "12", "21", "22"
UNLIKE = 1e4  # times, that one motor's inertia is not of the other's
ROUNDING = 1e-12  # of an inertia, by which a point mass may be less than itself


@dataclass(frozen=True)
class Link:
    """A bar as it is built, of `FiveBar.from_links`.

    Its first joint is the motor of a proximal bar, the elbow of a distal one.

    Parameters
    ----------
    mass : float
        kg.
    x, y : float
        Centre of mass along and across the bar from its first joint, m. x None: the middle of a
        uniform bar.
    inertia : float, optional
        About the first joint, kg m^2. None: of a uniform bar, m l^2 / 3; with x given, m l^2 / 12
        about the centre of mass.

    Raises
    ------
    ValueError
        A value that no body can have, as an inertia below m (x^2 + y^2).

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.Link(0.3, x=0.04, inertia=0.001).mass
    0.3
    """

    mass: float
    x: float | None = None
    y: float = 0.0
    inertia: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", inertia(self.mass, "a link's mass"))
        for name in ("x", "y"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, number(getattr(self, name), f"a link's {name}"))
        if self.inertia is None:
            return
        object.__setattr__(self, "inertia", inertia(self.inertia, "a link's inertia"))
        if self.x is None:
            raise ValueError(
                f"a link's inertia = {self.inertia:g} kg m² is about its first joint: it needs x,"
                " the centre of mass"
            )
        least = self.mass * (self.x * self.x + self.y * self.y)
        if self.inertia < least * (1 - ROUNDING):
            raise ValueError(
                f"a link's inertia = {self.inertia:g} kg m² about its first joint is less than mass"
                f" (x^2 + y^2) = {least:g} kg m²: no body has that; is it about the centre of mass?"
                " Then Link.about_centre(...), in a file inertia_about_centre"
            )

    @classmethod
    def about_centre(cls, mass: float, x: float, y: float = 0.0, inertia: float = 0.0) -> Link:
        """Return a link whose inertia, kg m^2, is about its centre of mass, as data sheets and CAD
        programs give it.
        """
        mass, x, y = (
            number(value, f"a link's {name}")
            for name, value in (("mass", mass), ("x", x), ("y", y))
        )
        own = number(inertia, "a link's inertia about its centre of mass", 0.0)
        return cls(mass, x, y, own + mass * (x * x + y * y))

    def of_length(self, length: float) -> tuple[float, float, float, float]:
        """Return (mass, first moments along and across, inertia about the first joint) as a bar of
        this length, m.
        """
        x = length / 2 if self.x is None else self.x
        own = self.inertia
        if own is None:
            own = self.mass * (length * length / 12 + x * x + self.y * self.y)
        return self.mass, self.mass * x, self.mass * self.y, own


def links_by_name(links: object) -> dict[str, Link]:
    """Return all four links of {"11": Link or mass, ...}; a bar that is not named has no mass."""
    if not isinstance(links, Mapping) or not set(links) <= set(NAMES):
        raise ValueError(f'links must be a table of "11", "12", "21" and "22", not {shown(links)}')
    return {name: _link(links, name) for name in NAMES}


def knowing_links(robot: T, links: Mapping[str, Link]) -> T:
    """Return this robot, just made, which from then on knows that its inertias are of these."""
    object.__setattr__(robot, "links", links)
    return robot


def grouped(
    lengths: Mapping[str, Any],
    links: Mapping[str, Link],
    payload: float = 0.0,
    rotor: Sequence = (0.0, 0.0),
) -> dict[str, float]:
    """Return base parameters {name: value} of these links at lengths {"l11": m, ...}."""
    rotor = rotor.tolist() if isinstance(rotor, np.ndarray) else rotor
    if not isinstance(rotor, (tuple, list)) or len(rotor) != 2:
        raise ValueError(
            f"rotor must be two inertias, or (inertia, gear ratio) pairs, not {shown(rotor)}"
        )
    if (
        all(isinstance(each, int | float) for each in rotor)
        and max(rotor) > UNLIKE * min(rotor) > 0
    ):
        raise ValueError(
            f"rotor = {shown(rotor)} are two inertias that are too unlike: a motor and its gear"
            " ratio are a pair in it, as ((inertia, ratio), (inertia, ratio))"
        )
    found = {"m": inertia(payload, "payload")}
    for leg, motor in zip("12", rotor):
        l1, l2 = (size(lengths[name], name) for name in (f"l{leg}1", f"l{leg}2"))
        _, mx1, my1, zz1 = links[f"{leg}1"].of_length(l1)
        mass, mx2, my2, zz2 = links[f"{leg}2"].of_length(l2)
        at_end = mx2 / l2
        at_elbow = mass - at_end
        found["m"] += at_end
        found[f"zz{leg}"] = zz1 + at_elbow * l1 * l1 + _rotor(motor)
        found[f"mx{leg}1"], found[f"my{leg}1"] = mx1 + at_elbow * l1, my1
        found[f"zz{leg}2"], found[f"my{leg}2"] = zz2 - mx2 * l2, my2
    return found


def _link(links, name):
    link = links.get(name, 0.0)
    if isinstance(link, Link):
        return link
    try:
        return Link(link)
    except ValueError as error:
        raise ValueError(f'links["{name}"]: {error}') from None


def _rotor(motor):
    """Return the inertia that a motor puts on its joint."""
    if isinstance(motor, (tuple, list)):
        if len(motor) != 2:
            raise ValueError(
                f"rotor must be an inertia or (inertia, gear ratio), not {shown(motor)}"
            )
        return (
            inertia(motor[0], "rotor's inertia")
            * positive(abs(number(motor[1], "rotor's gear ratio")), "rotor's gear ratio") ** 2
        )
    return inertia(motor, "rotor")
