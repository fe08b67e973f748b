"""Grades a folder of submissions by persistent processes; each result is on disk before the next is begun."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import textwrap
import threading
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, replace
from pathlib import Path

from ...errors import UsageError
from ...models.robots import Robot
from ...progress import progress
from ..grade import file_hash
from ..labs import PACKAGE, Lab
from ..report.outputs import file_name, write_whole
from ..report.text import printable
from ..results import Report
from ..variants import robot_for
from .submissions import Entry

STATE = "grading.json"
SERIOUS = ("timeout", "memory", "killed", "exit", "flood", "garbled")


class GraderError(RuntimeError):
    """The grader's own process failed, not the student's."""


@dataclass(frozen=True)
class Cohort:
    """How all are graded: one seed for all, a robot each where there is a secret."""

    lab: Lab
    out: Path
    seed: str
    secret: bytes | None
    isolate: str
    limit: float | None

    def robot(self, entry: Entry) -> Robot:
        return robot_for(entry.student, self.secret, self.lab.robot())

    def request(self, entry: Entry) -> dict:
        return {
            "lab": str(self.lab.folder), "path": os.fsencode(entry.path).hex(), "student": entry.student,
            "seed": self.seed, "robot": self.robot(entry).parameters, "isolate": self.isolate, "limit": self.limit,
            "trouble": entry.trouble,
        }  # fmt: skip

    def file(self, entry: Entry, suffix: str) -> Path:
        return self.out / "students" / (file_name(entry.student) + suffix)

    def done(self, entry: Entry) -> Report | None:
        """The Report of an earlier run on the same file, lab, seed and robot; else None."""
        try:
            report = Report.from_json(json.loads(self.file(entry, ".json").read_text(encoding="utf-8")))
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return None  # none yet, or no result: graded again
        key = report.student, report.submission_hash, report.lab_hash, report.seed, report.robot
        now = entry.student, file_hash(entry.path), self.lab.hash(), self.seed, self.robot(entry).parameters
        return report if key == now and report.submission_hash and not report.faults else None


def begin(lab: Lab, out: Path, seed: str | None, secret: bytes | None, isolate: str, limit: float | None) -> Cohort:
    """The Cohort of a folder of results, with the seed of its earlier run where none is given."""
    (out / "students").mkdir(parents=True, exist_ok=True)
    state = out / STATE
    if state.exists():
        try:
            known = json.loads(state.read_text(encoding="utf-8"))
            earlier, known_seed = str(known["lab"]), str(known["seed"])
        except (ValueError, KeyError, TypeError):
            raise UsageError(f"{state} is not what an earlier run left there: give another --out") from None
        if earlier != lab.name:
            raise UsageError(f"{out} holds results of {earlier}: give another --out")
        seed = seed or known_seed
    seed = seed or os.urandom(8).hex()
    write_whole(state, json.dumps({"lab": lab.name, "seed": seed}) + "\n")
    return Cohort(lab, out, seed, secret, isolate, limit)


def run_cohort(cohort: Cohort, entries: list[Entry], jobs: int) -> list[Report]:
    """Reports in the order of the entries; those of an earlier run are kept."""
    reports = {entry: report for entry in entries if (report := cohort.done(entry)) is not None}
    left = [entry for entry in entries if entry not in reports]
    if kept := len(reports):
        print(f"{kept} of {len(entries)} are graded already", file=sys.stderr)
    pool, workers, troubles, full = ThreadPoolExecutor(jobs), _Workers(), 0, 0
    with progress(total=len(left), unit="student") as bar:
        futures = {pool.submit(_one, cohort, entry, workers): entry for entry in left}
        try:
            for future in as_completed(futures):
                entry, report = futures[future], future.result()
                if len(reports) == kept + 1:  # the machine is the same for all
                    for warning in report.warnings:
                        bar.write(warning, file=sys.stderr)
                reports[entry] = report
                if trouble := trouble_of(report):
                    troubles += 1
                    text = f"{printable(entry.student)}: {printable(trouble)}"
                    bar.write(textwrap.shorten(text, 160, placeholder=" ..."), file=sys.stderr)
                full += report.points == report.max_points
                bar.set_postfix_str(f"all points {full}, in trouble {troubles}")
                bar.update()
        except KeyboardInterrupt:
            raise RuntimeError(
                f"interrupted: {len(reports)} of {len(entries)} are graded; the same command goes on from there"
            ) from None
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
            workers.stop()
            pool.shutdown()
    return [reports[entry] for entry in entries]


def trouble_of(report: Report) -> str:
    """What an instructor wants to hear at once of a submission, "" where nothing."""
    if report.trouble:
        return report.trouble
    lost = [check.reason for check in report.checks if check.reason in SERIOUS]
    return ", ".join(f"{reason} in {lost.count(reason)} checks" for reason in dict.fromkeys(lost))


def _one(cohort, entry, workers):
    """Grade one entry and put its files on disk."""
    request = cohort.request(entry)
    try:
        answer = workers.ask(request)
    except EOFError:
        answer = {"failed": "ended"}
    if "failed" in answer:
        request["trouble"] = f"the grader's own process {answer['failed']} while grading it: look at it by hand"
        answer = workers.ask(request)
    if trouble := answer.get("error") or answer.get("failed"):
        raise GraderError(f"{entry.path.name}: {trouble}")
    write_whole(cohort.file(entry, ".html"), answer["page"])
    write_whole(cohort.file(entry, ".json"), json.dumps(answer["report"], indent=1) + "\n")
    return replace(Report.from_json(answer["report"]), warnings=tuple(answer["warnings"]))


class _Workers:
    """One persistent process per thread that asks."""

    def __init__(self):
        self._own, self._all, self._stopped = threading.local(), [], False
        self._lock = threading.Lock()

    def ask(self, request):
        """Its answer to a request. Raises EOFError where the process ended instead."""
        process = getattr(self._own, "process", None)
        if process is None or process.poll() is not None:
            process = self._own.process = self._start()
        try:
            process.stdin.write(json.dumps(request) + "\n")
            process.stdin.flush()
            line = process.stdout.readline()
        except BrokenPipeError:
            line = ""
        if not line.endswith("\n"):
            process.kill()
            process.wait()
            if self._stopped:
                raise GraderError("stopped")
            raise EOFError
        return json.loads(line)

    def _start(self):
        path = os.pathsep.join(filter(None, (str(PACKAGE.parent), os.environ.get("PYTHONPATH"))))
        command = [sys.executable, "-P", "-m", "fivebar.grading.course.worker_loop"]
        with self._lock:
            if self._stopped:
                raise GraderError("stopped")
            process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8", start_new_session=True,
                env=os.environ | {"PYTHONPATH": path},
            )  # fmt: skip
            self._all.append(process)
        return process

    def stop(self):
        """End all; one that is at work is killed, and its student's program with it."""
        with self._lock:
            self._stopped = True
        for process in self._all:
            process.kill()
            process.wait()
        for process in self._all:
            process.stdout.close()
            try:
                process.stdin.close()
            except BrokenPipeError:
                pass  # what it was being told is of no use now
