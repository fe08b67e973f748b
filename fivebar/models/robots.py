"""Parameter sets of robots: frozen, self-validating, named by their source."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, NamedTuple, Protocol

import numpy as np

from .._backend import is_symbolic, wrap
from ..checks import base, inertia, not_too_different, size
from .dyads import Crank, Slider


def must_close(what: str, lengths: dict[str, float]) -> None:
    """Refuse sides (name -> m) of a closed chain of which one is longer than all others together."""
    if not any(map(is_symbolic, lengths.values())):
        must_span(what, max(lengths, key=lengths.__getitem__), lengths)


def must_span(what: str, longest: str, lengths: dict[str, float]) -> None:
    """Refuse a side that is longer than all others together."""
    others = [name for name in lengths if name != longest]
    total = sum(lengths[name] for name in others)
    if lengths[longest] > total:
        raise ValueError(
            f"this {what} can never close: {longest} = {lengths[longest]:g} m is longer than "
            f"{' + '.join(others)} = {total:g} m, by {lengths[longest] - total:.6g} m"
        )


class Words(NamedTuple):
    """What the parts and quantities of a kind of robot are called, in messages, tables, files and pictures."""

    title: str
    joints: tuple  # active
    passive: tuple
    base: str  # where a drive is mounted
    pivots: str  # that the drives move
    unit: str  # of a joint coordinate
    effort: str  # of a drive
    effort_unit: str
    inertias: tuple

    @property
    def sines(self) -> tuple:
        """The margins of both legs' Type 1, and of Type 2."""
        return *(f"sin {angle}" for angle in self.passive), "det A"


FIVE_BAR = Words(
    "five-bar robot", ("q11", "q21"), ("q12", "q22"), "base joint", "elbows", "rad", "torque", "N m", ("zz1", "zz2")
)
BIGLIDE = Words("biglide robot", ("q1", "q2"), ("phi1", "phi2"), "guide", "feet", "m", "force", "N", ("mf1", "mf2"))


class Drive(Protocol):
    """What turns an active joint coordinate q into a pivot P(q) that moves; written on components (`dyads`).

    Where a text says rad of joint coordinates, m is meant of a drive that slides, and N of its torque in N m.
    """

    @property
    def length(self) -> float: ...  # |P'(q)|

    def direction(self, q): ...
    def coordinate(self, direction): ...
    def pivot(self, direction) -> tuple: ...
    def tangent(self, direction) -> tuple: ...
    def sine(self, direction, distal): ...
    def cosine(self, direction, distal): ...
    def slopes(self, sine, cosine) -> tuple: ...
    def bends(self, sine, cosine) -> tuple: ...
    def close(self, xi: tuple, bar: float, working): ...
    def relative(self, absolute, own): ...
    def absolute(self, passive, own): ...


class Robot(Protocol):
    """What every function here asks of a robot: two drives, and two distal bars that meet in the end-effector."""

    @property
    def m(self) -> float: ...  # grouped mass of the end-effector, kg
    @property
    def turns(self) -> bool: ...  # whether joint coordinates are angles
    @property
    def words(self) -> Words: ...
    @property
    def drives(self) -> tuple[Drive, Drive]: ...
    @property
    def distal(self) -> tuple[float, float]: ...
    @property
    def inertias(self) -> tuple[float, float]: ...
    def differ(self, difference: Any) -> Any: ...
    def continuous(self, q: np.ndarray) -> np.ndarray: ...


def beside(robot: Robot, q, before):
    """Joint coordinates q, which may jump by a turn, in the turn that is nearest to `before`."""
    difference = q - before
    return q - (difference - robot.differ(difference))


def _check_values(robot):
    """Make every field a float: lengths of bars > 0, all others >= 0, none so large or small that products fail."""
    for f in fields(robot):
        value = getattr(robot, f.name)
        if is_symbolic(value):
            if value.numel() == 1 and not value.is_constant():
                continue  # what a compiled function is told later
            if value.numel() == 1:
                value = float(value)  # CasADi's numbers are numbers
        if f.name.startswith("l"):
            value = size(value, f.name)
        elif f.name == "d":
            value = base(value, "d")
        else:
            value = inertia(value, f.name)
        object.__setattr__(robot, f.name, value)
    lengths = {f.name: getattr(robot, f.name) for f in fields(robot) if f.name[0] == "l"}
    if not any(map(is_symbolic, lengths.values())):
        not_too_different(lengths)


