"""Linkages as pictures: a study over time, the vector method's six plots, and coupler curves by
colour.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np

from ...linkages.quantities import unit, usual_panels
from ..skeleton import study_body
from ..style import COLOURS, DASHES, group_words, largest_of, of_unit, shown_unit
from .panels import STYLES, draw, draw_points, note, over_time, plane
from .sheets import Sheet, new_figure

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


def draw_study(study: Study, sheet: Sheet, panels: Sequence | None = None) -> Figure:
    """Draw a Study: the linkage with its traced path, and a panel over time for each list of
    quantity names.
    """
    panels = usual_panels(study) if panels is None else panels
    of_panel = {", ".join(names): names for names in panels}
    shape = 12, max(5.0, 2.1 * len(of_panel) + 0.6)
    rows = [["linkage", name] for name in of_panel]
    figure, (picture, *over_t) = sheet.mosaic(rows, shape, of_panel, width_ratios=(1, 1.25))
    if sheet.axes is None:
        figure.suptitle(study.linkage.title)
    body = study_body(study)
    size = largest_of(body.points)
    _picture(picture, study, body)
    for row, (axes, names) in enumerate(zip(over_t, of_panel.values())):
        title, labels = group_words(names)
        columns = [study[name] for name in names]
        scale, shown = shown_unit(columns, unit(names[0]), size, degrees=True)
        for column, label, colour, dashes in zip(columns, labels, cycle(COLOURS), cycle(DASHES)):
            draw(axes, "line.medium", study.t, scale * column, color=colour, ls=dashes, label=label)
        if study.lock:
            label = "the mechanism locks" if row == 0 else None
            axes.axvline(study.lock[1], **STYLES["line.limit"], label=label)
        over_time(axes, 5, f"({shown})", title, last=row == len(over_t) - 1)
    return figure


def _picture(axes, study, body):
    """The linkage in some of its poses, the first one dark."""
    points = body.points
    sliding = [*body.moving_rails, *(block[:2] for block in body.blocks)]
    for sample in (*np.linspace(0, len(points) - 1, 6).astype(int)[1:-1], 0):
        kind = "" if sample == 0 else "-later"
        for pair in sliding:
            draw_points(axes, f"linkage.block{kind}", points[sample, pair])
        for pair, colour in zip(body.bars, body.colours):
            draw_points(axes, f"linkage.bar{kind}", points[sample, pair], color=colour)
    label = f"path of {study.motion.chain.traced}"
    draw_points(axes, "path.linkage", points[:, body.traced], label=label)
    draw_points(axes, "path.feet", points[0, body.feet], ls=":", lw=1.2, zorder=1.5)
    for rail in body.fixed_rails:
        draw_points(axes, "path.rail", points[0, rail])
    if study.lock:
        draw_points(axes, "mark.lock", points[-1, body.traced])
    for name, place in zip(body.names, points[0]):
        note(axes, name, place)
    axes.margins(0.08)  # for the names
    plane(axes, 2, "at the start, and later (pale)")
    axes.set_aspect("equal", adjustable="datalim")


def vector_method_figure(study: Study, point: str = "M") -> Figure:
    """Draw Figs. 2 to 7 of the vector method paper for a point: six panels over the crank angle.

    Zhauyt and others 2016: sizes of position, velocity and acceleration, its parts along and across
    the path, and the path's curvature radius (on a logarithmic scale: it has poles where the path
    has inflections).
    """
    figure = new_figure(12, 6.4)
    panels = figure.subplots(2, 3, sharex=True)
    for axes, (name, title) in zip(panels.flat, VECTOR_METHOD.items()):
        axes.plot(np.degrees(study.q), study[f"{point}.{name}"], color=COLOURS[0], lw=1.5)
        axes.set_title(f"{title} of {point}", fontsize=10)
        axes.set_ylabel(f"({of_unit(unit(f'{point}.{name}'))})")
        axes.grid(alpha=0.25)
        axes.margins(x=0)
    axes.set_yscale("log")
    for axes in panels[1]:
        axes.set_xlabel("crank angle (deg)")
    return figure


def coupler_curve_figure(curves: Sequence[Curve], linkages: Sequence[FourBar] = ()) -> Figure:
    """Draw coupler curves, one colour for each label, with the fixed joints of `linkages` marked,
    and the places where a mechanism locks.

    curves: from `coupler_curves` of any four-bars, or from `type_2_curves` of a five-bar.
    """
    if not curves:
        raise ValueError("no curves to draw: the coupler closes at no crank angle")
    figure = new_figure(8, 7)
    axes = figure.add_subplot()
    labels: dict = {}
    locked = False
    for curve in curves:
        new = curve.label not in labels
        number = labels.setdefault(curve.label, len(labels))
        style: dict = dict(color=COLOURS[number % len(COLOURS)], ls=DASHES[number % len(DASHES)])
        label = curve.label if new else None
        draw_points(axes, "line.medium", curve.points, label=label, **style)
        if len(curve.locks):
            label = None if locked else "the mechanism locks"
            draw_points(axes, "mark.lock", curve.locks, label=label)
            locked = True
    for four_bar in linkages:
        angle = four_bar.tilt
        foot = four_bar.base + four_bar.ground * np.array([np.cos(angle), np.sin(angle)])
        draw_points(axes, "path.feet", [four_bar.base, foot])
    plane(axes, 3, "coupler curves")
    return figure
