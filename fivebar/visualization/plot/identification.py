"""What an identified robot's model says of its motors' torques: measured, predicted and the
difference.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..style import SIDES
from .panels import draw_measured, over_time
from .sheets import Sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...estimation.identification.result import Identification


def draw_identification(result: Identification, sheet: Sheet) -> Figure:
    """Draw an Identification: a row for its run, and one for the run it was tried on, if any."""
    if not len(result.t):
        raise ValueError(
            "an Identification read from a file has no rows to draw: identify the log again"
        )
    runs: dict = {"the log": result}
    if result.validation is not None:
        runs["second run"] = result.validation
    mosaic = [[f"{side} motor, {name}" for side, _ in SIDES] for name in runs]
    figure, panels = sheet.mosaic(mosaic, (12, 3.6 * len(runs)))
    for row, (name, run) in zip(np.reshape(panels, (-1, 2)), runs.items()):
        # Several logs, each from 0 on, are not joined.
        breaks = np.flatnonzero(np.diff(run.t, prepend=run.t[:1]) < 0)
        t = np.insert(run.t, breaks, np.nan)
        tau = np.insert([run.tau, run.predicted], breaks, np.nan, axis=1)
        for k, (axes, (side, colour)) in enumerate(zip(row, SIDES)):
            ylabel = draw_measured(axes, t, tau[..., k], result.robot.words, colour, "predicted")
            over_time(axes, 3, ylabel, f"{side} motor, {name}: misses {100 * run.misfit:.3g} %")
    return figure
