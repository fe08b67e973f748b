"""Puts the marks into the sheet that Moodle or Canvas gave out, so that it takes the sheet back.

Moodle: an assignment's grading worksheet, rows "Participant 4711", in any language. Canvas: the
gradebook's export, numbers under "ID" and the points possible in a row of their own. Or any other
sheet with students' ids in a column. Only the cells of the marks are changed.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from ...base.errors import UsageError
from ..intake.students_robots import id_key
from ..labs import Lab
from ..report.text import number
from .marks import Mark
from .sheet import Sheet, number_in, read_sheet

# Titles in Moodle's worksheet.
GRADE = "grade note bewertung calificación valutazione nota cijfer".split()
MOST = "maximum grade,note maximale,bestwertung,calificación máxima,valutazione massima".split(",")
POSSIBLE = "points possible"  # Canvas' row
_NUMBER = re.compile(r"\D*(\d+)")
# "Wednesday, 25 November 2026, 3:31 PM", "mercredi 25 novembre 2026, 15:31", "25. November 2026"
_DATE = re.compile(
    r"(\d{1,2})\.? (?:de )?(\w{3,})\.? (?:de )?(\d{4})\D+(\d{1,2}):(\d\d)\s*([ap]m)?"
)
_MONTHS = (
    "jan gen ene,feb fév,mar mär,apr avr abr,may mai mag,jun juin giu,jul juil lug,aug aoû ago,"
    "sep set,oct okt ott,nov,dec déc dez dic"
)


@dataclass(frozen=True)
class Filled:
    """The sheet's text with its marks; how many; who has no row; rows without a hand-in."""

    text: str
    count: int
    no_row: list[str]
    no_hand_in: int


class Gradebook:
    """A learning platform's sheet, and the column for the marks of a lab in it.

    column: its title; None: Moodle's own, or the only one that names the lab.
    """

    def __init__(self, path: Path, lab: Lab, column: str | None = None):
        self.sheet = read_sheet(path)
        self.mark = _column(path, self.sheet.titles, lab, column)
        self.limit = ""
        self.students = []
        for k in range(1, len(self.sheet.rows)):
            if self.sheet.value(k, 0).strip().casefold() == POSSIBLE:
                self.limit = self.sheet.value(k, self.mark)
            elif any(self.sheet.rows[k]):
                self.students.append(k)

    def handed_in(self, student: str, moodle_number: str) -> datetime | None:
        """Return when a student handed in, where the sheet says it as Moodle's does; else None."""
        rows = _rows_of(self.sheet, student, moodle_number)
        if len(rows) != 1:
            return None
        cells = self.sheet.values(rows[0])
        for title, cell in zip(self.sheet.titles, cells):
            plain = title.casefold()
            if any(word in plain for word in GRADE):
                continue  # the time of the mark
            time = moodle_time(cell)
            if time is not None:
                return time
        return None

    def fill(self, marks: Iterable[Mark]) -> Filled:
        """Write each mark, scaled to the most that the sheet allows.

        Who has no mark yet keeps his cell: a person has to look. Decimal commas are kept.
        """
        most = self._column_of_the_most()
        if most is None:
            comma = self.sheet.has_comma(self.mark)
        else:
            comma = self.sheet.has_comma(self.mark, most)
        left = set(self.students)
        count = 0
        no_row = []
        for mark in marks:
            rows = _rows_of(self.sheet, mark.student, mark.number)
            left -= set(rows)
            if len(rows) != 1:
                no_row.append(mark.student)
            elif mark.points is not None:
                limit = self.limit
                if most is not None:
                    limit = self.sheet.value(rows[0], most)
                scale = number_in(limit) or mark.most
                text = number(mark.points * scale / mark.most)
                if comma:
                    text = text.replace(".", ",")
                self.sheet.put(rows[0], self.mark, text)
                count += 1
        return Filled(self.sheet.text, count, no_row, len(left))

    def _column_of_the_most(self):
        """Return the first column of the most that is possible, None where there is none."""
        for k, title in enumerate(self.sheet.titles):
            if title.casefold() in MOST:
                return k
        return None


def _column(path, titles, lab, wanted):
    plain = [title.casefold() for title in titles]
    if wanted is None:
        names = GRADE
        which = f"for {lab.name}"
    else:
        names = [wanted.strip().casefold()]
        which = repr(wanted)
    columns = [k for k, title in enumerate(plain) if title in names]
    if not columns and wanted is None:
        # "lab1" in "Lab 1 (77)" and "amoro" in "AMORO lab (123)", but "lab1" not in "Lab 10".
        first_word = lab.name.split("_")[0].casefold()
        spaced = " ?".join(re.escape(first_word))
        short = re.compile(rf"\b{spaced}\b")
        columns = [k for k, title in enumerate(plain) if short.search(title)]
    if len(columns) != 1:
        listed = ", ".join(titles)
        raise UsageError(
            f"{path} has {len(columns)} columns {which}: give --column one of {listed}"
        )
    return columns[0]


def _rows_of(sheet: Sheet, student: str, moodle_number: str) -> list[int]:
    """Return the rows of a student: by the number in the hand-in's name, else by his id in any
    cell.
    """
    rows = range(1, len(sheet.rows))
    if moodle_number:
        found = [k for k in rows if _has_number(sheet.values(k), moodle_number)]
        if found:
            return found
    wanted = id_key(student)
    found = []
    for k in rows:
        ids = map(id_key, sheet.values(k))
        if wanted in ids:
            found.append(k)
    return found


def _has_number(cells, wanted):
    for cell in cells[:2]:
        found = _NUMBER.fullmatch(cell.strip())
        if found and found[1] == wanted:
            return True
    return False


def moodle_time(text: str) -> datetime | None:
    """Return the time in a cell of Moodle's worksheet, in one of five languages; else None."""
    found = _DATE.search(text.casefold())
    if not found:
        return None
    day, word, year, hour, minute, half = found.groups()
    month = _month(word)
    if month is None:
        return None
    hours = int(hour)
    if half:
        hours %= 12
    if half == "pm":
        hours += 12
    try:
        return datetime(int(year), month, int(day), hours, int(minute))
    except ValueError:
        return None


def _month(word):
    """Return the number of the month of this name, None where it is none."""
    for k, names in enumerate(_MONTHS.split(","), 1):
        beginnings = tuple(names.split())
        if word.startswith(beginnings):
            return k
    return None
