"""A web page in one file, for any browser and without a network: what scenes, linked pages and the
live page share.
"""

from __future__ import annotations

import html
import json
from base64 import b64encode
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

from ..base.tables import TextFile, written

HERE = Path(__file__).parent


class WebPage:
    """A page, complete: its title and `html`; in a notebook it shows itself."""

    if TYPE_CHECKING:  # subclasses have them as fields or properties

        @property
        def title(self) -> str: ...

        @property
        def html(self) -> str: ...

    def save(self, path: TextFile) -> None:
        """Write the page (HTML in UTF-8), whole or not at all.

        Parameters
        ----------
        path : str, path or text file
            Where to write it.
        """
        with written(path) as file:
            file.write(self.html)

    def _repr_html_(self) -> str:
        return frame_html(self.html, self.title, 760)


def document(
    folder: Path, title: str, scripts: str = "'unsafe-inline'", style: str = "", **parts: str
) -> str:
    """Return the page whose body and own style are page.html and page.css of this folder.

    scripts: which the page's policy lets run; style: more of it; parts: what is filled into its
    body.
    """
    title = html.escape(title)
    body = Template((folder / "page.html").read_text("utf-8")).substitute(title=title, **parts)
    common, own = ((place / "page.css").read_text("utf-8") for place in (HERE, folder))
    style = common + style + own
    return Template((HERE / "page.html").read_text("utf-8")).substitute(
        title=title, scripts=scripts, style=style, body=body
    )


def report(kind: str, title: str, **parts: str) -> str:
    """Return a page of text, pictures and tables, without scripts: one of designs or charts."""
    style = (HERE / "report.css").read_text("utf-8")
    return document(HERE / kind, title, "'none'", style, **parts)


def picture(png: bytes, text: str) -> str:
    """Return HTML of a picture, and of the text that says what it shows."""
    data = b64encode(png).decode()
    image = f'<img alt="{html.escape(text)}" src="data:image/png;base64,{data}">'
    return _scrolling(image, text, "chart")


def table(title: str, heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return HTML of a table; its heads are texts, its cells are HTML already."""
    head = "".join(f'<th scope="col">{html.escape(text)}</th>' for text in heads)
    lines = []
    for row in rows:
        cells = "".join(f"<td>{cell}</td>" for cell in row)
        lines.append(f"<tr>{cells}</tr>")
    body = "\n".join(lines)
    made = f"<table><thead><tr>{head}</tr></thead><tbody>\n{body}\n</tbody></table>"
    return _scrolling(made, title, "wide")


def _scrolling(content, name, kind):
    """Return HTML of what may be wider than the window, which the keyboard can scroll too."""
    name = html.escape(name)
    return (
        f'<div class="scroll {kind}" tabindex="0" role="region" aria-label="{name}">{content}</div>'
    )


def script(folder: Path, *names: str) -> str:
    """Return the JavaScript in these files of a folder."""
    return "\n".join((folder / f"{name}.js").read_text("utf-8") for name in names)


def frame_html(page: str, title: str, height: int, style: str = "") -> str:
    """Return HTML of a frame with this page, so many pixels high, for a notebook."""
    return (
        f'<iframe style="width:100%;height:{height}px;border:0;{style}"'
        f' title="{html.escape(title)}" srcdoc="{html.escape(page)}"></iframe>'
    )


def as_json(content: dict) -> str:
    """Return JSON for a script element.

    "<" could only be in a string, and escaped no text can end the element.
    """
    return json.dumps(content, allow_nan=False).replace("<", "\\u003c")


def library_folder(name: str, purpose: str) -> Path:
    """Return the folder of an installed package, of which only files for the browser are wanted."""
    package = find_spec(name)
    if package is None or package.origin is None:
        raise ImportError(f"{purpose}: pip install {name}")
    return Path(package.origin).parent
