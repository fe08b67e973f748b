"""Puts the marks into the sheet that Moodle or Canvas gave out, so that it takes the sheet back.

Moodle: an assignment's grading worksheet, rows "Participant 4711", in any language. Canvas: the
gradebook's export, numbers under "ID" and the points possible in a row of their own. Or any other
sheet with students' ids in a column.
"""

from __future__ import annotations

import csv
import io
import re
from dataclasses import dataclass
from pathlib import Path

from ...base.errors import UsageError
from ..intake.cohort_folder import Entry
from ..labs import Lab
from ..report.text import number
from ..results import Report
from ..variants import id_key

# Titles in Moodle's worksheet.
GRADE = "grade note bewertung calificación valutazione nota cijfer".split()
MOST = "maximum grade,note maximale,bestwertung,calificación máxima,valutazione massima".split(",")
POSSIBLE = "points possible"  # Canvas' row
_NUMBER = re.compile(r"\D*(\d+)")
_COMMA = re.compile(r"\d+,\d+")


@dataclass(frozen=True)
class Filled:
    """The sheet's text with its marks; how many; who has no row, or no program; rows without a
    hand-in.
    """

    text: str
    count: int
    no_row: list[str]
    no_program: list[str]
    no_hand_in: int


def fill_gradebook(
    path: Path, lab: Lab, entries: list[Entry], reports: list[Report], column: str | None = None
) -> Filled:
    """Return the sheet with each graded student's mark in the column, scaled to the most that the
    sheet allows.

    column: its title; None: Moodle's own, or the only one that names the lab. Who is not graded, or
    handed in what holds no program that can be meant, keeps his cell: a person has to look. Decimal
    commas are kept.
    """
    text = _read(path)
    sign = max(",;\t", key=text.split("\n", 1)[0].count)
    try:
        rows = list(csv.reader(io.StringIO(text, newline=""), delimiter=sign))
    except csv.Error as error:
        raise UsageError(f"{path} is no sheet of marks: {error}") from None
    if len(rows) < 2 or len(rows[0]) < 2:
        raise UsageError(
            f"{path} is no sheet of marks: a line of titles and a line per student are asked"
        )
    titles = rows[0]
    rows = [row + [""] * (len(titles) - len(row)) if row else row for row in rows]
    mark = _column(path, titles, lab, column)
    most = next((k for k, title in enumerate(titles) if title.strip().casefold() in MOST), None)
    students = {k: row for k, row in enumerate(rows) if k and any(row)}
    limit = ""
    for k, row in list(students.items()):
        if row[0].strip().casefold() == POSSIBLE:
            limit = students.pop(k)[mark]
    cells = [row[k] for row in rows[1:] if row for k in (mark, most) if k is not None]
    # Excel parts cells by semicolons where a comma is decimal.
    comma = sign == ";" or any(_COMMA.fullmatch(cell.strip()) for cell in cells)
    count, no_row, no_program = 0, [], []
    for entry, report in zip(entries, reports):
        matches = _rows_of(entry, rows)
        if len(matches) != 1:
            no_row.append(entry.student)
        elif entry.trouble:
            no_program.append(entry.student)
        elif not report.ungraded:
            row = rows[matches[0]]
            scale = _float(limit if most is None else row[most])
            share = 1.0 if scale is None else scale / report.max_points
            points = number(report.points * share)
            row[mark] = points.replace(".", ",") if comma else points
            count += 1
        for k in matches:
            students.pop(k, None)
    file = io.StringIO(newline="")
    ending = "\r\n" if "\r\n" in text else "\n"
    csv.writer(file, delimiter=sign, lineterminator=ending).writerows(rows)
    return Filled(file.getvalue(), count, no_row, no_program, len(students))


def _read(path):
    try:
        return path.read_bytes().decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"--gradebook: {error}") from None


def _column(path, titles, lab, wanted):
    plain = [title.strip().casefold() for title in titles]
    short = lab.name.split("_")[0].casefold()
    names = GRADE if wanted is None else [wanted.strip().casefold()]
    columns = [k for k, title in enumerate(plain) if title in names]
    if not columns and wanted is None:
        lab_title = re.compile(rf"{short}\b")
        columns = [k for k, title in enumerate(plain) if lab_title.search(title.replace(" ", ""))]
    if len(columns) != 1:
        name = f"for {lab.name}" if wanted is None else repr(wanted)
        raise UsageError(
            f"{path} has {len(columns)} columns {name}: give --column one of {', '.join(titles)}"
        )
    return columns[0]


def _rows_of(entry, rows):
    """Return the rows of a student: by the number in the hand-in's name, else by his id in any
    cell.
    """
    if entry.number:
        found = [k for k, row in enumerate(rows) if k and _has_number(row, entry.number)]
        if found:
            return found
    key = id_key(entry.student)
    return [k for k, row in enumerate(rows) if k and key in map(id_key, row)]


def _has_number(row, number):
    cells = (_NUMBER.fullmatch(part.strip()) for part in row[:2])
    return any(cell and cell[1] == number for cell in cells)


def _float(text):
    try:
        value = float(text.strip().replace(",", "."))
    except ValueError:
        return None
    return value if 0 < value < 1e9 else None
