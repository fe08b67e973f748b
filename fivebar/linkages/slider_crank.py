"""The slider-crank with offset: any of its four links held, on either branch."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..base.backend import EPS, is_symbolic
from .chain import Along, Fixed, Reach, Slot, Still, Turned, slide
from .checks import bodies, finite, sizes
from .limits import ends_of, guide_limits
from .motion import BLOCK, RAIL, Body, Chain, Link, one_drive

if TYPE_CHECKING:
    from .chain import Number

HELD = {
    "guide": "the slider-crank of engines and pumps; the crank is driven",
    "crank": (
        "the quick return of Whitworth and the rotary engine; the rod is driven, the guide turns"
    ),
    "rod": (
        "the oscillating cylinder; the crank is driven, the guide swings through a swivelling block"
    ),
    "slider": "the hand pump; the rod is driven, the guide slides",
}


@dataclass(frozen=True)
class SliderCrank:
    """Slider-crank O A B: crank OA, rod AB, slider B on the guide that passes O at `offset` to the
    left, all in m.

    held: the link that does not move: "guide", "crank", "rod" or "slider". branch +1: the slider is
    ahead along the guide of the rod's other end (guide held), of O (crank or rod held); with the
    slider held, O is ahead of A. Raises ValueError for lengths that cannot close.
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
        sizes(self, "crank", "rod")
        finite(self, "offset")
        bodies(self, Body, "crank_body", "rod_body", "slider_body", "guide_body")
        if not isinstance(self.held, str) or self.held not in HELD:
            raise ValueError(f"no link {self.held!r} to hold; the known ones are {', '.join(HELD)}")
        if abs(self.offset) > self.crank + self.rod:
            raise ValueError(
                f"this slider-crank can never close: offset = {abs(self.offset):g} m is more than"
                f" crank + rod = {self.crank + self.rod:g} m, by"
                f" {abs(self.offset) - self.crank - self.rod:.6g} m"
            )

    def chain(self, q: Number, branch: Number) -> Chain:
        return (
            self._on_fixed_guide if self.held in ("guide", "slider") else self._on_turning_guide
        )(q, branch)

    start = one_drive

    @property
    def flats(self) -> list[float]:
        """Angles of the driven link, rad, at which the dyad is singular without being a limit."""
        tolerance = 8 * EPS * (self.crank + self.rod)
        if self.held in ("guide", "slider"):
            driven, bar, e = (
                (self.crank, self.rod, self.offset)
                if self.held == "guide"
                else (self.rod, self.crank, -self.offset)
            )
            return [
                side * math.pi / 2
                for side in (1, -1)
                if abs(abs(e - side * driven) - bar) <= tolerance
            ]
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

    def _on_fixed_guide(self, q, branch):
        """RRP; with the slider held its guide moves along itself, so that O is what slides."""
        base, heading, length = Fixed((0.0, 0.0)), Turned(Still(), q), self._length
        if self.held == "guide":
            a = Reach(base, heading, self.crank)
            b, rod = slide(
                a,
                (0.0, self.offset),
                (1.0, 0.0),
                self.rod,
                branch,
                "the rod is perpendicular to the guide",
            )
            rail = {
                name: Fixed((along, self.offset))
                for name, along in zip(RAIL, (-0.3 * length, length))
            }
            points = {"O": base, "A": a, "B": b, **rail, **_block(b, Still(), length)}
            links = {
                "crank": Link(base, heading, self.crank, self.crank_body),
                "rod": Link(a, rod, self.rod, self.rod_body),
                "slider": Link(b, Still(), 0.0, self.slider_body),
            }
            ways = {"slide": Along(b, (0.0, self.offset), (1.0, 0.0))}
            bars, grounded, block = (("O", "A"), ("A", "B")), ("O", *RAIL), (*BLOCK, "B")
            return Chain(
                points, links, ways, (b.dyad,), bars, grounded, ("O",), "B", (RAIL,), (block,)
            )
        a = Reach(base, heading, self.rod)
        singular = "the crank is perpendicular to the guide"
        o, crank = slide(a, (0.0, -self.offset), (1.0, 0.0), self.crank, branch, singular)
        points = {"B": base, "A": a, "O": o, **self._rail(o, Still())}
        links = {
            "rod": Link(base, heading, self.rod, self.rod_body),
            "crank": Link(a, crank, self.crank, self.crank_body),
            "guide": Link(o, Still(), 0.0, self.guide_body),
        }
        ways = {"slide": Along(o, (0.0, -self.offset), (-1.0, 0.0))}
        bars = ("B", "A"), ("A", "O"), *self._arm
        return Chain(points, links, ways, (o.dyad,), bars, ("B",), ("B",), "O", (RAIL,))

    def _on_turning_guide(self, q, branch):
        """RPR: the guide turns about O and passes the block's pin B at the offset."""
        heading, base = Turned(Still(), q), Fixed((0.0, 0.0))
        if self.held == "crank":
            o, a = base, Fixed((self.crank, 0.0))
            b = Reach(a, heading, self.rod)
            links, grounded, traced = (
                {"rod": Link(a, heading, self.rod, self.rod_body)},
                ("A", "O"),
                "B",
            )
        else:
            a, b = base, Fixed((self.rod, 0.0))
            o = Reach(a, heading, self.crank)
            links, grounded, traced = (
                {"crank": Link(a, heading, self.crank, self.crank_body)},
                ("A", "B"),
                RAIL[1],
            )
        guide = Slot(o, b, self.offset, branch)
        points = {"O": o, "A": a, "B": b, **self._rail(o, guide), **_block(b, guide, self._length)}
        # Block and guide turn as one; the block's own centre is its pin.
        links |= {
            "guide": Link(o, guide, 0.0, self.guide_body),
            "slider": Link(b, guide, 0.0, self.slider_body),
        }
        bars = ("A", "B" if self.held == "crank" else "O"), *self._arm
        ways, block = {"slide": _Slide(guide)}, (*BLOCK, "B")
        return Chain(
            points, links, ways, (guide,), bars, grounded, ("A",), traced, (RAIL,), (block,)
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
        """The ends of a moving guide."""
        ends = (-0.3 * self._length, self._length)
        return {name: Reach(origin, heading, along, self.offset) for name, along in zip(RAIL, ends)}

    def crank_limits(self, branch: int) -> list[float]:
        """Angles of the driven link, rad, at which the dyad is singular."""
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


def _block(pin, heading, length):
    """The ends of a sliding block."""
    return {name: Reach(pin, heading, along * length) for name, along in zip(BLOCK, (-0.06, 0.06))}
