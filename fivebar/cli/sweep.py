"""`fivebar sweep`: figures of merit of many designs."""

from __future__ import annotations

import json
import math
import sys
from argparse import _SubParsersAction
from contextlib import nullcontext
from pathlib import Path

from ..base.errors import UsageError
from .endings import check_ending
from .robot_options import add_robot_options, chosen_robot
from .task_options import (
    add_task_options,
    by_option,
    chosen_task,
    figure_list,
    figure_of,
    interval,
    span,
)


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `sweep` to the program's commands."""
    parser = commands.add_parser("sweep", help="figures of merit of many designs")
    parser.add_argument(
        "figures",
        nargs="*",
        metavar="FIGURE",
        help="a name, or FILE.py:FUNCTION; =min or =max: the best designs are those",
    )
    parser.add_argument("--list", action="store_true", help="list the figures and their units")
    group = parser.add_argument_group(
        "designs", "by the robot's parameters, l1, l2, r1, r2, r3, task_x, task_y; m"
    )
    group.add_argument(
        "--grid",
        action="append",
        default=[],
        metavar="NAME=LOW:HIGH:COUNT",
        help="all combinations",
    )
    group.add_argument(
        "--bound", action="append", default=[], metavar="NAME=LOW:HIGH", help="bounds of --sample"
    )
    group.add_argument(
        "--sample", type=int, metavar="N", help="designs spread evenly between the bounds"
    )
    group.add_argument("--seed", type=int, default=0, help="seed of --sample (default: 0)")
    group.add_argument(
        "--triangle", type=int, metavar="N", help="Liu's r1 + r2 + r3 = 3, N parts a side"
    )
    group.add_argument("--designs", metavar="FILE", help="a .csv or .npz file of columns by name")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="a folder of results; a second run goes on there"
    )
    parser.add_argument(
        "--workers", type=int, metavar="N", help="processes (default: one per processor)"
    )
    parser.add_argument(
        "--dask", metavar="ADDRESS", help="a Dask scheduler, tcp://host:8786, or its .json file"
    )
    parser.add_argument("--chunk", type=int, metavar="N", help="designs computed at a time")
    parser.add_argument(
        "--best", type=int, default=10, metavar="N", help="designs to list (default: %(default)s)"
    )
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write a row per design")
    parser.add_argument(
        "--plot", type=Path, metavar="FILE", help="draw the first figure: .png, .svg or .pdf"
    )
    parser.add_argument("--json", action="store_true", help="print the best designs as JSON")
    add_task_options(parser)
    add_robot_options(parser)
    parser.set_defaults(run=_sweep)


def _sweep(arguments):
    if arguments.list:
        print(figure_list())
        return
    if not arguments.figures:
        raise UsageError("which figure? fivebar sweep --list names them")
    from ..base.workers import dask_executor
    from ..optimal_design.sweeping import sweep

    robot, choices = chosen_robot(arguments), chosen_task(arguments)
    check_ending("--plot", arguments.plot)
    if arguments.dask and arguments.workers:
        raise UsageError("--workers are processes here; with --dask the cluster has its own")
    try:
        designs = _designs(arguments)
        first, _, sense = arguments.figures[0].partition("=")
        figures = [figure_of(name) for name in (first, *arguments.figures[1:])]
        with dask_executor(arguments.dask) if arguments.dask else nullcontext() as executor:
            swept = sweep(
                figures,
                designs,
                executor,
                arguments.out,
                robot=robot,
                chunk=arguments.chunk,
                workers=arguments.workers,
                **choices,
            )
        best = swept.best(count=arguments.best, sense=sense or None)
    except (ValueError, TypeError) as error:
        raise by_option(error) from None
    except KeyboardInterrupt:
        if arguments.out is None:
            raise
        raise RuntimeError(
            f"interrupted: what was done is in {arguments.out}; the same command goes on there"
        ) from None
    _show(arguments, swept, best)


def _designs(arguments):
    from ..optimal_design.designs import grid, sample, triangle

    sources = ("grid", "sample", "triangle", "designs")
    chosen = [f"--{name}" for name in sources if getattr(arguments, name)]
    if len(chosen) != 1:
        wrong = f", not {' and '.join(chosen)}" if chosen else ""
        raise UsageError(f"designs come from one of --grid, --sample, --triangle, --designs{wrong}")
    if arguments.bound and not arguments.sample:
        raise UsageError("--bound is of --sample N")
    if arguments.designs:
        return arguments.designs
    if arguments.triangle:
        return triangle(arguments.triangle)
    if arguments.sample:
        bounds = dict(interval(text, "--bound") for text in arguments.bound)
        return sample(bounds, arguments.sample, arguments.seed)
    return grid(**dict(map(_axis, arguments.grid)))


def _axis(text):
    import numpy as np

    name, values = span(text, "--grid", (1, 3))
    if None in values:
        raise UsageError(f"--grid: a number is missing in {text!r}")
    if len(values) == 1:
        return name, values
    low, high, count = values
    if count != int(count) or not 1 <= count <= 1e6:
        raise UsageError(f"--grid: {count:g} is no count, in {text!r}")
    return name, np.linspace(low, high, int(count))


def _show(arguments, swept, best):
    columns = [*swept.names, *swept.figures]
    table = {name: swept[name][best].tolist() for name in columns}
    for path, write in ((arguments.csv, swept.to_csv), (arguments.plot, swept.plot)):
        if path:
            write(path)
            print(path, file=sys.stderr)
    if arguments.out:
        print(arguments.out, file=sys.stderr)
    rows = zip(best.tolist(), *table.values())
    if arguments.json:
        names = ("design", *columns)
        designs = [dict(zip(names, map(_finite_or_none, row))) for row in rows]
        about = {"designs": swept.count, "errors": len(swept.errors)}
        print(json.dumps(about | {"best": designs}, indent=1))
        return
    widths = [max(12, len(name) + 2) for name in columns]
    print(f"{'design':>8}" + "".join(f"{name:>{w}}" for name, w in zip(columns, widths)))
    for number, *values in rows:
        cells = (f"{value:{width}.6g}" for value, width in zip(values, widths))
        print(f"{number:8d}" + "".join(cells))
    if not len(best):
        print(f"no design has a {swept.figures[0]}", file=sys.stderr)
    for k, text in swept.errors[:3]:
        print(f"design {k}: {text}", file=sys.stderr)
    if len(swept.errors) > 3:
        print(f"... {len(swept.errors)} errors in {swept.count} designs", file=sys.stderr)


def _finite_or_none(value):
    return value if math.isfinite(value) else None