@dataclass(frozen=True)
class FiveBar:
    """Planar five-bar robot 2-RRR with motors at the base joints (-d/2, 0) and (d/2, 0).

    l11, l12: proximal and distal bar of the left leg, l21, l22: of the right leg, d: distance of the base joints, m;
    zz1, zz2: grouped inertias of the proximal bars, kg m^2; m: grouped mass of the end-effector, kg.
    The default is the AMORO lab's robot. Raises ValueError for a value that no such robot can have, and for lengths
    outside 1e-6 to 1e6 m (d: 0, or from 1e-12), bars in a ratio above 1e6, masses and inertias outside 1e-30 to 1e30
    (but 0): products of others overflow, underflow or lose their digits. CasADi symbols in place of numbers are taken
    as they are: what is made of such a robot is a function of them.
    """

    l11: float = 0.09
    l12: float = 0.09
    l21: float = 0.09
    l22: float = 0.09
    d: float = 0.118
    zz1: float = 0.002
    zz2: float = 0.002
    m: float = 0.5

    turns = True  # joint coordinates are angles
    words = FIVE_BAR

    def __post_init__(self):
        _check_values(self)
        must_close("robot", {name: getattr(self, name) for name in ("l11", "l12", "l21", "l22", "d")})

    @property
    def drives(self) -> tuple[Crank, Crank]:
        """The left and right drive."""
        return Crank(-self.d / 2, 0.0, self.l11), Crank(self.d / 2, 0.0, self.l21)

    @property
    def distal(self) -> tuple[float, float]:
        """Lengths of the two bars that meet in the end-effector, m."""
        return self.l12, self.l22

    @property
    def inertias(self) -> tuple[float, float]:
        """Grouped inertias of the two drives."""
        return self.zz1, self.zz2

    def differ(self, difference: Any) -> Any:
        """The difference of two joint coordinates: of angles the one within half a turn."""
        return wrap(difference)

    def continuous(self, q: np.ndarray) -> np.ndarray:
        """Joint coordinates (n, 2) along a motion, without the jumps of angles."""
        return np.unwrap(q, axis=0)


@dataclass(frozen=True)
class Biglide:
    """Planar biglide robot 2-PRR: two feet slide along y, on guides at x = -d/2 and x = d/2, and carry two bars.

    l1, l2: left and right bar, d: distance of the guides, m; mf1, mf2: masses of the feet, m: grouped mass of the
    end-effector, kg. The feet's coordinates q1, q2 are in m, the drives' forces in N. The guides have no ends.
    The default is the AMORO lab's robot. Raises ValueError for a value that no such robot can have, and outside the
    range of a FiveBar.
    """

    l1: float = 0.2828427
    l2: float = 0.2828427
    d: float = 0.4
    mf1: float = 1.0
    mf2: float = 1.0
    m: float = 3.0

    turns = False
    words = BIGLIDE

    def __post_init__(self):
        _check_values(self)
        lengths = {"l1": self.l1, "l2": self.l2, "d": self.d}
        if not any(map(is_symbolic, lengths.values())):
            must_span("robot", "d", lengths)

    @property
    def drives(self) -> tuple[Slider, Slider]:
        """The left and right drive."""
        return Slider(-self.d / 2, 0.0), Slider(self.d / 2, 0.0)

    @property
    def distal(self) -> tuple[float, float]:
        """Lengths of the two bars that meet in the end-effector, m."""
        return self.l1, self.l2

    @property
    def inertias(self) -> tuple[float, float]:
        """Masses of the two feet, the inertias of the drives."""
        return self.mf1, self.mf2

    def differ(self, difference: Any) -> Any:
        """The difference of two joint coordinates: lengths do not wrap."""
        return difference

    def continuous(self, q: np.ndarray) -> np.ndarray:
        """Joint coordinates (n, 2) along a motion: lengths do not jump."""
        return q


KINDS = FiveBar, Biglide


def parameters_of(robot: FiveBar | Biglide) -> list:
    """The robot's parameters in the order of its class."""
    return [getattr(robot, f.name) for f in fields(robot)]


def with_parameters(kind: type, p: Any) -> FiveBar | Biglide:
    """The robot of a kind with these parameters in the order of its class, a CasADi vector for instance."""
    return kind(**{f.name: p[k] for k, f in enumerate(fields(kind))})


def robot_of(parameters: dict[str, float]) -> FiveBar | Biglide:
    """The robot with these parameters {name: value}: of the first kind that has them all, ValueError if none has."""
    for kind in KINDS:
        if set(parameters) <= {f.name for f in fields(kind)}:
            return kind(**parameters)
    known = [f"{', '.join(f.name for f in fields(kind))} ({kind.words.title})" for kind in KINDS]
    unknown = min((sorted(set(parameters) - {f.name for f in fields(kind)}) for kind in KINDS), key=len)
    raise ValueError(f"no parameter {', '.join(unknown)}; the known ones are {' or '.join(known)}")


@dataclass(frozen=True)
class NamedRobot:
    """A robot with the place its numbers come from; inertias are 0 where the source gives none."""

    robot: FiveBar | Biglide
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
    "biglide": NamedRobot(Biglide(), "AMORO lab handout, Ecole Centrale de Nantes, 2021"),
    "hoang-2015": NamedRobot(_symmetric(0.07, 0.2, 0.125), "Hoang, Vuong, Pham 2015: no Type-2 singularity anywhere"),
    **{f"liu-2006-{letter}": NamedRobot(_symmetric(*r), _LIU.format(*r)) for letter, r in zip("abcdef", _LIU_SETS)},
}
