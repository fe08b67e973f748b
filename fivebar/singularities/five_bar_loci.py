"""Singularity loci of a five-bar in closed form: curves of the end-effector and of the active
joints.

Bars in line make the five-bar a four-bar, base + r2 e2 = r1 e1 + c u in unit vectors e1, e2
(cranks) and u (coupler): Type 2 is the four-bar with coupler l12 + l22 (stretched) or |l12 - l22|
(folded), Type 1 of a leg the one in which this leg is a single crank of length l1 + l2 or |l1 -
l2|. Points and unit vectors are complex numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base.backend import EPS, pairs
from ..models.robots import FiveBar
from .four_bar_motion import FourBarMotion, Turning, aligned, closures
from .leg_circles import LegCircles
from .locus import MODES, Locus, TypeThree, Vertex, modes_of, pieces_of, type_of, values_of
from .margins import Singularity

# Of the size: as far a touching point can be from where it is computed, which is a double root.
NEAR = 1e-6
# Pieces of a smaller share of their curve's parameter are one point: rounding error divided them.
SHORTEST = 1e-7


@dataclass(frozen=True, eq=False)
class CouplerCurve:
    """A robot moving with bars in line; bars: for u11, u12, u21, u22 which of (e1, e2, u) it is,
    and its sign.
    """

    robot: FiveBar
    motion: FourBarMotion | Turning
    bars: tuple

    def _bars(self, t, count=4):
        """Return unit vectors u11, u12, u21, u22, or the first of them, and their rates."""
        directions, rates = self.motion(t)
        return [sign * directions[k] for k, sign in self.bars[:count]], [
            rates[k] for k, _ in self.bars[:count]
        ]

    def task(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Position x + i y of the end-effector and its derivative."""
        robot = self.robot
        (u11, u12), (rate1, rate2) = self._bars(t, 2)
        proximal = robot.l11 * u11
        distal = robot.l12 * u12
        return -robot.d / 2 + proximal + distal, 1j * (proximal * rate1 + distal * rate2)

    def joint(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return active angles q1 + i q2 in (-pi, pi] and their derivatives."""
        (u11, _, u21, _), (rate1, _, rate2, _) = self._bars(t)
        return np.angle(u11) + 1j * np.angle(u21), rate1 + 1j * rate2

    def sines(self, t: np.ndarray) -> np.ndarray:
        """sin q12, sin q22 and det A."""
        (u11, u12, u21, u22), _ = self._bars(t)
        return np.array([(u11.conj() * u12).imag, (u21.conj() * u22).imag, (u12.conj() * u22).imag])

    @cached_property
    def aligned(self) -> list[float]:
        """Values of t at which a leg, or both, are in line."""
        return sorted(aligned(self.motion))

    @cached_property
    def edges(self) -> np.ndarray:
        """Values of t between which the modes do not change; first and last are the same pose."""
        period = self.motion.period
        cuts: list[float] = []
        for t in self.aligned:
            if not cuts or t - cuts[-1] > SHORTEST * period:
                cuts.append(t)
        if len(cuts) > 1 and cuts[0] + period - cuts[-1] <= SHORTEST * period:
            cuts.pop()
        return np.array([*cuts, cuts[0] + period] if cuts else [0.0, period])

    @cached_property
    def _in_line(self):
        """Per leg, at the edges: +1 where it is stretched, -1 where it is folded, 0 where it is not
        in line.
        """
        bars, _ = self._bars(self.edges)
        cosines = [u1.conj() * u2 for u1, u2 in (bars[:2], bars[2:])]
        return [
            np.where(np.abs(each.imag) <= SHORTEST, np.sign(each.real), 0).astype(int)
            for each in cosines
        ]

    @cached_property
    def corners(self) -> np.ndarray:
        """The end-effector at the edges, from the leg in line there: within its reach to the last
        digits.
        """
        (bars, _), xi = self._bars(self.edges), self.task(self.edges)[0]
        for drive, bar, u1, sides in zip(
            self.robot.drives, self.robot.distal, bars[::2], self._in_line
        ):
            xi = np.where(sides == 0, xi, drive.x + (drive.length + sides * bar) * u1)
        return xi

    def vertices(self, shared: list[Vertex], near: float) -> list[Vertex]:
        """At the edges; where both legs are in line, or one is folded on its base joint, one of
        those that are shared.

        near: m, how far that may be from where it is computed.
        """
        found = []
        for z, *sides in zip(self.corners[:-1], *self._in_line):
            circles = tuple((leg, side) for leg, side in enumerate(sides) if side)
            same = [v for v in shared if v.circles == circles and abs(v.z - z) <= near]
            found.append(same[0] if same else Vertex(complex(z), circles))
        return [*found, found[0]]

    @cached_property
    def modes(self) -> np.ndarray:
        """Signs (pieces, 3) of the working modes and the assembly mode on the pieces, 0 where in
        line all along.
        """
        sines = self.sines((self.edges[:-1] + self.edges[1:]) / 2)
        return -np.where(np.abs(sines) <= 64 * EPS, 0, np.sign(sines)).astype(int).T


@dataclass(frozen=True, eq=False)
class FiveBarLoci:
    """All singularity loci of a robot, each space traced when first read.

    task, joint: tuples of Locus; type3: the points where a locus changes its modes; everywhere:
    working modes that are Type 2 in every pose (coaxial motors and equal legs: the legs coincide).
    """

    robot: FiveBar

    @cached_property
    def _chains(self):
        """(kind, CouplerCurve) of the two sides of Type 2, self-motions included."""
        return [chain for side in (-1, 1) for chain in distal_chains(self.robot, side)]

    @cached_property
    def everywhere(self) -> tuple:
        differences = self.robot.d, self.robot.l11 - self.robot.l21, self.robot.l12 - self.robot.l22
        if max(map(abs, differences)) <= 8 * EPS * self.circles.scale:
            return ((1, 1), (-1, -1))
        return ()

    @cached_property
    def circles(self) -> LegCircles:
        """Type 1 in task space."""
        return LegCircles(self.robot)

    @property
    def touches(self) -> tuple[Vertex, ...]:
        return self.circles.touches

    @cached_property
    def task(self) -> tuple[Locus, ...]:
        pieces = [*self.circles.pieces]
        for kind, chain in self._chains:
            if kind == "self-motion" and self.everywhere:
                continue  # it fills the plane
            label = [
                (type_of(m[:2], Singularity.PARALLEL), kind, modes_of(m[:2]), ())
                for m in chain.modes
            ]
            if chain.aligned:
                vertices = chain.vertices(self.touches, NEAR * self.circles.scale)
            else:
                vertices = None
            pieces += pieces_of(
                chain.task, chain.edges, label, self.circles.scale, chain.corners, vertices=vertices
            )
        return tuple(pieces)

    @cached_property
    def joint(self) -> tuple[Locus, ...]:
        pieces = []
        for leg in (0, 1):
            for side in (1, -1):
                kind = f"{('left', 'right')[leg]} {'stretched' if side > 0 else 'folded'}"
                for chain in _serial_chains(self.robot, leg, side):
                    label = []
                    for m in chain.modes:
                        if leg == 0:
                            working = [0, m[1]]
                        else:
                            working = [m[0], 0]
                        label.append(
                            (
                                type_of(m[2:], Singularity.SERIAL),
                                kind,
                                modes_of(working),
                                values_of(m[2]),
                            )
                        )
                    pieces += pieces_of(chain.joint, chain.edges, label, 2 * np.pi, angles=True)
        for kind, chain in self._chains:
            label = [
                (type_of(m[:2], Singularity.PARALLEL), kind, modes_of(m[:2]), (1, -1))
                for m in chain.modes
            ]
            if kind == "self-motion" and not self.everywhere:
                modes = {mode for each in label for mode in each[2]}
                working = tuple(mode for mode in MODES if mode in modes)
                label = [(Singularity.PARALLEL, kind, working, (1, -1))]
                pieces += pieces_of(
                    chain.joint, chain.edges[[0, -1]], label, 2 * np.pi, angles=True
                )
            else:
                pieces += pieces_of(chain.joint, chain.edges, label, 2 * np.pi, angles=True)
        return tuple(pieces)

    @cached_property
    def type3(self) -> TypeThree:
        xi = [np.empty((0, 2))]
        q = [np.empty((0, 2))]
        working = [np.empty((0, 2), dtype=int)]
        for kind, chain in self._chains:
            if chain.aligned and not (kind == "self-motion" and self.everywhere):
                t = chain.edges[:-1]
                sines = chain.sines(t)[:2].T
                xi.append(pairs(chain.corners[:-1]))
                q.append(pairs(chain.joint(t)[0]))
                signs = np.where(np.abs(sines) <= 1e-7, 0, np.sign(sines))
                working.append(-signs.astype(int))
        return TypeThree(*map(np.concatenate, (xi, q, working)))


def distal_chains(
    robot: FiveBar, side: int, det_A: float = 0.0, sign: int = 1
) -> list[tuple[str, CouplerCurve]]:
    """Return (kind, CouplerCurve) of the motions in which det A is sign det_A: of 0 Type 2, self-
    motions included.

    side: of the distal bars, 1 where they lie back on each other, -1 where they go on in line,
        turned from there.
    """
    cosine = math.sqrt((1 - det_A) * (1 + det_A))
    turn = complex(side * cosine, sign * det_A)
    # The way between the elbows, l12 - l22 exp(i theta), without the cancellation of a small angle.
    along = robot.l12 + robot.l22 * cosine
    if side > 0:
        along = robot.l12 - robot.l22 + robot.l22 * det_A * det_A / (1 + cosine)
    elbows = complex(along, -sign * robot.l22 * det_A)
    apart = abs(elbows)
    kind = "folded" if side > 0 else "stretched"
    if apart <= 8 * EPS * (robot.l12 + robot.l22):
        apart = 0.0
        elbows = complex(1.0)
        kind = kind if det_A else "self-motion"
    first = elbows.conjugate() / abs(elbows)
    bars = (0, 1), (2, first), (1, 1), (2, first * turn)
    kind += f" {'+' if sign > 0 else '-'}" if det_A else ""
    return [
        (kind, CouplerCurve(robot, each, bars))
        for each in closures(robot.d, robot.l11, apart, robot.l21)
    ]


def _serial_chains(robot, leg, side):
    """Chains in which a leg is in line, stretched (side 1) or folded (-1), and the other leg
    closes.
    """
    proximal, distal, other1, other2 = (
        (robot.l11, robot.l12, robot.l21, robot.l22)
        if leg == 0
        else (robot.l21, robot.l22, robot.l11, robot.l12)
    )
    reach = proximal + side * distal
    sign = -1 if reach < 0 else 1
    if leg == 0:
        motions = closures(robot.d, abs(reach), other2, other1)
        bars = ((0, sign), (0, side * sign), (1, 1), (2, -1))
    else:
        motions = closures(robot.d, other1, other2, abs(reach))
        bars = ((0, 1), (2, 1), (1, sign), (1, side * sign))
    return [CouplerCurve(robot, motion, bars) for motion in motions]
