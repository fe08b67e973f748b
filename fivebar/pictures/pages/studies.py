"""A linkage's study on a page: over the crank angle where it turns one way, else over time."""

import numpy as np

from ...linkages.quantities import unit, usual_panels
from ...tables import must_increase
from .document import packed
from .samples import gaps, joints, kept, panel


def study_content(study, show=None):
    """What the page of a Study holds."""
    must_increase(study.t, "the study")
    panels = usual_panels(study) if show is None else [show] if isinstance(show, str) else show
    panels = [[names] if isinstance(names, str) else names for names in panels]
    names = list(dict.fromkeys(name for own in panels for name in own))
    if not names:
        raise ValueError("show is empty: it needs names of the study's quantities")
    values = {name: study[name] for name in names}  # refuses names it does not know
    for own in panels:
        units = {unit(name) for name in own}
        if len(units) != 1:
            raise ValueError(f"a plot has one unit, but {', '.join(own)} have {', '.join(sorted(units))}")
    points, turn = study.points(), np.diff(study.q, axis=0)
    keep, notes = kept(len(study.t), len(names) + 2 * points.shape[1] + 2, "Study.to_csv")
    one_way = study.q.ndim == 1 and ((turn > 0).all() or (turn < 0).all())
    columns = {name: column[keep] for name, column in values.items()}
    if study.lock:
        at = ", ".join(f"{angle:.6g}" for angle in np.degrees(np.atleast_1d(study.lock[0])))
        notes.append(f"The study ends before the lock at {at} deg, {study.lock[1]:.6g} s.")
    chain, index = study.motion.chain, study.motion.points.index
    fixed = [rail for rail in chain.rails if set(rail) <= set(chain.grounded)]
    bars = [*chain.bars, *(rail for rail in chain.rails if rail not in fixed)]
    return {
        "title": study.linkage.title,
        "notes": notes + gaps("", columns),
        "axis": {"name": "crank angle", "unit": "deg", "scale": 180 / np.pi}
        if one_way
        else {"name": "time", "unit": "s", "scale": 1.0},
        "subjects": [
            {
                "name": "",
                "t": packed(study.t[keep]),
                "x": packed(study.q[keep]) if one_way else None,
                "joints": joints(points[keep]),
                "names": ["" if name in chain.marks else name.removeprefix("joint ") for name in study.motion.points],
                "bars": [[index(a), index(b), None] for a, b in bars],
                "rails": [list(map(index, rail)) for rail in fixed],
                "blocks": [list(map(index, block[:2])) for block in chain.blocks],
                "pins": sorted({index(name) for bar in bars for name in bar if name not in chain.marks}),
                "grounded": [index(name) for name in chain.grounded if name not in chain.marks],
                "actuated": [index(name) for name in chain.actuated],
                "traced": index(chain.traced),
                "reference": None,
                "columns": {name: packed(column) for name, column in columns.items()},
                "marks": [],
            }
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
