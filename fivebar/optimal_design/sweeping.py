"""`sweep`: designs x figures, in chunks over an executor, each chunk on disk as it comes."""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Executor
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from ..base.checks import instance, optional, takes, whole
from ..base.folders import locked_folder
from ..base.progress import progress
from ..base.workers import WorkersDied, check_executor, compute_chunks
from ..models.robots import Biglide, FiveBar
from .batch import check_variables
from .designs import designs_of, digest
from .figures import Figure, evaluate, figures_of
from .shards import WHAT, Chunk, begin, is_done, write_chunk, write_manifest
from .sweeps import Sweep, in_folder
from .task import Task, task_of

AT_ONCE, ONE_BY_ONE = 1000, 10  # designs in a chunk: of figures in closed form, of others
MOST_KEPT = 2 * 10**8  # numbers in memory, where there is no folder
FOR_FEW = 4  # chunks of closed forms, for which it is not worth starting processes


@takes(
    robot=optional(instance(FiveBar, Biglide)),
    chunk=optional(whole(1, 10**6)),
    workers=optional(whole(1, 1024)),
    out=optional(instance(str, os.PathLike, what="a folder's path")),
)
def sweep(
    figure: str | Callable | Figure | Iterable | Mapping[str, Callable],
    designs: Any,
    executor: Executor | None = None,
    out: str | os.PathLike | None = None,
    *,
    robot: FiveBar | Biglide | None = None,
    chunk: int | None = None,
    workers: int | None = None,
    **choices: Any,
) -> Sweep:
    """Figures of merit of many designs: Sweep.

    figure: a name of `designing.FIGURES`, a function robot -> number, a list of these, or {name:
        function}.
    designs: {name: column (n,)}; a .csv or .npz file of such columns; robots, or {name: value}, one
        by one from any iterable; or `designing.grid`, `sample`, `triangle`. Names are the robot's
        parameters, or l1, l2 (both proximal, both distal bars), r1, r2, r3 (Liu's), zz (both),
        task_x, task_y (where the table or the motion is).
    executor: any concurrent.futures.Executor, as Dask's `client.get_executor()`; None: a pool of
        `workers` processes (None: one per processor), which is begun anew where one of them is
        killed.
    out: a folder, which gets a manifest and each chunk as it comes. The same call again goes on
        there, computes no chunk twice and ends with the same bytes, whatever the executor. None:
        all is kept in memory.
    robot: what the designs do not name, FiveBar() if None. chunk: designs at a time.
    choices: what the figures are about, the fields of `designing.Task`: table=(0.2, 0.15),
        motor="xh430-w350", ...

    A design that is no robot, or of which a figure raises, gets nan and a message in `.errors`.
    ValueError for another sweep's folder, and where figures and choices do not fit; RuntimeError
    where the executor dies: what was done stays.
    """
    check_executor(executor)
    robot = FiveBar() if robot is None else robot
    task = task_of(choices)
    figures = figures_of(figure, task, robot)
    given = designs_of(designs, robot)
    check_variables(given.names, robot, "designs")
    quick = all(each.kind in ("closed", "poses") for each in figures)
    chunk = chunk or (AT_ONCE if quick else ONE_BY_ONE)
    if (
        executor is None
        and workers is None
        and given.count is not None
        and given.count <= (FOR_FEW if quick else 1) * chunk
    ):
        workers = 1
    compute = partial(compute_chunk, figures, given.names, robot, task)
    manifest = _manifest(figures, given, chunk, robot, task)
    chunks = enumerate(given.chunks(chunk))
    total = None if given.count is None else math.ceil(given.count / chunk)
    if out is None:
        return _in_memory(manifest, compute, chunks, executor, workers, total)
    return _on_disk(Path(out), manifest, compute, chunks, executor, workers, total)


def compute_chunk(
    figures: tuple[Figure, ...],
    names: tuple[str, ...],
    robot: FiveBar | Biglide,
    task: Task,
    rows: np.ndarray,
) -> Chunk:
    """What is done in another process."""
    return Chunk(rows, *evaluate(figures, names, rows, robot, task))


def _manifest(figures, given, chunk, robot, task):
    return {
        "what": WHAT,
        "figures": [each.about for each in figures],
        "variables": list(given.names),
        "designs": given.about,
        "chunk": chunk,
        "robot": {"kind": type(robot).__name__, **_plain(robot.parameters)},
        "choices": task.about,
        "versions": {"fivebar": version("fivebar"), "numpy": np.__version__},
    }


def _plain(parameters):
    return {
        name: list(value) if isinstance(value, tuple) else value
        for name, value in parameters.items()
    }


def _in_memory(manifest, compute, chunks, executor, workers, total):
    found, size, counted = (
        {},
        len(manifest["variables"]) + len(manifest["figures"]),
        _Counted(chunks),
    )
    with progress(total=total, unit=" chunks") as bar:
        for number, done in compute_chunks(compute, counted.all(), executor, workers):
            found[number] = done
            if len(found) * manifest["chunk"] * size > MOST_KEPT:
                raise ValueError(
                    f"designs: more than {MOST_KEPT:g} numbers in memory; give out=, a folder for"
                    " them"
                )
            bar.update()
    return Sweep(
        manifest | {"done": counted.done}, tuple(found[number] for number in sorted(found))
    )


def _on_disk(folder, manifest, compute, chunks, executor, workers, total):
    with locked_folder(folder, "sweep"):
        known = begin(folder, manifest)
        numbers = _Counted(chunks)
        with progress(total=total, unit=" chunks") as bar:
            try:
                for number, done in compute_chunks(compute, numbers.left(folder, bar), executor, workers):
                    write_chunk(folder, number, done)
                    bar.update()
            except WorkersDied as error:
                raise RuntimeError(
                    f"{error}. What was done is in {folder}: {_count(folder)} chunks; the same call"
                    " goes on from there"
                ) from None
            except OSError as error:
                error.strerror = (
                    f"{error.strerror}; what was done stays in {folder}: {_count(folder)} chunks"
                )
                raise
        done = numbers.done
        if "done" in known and known["done"] != done:
            raise ValueError(
                f"out: {folder} is done with {known['done']['designs']} designs, not"
                f" {numbers.designs}"
            )
        if beyond := sorted(folder.glob("chunk-*.npz"))[numbers.seen :]:
            raise ValueError(
                f"out: {folder} holds {beyond[0].name}, beyond the {numbers.seen} chunks of these"
                " designs"
            )
        if "done" not in known:
            write_manifest(folder, manifest | {"done": done})
    return in_folder(folder)


def _count(folder):
    return len(list(folder.glob("chunk-*.npz")))


class _Counted:
    """Chunks as they are asked for, and what there has been of them."""

    def __init__(self, chunks: Iterable[tuple[int, np.ndarray]]):
        self.chunks, self.seen, self.designs, self.hash = chunks, 0, 0, hashlib.sha256()

    @property
    def done(self) -> dict:
        return {"chunks": self.seen, "designs": self.designs, "sha256": self.hash.hexdigest()}

    def all(self) -> Iterator[tuple[int, np.ndarray]]:
        """(number, rows) of each chunk."""
        for number, rows in self.chunks:
            self.seen, self.designs = number + 1, self.designs + len(rows)
            self.hash.update(digest(rows).encode())
            yield number, rows

    def left(self, folder: Path, bar: Any) -> Iterator[tuple[int, np.ndarray]]:
        """(number, rows) of those that are not in the folder."""
        for number, rows in self.all():
            if is_done(folder, number, rows):
                bar.update()
            else:
                yield number, rows
