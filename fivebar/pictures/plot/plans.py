"""A plan as a picture: its path over the singularity loci, torques and limits, and how near it is to singular."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ...singularities.loci import singularity_loci
from ...singularities.margins import Singularity
from ..skeleton import robot_body
from ..style import INK, LEFT, REFERENCE, RIGHT, finish, readable
from .pose_panels import around, draw_robot

if TYPE_CHECKING:
    from ..motions import Plan

LOCI = {
    Singularity.SERIAL: dict(color="0.55", lw=1.2, ls="-", label="Type 1"),
    Singularity.PARALLEL: dict(color="0.35", lw=1.2, ls=(0, (6, 2.5)), label="Type 2"),
}


def planned(plan: Plan) -> Figure:
    """Figure of a Plan: path with the robot at both ends, torques, sines of both legs and det A."""
    figure = Figure(figsize=(12, 7), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.1))
    # Every interval at both of its ends: torques may jump from one to the next.
    k, sigma = np.meshgrid(np.arange(len(plan.pieces.xi)), np.linspace(0, 1, 21), indexing="ij")
    k, sigma = k.ravel(), sigma.ravel()
    t = plan.pieces.knots[k] + sigma * plan.pieces.widths[k]
    motion = plan.pieces.motion(k, sigma)
    pose = plan.accelerations(t).rates.pose
    crossings = np.flatnonzero(np.diff(pose.det_A >= 0))  # once, too, where a node is on the singularity
    _path(figure.add_subplot(grid[:, 0]), plan, motion[:, :2], pose, crossings)
    above = figure.add_subplot(grid[0, 1])
    _torques(above, plan, t, motion[:, 6:])
    below = figure.add_subplot(grid[1, 1], sharex=above)
    _sines(below, plan, t, pose)
    for axes in (above, below):
        for i in crossings:
            axes.axvline(t[i], color=INK, lw=0.8, ls=(0, (6, 2.5)))
    return figure


def _path(axes, plan, xi, pose, crossings):
    body = robot_body(plan.robot, pose.elbows, xi)
    draw_robot(axes, body, 0, alpha=0.35)
    draw_robot(axes, body, -1)
    low, high = around(np.concatenate([*body.points[[0, -1]][:, body.joints], xi]))
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    known = set()
    for piece in singularity_loci(plan.robot).task:
        if plan.problem.working in piece.working and len(piece.points) > 1:
            style = LOCI[piece.type & ~Singularity.SERIAL or Singularity.SERIAL]
            label = style["label"] if style["label"] not in known else None
            known.add(style["label"])
            points = 1e3 * piece.drawn(low[1] / 1e3, high[1] / 1e3)
            axes.plot(*points.T, **(style | {"label": label}), zorder=0)
    axes.plot(*(1e3 * xi.T), color=REFERENCE, lw=2.2, label="planned path", zorder=3)
    axes.plot(*(1e3 * xi[0]), "o", color=REFERENCE, mec="white", ms=8, zorder=4)
    axes.plot(*(1e3 * xi[-1]), "s", color=REFERENCE, mec="white", ms=8, zorder=4)
    for i, (conditions, _) in enumerate(plan.problem.stops[1:-1]):
        label = "via" if i == 0 else None
        axes.plot(*(1e3 * np.array(conditions[0])), "D", color=INK, mfc="white", ms=7, zorder=4, label=label)
    for i, crossing in enumerate(crossings):
        label = "crossing" if i == 0 else None
        axes.plot(*(1e3 * xi[crossing]), "x", color=INK, ms=8, mew=1.6, ls="none", zorder=5, label=label)
    axes.set_aspect("equal")
    finish(axes, 5, xlabel="x (mm)", ylabel="y (mm)", title="path, with the robot at start (pale) and goal")


def _torques(axes, plan, t, tau):
    limits = plan.problem.limits.torque or (0.0, 0.0)
    own = plan.robot.words
    scale, unit = readable(max(np.abs(tau).max(), *limits), own.effort_unit)
    for leg, (name, colour) in enumerate((("left", LEFT), ("right", RIGHT))):
        axes.plot(t, scale * tau[:, leg], color=colour, lw=1.4, label=name)
        for side in (-1, 1) if limits[leg] else ():
            label = f"limit, met {100 * plan.saturated:.0f} % of the time" if (leg, side) == (0, 1) else None
            axes.axhline(side * scale * limits[leg], color=INK, lw=1, ls=":", label=label)
    for knot in plan.pieces.knots:
        axes.plot([knot, knot], [0, 0.025], color="0.5", lw=0.6, transform=axes.get_xaxis_transform())
    weights = {name: weight for name, weight in plan.problem.weights.items() if weight}
    words = " + ".join(f"{weight:g} {name}" if len(weights) > 1 else name for name, weight in weights.items())
    axes.margins(x=0)
    title = f"{own.effort}s for least {words}; {len(plan.pieces.xi)} intervals (ticks)"
    finish(axes, 4, ylabel=f"{own.effort} ({unit})", title=title)


def _sines(axes, plan, t, pose):
    limits = plan.problem.limits
    names = (r"$\sin q_{12}$", r"$\sin q_{22}$") if plan.robot.turns else (r"$\sin \phi_1$", r"$\sin \phi_2$")
    for leg, (name, colour) in enumerate(zip(names, (LEFT, RIGHT))):
        axes.plot(t, pose.sines[leg], color=colour, lw=1.4, label=name)
        axes.axhline(-plan.problem.working[leg] * limits.serial, color=colour, lw=1, ls=":")
    axes.plot(t, pose.det_A, color=INK, lw=1.8, label="det A")
    if limits.parallel is not None:
        axes.axhline(plan.problem.side * limits.parallel, color=INK, lw=1, ls=":")
    axes.axhline(0, color=INK, lw=0.6)
    axes.margins(x=0)
    title = "distance to singularities, with limits (dotted)"
    finish(axes, 3, xlabel="time (s)", ylabel="sine", title=title, ylim=(-1.05, 1.05))
