"""What figures of merit are about, on the command line."""

from __future__ import annotations

import argparse
import re
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from shutil import get_terminal_size
from textwrap import fill

from ..base.errors import UsageError

_FILES = set()  # of users, by the names of the modules that they are
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
    """The choices of `sweep` and `design`."""
    motor, signs = arguments.motor, arguments.working
    if motor is not None:
        motor = motor[0] if len(motor) == 1 else tuple(number(each, "--motor") for each in motor)
    if signs is not None and (len(signs) != 2 or set(signs) - {"+", "-"}):
        raise UsageError(f"--working must be two signs, as +-, not {signs!r}")
    disc = arguments.disc
    choices = dict(
        table=arguments.table,
        disc=disc[0] if disc and len(disc) == 1 else disc,
        poses=arguments.poses,
        working=None if signs is None else tuple(1 if sign == "+" else -1 for sign in signs),
        motor=motor,
        tolerances=dict(pair(each, "--tolerance") for each in arguments.tolerance) or None,
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


def number(text: str, option: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise UsageError(f"{option}: {text!r} is no number") from None


def pair(text: str, option: str) -> tuple[str, float]:
    """("q", 0.001) of q=0.001."""
    name, sign, value = text.partition("=")
    if not sign:
        raise UsageError(f"{option} must be NAME=VALUE, not {text!r}")
    return name, number(value, option)


def span(text: str, option: str, counts: tuple[int, ...]) -> tuple[str, list[float | None]]:
    """("l1", [0.05, 0.2]) of l1=0.05:0.2; an empty place is None."""
    name, sign, values = text.partition("=")
    found = [number(each, option) if each else None for each in values.split(":")]
    if not sign or len(found) not in counts:
        shape = " or ".join(
            ":".join(("LOW", "HIGH", "COUNT")[:n]) if n > 1 else "VALUE" for n in counts
        )
        raise UsageError(f"{option} must be NAME={shape}, not {text!r}")
    return name, found


def figure_of(text: str) -> object:
    """A name, or the function in FILE.py:NAME."""
    file, _, name = text.rpartition(":")
    if not file.endswith(".py"):
        return text
    path = Path(file)
    if path.stem in sys.modules and path.stem not in _FILES:
        raise UsageError(
            f"{text!r}: {path.stem} is the name of a module that is in use: give the file another"
        )
    spec = spec_from_file_location(path.stem, path)
    if not path.is_file() or spec is None or not name:
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
    _by_value(module)
    return found


def _by_value(module):
    """Dask's workers have not this file: they are sent what is in it."""
    try:
        import cloudpickle
    except ImportError:
        return  # without Dask nothing is sent to where the file is not
    cloudpickle.register_pickle_by_value(module)


def listed() -> str:
    """All figures and motors, each with its words below it."""
    from ..optimal_design import FIGURES, MOTORS

    heads = {}
    for each in FIGURES.values():
        needs = ", ".join(OPTIONS.get(need, f"--{need}") for need in each.needs)
        head = f"{each.label}, {'max' if each.better == 'large' else 'min'}"
        heads[f"{head}; needs {needs}" if needs else head] = each.words
    heads |= {
        f"motor {name}: {m.torque:g} N m, {m.speed:.4g} rad/s": m.source
        for name, m in MOTORS.items()
    }
    width = min(get_terminal_size().columns, 100)
    return "\n".join(
        f"{head}\n{fill(words, width, initial_indent='    ', subsequent_indent='    ')}"
        for head, words in heads.items()
    )


def by_option(error: Exception) -> UsageError:
    """The error in the command line's words: --table where Python's say table=... ."""
    return UsageError(
        re.sub(r"\b(\w+)=(?:\.\.\.|radius)", r"--\1", str(error)).replace(
            "--tolerances", "--tolerance"
        )
    )
