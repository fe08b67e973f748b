"""The processes that grade a cohort: one for each thread that asks."""

from __future__ import annotations

import os
import threading
from concurrent.futures import CancelledError
from dataclasses import replace
from pathlib import Path

from ...base.workers import WorkerPool
from ..grade import grade
from ..intake.program import Job
from ..labs import Lab
from ..robots import parameters_of, with_numbers
from ..worker.sandbox import IsolationError, KilledError


class GraderError(RuntimeError):
    """The grader's own process failed, not the student's."""


class Workers:
    """One persistent process per thread that asks: a lab that kills it costs one submission."""

    def __init__(self) -> None:
        self._local = threading.local()
        self._pools: list[WorkerPool] = []
        self._stopped = False
        self._lock = threading.Lock()

    def ask(self, job: Job, lab: Lab) -> dict:
        """Return a report, why there is none, or why there can be none.

        Raises EOFError where the process that graded has ended.
        """
        pool = getattr(self._local, "pool", None) or self._start()
        try:
            return pool.submit(grade_job, sendable(job), lab.folder).result()
        except (RuntimeError, CancelledError):  # BrokenProcessPool, or a pool that is stopped
            self._local.pool = None
            pool.kill()
            if self._stopped:
                raise GraderError("stopped") from None
            raise EOFError from None

    def _start(self) -> WorkerPool:
        with self._lock:
            if self._stopped:
                raise GraderError("stopped")
            # Not forked: other threads may hold locks at this moment.
            pool = WorkerPool(1, start_method="spawn", initializer=move_stdout)
            self._pools.append(pool)
        self._local.pool = pool
        return pool

    def stop(self) -> None:
        """End all processes; one that is at work is killed, and its student's program with it."""
        with self._lock:
            self._stopped = True
        for pool in self._pools:
            pool.kill()


def move_stdout() -> None:
    """Print to stderr what a lab prints: stdout is for the grader's data."""
    os.dup2(2, 1)


def sendable(job: Job) -> Job:
    """Return a job with its robot's numbers alone, whose class the lab may define: another process
    has not got it.
    """
    return replace(job, robot=parameters_of(job.robot))


def grade_job(job: Job, folder: Path) -> dict:
    """Grade one submission; the answer is plain data. job: as `sendable`."""
    try:
        lab = Lab(folder)
        own = replace(job, robot=with_numbers(lab.robot(), job.robot))
        report = grade(lab, own)
        return {"report": report.as_json(figures=True), "warnings": report.warnings}
    except IsolationError as error:  # of this machine: nobody can be graded
        return {"error": str(error)}
    except KilledError as error:
        return {"failed": str(error)}
    except Exception as error:  # of this submission, as far as one can tell: the others are graded
        return {"failed": f"the grader itself failed with {type(error).__name__}: {error}"[:300]}
