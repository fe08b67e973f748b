"""What pictures have in common: panels of the plane and over time, a robot, loci, motors."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.transforms import Affine2D

from ...paths.placement import Placement
from ...singularities.loci import singularity_loci
from ...singularities.margins import Singularity
from .. import style as names
from ..loci import tool_loci
from ..style import INK, SIDES, readable
from .sheets import inches_across, small_letters

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from ...models.robots import Biglide, FiveBar, Words
    from ...paths.tool import Tool
    from ..skeleton import Skeleton

ENTRY = 0.8  # in, of a legend, about


def in_frame(figure: Figure, frame: Placement, scale: float = 1e3) -> Figure:
    """Return a figure whose panels of the plane, `scale` to a metre, are moved from the robot's own
    frame to the measuring one.
    """
    z = frame.turned
    move = Affine2D.from_values(z.real, z.imag, -z.imag, z.real, *(scale * np.array(frame.shift)))
    panels = [axes for axes in figure.axes if axes.get_aspect() == 1]
    if frame == Placement() or not panels:
        return figure
    (left, right), (below, above) = panels[0].get_xlim(), panels[0].get_ylim()
    for axes in panels:
        for artist in (*axes.lines, *axes.images, *axes.patches, *axes.collections):
            artist.set_transform(move + artist.get_transform())
        places: Any = axes.texts  # annotations
        for text in places:
            text.xy = move.transform(text.xy)
    corners = move.transform([(left, below), (right, below), (left, above), (right, above)])
    (left, below), (right, above) = corners.min(axis=0), corners.max(axis=0)
    panels[0].set(xlim=(left, right), ylim=(below, above))  # which all panels share
    return figure


def _part(name, low, high):
    colours = colormaps[name](np.linspace(low, high, 257))
    return LinearSegmentedColormap.from_list(name, colours, 257)


# All keep their order for colour-blind eyes; without their darkest ends, on which no line would be
# seen, and without the yellow, which is not seen on white.
PALETTES = {
    "diverging": LinearSegmentedColormap.from_list("signed", names.SIGNED_COLOURS, 257),
    "rising": _part("cividis", 0.35, 1.0),
    "lines": _part("viridis", 0.0, 0.78),
}
PALETTES["falling"] = PALETTES["rising"].reversed()
LOCI = {
    Singularity.SERIAL: dict(color="0.55", lw=1.2, ls="-", label="Type 1"),
    Singularity.PARALLEL: dict(color="0.35", lw=1.2, ls=(0, (6, 2.5)), label="Type 2"),
}


def _styles():
    """Return the style sheet: {group.kind: style}."""
    sheet = tomllib.loads((Path(__file__).parent / "styles.toml").read_text("utf-8"))
    styles = {}
    for group, kinds in sheet.items():
        for kind, style in kinds.items():
            for name, value in style.items():
                if isinstance(value, str):
                    style[name] = getattr(names, value, value)
                elif isinstance(value, list):
                    style[name] = tuple(value)
            styles[f"{group}.{kind}"] = style
    return styles


STYLES = _styles()


def finish(axes: Axes, columns: int, **words) -> None:
    """Set labels, title and limits of a panel, a pale grid, and its legend under it."""
    axes.set(**words)
    axes.title.set_wrap(True)
    axes.grid(alpha=0.25)
    columns = max(1, min(columns, int(inches_across(axes) / ENTRY)))
    # In letters, so that it clears the labels whatever the panel's height.
    pad = 5 if axes.get_xlabel() else 2.5
    place: dict = dict(loc="upper center", bbox_to_anchor=(0.5, 0), borderaxespad=pad)
    axes.legend(ncols=columns, fontsize=small_letters(), frameon=False, **place)


def figure_legend(figure: Figure, handles: list, columns: int, **style: Any) -> None:
    """Put a legend under all panels of a figure."""
    place: dict = dict(loc="outside lower center", ncols=columns, handlelength=3.2) | style
    figure.legend(handles=handles, fontsize=small_letters(), frameon=False, **place)


def plane(axes: Axes, columns: int = 0, title: str = "") -> None:
    """Make a panel one of the plane, in mm; with a legend of so many columns, if any."""
    axes.set_aspect("equal")
    words = dict(xlabel="x (mm)", ylabel="y (mm)", title=title)
    if columns:
        finish(axes, columns, **words)
    else:
        axes.set(**words)
        axes.grid(alpha=0.25)


def over_time(axes: Axes, columns: int, ylabel: str, title: str, last: bool = True) -> None:
    """Finish a panel over time, with the time's label under the last."""
    axes.margins(x=0)
    finish(axes, columns, xlabel="time (s)" if last else "", ylabel=ylabel, title=title)


def draw(axes: Axes, kind: str, x: ArrayLike, y: ArrayLike, **more) -> None:
    """Plot a line or marks in the style of their kind."""
    axes.plot(x, y, **STYLES[kind] | more)


