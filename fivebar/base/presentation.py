"""Methods by which results show themselves: plot, page, scene, animate and the notebook
representation.

A result knows nothing of pictures. `fivebar/__init__` sets `load_presenters`, and the room
`visualization` says in `presenters.py` which function draws which class. So no lower room imports a
higher one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..visualization.pages import Page
    from ..visualization.view import Scene
    from .tables import BinaryFile, FilePath

load_presenters: Any = None


class Plotted:
    """A result with a picture."""

    def plot(
        self,
        path: BinaryFile | None = None,
        axes: Any = None,
        width: str | float | None = None,
        **options: Any,
    ) -> Figure:
        """Return the Matplotlib figure of this result.

        Parameters
        ----------
        path : str, path or binary file, optional
            Where to write the figure: PNG, SVG or PDF by the ending of the name.
        axes : Axes, sequence of Axes or {name: Axes}, optional
            Panels of a figure of one's own: all of the picture's, or those named. A wrong name gets
            a list of the names.
        width : float, "column" or "page", optional
            Of a new figure, mm: 88 of a journal's column, or 181 of its page, in letters of 7
            points. As wide as the picture needs without.
        **options
            What the picture of this class takes besides: `help(fivebar.visualization.presenters)`.
        """
        return load_presenters().plot(self, path, axes, width, **options)

    def _repr_html_(self) -> str:
        import html  # late, because a start without a notebook needs none of these
        import io
        from base64 import b64encode

        picture = io.BytesIO()
        self.plot().savefig(picture, format="png", dpi=100)
        words = html.escape(repr(self))
        data = b64encode(picture.getvalue()).decode()
        image = f'<img style="max-width:100%" alt="{words}" src="data:image/png;base64,{data}">'
        return f"<code>{words}</code><br>{image}"


class Paged:
    """A result with a linked page."""

    def page(
        self,
        path: FilePath | None = None,
        show: str | Sequence | None = None,
        title: str | None = None,
    ) -> Page:
        """Return a page in one HTML file on which pointing at a plot moves the mechanism:
        `fb.page`.

        Parameters
        ----------
        path : str or path, optional
            Where to write the page.
        show : str or sequence of str, optional
            Quantities to plot; the usual ones by default.
        title : str, optional
            Text over the page; the result's own by default.
        """
        return load_presenters().page(self, path, show, title)


class Animated(Plotted, Paged):
    """A motion: a result with a picture, a linked page and a 3-D scene."""

    def scene(self, show: str | Sequence[str] | None = None, title: str | None = None) -> Scene:
        """Return the motion as a scene, which shows itself in a notebook: `fb.view.scene`.

        Parameters
        ----------
        show : str or sequence of str, optional
            Names out of `fb.view.SHOWS`; the traced path, and the reference where there is one, by
            default.
        title : str, optional
            Text over the scene; the mechanism's own by default.
        """
        return load_presenters().scene(self, show, title)

    def animate(
        self,
        path: FilePath | None = None,
        show: str | Sequence[str] | None = None,
        title: str | None = None,
    ) -> Scene:
        """Return the motion as a scene and write it to `path` if given.

        Parameters
        ----------
        path : str or path, optional
            A page in meshcat's viewer (.html; no server, no network), an animation (.gif; with
            ffmpeg .mp4, .webm) or a strip of poses (.png).
        show, title
            As in `scene`.
        """
        return self.scene(show, title).saved(path)
