"""A front as a page: its picture, and a table whose rows open their robots on the live page beside
it.
"""

from __future__ import annotations

import html
import io
from base64 import b64encode
from pathlib import Path
from typing import TYPE_CHECKING

from ... import visualization as pictures
from ...base.tables import written
from ...models.robots import FiveBar
from ..document import document
from ..play.live import Live, play
from ..plot.designs import _with_unit, label, pose_of

if TYPE_CHECKING:
    from ...optimal_design.results import Design, Front

PLAY = "play.html"


def live_page(design: Design) -> Live:
    """The live page of a design, its end-effector in the middle of its table."""
    if not isinstance(design.robot, FiveBar):
        raise ValueError(f"the live page is of five-bars, not of a {design.robot.words.title}")
    return play(design.robot, pose_of(design))


def save_page(front: Front, path: Path) -> None:
    """index.html and play.html; of other robots than five-bars without links."""
    live = [live_page(each) if isinstance(each.robot, FiveBar) else None for each in front.designs]
    first = front.designs[0]
    units = [*map(_with_unit, first.parameters), *map(label, first.values)]
    heads = "".join(f'<th scope="col">{html.escape(text)}</th>' for text in ("", *units, "held by"))
    rows = []
    for number, (each, page) in enumerate(zip(front.designs, live), start=1):
        told = (
            f'<a href="{PLAY}{html.escape(page.fragment)}">robot {number}</a>'
            if page
            else f"robot {number}"
        )
        cells = [
            told,
            *(f"{value:.6g}" for value in (*each.parameters.values(), *each.values.values())),
        ]
        cells.append(
            html.escape("; ".join(sentence.partition(" is ")[0] for sentence in each.binding))
        )
        rows.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
    picture = io.BytesIO()
    front.plot().savefig(picture, format="png", dpi=90)
    goals = " and ".join(f"{way} {name}" for name, way in front.goals.items())
    folder_of_page, title = (
        Path(pictures.__file__).parent / "designs",
        f"{len(front)} robots: {goals}",
    )
    picture = b64encode(picture.getvalue()).decode()
    notes = html.escape(repr(first.task)[1:-1])
    page = document(
        folder_of_page, title, notes=notes, picture=picture, heads=heads, rows="\n".join(rows)
    )
    with written(path) as out:
        out.write(page)
    if live[0] is not None:
        live[0].save(path.parent / PLAY)
