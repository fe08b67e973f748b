"""A linkage's study on a page: over the crank angle where it turns one way, else over time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from ...base.tables import must_increase
from ...linkages.quantities import unit, usual_panels
from ..names import names_of
from ..skeleton import study_body
from ..style import of_unit
from .document import packed
from .samples import gaps, kept, panel, subject

if TYPE_CHECKING:
    from ...linkages import Study


def study_content(study: Study, show: str | Iterable | None = None) -> dict:
    """What the page of a Study holds."""
    panels, names = _asked([study], show)
    turn = np.diff(study.q, axis=0)
    one_way = study.q.ndim == 1 and ((turn > 0).all() or (turn < 0).all())
    keep, body, columns, notes = _kept("", study, names, 1)
    x = packed(study.q[keep]) if one_way else None
    return {
        "title": study.linkage.title,
        "notes": notes,
        "axis": (
            {"name": "crank angle", "unit": "deg", "scale": 180 / np.pi}
            if one_way
            else {"name": "time", "unit": "s", "scale": 1.0}
        ),
        "subjects": [subject("", study.t[keep], body.at(keep), columns, x=x)],
        "panels": [
            _panel([(_short(name, own), 0, name, columns[name]) for name in own], own)
            for own in panels
        ],
        "table": [[name, f"{name} ({of_unit(unit(name))})"] for name in names],
        "source": "Study.to_csv",
    }


def studies_content(studies: Mapping[str, Study], show: str | Iterable | None = None) -> dict:
    """What the page of several studies {name: Study} holds: over time, each quantity with a curve
    for each.
    """
    studies = {str(name): study for name, study in studies.items()}
    _, names = _asked(list(studies.values()), show)
    found = {name: _kept(name, study, names, len(studies)) for name, study in studies.items()}
    return {
        "title": ", ".join(studies),
        "notes": [note for *_, notes in found.values() for note in notes],
        "axis": {"name": "time", "unit": "s", "scale": 1.0},
        "subjects": [
            subject(name, studies[name].t[keep], body.at(keep), columns)
            for name, (keep, body, columns, _) in found.items()
        ],
        "panels": [
            _panel(
                [
                    (own, k, name, columns[name])
                    for k, (own, (_, _, columns, _)) in enumerate(found.items())
                ],
                [name],
            )
            for name in names
        ],
        "table": [[name, f"{name} ({of_unit(unit(name))})"] for name in names],
        "source": "Study.to_csv",
    }


def _asked(studies, show):
    """(names that share a plot, all names), refused where they are none or of several units."""
    for study in studies:
        must_increase(study.t, "the study")
    one = isinstance(show, str) or not isinstance(show, Iterable)
    panels = [
        names_of(names)
        for names in (usual_panels(studies[0]) if show is None else [show] if one else show)
    ]
    names = list(dict.fromkeys(name for own in panels for name in own))
    if not names:
        raise ValueError("show is empty: it needs names of the study's quantities")
    for own in panels:
        units = {
            unit(name) for study in studies for name in own if study[name] is not None
        }  # refuses unknown names
        if len(units) != 1:
            raise ValueError(
                f"a plot has one unit, but {', '.join(own)} have {', '.join(sorted(units))}"
            )
    return panels, names


def _kept(name, study, names, count):
    """(samples that fit in, its body, columns of these quantities, notes)."""
    body = study_body(study)
    source = f"Study.to_csv of {name}" if name else "Study.to_csv"
    keep, notes = kept(len(study.t), (len(names) + 2 * body.points.shape[1] + 2) * count, source)
    columns = {each: study[each][keep] for each in names}
    if study.lock:
        at = ", ".join(f"{angle:.6g}" for angle in np.degrees(np.atleast_1d(study.lock[0])))
        whose = f"The study {name}" if name else "The study"
        notes.append(f"{whose} ends before the lock at {at} deg, {study.lock[1]:.6g} s.")
    return keep, body, columns, notes + gaps(name, columns)


def _alike(names):
    return len(names) > 1 and len({name.rpartition(".")[2] for name in names}) == 1


def _short(name, names):
    """Of quantities of one kind, as "coupler.angle" and "rocker.angle", their parts."""
    return name.rpartition(".")[0] if _alike(names) else name


def _panel(curves, names):
    title = names[0].rpartition(".")[2].replace("_", " ") if _alike(names) else ", ".join(names)
    own = panel(title, unit(names[0]), curves)
    return own | {"unit": "deg", "scale": 180 / np.pi} if unit(names[0]) == "rad" else own
