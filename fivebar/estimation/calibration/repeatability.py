"""`repeatability`: pose accuracy and repeatability from repeated measurements (ISO 9283)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy import ndarray
from numpy.typing import ArrayLike

from ...base.backend import finite_numbers
from ...base.checks import shown
from ...base.presentation import Plotted
from ...base.representation import aligned, one_line


@dataclass(frozen=True, eq=False)
class Repeatability(Plotted):
    """Accuracy and repeatability at poses that were visited many times; printed, it is a report.

    points (poses, n, 2) m: attained; commanded (poses, 2) m, or None. All lengths in m.
    """

    points: ndarray
    commanded: ndarray | None = None

    def __repr__(self) -> str:
        poses, n = self.points.shape[:2]
        return one_line(
            "Repeatability", f"{poses} poses", f"{n} cycles", f"RP = {1e3 * self.RP.max():.4g} mm"
        )

    @cached_property
    def barycentre(self) -> ndarray:
        """(poses, 2) mean attained point."""
        return self.points.mean(axis=1)

    @cached_property
    def distances(self) -> ndarray:
        """(poses, n) of the attained points to their barycentre."""
        return np.hypot(*np.moveaxis(self.points - self.barycentre[:, None], 2, 0))

    @cached_property
    def mean(self) -> ndarray:
        """(poses,) mean of the distances."""
        return self.distances.mean(axis=1)

    @cached_property
    def sd(self) -> ndarray:
        """(poses,) standard deviation of the distances, with n - 1."""
        return self.distances.std(axis=1, ddof=1)

    @cached_property
    def RP(self) -> ndarray:
        """(poses,) repeatability: mean + 3 sd of the distances."""
        return self.mean + 3 * self.sd

    @cached_property
    def AP(self) -> ndarray | None:
        """(poses,) accuracy: from the commanded point to the barycentre; None where nothing was
        commanded.
        """
        return None if self.commanded is None else np.hypot(*(self.barycentre - self.commanded).T)

    def __str__(self) -> str:
        poses, n = self.points.shape[:2]
        figures = {
            "x mean (mm)": self.barycentre[:, 0],
            "y mean (mm)": self.barycentre[:, 1],
            "mean dist. (mm)": self.mean,
            "sd (mm)": self.sd,
            "RP (mm)": self.RP,
        }
        if self.AP is not None:
            figures["AP (mm)"] = self.AP
        rows = [["pose", *figures]]
        for k in range(poses):
            rows.append([str(k + 1), *(f"{1e3 * values[k]:.4f}" for values in figures.values())])
        lines = aligned(rows, 0)
        lines.append(
            f"worst RP {1e3 * self.RP.max():.4f} mm, mean + 3 sd of the distances to the barycentre"
            " (ISO 9283)"
        )
        if n < 30:
            lines.append(f"{n} cycles at a pose, where the standard asks for 30")
        return "\n".join(lines)


def repeatability(points: ArrayLike, commanded: ArrayLike | None = None) -> Repeatability:
    """Return accuracy and repeatability of points attained again and again (ISO 9283:1998, 7.2).

        RP = mean + 3 sd of the distances to the barycentre
        AP = distance of the barycentre from the commanded point

    Parameters
    ----------
    points : (n, 2) or (poses, n, 2) array
        Attained points at one pose or several, m, n >= 2.
    commanded : (2,) or (poses, 2) array, optional
        Commanded points, m.

    Returns
    -------
    Repeatability
        Printed, it is a report.

    Raises
    ------
    ValueError
        The shapes do not fit.

    Examples
    --------
    >>> import fivebar as fb
    >>> points = [(0, 0.1), (2e-5, 0.1), (0, 0.10002), (1e-5, 0.09999)]
    >>> fb.repeatability(points).RP.round(9).tolist()
    [2.6804e-05]
    """
    found = finite_numbers(points, "points")
    pairs = found.ndim in (2, 3) and found.shape[-1] == 2
    if not pairs or found.shape[-2] < 2 or not len(found):
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
