"""Crossings of singularities along a motion, as pictures mark them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..models.geometry import Pose


def crossings(t: np.ndarray, pose: Pose) -> Iterator[tuple[float, int, int, int, float]]:
    """(s, type, vanished sine, sample before, share of the way to the next) of each singularity
    between poses at t.
    """
    sines = np.stack([*pose.sines, pose.det_A], axis=1)
    known = np.isfinite(sines[:-1]) & np.isfinite(sines[1:])
    for k, margin in zip(
        *np.nonzero(known & np.diff(sines >= 0, axis=0))
    ):  # once, too, where a pose is on it
        share = sines[k, margin] / (sines[k, margin] - sines[k + 1, margin])
        yield (
            float(t[k] + share * (t[k + 1] - t[k])),
            2 if margin == 2 else 1,
            int(margin),
            int(k),
            float(share),
        )
