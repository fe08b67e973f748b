"""A plan as a picture: its path over the singularity loci, torques and limits, and how near it is
to singular.
"""

from __future__ import annotations

from dataclasses import astuple
from typing import TYPE_CHECKING

import numpy as np

from ...singularities.margins import Singularity
from ..loci import crossings
from ..skeleton import robot_body
from ..style import SIDES
from .panels import (
    LOCI,
    STYLES,
    draw,
    draw_level,
    draw_loci_of,
    draw_points,
    draw_robot,
    draw_torques,
    finish,
    mark_crossing,
    over_time,
    plane,
    set_window,
)
from .sheets import Sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...paths.tool import Tool
    from ...planning.plans import Plan


def draw_plan(plan: Plan, sheet: Sheet, tool: Tool | None = None) -> Figure:
    """Draw a Plan: path with the robot at both ends, torques, sines of both legs and det A.

    Where its modes are free, the loci are those of any modes. tool: whose path is drawn then, with
    the loci that it sees in the modes of the start.
    """
    over_t = "torques", "sines"
    rows = [["path", name] for name in over_t]
    figure, (path, *right) = sheet.mosaic(rows, (12, 7), over_t, width_ratios=(1, 1.1))
    # Every interval at both of its ends: torques may jump from one to the next.
    k, sigma = np.meshgrid(np.arange(len(plan.pieces.xi)), np.linspace(0, 1, 21), indexing="ij")
    k = k.ravel()
    sigma = sigma.ravel()
    t = plan.pieces.knots[k] + sigma * plan.pieces.widths[k]
    motion = plan.pieces.motion(k, sigma)
    pose = plan.accelerations(t).rates.pose
    crossed = [(Singularity(kind), place) for _, kind, _, place, _ in crossings(t, pose)]
    _path(path, plan, pose, crossed, tool)
    _torques(right[0], plan, t, motion[:, -2:])
    _sines(right[1], plan, t, pose)
    for axes in right:
        for kind, place in crossed:
            mark_crossing(axes, t[place], kind)
    return figure


def _path(axes, plan, pose, crossed, tool):
    working = plan.problem.working
    if tool is None:
        xi = pose.xi
        body = robot_body(plan.robot, pose.elbows, xi)
    else:
        xi = tool.point(pose)
        body = robot_body(plan.robot, pose.elbows, pose.xi, astuple(tool))
        working = tuple(pose.working[0].tolist())
    draw_robot(axes, body, 0, alpha=0.35)
    draw_robot(axes, body, -1)
    ends = set_window(axes, np.concatenate([*body.points[[0, -1]][:, body.joints], xi]))
    draw_loci_of(axes, plan.robot, working, ends, tool)
    draw_points(axes, "path.planned", xi)
    draw_points(axes, "mark.end", xi[0], marker="o")
    draw_points(axes, "mark.end", xi[-1], marker="s")
    if vias := [conditions[0] for conditions, _ in plan.problem.stops[1:-1]]:
        # A stop is a point or the four bars.
        still = [np.concatenate([at, np.zeros(2 * len(at))]) for at in vias]
        poses = [plan.problem.accelerations(motion).rates.pose for motion in still]
        points = [pose.xi if tool is None else tool.point(pose) for pose in poses]
        draw_points(axes, "mark.via", points)
    for kind, marker in ((Singularity.SERIAL, "+"), (Singularity.PARALLEL, "x")):
        if places := [place for other, place in crossed if other == kind]:
            label = f"crossing of {LOCI[kind]['label']}"
            draw_points(axes, "mark.crossing", xi[places], marker=marker, label=label)
    plane(axes, 4, "path, with the robot at start (pale) and goal")


def _torques(axes, plan, t, tau):
    words = plan.robot.words
    limit = f"limit, reached {100 * plan.saturated:.0f} % of the time"
    ylabel = draw_torques(axes, words, t, tau, plan.problem.constraints, limit)
    for knot in plan.pieces.knots:
        axes.axvline(knot, 0, 0.025, **STYLES["line.zero"])
    weights = {name: weight for name, weight in plan.problem.weights.items() if weight}
    goal = " + ".join(plan.aims)
    if len(weights) > 1:
        own = plan.aims[len(weights) :]
        goal = " + ".join([*(f"{weight:g} {name}" for name, weight in weights.items()), *own])
    axes.margins(x=0)
    title = f"{words.effort}s for least {goal}; {len(plan.pieces.xi)} intervals (ticks)"
    finish(axes, 4, ylabel=ylabel, title=title)


def _sines(axes, plan, t, pose):
    limits = plan.problem.constraints
    names = (r"\phi_1", r"\phi_2")
    if plan.robot.turns:
        names = "q_{12}", "q_{22}"
    for leg, (name, (_, colour)) in enumerate(zip(names, SIDES)):
        draw(axes, "line.medium", t, pose.sines[leg], color=colour, label=rf"$\sin {name}$")
        if limits.sin:
            limit = -plan.problem.working[leg] * limits.sin
            draw_level(axes, "line.limit", limit, color=colour)
    draw(axes, "line.determinant", t, pose.det_A)
    if limits.det_A:
        draw_level(axes, "line.limit", plan.problem.side * limits.det_A)
    draw_level(axes, "line.zero", 0)
    axes.set_ylim(-1.05, 1.05)
    over_time(axes, 3, "sine", "distance to singularities, with limits (dotted)")
