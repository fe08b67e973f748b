"""A linkage's study on a page: over the crank angle where it turns one way, else over time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from ...base.tables import must_increase
from ...linkages.quantities import unit, usual_panels
from ..skeleton import study_body
from ..style import group_words, largest_of, names_of, of_unit
from .document import packed
from .samples import TIME, gap_notes, panel, samples_to_keep, subject

if TYPE_CHECKING:
    from ...linkages import Study


def studies_content(studies: Mapping[str, Study], show: str | Iterable | None = None) -> dict:
    """Return what the page of studies {name: Study} holds; a single one has the name "".

    One is drawn over its crank angle where this turns one way; of several each quantity has a plot
    over time, with a curve for each.
    """
    studies = {str(name): study for name, study in studies.items()}
    groups = _groups(list(studies.values()), show)
    names = list(dict.fromkeys(sum(groups, ())))
    alone = list(studies) == [""]
    axis = TIME
    subjects = []
    columns = {}
    notes = []
    size = 0.0
    for name, study in studies.items():
        body = study_body(study)
        size = max(size, largest_of(body.points))
        source = f"Study.to_csv of {name}" if name else "Study.to_csv"
        width = len(names) + 2 * body.points.shape[1] + 2
        keep, words = samples_to_keep(len(study.t), width * len(studies), source)
        columns[name] = {key: study[key][keep] for key in names}
        notes += words + _lock(name, study) + gap_notes(name, columns[name])
        x = None
        turn = np.diff(study.q, axis=0)
        if alone and study.q.ndim == 1 and ((turn > 0).all() or (turn < 0).all()):
            x = packed(study.q[keep])
            axis = {"name": "crank angle", "unit": "deg", "scale": 180 / np.pi}
        subjects.append(subject(name, study.t[keep], body.at(keep), columns[name], x=x))
    panels = []
    for group in groups if alone else [(name,) for name in names]:
        title, labels = group_words(group)
        curves = [
            (study or label, k, name, columns[study][name])
            for name, label in zip(group, labels)
            for k, study in enumerate(studies)
        ]
        panels.append(panel(title, unit(group[0]), curves, size=size, degrees=True))
    return {
        "title": study.linkage.title if alone else ", ".join(studies),
        "notes": notes,
        "axis": axis,
        "subjects": subjects,
        "panels": panels,
        "table": [[name, f"{name} ({of_unit(unit(name))})"] for name in names],
        "source": "Study.to_csv",
    }


def _lock(name, study):
    if not study.lock:
        return []
    angles = ", ".join(f"{angle:.6g}" for angle in np.degrees(np.atleast_1d(study.lock[0])))
    whose = f"The study {name}" if name else "The study"
    return [
        f"{whose} ends before the mechanism locks, at a crank angle of {angles} deg and"
        f" {study.lock[1]:.6g} s."
    ]


def _groups(studies, show):
    """Tuples of names that share a plot, refused where they are none or of several units."""
    for study in studies:
        must_increase(study.t, "the study")
    if show is None:
        show = usual_panels(studies[0])
    elif isinstance(show, str) or not isinstance(show, Iterable):
        show = [show]
    groups = [names_of(names) for names in show]
    if not any(groups):
        raise ValueError("show is empty: it needs names of the study's quantities")
    for group in groups:
        for study in studies:
            for name in group:
                study[name]  # refuses unknown names
        units = sorted(set(map(unit, group)))
        if len(units) != 1:
            raise ValueError(f"a plot has one unit, but {', '.join(group)} have {', '.join(units)}")
    return groups
