"""Figures of many runs in place of their rows: last state, errors, peak torques, crossings."""

from __future__ import annotations

import hashlib
import os
import pickle
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from importlib.metadata import version

import numpy as np

from ..base.checks import instance, named_functions, optional, whole
from ..base.shards import Chunk, ChunkedTable, code_hash
from ..base.workers import check_executor
from .events import crossings, may_cross
from .loops import ClosedLoops
from .steps import MARGIN_RATES, MARGINS, Q_DOT, XI, Q

TOGETHER = 32  # runs in one call
AT_ONCE = 10**6  # rows in one call


@dataclass(frozen=True)
class Summary:
    """Keep figures of each run of `simulate_many` in place of its rows.

    Parameters
    ----------
    functions : dict, optional
        {name: function of a Run} that gives a number; figures of your own.
    executor : concurrent.futures.Executor, optional
        Dask's `client.get_executor()`, for instance; None: a pool of `workers`.
    out : path, optional
        A folder, which gets a manifest and each chunk when it is done. The same call again goes on
        there, and computes no chunk twice. None: all is kept in memory.
    chunk : int
        Runs at a time.
    workers : int, optional
        Processes; None: one per processor, or only this one for a single chunk.

    Examples
    --------
    >>> import fivebar as fb
    >>> robots = [fb.FiveBar(m=m) for m in (0.4, 0.5, 0.6)]
    >>> controller = fb.ComputedTorque(fb.FiveBar(), kp=100, kd=20)
    >>> reference = fb.line((0.09, 0.068), (0.0, 0.1), duration=2.0)
    >>> runs = fb.simulate_many(robots, controller, reference, summary=fb.Summary())
    >>> len(runs), int(runs["max_error_m"].argmin())
    (3, 1)
    """

    functions: Mapping[str, Callable] = field(default_factory=dict)
    executor: Executor | None = None
    out: str | os.PathLike | None = None
    chunk: int = 500
    workers: int | None = None

    def __post_init__(self) -> None:
        named_functions(self.functions, "Summary: functions")
        check_executor(self.executor)
        path = instance(str, os.PathLike, what="a folder's path")
        optional(path)(self.out, "Summary: out")
        whole(1, 10**6)(self.chunk, "Summary: chunk")
        optional(whole(1, 1024))(self.workers, "Summary: workers")

    @staticmethod
    def load(folder: str | os.PathLike) -> Summaries:
        """Return the figures in a folder `out`, up to its first missing chunk."""
        return Summaries.load(folder)


class Summaries(ChunkedTable):
    """Figures of many runs, from `simulate_many` with a `summary`, or `Summary.load`.

    `table["rms_error_m"]` is one column (n,): of what varies from run to run (`names`: the robot's
    parameters, gains, the start) or a figure (`figures`): the last q, q' and xi, max_error_m,
    rms_error_m and final_error_m of the end-effector, peak torques, the number of crossings of
    singularities, and functions of your own. Figures of a run that failed are nan; `.errors` says
    why.
    """

    kind = "summary"
    cases = "runs"


def summarize(loops: ClosedLoops, cases: np.ndarray, summary: Summary) -> Summaries:
    """Return the figures of loops, each a row of `cases`."""
    workers = summary.workers
    if workers is None and summary.executor is None and len(cases) <= summary.chunk:
        workers = 1
    if workers != 1:
        loops.threads = 1
    compute = Summarizer(loops, dict(summary.functions))
    if taken := sorted(set(compute.built_in) & set(summary.functions)):
        raise ValueError(f"Summary: functions: {taken[0]} is the name of a built-in figure")
    figures: list[dict[str, str]] = [{"name": name} for name in compute.built_in]
    for name, function in summary.functions.items():
        figures.append({"name": name, "code": code_hash(function)})
    about = {
        "figures": figures,
        "variables": list(loops.loop.columns),
        "designs": {"runs": len(cases)},
        "chunk": summary.chunk,
        "robot": {"kind": loops.loop.kind.__name__},
        "choices": _choices(loops),
        "versions": {name: version(name) for name in ("fivebar", "numpy", "casadi")},
    }
    begins = range(0, len(cases), summary.chunk)
    chunks = (cases[k : k + summary.chunk] for k in begins)
    options = summary.executor, workers, summary.out
    return Summaries.compute(compute, chunks, len(cases), about, *options)


