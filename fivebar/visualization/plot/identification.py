"""What an identified robot's model says of its motors' torques: measured, predicted and the
difference.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ..style import INK, LEFT, RIGHT, finish, readable

if TYPE_CHECKING:
    from ...estimation.identification.result import Identification


def identification(found: Identification) -> Figure:
    """Figure of an Identification: a row for the run it is from, and one for the run it was tried
    on, if any.
    """
    if not len(found.t):
        raise ValueError(
            "an Identification read from a file has no rows to draw: identify the log again"
        )
    runs = [("the log", found)] + (
        [("second run", found.validation)] if found.validation is not None else []
    )
    figure = Figure(figsize=(12, 3.6 * len(runs)), layout="constrained")
    panels = figure.subplots(len(runs), 2, squeeze=False)
    words = found.robot.words
    for row, (name, run) in zip(panels, runs):
        scale, unit = readable(np.nanmax(np.abs(run.tau)), words.effort_unit)
        time, breaks = (
            run.t,
            np.flatnonzero(np.diff(run.t, prepend=run.t[:1]) < 0),
        )  # several logs, each from 0 on
        for k, (axes, side, colour) in enumerate(zip(row, ("left", "right"), (LEFT, RIGHT))):
            tau, predicted = (
                np.insert(values[:, k], breaks, np.nan) for values in (run.tau, run.predicted)
            )
            t = np.insert(time, breaks, np.nan)
            axes.plot(t, scale * tau, color=INK, lw=2.2, alpha=0.5, label="measured")
            axes.plot(t, scale * predicted, color=colour, lw=1.2, label="predicted")
            axes.plot(t, scale * (tau - predicted), color=INK, lw=0.9, ls=":", label="difference")
            axes.margins(x=0)
            title = f"{side} motor, {name}: misses {100 * run.misfit:.3g} %"
            finish(axes, 3, xlabel="time (s)", ylabel=f"{words.effort} ({unit})", title=title)
    return figure
