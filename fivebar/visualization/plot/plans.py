"""A plan as a picture: its path over the singularity loci, torques and limits, and how near it is
to singular.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from ...singularities.loci import singularity_loci
from ...singularities.margins import Singularity
from ..skeleton import robot_body
from ..style import INK, LEFT, REFERENCE, RIGHT, finish, readable
from .pose_panels import around, draw_robot

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...models.robots import Robot, Words
    from ...planning.plans import Plan

LOCI = {
    Singularity.SERIAL: dict(color="0.55", lw=1.2, ls="-", label="Type 1"),
    Singularity.PARALLEL: dict(color="0.35", lw=1.2, ls=(0, (6, 2.5)), label="Type 2"),
}


def planned(plan: Plan) -> Figure:
    """Figure of a Plan: path with the robot at both ends, torques, sines of both legs and det A.

    Where its modes are free, the loci are those of any modes, and the four bars' angles stand
    between.
    """
    free = plan.problem.working is None
    figure = Figure(figsize=(12, 9 if free else 7), layout="constrained")
    grid = figure.add_gridspec(2 + free, 2, width_ratios=(1, 1.1))
    # Every interval at both of its ends: torques may jump from one to the next.
    k, sigma = np.meshgrid(np.arange(len(plan.pieces.xi)), np.linspace(0, 1, 21), indexing="ij")
    k, sigma = k.ravel(), sigma.ravel()
    t = plan.pieces.knots[k] + sigma * plan.pieces.widths[k]
    motion = plan.pieces.motion(k, sigma)
    pose = plan.accelerations(t).rates.pose
    # Once, too, where a node is on the singularity.
    crossings = {
        kind: [i for margin in own for i in np.flatnonzero(np.diff(margin >= 0))]
        for kind, own in ((Singularity.SERIAL, pose.sines), (Singularity.PARALLEL, [pose.det_A]))
    }
    _path(figure.add_subplot(grid[:, 0]), plan, pose, crossings)
    above = figure.add_subplot(grid[0, 1])
    _torques(above, plan, t, motion[:, -2:])
    below = figure.add_subplot(grid[-1, 1], sharex=above)
    _sines(below, plan, t, pose)
    rows = [above, below]
    if free:
        rows.append(figure.add_subplot(grid[1, 1], sharex=above))
        _bars(rows[-1], plan, t, motion[:, :4])
    for axes in rows:
        for kind, places in crossings.items():
            for i in places:
                axes.axvline(t[i], **LOCI[kind] | dict(label=None, lw=0.8, color=INK))
    return figure


def _bars(axes, plan, t, bars):
    words = plan.robot.words
    scale, unit = (180 / np.pi, "deg") if plan.robot.turns else (1e3, "mm")
    for leg, (name, colour) in enumerate(zip(words.joints, (LEFT, RIGHT))):
        axes.plot(
            t, scale * bars[:, 2 * leg], color=colour, lw=1.4, label=f"$q_{{{name[1:]}}}$ ({unit})"
        )
        label = rf"$\phi_{leg + 1}$ (deg)"
        axes.plot(
            t,
            180 / np.pi * bars[:, 2 * leg + 1],
            color=colour,
            lw=1.4,
            ls=(0, (1.2, 1.2)),
            label=label,
        )
    axes.margins(x=0)
    finish(axes, 4, title="the four bars: proximal solid, distal dotted")


def _path(axes, plan, pose, crossings):
    xi = pose.xi
    body = robot_body(plan.robot, pose.elbows, xi)
    draw_robot(axes, body, 0, alpha=0.35)
    draw_robot(axes, body, -1)
    low, high = around(np.concatenate([*body.points[[0, -1]][:, body.joints], xi]))
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    draw_loci(axes, plan.robot, plan.problem.working, (low[1], high[1]))
    axes.plot(*(1e3 * xi.T), color=REFERENCE, lw=2.2, label="planned path", zorder=3)
    axes.plot(*(1e3 * xi[0]), "o", color=REFERENCE, mec="white", ms=8, zorder=4)
    axes.plot(*(1e3 * xi[-1]), "s", color=REFERENCE, mec="white", ms=8, zorder=4)
    for i, (conditions, _) in enumerate(plan.problem.stops[1:-1]):
        label = "via" if i == 0 else None
        axes.plot(
            *(1e3 * _point(plan, conditions[0])),
            "D",
            color=INK,
            mfc="white",
            ms=7,
            zorder=4,
            label=label,
        )
    for kind, marker in ((Singularity.SERIAL, "+"), (Singularity.PARALLEL, "x")):
        places = 1e3 * xi[crossings[kind]]
        if len(places):
            label = f"crossing of {LOCI[kind]['label']}"
            axes.plot(*places.T, marker, color=INK, ms=9, mew=1.6, ls="none", zorder=5, label=label)
    axes.set_aspect("equal")
    finish(
        axes,
        3 if crossings[Singularity.SERIAL] else 5,
        xlabel="x (mm)",
        ylabel="y (mm)",
        title="path, with the robot at start (pale) and goal",
    )


def draw_loci(axes: Axes, robot: Robot, working: tuple | None, ends: tuple | None = None) -> None:
    """The loci of these working modes (None: of all), each type named once; ends: y, mm, of those
    that have no ends, which are left out without.
    """
    known = set()
    for piece in singularity_loci(robot).task:
        if (
            working in (None, *piece.working)
            and len(piece.points) > 1
            and (ends or not piece.unbounded)
        ):
            style = LOCI[piece.type & ~Singularity.SERIAL or Singularity.SERIAL]
            label = style["label"] if style["label"] not in known else None
            known.add(style["label"])
            points = piece.drawn(ends[0] / 1e3, ends[1] / 1e3) if ends else piece.points
            axes.plot(*(1e3 * points).T, **(style | {"label": label}), zorder=0)


def _point(plan, at):
    """The end-effector at a stop, which is a point or the four bars."""
    at = np.array(at)
    motion = np.concatenate([at, np.zeros(2 * len(at))])
    return plan.problem.accelerations(motion).rates.pose.xi


def draw_torques(
    axes: Axes, words: Words, t: np.ndarray, tau: np.ndarray, limits: Any, limit: str
) -> str:
    """Torques (n, 2) and their limits, the first of these named `limit`; gives the unit."""
    most = limits.torque or (0.0, 0.0)
    scale, unit = readable(max(np.abs(tau).max(), *most), words.effort_unit)
    for leg, (name, colour) in enumerate((("left", LEFT), ("right", RIGHT))):
        axes.plot(t, scale * tau[:, leg], color=colour, lw=1.4, label=name)
        for side in (-1, 1) if most[leg] else ():
            label = limit if (leg, side) == (0, 1) else None
            axes.axhline(side * scale * most[leg], color=INK, lw=1, ls=":", label=label)
    return unit


def _torques(axes, plan, t, tau):
    own = plan.robot.words
    unit = draw_torques(
        axes,
        own,
        t,
        tau,
        plan.problem.constraints,
        f"limit, met {100 * plan.saturated:.0f} % of the time",
    )
    for knot in plan.pieces.knots:
        axes.plot(
            [knot, knot], [0, 0.025], color="0.5", lw=0.6, transform=axes.get_xaxis_transform()
        )
    weights = {name: weight for name, weight in plan.problem.weights.items() if weight}
    words = " + ".join(
        f"{weight:g} {name}" if len(weights) > 1 else name for name, weight in weights.items()
    )
    axes.margins(x=0)
    title = f"{own.effort}s for least {words}; {len(plan.pieces.xi)} intervals (ticks)"
    finish(axes, 4, ylabel=f"{own.effort} ({unit})", title=title)


def _sines(axes, plan, t, pose):
    limits = plan.problem.constraints
    names = (
        (r"$\sin q_{12}$", r"$\sin q_{22}$")
        if plan.robot.turns
        else (r"$\sin \phi_1$", r"$\sin \phi_2$")
    )
    for leg, (name, colour) in enumerate(zip(names, (LEFT, RIGHT))):
        axes.plot(t, pose.sines[leg], color=colour, lw=1.4, label=name)
        if limits.sin:
            axes.axhline(-plan.problem.working[leg] * limits.sin, color=colour, lw=1, ls=":")
    axes.plot(t, pose.det_A, color=INK, lw=1.8, label="det A")
    if limits.det_A:
        axes.axhline(plan.problem.side * limits.det_A, color=INK, lw=1, ls=":")
    axes.axhline(0, color=INK, lw=0.6)
    axes.margins(x=0)
    title = "distance to singularities, with limits (dotted)"
    finish(axes, 3, xlabel="time (s)", ylabel="sine", title=title, ylim=(-1.05, 1.05))
