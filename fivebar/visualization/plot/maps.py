"""A map as a picture: one panel per mode with the field, the exact loci by type, the aspects'
numbers and a path.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context, rcParams
from matplotlib.colors import LogNorm, Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MultipleLocator

from ...base.checks import positive
from ...constraints.disc import clearance_at
from ...paths.placing.tool_regions import tool_regions
from ...singularities.maps import SIGNED
from ...singularities.passages import known_aspects
from ..loci import map_loci
from ..style import ALONG, DEXTEROUS, INK, PINK, field_scale, signs
from .panels import PALETTES, STYLES, draw, figure_legend, new_panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from ...singularities.maps import Map

WIDTHS: dict[Any, float] = {"column": 88.0, "page": 181.0}  # mm
HALO = [withStroke(linewidth=3.0, foreground="white")]


def singularity_map(
    data: Map,
    path: ArrayLike | None = None,
    dexterous: tuple | None = None,
    modes: Sequence | None = None,
    width: str | float = 240.0,
    axes: Any = None,
) -> Figure:
    """Return the figure of a singularity map: a panel for each mode, in mm or degrees.

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
        Of the figure, mm: 88 of a journal's column, a panel a row, or 181 of its page, two; their
        letters have 7 points.
    axes : Axes or sequence of Axes, optional
        Panels of a figure of one's own, one for each mode, whose curves have their names for
        its legend; a new figure without.

    Returns
    -------
    Figure
        Four working modes in task space, or both assembly modes in joint space.

    Raises
    ------
    ValueError
        For modes that the map does not have, and axes that do not fit.

    Examples
    --------
    >>> import fivebar as fb
    >>> data = fb.singularity_map(fb.FiveBar(), space="joint", shape=(21, 21))
    >>> figure = fb.plot.singularity_map(data)
    >>> figure.axes[0].get_title()
    'assembly mode +1'
    """
    known: list[Any] = list(data.modes)
    wanted: list[Any] = known if modes is None else list(modes)
    if not wanted or not all(mode in known for mode in wanted):
        raise ValueError(f"modes: {wanted}, where the map has {known}")
    inches = positive(WIDTHS.get(width) or width, "width") / 25.4
    columns = min(len(wanted), 1 if inches < 4 else 2)
    side = (inches - 1.6) / columns
    regions = dexterous
    robot: Any = data.robot
    if data.space == "task" and robot.turns and dexterous is None:
        regions = known_aspects(robot) if data.tool is None else tool_regions(data.tool, robot)
    loci = list(map_loci(data))
    with rc_context({"font.size": 10 if inches > 8 else 7}):
        height = side * np.clip(np.ptp(data.y) / np.ptp(data.x), 0.4, 2.0) + 0.35
        figure, panels = new_panels(axes, len(wanted), columns, side, height)
        if axes is None:
            figure.set_figwidth(inches)
        kinds: dict[str, None] = {}
        for panel, mode in zip(panels, wanted):
            own = [points for points in loci if known.index(mode) in points[1]]
            image = _panel(panel, data, known.index(mode), own, path, dexterous, regions, kinds)
        scale = field_scale(data)
        extend = "neither" if data.field in (*SIGNED, "transmission_angle") else "max"
        bar: dict[str, Any] = dict(label=scale.words, shrink=0.85, pad=0.02, extend=extend)
        colours = figure.colorbar(image, ax=list(panels), **bar)
        colours.ax.tick_params(labelsize=rcParams["font.size"])
        handles = [Line2D([], [], label=words, **STYLES[f"map.{words}"]) for words in kinds]
        if axes is None:
            figure_legend(figure, handles, columns + (inches > 8))
            for panel in panels:
                panel.label_outer()
    return figure


def _panel(axes, data, number, loci, path, dexterous, regions, kinds):
    """Draw one mode of a map; return the image of its field."""
    task = data.space == "task"
    robot: Any = data.robot
    turns = robot.turns
    scale, unit = (1e3, "mm") if task or not turns else (180 / np.pi, "deg")
    x = scale * data.x
    y = scale * data.y
    shown = field_scale(data)
    norm = (LogNorm if shown.logarithmic else Normalize)(shown.low, shown.high)
    colours = dict(cmap=PALETTES[shown.palette], norm=norm, interpolation="bilinear", zorder=0)
    # The image's borders are half a step beyond the outer nodes, the middles of its pixels.
    half_x = np.ptp(x) / (len(x) - 1) / 2
    half_y = np.ptp(y) / (len(y) - 1) / 2
    borders = x[0] - half_x, x[-1] + half_x, y[0] - half_y, y[-1] + half_y
    values = np.minimum(shown.factor * data.values[number], 1e12)  # inf, too, has a colour

    def show(words, points, **style):
        kinds[words] = None
        draw(axes, f"map.{words}", *(scale * np.asarray(points)).T, label=words, **style)

    image = axes.imshow(values, origin="lower", extent=borders, **colours)
    axes.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]), facecolor="#ececec", aspect="equal")
    for words, _, points in loci:
        show(words, points)
    for drive in robot.drives if task else ():
        if turns:
            show("base joint", [(drive.x, drive.y)])
        else:
            show("guide", [(drive.x, data.y[0]), (drive.x, data.y[-1])])
    mode = data.modes[number]
    here = [region for region in regions or () if region.working == mode]
    for region in here:
        if dexterous is not None:
            _hatch(axes, region, scale)
            for loop in region.polygons:
                closed = np.concatenate([loop, loop[:1]])
                show(DEXTEROUS, closed, path_effects=HALO)
        _number(axes, region, scale)
    if path is not None:
        points = np.asarray(path, dtype=float)
        show(ALONG, points, path_effects=HALO)
        for end, marker in ((0, "o"), (-1, "s")):
            draw(axes, "map.end", *(scale * points[[end]]).T, marker=marker)
    title = f"working modes ({signs(*mode)})" if task else f"assembly mode {signs(mode)}"
    if regions is not None:
        is_aspect = dexterous is None and data.tool is None
        title += _numbers("aspect" if is_aspect else "region", here)
    axes.set_title(title, fontsize="medium")
    names = "xy" if task else [f"$q_{{{name[1:]}}}$" for name in robot.words.joints]
    axes.set(xlabel=f"{names[0]} ({unit})", ylabel=f"{names[1]} ({unit})")
    axes.tick_params(labelsize=rcParams["font.size"])  # ticks are made later
    if unit == "deg":
        axes.xaxis.set_major_locator(_degrees(np.ptp(x)))
        axes.yaxis.set_major_locator(_degrees(np.ptp(y)))
    return image


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


def _degrees(width):
    steps = [step for step in (1, 5, 15, 30, 45, 90) if width / step <= 9]
    return MultipleLocator(steps[0] if steps else 180)
