"""Charts made: measured, written, drawn."""

from __future__ import annotations

import io
from importlib import import_module
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np
from PIL import Image

from ...base.folders import locked_folder
from ...base.progress import progress
from ...base.tables import saved, written
from ..chart_names import PEERS
from . import findings, picture, runner
from .chart import MODULES, load, module_of
from .page import write_page
from .store import from_csv

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from .chart import Chart
    from .store import Result

DPI, COLOURS = 200, 256  # a palette makes a third of the file


def chart_names(peers: bool = False) -> tuple[str, ...]:
    """All charts, those of other simulators only if asked for."""
    return tuple(name for name in MODULES if peers or name not in PEERS)


def make(names: Sequence[str], folder: Path, quick: bool = False) -> dict[str, Result]:
    """Measure and draw charts into a folder: NAME.csv, .png, .svg, and index.html of all there are;
    {name: Result}.

    quick: every other knob and less time for each. An interrupted run goes on where it was.
    ValueError where another process makes charts in this folder.
    """
    modules = {name: module_of(name) for name in names}
    with locked_folder(folder, "chart"):
        return _make(modules, folder, quick)


def _make(modules, folder, quick):
    partials = []
    others = [name for name in MODULES if name not in modules and (folder / f"{name}.csv").exists()]
    results = {name: redraw(folder / f"{name}.csv", name) for name in others}
    total = sum(len(load(module).jobs(quick)) for module in modules.values())
    with progress(total=total, unit=" attempts", smoothing=0.02) as bar:
        for name in modules:
            bar.set_description(name)
            results[name], partial = runner.run(name, folder, quick, bar.update)
            results[name].to_csv(folder / f"{name}.csv")
            partials.append(partial)
        ordered, pictures = {name: results[name] for name in MODULES if name in results}, {}
        for name, result in ordered.items():
            bar.set_description(f"{name}, drawn")
            pictures[name] = draw(result, folder)
            bar.refresh()
    notes = {
        n: (module_with(r.chart).caption(r), module_with(r.chart).table(r))
        for n, r in ordered.items()
    }
    write_page(folder / "index.html", ordered, pictures, notes)
    for partial in (
        partials
    ):  # not before all are done: an interrupted run of several charts keeps the finished ones
        partial.done()
    return {name: results[name] for name in modules}


def redraw(path: Path, name: str) -> Result:
    """The Result of a CSV file that `make` wrote."""
    return from_csv(path, load(module_of(name)))


def draw(result: Result, folder: Path) -> bytes:
    """NAME.png and .svg of a Result; a PNG's bytes without title and verdict, for a page that has
    them as text.
    """
    figure, buffer = module_with(result.chart).figure(result), io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI)
    image = _few_colours(Image.open(buffer).convert("RGB"))
    with written(folder / f"{result.chart.name}.png", binary=True) as file:
        image.save(file, "png", optimize=True)
    saved(figure, folder / f"{result.chart.name}.svg")
    bare = io.BytesIO()
    picture.plain(figure, image).save(bare, "png", optimize=True)
    return bare.getvalue()


def _few_colours(image):
    """A picture with a palette: its most frequent colours as they are, all others as the nearest of
    these.
    """
    pixels = np.asarray(image).astype(np.uint32) @ np.array([1 << 16, 1 << 8, 1], np.uint32)
    found, index, counts = np.unique(pixels, return_inverse=True, return_counts=True)
    levels = found[:, None] >> np.array([16, 8, 0]) & 255
    kept = levels[np.argsort(counts)[: -COLOURS - 1 : -1]]
    nearest = np.array(
        [np.argmin(((kept - level) ** 2).sum(axis=1)) for level in levels.astype(int)]
    )
    small = Image.fromarray(nearest[index].reshape(pixels.shape).astype(np.uint8))
    small.putpalette(kept.astype(np.uint8).tobytes())  # of gray levels it makes numbers of colours
    return small


def module_with(chart: Chart) -> object:
    """What has figure(result), caption(result) and table(result) for a chart."""
    if chart.picture:
        return import_module(f".charts.{chart.picture}", __package__)
    return SimpleNamespace(figure=picture.figure, caption=findings.caption, table=findings.table)
