"""The table of marks: the points of all labs beside what the teacher writes into it by hand."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ...base.errors import UsageError
from ..intake.cohort_folder import Entry
from ..intake.students_robots import name_key
from ..judging.results import Report
from ..report.outputs import plain_cell
from ..report.text import nothing_is_filled_in, number
from .cohort import trouble_of
from .items import has_marks
from .sheet import Sheet, number_in, quoted, read_sheet

FILE = "marks.csv"
# The teacher's columns that have a meaning; "report /10" and all others are his own, too.
ADJUST = "adjust"
COMMENT = "comment"
DAYS_LATE = "days late"
EXTRA_DAYS = "extra days"
UNTOUCHED = "nothing is filled in"  # a state: it has a mark, of no points
HIS = (ADJUST, COMMENT, DAYS_LATE, EXTRA_DAYS)
AFTER = ("lost for late days", "mark", "of", "state", "same program as", "file", "trouble")
_OUT_OF = re.compile(r"(.+?)\s*/\s*(\d+(?:[.,]\d+)?)")


@dataclass(frozen=True)
class Mark:
    """A student's mark: points of `most`, None where a person has to look first; `state` says why.

    results: lab -> (entry, report), the best of his attempts; by_hand: the teacher's cells; lost:
    points, for being late.
    """

    student: str
    number: str
    results: Mapping[str, tuple[Entry, Report]]
    by_hand: Mapping[str, str]
    points: float | None
    most: float
    lost: float
    state: str
    same: tuple[str, ...] = field(default=(), compare=False)

    @property
    def comment(self) -> str:
        return self.by_hand.get(COMMENT, "").strip()

    def sum(self) -> str:
        """Return how the mark comes about, in a sentence."""
        if self.points is None:
            return ""
        parts = []
        for lab, (_, report) in self.results.items():
            points = f"{number(report.points)} of {number(report.max_points)}"
            parts.append(f"{lab} {'no program' if report.no_program else points}")
        for title, cell in self.by_hand.items():
            value = number_in(cell)
            found = _OUT_OF.fullmatch(title)
            if value is not None and found:
                parts.append(f"{found[1]} {number(value)} of {found[2]}")
        if self.lost:
            parts.append(f"-{number(self.lost)} for late days")
        adjust = number_in(self.by_hand.get(ADJUST, ""))
        if adjust:
            sign = "+" if adjust > 0 else "-"
            parts.append(f"{sign}{number(abs(adjust))} by hand")
        total = f"{number(self.points)} of {number(self.most)}"
        if len(parts) == 1:
            return f"Mark: {total}."
        return f"Mark: {total} ({', '.join(parts)})."


def best_of(entries: Iterable[Entry], reports: Iterable[Report]) -> dict[str, tuple[Entry, Report]]:
    """Return student's id -> (entry, report) of the best of his attempts."""
    found: dict[str, tuple[Entry, Report]] = {}
    for entry, report in zip(entries, reports):
        key = name_key(entry.student)
        if key in found:
            _, best = found[key]
            if _worth(report) <= _worth(best):
                continue
        found[key] = entry, report
    return found


def _worth(report):
    return has_marks(report), report.points


