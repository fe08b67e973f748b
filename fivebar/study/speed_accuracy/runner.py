"""The one runner: makes a chart's attempts, each in a process that may hang or crash, and times and
judges them.
"""

from __future__ import annotations

import gc
import math
import multiprocessing
import os
import time
from contextlib import suppress
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from ...base.errors import SingularityError, UnreachableError
from ...base.workers import end_with_parent, without_interrupts
from .chart import Attempt, Failed, load, module_of
from .machine import describe, missing
from .store import Partial, Result

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from .chart import Chart, Method

BUDGET = {True: 0.1, False: 0.3}  # s of timing for one attempt, in a quick and in a full run
REFUSALS = (
    ArithmeticError,
    ValueError,
    RuntimeError,
    MemoryError,
)  # other errors are ours, and end the run
WORDS = (
    (SingularityError, "refused: singular"),
    (UnreachableError, "refused: unreachable"),
    (ArithmeticError, "refused: not finite, or too fast"),
    (ValueError, "breaks down"),
    (RuntimeError, "gives up"),
)
THREADS = (
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "OMP_NUM_THREADS",
)  # each process has one of them
QUARTILES = (25, 50, 75)
SHORTEST_SAMPLE = 1e-4  # s; shorter calls are timed together
MOST_SAMPLES = 101
LONGEST_REPEATED = 5.0  # budgets; a call as long is not timed again


def run(
    name: str, folder: Path, quick: bool = False, progress: Callable[[], object] | None = None
) -> tuple[Result, Partial]:
    """Measure a chart, going on where an interrupted run ended; Result. progress: called after each
    attempt.
    """
    module = module_of(name)
    chart = load(module)
    about = {**describe(), "threads": 1, "quick": quick}
    partial = Partial(folder / f"{name}.partial.jsonl", about)
    with Worker(module, chart.limit, BUDGET[quick]) as worker:
        for problem, method, knob in chart.jobs(quick):
            if not partial.has(problem, method.name, knob):
                partial.add(row_of(problem, method, knob, worker.measure))
            if progress:
                progress()
    keys = [(problem, method.name, knob) for problem, method, knob in chart.jobs(quick)]
    return Result(chart, about, [partial.row(*key) for key in keys]), partial


def row_of(problem: str, method: Method, knob: float, measure: Callable[..., dict]) -> dict:
    """The row of an attempt, made by measure(problem, method's name, knob) if the method can run
    here.
    """
    row = {"problem": problem, "method": method.name, "knob": knob, "status": "ok", "word": ""}
    if lacking := missing(method.needs):
        return row | {"status": "left out", "word": lacking}
    return row | measure(problem, method.name, knob)


def measure(chart: Chart, problem: str, name: str, knob: float, budget: float) -> dict:
    """Columns of an attempt: its times and measures, or how it failed, and after what time."""
    before = time.perf_counter()
    attempt = Attempt(None, None)  # until there is another
    once = None
    try:
        with np.errstate(all="ignore"):
            attempt = chart.method(name).prepare(problem, knob)
            before = time.perf_counter()
            result = attempt.call()
            once = time.perf_counter() - before
            measures = attempt.judge(result)
        if not all(np.isfinite(value) for value in measures.values()):
            raise Failed("nan")
    except (Failed, *REFUSALS) as error:
        spent = once or time.perf_counter() - before
        if attempt.times and len(own := attempt.times()):
            spent = float(np.median(own))
        return {"status": "failed", "word": word_for(error), "seconds": spent / attempt.per}
    with np.errstate(all="ignore"):
        samples = attempt.times() if attempt.times else times_of(attempt.call, once, budget)
    low, middle, high = (float(s) for s in np.percentile(samples / attempt.per, QUARTILES))
    return {
        "seconds": middle,
        "seconds_low": low,
        "seconds_high": high,
        "repeats": len(samples),
        **{key: float(value) for key, value in measures.items()},
    }


def times_of(call: Callable[[], object], first: float, budget: float) -> np.ndarray:
    """Seconds of a call, (n,) samples in about `budget` s, without the garbage collector.

    first: s that it took before, which warmed it up; all there is where that is LONGEST_REPEATED
        budgets or more.
    """
    if first > LONGEST_REPEATED * budget:
        return np.array([first])
    before = time.perf_counter()
    call()
    once = time.perf_counter() - before
    together = max(1, math.ceil(SHORTEST_SAMPLE / max(once, 1e-9)))
    count = int(np.clip(budget / (together * once), 3, MOST_SAMPLES))
    samples, collecting = np.empty(count), gc.isenabled()
    gc.disable()
    try:
        for k in range(count):
            before = time.perf_counter()
            for _ in range(together):
                call()
            samples[k] = (time.perf_counter() - before) / together
    finally:
        if collecting:
            gc.enable()
    return samples


def word_for(error: Exception) -> str:
    """How an error is named on a chart."""
    if isinstance(error, Failed):
        return str(error)
    return next((word for kind, word in WORDS if isinstance(error, kind)), type(error).__name__)


class Worker:
    """A process that makes attempts, one at a time; killed and replaced where it hangs, replaced
    where it crashed.
    """

    def __init__(self, module: str, limit: float, budget: float) -> None:
        self.arguments, self.limit, self.process = (module, budget), limit, None

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def measure(self, problem: str, method: str, knob: float) -> dict:
        if self.process is None or not self.process.is_alive():
            self._end()
            self._begin()
        before = time.perf_counter()
        try:
            self.pipe.send((problem, method, knob))
            if not self.pipe.poll(self.limit):
                self._end()
                return {
                    "status": "failed",
                    "word": f"timeout, {self.limit:g} s",
                    "seconds": self.limit,
                }
            row = self.pipe.recv()
        except (EOFError, ConnectionError):
            self._end()
            return {"status": "failed", "word": "crashed", "seconds": time.perf_counter() - before}
        if isinstance(row, BaseException):
            raise row
        return row

    def _begin(self):
        spawn = multiprocessing.get_context("spawn")
        self.pipe, theirs = spawn.Pipe()
        self.room = TemporaryDirectory(
            prefix="fivebar-chart-"
        )  # what a process that is killed leaves behind
        process = spawn.Process(
            target=_serve, args=(theirs, self.room.name, *self.arguments), daemon=True
        )
        own = dict.fromkeys(THREADS, "1") | {"TMPDIR": self.room.name}
        before = {name: os.environ.get(name) for name in own}
        os.environ.update(own)  # read when NumPy is loaded, there
        try:
            with without_interrupts():
                process.start()
            self.process = process
        finally:
            for name, value in before.items():
                os.environ.pop(name) if value is None else os.environ.update({name: value})
            theirs.close()
        with suppress(EOFError, ConnectionError):
            if self.pipe.poll(60) and self.pipe.recv() == "ready":
                return
        raise RuntimeError("the process that measures does not start")

    def _end(self):
        if self.process is not None:
            self.process.kill()
            self.process.join()
            self.pipe.close()
            self.room.cleanup()
            self.process = None


def _serve(pipe, room, module, budget):
    end_with_parent(room)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):  # what solvers print would tear the progress bar
        os.dup2(nowhere, stream)
    chart = load(module)
    pipe.send("ready")
    while True:
        try:
            job = pipe.recv()
        except EOFError:
            return
        try:
            pipe.send(measure(chart, *job, budget))
        except Exception as error:  # sent on, and raised there
            error.add_note(f"in the attempt {job}")
            pipe.send(error)
