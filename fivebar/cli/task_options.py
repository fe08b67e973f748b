"""Options for the task of figures of merit."""

from __future__ import annotations

import argparse
import sys
from contextlib import suppress
from importlib.util import module_from_spec, spec_from_file_location
from itertools import zip_longest
from pathlib import Path
from textwrap import fill, indent

from ..base.errors import UsageError
from ..planning.samples import from_csv
from .options import WORKING, named_values, number, usage_errors, used_options

_MODULES: set = set()  # of users, by the names of the modules that they are
TASK = (  # a group of options
    {
        "--table M +": "width height, or x_min x_max y_min y_max",
        "--disc M +": "radius, or x y radius, in place of a table",
        "--poses N N": "nodes of the table (default: 31 31)",
        WORKING: "working modes (default: 1 -1, elbows out)",
        "--motor NAME +": "by name, or its torque at rest (N m) and speed without load (rad/s)",
        "--motion PATH.csv": "t (s), x, y (m), about the task's own origin",
        "--path DRAWING": "a drawing or points, as `draw` reads and rounds them; about that origin",
        "--tolerances NAME=VALUE ...": "of q (rad), l or d (m)",
        "--stiffness NM/RAD": "of each motor",
        "--det-A NUMBER": "least |det A| of a dexterous region",
        "--sin SINE": "least |sin q_i2| of a dexterous region",
        "--margin M": "that discs and rectangles keep",
    },
    "task",
    "what the figures are about, SI units; task_x and task_y move it",
)


def chosen_task(arguments: argparse.Namespace) -> dict:
    """Return the task's options, as `sweep` and `design` take them."""
    from ..models.robots import FiveBar
    from ..paths.machine import Machine

    names = "table disc poses working path stiffness det_A sin margin".split()
    choices = used_options(arguments, *names)
    if len(arguments.disc) == 1:
        choices["disc"] = arguments.disc[0]
    if len(arguments.motor) == 1:
        choices["motor"] = arguments.motor[0]
    elif arguments.motor:
        names = "stall_torque", "no_load_speed"
        choices["motor"] = [
            number(text, "--motor", name)
            for text, name in zip_longest(arguments.motor, names, fillvalue="")
        ]
    if arguments.tolerances:
        choices["tolerances"] = named_values(arguments.tolerances, "--tolerances")
    if arguments.motion:
        with usage_errors():
            choices["motion"] = from_csv(arguments.motion)
            Machine(FiveBar()).for_points_of(choices["motion"])  # figures know no tool and no frame
    return choices


def chosen_bounds(arguments: argparse.Namespace, user: str) -> dict:
    """Return {parameter: (low, high)} of --bound, which what uses them needs."""
    if not arguments.bound:
        raise UsageError(f"{user} needs --bound NAME=LOW:HIGH, as --bound l1=0.05:0.2")
    return named_values(arguments.bound, "--bound", "LOW:HIGH")


def figure_of(text: str) -> object:
    """Return a figure's name, or the function in FILE.py:NAME."""
    file, _, name = text.rpartition(":")
    if not file.endswith(".py"):
        return text
    path = Path(file)
    if path.stem in sys.modules and path.stem not in _MODULES:
        raise UsageError(
            f"{text!r}: {path.stem} is the name of a module that is in use: give the file another"
        )
    spec = spec_from_file_location(path.stem, path)
    if not path.is_file() or spec is None or spec.loader is None or not name:
        raise UsageError(
            f"{text!r}: a figure of your own is FILE.py:FUNCTION, and there is no such file"
        )
    _MODULES.add(path.stem)
    module = sys.modules[path.stem] = module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
        function = getattr(module, name)
    except Exception as error:  # whatever somebody's own file raises
        raise UsageError(f"{text}: {type(error).__name__}: {error}") from None
    with suppress(ImportError):  # Dask's workers do not have this file: they are sent its content.
        import cloudpickle

        cloudpickle.register_pickle_by_value(module)
    return function


def figure_list() -> str:
    """Return all figures and motors, each with its words below it."""
    from ..models.motors import MOTORS
    from ..optimal_design import FIGURES

    lines = []
    for figure in FIGURES.values():
        head = f"{figure.label}, {'max' if figure.better == 'large' else 'min'}"
        if figure.needs:
            head += "; needs " + ", ".join(f"--{need}" for need in figure.needs)
        lines += [head, indent(fill(figure.words, 96), "    ")]
    for name, motor in MOTORS.items():
        line = f"{motor.stall:g} N m at rest, {motor.speed:.4g} rad/s without load"
        lines.append(f"motor {name}: {line}")
        lines.append(f"    {motor.source}")
    return "\n".join(lines)
