"""The six-bar press of Wang, Chen and Deng 2019, with its equations corrected, and its two sets of
lengths.

Crank 2, coupler 3 and rocker 4 are a four-bar; bar 5 hangs from the joint of 3 and 4 and moves
slider 6 on the vertical through the rocker's pivot. Origin at the crank's pivot; angles and x as in
the paper; gravity, where there is any, is along +x. Errata: eq. 4 has L3^2 on its right; A and B of
eq. 5 are exchanged; eq. 9 with its minus sign is the lower branch, on which theta5 = -arccos(...);
eq. 20 is alpha3; eq. 21 has two wrong signs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..base.checks import inertia
from ..models.robots import must_close
from .chain import Along, Fixed, Reach, Still, Turned, meet, slide
from .checks import check, check_lengths, coordinate
from .limits import four_bar_limits
from .motion import BLOCK, RAIL, Body, Chain, MovingLink, one_drive
from .slider_crank import block

if TYPE_CHECKING:
    from .chain import Number

START = math.radians(160.24)  # Table 1: crank angle at t = 0
SPEED = math.radians(120.0)  # rad/s, of the crank
GRAVITY = (9.81, 0.0)  # m/s^2, along +x as in the paper


@dataclass(frozen=True)
class SixBarPress:
    """Six-bar press: crank, coupler, rocker, and a bar to the slider.

    A branch is (rocker, slider), +1 above and -1 below. Its coordinates are "S6" of eq. 12 and
    "S6_down", the slider's height above the line at l12.

    Parameters
    ----------
    l2, l3, l4, l5 : float
        Crank, coupler, rocker and bar, m.
    l11 : float
        Distance of the pivots, m.
    l12 : float
        Distance of the line from which S6_down counts, m.
    theta11 : float
        Direction from pivot to pivot, rad.
    m2, m3, m4, m5, m6 : float
        Masses of these links and the slider, kg; centres of mass are at mid-link.
    j2, j3, j4, j5 : float
        Inertias about the centres of mass, kg m^2. j2 is not printed in the paper; it counts only
        where the crank accelerates.

    Examples
    --------
    >>> from fivebar import linkages
    >>> linkages.REPAIRED.title
    'six-bar press'
    """

    l2: float
    l3: float
    l4: float
    l5: float
    l11: float
    l12: float
    theta11: float
    m2: float = 0.0
    m3: float = 0.0
    m4: float = 0.0
    m5: float = 0.0
    m6: float = 0.0
    j2: float = 0.0
    j3: float = 0.0
    j4: float = 0.0
    j5: float = 0.0

    usual_branch = (-1, -1)
    usual_start = START

    def __post_init__(self) -> None:
        check_lengths(self, "l2", "l3", "l4", "l5", "l11", "l12")
        check(self, coordinate, "theta11")
        must_close("press", {name: getattr(self, name) for name in ("l2", "l3", "l4", "l11")})
        check(self, inertia, "m2", "m3", "m4", "m5", "m6", "j2", "j3", "j4", "j5")

    @property
    def rocker_pivot(self) -> tuple[float, float]:
        return self.l11 * math.cos(self.theta11), self.l11 * math.sin(self.theta11)

    def chain(self, q: Number, branch: Any) -> Chain:
        a = Fixed((0.0, 0.0))
        crank = Turned(Still(), q)
        d = Fixed(self.rocker_pivot)
        b = Reach(a, crank, self.l2)
        c, coupler, rocker = meet(b, d, self.l3, self.l4, branch[0])
        e, bar = slide(
            c, d.p, (0.0, 1.0), self.l5, branch[1], "bar 5 is perpendicular to the slider's guide"
        )
        up = Still((0.0, 1.0))
        links = {
            "crank": MovingLink(a, crank, self.l2, Body(self.m2, self.j2)),
            "coupler": MovingLink(b, coupler, self.l3, Body(self.m3, self.j3)),
            "rocker": MovingLink(d, rocker, self.l4, Body(self.m4, self.j4)),
            "bar": MovingLink(c, bar, self.l5, Body(self.m5, self.j5)),
            "slider": MovingLink(e, up, 0.0, Body(self.m6)),
        }
        share = branch[1] * (self.l4 + self.l5)
        x, y = d.p
        rail = {RAIL[0]: Fixed((x, y + 0.4 * share)), RAIL[1]: Fixed((x, y + 1.1 * share))}
        return Chain(
            points={"A": a, "B": b, "C": c, "D": d, "E": e, **rail, **block(e, up, self.l5)},
            links=links,
            coordinates={
                "S6": Along(e, d.p, (0.0, -1.0), self.l12),
                "S6_down": Along(e, d.p, (0.0, 1.0), self.l12),
            },
            dyads=(c.dyad, e.dyad),
            bars=(("A", "B"), ("B", "C"), ("D", "C"), ("C", "E")),
            grounded=("A", "D", *RAIL),
            actuated=("A",),
            traced="C",
            rails=(RAIL,),
            blocks=((*BLOCK, "E"),),
        )

    start = one_drive
    driven = "crank"
    title = "six-bar press"

    def crank_limits(self, branch: Any) -> list[float]:
        """Crank angles at which coupler and rocker are in line, or bar 5 is perpendicular to the
        guide.
        """
        limits = four_bar_limits(self.theta11, self.l11, self.l2, self.l3, self.l4)
        if (
            self.l4 > self.l5
        ):  # the rocker's end gets too far from the guide: a four-bar driven by its rocker
            across = math.acos(self.l5 / self.l4)
            for theta4 in (across, -across, math.pi - across, math.pi + across):
                x, y = self.rocker_pivot
                x = x + self.l4 * math.cos(theta4)
                y = y + self.l4 * math.sin(theta4)
                square = x * x + y * y
                cosine = (square + self.l2**2 - self.l3**2) / (2 * self.l2 * math.sqrt(square))
                if abs(cosine) < 1:
                    limits += [
                        math.atan2(y, x) + math.acos(cosine),
                        math.atan2(y, x) - math.acos(cosine),
                    ]
        return limits


_TABLE_1 = dict(
    l3=0.54,
    l4=0.25,
    l5=0.4,
    l11=0.434,
    l12=0.65,
    theta11=math.radians(11.0),
    m2=0.037,
    m3=0.213,
    m4=0.1,
    m5=0.158,
    m6=0.139,
    j3=5.27e-3,
    j4=5.42e-4,
    j5=2.17e-3,
)

PRINTED = SixBarPress(l2=0.202, **_TABLE_1)
REPAIRED = SixBarPress(l2=0.052, **_TABLE_1)
PRESSES = {
    "repaired": (
        REPAIRED,
        (
            "Wang, Chen and Deng 2019, Table 1, with the crank of 52 mm in place of 202 mm (our"
            " repair: it turns, and its folded dead centre is at the printed initial angle of"
            " 160.24 deg)"
        ),
    ),
    "printed": (
        PRINTED,
        (
            "Wang, Chen and Deng 2019, Table 1 as printed: its crank of 202 mm cannot turn (202 +"
            " 540 > 434 + 250 mm)"
        ),
    ),
}
