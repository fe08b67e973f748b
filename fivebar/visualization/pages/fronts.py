"""A front as a page: its picture, and a table whose rows open their robots on the live page beside
it.
"""

from __future__ import annotations

import html
import io
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote

from ...base.tables import written
from ...models.robots import FiveBar
from ..document import picture, report, table
from ..play.live import LivePage, play
from ..plot.designs import Quantity, parameter_unit, pose_of

if TYPE_CHECKING:
    from ...optimal_design.results import Design, Front


def live_page(design: Design) -> LivePage:
    """Return the live page of a design, its end-effector in the middle of its table."""
    if not isinstance(design.robot, FiveBar):
        raise ValueError(f"the live page is of five-bars, not of a {design.robot.words.title}")
    return play(design.robot, pose_of(design))


def save_page(front: Front, path: str | PathLike | None, title: str | None) -> None:
    """Write a page, PAGE.html, and the live page that its table opens, PAGE_live.html.

    Robots other than five-bars have no live page.
    """
    if path is None:
        raise ValueError("page: a front has a page of two files: give it a path")
    path = Path(path)
    live_path = path.with_name(f"{path.stem}_live.html")  # `fivebar play` writes play.html
    first = front.designs[0]
    rows = []
    live = None
    heads = [Quantity(name, parameter_unit(name, first.robot)) for name in first.parameters]
    heads += [Quantity(name, first.units[name]) for name in first.values]
    for number, design in enumerate(front.designs, start=1):
        name = f"robot {number}"
        if isinstance(design.robot, FiveBar):
            page = live_page(design)
            live = live or page
            address = html.escape(quote(live_path.name) + page.fragment)
            name = f'<a href="{address}">{name}</a>'
        values = *design.parameters.values(), *design.values.values()
        active = "; ".join(sentence.partition(" is ")[0] for sentence in design.binding)
        rows.append([name, *(f"{value:.6g}" for value in values), html.escape(active)])
    png = io.BytesIO()
    front.plot().savefig(png, format="png", dpi=90)
    goals = " and ".join(f"{name} ({way})" for name, way in front.goals.items())
    notes = f"{repr(first.task)[1:-1]}; SI units.".removeprefix("Task: ; ")  # without a task
    title = title or f"Pareto front of {len(front)} robots: {goals}"
    page = report(
        "designs",
        title,
        notes=html.escape(notes),
        picture=picture(png.getvalue(), f"{title}, and robots along it"),
        table=table("designs", ["robot", *map(str, heads), "active constraints"], rows),
    )
    with written(path) as out:
        out.write(page)
    if live:
        live.save(live_path)
