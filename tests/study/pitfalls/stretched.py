"""The height of a dyad's triangle as sqrt(l^2 - a^2), and what cancels in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fivebar.models.dyads import RRR

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


def printed_height(span: tuple[np.ndarray, np.ndarray], r1: float, r2: float) -> np.ndarray:
    """Height of the joint over the pivots' span: h = sqrt(l^2 - a^2), a the part of the span up to
    its foot.

    span: (x, y) arrays, m. AMORO eq. 2 (and 8), where a is half the span; here for any two bars.
    nan where l^2 - a^2 is rounded to below zero.
    """
    x, y = span
    if r1 == r2:
        a = np.sqrt((x / 2) ** 2 + (y / 2) ** 2)
    else:
        length = np.sqrt(x**2 + y**2)
        a = (length**2 + r1**2 - r2**2) / (2 * length)
    with np.errstate(invalid="ignore"):
        return np.sqrt(r1**2 - a**2)


def dyad_height(span: tuple[np.ndarray, np.ndarray], r1: float, r2: float) -> np.ndarray:
    """The same from the RRR dyad, a product of differences (Heron)."""
    dyad = RRR(span, r1, r2, 1)
    return dyad.sine * (r1 * r2) / np.sqrt(dyad.span_squared)


def spans(length: float, count: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """`count` spans (x, y) of this length, m, in directions all around (0.37 rad apart from the
    axes).
    """
    angle = 0.37 + np.linspace(0, 2 * np.pi, count, endpoint=False)
    return length * np.cos(angle), length * np.sin(angle)


@dataclass(frozen=True, eq=False)
class Stretched:
    """Heights (n, count) m by both methods at spans shorter than r1 + r2 by the shares `short`
    (n,).
    """

    short: np.ndarray
    spans: np.ndarray
    printed: np.ndarray
    dyad: np.ndarray


def stretch(r1: float, r2: float, short: ArrayLike, count: int = 400) -> Stretched:
    """Both heights as the bars are stretched. short: (n,), 0 for exactly stretched."""
    short = np.asarray(short, dtype=float)
    around = np.array([spans((r1 + r2) * (1 - s), count) for s in short])
    pairs = [
        (printed_height(tuple(span), r1, r2), dyad_height(tuple(span), r1, r2)) for span in around
    ]
    return Stretched(short, around, *(np.array(column) for column in zip(*pairs)))