def draw_points(axes: Axes, kind: str, points: ArrayLike, **more) -> None:
    """Plot points (..., 2) m in mm."""
    draw(axes, kind, *np.moveaxis(1e3 * np.asarray(points), -1, 0), **more)


def note(axes: Axes, text: str, point: np.ndarray) -> None:
    """Write a note beside a point (2,) m."""
    axes.annotate(
        text,
        tuple(1e3 * point),
        xytext=(6, 5),
        fontsize=small_letters(),
        textcoords="offset points",
    )


def draw_level(axes: Axes, kind: str, *levels: float, **more) -> None:
    """Draw horizontal lines; the label is the first one's."""
    for level in levels:
        axes.axhline(level, **STYLES[kind] | more)
        more.pop("label", None)


def draw_robot(axes: Axes, body: Skeleton, sample: int = 0, **style) -> None:
    """Draw a robot in mm: a hue for each leg, its proximal bar dark; squares are its motors.

    Guides go from border to border.
    """
    points = body.points[sample]
    # A bar folded back lies under the other.
    for bar, colour in reversed(list(zip(body.bars, body.colours))):
        draw_points(axes, "robot.bar", points[list(bar)], color=colour, **style)
    draw_points(axes, "robot.motor", points[list(body.actuated)], **style)
    for low, _ in body.rails:
        axes.axvline(1e3 * points[low, 0], **STYLES["robot.guide"])


def set_window(axes: Axes, points: np.ndarray) -> tuple[float, float]:
    """Let a panel show all points (..., 2) m, with room around them; return its y limits, mm."""
    points = 1e3 * points.reshape(-1, 2)
    low = points.min(axis=0)
    high = points.max(axis=0)
    margin = 0.12 * (high - low).max()
    (left, low), (right, high) = low - margin, high + margin
    axes.set(xlim=(left, right), ylim=(low, high))
    return low, high


def draw_loci_of(axes: Axes, robot: Any, working: Any, ends: tuple, tool: Tool | None) -> None:
    """Draw the loci of joint C, or those that a tool sees."""
    if tool is None:
        draw_loci(axes, robot, working, ends)
    else:
        draw_tool_loci(axes, tool, robot, working)


def draw_loci(
    axes: Axes, robot: FiveBar | Biglide, working: tuple | None, ends: tuple | None = None
) -> None:
    """Draw the loci of these working modes (None: of all), each type named once.

    ends: y, mm, of those that have no ends, which are left out without.
    """
    known = set()
    for piece in singularity_loci(robot).task:
        endless = piece.unbounded and not ends
        if working not in (None, *piece.working) or len(piece.points) == 1 or endless:
            continue
        style: dict = dict(LOCI[piece.type & ~Singularity.SERIAL or Singularity.SERIAL])
        if style["label"] in known:
            del style["label"]
        known.add(style.get("label"))
        if ends:
            points = piece.drawn(ends[0] / 1e3, ends[1] / 1e3)
        else:
            points = piece.points
        axes.plot(*(1e3 * points).T, zorder=0, **style)


def draw_tool_loci(axes: Axes, tool: Tool, robot: FiveBar, working: tuple[int, int]) -> None:
    """Draw the borders of the regions that a tool sees in these modes, each type named once."""
    known = set()
    for locus, points in tool_loci(tool, robot, working):
        style: dict = dict(LOCI[Singularity.PARALLEL & locus.type or Singularity.SERIAL])
        if style["label"] in known:
            del style["label"]
        known.add(style.get("label"))
        axes.plot(*(1e3 * points.T), zorder=0, **style)


def mark_crossing(axes: Axes, place: float, kind: Singularity) -> None:
    """Mark where a singularity is crossed on a panel over time or way."""
    axes.axvline(place, ls=LOCI[kind]["ls"], lw=0.8, color=INK)


def draw_torques(
    axes: Axes, words: Words, t: np.ndarray, tau: np.ndarray, limits: Any, limit: str
) -> str:
    """Draw torques (n, 2) and their limits, named once as `limit`; return the axis's label."""
    most = limits.torque or (0.0, 0.0)
    scale, unit = readable(max(np.abs(tau).max(), *most), words.effort_unit)
    for leg, (name, colour) in enumerate(SIDES):
        draw(axes, "line.medium", t, scale * tau[:, leg], color=colour, label=name)
        if most[leg]:
            label = None if leg else limit
            draw_level(axes, "line.limit", scale * most[leg], -scale * most[leg], label=label)
    return f"{words.effort} ({unit})"


def draw_measured(
    axes: Axes, t: np.ndarray, pair: np.ndarray, words: Words, colour: str, label: str
) -> str:
    """Draw measured and computed efforts (2, n) of a motor; return the axis's label."""
    sizes = np.abs(pair)[np.isfinite(pair)]
    scale, unit = readable(sizes.max(initial=0.0), words.effort_unit)
    measured, computed = scale * pair
    draw(axes, "line.measured", t, measured)
    draw(axes, "line.thin", t, computed, color=colour, label=label)
    draw(axes, "line.difference", t, measured - computed)
    return f"{words.effort} ({unit})"
