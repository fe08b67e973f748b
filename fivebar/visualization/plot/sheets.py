"""Where a picture goes: onto panels of a figure of one's own, or into a new figure, which may be as
wide as a journal's column.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context, rcParams
from matplotlib.figure import Figure

from ...base.checks import shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTHS = {"column": 88.0, "page": 181.0}  # mm
NARROW = 4.0  # in; panels of narrower figures are below one another
NORMAL, SMALL = 10, 7  # points, of letters in wide figures and in those for journals


def new_figure(width: float, height: float) -> Figure:
    """Return a figure of this size in inches, without a window."""
    return Figure(figsize=(width, height), layout="constrained")


def inches_across(axes: Axes) -> float:
    """Return about how wide a panel is, before it is laid out."""
    return axes.get_position().width * axes.figure.bbox.width / axes.figure.dpi


def small_letters() -> float:
    """Return the size of legends and notes, points."""
    return min(8.0, rcParams["font.size"])


@dataclass(frozen=True)
class Sheet:
    """Panels that are given, one, several or by their names, or a new figure of a width.

    width: mm, or "column", or "page"; None: as wide as the picture needs.
    """

    axes: Any = None
    width: Any = None

    @property
    def inches(self) -> float | None:
        """The width of a new figure; None: as wide as the picture needs."""
        if self.width is None:
            return None
        if self.axes is not None:
            raise ValueError("width is of a new figure: axes have the width of theirs")
        mm: Any = WIDTHS.get(self.width) if isinstance(self.width, str) else self.width
        if not isinstance(mm, Real) or not 40 <= float(mm) <= 1000:
            raise ValueError(
                'width must be "column" (88 mm), "page" (181 mm) or a number of mm from 40 to'
                f" 1000, not {shown(self.width)}"
            )
        return float(mm) / 25.4

    @property
    def is_narrow(self) -> bool:
        return (self.inches or 2 * NARROW) < NARROW

    def letters(self) -> AbstractContextManager:
        """Return the context in which letters have the size that suits the width."""
        return rc_context({"font.size": NORMAL if (self.inches or 9) > 8 else SMALL})

    def mosaic(
        self,
        rows: Sequence[Sequence[str]],
        size: tuple[float, float],
        together: Iterable[str] = (),
        **ratios: Any,
    ) -> tuple[Figure, list]:
        """Return a figure and its panels, in the order of their names in rows of a mosaic.

        A panel whose name is not among given ones is drawn on a figure that nobody sees.

        Parameters
        ----------
        rows : list of lists of str
            A panel over several places has its name in each.
        size : (2,)
            Width and height in inches without a width that is asked for.
        together : names
            Panels that have one axis of time.
        """
        names = list(dict.fromkeys(name for row in rows for name in row))
        given = self._given(names)
        if len(given) == len(names):
            return given[names[0]].figure, [given[name] for name in names]
        width, height = size
        if self.inches is not None:
            scale = self.inches / width
            if self.is_narrow and len(names) > 1:
                shares = [sum(name in row for row in rows) for name in names]
                height *= len(rows[0]) * sum(shares) / len(rows)
                rows, ratios = [[name] for name in names], {"height_ratios": shares}
            else:
                scale = max(scale, 0.7)  # as letters
            width, height = self.inches, height * scale
        figure: Any = new_figure(width, height)
        panels = figure.subplot_mosaic(rows, **ratios)
        first, *others = [panels[name] for name in together if name not in given] or [None]
        for panel in others:
            panel.sharex(first)
        if given:
            figure = next(iter(given.values())).figure
        return figure, [(panels | given)[name] for name in names]

    def grid(
        self, names: Sequence[str], columns: int, width: float, height: float, narrow: int = 1
    ) -> tuple[Figure, list]:
        """Return a figure and its panels, with common axes, in rows of so many columns, each so
        wide and high in inches; narrow: columns of a narrow figure.
        """
        given = self._given(names)
        if given:
            return self.mosaic([names], (len(names) * width, height))
        count = len(names)
        columns = min(columns, count)
        if self.inches is not None:
            columns = min(columns, narrow if self.is_narrow else 2)
            height *= (self.inches - 0.5) / columns / width
            width = (self.inches - 0.5) / columns
        rows = -(-count // columns)
        figure = new_figure(width * columns + 0.5, height * rows + 0.5)
        panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
        for unused in panels[count:]:
            unused.remove()
        return figure, list(panels[:count])

    def _given(self, names):
        """Return the panels that are given, {name: Axes}."""
        given = self.axes
        if given is None:
            return {}
        if not isinstance(given, Mapping):
            flat = np.ravel(given)
            if len(flat) != len(names):
                raise ValueError(
                    f"axes: {len(flat)} of them for {len(names)} panels: {', '.join(names)};"
                    f" axes={{{names[0]!r}: ...}} draws one alone"
                )
            given = dict(zip(names, flat))
        unknown = [name for name in given if name not in names] or ["is given"] * (not given)
        if unknown:
            raise ValueError(
                f"axes: no panel {', '.join(map(str, unknown))}; the panels are {', '.join(names)}"
            )
        for name, panel in given.items():
            if not hasattr(panel, "get_xlim"):
                raise TypeError(f"axes: {name} must be Matplotlib's Axes, not {shown(panel)}")
        return given
