"""A page in one file: the plotting library, the page's own code, and what is shown as JSON."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...base.representation import one_line
from ...base.tables import TextFile, written
from ..document import as_json, document, framed, library

HERE = Path(__file__).parent
CODE = {"motion": ("motion", "curves", "controls"), "map": ("map", "map_controls")}


@dataclass(frozen=True, eq=False)
class Page:
    """A page, complete; in a notebook it shows itself."""

    title: str
    html: str

    def __repr__(self) -> str:
        return one_line("Page", self.title)

    def save(self, path: TextFile) -> None:
        """Write it (HTML in UTF-8), whole or not at all. path: a path or an open text file."""
        with written(path) as file:
            file.write(self.html)

    def _repr_html_(self) -> str:
        return framed(self.html, self.title, 760)


def made(path: TextFile | None, code: str, content: dict, models: str = "") -> Page:
    """The page with this code, one of CODE, and content: a dict for JSON with a title and notes;
    written, if asked.

    path: None does not write it; models: JavaScript of what the page computes itself.
    """
    bokeh = library("bokeh", "a linked page needs the plots of Bokeh") / "server" / "static" / "js"
    text = document(
        HERE,
        content["title"],
        library="\n".join(
            (bokeh / name).read_text("utf-8") for name in ("bokeh.min.js", "bokeh-api.min.js")
        ),
        code="\n".join(
            [script(name) for name in ("common", "picture", "plot")]
            + [models, *map(script, CODE[code])]
        ),
        content=as_json(content),
    )
    page = Page(content["title"], text)
    if path is not None:
        page.save(path)
    return page


def script(name: str) -> str:
    """A part of the pages' own code."""
    return (HERE / f"{name}.js").read_text("utf-8")


def packed(values: np.ndarray, kind: str = "f8") -> dict:
    """An array as JSON: base64 of its little-endian numbers."""
    return {kind: b64encode(np.ascontiguousarray(values, f"<{kind}").tobytes()).decode()}
