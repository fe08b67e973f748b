"""`repeatability`: pose accuracy and repeatability from repeated measurements, as ISO 9283 defines
them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...base.backend import finite_numbers
from ...base.checks import shown
from ...base.presentation import Plotted
from ...base.representation import aligned, one_line

if TYPE_CHECKING:
    pass

CYCLES = 30  # that the standard asks for at each pose


@dataclass(frozen=True, eq=False)
class Repeatability(Plotted):
    """Accuracy and repeatability at poses that were visited many times; printed, it is a report.

    points (poses, n, 2) m: attained; commanded (poses, 2) m, or None. All lengths in m.
    """

    points: np.ndarray
    commanded: np.ndarray | None = None

    def __repr__(self) -> str:
        poses, n = self.points.shape[:2]
        return one_line(
            "Repeatability", f"{poses} poses", f"{n} cycles", f"RP = {1e3 * self.RP.max():.4g} mm"
        )

    @cached_property
    def barycentre(self) -> np.ndarray:
        """(poses, 2) mean attained point."""
        return self.points.mean(axis=1)

    @cached_property
    def distances(self) -> np.ndarray:
        """(poses, n) of the attained points to their barycentre."""
        return np.hypot(*np.moveaxis(self.points - self.barycentre[:, None], 2, 0))

    @cached_property
    def mean(self) -> np.ndarray:
        """(poses,) mean of the distances."""
        return self.distances.mean(axis=1)

    @cached_property
    def sd(self) -> np.ndarray:
        """(poses,) standard deviation of the distances, with n - 1."""
        return self.distances.std(axis=1, ddof=1)

    @cached_property
    def RP(self) -> np.ndarray:
        """(poses,) repeatability: mean + 3 sd of the distances."""
        return self.mean + 3 * self.sd

    @cached_property
    def AP(self) -> np.ndarray | None:
        """(poses,) accuracy: from the commanded point to the barycentre; None where nothing was
        commanded.
        """
        return None if self.commanded is None else np.hypot(*(self.barycentre - self.commanded).T)

    def __str__(self) -> str:
        head = ["pose", "x mean (mm)", "y mean (mm)", "mean dist. (mm)", "sd (mm)", "RP (mm)"]
        columns = [
            np.arange(1, len(self.points) + 1),
            *(1e3 * self.barycentre.T),
            *(1e3 * v for v in self._figures),
        ]
        if self.AP is not None:
            head.append("AP (mm)")
            columns.append(1e3 * self.AP)
        text = aligned(
            [head, *([f"{row[0]:.0f}", *(f"{v:.4f}" for v in row[1:])] for row in zip(*columns))], 0
        )
        text.append(
            f"worst RP {1e3 * self.RP.max():.4f} mm, mean + 3 sd of the distances to the barycentre"
            " (ISO 9283)"
        )
        if self.points.shape[1] < CYCLES:
            text.append(
                f"{self.points.shape[1]} cycles at a pose, where the standard asks for {CYCLES}"
            )
        return "\n".join(text)

    @property
    def _figures(self):
        return self.mean, self.sd, self.RP


def repeatability(points: ArrayLike, commanded: ArrayLike | None = None) -> Repeatability:
    """Accuracy and repeatability of points attained again and again: RP = mean + 3 sd of the
    distances to their barycentre, AP = distance of the barycentre from the commanded point (ISO
    9283:1998, 7.2).

    points: (n, 2) at one pose or (poses, n, 2), m, n >= 2; commanded: (2,) or (poses, 2), m.
    """
    found = finite_numbers(points, "points")
    if found.ndim not in (2, 3) or found.shape[-1] != 2 or found.shape[-2] < 2 or not len(found):
        raise ValueError(
            f"points must have shape (n, 2) or (poses, n, 2) with n >= 2, not {found.shape}"
        )
    found = found if found.ndim == 3 else found[None]
    if commanded is None:
        return Repeatability(found)
    target = np.atleast_2d(finite_numbers(commanded, "commanded"))
    if target.shape != (len(found), 2):
        raise ValueError(
            f"commanded must be one point for each of the {len(found)} poses in points, not"
            f" {shown(commanded)}"
        )
    return Repeatability(found, target)
