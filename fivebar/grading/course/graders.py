"""The processes that grade: persistent ones of our own, or those of an executor, a Dask cluster's
for instance.
"""

from __future__ import annotations

import atexit
import json
import os
import subprocess
import sys
import threading
from concurrent.futures import CancelledError, Executor
from dataclasses import replace

from ..labs import PACKAGE, Lab
from ..program import Job
from .worker_loop import request_line


class GraderError(RuntimeError):
    """The grader's own process failed, not the student's."""


class Elsewhere:
    """The processes of an executor, on other machines perhaps: each has one that grades for every
    thread that asks.
    """

    def __init__(self, executor: Executor):
        self._executor = executor

    def ask(self, job: Job, lab: Lab) -> dict:
        """As of Workers."""
        siblings = tuple(replace(file, path=file.path.resolve()) for file in job.siblings)
        job = replace(job, path=job.path.resolve(), siblings=siblings)
        try:
            answer = self._executor.submit(
                _answer_there, request_line(job, replace(lab, folder=lab.folder.resolve()))
            )
            answer = answer.result()
        except Exception as error:
            of_cluster = type(error).__module__.startswith("distributed")
            if not of_cluster and not isinstance(error, (CancelledError, RuntimeError, OSError)):
                raise
            raise RuntimeError(
                f"the cluster is gone ({type(error).__name__}: {error}): what was graded stays, and"
                " the same command goes on from there"
            ) from None
        if answer is None:
            raise EOFError
        return answer

    def stop(self) -> None:
        """They are the cluster's."""


_there: list = []  # of a cluster's process: its Workers


def _answer_there(request):
    """What is run in a cluster's process; None where the process that graded ended instead."""
    if not _there:
        _there.append(Workers())
        atexit.register(_there[0].stop)
    try:
        return _there[0].answer(request)
    except EOFError:
        return None


class Workers:
    """One persistent process per thread that asks."""

    def __init__(self):
        self._own, self._all, self._stopped = threading.local(), [], False
        self._lock = threading.Lock()

    def ask(self, job: Job, lab: Lab) -> dict:
        """Its answer: a report, why there is none, or why there can be none. Raises EOFError where
        it ended instead.
        """
        return self.answer(request_line(job, lab))

    def answer(self, request: str) -> dict:
        """The same to a line."""
        process = getattr(self._own, "process", None)
        if process is None or process.poll() is not None:
            process = self._own.process = self._start()
        try:
            process.stdin.write(request)
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
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                encoding="utf-8",
                start_new_session=True,
                env=os.environ | {"PYTHONPATH": path},
            )
            self._all.append(process)
        return process

    def stop(self) -> None:
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
