"""The singularity loci of a robot, in closed form."""

from __future__ import annotations

from ..models.robots import KINDS, Biglide, FiveBar
from .biglide_loci import BiglideLoci
from .five_bar_loci import FiveBarLoci


def singularity_loci(robot: FiveBar | Biglide) -> FiveBarLoci | BiglideLoci:
    """Return the singularity loci in task space and in joint space, in closed form.

    Parameters
    ----------
    robot : FiveBar or Biglide

    Returns
    -------
    FiveBarLoci or BiglideLoci
        `task` and `joint`: tuples of Locus.

    Raises
    ------
    TypeError
        robot is of another kind.

    References
    ----------
    Gosselin and Angeles 1990 (the types); Liu, Wang and Pritschow 2006 (symmetric five-bars).

    Examples
    --------
    >>> import fivebar as fb
    >>> len(fb.singularity_loci(fb.FiveBar()).task) > 0
    True
    """
    if not isinstance(robot, KINDS):
        raise TypeError(
            f"singularity_loci needs a FiveBar or a Biglide, not {type(robot).__name__}, as its"
            " robot"
        )
    if isinstance(robot, FiveBar):
        return FiveBarLoci(robot)
    return BiglideLoci(robot)
