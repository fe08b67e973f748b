"""A course's folder of results: all labs of the hand-ins graded, and what comes of the results."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ...base.errors import UsageError
from ..intake.cohort_folder import Entry, HandIn, entries_of, find_hand_ins, not_graded
from ..intake.hand_in import Left, functions_of
from ..labs import Lab
from ..report.outputs import write_whole
from ..results import Report
from ..variants import id_key
from ..worker.submission import SubmissionError, read_submission
from .cohort import Cohort, begin, run_cohort
from .cohort_page import Group, write_summary
from .copies import equal_programs
from .feedback import page_for, write_feedback, write_page
from .gradebook import Filled, Gradebook
from .items import summary_text
from .marks import FILE, Mark, Table, best_of
from .settings import Settings

Result = tuple[Entry, Report]


class Course:
    """One grading of a main lab, and of the labs of its family of which there are files.

    students: id key -> (id, the learning platform's number); ignored: (student, what of his is not
    graded); equal: groups of equal programs; marks: of all students.
    """

    def __init__(self, lab: Lab, out: Path, settings: Settings, book: Gradebook | None = None):
        self.lab, self.out, self.settings, self.book = lab, out, settings, book
        self.entries: dict[Lab, list[Entry]] = {}
        self.students: dict[str, tuple[str, str]] = {}
        self.ignored: list[tuple[str, Left]] = []
        self.cohorts: dict[Lab, Cohort] = {}
        self.results: dict[Lab, dict[str, Result]] = {}
        self.all_results: dict[Lab, list[Result]] = {}
        self.equal: dict[Lab, list[Group]] = {}
        self.marks: list[Mark] = []

    def find(self, folders: Iterable[Path], file: str | None, must_be_told_apart: bool) -> None:
        """Look for hand-ins; each folder holds one attempt of each student."""
        hand_ins: list[HandIn] = []
        for folder in folders:
            found, left = find_hand_ins(folder, must_be_told_apart)
            hand_ins += found
            self.ignored += [("", item) for item in left]
        others = [lab for lab in self.lab.family()[1:] if self.lab.family()[0] == self.lab]
        for lab in self._counting([self.lab, *others]):
            entries = entries_of(hand_ins, lab, file, named=lab != self.lab)
            if entries or lab == self.lab:
                self.entries[lab] = entries
        all_entries = [entry for entries in self.entries.values() for entry in entries]
        for hand_in in hand_ins:
            self.students[id_key(hand_in.student)] = hand_in.student, hand_in.number
            self.ignored += [(hand_in.student, item) for item in not_graded(hand_in, all_entries)]

    def _counting(self, labs):
        """Return the labs that the course's settings name, all where they name none."""
        wanted = self.settings.labs
        if wanted is None:
            return labs
        unknown = set(wanted) - {lab.name for lab in labs}
        if unknown:
            known = ", ".join(lab.name for lab in labs)
            raise UsageError(f"course.toml: labs names {', '.join(unknown)}; there are {known}")
        return [lab for lab in labs if lab.name in wanted]

    def grade(self, how: tuple, jobs: int) -> None:
        """Run all programs that have no result yet. how: as in `begin`."""
        Table(self.out, self._names())  # what is wrong with it is better known now
        for lab, entries in self.entries.items():
            out = self.out if lab == self.lab else self.out / lab.name
            self.cohorts[lab] = begin(lab, out, *how)
            reports = run_cohort(self.cohorts[lab], entries, jobs)
            weighted = [self.settings.weighted(report) for report in reports]
            self.all_results[lab] = list(zip(entries, weighted))
            self.results[lab] = best_of(entries, weighted)
            self.equal[lab] = self._equal(lab)

    def _names(self):
        return [lab.name for lab in self.entries]

    def reports(self) -> list[Report]:
        """Return the report of each student's best attempt, lab by lab."""
        return [report for results in self.results.values() for _, report in results.values()]

    def _equal(self, lab):
        sources = {}
        for entry, report in self.results[lab].values():
            if not report.no_program:
                sources[entry.student] = _source(entry.path, entry.member)
        handed_out = lab.folder / "student.py"
        template = _source(handed_out) if handed_out.is_file() else ""
        return equal_programs(sources, template, functions_of(lab))

    def write(self) -> Filled | None:
        """Write tables, pages, feedback and the learning platform's sheet, as they are now."""
        table = Table(self.out, self._names())
        for name in table.without_hand_in({student for student, _ in self.students.values()}):
            self.students.setdefault(id_key(name), (name, ""))
        most = {
            lab.name: max((report.max_points for _, report in results.values()), default=0.0)
            for lab, results in self.results.items()
        }
        share = self.settings.late_percent / 100
        for key, (student, moodle_number) in sorted(self.students.items()):
            results = {lab.name: found[key] for lab, found in self.results.items() if key in found}
            late = self._days_late(student, moodle_number), share
            same = self._same_as(student)
            self.marks.append(table.mark(student, moodle_number, results, most, late, same))
        for lab, results in self.results.items():
            ignored = self.ignored if lab == self.lab else []
            best = [report for _, report in results.values()]
            write_summary(self.cohorts[lab].out, lab.name, best, ignored, self.equal[lab])
        self._write_pages()
        write_whole(self.out / FILE, table.text(self.marks))
        if self.book is None:
            return None
        filled = self.book.fill(m for m in self.marks if m.results or m.points is not None)
        write_whole(self.out / "gradebook.csv", filled.text)
        return filled

    def _days_late(self, student, moodle_number):
        """Return the days between the due time and what Moodle's sheet says, 0 where unknown."""
        due, time = self.settings.due, None
        if due and self.book:
            time = self.book.handed_in(student, moodle_number)
        return 0.0 if time is None else (time - due).total_seconds() / 86_400

    def _same_as(self, student):
        found = []
        for groups in self.equal.values():
            for students, _ in groups:
                if student in students:
                    found += [other for other in students if other != student]
        return tuple(dict.fromkeys(found))

    def _write_pages(self):
        marks = {id_key(mark.student): mark for mark in self.marks}
        feedback = []
        for lab, results in self.all_results.items():
            cohort = self.cohorts[lab]
            for entry, report in results:
                if report.ungraded:
                    continue
                key = id_key(entry.student)
                page = page_for(report, marks[key])
                write_page(cohort.file(entry, ".html"), page)
                if self.results[lab][key][0] == entry:
                    feedback.append((entry, lab.name, page))
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
        for lab, results in self.results.items():
            reports = [report for _, report in results.values() if not report.ungraded]
            parts.append(summary_text(lab.name, reports))
            parts.append(f"{self.cohorts[lab].out / 'summary.html'}\n")
        return "\n".join([*parts, str(self.out / FILE)])


def _source(path, member=""):
    try:
        return read_submission(path, member).source
    except SubmissionError:
        return f"# unreadable: {path} {member}"
