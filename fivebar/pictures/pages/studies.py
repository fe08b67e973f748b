"""A linkage's study on a page: over the crank angle where it turns one way, else over time."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from ...linkages.quantities import unit, usual_panels
from ...tables import must_increase
from ..names import names_of
from ..skeleton import study_body
from .document import packed
from .samples import gaps, kept, panel, subject

if TYPE_CHECKING:
    from ...linkages import Study


def study_content(study: Study, show: str | Iterable | None = None) -> dict:
    """What the page of a Study holds."""
    must_increase(study.t, "the study")
    one = isinstance(show, str) or not isinstance(show, Iterable)
    panels = [names_of(names) for names in (usual_panels(study) if show is None else [show] if one else show)]
    names = list(dict.fromkeys(name for own in panels for name in own))
    if not names:
        raise ValueError("show is empty: it needs names of the study's quantities")
    values = {name: study[name] for name in names}  # refuses names it does not know
    for own in panels:
        units = {unit(name) for name in own}
        if len(units) != 1:
            raise ValueError(f"a plot has one unit, but {', '.join(own)} have {', '.join(sorted(units))}")
    body, turn = study_body(study), np.diff(study.q, axis=0)
    keep, notes = kept(len(study.t), len(names) + 2 * body.points.shape[1] + 2, "Study.to_csv")
    one_way = study.q.ndim == 1 and ((turn > 0).all() or (turn < 0).all())
    columns = {name: column[keep] for name, column in values.items()}
    if study.lock:
        at = ", ".join(f"{angle:.6g}" for angle in np.degrees(np.atleast_1d(study.lock[0])))
        notes.append(f"The study ends before the lock at {at} deg, {study.lock[1]:.6g} s.")
    return {
        "title": study.linkage.title,
        "notes": notes + gaps("", columns),
        "axis": {"name": "crank angle", "unit": "deg", "scale": 180 / np.pi}
        if one_way
        else {"name": "time", "unit": "s", "scale": 1.0},
        "subjects": [
            subject("", study.t[keep], body.at(keep), columns, legs=False, x=packed(study.q[keep]) if one_way else None)
        ],
        "panels": [_panel(own, columns) for own in panels],
        "table": [[name, f"{name} ({unit(name)})"] for name in names],
        "source": "Study.to_csv",
    }


def _panel(names, columns):
    """The plot of these quantities; those of one kind, as "coupler.angle" and "rocker.angle", by their parts."""
    kinds = {name.rpartition(".")[2] for name in names}
    alike = len(names) > 1 and len(kinds) == 1
    title = kinds.pop().replace("_", " ") if alike else ", ".join(names)
    curves = [(name.rpartition(".")[0] if alike else name, 0, name, columns[name]) for name in names]
    own = panel(title, unit(names[0]), curves)
    return own | {"unit": "deg", "scale": 180 / np.pi} if unit(names[0]) == "rad" else own
