"""A page in one file: the plotting library, the page's own code, and what is shown as JSON."""

import html
import json
from base64 import b64encode
from importlib.util import find_spec
from pathlib import Path
from string import Template

import numpy as np

HERE = Path(__file__).parent
CODE = {"motion": ("motion", "curves", "controls"), "map": ("model", "map", "map_controls")}


def write(path, code, content):
    """Write the page with this code, one of CODE, and content: a dict for JSON with a title and notes."""
    text = Template((HERE / "page.html").read_text("utf-8")).substitute(
        title=html.escape(content["title"]),
        style=(HERE / "page.css").read_text("utf-8"),
        library="\n".join(file.read_text("utf-8") for file in _library()),
        code="\n".join((HERE / f"{name}.js").read_text("utf-8") for name in ("common", "picture", "plot", *CODE[code])),
        # "<" could only be in a string: escaped, no text can end the element that holds the JSON.
        content=json.dumps(content, allow_nan=False).replace("<", "\\u003c"),
    )
    Path(path).write_text(text, encoding="utf-8")


def packed(values, kind="f8"):
    """An array as JSON: base64 of its little-endian numbers."""
    return {kind: b64encode(np.ascontiguousarray(values, f"<{kind}").tobytes()).decode()}


def _library():
    # The package is found and not imported: only its files for the browser are wanted.
    bokeh = find_spec("bokeh")
    if bokeh is None:
        raise ImportError("a linked page needs the plots of Bokeh: pip install bokeh")
    folder = Path(bokeh.submodule_search_locations[0], "server", "static", "js")
    return folder / "bokeh.min.js", folder / "bokeh-api.min.js"
