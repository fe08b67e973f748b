"""A page in one file: the plotting library, the page's own code, and what is shown as JSON."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...base.representation import one_line
from ...base.tables import TextFile
from ..document import WebPage, as_json, document, library_folder, script

HERE = Path(__file__).parent
CODE = {"motion": ("motion", "curves", "controls"), "map": ("map", "map_controls")}


@dataclass(frozen=True, eq=False)
class Page(WebPage):
    """A page, complete; in a notebook it shows itself."""

    title: str
    html: str

    def __repr__(self) -> str:
        return one_line("Page", self.title)


def make_page(path: TextFile | None, code: str, content: dict, models: str = "") -> Page:
    """Return the page with this code, one of CODE, and content; write it if path is not None.

    models: JavaScript of what the page computes itself.
    """
    bokeh = (
        library_folder("bokeh", "a linked page needs the plots of Bokeh")
        / "server"
        / "static"
        / "js"
    )
    parts = (
        script(HERE.parent, "parts", "timeline"),
        script(HERE, "common", "picture", "plot"),
        models,
        script(HERE, *CODE[code]),
    )
    text = document(
        HERE,
        content["title"],
        library=script(bokeh, "bokeh.min", "bokeh-api.min"),
        code="\n".join(parts),
        content=as_json(content),
    )
    page = Page(content["title"], text)
    if path is not None:
        page.save(path)
    return page


def packed(values: np.ndarray, kind: str = "f8") -> dict:
    """Return an array as JSON: base64 of its little-endian numbers."""
    return {kind: b64encode(np.ascontiguousarray(values, f"<{kind}").tobytes()).decode()}
