"""Options as lines of usage, and what all commands do with their arguments and results."""

from __future__ import annotations

import json
import os
import sys
from argparse import ArgumentTypeError, Namespace
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from ..base import units
from ..base.errors import UsageError
from ..base.folders import locked_folder
from ..base.representation import printable
from ..models.parameter_units import units_of

# Names of values that are numbers: their table of units, and the unit of one without a unit.
NUMBERS: dict[str, tuple[Mapping[str, float], str]] = {
    **dict.fromkeys("M X Y GROUND CRANK COUPLER ROCKER ROD".split(), (units.METRES, "m")),
    "MM": (units.METRES, "mm"),
    "S": (units.SECONDS, "s"),
    "RAD": (units.RADIANS, "rad"),
    "DEG": (units.RADIANS, "deg"),
    **dict.fromkeys(("FX", "FY"), (units.NEWTONS, "N")),
    "NM": (units.NEWTON_METRES, "N m"),
    "M/S": (units.SPEEDS, "m/s"),
    "M/S2": (units.ACCELERATIONS, "m/s²"),
    "RAD/S": (units.RADIANS_PER_SECOND, "rad/s"),
    "NM/RAD": (units.STIFFNESSES, "N m/rad"),
    "HZ": (units.HERTZ, "Hz"),
    **dict.fromkeys("K SINE SHARE NUMBER PERCENT DOWN UP".split(), (units.NO_UNIT, "")),
    **dict.fromkeys("Q1 Q2 X0 X1 Y0 Y1".split(), (units.METRES | units.RADIANS, "")),
}
# Files to be written: the endings of which one must be theirs.
WRITTEN: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("OUT", "OUT.csv", "OUT.json"), ()),
    "OUT.png": (".png", ".svg", ".pdf"),
    "OUT.html": (".html", ".gif", ".mp4", ".webm", ".png"),
    "PAGE.html": (".html", ".htm"),
    "GRID.csv": (".csv", ".npz"),
}
JSON: dict[str, Any] = {"--json": "the result as JSON on stdout"}
# Of commands that read a table.
TABLE = JSON | {"--columns NAME=HEADING ...": "of columns with other headings, as x='East (mm)'"}
WORKING = "--working -1|1 -1|1"


def add_options(
    parser: Any, options: Mapping[str, Any], title: str | None = None, words: str | None = None
) -> None:
    """Add options {usage: help, or (default, help)}; with a title as a group of their own.

    A usage is written as in the help: "--fit" is a flag, "--at X Y" takes two numbers,
    "--space task|joint" one of two words and "--units UNIT ..." any number of values, also
    when the option is repeated; of "--disc M +" the last ones count. A value without an option
    is "NAME", "[FILE]" or "[GOAL ...]". The name of a value tells its type.
    """
    target = parser if title is None else parser.add_argument_group(title, words)
    for usage, text in options.items():
        settings: dict[str, Any] = {}
        if isinstance(text, tuple):
            default, text = text
            settings["default"] = default
            shown = " ".join(map(str, default)) if isinstance(default, tuple) else default
            text += f" (default: {shown})"
        name, *values = usage.strip("[]").split()
        may_lack = usage.startswith("[")
        if not name.startswith("--"):
            values.insert(0, name)
            name = name.partition(".")[0].lower()
            settings["nargs"] = "?" if may_lack else None
        if not values:
            target.add_argument(name, action="store_true", help=text)
            continue
        kind = settings["type"] = type_of(values[0], name)
        if "|" in values[0]:
            settings["choices"] = [kind(choice) for choice in values[0].split("|")]
        if values[-1] in ("...", "+"):
            several = "*" if may_lack else "+"
            settings |= {"nargs": several, "default": []}
            settings["action"] = "extend" if values[-1] == "..." else "store"
            settings["metavar"] = " ".join(values[:-1])
        elif len(values) > 1:
            settings |= {"nargs": len(values), "metavar": tuple(values)}
        else:
            settings["metavar"] = values[0]
        target.add_argument(name, help=text.strip(), **settings)


def add_command(
    commands: Any, name: str, run: Callable[[Namespace], None], *groups: tuple, **settings: Any
) -> Any:
    """Add a command that a function runs; groups: each the arguments of `add_options`."""
    parser = commands.add_parser(name, **settings)
    for group in groups:
        add_options(parser, *group)
    parser.set_defaults(run=run, parser=parser)
    return parser


def type_of(value: str, option: str) -> Callable[[str], Any]:
    """Return what reads the text of a value with this name."""
    if value in ("N", "-1|1"):
        return _whole_number
    if value in NUMBERS:
        return partial(_number, *NUMBERS[value])
    if value in WRITTEN:
        return partial(_file_to_write, option, WRITTEN[value])
    if value == "FILE" or value.endswith((".csv", ".json", ".txt")):
        return partial(_file_to_read, option)
    return Path if value in ("DIR", "FOLDER", "SUBMISSION") else str


def _whole_number(text):
    try:
        return int(text)
    except ValueError:
        raise ArgumentTypeError(f"{text!r} is not a whole number") from None


