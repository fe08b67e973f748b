"""Parameter sets of robots: frozen, self-validating, named by their source."""

import math
from dataclasses import dataclass, fields

from .dyads import Crank


def must_close(what, lengths):
    """Refuse sides (name -> m) of a closed chain of which one is longer than all others together."""
    longest = max(lengths, key=lengths.get)
    others = [name for name in lengths if name != longest]
    total = sum(lengths[name] for name in others)
    if lengths[longest] > total:
        raise ValueError(
            f"this {what} can never close: {longest} = {lengths[longest]:g} m is longer than "
            f"{' + '.join(others)} = {total:g} m, by {lengths[longest] - total:.6g} m"
        )


@dataclass(frozen=True)
class FiveBar:
    """Planar five-bar robot 2-RRR with motors at the base joints (-d/2, 0) and (d/2, 0).

    l11, l12: proximal and distal bar of the left leg, l21, l22: of the right leg, d: distance of the base joints, m;
    zz1, zz2: grouped inertias of the proximal bars, kg m^2; m: grouped mass of the end-effector, kg.
    The default is the AMORO lab's robot. Raises ValueError for a value that no such robot can have.
    """

    l11: float = 0.09
    l12: float = 0.09
    l21: float = 0.09
    l22: float = 0.09
    d: float = 0.118
    zz1: float = 0.002
    zz2: float = 0.002
    m: float = 0.5

    def __post_init__(self):
        for f in fields(self):
            value = getattr(self, f.name)
            try:
                number = math.nan if isinstance(value, bool) else float(value)
            except (TypeError, ValueError):
                raise ValueError(f"{f.name} must be a number, not {value!r}") from None
            is_bar = f.name.startswith("l")
            if not math.isfinite(number) or number < 0 or (is_bar and number == 0):
                raise ValueError(f"{f.name} must be finite and {'> 0' if is_bar else '>= 0'}, not {number:g}")
            object.__setattr__(self, f.name, number)
        must_close("robot", {name: getattr(self, name) for name in ("l11", "l12", "l21", "l22", "d")})

    @property
    def drives(self):
        """The left and right drive."""
        return Crank(-self.d / 2, 0.0, self.l11), Crank(self.d / 2, 0.0, self.l21)

    @property
    def distal(self):
        """Lengths of the two bars that meet in the end-effector, m."""
        return self.l12, self.l22

    @property
    def inertias(self):
        """Grouped inertias of the two drives."""
        return self.zz1, self.zz2


@dataclass(frozen=True)
class NamedRobot:
    """A robot with the place its numbers come from; inertias are 0 where the source gives none."""

    robot: FiveBar
    source: str


def _symmetric(proximal, distal, half_base):
    return FiveBar(proximal, distal, proximal, distal, 2 * half_base, 0, 0, 0)


_LIU = "Liu, Wang, Pritschow 2006, Mech. Mach. Theory 41, lengths without unit: r1, r2, r3 = {}, {}, {}"
_LIU_SETS = [
    (1.2, 1.0, 0.8),
    (0.8125, 0.9375, 1.25),
    (0.7, 1.7, 0.6),
    (1.17, 1.45, 0.38),
    (1.5, 1.5, 0),
    (0.4, 2.33, 0.27),
]

ROBOTS = {
    "amoro": NamedRobot(FiveBar(), "AMORO lab handout, Ecole Centrale de Nantes, 2021"),
    "amoro-files": NamedRobot(FiveBar(zz1=0.002025, zz2=0.002025), "the AMORO lab's own files, zz = 1.0 * 0.045^2"),
    "hoang-2015": NamedRobot(_symmetric(0.07, 0.2, 0.125), "Hoang, Vuong, Pham 2015: no Type-2 singularity anywhere"),
    **{f"liu-2006-{letter}": NamedRobot(_symmetric(*r), _LIU.format(*r)) for letter, r in zip("abcdef", _LIU_SETS)},
}
