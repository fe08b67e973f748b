"""Parts of the workspace mirrored in the line of the base joints: with q -> -q both working modes
change, and det A.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from .locus import Locus, Vertex
from .regions import LocusArc

SAME = 1e-12  # of parameters of circles


class Mirror:
    """Images of what the loci bound. A circle's image is the same circle, where it is among the
    loci.
    """

    def __init__(self, loci: list[Locus]):
        self._circles = [locus for locus in loci if locus.circle]
        self._images: dict = {}

    def loops(self, boundary: tuple) -> tuple:
        """Return the loops of the image, with it on their left."""
        return tuple(tuple(map(self._arc, reversed(loop))) for loop in boundary)

    def _arc(self, arc):
        locus, total, sign = self._image(arc.locus)
        image = LocusArc(locus, total + sign * arc.end, total + sign * arc.start)
        image.__dict__.update(
            _samples=(total + sign * arc.s[::-1], arc.z[::-1].conj()), moment=arc.moment
        )
        return image

    def _image(self, locus):
        """Return the image of a locus, and by which parameter total + sign s it goes."""
        if id(locus) not in self._images:
            self._images[id(locus)] = self._of_circle(locus) or (_turned(locus), 0.0, 1)
        return self._images[id(locus)]

    def _of_circle(self, locus):
        low, high = locus.interval
        for other in self._circles:
            total = other.interval[0] + high
            if other.circle != locus.circle:
                continue
            mirrored = min(abs(total), abs(total - 2 * np.pi)) <= SAME
            if mirrored and abs(other.interval[1] + low - total) <= SAME:
                return other, total, -1
        return None


def _turned(locus):
    return replace(
        locus,
        working=tuple((-left, -right) for left, right in locus.working),
        points=locus.points * (1, -1),
        vertices=tuple(Vertex(vertex.z.conjugate(), vertex.circles) for vertex in locus.vertices),
        _curve=partial(_conjugate, locus._curve),
    )


def _conjugate(curve, t):
    return tuple(each.conjugate() for each in curve(t))