def _choices(loops):
    """Return what all runs share, for the manifest."""
    loop = loops.loop
    law = {name: str(value) for name, value in vars(loop.law).items()}
    del law["kp"], law["kd"]  # they are columns
    reference = hashlib.sha256(loops.targets.tobytes())
    if loops.xi_ref is not None:
        reference.update(loops.xi_ref.tobytes())
    return {
        "controller": {"class": type(loop.law).__name__, "law": code_hash(loop.law.law), **law},
        "reference": reference.hexdigest(),
        "grid": list(loop.grid),
        "chart": loop.chart.name,
        "method": loop.method,
        "torque_limit": loop.torque_limit,
        "measurement": asdict(loop.measurement),
        "torques": loop.torques and hashlib.sha256(loop.torques.text.encode()).hexdigest(),
    }


class Summarizer:
    """Rows of cases -> Chunk of their figures; runs in another process."""

    def __init__(self, loops: ClosedLoops, functions: dict[str, Callable]) -> None:
        if loops.tool is not None:
            raise ValueError(
                "simulate_many: summary has the errors of joint C, not those of the reference's"
                " tool: leave summary out, Run.error is the tool's"
            )
        self.loops = loops
        self.functions = functions
        left, right = loops.loop.kind.words.joints  # type: ignore[attr-defined]
        self.built_in = [left, right, f"{left}_dot", f"{right}_dot", "x", "y"]
        if loops.xi_ref is not None:
            self.built_in += ["max_error_m", "rms_error_m", "final_error_m"]
        self.built_in += ["peak_tau1", "peak_tau2", "crossings"]

    def __reduce__(self) -> tuple:
        # The compiled loop is kept from chunk to chunk in each process.
        return _summarizer, (pickle.dumps((self.loops, self.functions)),)

    def __call__(self, cases: np.ndarray) -> Chunk:
        together = max(1, min(TOGETHER, AT_ONCE // self.loops.loop.grid.steps))
        figures = len(self.built_in) + len(self.functions)
        values = np.full((len(cases), figures), np.nan)
        errors: list[tuple[int, str]] = []
        for first in range(0, len(cases), together):
            part = slice(first, first + together)
            for k, message in self._summarize(cases[part], values[part]):
                errors.append((first + k, message))
        return Chunk(cases, values, errors)

    def _summarize(self, cases, values):
        """Fill the values (n, figures) of runs; yield (number, message) of those that fail."""
        observed, samples = self.loops(cases)
        torques = self.loops.torques(samples)
        robots = [self.loops.robot(row) for row in cases]
        along = np.moveaxis(observed[:, :, Q], 1, 0)
        q = robots[0].continuous(along)[-1]
        end = observed[:, -1]
        columns = [q, end[:, Q_DOT], end[:, XI]]
        if self.loops.xi_ref is not None:
            away = observed[:, :, XI] - self.loops.xi_ref
            error = np.linalg.norm(away, axis=2)
            rms = np.sqrt(np.mean(error**2, axis=1))
            errors = [error.max(axis=1), rms, error[:, -1]]
            columns.append(np.stack(errors, axis=1))
        columns.append(np.abs(torques).max(axis=1))
        built_in = np.hstack(columns)
        margins, rates = observed[:, :, MARGINS], observed[:, :, MARGIN_RATES]
        crosses = may_cross(margins, rates)
        for k, robot in enumerate(robots):
            try:
                self.loops.check(robot, observed[k], torques[k])
            except ArithmeticError as error:
                yield k, str(error)
                continue
            events = ()
            if crosses[k]:
                events = crossings(robot, self.loops.t, margins[k], rates[k])
            count = len(events)
            values[k, : len(self.built_in)] = *built_in[k], count
            if self.functions:
                crossed = bool(crosses[k])
                run = self.loops.run(robot, observed[k], samples[k], crossed)
                for message in self._own(run, values[k]):
                    yield k, message

    def _own(self, run, values):
        """Fill the values of the user's functions; yield the messages of those that fail."""
        first = len(self.built_in)
        for place, (name, function) in enumerate(self.functions.items(), first):
            try:
                values[place] = function(run)
            except Exception as error:  # Whatever a user's function raises.
                yield f"{name}: {type(error).__name__}: {error}"


@lru_cache(maxsize=1)
def _summarizer(data: bytes) -> Summarizer:
    return Summarizer(*pickle.loads(data))
