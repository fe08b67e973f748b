"""Time and judge the attempts of a chart, in a process that may hang or crash."""

from __future__ import annotations

import math
import os
import tempfile
import time
import timeit
from collections.abc import Callable
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ...base.errors import SingularityError, UnreachableError
from ...base.workers import WorkerPool, WorkersDied
from .chart import Attempt, Chart, Failed, Method, load
from .machine import describe
from .store import Partial, Result

BUDGET = {True: 0.1, False: 0.3}  # s of timing for one attempt, in a quick and in a full run
# How an error is named on a chart; all other errors are our own, and end the run.
WORDS = {
    SingularityError: "refused: singular",
    UnreachableError: "refused: unreachable",
    ArithmeticError: "refused: not finite, or too fast",
    ValueError: "breaks down",
    RuntimeError: "gives up",
    MemoryError: "out of memory",
}
REFUSALS: tuple[type[Exception], ...] = (Failed, *WORDS)
THREADS = "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"
SHORTEST_SAMPLE = 1e-4  # s; shorter calls are timed together
MOST_SAMPLES = 101
LONGEST_REPEATED = 5.0  # budgets; a longer call is timed once


def run(
    module: str, folder: Path, quick: bool, progress: Callable[[], object]
) -> tuple[Result, Partial]:
    """Measure a chart, going on where an interrupted run ended; progress: called each time."""
    chart = load(module)
    about = {**describe(), "threads": 1, "quick": quick}
    partial = Partial(folder / f"{chart.name}.partial.jsonl", about)
    rows = []
    with Worker(module, chart.limit, BUDGET[quick]) as worker:
        for problem, method, knob in chart.jobs(quick):
            key = problem, method.name, knob
            if not partial.has(*key):
                partial.add(row_of(problem, method, knob, worker.measure))
            rows.append(partial.row(*key))
            progress()
    return Result(chart, about, rows), partial


def row_of(problem: str, method: Method, knob: float, measure: Callable[..., dict]) -> dict:
    """Return the row of an attempt: measure(problem, name, knob), or what it lacks."""
    row = {"problem": problem, "method": method.name, "knob": knob, "status": "ok", "word": ""}
    for need in method.needs:
        if lacking := need():
            return row | {"status": "left out", "word": lacking}
    return row | measure(problem, method.name, knob)


def measure(chart: Chart, problem: str, name: str, knob: float, budget: float) -> dict:
    """Return times and measures of an attempt, or how it failed and after what time."""
    attempt = Attempt(lambda: None, lambda result: {})
    times: Any = ()
    before = time.perf_counter()
    try:
        with np.errstate(all="ignore"):
            attempt = chart.method(name).prepare(problem, knob)
            before = time.perf_counter()
            result = attempt.call()
            times = (time.perf_counter() - before,)
            measures = attempt.judge(result)
        if not all(np.isfinite(value) for value in measures.values()):
            raise Failed("nan")
    except REFUSALS as error:
        times = times or (time.perf_counter() - before,)
        if attempt.times and len(attempt.times()):
            times = attempt.times()
        seconds = float(np.median(times)) / attempt.per
        return {"status": "failed", "word": word_for(error), "seconds": seconds}
    with np.errstate(all="ignore"):
        samples = attempt.times() if attempt.times else times_of(attempt.call, times[0], budget)
    low, middle, high = np.percentile(samples / attempt.per, (25, 50, 75)).tolist()
    return {
        "seconds": middle,
        "seconds_low": low,
        "seconds_high": high,
        "repeats": len(samples),
        **{key: float(value) for key, value in measures.items()},
    }


def times_of(call: Callable[[], object], first: float, budget: float) -> np.ndarray:
    """Return (n,) s of a call that took `first` s before, in about `budget` s.

    `timeit` switches the garbage collector off.
    """
    if first > LONGEST_REPEATED * budget:
        return np.array([first])
    timer = timeit.Timer(call)
    once = timer.timeit(1)
    number = max(1, math.ceil(SHORTEST_SAMPLE / max(once, 1e-9)))
    count = int(np.clip(budget / (number * once), 3, MOST_SAMPLES))
    return np.array(timer.repeat(count, number)) / number


def word_for(error: Exception) -> str:
    """Return how an error is named on a chart."""
    if isinstance(error, Failed):
        return str(error)
    return next(word for kind, word in WORDS.items() if isinstance(error, kind))


class Worker:
    """A process that makes attempts, one at a time; replaced where it hangs or crashes."""

    def __init__(self, module: str, limit: float, budget: float) -> None:
        self.module = module
        self.limit = limit
        self.budget = budget
        self.pool: Any = None

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def measure(self, problem: str, method: str, knob: float) -> dict:
        """Return the columns of an attempt; raise what is no failure of the method."""
        arguments = _measure_one, problem, method, knob, self.budget
        try:
            self._begin()
            future = self.pool.submit(*arguments)
        except BrokenProcessPool:  # killed since the last attempt
            self._end()
            self._begin()
            future = self.pool.submit(*arguments)
        before = time.perf_counter()
        try:
            return future.result(self.limit)
        except TimeoutError:
            word = f"timeout, {self.limit:g} s"
        except BrokenProcessPool:
            word = "crashed"
        self._end()
        return {"status": "failed", "word": word, "seconds": time.perf_counter() - before}

    def _begin(self):
        if self.pool is not None:
            return
        self.folder = TemporaryDirectory(prefix="fivebar-chart-")
        arguments = self.module, self.folder.name
        self.pool = WorkerPool(1, "spawn", _prepare, arguments)
        inherited = dict(os.environ)
        os.environ.update(dict.fromkeys(THREADS, "1"))  # read when NumPy is loaded, there
        try:
            self.pool.submit(os.getpid).result()
        except BrokenProcessPool:
            self._end()
            raise WorkersDied(
                "chart: the process that makes the attempts ended at its start, before the first"
                f" attempt of {self.module.rpartition('.')[2]}: was it killed, or is the machine"
                " out of memory?"
            ) from None
        finally:
            os.environ.clear()
            os.environ.update(inherited)

    def _end(self):
        if self.pool is not None:
            self.pool.kill()
            self.folder.cleanup()
            self.pool = None


def _prepare(module, folder):
    """Prepare the worker process: its folder for temporary files, its chart, no output."""
    global _chart
    tempfile.tempdir = os.environ["TMPDIR"] = folder
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):  # what solvers print would tear the progress bar
        os.dup2(nowhere, stream)
    _chart = load(module)


def _measure_one(problem, method, knob, budget):
    try:
        return measure(_chart, problem, method, knob, budget)
    except Exception as error:
        error.add_note(f"in the attempt {problem}, {method}, {knob}")
        raise
