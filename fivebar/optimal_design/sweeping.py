"""`sweep`: figures of merit of many designs, in chunks over an executor, each on disk when done."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor
from dataclasses import asdict
from functools import partial
from importlib.metadata import version
from typing import Any

import numpy as np

from ..base.checks import instance, optional, takes, whole
from ..base.robot_uses import robot_for
from ..base.shards import Chunk
from ..base.workers import check_executor
from ..models.robots import Biglide, FiveBar
from .batch import check_variables
from .designs import designs_of
from .figures import Figure, evaluate, figures_of, warn_of_inertias
from .results import plain_parameters
from .sweeps import Sweep
from .task import Task, task_of


@takes(
    robot=optional(robot_for("fb.sweep")),
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
    """Return figures of merit of many designs.

    A design that is no robot, or of which a figure raises, gets nan and a message in `.errors`. A
    figure over a table is nan where a design does not reach all of it, or meets Type 2 in it.

    Parameters
    ----------
    figure : str, callable, list or mapping
        A name of `optimal_design.FIGURES`, a function robot -> number, a list of these, or {name:
        function}.
    designs : mapping, path, iterable or Designs
        {name: column (n,)}; a .csv or .npz file of such columns; robots, or {name: value}, one by
        one from any iterable; or `optimal_design.grid`, `sample`, `triangle`. Names are the robot's
        parameters, or l1, l2 (both proximal, both distal bars), r1, r2, r3 (Liu's), zz (both),
        task_x, task_y (the origin of the table or the motion).
    executor : concurrent.futures.Executor
        Dask's `client.get_executor()`, for instance; None: a pool of `workers`, which is begun
        anew where one of them is killed.
    out : path
        A folder, which gets a manifest and each chunk when it is done. The same call again goes on
        there, computes no chunk twice and ends with the same bytes, whatever the executor. None:
        all is kept in memory.
    robot : FiveBar or Biglide
        What the designs do not name; None: FiveBar().
    chunk : int
        Designs at a time; None: 1000 of closed forms, 10 of other figures.
    workers : int
        Processes; None: one per processor, or only this one where the work is short.
    **choices
        What the figures are about, the fields of `optimal_design.Task`: table=(0.2, 0.15), ...

    Returns
    -------
    Sweep

    Raises
    ------
    ValueError
        The folder holds another sweep, or figures and choices do not fit.
    RuntimeError
        The executor died; what was done stays.

    Examples
    --------
    >>> import fivebar as fb
    >>> swept = fb.sweep("bars", {"l1": [0.1, 0.12], "l2": [0.1, 0.1]})
    >>> swept["bars"]
    array([0.4 , 0.44])
    """
    check_executor(executor)
    robot = FiveBar() if robot is None else robot
    task = task_of(choices)
    figures = figures_of(figure, task, robot)
    designs = designs_of(designs, robot)
    check_variables(designs.names, robot, "designs", *designs.ends)
    warn_of_inertias(figures, designs.names, robot)
    closed = all(one.kind in ("closed", "poses") for one in figures)
    chunk = chunk or (1000 if closed else 10)
    # A few chunks take less time than starting processes.
    if executor is None and designs.count <= (4 if closed else 1) * chunk:
        workers = workers or 1
    about = {
        "figures": [one.about for one in figures],
        "variables": list(designs.names),
        "designs": designs.about,
        "chunk": chunk,
        "robot": {"kind": type(robot).__name__, **plain_parameters(robot)},
        "choices": task.about,
        "versions": {"fivebar": version("fivebar"), "numpy": np.__version__},
    }
    if robot.links:
        about["links"] = {name: asdict(link) for name, link in robot.links.items()}
    compute = partial(compute_chunk, figures, designs.names, robot, task)
    chunks = designs.chunks(chunk)
    return Sweep.compute(compute, chunks, designs.count, about, executor, workers, out)


def compute_chunk(
    figures: tuple[Figure, ...],
    names: tuple[str, ...],
    robot: FiveBar | Biglide,
    task: Task,
    rows: np.ndarray,
) -> Chunk:
    """Return one chunk; runs in another process."""
    return Chunk(rows, *evaluate(figures, names, rows, robot, task))
