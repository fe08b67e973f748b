"""A course's folder of results: all labs of the hand-ins graded, and what comes of the results."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from ...base.errors import UsageError
from ..intake.cohort_folder import Entry, HandIn, entries_of, find_hand_ins, not_graded
from ..intake.hand_in import Left, functions_of, source_of
from ..intake.students_robots import name_key
from ..judging.results import Report
from ..labs import Lab
from ..report.outputs import write_whole
from .cohort import Cohort, begin, run_cohort
from .cohort_page import Group, write_summary
from .copies import equal_programs
from .feedback import page_for, write_feedback
from .gradebook import Filled, Gradebook
from .items import summary_text
from .marks import FILE, Mark, Table, best_of
from .settings import Settings


@dataclass(frozen=True)
class Graded:
    """One lab's results: all attempts; by name the best of each student; groups of equal
    programs.
    """

    cohort: Cohort
    attempts: list[tuple[Entry, Report]]
    best: dict[str, tuple[Entry, Report]]
    equal: list[Group]

    @property
    def name(self) -> str:
        return self.cohort.lab.name

    @property
    def reports(self) -> list[Report]:
        return [report for _, report in self.best.values()]

    @property
    def most(self) -> float:
        return max((report.max_points for report in self.reports), default=0.0)


class Course:
    """One grading of a main lab, and of the labs of its family of which there are files.

    students: name -> (id, the learning platform's number); ignored: (student, what of his is not
    graded); graded: the labs' results; marks: of all students.
    """

    def __init__(self, lab: Lab, out: Path, settings: Settings, book: Gradebook | None = None):
        self.lab = lab
        self.out = out
        self.settings = settings
        self.book = book
        self.entries: dict[Lab, list[Entry]] = {}
        self.students: dict[str, tuple[str, str]] = {}
        self.ignored: list[tuple[str, Left]] = []
        self.graded: list[Graded] = []
        self.marks: list[Mark] = []

    def find(self, folders: Iterable[Path], file: str | None, must_be_told_apart: bool) -> None:
        """Look for hand-ins; each folder holds one attempt of each student."""
        hand_ins: list[HandIn] = []
        for folder in folders:
            found, left = find_hand_ins(folder, must_be_told_apart, self.lab.with_others())
            hand_ins += found
            self.ignored += [("", item) for item in left]
        for lab in self._labs():
            entries = entries_of(hand_ins, lab, file, named=lab != self.lab)
            if entries or lab == self.lab:
                self.entries[lab] = entries
        graded: list[Entry] = []
        for entries in self.entries.values():
            graded += entries
        for hand_in in hand_ins:
            student = hand_in.student
            self.students[name_key(student)] = student, hand_in.number
            for item in not_graded(hand_in, graded):
                self.ignored.append((student, item))

    def _labs(self):
        """Return the labs that may count: the family's, or those of it that the settings name."""
        labs = {lab.name: lab for lab in self.lab.with_others()}
        wanted = self.settings.labs
        if wanted is None:
            return list(labs.values())
        unknown = set(wanted) - set(labs)
        if unknown:
            raise UsageError(f"course.toml: labs names {', '.join(unknown)}; there are {[*labs]}")
        return [labs[name] for name in wanted]

    def grade(self, how: tuple, jobs: int) -> None:
        """Run all programs that have no result yet. how: of a `Cohort`, from its seed on."""
        self._table()  # what is wrong with it is better known now
        for lab, entries in self.entries.items():
            out = self.out
            if lab != self.lab:
                out = self.out / lab.name
            cohort = begin(Cohort(lab, out, *how))
            results = run_cohort(cohort, entries, jobs)
            reports = list(map(self.settings.weighted, results))
            attempts = list(zip(entries, reports))
            best = best_of(entries, reports)
            equal = _equal(lab, best)
            self.graded.append(Graded(cohort, attempts, best, equal))

    def _table(self):
        return Table(self.out, [lab.name for lab in self.entries])

    def reports(self) -> list[Report]:
        """Return the report of each student's best attempt, lab by lab."""
        return [report for graded in self.graded for report in graded.reports]

    def write(self) -> Filled | None:
        """Write tables, pages, feedback and the learning platform's sheet, as they are now."""
        table = self._table()
        handed_in = {student for student, _ in self.students.values()}
        for name in table.without_hand_in(handed_in):
            self.students.setdefault(name_key(name), (name, ""))
        self.marks = [self._mark(table, key) for key in sorted(self.students)]
        for graded in self.graded:
            ignored = []
            if graded is self.graded[0]:
                ignored = self.ignored
            out = graded.cohort.out
            write_summary(out, graded.name, graded.reports, ignored, graded.equal)
        self._write_pages()
        write_whole(self.out / FILE, table.text(self.marks))
        if self.book is None:
            return None
        marks = [mark for mark in self.marks if mark.results or mark.points is not None]
        filled = self.book.fill(marks)
        write_whole(self.out / "gradebook.csv", filled.text)
        return filled

    def _mark(self, table, key):
        student, platform_number = self.students[key]
        best = {}
        most = {}
        others = []
        for graded in self.graded:
            most[graded.name] = graded.most
            if key in graded.best:
                best[graded.name] = graded.best[key]
            for students, _ in graded.equal:
                if student in students:
                    others += students
        same = tuple(other for other in dict.fromkeys(others) if other != student)
        days_late = self._days_late(student, platform_number)
        late = days_late, self.settings.late_percent / 100
        return table.mark(student, platform_number, best, most, late, same)

    def _days_late(self, student, platform_number):
        """Return how many days after the due date a student handed in, 0 where this is unknown."""
        due = self.settings.due
        if due is None or self.book is None:
            return 0.0
        time = self.book.handed_in(student, platform_number)
        if time is None:
            return 0.0
        return (time - due).total_seconds() / 86_400

    def _write_pages(self):
        marks = {name_key(mark.student): mark for mark in self.marks}
        feedback = []
        for graded in self.graded:
            for entry, report in graded.attempts:
                if report.ungraded:
                    continue
                key = name_key(entry.student)
                page = page_for(report, marks[key])
                write_whole(graded.cohort.file(entry, ".html"), page)
                best_entry, _ = graded.best[key]
                if best_entry == entry:
                    feedback.append((entry, graded.name, page))
        write_feedback(self.out, feedback)

    def without_mark(self) -> dict[str, list[str]]:
        """Return why there is no mark -> students."""
        found: dict[str, list[str]] = {}
        for mark in self.marks:
            if mark.points is None:
                found.setdefault(mark.state, []).append(mark.student)
        return found

    def words(self) -> str:
        """Return what is shown of the results at the end."""
        parts = []
        for graded in self.graded:
            page = graded.cohort.out / "summary.html"
            parts.append(summary_text(graded.name, graded.reports))
            parts.append(f"{page}\n")
        parts.append(str(self.out / FILE))
        return "\n".join(parts)


def _equal(lab, best):
    sources = {}
    for entry, report in best.values():
        if not report.no_program:
            sources[entry.student] = source_of(entry)
    return equal_programs(sources, lab.template(), functions_of(lab))
