"""`fivebar sweep`: figures of merit of many designs."""

from __future__ import annotations

import json
import math
import sys
from argparse import _SubParsersAction
from contextlib import nullcontext
from pathlib import Path

from ..base.errors import UsageError
from .robot_options import add_robot_options, chosen_robot
from .task_options import add_task_options, by_option, chosen_task, figure_of, listed, span


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `sweep` to the program's commands."""
    parser = commands.add_parser("sweep", help="figures of merit of many designs")
    parser.add_argument(
        "figures",
        nargs="*",
        metavar="FIGURE",
        help="by name, or FILE.py:FUNCTION; =min or =max: of the best",
    )
    parser.add_argument(
        "--list", action="store_true", help="the figures, with their units and what they are"
    )
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
        "--bound", action="append", default=[], metavar="NAME=LOW:HIGH", help="of --sample"
    )
    group.add_argument(
        "--sample", type=int, metavar="N", help="designs spread evenly between the bounds"
    )
    group.add_argument("--seed", type=int, default=0, help="of --sample (default: 0)")
    group.add_argument(
        "--triangle", type=int, metavar="N", help="Liu's r1 + r2 + r3 = 3, N parts a side"
    )
    group.add_argument("--designs", metavar="FILE", help="a .csv or .npz file of columns by name")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="chunks as they come; a second run goes on there"
    )
    parser.add_argument(
        "--workers", type=int, metavar="N", help="processes (default: one per processor)"
    )
    parser.add_argument(
        "--dask", metavar="ADDRESS", help="a scheduler, tcp://host:8786, or its .json file"
    )
    parser.add_argument("--chunk", type=int, metavar="N", help="designs at a time")
    parser.add_argument(
        "--best", type=int, default=10, metavar="N", help="designs to list (default: %(default)s)"
    )
    parser.add_argument("--csv", type=Path, metavar="FILE", help="a row per design")
    parser.add_argument(
        "--plot", type=Path, metavar="FILE", help="the first figure: .png, .svg or .pdf"
    )
    parser.add_argument("--json", action="store_true", help="the best designs as JSON")
    add_task_options(parser)
    add_robot_options(parser)
    parser.set_defaults(run=_sweep)


def _sweep(arguments):
    if arguments.list:
        print(listed())
        return
    if not arguments.figures:
        raise UsageError("which figure? fivebar sweep --list names them")
    from ..base.workers import dask_executor
    from ..optimal_design.sweeping import sweep

    robot, choices = chosen_robot(arguments), chosen_task(arguments)
    if arguments.plot and arguments.plot.suffix not in (".png", ".svg", ".pdf"):
        raise UsageError(f"--plot must end in .png, .svg or .pdf, not {arguments.plot.name!r}")
    if arguments.dask and arguments.workers:
        raise UsageError("--workers are processes here; with --dask the cluster has its own")
    try:
        designs = _designs(arguments)
        first, _, sense = arguments.figures[0].partition("=")
        figures = [figure_of(each) for each in (first, *arguments.figures[1:])]
        with dask_executor(arguments.dask) if arguments.dask else nullcontext() as executor:
            done = sweep(
                figures,
                designs,
                executor,
                arguments.out,
                robot=robot,
                chunk=arguments.chunk,
                workers=arguments.workers,
                **choices,
            )
        best = done.best(count=arguments.best, sense=sense or None)
    except (ValueError, TypeError) as error:
        raise by_option(error) from None
    except KeyboardInterrupt:
        if arguments.out is None:
            raise
        raise RuntimeError(
            f"interrupted: what was done is in {arguments.out}; the same command goes on there"
        ) from None
    _show(arguments, done, best)


def _designs(arguments):
    from ..optimal_design.designs import grid, sample, triangle

    asked = [name for name in ("grid", "sample", "triangle", "designs") if getattr(arguments, name)]
    if len(asked) != 1:
        found = f", not {' and '.join('--' + name for name in asked)}" if asked else ""
        raise UsageError(f"designs come from one of --grid, --sample, --triangle, --designs{found}")
    if arguments.bound and not arguments.sample:
        raise UsageError("--bound is of --sample N")
    if arguments.designs:
        return arguments.designs
    if arguments.triangle:
        return triangle(arguments.triangle)
    if arguments.sample:
        return sample(
            dict(_bound(each) for each in arguments.bound), arguments.sample, arguments.seed
        )
    import numpy as np

    axes = {}
    for each in arguments.grid:
        name, values = span(each, "--grid", (1, 3))
        if None in values:
            raise UsageError(f"--grid: a number is missing in {each!r}")
        if len(values) == 3 and not (values[2] == int(values[2]) and 1 <= values[2] <= 1e6):
            raise UsageError(f"--grid: {values[2]:g} is no count, in {each!r}")
        axes[name] = (
            values if len(values) == 1 else np.linspace(values[0], values[1], int(values[2]))
        )
    return grid(**axes)


def _bound(text):
    name, values = span(text, "--bound", (1, 2))
    if None in values:
        raise UsageError(f"--bound: a number is missing in {text!r}")
    return name, values[0] if len(values) == 1 else tuple(values)


def _show(arguments, done, best):
    columns = [*done.names, *done.figures]
    table = {name: done[name][best] for name in columns}
    for name, write in (("csv", done.to_csv), ("plot", done.plot)):
        if getattr(arguments, name):
            write(getattr(arguments, name))
            print(getattr(arguments, name), file=sys.stderr)
    if arguments.out:
        print(arguments.out, file=sys.stderr)
    if arguments.json:
        rows = [
            {"design": int(k), **{name: _plain(table[name][n]) for name in columns}}
            for n, k in enumerate(best)
        ]
        print(
            json.dumps({"designs": done.count, "errors": len(done.errors), "best": rows}, indent=1)
        )
        return
    print(f"{'design':>8}" + "".join(f"{name:>{_width(name)}}" for name in columns))
    for n, k in enumerate(best):
        print(f"{k:8d}" + "".join(f"{table[name][n]:{_width(name)}.6g}" for name in columns))
    if not len(best):
        print(f"no design has a {done.figures[0]}", file=sys.stderr)
    for k, text in done.errors[:3]:
        print(f"design {k}: {text}", file=sys.stderr)
    if len(done.errors) > 3:
        print(f"... {len(done.errors)} errors in {done.count} designs", file=sys.stderr)


def _width(name):
    return max(12, len(name) + 2)


def _plain(value):
    return float(value) if math.isfinite(value) else None
