"""`fivebar design`: the best robot for a task, or the front of several goals."""

from __future__ import annotations

import json
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
    """Add `design` to the program's commands."""
    parser = commands.add_parser("design", help="the best robot for a task")
    parser.add_argument(
        "goals",
        nargs="*",
        metavar="GOAL",
        help="up to three figures: a name or FILE.py:FUNCTION, with =min or =max",
    )
    parser.add_argument("--list", action="store_true", help="list the figures and their units")
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
        "--step-mm", type=float, metavar="MM", help="lengths are whole multiples of this step"
    )
    parser.add_argument(
        "--points",
        type=int,
        default=20,
        metavar="N",
        help="points on a front (default: %(default)s)",
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the search (default: 0)")
    parser.add_argument(
        "--effort", type=float, default=1.0, metavar="E", help="2: twice as long a search"
    )
    parser.add_argument(
        "--dask",
        metavar="ADDRESS",
        help="a Dask scheduler, for figures that are not in closed form",
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="a folder for the table, the picture and the robots"
    )
    parser.add_argument("--plot", type=Path, metavar="FILE", help=".png, .svg or .pdf")
    parser.add_argument("--json", action="store_true", help="print the designs as JSON")
    add_task_options(parser)
    add_robot_options(parser)
    parser.set_defaults(run=_design)


def _design(arguments):
    if arguments.list:
        print(figure_list())
        return
    if not arguments.goals:
        raise UsageError("which goal? fivebar design --list names the figures")
    from ..base.workers import dask_executor
    from ..optimal_design.figures import FIGURES
    from ..optimal_design.optimum import design

    robot, choices = chosen_robot(arguments), chosen_task(arguments)
    check_ending("--plot", arguments.plot)
    goals = {}
    for text in arguments.goals:
        name, _, sense = text.partition("=")
        smaller = name in FIGURES and FIGURES[name].better == "small"
        goals[figure_of(name)] = sense or ("min" if smaller else "max")
    bounds = dict(interval(text, "--bound") for text in arguments.bound)
    limits = {}
    for text in arguments.limit:
        name, values = span(text, "--limit", (1, 2))
        limits[figure_of(name)] = values[0] if len(values) == 1 else tuple(values)
    step = None if arguments.step_mm is None else arguments.step_mm / 1000
    try:
        with dask_executor(arguments.dask) if arguments.dask else nullcontext() as executor:
            result = design(
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
    _show(arguments, result)


def _show(arguments, result):
    is_front = hasattr(result, "designs")
    designs = result.designs if is_front else (result,)
    if arguments.out and is_front:
        result.save(arguments.out)
    elif arguments.out:
        arguments.out.mkdir(parents=True, exist_ok=True)
        result.save(arguments.out / "design.json")
        result.to_robot_file(arguments.out / "robot.json")
        result.plot(arguments.out / "robot.png")
    if arguments.plot:
        result.plot(arguments.plot)
    for path in filter(None, (arguments.out, arguments.plot)):
        print(path, file=sys.stderr)
    if arguments.json:
        print(json.dumps([design.as_json() for design in designs], indent=1))
    elif is_front:
        _print_front(designs)
    else:
        print(result.report)


def _print_front(designs):
    columns = [*designs[0].parameters, *designs[0].values]
    widths = [max(10, len(name) + 1) for name in columns]
    print("".join(f"{name:>{w}}" for name, w in zip(columns, widths)) + "  held by")
    for design in designs:
        numbers = (*design.parameters.values(), *design.values.values())
        cells = (f"{number:{width}.4g}" for number, width in zip(numbers, widths))
        active = "; ".join(sentence.partition(" is ")[0] for sentence in design.binding)
        print("".join(cells) + f"  {active or 'nothing'}")
