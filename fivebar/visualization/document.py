"""A web page in one file, for any browser and without a network: the head and style that all pages
share.
"""

from __future__ import annotations

import html
import json
from importlib.util import find_spec
from pathlib import Path
from string import Template

HERE = Path(__file__).parent


def document(folder: Path, title: str, scripts: str = "'unsafe-inline'", **parts: str) -> str:
    """The page whose body, with `parts` to fill in, and own style are page.html and page.css of
    this folder.

    scripts: which the page's policy lets run.
    """
    title = html.escape(title)
    body = Template((folder / "page.html").read_text("utf-8")).substitute(title=title, **parts)
    style = "".join((place / "page.css").read_text("utf-8") for place in (HERE, folder))
    return Template((HERE / "page.html").read_text("utf-8")).substitute(
        title=title, scripts=scripts, style=style, body=body
    )


def framed(page: str, title: str, height: int, style: str = "") -> str:
    """HTML of a frame with this page, so many pixels high, for a notebook."""
    return (
        f'<iframe style="width:100%;height:{height}px;border:0;{style}"'
        f' title="{html.escape(title)}" srcdoc="{html.escape(page)}"></iframe>'
    )


def as_json(content: dict) -> str:
    """JSON for a script element: "<" could only be in a string, and escaped no text can end the
    element.
    """
    return json.dumps(content, allow_nan=False).replace("<", "\\u003c")


def library(name: str, purpose: str) -> Path:
    """The folder of an installed package of which only files for the browser are wanted: it is
    found, not imported.
    """
    package = find_spec(name)
    if package is None:
        raise ImportError(f"{purpose}: pip install {name}")
    return Path(package.submodule_search_locations[0])