class Table:
    """The teacher's cells of an earlier table of marks, by student; none where there is no table
    yet.
    """

    def __init__(self, out: Path, labs: Iterable[str]):
        self.path = out / FILE
        self.labs = tuple(labs)
        self.sheet: Sheet | None = None
        self.titles = list(HIS)
        self.names: list[str] = []
        self.cells: dict[str, dict[str, str]] = {}
        if self.path.exists():
            self.sheet = read_sheet(self.path)
            self._read(self.sheet)

    def _read(self, sheet):
        titles = sheet.titles
        if "student" not in titles:
            raise UsageError(f'{self.path} has no column "student": which mark is whose?')
        doubled = [title for title in titles if title and titles.count(title) > 1]
        if doubled:
            raise UsageError(f"{self.path} has two columns {doubled[0]!r}")
        ours = {"student", *self.labs, *AFTER, ""}
        self.titles = [title for title in titles if title not in ours]
        self.titles += [title for title in HIS if title not in self.titles]
        for k in range(1, len(sheet.rows)):
            row = dict(zip(titles, sheet.values(k)))
            name = row["student"].strip()
            if not name:
                continue
            key = name_key(name)
            if key in self.cells:
                raise UsageError(f"{self.path} has two rows of {name}")
            self.cells[key] = {title: row.get(title, "") for title in self.titles}
            self.names.append(name)

    def by_hand(self, student: str) -> dict[str, str]:
        key = name_key(plain_cell(student))
        empty = dict.fromkeys(self.titles, "")
        return self.cells.get(key, empty)

    def number(self, student: str, title: str) -> float | None:
        """Return what the teacher wrote, None where nothing. Raises UsageError for no number."""
        cells = self.by_hand(student)
        text = cells.get(title, "").strip()
        value = number_in(text)
        if text and value is None:
            raise UsageError(f"{self.path}, {student}: {title} is {text!r}, which is no number")
        if value is not None and value < 0 and title != ADJUST:
            raise UsageError(f"{self.path}, {student}: {title} is {text}, and must be at least 0")
        return value

    def out_of(self) -> dict[str, float]:
        """Return title -> the most of it, of the teacher's columns "report /10"."""
        most = {}
        for title in self.titles:
            found = _OUT_OF.fullmatch(title)
            if found:
                most[title] = number_in(found[2]) or 0.0
        return most

    def mark(
        self,
        student: str,
        moodle_number: str,
        results: Mapping[str, tuple[Entry, Report]],
        most: Mapping[str, float],
        late: tuple[float, float],
        same: tuple[str, ...] = (),
    ) -> Mark:
        """Return a student's mark.

        most: of each lab that counts; late: (days late as far as they are known, the share of the
        mark that a day costs).
        """
        adjust = self.number(student, ADJUST)
        out_of = self.out_of()
        parts = {title: self.number(student, title) for title in out_of}
        points = sum(report.points for _, report in results.values())
        points += sum(part for part in parts.values() if part is not None)
        days, share = late
        typed = self.number(student, DAYS_LATE)
        extra = self.number(student, EXTRA_DAYS)
        if typed is not None:
            days = typed
        if extra is not None:
            days -= extra
        begun_days = max(0, math.ceil(days - 1e-9))
        lost_share = min(1.0, share * begun_days)
        lost = round(points * lost_share, 2)
        state = _state(results, most, parts)
        # What is written under "adjust" says that a person has looked, 0 as well.
        looked = adjust is not None and "not graded" not in state
        total = None
        if state in ("graded", UNTOUCHED) or looked:
            total = points - lost + (adjust or 0.0)
            total = max(0.0, round(total, 2))
        whole = sum(most.values()) + sum(out_of.values())
        by_hand = self.by_hand(student)
        return Mark(student, moodle_number, results, by_hand, total, whole, lost, state, same)

    def without_hand_in(self, known: set[str]) -> list[str]:
        """Return the students of the table of whom nothing was found."""
        keys = {name_key(plain_cell(student)) for student in known}
        return [name for name in self.names if name_key(name) not in keys]

    def text(self, marks: Iterable[Mark]) -> str:
        """Return the whole table again, in the dialect in which it was read."""
        sign = self.sheet.sign if self.sheet else ","
        titles = ["student", *self.labs, *AFTER, *self.titles]
        lines = [_line(titles, sign)]
        for mark in marks:
            ours = [_written(value, sign) for value in self._values(mark)]
            by_hand = [mark.by_hand[title] for title in self.titles]
            lines.append(_line(ours + by_hand, sign))
        # With the mark in front Excel reads accents.
        return "\ufeff" + "".join(lines)

    def _values(self, mark):
        """Return what is ours of a row: numbers, and texts."""
        yield mark.student
        for lab in self.labs:
            _, report = mark.results.get(lab, (None, None))
            if report and has_marks(report):
                yield report.points
            else:
                yield ""
        files = []
        troubles = []
        for entry, report in mark.results.values():
            trouble = trouble_of(report)
            if entry.name:
                files.append(entry.name)
            if trouble and trouble not in troubles:
                troubles.append(trouble)
        yield mark.lost or ""
        yield "" if mark.points is None else mark.points
        yield mark.most
        yield mark.state
        yield ", ".join(mark.same)
        yield ", ".join(files)
        yield "; ".join(troubles)


def _written(value, sign):
    """Return a number as the dialect has it, or a text that no spreadsheet takes for a formula."""
    if isinstance(value, str):
        return plain_cell(value)
    text = number(value)
    if sign == ";":
        return text.replace(".", ",")
    return text


def _line(cells, sign):
    written = [quoted(text, sign) for text in cells]
    return sign.join(written) + "\r\n"


def _state(results, most, parts):
    """Return "graded", or what keeps a student from a mark or is to be known of it."""
    if not results:
        return "no hand-in of this name"
    ungraded = []
    absent = []
    for lab in most:
        _, report = results.get(lab, (None, None))
        if report and (report.ungraded or report.faults):
            ungraded.append(lab)
        if not report or report.no_program:
            absent.append(lab)
    empty_cells = [title for title, part in parts.items() if part is None]
    if ungraded:
        return f"not graded: {', '.join(ungraded)}"
    if absent and len(most) > 1:
        return f"no program: {', '.join(absent)}"
    if absent:
        return "no program"
    if empty_cells:
        return f"waits for {', '.join(empty_cells)}"
    if all(nothing_is_filled_in(report) for _, report in results.values()):
        return UNTOUCHED
    return "graded"
