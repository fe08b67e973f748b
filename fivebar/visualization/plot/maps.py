"""A map as a picture: one panel per mode with the field, the exact loci by type, the aspects'
numbers and a path.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rcParams
from matplotlib.colors import LogNorm, Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator, MultipleLocator

from ...base.checks import one_of
from ...base.units import METRES, RADIANS, unit_named
from ...constraints.disc import clearance_at
from ...paths.placing.tool_regions import tool_regions
from ...singularities.maps import SIGNED
from ...singularities.passages import known_aspects
from ..loci import map_loci
from ..style import (
    ALONG,
    DEXTEROUS,
    INK,
    NO_VALUE,
    PINK,
    Scale,
    field_scale,
    length_unit,
    of_unit,
    signs,
)
from .panels import PALETTES, STYLES, draw, figure_legend
from .sheets import Sheet, inches_across

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from ...singularities.maps import Map

SMALLEST_SHAPE, LARGEST_SHAPE = 0.4, 2.0  # height over width of a panel
HALO = [withStroke(linewidth=3.0, foreground="white")]


def singularity_map(
    data: Map,
    path: ArrayLike | None = None,
    dexterous: tuple | None = None,
    modes: Sequence | None = None,
    width: str | float = 240.0,
    axes: Any = None,
    unit: str | None = None,
    labels: Mapping[str, str] | None = None,
) -> Figure:
    """Return the figure of a singularity map: a panel for each mode.

    The field is one raster of the map's nodes, the curves over it are drawn as curves. `dpi=` of
    `savefig` is the resolution of the raster.

    Parameters
    ----------
    data : Map
        From `fb.singularity_map`.
    path : (n, 2) array, optional
        Points of the map's own space, m or rad, drawn on all panels.
    dexterous : sequence of regions, optional
        Of `fb.dexterous`, or what constraints leave, drawn and numbered in place of the aspects.
    modes : sequence, optional
        Out of `data.modes`, such as [(1, -1)] for elbows out; all by default.
    width : float, "column" or "page"
        Of the figure, mm: 88 of a journal's column or 181 of its page; their letters have 7 points.
    axes : Axes or sequence of Axes, optional
        Panels of a figure of one's own, one for each mode, whose curves have their names for
        its legend; a new figure without.
    unit : str, optional
        Of the axes: "um", "mm", "cm", "m" or "in", by default one that fits the robot; of joints
        that turn "deg", the default, or "rad".
    labels : mapping, optional
        What is written in place of "x" and "y" (in joint space "q11" and "q21"), of the field's
        name, and of what the legend says, such as {"x": "$x_P$", "parallel": "det A"}.

    Returns
    -------
    Figure
        Four working modes in task space, or both assembly modes in joint space.

    Raises
    ------
    ValueError
        For modes and labels that the map does not have, a unit or a width that is none, and axes
        that do not fit.

    Examples
    --------
    >>> import fivebar as fb
    >>> data = fb.singularity_map(fb.FiveBar(), space="joint", shape=(21, 21))
    >>> figure = fb.plot.singularity_map(data, unit="rad", labels={"q11": "$a_1$"})
    >>> figure.axes[0].get_title(), figure.axes[1].get_xlabel()
    ('assembly mode +1', '$a_1$ (rad)')
    """
    known: list[Any] = list(data.modes)
    wanted: list[Any] = known if modes is None else list(modes)
    if not wanted or not all(mode in known for mode in wanted):
        raise ValueError(f"modes: {wanted}, where the map has {known}")
    sheet = Sheet(axes, width if axes is None else None)
    picture = MapPicture(data, field_scale(data), unit, labels or {})
    with sheet.letters():
        names = [picture.title(mode) for mode in wanted]
        figure, panels = sheet.grid(names, 2, 1.0, picture.shape, 1 + (len(wanted) > 2))
        for panel, mode in zip(panels, wanted):
            picture.draw(panel, mode, path, dexterous)
        picture.finish(figure, panels, sheet)
    if unknown := [name for name in picture.labels if name not in picture.said]:
        has = ", ".join(picture.said)
        raise ValueError(f"labels: nothing is called {', '.join(unknown)}; the map has {has}")
    return figure


@dataclass(eq=False)
class MapPicture:
    """What panels of maps have in common: how they are coloured, in which unit and in what words.

    kinds: of curves that were drawn, for a legend; said: the words for which there are labels.
    """

    data: Map
    colours: Scale
    unit: Any = None
    labels: Mapping[str, str] = field(default_factory=dict)
    kinds: dict[str, None] = field(default_factory=dict)
    said: dict[str, None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.is_task = self.data.space == "task"
        self.is_angle = not self.is_task and self.data.robot.turns
        units = RADIANS if self.is_angle else METRES
        usual = "deg" if self.is_angle else length_unit(self.data.robot)[1]
        self.unit = one_of(*units)(unit_named(str(self.unit or usual)), "unit")
        self.scale = 1 / units[self.unit]
        self.loci = list(map_loci(self.data))

    @property
    def shape(self) -> float:
        """Height over width of a panel."""
        return float(
            np.clip(np.ptp(self.data.y) / np.ptp(self.data.x), SMALLEST_SHAPE, LARGEST_SHAPE)
        )

    def label(self, name: str, words: str | None = None) -> str:
        """Return what is written for a name; without a label of one's own its words."""
        self.said[name] = None
        return self.labels.get(name, words or name)

    def title(self, mode: Any) -> str:
        """Return what a mode is called."""
        if self.is_task:
            return f"working modes ({signs(*mode)})"
        return f"assembly mode {signs(mode)}"

    def draw(self, axes: Any, mode: Any, path: Any = None, dexterous: Any = None) -> None:
        """Draw one mode."""
        data, scale = self.data, self.scale
        robot: Any = data.robot
        number = data.modes.index(mode)
        x, y = scale * data.x, scale * data.y
        norm = (LogNorm if self.colours.logarithmic else Normalize)(*self.colours[2:4])
        # The image's borders are half a step beyond the outer nodes, the middles of its pixels.
        half_x = np.ptp(x) / (len(x) - 1) / 2
        half_y = np.ptp(y) / (len(y) - 1) / 2
        borders = x[0] - half_x, x[-1] + half_x, y[0] - half_y, y[-1] + half_y
        values = np.minimum(self.colours.factor * data.values[number], 1e12)  # inf has a colour
        colours = dict(cmap=PALETTES[self.colours.palette], norm=norm, interpolation="bilinear")
        axes.imshow(values, origin="lower", extent=borders, zorder=0, **colours)
        limits = dict(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
        axes.set(**limits, facecolor=NO_VALUE, aspect="equal")
        for words, layers, points in self.loci:
            if number in layers:
                self._show(axes, words, points)
        for drive in robot.drives if self.is_task else ():
            if robot.turns:
                self._show(axes, "base joint", [(drive.x, drive.y)])
            else:
                self._show(axes, "guide", [(drive.x, data.y[0]), (drive.x, data.y[-1])])
        title = self.title(mode)
        if inches_across(axes) < 0.27 * rcParams["font.size"]:
            title = title.partition(" modes ")[2] or title
        if self.is_task and (robot.turns or dexterous is not None):
            title += self._draw_regions(axes, mode, dexterous)
        if path is not None:
            points = np.asarray(path, dtype=float)
            self._show(axes, ALONG, points, path_effects=HALO)
            for end, marker in ((0, "o"), (-1, "s")):
                draw(axes, "map.end", *(scale * points[[end]]).T, marker=marker)
        axes.set_title(title, fontsize="medium")
        names = "xy" if self.is_task else robot.words.joints
        for axis, name in zip((axes.xaxis, axes.yaxis), names):
            words = self.label(name, name if self.is_task else f"$q_{{{name[1:]}}}$")
            axis.set_label_text(words if words.endswith(")") else f"{words} ({of_unit(self.unit)})")
            if self.unit == "deg":
                axis.set_major_locator(_degrees(axes, np.ptp(x)))
        axes.tick_params(labelsize=rcParams["font.size"])  # ticks are made later

    def _show(self, axes, words, points, **style):
        self.kinds[words] = None
        xy = self.scale * np.asarray(points)
        draw(axes, f"map.{words}", *xy.T, label=self.label(words), **style)

    def _draw_regions(self, axes, mode, dexterous):
        """Draw the regions of a mode, or the numbers of its aspects; return them for the title."""
        tool, robot = self.data.tool, self.data.robot
        regions: Any = dexterous
        if regions is None:
            regions = known_aspects(robot) if tool is None else tool_regions(tool, robot)
        here = [region for region in regions if region.working == mode]
        for region in here:
            if dexterous is not None:
                _hatch(axes, region, self.scale)
                for loop in region.polygons:
                    closed = np.concatenate([loop, loop[:1]])
                    self._show(axes, DEXTEROUS, closed, path_effects=HALO)
            _number(axes, region, self.scale)
        return _numbers("aspect" if dexterous is None and tool is None else "region", here)

    def finish(self, figure: Figure, panels: list, sheet: Sheet, lines: int = 0) -> None:
        """Add the colour bar; to a new figure the legend, too, and let its height fit.

        lines: of a title besides its first.
        """
        is_closed = self.data.field in (*SIGNED, "transmission_angle")
        side: Any = {}
        if sheet.is_narrow:
            side = dict(
                location="top",
                aspect=40,
                ticks=None if self.colours.logarithmic else MaxNLocator(4),
            )
        words = self.label(self.data.field, self.colours.words)
        side |= dict(label=words, pad=0.02, extend="neither" if is_closed else "max")
        bar = figure.colorbar(panels[0].images[0], ax=panels, **side)
        bar.ax.tick_params(labelsize=rcParams["font.size"])
        if sheet.axes is not None:
            return
        # Side by side panels keep their distances, and the bar is as high as they are.
        figure.set_layout_engine("compressed")
        columns = max(1, int(figure.get_figwidth() / 2.6))
        handles = [
            Line2D([], [], label=self.label(words), **STYLES[f"map.{words}"])
            for words in self.kinds
        ]
        figure_legend(figure, handles, columns)
        for panel in panels:
            panel.label_outer()
        grid = panels[0].get_gridspec()
        line = 1.5 * rcParams["font.size"] / 72  # in
        across = figure.get_figwidth() - 5 * line - (0 if sheet.is_narrow else 6 * line)
        high = across / grid.ncols * self.shape + (2 + lines) * line
        legend = -(-len(handles) // columns)
        figure.set_figheight(grid.nrows * high + (legend + 3 + 4 * sheet.is_narrow) * line)


def _numbers(name, regions):
    numbers = [str(region.number) for region in regions]
    if not numbers:
        return f": no {name}"
    if len(numbers) == 1:
        return f": {name} {numbers[0]}"
    return f": {name}s {numbers[0]} to {numbers[-1]}"


def _number(axes, region, scale):
    """A region's number where it has most clearance, with a leader where it would cover it."""
    x, y = scale * region.point
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    if not (left < x < right and low < y < high):
        return
    width = right - left
    box = dict(boxstyle="circle,pad=0.25", fc="white", ec=INK, lw=0.8)
    text = dict(ha="center", va="center", fontsize="small", fontweight="bold", bbox=box, color=INK)
    away = 0
    if scale * clearance_at(region, complex(*region.point)) <= 0.03 * width:
        if x >= (left + right) / 2 - 0.01 * width:
            away = 34
        else:
            away = -34
        text["arrowprops"] = dict(arrowstyle="-", color=INK, lw=0.8, shrinkA=0, shrinkB=0)
    place = dict(xytext=(away, 0), textcoords="offset points", zorder=6)
    axes.annotate(str(region.number), (x, y), **place, **text)


def _hatch(axes, region, scale):
    """What is inside the exact border."""
    paths = [Path(scale * np.concatenate([loop, loop[:1]])) for loop in region.polygons]
    style = dict(fc="none", ec=PINK, lw=0, hatch="//", alpha=0.6, zorder=2.5)
    axes.add_patch(PathPatch(Path.make_compound_path(*paths), **style))


def _degrees(axes, width):
    """Return the ticks of a range of angles, as many as have room."""
    steps = [step for step in (1, 5, 15, 30, 45, 90) if width / step <= 2.5 * inches_across(axes)]
    return MultipleLocator(steps[0] if steps else 180)
