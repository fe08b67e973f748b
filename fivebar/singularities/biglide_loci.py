"""Singularity loci of a biglide in closed form: lines without ends, as nothing changes along its
guides.

Every singular pose is given by the directions u1, u2 of the bars, unit complex numbers, up to a
shift y of the whole
robot: xi = -d/2 + l1 Re(u1) + i y, q2 - q1 = l1 Im(u1) - l2 Im(u2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base.backend import EPS, pairs
from ..models.robots import Biglide
from .locus import MODES, Locus, TypeThree, modes_of, type_of, values_of
from .margins import Singularity

FLAT = 8 * EPS  # a squared sine up to this is 0


@dataclass(frozen=True)
class LocusLine:
    """Points start + t direction, and their derivative: what `Locus` follows."""

    start: complex
    direction: complex

    def __call__(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.start + t * self.direction, self.direction + 0.0 * t


@dataclass(frozen=True, eq=False)
class BiglideLoci:
    """All singularity loci of a biglide.

    task: lines along y, by y; joint: lines q2 - q1 = constant, by q1; each a tuple of unbounded
    Locus. type3: without points, as in a line of Type 3 all of it is. everywhere: working modes
    that are Type 2 in every pose (d = 0 and
    equal bars: the legs coincide).
    """

    robot: Biglide

    @cached_property
    def _families(self):
        """(kind, own type, u1, u2) of all singular poses."""
        (l1, l2), d, families = self.robot.distal, self.robot.d, []
        bases = -d / 2, d / 2
        for leg, towards in ((0, 1), (1, -1)):
            for side, way in ((1, "inward"), (-1, "outward")):
                own = complex(side * towards)
                other = 1 - leg
                reached = bases[leg] + own.real * (l1, l2)[leg] - bases[other]
                for u in _directions(reached, (l1, l2)[other]):
                    if leg == 0:
                        bars = (own, u)
                    else:
                        bars = (u, own)
                    families.append((f"{('left', 'right')[leg]} {way}", Singularity.SERIAL, *bars))
        for kind, reach, side in (("stretched", l1 + l2, -1), ("folded", l1 - l2, 1)):
            if abs(reach) > 8 * EPS * (l1 + l2):
                families += [
                    (kind, Singularity.PARALLEL, u, side * u) for u in _directions(d, reach)
                ]
        return families

    @property
    def everywhere(self) -> tuple:
        size = sum(self.robot.distal) + self.robot.d
        l1, l2 = self.robot.distal
        if max(self.robot.d, abs(l1 - l2)) <= 8 * EPS * size:
            return ((1, 1), (-1, -1))
        return ()

    @cached_property
    def task(self) -> tuple[Locus, ...]:
        found: dict[str, tuple] = {}  # those of a kind are on one line
        for kind, own, u1, u2 in self._families:
            modes = _signs(u1, u2)
            line = LocusLine(complex(-self.robot.d / 2 + self.robot.l1 * u1.real), 1j)
            if own == Singularity.SERIAL:
                working = MODES
            else:
                working = modes_of(modes[:2])
            found.setdefault(kind, (_type(own, modes), set(), line))[1].update(working)
        lines = []
        for kind, (type_, active, line) in found.items():
            working = tuple(mode for mode in MODES if mode in active)
            lines.append(self._line(type_, kind, working, (), line))
        return tuple(lines)

    @cached_property
    def joint(self) -> tuple[Locus, ...]:
        pieces = []
        for kind, own, u1, u2 in self._families:
            s1, s2, s = modes = _signs(u1, u2)
            along = own == Singularity.PARALLEL
            assembly = (1, -1) if along else values_of(s)
            line = LocusLine(1j * (self.robot.l1 * u1.imag - self.robot.l2 * u2.imag), 1 + 1j)
            pieces.append(self._line(_type(own, modes), kind, modes_of((s1, s2)), assembly, line))
        if self.everywhere:
            pieces.append(
                self._line(
                    Singularity.PARALLEL,
                    "self-motion",
                    self.everywhere,
                    (1, -1),
                    LocusLine(0j, 1 + 1j),
                )
            )
        return tuple(pieces)

    def _line(self, type_, kind, working, assembly, line):
        parameters = np.array([-1.0, 1.0]) * sum(self.robot.distal)
        points = pairs(line(parameters)[0])
        return Locus(
            type_, kind, working, assembly, points, parameters, False, line, unbounded=True
        )

    @property
    def type3(self) -> TypeThree:
        return TypeThree(np.empty((0, 2)), np.empty((0, 2)), np.empty((0, 2), dtype=int))


def _directions(across, bar):
    """Return unit vectors of a bar (of negative length: turned round) that spans `across` between
    guides; none, one or two.
    """
    square = (1 - across / bar) * (1 + across / bar)
    if square < -FLAT:
        return []
    if square <= FLAT:
        return [complex(math.copysign(1.0, across / bar))]
    rise = math.sqrt(square)
    return [complex(across / bar, rise), complex(across / bar, -rise)]


def _signs(u1, u2):
    """Working modes of both legs and the assembly mode, 0 where singular."""
    sines = u1.imag, u2.imag, (u1.conjugate() * u2).imag
    signs = []
    for sine in sines:
        signs.append(0 if abs(sine) <= 64 * EPS else -int(math.copysign(1, sine)))
    return tuple(signs)


def _type(own, modes):
    """Type 3 where the bars are parallel and across the guides too."""
    return type_of(modes[2:] if own == Singularity.SERIAL else modes[:2], own)
