"""The verb `page`: which page shows what."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from ...base.checks import shown, text
from ...linkages import Study
from ...singularities.maps import Map
from .document import Page, made
from .maps import map_content, map_models
from .runs import is_planned, is_run, runs_content, sampled
from .studies import studies_content, study_content

if TYPE_CHECKING:
    import numpy as np


def page(
    subject: object,
    path: str | Path | None = None,
    show: str | Iterable | None = None,
    title: str | None = None,
) -> Page:
    """A web page, complete in one file, on which pointing at a plot shows the mechanism in that
    state: Page.

    subject  a Run, a Plan or a TimedPath; a linkage's Study; a dict {name: Run} or {name: Study},
    to compare them; or a
             singularity map, a Map
    path     file to write (HTML in UTF-8); None: none, as for a notebook, in which the result shows
    itself
    show     of runs: names of QUANTITIES (pages.runs), in the order of the plots; of a study:
        quantity names, or lists
             of names of one unit that share a plot; None: the usual ones; not for a map. Nothing
             else is computed
    title    text over the page, None: the subject's own

    Raises ValueError for fewer than 2 samples, times that do not increase, names that do not exist,
    quantities of a reference where there is none; ImportError without Bokeh; OSError if the file
    cannot be written.
    """
    if not (path is None or isinstance(path, (str, os.PathLike))):
        raise TypeError(f"path must be a str or an os.PathLike, not {shown(path)}")
    if title is not None:
        text(title, "title")
    if not (
        show is None
        or isinstance(show, (str, list, tuple, dict, set, Iterator))
        or hasattr(show, "keys")
    ):
        raise TypeError(f"show must be a name or several, not {shown(show)}")
    if is_planned(subject):
        subject = sampled(subject)
    if is_run(subject):
        code, content = "motion", runs_content({"": subject}, show)
    elif (
        isinstance(subject, Mapping)
        and subject
        and all(isinstance(each, Study) for each in subject.values())
    ):
        code, content = "motion", studies_content(subject, show)
    elif isinstance(subject, Mapping):
        code, content = "motion", runs_content(subject, show)
    elif isinstance(subject, Study):
        code, content = "motion", study_content(subject, show)
    elif isinstance(subject, Map):
        if show is not None:
            raise ValueError("the page of a map shows the map's own margin: leave out show")
        return map_page(subject, path, title)
    else:
        known = "a Run, a Plan, a TimedPath, a Study, a dict of Runs or of Studies, or a Map"
        raise TypeError(f"subject: a page shows {known}, not {type(subject).__name__}")
    return made(path, code, content if title is None else content | {"title": str(title)})


def story(runs: Mapping, path: str | Path, show: Iterable, title: str, notes: list) -> Page:
    """Write a page of runs, each in its own picture, which plays once when it is opened; notes:
    sentences under it.
    """
    content = runs_content(runs, show)
    told = {"title": title, "notes": notes + content["notes"], "apart": True, "plays": True}
    return made(path, "motion", content | told)


def map_page(
    data: Map,
    path: str | Path | None,
    title: str | None = None,
    along: np.ndarray | None = None,
    regions: tuple | None = None,
) -> Page:
    """The page of a map; along: a path (n, 2) m on it; regions: of `dexterous`, in place of the
    aspects.
    """
    content = map_content(data, along, regions)
    return made(
        path, "map", content if title is None else content | {"title": title}, map_models(data)
    )
