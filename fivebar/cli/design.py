"""`fivebar design`: the best robot for a task, or the front of several goals."""

from __future__ import annotations

import json
import sys
from argparse import _SubParsersAction
from contextlib import nullcontext
from pathlib import Path

from ..base.errors import UsageError
from .robot_options import add_robot_options, chosen_robot
from .task_options import add_task_options, by_option, chosen_task, figure_of, listed, span


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `design` to the program's commands."""
    parser = commands.add_parser("design", help="the best robot for a task")
    parser.add_argument(
        "goals",
        nargs="*",
        metavar="GOAL",
        help="up to three figures, by name or FILE.py:FUNCTION; with =min or =max",
    )
    parser.add_argument(
        "--list", action="store_true", help="the figures, with their units and what they are"
    )
    parser.add_argument(
        "--bound", action="append", default=[], metavar="NAME=LOW:HIGH", help="or NAME=VALUE, fixed"
    )
    parser.add_argument(
        "--limit",
        action="append",
        default=[],
        metavar="FIGURE=LOW:HIGH",
        help="or VALUE, LOW:, :HIGH",
    )
    parser.add_argument(
        "--step-mm", type=float, metavar="MM", help="lengths are whole multiples of it"
    )
    parser.add_argument(
        "--points", type=int, default=20, metavar="N", help="on a front (default: %(default)s)"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the search (default: 0)")
    parser.add_argument(
        "--effort", type=float, default=1.0, metavar="E", help="2: twice as long a search"
    )
    parser.add_argument(
        "--dask", metavar="ADDRESS", help="who computes figures that are not in closed form"
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="a front's table, picture, and robots as files"
    )
    parser.add_argument("--plot", type=Path, metavar="FILE", help=".png, .svg or .pdf")
    parser.add_argument("--json", action="store_true", help="the designs as JSON on stdout")
    add_task_options(parser)
    add_robot_options(parser)
    parser.set_defaults(run=_design)


def _design(arguments):
    if arguments.list:
        print(listed())
        return
    if not arguments.goals:
        raise UsageError("which goal? fivebar design --list names the figures")
    from ..base.workers import dask_executor
    from ..optimal_design.figures import FIGURES
    from ..optimal_design.optimum import design

    robot, choices = chosen_robot(arguments), chosen_task(arguments)
    if arguments.plot and arguments.plot.suffix not in (".png", ".svg", ".pdf"):
        raise UsageError(f"--plot must end in .png, .svg or .pdf, not {arguments.plot.name!r}")
    goals = {}
    for each in arguments.goals:
        name, _, sense = each.partition("=")
        figure = figure_of(name)
        known = FIGURES[name].better if name in FIGURES else "large"
        goals[figure] = sense or ("max" if known == "large" else "min")
    bounds = {
        name: _pair(values)
        for name, values in (span(each, "--bound", (1, 2)) for each in arguments.bound)
    }
    limits = {}
    for each in arguments.limit:
        name, values = span(each, "--limit", (1, 2))
        limits[figure_of(name)] = values[0] if len(values) == 1 else tuple(values)
    step = None if arguments.step_mm is None else arguments.step_mm / 1000
    try:
        with dask_executor(arguments.dask) if arguments.dask else nullcontext() as executor:
            found = design(
                goals,
                bounds,
                limits=limits,
                robot=robot,
                points=arguments.points,
                seed=arguments.seed,
                step=step,
                effort=arguments.effort,
                executor=executor,
                **choices,
            )
    except (ValueError, TypeError) as error:
        raise (
            ArithmeticError(error) if "nothing within" in str(error) else by_option(error)
        ) from None
    _show(arguments, found)


def _pair(values):
    if None in values:
        raise UsageError("--bound: a number is missing")
    return values[0] if len(values) == 1 else tuple(values)


def _show(arguments, found):
    designs = getattr(found, "designs", (found,))
    if arguments.out:
        if len(designs) > 1 or hasattr(found, "designs"):
            found.save(arguments.out)
        else:
            arguments.out.mkdir(parents=True, exist_ok=True)
            found.save(arguments.out / "design.json")
            found.to_robot_file(arguments.out / "robot.json")
            found.plot(arguments.out / "robot.png")
        print(arguments.out, file=sys.stderr)
    if arguments.plot:
        found.plot(arguments.plot)
        print(arguments.plot, file=sys.stderr)
    if arguments.json:
        print(json.dumps([each.as_json() for each in designs], indent=1))
        return
    if found is designs[0]:
        print(found.report)
        return
    columns = [*designs[0].parameters, *designs[0].values]
    print("".join(f"{name:>{max(10, len(name) + 1)}}" for name in columns) + "  held by")
    for each in designs:
        numbers = {**each.parameters, **each.values}
        held = "; ".join(sentence.partition(" is ")[0] for sentence in each.binding)
        print(
            "".join(f"{numbers[name]:{max(10, len(name) + 1)}.4g}" for name in columns)
            + f"  {held or 'nothing'}"
        )
