"""Arcs of curves on which all is known: ellipses, a curve with three petals, and polygons."""

import numpy as np

from fivebar.base.backend import pairs
from fivebar.singularities.locus import Locus, pieces_of
from fivebar.singularities.margins import Singularity
from fivebar.singularities.regions import LocusArc

LABEL = Singularity.NONE, "", (), ()
TURN = 2 * np.pi


def arcs(curve, cuts, scale, circle=()):
    """The curve's arcs between cuts."""
    pieces = pieces_of(
        curve, np.array(cuts, dtype=float), [LABEL] * (len(cuts) - 1), scale, circle=circle
    )
    return tuple(LocusArc(piece, *piece.interval) for piece in pieces)


def ellipse(a, b, center=0.0, cuts=(0, TURN), circle=()):
    """Counterclockwise, by its eccentric angle."""

    def curve(t):
        return center + a * np.cos(t) + 1j * b * np.sin(t), -a * np.sin(t) + 1j * b * np.cos(t)

    return arcs(curve, cuts, max(a, b), circle)


def petals(size, cuts=(0, TURN)):
    """|z| = size (1 + 0.6 cos 3 t), t the angle of z."""

    def curve(t):
        r, dr = size * (1 + 0.6 * np.cos(3 * t)), -1.8 * size * np.sin(3 * t)
        return r * np.exp(1j * t), (dr + 1j * r) * np.exp(1j * t)

    return arcs(curve, cuts, size)


def polygon(*corners):
    """Its sides, from 0 to 1 each."""

    def side(a, b):
        def curve(t):
            return a + t * (b - a), np.full(np.shape(t), complex(b - a))

        return arcs(curve, (0, 1), abs(b - a))[0]

    return tuple(side(complex(a), complex(b)) for a, b in zip(corners, (*corners[1:], corners[0])))


def backwards(loop):
    """A loop run through the other way, so that it bounds a hole."""
    return tuple(arc.reversed for arc in reversed(loop))


def uneven_circle(seed):
    """The unit circle by samples at most 1 degree apart, not evenly."""
    steps = np.random.default_rng(seed).uniform(0.1, 1.0, 800)
    t = np.append(0, np.cumsum(steps / steps.sum() * TURN))

    def curve(t):
        return np.exp(1j * t), 1j * np.exp(1j * t)

    return LocusArc(Locus(*LABEL, pairs(np.exp(1j * t)), t, True, curve), 0.0, TURN)
