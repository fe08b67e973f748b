"""The verb `page`: which page shows what."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...base.checks import text
from ...linkages import Study
from ...simulation.run import Run
from ...singularities.maps import Map
from ..functions import pose_functions, script
from .document import Page, make_page
from .maps import map_content
from .runs import is_planned, runs_content, sampled
from .studies import studies_content

if TYPE_CHECKING:
    import numpy as np


def page(
    subject: Any,
    path: str | Path | None = None,
    show: str | Iterable | None = None,
    title: str | None = None,
) -> Page:
    """Return a web page in one file on which pointing at a plot shows the mechanism in that state.

    Parameters
    ----------
    subject : Run, Plan, TimedPath, Study, Map, or dict of Runs or Studies by name
        What is shown; those of a dict are compared.
    path : str or path, optional
        File to write (HTML in UTF-8).
    show : str or sequence, optional
        Of runs: names of QUANTITIES (pages.runs), in the order of the plots. Of a study: names of
        quantities, or lists of names of one unit that share a plot. The usual ones by default;
        nothing else is computed.
    title : str, optional
        Text over the page; the subject's own by default.

    Returns
    -------
    Page
        In a notebook it shows itself.

    Raises
    ------
    ValueError
        For fewer than 2 samples, times that do not increase, names that do not exist, and
        quantities of a reference where there is none.
    ImportError
        Without Bokeh.

    Examples
    --------
    >>> import fivebar as fb
    >>> robot = fb.FiveBar()
    >>> line = fb.line((0.09, 0.068), (0.05, 0.08), 0.1)
    >>> fb.page(fb.simulate(robot, fb.ComputedTorque(robot, 100, 20), line), title="A line")
    <Page: A line>
    """
    if title is not None:
        text(title, "title")
    if is_planned(subject):
        subject = sampled(subject)
    if isinstance(subject, Map):
        if show is not None:
            raise ValueError("the page of a map shows the map's own margin: leave out show")
        return map_page(subject, path, title)
    if not isinstance(subject, Mapping):
        subject = {"": subject}
    if subject and all(isinstance(one, Study) for one in subject.values()):
        content = studies_content(subject, show)
    elif "" not in subject or isinstance(subject[""], Run):
        content = runs_content(subject, show)
    else:
        known = "a Run, a Plan, a TimedPath, a Study, a dict of Runs or of Studies, or a Map"
        kind = type(subject[""]).__name__
        raise TypeError(f"subject: a page shows {known}, not {kind}")
    return make_page(path, "motion", content | ({} if title is None else {"title": title}))


def story(runs: Mapping, path: str | Path, show: Iterable, title: str, notes: list) -> Page:
    """Write a page of runs, each in its own picture, which plays once when it is opened.

    notes: sentences under it.
    """
    content = runs_content(runs, show)
    more = {"title": title, "notes": notes + content["notes"], "apart": True, "plays": True}
    return make_page(path, "motion", content | more)


def map_page(
    data: Map,
    path: str | Path | None,
    title: str | None = None,
    along: np.ndarray | None = None,
    regions: tuple | None = None,
) -> Page:
    """Return the page of a map, with the robot's igm and dgm in JavaScript.

    along: a path (n, 2) m on it; regions: of `dexterous`, in place of the aspects.
    """
    content = map_content(data, along, regions)
    if title is not None:
        content["title"] = title
    return make_page(path, "map", content, script(pose_functions(data.robot)))
