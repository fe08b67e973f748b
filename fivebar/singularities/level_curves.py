"""Curves on which the distal bars make a given angle: det A = sin of it is constant there, and not
0 but for Type 2.

The angle theta fixes the distance of the elbows, l12 u12 - l22 u22 = u12 (l12 - l22 exp(i theta)),
so the curve is that of a four-bar's coupler, for any lengths: |det A| = k has theta = +-psi and pi
+- psi, psi = asin k, and Type 2 is their limit. In one working mode theta is a function of the
place, so that curves of two angles never meet; one curve meets itself where the proximal bars and
the way between the elbows are in line.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from itertools import product

import numpy as np

from ..base.backend import EPS
from ..models.robots import FiveBar
from .five_bar_loci import NEAR, SHORTEST, CouplerCurve, distal_chains
from .four_bar_motion import Turning
from .leg_circles import LegCircles
from .locus import Locus, Vertex, pieces_of
from .margins import Singularity

# Of the robot's size: as far a corner of two circles may be from the curve that passes there.
SAME = 1e-12


@dataclass(frozen=True, eq=False)
class LevelCurves:
    """The curves of |det A| = det_A, in a working mode as far as the legs' circles."""

    robot: FiveBar
    det_A: float
    circles: LegCircles
    nodes: dict = field(default_factory=dict)  # vertices at which a curve meets itself, by its kind

    @cached_property
    def chains(self) -> tuple[tuple[str, CouplerCurve], ...]:
        """(kind, curve) of all angles: "folded +" has its distal bars side by side and det A > 0,
        and so on.
        """
        k = self.det_A
        found = [
            chain
            for side, sign in product((1, -1), (1, -1) if k else (1,))
            for chain in distal_chains(self.robot, side, k, sign)
        ]
        return tuple((kind, chain) for kind, chain in found if not (k and _extreme(chain.motion)))

    def pieces(self, working: tuple[int, int]) -> list[Locus]:
        """Return those of a working mode, from circle to circle."""
        return [
            piece for kind, chain in self.chains for piece in self._of_chain(kind, chain, working)
        ]

    def _of_chain(self, kind, chain, working):
        t, vertices = self._cuts(kind, chain, working)
        period = chain.motion.period
        spans = [(0.0, period)]
        ends = [()]
        if t:
            spans = [*zip(t, [*t[1:], t[0] + period])]
            ends = [*zip(vertices, [*vertices[1:], vertices[0]])]
        bars, _ = chain._bars(np.array([(low + high) / 2 for low, high in spans]))
        inside = np.ones(len(spans), dtype=bool)
        for leg, mode in enumerate(working):
            turn = bars[2 * leg].conj() * bars[2 * leg + 1]
            stretched = self._turn(working, leg, 1)
            folded = self._turn(working, leg, -1)
            for margin in (turn, stretched.conjugate() * turn, turn.conj() * folded):
                inside &= -mode * margin.imag > 64 * EPS
        type_ = Singularity.NONE if self.det_A else Singularity.PARALLEL
        label = type_, kind, (working,), ()
        pieces = []
        for k in np.flatnonzero(inside):
            corners = list(ends[k])
            pieces += pieces_of(
                chain.task,
                np.array(spans[k]),
                [label],
                self.circles.scale,
                np.array([v.z for v in corners]) if corners else None,
                vertices=corners,
                period=period,
            )
        return [piece for piece in pieces if len(piece.points) > 1]

    def _cuts(self, kind, chain, working):
        """Return parameters at which a curve comes to a circle or passes itself, and their
        vertices.
        """
        found = [(t, ()) for t in chain.motion.flat]
        circles = list(product((0, 1), (1, -1)))
        ways = [
            (leg, self._turn(working, leg, side) / chain.bars[1::2][leg][1])
            for leg, side in circles
        ]
        found += [
            (each, circle) for circle, own in zip(circles, chain.motion.meets(ways)) for each in own
        ]
        if not found:
            return [], []
        found.sort()
        t = np.array([each for each, _ in found])
        period = chain.motion.period
        places = self._places(chain, t, [circle for _, circle in found], working)
        groups = []
        for k in range(len(found)):
            before = groups[-1] if groups else None
            if before and self._one(found, places, before[0], k, period):
                before.append(k)
            else:
                groups.append([k])
        if len(groups) > 1 and self._one(found, places, groups[0][0], groups[-1][-1], period):
            groups[0] += groups.pop()
        vertices = []
        for group in groups:
            circles = {found[k][1] for k in group} - {()}
            vertices.append(self._vertex(kind, places[group[0]], circles))
        return [float(t[g[0]]) for g in groups], vertices

    def _turn(self, working, leg, side):
        """By what the distal bar of a leg is turned against the proximal one on that circle."""
        cosine, sine = self.circles.bend(leg, side)
        return complex(side * cosine, -working[leg] * sine)

    def _one(self, found, places, k, m, period):
        """Return whether two cuts are one: a circle that is touched, or the corner of two."""
        apart = (found[m][0] - found[k][0] + period / 2) % period - period / 2
        if found[k][1] == found[m][1]:
            return abs(apart) <= SHORTEST * period
        return (
            abs(apart) <= 1e-3 * period and abs(places[k] - places[m]) <= SAME * self.circles.scale
        )

    def _places(self, chain, t, circles, working):
        """Return the end-effector there, from the leg that is on its circle: within its reach to
        the last digits.
        """
        z, (bars, _) = chain.task(t)[0], chain._bars(t)
        for k, circle in enumerate(circles):
            if circle:
                leg, side = circle
                drive = self.robot.drives[leg]
                bar = self.robot.distal[leg]
                z[k] = drive.x + bars[2 * leg][k] * (
                    drive.length + bar * self._turn(working, leg, side)
                )
        return z

    def _vertex(self, kind, z, circles):
        circles = tuple(sorted(circles))
        if not circles:
            shared = self.nodes.setdefault(kind, [])
        else:
            shared = [v for v in self.corners if v.circles == circles]
        for vertex in shared:
            if abs(vertex.z - z) <= NEAR * self.circles.scale:
                return vertex
        found = Vertex(complex(z), circles)
        if not circles:
            shared.append(found)
        return found

    @cached_property
    def corners(self) -> tuple[Vertex, ...]:
        """Vertices of the circles: where two cross or touch, and those of no radius."""
        ends = {vertex for piece in self.circles.pieces for vertex in piece.vertices}
        return (*self.circles.touches, *ends)


def _extreme(motion):
    """Return whether the robot turns as a whole with its elbows as far apart as they can be, or as
    near: all around det A is on one side of what it is there.
    """
    return (
        isinstance(motion, Turning)
        and all(motion.turns)
        and all(complex(e).imag == 0 for e in motion.start)
    )
