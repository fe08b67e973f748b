"""The slider-crank with offset: any of its four links held, on either branch."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..base.backend import EPS, is_symbolic
from ..base.checks import instance, one_of
from .chain import Along, Fixed, Reach, Slot, Still, Turned, slide
from .checks import check, check_lengths, coordinate
from .limits import ends_of, guide_limits
from .motion import BLOCK, RAIL, Body, Chain, MovingLink, one_drive

if TYPE_CHECKING:
    from .chain import Heading, Number, Point

HELD = {
    "guide": "the slider-crank of engines and pumps; the crank is driven",
    "crank": "the quick return of shapers; the rod is driven, the guide swings",
    "rod": (
        "the oscillating cylinder; the crank is driven, the guide swings through a swivelling block"
    ),
    "slider": "the hand pump; the rod is driven, the guide slides",
}
# Where the driven bar, of crank and rod, is the longer one.
TURNING = "the quick return of Whitworth and the rotary engine; the {} is driven, the guide turns"


@dataclass(frozen=True)
class SliderCrank:
    """Slider-crank O A B: crank OA, rod AB, slider B on the guide that passes O at an offset.

    branch +1: the slider is ahead along the guide of the rod's other end (guide held), of O (crank
    or rod held); with the slider held, O is ahead of A.

    Parameters
    ----------
    crank, rod : float
        m.
    offset : float
        Distance of the guide from O, to its left, m.
    held : "guide", "crank", "rod" or "slider"
        The link that does not move.
    crank_body, rod_body, slider_body, guide_body : Body

    Raises
    ------
    ValueError
        Lengths that cannot close.

    Examples
    --------
    >>> from fivebar import linkages
    >>> linkages.move(linkages.SliderCrank(0.05, 0.15), 0.0).position("B").round(6).tolist()
    [0.2, 0.0]
    """

    crank: float
    rod: float
    offset: float = 0.0
    held: str = "guide"
    crank_body: Body = Body()
    rod_body: Body = Body()
    slider_body: Body = Body()
    guide_body: Body = Body()

    usual_branch = 1

    def __post_init__(self) -> None:
        check_lengths(self, "crank", "rod")
        check(self, coordinate, "offset")
        check(self, instance(Body), "crank_body", "rod_body", "slider_body", "guide_body")
        check(self, one_of(*HELD), "held")
        if abs(self.offset) > self.crank + self.rod:
            raise ValueError(
                f"this slider-crank can never close: offset = {abs(self.offset):g} m is more than"
                f" crank + rod = {self.crank + self.rod:g} m, by"
                f" {abs(self.offset) - self.crank - self.rod:.6g} m"
            )

    def chain(self, q: Number, branch: Any) -> Chain:
        if self.held == "guide":
            return self._guide_held(q, branch)
        if self.held == "slider":
            return self._slider_held(q, branch)
        return self._on_turning_guide(q, branch)

    start = one_drive

    @property
    def flats(self) -> list[float]:
        """Angles of the driven link, rad, at which the dyad is singular without being a limit."""
        tolerance = 8 * EPS * (self.crank + self.rod)
        if self.held in ("guide", "slider"):
            driven = self.crank
            bar = self.rod
            offset = self.offset
            if self.held == "slider":
                driven = self.rod
                bar = self.crank
                offset = -self.offset
            heights = {side: abs(offset - side * driven) for side in (1, -1)}
            return [s * math.pi / 2 for s, h in heights.items() if abs(h - bar) <= tolerance]
        if abs(abs(self.crank - self.rod) - abs(self.offset)) <= tolerance:
            return [math.pi if self.held == "crank" else 0.0]
        return []

    @property
    def title(self) -> str:
        return f"slider-crank, {self.held} held"

    @property
    def driven(self) -> str:
        """The name of the driven link."""
        return "crank" if self.held in ("guide", "rod") else "rod"

    def _guide_held(self, q, branch):
        length, y = self._length, self.offset
        o = Fixed((0.0, 0.0))
        heading = Turned(Still(), q)
        a = Reach(o, heading, self.crank)
        singular = "the rod is perpendicular to the guide"
        b, rod = slide(a, (0.0, y), (1.0, 0.0), self.rod, branch, singular)
        links = {
            "crank": MovingLink(o, heading, self.crank, self.crank_body),
            "rod": MovingLink(a, rod, self.rod, self.rod_body),
            "slider": MovingLink(b, Still(), 0.0, self.slider_body),
        }
        rail = {RAIL[0]: Fixed((-0.3 * length, y)), RAIL[1]: Fixed((length, y))}
        return Chain(
            points={"O": o, "A": a, "B": b, **rail, **block(b, Still(), length)},
            links=links,
            coordinates={"slide": Along(b, (0.0, y), (1.0, 0.0))},
            dyads=(b.dyad,),
            bars=(("O", "A"), ("A", "B")),
            grounded=("O", *RAIL),
            actuated=("O",),
            traced="B",
            rails=(RAIL,),
            blocks=((*BLOCK, "B"),),
        )

    def _slider_held(self, q, branch):
        """Return the chain in which the guide moves along itself, so that O slides."""
        b = Fixed((0.0, 0.0))
        heading = Turned(Still(), q)
        a = Reach(b, heading, self.rod)
        line = (0.0, -self.offset)
        singular = "the crank is perpendicular to the guide"
        o, crank = slide(a, line, (1.0, 0.0), self.crank, branch, singular)
        links = {
            "rod": MovingLink(b, heading, self.rod, self.rod_body),
            "crank": MovingLink(a, crank, self.crank, self.crank_body),
            "guide": MovingLink(o, Still(), 0.0, self.guide_body),
        }
        return Chain(
            points={"B": b, "A": a, "O": o, **self._rail(o, Still())},
            links=links,
            coordinates={"slide": Along(o, line, (-1.0, 0.0))},
            dyads=(o.dyad,),
            bars=(("B", "A"), ("A", "O"), *self._arm),
            grounded=("B",),
            actuated=("B",),
            traced="O",
            rails=(RAIL,),
        )

    def _on_turning_guide(self, q, branch):
        """RPR: the guide turns about O and passes the block's pin B at the offset."""
        heading = Turned(Still(), q)
        origin = Fixed((0.0, 0.0))
        if self.held == "crank":
            o = origin
            a = Fixed((self.crank, 0.0))
            b = Reach(a, heading, self.rod)
            links = {"rod": MovingLink(a, heading, self.rod, self.rod_body)}
            grounded = ("A", "O")
            traced = "B"
            bar = ("A", "B")
        else:
            a = origin
            b = Fixed((self.rod, 0.0))
            o = Reach(a, heading, self.crank)
            links = {"crank": MovingLink(a, heading, self.crank, self.crank_body)}
            grounded = ("A", "B")
            traced = RAIL[1]
            bar = ("A", "O")
        guide = Slot(o, b, self.offset, branch)
        # Block and guide turn as one; the block's own centre is its pin.
        links["guide"] = MovingLink(o, guide, 0.0, self.guide_body)
        links["slider"] = MovingLink(b, guide, 0.0, self.slider_body)
        ends = block(b, guide, self._length)
        return Chain(
            points={"O": o, "A": a, "B": b, **self._rail(o, guide), **ends},
            links=links,
            coordinates={"slide": _Slide(guide)},
            dyads=(guide,),
            bars=(bar, *self._arm),
            grounded=grounded,
            actuated=("A",),
            traced=traced,
            rails=(RAIL,),
            blocks=((*BLOCK, "B"),),
        )

    @property
    def _length(self):
        """Of what is drawn of the guide."""
        return self.crank + self.rod + abs(self.offset)

    @property
    def _arm(self):
        """What holds a moving rail beside O."""
        return (("O", RAIL[0]),) if is_symbolic(self.offset) or self.offset else ()

    def _rail(self, origin, heading):
        """Return the ends of a moving guide."""
        ends = (-0.3 * self._length, self._length)
        return {name: Reach(origin, heading, along, self.offset) for name, along in zip(RAIL, ends)}

    def crank_limits(self, branch: Any) -> list[float]:
        """Return angles of the driven link, rad, at which the dyad is singular."""
        if self.held == "guide":
            return guide_limits(self.crank, self.rod, self.offset)
        if self.held == "slider":
            return guide_limits(self.rod, self.crank, -self.offset)
        # |OB|^2 = (crank - rod)^2 + 2 crank rod (1 + cos q) with the crank held, - cos q with the
        # rod held: >= offset^2
        near = (self.offset**2 - (self.crank - self.rod) ** 2) / (2 * self.crank * self.rod)
        return ends_of(math.pi if self.held == "crank" else 0.0, near, 0.0)


class _Slide:
    """The block's way along a turning guide as a coordinate."""

    def __init__(self, guide):
        self.guide = guide

    p = property(lambda self: self.guide.slide)
    v = property(lambda self: self.guide.slide_rate)
    a = property(lambda self: self.guide.slide_acceleration)


def block(pin: Point, heading: Heading, length: float) -> dict[str, Reach]:
    """Return the ends of a sliding block."""
    return {name: Reach(pin, heading, along * length) for name, along in zip(BLOCK, (-0.06, 0.06))}
