"""Linkages as pictures: a study over time, the vector method's six plots, and coupler curves by
colour.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ...linkages.quantities import unit, usual_panels
from ..skeleton import study_body
from ..style import BASE, COLOURS, DASHES, INK, PALE, PATH, of_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...linkages import Curve, FourBar, Study

VECTOR_METHOD = {
    "distance": "Fig. 2: position",
    "speed": "Fig. 3: velocity",
    "total": "Fig. 4: acceleration",
    "tangential": "Fig. 5: tangential acceleration",
    "normal": "Fig. 6: normal acceleration",
    "curvature_radius": "Fig. 7: curvature radius",
}


def study_figure(study: Study, panels: Sequence | None = None) -> Figure:
    """Figure of a Study: the linkage with its traced path, and a panel over time for each list of
    quantity names.
    """
    panels = usual_panels(study) if panels is None else panels
    figure = Figure(figsize=(12, max(5.0, 1.9 * len(panels) + 0.6)), layout="constrained")
    grid = figure.add_gridspec(len(panels), 2, width_ratios=(1, 1.25))
    picture(figure.add_subplot(grid[:, 0]), study)
    first = None
    for row, names in enumerate(panels):
        axes = figure.add_subplot(grid[row, 1], sharex=first)
        first = first or axes
        _panel(axes, study, names)
        axes.tick_params(labelbottom=row == len(panels) - 1)
    axes.set_xlabel("time (s)")
    return figure


def picture(axes: Axes, study: Study) -> None:
    """The linkage in some of its poses, the first one dark, on equal axes in m."""
    body = study_body(study)
    points, traced = body.points, study.motion.chain.traced
    bars = list(zip(body.bars, body.colours))
    sliding = [(pair, PALE) for pair in (*body.moving_rails, *(block[:2] for block in body.blocks))]
    for sample in (*np.linspace(0, len(points) - 1, 6).astype(int)[1:-1], 0):
        first = sample == 0
        bar = dict(lw=3, marker="o", ms=5, mfc="white") if first else dict(lw=1.2, alpha=0.3)
        block = dict(lw=11, solid_capstyle="butt", alpha=0.75 if first else 0.15)
        for pairs, style in ((sliding, block), (bars, bar)):
            for pair, colour in pairs:
                axes.plot(*points[sample, pair].T, color=colour, zorder=2 + first, **style)
    axes.plot(*points[:, body.traced].T, color=PATH, lw=1.6, zorder=4, label=f"path of {traced}")
    axes.plot(
        *points[0, body.feet].T,
        color=BASE,
        marker="^",
        ms=9,
        mfc="white",
        ls=":",
        lw=1.2,
        zorder=1.5,
    )
    for rail in body.fixed_rails:
        axes.plot(*points[0, rail].T, color=BASE, lw=5, alpha=0.35, zorder=0)
    for name, place in zip(body.names, points[0]):
        axes.annotate(name, place, textcoords="offset points", xytext=(6, 6), fontsize=9)
    axes.margins(0.08)  # room for the names
    axes.set(
        xlabel="x (m)", ylabel="y (m)", title=f"{study.linkage.title}; at the start, later (pale)"
    )
    axes.set_aspect("equal", adjustable="datalim")
    axes.grid(alpha=0.25)
    axes.legend(fontsize=8, frameon=False, loc="upper right")


def vector_method_figure(study: Study, point: str = "M") -> Figure:
    """Figs. 2 to 7 of the vector method paper for a point of a Study: six panels over the crank
    angle.

    Zhauyt and others 2016: sizes of position, velocity and acceleration, its parts along and across
    the path, and the path's curvature radius (on a logarithmic scale: it has poles where the path
    has inflections).
    """
    figure = Figure(figsize=(12, 6.4), layout="constrained")
    crank = np.degrees(study.q)
    for axes, (own, title) in zip(figure.subplots(2, 3, sharex=True).flat, VECTOR_METHOD.items()):
        axes.plot(crank, study[f"{point}.{own}"], color=COLOURS[0], lw=1.5)
        axes.set_title(f"{title} of {point}", fontsize=10)
        axes.set_ylabel(f"({of_unit(unit(f'{point}.{own}'))})")
        axes.grid(alpha=0.25)
        axes.margins(x=0)
        if own == "curvature_radius":
            axes.set_yscale("log")
        if axes.get_subplotspec().is_last_row():
            axes.set_xlabel("crank angle (deg)")
    return figure


def coupler_curve_figure(curves: Sequence[Curve], linkages: Sequence[FourBar] = ()) -> Figure:
    """Figure of coupler curves, one colour for each label, with the fixed joints of `linkages`
    marked.

    curves: from `coupler_curves` of any four-bars, or from `type_2_curves` of a five-bar.
    """
    if not curves:
        raise ValueError("no curves to draw: the coupler closes at no crank angle")
    figure = Figure(figsize=(8, 7), layout="constrained")
    axes = figure.add_subplot()
    labels = list(dict.fromkeys(curve.label for curve in curves))
    for curve in curves:
        number = labels.index(curve.label)
        new = curve.label not in [line.get_label() for line in axes.lines]
        axes.plot(
            *curve.points.T,
            color=COLOURS[number % len(COLOURS)],
            ls=DASHES[number % len(DASHES)],
            lw=1.6,
            label=curve.label if new else None,
        )
    for four_bar in linkages:
        foot = np.add(
            four_bar.base,
            four_bar.ground * np.array([np.cos(four_bar.tilt), np.sin(four_bar.tilt)]),
        )
        axes.plot(
            *np.transpose([four_bar.base, foot]),
            color=BASE,
            marker="^",
            ms=9,
            mfc="white",
            ls="none",
        )
    axes.set(xlabel="x (m)", ylabel="y (m)", title="coupler curves")
    axes.set_aspect("equal", adjustable="datalim")
    axes.grid(alpha=0.25)
    axes.legend(fontsize=9, frameon=False, loc="upper left", bbox_to_anchor=(1, 1))
    return figure


def _panel(axes, study, names):
    for number, name in enumerate(names):
        own = unit(name)
        values = np.degrees(study[name]) if own == "rad" else study[name]
        axes.plot(study.t, values, color=COLOURS[number % len(COLOURS)], lw=1.4, label=name)
    if study.lock:
        axes.axvline(study.lock[1], color=INK, lw=1, ls=":")
    axes.set_ylabel(f"({'deg' if own == 'rad' else of_unit(own)})")
    axes.margins(x=0)
    axes.grid(alpha=0.25)
    axes.legend(fontsize=8, frameon=False, loc="center left", bbox_to_anchor=(1, 0.5))
