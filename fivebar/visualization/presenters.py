"""Which function draws which class: what `.plot()`, `.page()`, `.scene()` of results call.

Options of `.plot()` besides `path`, `axes` and `width`: `panels` of a linkage's Study, `robots` of
a Front, `tool` of a Plan, `figure` and `mark` of a Sweep, `field` of a DesignComparison.
"""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from inspect import signature
from typing import TYPE_CHECKING, Any

from ..base.tables import BinaryFile, saved

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .pages import Page
    from .play.live import LivePage
    from .view import Scene

# Class name -> module in `plot` and its function (result, **options) -> Figure.
PLOTS = {
    "Calibration": "calibration.draw_calibration",
    "Comparison": "comparison.draw_comparison",
    "Design": "designs.draw_design",
    "DesignComparison": "comparison.draw_designs",
    "Front": "designs.draw_front",
    "Identification": "identification.draw_identification",
    "MeasurementPoses": "accuracy.draw_measurement_poses",
    "Path": "drawing.draw_path",
    "Plan": "plans.draw_plan",
    "Repeatability": "accuracy.draw_repeatability",
    "Replay": "replays.draw_replay",
    "Run": "runs.draw_run",
    "Study": "linkages.draw_study",
    "Sweep": "designs.draw_sweep",
    "TimedPath": "timed_paths.draw_timed_path",
    "TipError": "accuracy.draw_tip_error",
}


def plot(result: Any, path: BinaryFile | None, axes: Any, width: Any, **options: Any) -> Figure:
    """Draw a result; write the figure to `path` if given."""
    from .plot.sheets import Sheet

    kind = type(result).__name__
    module, name = PLOTS[kind].split(".")
    draw = getattr(import_module(f".plot.{module}", __package__), name)
    known = ["path", "axes", "width", *list(signature(draw).parameters)[2:]]
    for option in options:
        if option not in known:
            words = f"no option {option!r}; it has {', '.join(known)}"
            raise TypeError(f"the plot of a {kind} has {words}")
    sheet = Sheet(axes, width)
    with sheet.letters():
        return saved(draw(result, sheet, **options), path)


def page(result: Any, path: Any, show: Any, title: str | None) -> Page | LivePage | None:
    """Make the page of a result: of a Design its live page, of a Front a table with a picture, else
    linked plots.
    """
    from .pages import page

    match type(result).__name__:
        case "Design":
            from .pages.fronts import live_page

            live = live_page(result)
            if path is not None:
                live.save(path)
            return live
        case "Front":
            from .pages.fronts import save_page

            save_page(result, path, title)
            return None
        case "Replay":
            usual = ("xi", "tau", "q")
            return page(result.runs, path, usual if show is None else show, title)
        case _:
            return page(result, path, show, title)


def scene(result: Any, show: Any, title: str | None) -> Scene:
    """Make the 3-D scene of a motion; of a Replay, both motions side by side on one clock."""
    from .view import scene

    if type(result).__name__ == "Replay":
        names = ("measured", "simulated")
        measured, simulated = result.measured, result.simulated
        if measured.xi_ref is None:
            simulated = replace(simulated, xi_ref=None)
        return scene(measured.robot, measured, show, second=simulated, title=title, names=names)
    mechanism = result.linkage if type(result).__name__ == "Study" else result.robot
    return scene(mechanism, result, show, title=title)
