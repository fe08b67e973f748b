"""The plane as a tool on a distal bar sees it."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

from matplotlib.patches import PathPatch
from matplotlib.path import Path as MplPath

from ...paths.placing.tool_regions import tool_regions
from ..style import signs
from .panels import draw_points, draw_tool_loci, figure_legend, new_figure, plane

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...models.robots import FiveBar
    from ...paths.tool import Tool

AREA = "#d9e8f5"


def tool_map(tool: Tool, robot: FiveBar) -> Figure:
    """Return the figure of where a tool goes, a panel for each working mode, in mm.

    Parameters
    ----------
    tool : Tool
    robot : FiveBar

    Returns
    -------
    Figure
        Regions without a singularity, with their numbers as in `tool_regions`, and the loci that
        the tool sees.

    Examples
    --------
    >>> import fivebar as fb
    >>> figure = fb.plot.tool_map(fb.Tool(1, 0.02), fb.FiveBar())
    >>> len(figure.axes)
    4
    """
    regions = tool_regions(tool, robot)
    figure = new_figure(9.6, 9.0)
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    for axes, mode in zip(panels.flat, product((-1, 1), (-1, 1))):
        here = [region for region in regions if region.working == mode]
        for region in here:
            loops = [MplPath(1e3 * polygon, closed=True) for polygon in region.polygons]
            area = MplPath.make_compound_path(*loops)
            axes.add_patch(PathPatch(area, facecolor=AREA, edgecolor="none", zorder=-1))
            axes.text(*(1e3 * region.point), str(region.number))
        draw_tool_loci(axes, tool, robot, mode)
        for drive in robot.drives:
            draw_points(axes, "robot.motor", (drive.x, drive.y))
        numbers = ", ".join(str(region.number) for region in here) or "none"
        plane(axes, title=f"working modes ({signs(*mode)}): region {numbers}")
        axes.label_outer()
    handles = []
    for axes in panels.flat:
        handles += [line for line in axes.lines if line.get_label() in ("Type 1", "Type 2")]
    named = {line.get_label(): line for line in handles}
    figure_legend(figure, list(named.values()), 2)
    return figure