def _number(known, unit, text):
    try:
        return units.number_in(text, known, unit)
    except ValueError as error:
        raise ArgumentTypeError(str(error)) from None


def _file_to_read(option, text):
    path = Path(text)
    if not path.exists():
        raise UsageError(f"no file {text!r} for {option}")
    return path


def _file_to_write(option, endings, text):
    """Return the path, and make its folder; refuse it, if it must be, before the work begins."""
    path = Path(text)
    if path.is_dir():
        raise UsageError(f"{text} is a folder already")
    if endings and path.suffix not in endings:
        known = " or ".join([", ".join(endings[:-1]), endings[-1]])
        raise UsageError(f"{option} must end in {known}, not {path.name!r}")
    with usage_errors(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
    return path


def used_options(arguments: Namespace, *names: str) -> dict[str, Any]:
    """Return those options that were used, by name; a command may have no option of a name."""
    values = {name: vars(arguments).get(name) for name in names}
    return {name: value for name, value in values.items() if value not in (None, [])}


def changed_options(arguments: Namespace) -> set[str]:
    """Return the names of those options whose values are not their defaults."""
    default = arguments.parser.get_default
    return {name for name, value in vars(arguments).items() if value != default(name)}


def refuse_others(arguments: Namespace, words: str, *names: str) -> None:
    """Raise UsageError with these words where options of other names are used."""
    if changed_options(arguments).difference(("command", *names)):
        raise UsageError(words)


@contextmanager
def usage_errors(*kinds: type[Exception]) -> Iterator[None]:
    """Turn errors of these kinds into a UsageError; of values and files by default."""
    expected = kinds or (ValueError, OSError)
    try:
        yield
    except expected as error:
        raise UsageError(error) from None


def option_of(name: str) -> str:
    """Return an option as it is typed, by the name that its value has."""
    return "--" + name.replace("_", "-")


def number(text: str, option: str, name: str = "") -> float:
    """Return a number, with a unit of the parameter's of this name; UsageError names the option."""
    try:
        return units.number_in(text, units_of(name))
    except ValueError as error:
        raise UsageError(f"{option}: {error}") from None


def named_values(texts: Iterable[str], option: str, form: str = "VALUE") -> dict[str, Any]:
    """Return {name: number} of NAME=VALUE, and {name: numbers} of NAME=LOW:HIGH, or as the form
    is; None for an end of LOW:HIGH that is left out.
    """
    found: dict[str, Any] = {}
    for text in texts:
        name, sign, values = text.partition("=")
        parts = values.split(":")
        if not sign or len(parts) not in (1, form.count(":") + 1):
            shape = form if form == "VALUE" else f"VALUE or {form}"
            raise UsageError(f"{option} must be NAME={shape}, not {text!r}")
        numbers: list[Any] = []
        for part, of in zip(parts, form.split(":")):
            own = "" if of == "COUNT" else name
            is_open = len(parts) == 2 and not part
            value: Any = None if is_open else number(part, option, own)
            numbers.append(int(value) if of == "COUNT" and value.is_integer() else value)
        found[name] = numbers[0] if len(numbers) == 1 else tuple(numbers)
    return found


def point_words(point: Iterable[float], scale: float = 1e3, unit: str = "mm") -> str:
    """Return a point (2,), m, in words; scale: of the unit, to a metre."""
    x, y = point
    return f"({scale * x:.4g}, {scale * y:.4g}) {unit}"


def size_words(size: Iterable[float], scale: float = 1e3, unit: str = "mm") -> str:
    """Return width and height, m, in words; scale: of the unit, to a metre."""
    width, height = size
    return f"{scale * width:.4g} x {scale * height:.4g} {unit}"


def print_message(text: object) -> None:
    """Write a line to stderr; names in it may be hostile."""
    print(printable(str(text)), file=sys.stderr)


def print_notes(file: object, notes: Iterable[str]) -> None:
    """Write to stderr what is to be said of a file."""
    for note in notes:
        print_message(f"{file}: {note}")


def print_table(rows: Iterable[tuple[str, str]]) -> None:
    """Print names and values in two columns."""
    for name, value in rows:
        print(f"  {name:<20} {value}")


def write_files(folder: Path, writers: Mapping[str, Callable[[Path], object]]) -> list[Path]:
    """Write files into a folder of results, each by its function; return where they are."""
    from ..base.progress import progress

    with locked_folder(folder):
        for name, write in progress(writers.items(), desc="files", delay=2, leave=False):
            write(folder / name)
    return [folder / name for name in writers]


def write_options(
    arguments: Namespace, writers: Mapping[str, Callable[[Path], object]]
) -> list[Path]:
    """Write the files of those options that were used, each by its function; return where they
    are.
    """
    paths = used_options(arguments, *writers)
    for name, path in paths.items():
        writers[name](path)
    return list(paths.values())


def print_files(files: Iterable[object]) -> None:
    """Print the names of written files, one a line."""
    for file in files:
        print(file)


def print_json(content: object) -> None:
    """Print an object as JSON; nan and infinity, which JSON lacks, as null."""
    from ..estimation.saving import encode

    print(json.dumps(encode(content), indent=2, default=os.fspath))
