"""Options for the task of figures of merit."""

from __future__ import annotations

import argparse
import re
import sys
from contextlib import suppress
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from shutil import get_terminal_size
from textwrap import fill

from ..base.errors import UsageError

_FILES: set = set()  # of users, by the names of the modules that they are
OPTIONS = {"table": "--table (or --disc)", "tolerances": "--tolerance"}  # of what a figure needs


def add_task_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group(
        "task", "what the figures are about, SI units; task_x and task_y move it"
    )
    group.add_argument(
        "--table",
        nargs="+",
        type=float,
        metavar="M",
        help="width height, or x_min x_max y_min y_max",
    )
    group.add_argument(
        "--disc",
        nargs="+",
        type=float,
        metavar="M",
        help="radius, or x y radius, in place of a table",
    )
    group.add_argument(
        "--poses",
        nargs=2,
        type=int,
        metavar=("NX", "NY"),
        help="nodes of the table (default: 31 31)",
    )
    group.add_argument("--working", metavar="SIGNS", help="of the legs, as +- (default)")
    group.add_argument(
        "--motor", nargs="+", metavar="NAME|N_M RAD_S", help="by name, or its torque and its speed"
    )
    group.add_argument(
        "--motion", metavar="PATH.csv", help="t (s), x, y (m), about the task's own origin"
    )
    group.add_argument(
        "--path",
        metavar="FILE",
        help="a drawing or points, as `draw` reads them; about that origin",
    )
    group.add_argument(
        "--tolerance",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="of q (rad), l or d (m)",
    )
    group.add_argument("--stiffness", type=float, metavar="N_M_RAD", help="of each motor")
    group.add_argument(
        "--det-A", type=float, metavar="K", help="that a dexterous region keeps, |det A| >= K"
    )
    group.add_argument("--sin", type=float, metavar="S", help="the same of |sin q_i2|")
    group.add_argument("--margin", type=float, metavar="M", help="that discs and rectangles keep")


def chosen_task(arguments: argparse.Namespace) -> dict:
    """Return the choices of `sweep` and `design`."""
    motor, signs = arguments.motor, arguments.working
    if motor is not None and len(motor) > 1:
        motor = [[number(text, "--motor") for text in motor]]
    if signs is not None and (len(signs) != 2 or set(signs) - {"+", "-"}):
        raise UsageError(f"--working must be two signs, as +-, not {signs!r}")
    choices = dict(
        table=arguments.table,
        disc=_single(arguments.disc),
        poses=arguments.poses,
        working=None if signs is None else tuple(1 if sign == "+" else -1 for sign in signs),
        motor=_single(motor),
        tolerances=dict(pair(text, "--tolerance") for text in arguments.tolerance) or None,
        path=arguments.path,
        stiffness=arguments.stiffness,
        det_A=arguments.det_A,
        sin=arguments.sin,
        margin=arguments.margin,
    )
    if arguments.motion:
        from ..planning.samples import from_csv

        try:
            choices["motion"] = from_csv(arguments.motion)
        except (OSError, ValueError) as error:
            raise UsageError(error) from None
    return {name: value for name, value in choices.items() if value is not None}


def _single(values):
    """Return the only one of several values, or all of them."""
    return values[0] if values and len(values) == 1 else values


def number(text: str, option: str) -> float:
    """Return a number; UsageError names the option."""
    try:
        return float(text)
    except ValueError:
        raise UsageError(f"{option}: {text!r} is no number") from None


def pair(text: str, option: str) -> tuple[str, float]:
    """Return ("q", 0.001) of q=0.001."""
    name, sign, value = text.partition("=")
    if not sign:
        raise UsageError(f"{option} must be NAME=VALUE, not {text!r}")
    return name, number(value, option)


def span(text: str, option: str, counts: tuple[int, int]) -> tuple[str, list]:
    """Return ("l1", [0.05, 0.2]) of l1=0.05:0.2; None for an empty place."""
    name, sign, values = text.partition("=")
    numbers = [number(value, option) if value else None for value in values.split(":")]
    if not sign or len(numbers) not in counts:
        shape = "LOW:HIGH:COUNT" if 3 in counts else "LOW:HIGH"
        raise UsageError(f"{option} must be NAME=VALUE or {shape}, not {text!r}")
    return name, numbers


def interval(text: str, option: str) -> tuple[str, float | tuple[float, float]]:
    """Return ("l1", (0.05, 0.2)) of l1=0.05:0.2, ("l1", 0.1) of l1=0.1."""
    name, values = span(text, option, (1, 2))
    if None in values:
        raise UsageError(f"{option}: a number is missing in {text!r}")
    if len(values) == 1:
        return name, values[0]
    return name, (values[0], values[1])


def figure_of(text: str) -> object:
    """Return a figure's name, or the function in FILE.py:NAME."""
    file, _, name = text.rpartition(":")
    if not file.endswith(".py"):
        return text
    path = Path(file)
    if path.stem in sys.modules and path.stem not in _FILES:
        raise UsageError(
            f"{text!r}: {path.stem} is the name of a module that is in use: give the file another"
        )
    spec = spec_from_file_location(path.stem, path)
    if not path.is_file() or spec is None or spec.loader is None or not name:
        raise UsageError(
            f"{text!r}: a figure of your own is FILE.py:FUNCTION, and there is no such file"
        )
    _FILES.add(path.stem)
    module = sys.modules[path.stem] = module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
        found = getattr(module, name)
    except Exception as error:  # whatever somebody's own file raises
        raise UsageError(f"{text}: {type(error).__name__}: {error}") from None
    with suppress(ImportError):  # Dask's workers do not have this file: they are sent its content.
        import cloudpickle

        cloudpickle.register_pickle_by_value(module)
    return found


def figure_list() -> str:
    """Return all figures and motors, each with its words below it."""
    from ..optimal_design import FIGURES, MOTORS

    entries = {}
    for figure in FIGURES.values():
        head = f"{figure.label}, {'max' if figure.better == 'large' else 'min'}"
        if figure.needs:
            options = (OPTIONS.get(need, f"--{need}") for need in figure.needs)
            head += f"; needs {', '.join(options)}"
        entries[head] = figure.words
    for name, motor in MOTORS.items():
        entries[f"motor {name}: {motor.torque:g} N m, {motor.speed:.4g} rad/s"] = motor.source
    width = min(get_terminal_size().columns, 100)
    lines = []
    for head, words in entries.items():
        lines += [head, fill(words, width, initial_indent="    ", subsequent_indent="    ")]
    return "\n".join(lines)


def by_option(error: Exception) -> UsageError:
    """Return the error with --table where Python's message has table=... ."""
    message = re.sub(r"\b(\w+)=(?:\.\.\.|radius)", r"--\1", str(error))
    return UsageError(message.replace("--tolerances", "--tolerance"))
