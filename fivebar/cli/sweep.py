"""`fivebar sweep`: figures of merit of many designs."""

from __future__ import annotations

from functools import partial

from ..base.errors import UsageError
from ..base.representation import aligned
from .options import (
    JSON,
    add_command,
    named_values,
    print_json,
    print_message,
    usage_errors,
    used_options,
    write_options,
)
from .robot_options import add_robot_options, chosen_machine
from .task_options import TASK, chosen_bounds, chosen_task, figure_list, figure_of

DESIGNS = {
    "--grid NAME=LOW:HIGH:COUNT ...": "all combinations",
    "--bound NAME=LOW:HIGH ...": "bounds of --sample",
    "--sample N": "designs spread evenly between the bounds",
    "--seed N": (0, "seed of --sample"),
    "--triangle N": "Liu's r1 + r2 + r3 = 3, N parts a side",
    "--designs FILE": "a .csv or .npz file of columns by name",
}
OPTIONS = JSON | {
    "[FIGURE ...]": "a name, or FILE.py:FUNCTION; one with =min or =max: by which designs are best",
    "--list": "list the figures and their units",
    "--out DIR": "a folder of results; a second run goes on there",
    "--workers N": "processes (default: one per processor)",
    "--dask ADDRESS": "a Dask scheduler, tcp://host:8786, or its .json file",
    "--best N": (10, "designs to list"),
    "--csv OUT.csv": "write a row per design",
    "--plot OUT.png": "draw the figures: .png, .svg or .pdf",
    "--mark NAME=VALUE ...": "a chosen design to mark in the picture",
}


def add_parsers(commands):
    """Add `sweep` to the program's commands."""
    words = "by the robot's parameters, l1, l2, r1, r2, r3, task_x, task_y; m"
    designs = DESIGNS, "designs", words
    add_robot_options(add_command(commands, "sweep", _sweep, designs, (OPTIONS,), TASK))


def _sweep(arguments):
    if arguments.list:
        print(figure_list())
        return
    if not arguments.figure:
        raise UsageError(
            "which figure? It goes before the options, as fivebar sweep bars --grid l1=0.1:0.2:3;"
            " fivebar sweep --list names them"
        )
    from ..base.workers import dask_executor
    from ..optimal_design.sweeping import sweep

    robot, choices = chosen_machine(arguments).robot, chosen_task(arguments)
    if arguments.mark and not arguments.plot:
        raise UsageError("--mark is of --plot FILE")
    if arguments.dask and arguments.workers:
        raise UsageError("--workers are processes here; with --dask the cluster has its own")
    try:
        parts = [text.partition("=") for text in arguments.figure]
        figures = [figure_of(name) for name, *_ in parts]
        by, *others = [k for k, (_, sign, _) in enumerate(parts) if sign] or [0]
        if others:
            raise UsageError("=min or =max goes with one figure, by which designs are best")
        with usage_errors(ValueError, TypeError), dask_executor(arguments.dask) as executor:
            swept = sweep(
                figures,
                _designs(arguments),
                executor,
                arguments.out,
                robot=robot,
                workers=arguments.workers,
                **choices,
            )
            figure, sense = swept.figures[by], parts[by][2]
            best = swept.best(figure, arguments.best, sense or None)
    except KeyboardInterrupt:
        if arguments.out is None:
            raise
        raise KeyboardInterrupt(
            f"interrupted: what was done is in {arguments.out}; the same command goes on there"
        ) from None
    _show(arguments, swept, best)
    if words := swept.why_not_finite(figure):
        print_message(words)


def _designs(arguments):
    from ..optimal_design.designs import grid, sample, triangle

    sources = used_options(arguments, "grid", "sample", "triangle", "designs")
    if len(sources) != 1:
        wrong = " and ".join(f"--{name}" for name in sources) or "none"
        raise UsageError(
            f"designs come from one of --grid, --sample, --triangle, --designs, not {wrong}"
        )
    [(source, given)] = sources.items()
    if arguments.bound and source != "sample":
        raise UsageError("--bound is of --sample N")
    if source == "designs":
        return given
    if source == "triangle":
        return triangle(given)
    if source == "sample":
        return sample(chosen_bounds(arguments, "--sample"), given, arguments.seed)
    return grid(named_values(given, "--grid", "LOW:HIGH:COUNT"))


def _show(arguments, swept, best):
    draw = partial(swept.plot, mark=named_values(arguments.mark, "--mark") or None)
    files = write_options(arguments, {"csv": swept.to_csv, "plot": draw})
    for path in [*files, *used_options(arguments, "out").values()]:
        print_message(path)
    columns = [*swept.names, *swept.figures]
    names = "design", *columns
    rows = zip(best.tolist(), *(swept[name][best].tolist() for name in columns))
    if arguments.json:
        designs = [dict(zip(names, row)) for row in rows]
        print_json({"designs": swept.count, "errors": len(swept.errors), "best": designs})
        return
    lines = [names, *([f"{value:.6g}" for value in row] for row in rows)]
    print(*aligned(lines, 0), sep="\n")
    for k, text in swept.errors[:3]:
        print_message(f"design {k}: {text}")
