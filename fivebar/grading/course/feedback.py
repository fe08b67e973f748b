"""What goes back to the students: a page for each, and all of them in a zip that Moodle takes."""

from __future__ import annotations

import zipfile
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from ...base.tables import written
from ..intake.cohort_folder import Entry
from ..intake.hand_in import MOODLE
from ..judging.results import Report, withheld
from ..report.outputs import file_name
from ..report.page import report_page
from .marks import Mark

FILE = "feedback.zip"
_NO_DATE = (1980, 1, 1, 0, 0, 0)  # so that the same pages make the same file


def page_for(report: Report, mark: Mark) -> str:
    """Return a student's page: his report, with his mark and the teacher's comment above it."""
    comment = f"Comment: {mark.comment}" if mark.comment else ""
    told = tuple(filter(None, (mark.sum(), *comment.splitlines())))
    shown = withheld(report)
    return report_page(replace(shown, notes=(*told, *shown.notes)))


def write_feedback(out: Path, pages: Iterable[tuple[Entry, str, str]]) -> None:
    """Write the zip of all (entry, name of the lab, page).

    Moodle's "upload multiple feedback files in a zip" finds a student by the name of the folder
    that his hand-in had; without one the folder is his id.
    """
    with (
        written(out / FILE, binary=True) as file,
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive,
    ):
        for entry, lab, page in pages:
            name = f"{_folder(entry)}/{lab}.html"
            archive.writestr(zipfile.ZipInfo(name, _NO_DATE), page, zipfile.ZIP_DEFLATED)


def _folder(entry):
    for part in entry.path.parts[::-1]:
        if found := MOODLE.fullmatch(part):
            return f"{found['name']}_{found['number']}_assignsubmission_file_"
    return file_name(entry.student)
