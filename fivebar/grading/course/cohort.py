"""Grades a folder of submissions by persistent processes; each result is on disk before the next is
begun.
"""

from __future__ import annotations

import json
import os
import re
import signal
import sys
import textwrap
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

from ...base.errors import UsageError
from ...base.progress import progress
from ...base.representation import printable
from ...base.tables import STRANGE
from ...base.workers import first_done
from ..grade import OF_ANOTHER, job_hash
from ..intake.cohort_folder import Entry
from ..intake.program import Job
from ..intake.students_robots import hidden_seed, robot_for
from ..judging.results import Report
from ..labs import Lab
from ..report.outputs import file_name, write_whole
from ..robots import parameters_of
from .graders import GraderError, Workers

STATE = "grading.json"
TRIES = 3  # that one submission may cost a process that grades
SERIOUS = "timeout unasked memory killed exit flood garbled".split()


@dataclass(frozen=True)
class Cohort:
    """How all are graded: one seed for all, a robot each where there is a secret."""

    lab: Lab
    out: Path
    seed: str
    secret: bytes | None
    isolate: str
    limit: float | None
    hints_from: str = ""
    packages: tuple[str, ...] = ()

    def job(self, entry: Entry) -> Job:
        return Job(
            entry.path,
            entry.student,
            self.seed,
            robot_for(entry.student, self.secret, self.lab.robot()),
            self.isolate,
            self.limit,
            entry.trouble,
            entry.member,
            entry.siblings,
            self.hints_from,
            self.packages,
        )

    def file(self, entry: Entry, suffix: str) -> Path:
        attempt = f".{entry.attempt}" if entry.attempt > 1 else ""
        return self.out / "students" / (file_name(entry.student) + attempt + suffix)

    def done(self, entry: Entry) -> Report | None:
        """Return the Report of an earlier run on the same file, lab, seed and robot; else None."""
        try:
            report = Report.from_json(
                json.loads(self.file(entry, ".json").read_text(encoding="utf-8"))
            )
        except (OSError, *STRANGE):
            return None  # none yet, or no result: graded again
        job = self.job(entry)
        key = report.student, report.submission_hash, report.lab_hash, report.seed, report.robot
        now = job.student, job_hash(job), self.lab.hash(), job.seed, parameters_of(job.robot)
        key, now = (*key, report.packages), (*now, job.packages)
        if key != now or not report.submission_hash or report.faults:
            return None
        return replace(report, hints_from=job.hints_from)


def begin(cohort: Cohort) -> Cohort:
    """Return the Cohort with the seed of its folder's earlier run where it has none.

    Lab and secret must be the same.
    """
    lab, out, seed = cohort.lab, cohort.out, cohort.seed
    (out / "students").mkdir(parents=True, exist_ok=True)
    state = out / STATE
    own = hidden_seed(cohort.secret, lab.name) if cohort.secret else ""
    if state.exists():
        try:
            known = json.loads(state.read_text(encoding="utf-8"))
            earlier, known_seed = str(known["lab"]), str(known["seed"])
            same = known.get("secret", own) == own
        except STRANGE:
            raise UsageError(
                f"{state} is not what an earlier run left there: give another --out"
            ) from None
        if earlier != lab.name:
            raise UsageError(f"{out} holds results of {earlier}: give another --out")
        if not same:
            raise UsageError(
                f"{out} was graded with another secret, or without one, for other robots: give the"
                " same --secret-file, or another --out"
            )
        seed = seed or known_seed
    seed = seed or os.urandom(8).hex()
    write_whole(state, json.dumps({"lab": lab.name, "seed": seed, "secret": own}) + "\n")
    return replace(cohort, seed=seed)


def run_cohort(cohort: Cohort, entries: list[Entry], jobs: int) -> list[Report]:
    """Return reports in the order of the entries; those of an earlier run are kept.

    Where a machine is short of memory it may kill what grades: who was not graded in turn is tried
    once more alone. Who still is not has a Report that says so, without checks, and without a file:
    the next run tries again.
    """
    reports = {entry: report for entry in entries if (report := cohort.done(entry)) is not None}
    left = [entry for entry in entries if entry not in reports]
    if kept := len(reports):
        print(f"{kept} of {len(entries)} are graded already", file=sys.stderr)
    with progress(total=len(left), unit=" students") as bar:
        shown = _Shown(bar)
        _grade_all(cohort, left, jobs, reports, shown)
        again = [entry for entry in left if reports[entry].ungraded]
        if again and jobs > 1:
            _grade_all(cohort, again, 1, reports, shown)
    return [reports[entry] for entry in entries]


class _Shown:
    """What a run shows of its course."""

    def __init__(self, bar):
        self.bar, self.seen = bar, set()

    def add(self, entry, report):
        for warning in report.warnings:
            # The machine is the same for all, though each has a user of its own.
            if (kind := re.sub(r"\d+", "", warning)) not in self.seen:
                self.bar.write(warning, file=sys.stderr)
                self.seen.add(kind)
        if trouble := trouble_of(report):
            text = f"{printable(entry.student)}: {printable(trouble)}"
            self.bar.write(textwrap.shorten(text, 160, placeholder=" ..."), file=sys.stderr)
        self.bar.update()


def _grade_all(cohort, entries, jobs, reports, shown):
    """Grade the entries with so many processes at a time; each of the `reports` is added as it
    comes.
    """
    pool, workers = ThreadPoolExecutor(jobs), Workers()
    try:
        futures = {pool.submit(_one, cohort, entry, workers): entry for entry in entries}
        while futures:
            for future in first_done(futures):
                entry = futures.pop(future)
                reports[entry] = future.result()
                shown.add(entry, reports[entry])
    except KeyboardInterrupt:
        # The command ends: a second Ctrl-C would only leave its workers running.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        raise KeyboardInterrupt(
            f"interrupted: {len(reports)} are graded; the same command goes on from there"
        ) from None
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        workers.stop()
        pool.shutdown()


def trouble_of(report: Report) -> str:
    """Return what an instructor wants to hear at once of a submission, "" where nothing."""
    if report.ungraded or report.trouble:
        return report.ungraded or report.trouble
    if other := [note for note in report.notes if note.startswith(OF_ANOTHER)]:
        return other[0]
    lost = [check.reason for check in report.checks if check.reason in SERIOUS]
    return ", ".join(f"{lost.count(reason)} × {reason}" for reason in dict.fromkeys(lost))


def _one(cohort, entry, workers):
    """Grade one entry and put its files on disk; a Report that says why where that cannot be
    done.
    """
    why = ""
    for _ in range(TRIES):
        try:
            answer = workers.ask(cohort.job(entry), cohort.lab)
        except EOFError:
            why = f"the grader's own process was killed, {TRIES} times: was memory short?"
            continue
        if "error" in answer:
            raise GraderError(f"{entry.path.name}: {answer['error']}")
        if "report" not in answer:
            why = answer["failed"]
            break
        report = Report.from_json(answer["report"])
        write_whole(
            cohort.file(entry, ".json"), json.dumps(report.as_json(figures=True), indent=1) + "\n"
        )
        return replace(report, warnings=tuple(answer["warnings"]))
    return Report(
        cohort.lab.name, entry.path.name, (), entry.student, ungraded=f"NOT GRADED: {why}"
    )
