"""The singularity loci of a robot, in closed form."""

from __future__ import annotations

from ..models.robots import KINDS, Biglide, FiveBar
from .biglide_loci import BiglideLoci
from .five_bar_loci import FiveBarLoci


def singularity_loci(robot: FiveBar | Biglide) -> FiveBarLoci | BiglideLoci:
    """The singularity loci in task space and in joint space, in closed form: FiveBarLoci or
    BiglideLoci.

    Gosselin and Angeles 1990 (the types), Liu, Wang and Pritschow 2006 (the loci of symmetric
    five-bars).
    """
    if not isinstance(robot, KINDS):
        raise TypeError(
            f"singularity_loci needs a FiveBar or a Biglide, not {type(robot).__name__}, as its"
            " robot"
        )
    return FiveBarLoci(robot) if isinstance(robot, FiveBar) else BiglideLoci(robot)
