"""`fivebar design`: the best robot for a task, or the front of several goals."""

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
    used_options,
    write_files,
    write_options,
)
from .robot_options import add_robot_options, chosen_machine
from .task_options import TASK, chosen_bounds, chosen_task, figure_list, figure_of

OPTIONS = JSON | {
    "[GOAL ...]": "up to three figures: a name or FILE.py:FUNCTION, with =min or =max",
    "--list": "list the figures and their units",
    "--bound NAME=LOW:HIGH ...": "or NAME=VALUE, fixed",
    "--limit FIGURE=LOW:HIGH ...": "or VALUE, LOW:, :HIGH",
    "--step-mm MM": "lengths are whole multiples of this step",
    "--points N": (20, "points on a front"),
    "--seed N": (0, "seed of the search"),
    "--effort NUMBER": (1.0, "2: twice as long a search"),
    "--dask ADDRESS": "a Dask scheduler, for figures that are not in closed form",
    "--out DIR": "a folder for the table, the picture and the robots",
    "--plot OUT.png": "a picture: .png, .svg or .pdf",
}


def add_parsers(commands):
    """Add `design` to the program's commands."""
    add_robot_options(add_command(commands, "design", _design, (OPTIONS,), TASK))


def _design(arguments):
    if arguments.list:
        print(figure_list())
        return
    if not arguments.goal:
        raise UsageError(
            "which goal? It goes before the options, as fivebar design bars --bound l1=0.1:0.2;"
            " fivebar design --list names the figures"
        )
    from ..base.workers import dask_executor
    from ..optimal_design.optimum import design

    robot, choices = chosen_machine(arguments).robot, chosen_task(arguments)
    goals = {}
    for text in arguments.goal:
        name, _, sense = text.partition("=")
        goals[figure_of(name)] = sense or None
    bounds = chosen_bounds(arguments, "design")
    limits = named_values(arguments.limit, "--limit", "LOW:HIGH")
    limits = {figure_of(name): value for name, value in limits.items()}
    step = None if arguments.step_mm is None else arguments.step_mm / 1000
    try:
        with dask_executor(arguments.dask) as executor:
            result = design(
                goals,
                bounds,
                limits=limits,
                robot=robot,
                step=step,
                executor=executor,
                **used_options(arguments, "points", "seed", "effort"),
                **choices,
            )
    except (ValueError, TypeError) as error:
        kind = ArithmeticError if "nothing within" in str(error) else UsageError
        raise kind(error) from None
    _show(arguments, result)


def _show(arguments, result):
    is_front = hasattr(result, "designs")
    designs = result.designs if is_front else (result,)
    save = result.save if is_front else partial(_save_one, result)
    for path in write_options(arguments, {"out": save, "plot": result.plot}):
        print_message(path)
    if arguments.json:
        print_json([design.as_json() for design in designs])
    elif is_front:
        _print_front(designs)
    else:
        print(result.report)


def _save_one(design, folder):
    files = {"design.json": design.save, "robot.json": design.to_robot_file}
    write_files(folder, files | {"robot.png": design.plot})


def _print_front(designs):
    lines = [[*designs[0].parameters, *designs[0].values, "active constraints"]]
    for design in designs:
        numbers = (*design.parameters.values(), *design.values.values())
        active = "; ".join(sentence.partition(" is ")[0] for sentence in design.binding)
        lines.append([*(f"{number:.4g}" for number in numbers), active or "nothing"])
    print(*aligned(lines, 0), sep="\n")
