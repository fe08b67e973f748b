"""The singularity loci of a robot, in closed form."""

from __future__ import annotations

from ..base.robot_uses import takes_robot
from ..models.robots import Biglide, FiveBar
from .biglide_loci import BiglideLoci
from .five_bar_loci import FiveBarLoci


@takes_robot()
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
    if isinstance(robot, FiveBar):
        return FiveBarLoci(robot)
    return BiglideLoci(robot)
