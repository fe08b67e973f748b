"""A page in one file: the plotting library, the page's own code, and what is shown as JSON."""

from __future__ import annotations

from base64 import b64encode
from pathlib import Path

import numpy as np

from ...tables import written
from ..document import as_json, document, library

HERE = Path(__file__).parent
CODE = {"motion": ("motion", "curves", "controls"), "map": ("map", "map_controls")}


def write(path: str | Path, code: str, content: dict, models: str = "") -> None:
    """Write the page with this code, one of CODE, and content: a dict for JSON with a title and notes.

    models: JavaScript of what the page computes itself.
    """
    bokeh = library("bokeh", "a linked page needs the plots of Bokeh") / "server" / "static" / "js"
    text = document(
        HERE,
        content["title"],
        library="\n".join((bokeh / name).read_text("utf-8") for name in ("bokeh.min.js", "bokeh-api.min.js")),
        code="\n".join([script(name) for name in ("common", "picture", "plot")] + [models, *map(script, CODE[code])]),
        content=as_json(content),
    )
    with written(path) as file:
        file.write(text)


def script(name: str) -> str:
    """A part of the pages' own code."""
    return (HERE / f"{name}.js").read_text("utf-8")


def packed(values: np.ndarray, kind: str = "f8") -> dict:
    """An array as JSON: base64 of its little-endian numbers."""
    return {kind: b64encode(np.ascontiguousarray(values, f"<{kind}").tobytes()).decode()}
