"""A map as a picture: one panel per mode with the field, the exact loci by type, the aspects'
numbers and a path.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import LinearSegmentedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MultipleLocator

from ...singularities.aspects import aspects
from ...singularities.loci import singularity_loci
from ...singularities.maps import SIGNED, turned_into
from ...singularities.margins import Singularity
from ..style import (
    ACROSS,
    ALONG,
    DEXTEROUS,
    GREEN,
    INK,
    PINK,
    POINTS,
    TYPE_1,
    TYPE_2,
    TYPE_3,
    field_scale,
    locus_words,
)

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ...singularities.maps import Map


def _part(name, low, high):
    return LinearSegmentedColormap.from_list(
        name, colormaps[name](np.linspace(low, high, 257)), 257
    )


# Both keep their order for colour-blind eyes; without their darkest ends, on which no line would be
# seen.
PALETTES = {"diverging": _part("PuOr", 0.14, 0.86), "rising": _part("cividis", 0.35, 1.0)}
PALETTES["falling"] = PALETTES["rising"].reversed()
PALETTES["lines"] = _part("viridis", 0.0, 0.78)  # without the yellow, which is not seen on white
OUTSIDE = "#ececec"
HALO = [withStroke(linewidth=3.0, foreground="white")]
# Lines differ by their dashes, so that they are told apart in any colours.
_LINE, _POINT = (
    dict(color=INK, lw=1.5),
    dict(color=INK, marker="x", ms=5.5, mew=1.4, ls="none", zorder=4),
)
STYLES = {
    TYPE_1: _LINE | dict(ls="-"),
    ACROSS: _LINE | dict(ls="-"),
    TYPE_2["stretched"]: _LINE | dict(ls=(0, (6, 2.5))),
    TYPE_2["folded"]: _LINE | dict(ls=(0, (6, 2, 1, 2))),
    TYPE_2["self-motion"]: _LINE | dict(lw=1.7, ls=(0, (1.2, 1.6))),
    TYPE_3: dict(color=INK, marker="D", ms=4.5, mfc="white", mew=1.1, ls="none"),
    POINTS[Singularity.SERIAL]: _POINT,
    POINTS[Singularity.PARALLEL]: _POINT | dict(marker="+", ms=8),
    "base joint": dict(color="#555555", marker="^", ms=9, mfc="white", ls="none", zorder=3),
    "guide": dict(color="#b0b0b0", lw=5, ls="-", solid_capstyle="butt", zorder=0.5),
    ALONG: dict(color=GREEN, lw=2.0, ls="-"),
    DEXTEROUS: dict(color=PINK, lw=1.8, ls="-"),
}


def singularity_map(
    data: Map, path: ArrayLike | None = None, dexterous: tuple | None = None
) -> Figure:
    """Figure of a maps.Map: four working modes in task space, mm, or both assembly modes in joint
    space, degrees (mm).

    path: points (n, 2) of the map's own space, m or rad, drawn on all panels; dexterous: regions of
    `fb.dexterous`, drawn and numbered in place of the aspects. `savefig` writes it (PNG, SVG, PDF).
    """
    task, turns = data.space == "task", data.robot.turns
    scale, unit = (1e3, "mm") if task or not turns else (180 / np.pi, "deg")
    extent = [scale * limit for axis in (data.x, data.y) for limit in (axis[0], axis[-1])]
    height = np.clip((extent[3] - extent[2]) / (extent[1] - extent[0]), 0.4, 2.0)
    figure = Figure(
        figsize=(9.6, 1.0 + (2 if task else 1) * (0.35 + 3.75 * height)), layout="constrained"
    )
    panels = figure.subplots(2 if task else 1, 2, sharex=True, sharey=True)
    regions = (
        (dexterous if dexterous is not None else aspects(data.robot)) if task and turns else None
    )
    name = "aspect" if dexterous is None else "region"
    shown = field_scale(data)
    norm = (LogNorm if shown.logarithmic else Normalize)(shown.low, shown.high)
    colours = dict(cmap=PALETTES[shown.palette], norm=norm, interpolation="bilinear", zorder=0)
    values = np.minimum(shown.factor * data.values, 1e12)  # inf, too, has a colour
    known = {}
    for axes, mode, layer in zip(panels.flat, data.modes, values):
        borders = _to_borders(extent, layer.shape)
        image = axes.imshow(layer, origin="lower", extent=borders, **colours)
        axes.set(xlim=extent[:2], ylim=extent[2:], facecolor=OUTSIDE)
        axes.set_aspect("equal")
        (_task_loci if task else _joint_loci)(axes, data, mode, scale, known)
        own = [a for a in regions or () if a.working == mode]
        for region in own if dexterous is not None else ():
            _outline(axes, region, scale, known)
        _aspect_numbers(axes, own, scale)
        if path is not None:
            _path(axes, scale * np.asarray(path, dtype=float), known)
        axes.set_title(_title(data, mode, regions, name), fontsize=10)
        axes.label_outer()
    across, up = ("x", "y") if task else (f"$q_{{{name[1:]}}}$" for name in data.robot.words.joints)
    for axes in panels.flat:
        subplot = axes.get_subplotspec()
        axes.set_xlabel(f"{across} ({unit})") if subplot.is_last_row() else None
        axes.set_ylabel(f"{up} ({unit})") if subplot.is_first_col() else None
        if unit == "deg":
            axes.xaxis.set_major_locator(_degrees(extent[1] - extent[0]))
            axes.yaxis.set_major_locator(_degrees(extent[3] - extent[2]))
    extend = "neither" if data.field in (*SIGNED, "transmission_angle") else "max"
    figure.colorbar(image, ax=panels, label=shown.words, shrink=0.85, pad=0.02, extend=extend)
    handles = [Line2D([], [], label=words, **style) for words, style in known.items()]
    figure.legend(
        handles=handles,
        loc="outside lower center",
        ncols=3,
        fontsize=9,
        frameon=False,
        handlelength=3.2,
    )
    return figure


def _to_borders(extent, shape):
    """The image's borders: half a step beyond the outer nodes, which are the middles of its
    pixels.
    """
    dx, dy = (
        (extent[1] - extent[0]) / (shape[1] - 1) / 2,
        (extent[3] - extent[2]) / (shape[0] - 1) / 2,
    )
    return extent[0] - dx, extent[1] + dx, extent[2] - dy, extent[3] + dy


def _title(data, mode, regions, name):
    if data.space == "joint":
        return f"assembly mode {mode:+d}".replace("-", "−")
    modes = f"working modes ({mode[0]:+d}, {mode[1]:+d})".replace("-", "−")
    if regions is None:
        return modes
    numbers = [str(a.number) for a in regions if a.working == mode]
    listed = (
        f"{name}s {numbers[0]} to {numbers[-1]}" if len(numbers) > 1 else " ".join([name, *numbers])
    )
    if not numbers:
        listed = f"no {name}"
    return f"{modes}: {listed}"


def _draw(axes, known, words, points, **style):
    known.setdefault(words, STYLES[words])
    axes.plot(*points.T, label=words, **STYLES[words] | style)


def _task_loci(axes, data, mode, scale, known):
    loci = singularity_loci(data.robot)
    for piece in loci.task:
        if mode in piece.working:
            _draw(axes, known, locus_words(piece), scale * piece.drawn(data.y[0], data.y[-1]))
    threes = [
        xi
        for xi, own in zip(loci.type3.xi, loci.type3.working)
        if all(o in (0, m) for o, m in zip(own, mode))
    ]
    if threes:
        _draw(axes, known, TYPE_3, scale * np.array(threes))
    for drive in data.robot.drives:
        if data.robot.turns:
            _draw(axes, known, "base joint", scale * np.array([[drive.x, drive.y]]))
        else:
            _draw(
                axes,
                known,
                "guide",
                scale * np.array([(drive.x, y) for y in (data.y[0], data.y[-1])]),
            )


def _joint_loci(axes, data, mode, scale, known):
    """The loci of this assembly mode; as angles they repeat with every turn."""
    loci = singularity_loci(data.robot)
    own = [piece for piece in loci.joint if mode in piece.assembly]
    if not data.robot.turns:
        for piece in own:
            _draw(axes, known, locus_words(piece), scale * piece.drawn(data.x[0], data.x[-1]))
        return
    for words, points in [
        *((locus_words(p), p.points) for p in own),
        *((TYPE_3, q[None]) for q in loci.type3.q),
    ]:
        for turned in turned_into(data, points):
            _draw(axes, known, words, scale * turned)


def _aspect_numbers(axes, regions, scale):
    """Each number at its aspect's roomiest point, with a leader where it would cover the aspect."""
    width = np.ptp(axes.get_xlim())
    for aspect in regions:
        x, y = scale * aspect.point
        if not (
            axes.get_xlim()[0] < x < axes.get_xlim()[1]
            and axes.get_ylim()[0] < y < axes.get_ylim()[1]
        ):
            continue
        box = dict(boxstyle="circle,pad=0.25", fc="white", ec=INK, lw=0.8)
        text = dict(
            ha="center", va="center", fontsize=9, fontweight="bold", bbox=box, zorder=6, color=INK
        )
        if scale * aspect.clearance > 0.03 * width:
            axes.text(x, y, str(aspect.number), **text)
        else:
            towards = (34 if x >= sum(axes.get_xlim()) / 2 - 0.01 * width else -34, 0)
            arrow = dict(arrowstyle="-", color=INK, lw=0.8, shrinkA=0, shrinkB=0)
            axes.annotate(
                str(aspect.number),
                (x, y),
                towards,
                textcoords="offset points",
                arrowprops=arrow,
                **text,
            )


def _outline(axes, region, scale, known):
    """The exact border, what is inside hatched."""
    loops = [scale * np.concatenate([loop, loop[:1]]) for loop in region.polygons]
    codes = [[Path.MOVETO, *[Path.LINETO] * (len(loop) - 1)] for loop in loops]
    inside = Path(np.concatenate(loops), np.concatenate(codes))
    axes.add_patch(PathPatch(inside, fc="none", ec=PINK, lw=0, hatch="//", alpha=0.6, zorder=2.5))
    for loop in loops:
        _draw(axes, known, DEXTEROUS, loop, zorder=3.5, path_effects=HALO)


def _path(axes, points, known):
    _draw(axes, known, ALONG, points, path_effects=HALO, zorder=5)
    axes.plot(*points[0], "o", color=GREEN, mec="white", ms=7, zorder=5.5)
    axes.plot(*points[-1], "s", color=GREEN, mec="white", ms=7, zorder=5.5)


def _degrees(width):
    return MultipleLocator(
        next((step for step in (1, 5, 15, 30, 45, 90) if width / step <= 9), 180)
    )
