"""Measure charts, write and draw them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ...base.errors import UsageError
from ...base.folders import locked_folder
from ...base.progress import progress
from ...base.tables import saved
from . import picture, runner
from .catalogue import CHARTS
from .chart import load
from .page import write_page
from .store import Result


def make(
    names: Sequence[str],
    folder: Path,
    quick: bool = False,
    charts: dict[str, tuple[str, str]] = CHARTS,
) -> dict[str, Result]:
    """Measure and draw charts into a folder: NAME.csv, .png, .svg, and index.html of these charts.

    Parameters
    ----------
    names : of the charts
    folder : made where there is none; an interrupted run in it goes on where it was
    quick : every other knob, and less time for each
    charts : {name: (module with a function `chart`, what it is about)}

    Returns
    -------
    {name: Result}

    Raises
    ------
    UsageError for an unknown name; ValueError where another process makes charts in this folder.
    """
    for name in names:
        if name not in charts:
            raise UsageError(f"no chart {name!r}; the known ones are {', '.join(charts)}, and all")
    modules = {name: charts[name][0] for name in names}
    results = {}
    partials = []
    total = sum(len(load(module).jobs(quick)) for module in modules.values())
    with (
        locked_folder(folder, "chart"),
        progress(total=total, unit=" attempts", smoothing=0.02) as bar,
    ):
        for name, module in modules.items():
            bar.set_description(name)
            result, partial = runner.run(module, folder, quick, bar.update)
            results[name] = result
            partials.append(partial)
            write(result, folder)
        write_page(folder / "index.html", results)
        for partial in partials:  # not before all are done: what is finished is not measured again
            partial.done()
    return results


def write(result: Result, folder: Path) -> None:
    """Write NAME.csv, NAME.png and NAME.svg of a Result."""
    name = result.chart.name
    result.to_csv(folder / f"{name}.csv")
    figure = picture.draw(result)
    for ending in ("png", "svg"):
        saved(figure, folder / f"{name}.{ending}")
