"""Linkages as pictures: a study over time, the vector method's six plots, and coupler curves by
colour.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...linkages.quantities import unit, usual_panels
from ..skeleton import study_body
from ..style import COLOURS, DASHES, PALE, of_unit
from .panels import STYLES, draw, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...linkages import Curve, FourBar, Study

VECTOR_METHOD = {
    "distance": "Fig. 2: position",
    "speed": "Fig. 3: velocity",
    "total": "Fig. 4: acceleration",
    "tangential": "Fig. 5: tangential acceleration",
    "normal": "Fig. 6: normal acceleration",
    "curvature_radius": "Fig. 7: curvature radius",
}


def draw_study(study: Study, panels: Sequence | None = None) -> Figure:
    """Draw a Study: the linkage with its traced path, and a panel over time for each list of
    quantity names.
    """
    panels = usual_panels(study) if panels is None else panels
    figure = new_figure(12, max(5.0, 1.9 * len(panels) + 0.6))
    grid = figure.add_gridspec(len(panels), 2, width_ratios=(1, 1.25))
    _picture(figure.add_subplot(grid[:, 0]), study)
    axes: Any = None
    for row, names in enumerate(panels):
        axes = figure.add_subplot(grid[row, 1], sharex=axes)
        angle = unit(names[0]) == "rad"
        for number, name in enumerate(names):
            values = np.degrees(study[name]) if angle else study[name]
            axes.plot(
                study.t,
                values,
                color=COLOURS[number % len(COLOURS)],
                lw=1.4,
                label=name,
            )
        if study.lock:
            axes.axvline(study.lock[1], **STYLES["line.limit"])
        axes.set_ylabel(f"({'deg' if angle else of_unit(unit(names[0]))})")
        axes.margins(x=0)
        axes.grid(alpha=0.25)
        axes.legend(
            fontsize=8,
            frameon=False,
            loc="center left",
            bbox_to_anchor=(1, 0.5),
        )
        axes.tick_params(labelbottom=row == len(panels) - 1)
    axes.set_xlabel("time (s)")
    return figure


def _picture(axes, study):
    """The linkage in some of its poses, the first one dark, on equal axes in m."""
    body = study_body(study)
    points = body.points
    sliding = [*body.moving_rails, *(block[:2] for block in body.blocks)]
    for sample in (
        *np.linspace(0, len(points) - 1, 6).astype(int)[1:-1],
        0,
    ):
        first = sample == 0
        block = dict(
            lw=11,
            solid_capstyle="butt",
            alpha=0.75 if first else 0.15,
            color=PALE,
        )
        if first:
            bar = dict(lw=3, marker="o", ms=5, mfc="white")
        else:
            bar = dict(lw=1.2, alpha=0.3)
        for pair in sliding:
            axes.plot(
                *points[sample, pair].T,
                zorder=2 + first,
                **block,
            )
        for pair, colour in zip(body.bars, body.colours):
            axes.plot(
                *points[sample, pair].T,
                color=colour,
                zorder=2 + first,
                **bar,
            )
    label = f"path of {study.motion.chain.traced}"
    draw(axes, "path.linkage", *points[:, body.traced].T, label=label)
    draw(
        axes,
        "path.feet",
        *points[0, body.feet].T,
        ls=":",
        lw=1.2,
        zorder=1.5,
    )
    for rail in body.fixed_rails:
        draw(axes, "path.rail", *points[0, rail].T)
    for name, place in zip(body.names, points[0]):
        axes.annotate(
            name,
            place,
            textcoords="offset points",
            xytext=(6, 6),
            fontsize=9,
        )
    axes.margins(0.08)  # for the names
    _plane(axes, f"{study.linkage.title}; at the start, later (pale)")
    axes.legend(fontsize=8, frameon=False, loc="upper right")


def _plane(axes, title):
    axes.set(xlabel="x (m)", ylabel="y (m)", title=title)
    axes.set_aspect("equal", adjustable="datalim")
    axes.grid(alpha=0.25)


def vector_method_figure(study: Study, point: str = "M") -> Figure:
    """Draw Figs. 2 to 7 of the vector method paper for a point: six panels over the crank angle.

    Zhauyt and others 2016: sizes of position, velocity and acceleration, its parts along and across
    the path, and the path's curvature radius (on a logarithmic scale: it has poles where the path
    has inflections).
    """
    figure = new_figure(12, 6.4)
    panels = figure.subplots(2, 3, sharex=True)
    for axes, (name, title) in zip(panels.flat, VECTOR_METHOD.items()):
        axes.plot(
            np.degrees(study.q),
            study[f"{point}.{name}"],
            color=COLOURS[0],
            lw=1.5,
        )
        axes.set_title(f"{title} of {point}", fontsize=10)
        axes.set_ylabel(f"({of_unit(unit(f'{point}.{name}'))})")
        axes.grid(alpha=0.25)
        axes.margins(x=0)
    axes.set_yscale("log")
    for axes in panels[1]:
        axes.set_xlabel("crank angle (deg)")
    return figure


def coupler_curve_figure(curves: Sequence[Curve], linkages: Sequence[FourBar] = ()) -> Figure:
    """Draw coupler curves, one colour for each label, with the fixed joints of `linkages` marked.

    curves: from `coupler_curves` of any four-bars, or from `type_2_curves` of a five-bar.
    """
    if not curves:
        raise ValueError("no curves to draw: the coupler closes at no crank angle")
    figure = new_figure(8, 7)
    axes = figure.add_subplot()
    labels: dict = {}
    for curve in curves:
        new = curve.label not in labels
        number = labels.setdefault(curve.label, len(labels))
        style: dict = dict(
            color=COLOURS[number % len(COLOURS)],
            ls=DASHES[number % len(DASHES)],
        )
        axes.plot(
            *curve.points.T,
            lw=1.6,
            label=curve.label if new else None,
            **style,
        )
    for four_bar in linkages:
        angle = four_bar.tilt
        foot = four_bar.base + four_bar.ground * np.array([np.cos(angle), np.sin(angle)])
        draw(axes, "path.feet", *np.transpose([four_bar.base, foot]))
    _plane(axes, "coupler curves")
    axes.legend(fontsize=9, frameon=False, loc="upper left", bbox_to_anchor=(1, 1))
    return figure
