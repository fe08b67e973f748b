"""Robots from TOML and JSON files and RepRapFirmware's config.g, as `--robot FILE` reads them."""

from __future__ import annotations

import json
import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple
from warnings import catch_warnings, simplefilter

from ..base.tables import TextFile, file_or_path, whole_text
from .config_g import config_table
from .named_robots import ROBOTS, NamedRobot
from .parameter_units import table_in_si
from .parameters import kind_that_knows, robot_of
from .robots import Biglide, FiveBar

READERS: dict[str, Any] = {".toml": tomllib.loads, ".json": json.loads, ".g": config_table}
KINDS: dict[str, type] = {"five-bar": FiveBar, "biglide": Biglide}
SECTIONS = "readings", "frame", "constraints", "tool", "measured"  # of a `Machine`
LENGTHS = {"l1", "l2"}
OF_BIGLIDES = {field.name for field in fields(Biglide)} - {field.name for field in fields(FiveBar)}


def load_robot(path: TextFile) -> FiveBar | Biglide:
    """Return the robot in a file, or of a name.

    Parameters
    ----------
    path : name, path or open file
        A name in `fivebar.ROBOTS`; or a .toml or .json file of parameters by name, in SI units or
        with their unit, as "80 mm": those of `FiveBar` or `Biglide`, or with links those of
        `FiveBar.from_links`. kind = "five-bar" or "biglide" says which. Or
        RepRapFirmware's config.g, by its line M669 K9.

    Returns
    -------
    FiveBar or Biglide
        What the file does not name has its usual value. Offsets, frame and constraints of the file
        come with `load_machine`.

    Raises
    ------
    ValueError
        For a file that holds no robot, or one that could be of both kinds; for a length above 3 m,
        a mass above 50 kg or the like without its unit.

    Examples
    --------
    >>> import fivebar as fb
    >>> from pathlib import Path
    >>> from tempfile import mkdtemp
    >>> path = Path(mkdtemp()) / "robot.toml"
    >>> fb.FiveBar(l11=0.1).save(path)
    >>> fb.load_robot(path) == fb.FiveBar(l11=0.1)
    True
    >>> fb.load_robot("plotclock").l11
    0.035
    """
    return read_robot(path).robot


class RobotFile(NamedTuple):
    """What a file holds: its robot, its tables by name, "name = value" of what it leaves out."""

    robot: FiveBar | Biglide
    sections: dict[str, Any]
    defaults: list[str]
    name: str


def read_robot(path: TextFile) -> RobotFile:
    """Return what a file or a name says of a robot; ValueError for one that says none."""
    named = ROBOTS.get(path) if isinstance(path, str) else path
    if isinstance(named, NamedRobot):
        return RobotFile(named.robot, dict(named.tables), [], named.source)
    source = file_or_path(path, "read")
    read = READERS.get(Path(str(getattr(source, "name", source))).suffix.lower())
    if read is None:
        known = ", ".join(ROBOTS)
        raise ValueError(
            f"no robot {path!r}: the known ones are {known}; or a .toml, .json or config.g file"
        )
    text, name = whole_text(path, "a robot")
    try:
        table = read(text)
        if not isinstance(table, dict):
            raise ValueError("a robot is a table of its parameters by name")
        kind = _kind_of(table)
        own = {name: table[name] for name in table if name not in ("kind", *SECTIONS)}
        _refuse_tables(own)
        kind = kind or kind_that_knows(own)
        table = table_in_si(table, kind.turns)
        with catch_warnings():
            simplefilter("ignore")  # of unusual lengths, whose unit the file names
            robot = robot_of({name: table[name] for name in own}, kind)
    except (ValueError, TypeError, RecursionError) as error:
        raise ValueError(f"{name}: {error}") from None
    needed = () if "links" in table else fields(robot)[: robot.lab]
    return RobotFile(
        robot,
        {name: table[name] for name in SECTIONS if name in table},
        [f"{f.name} = {f.default:g}" for f in needed if f.name not in table],
        name,
    )


def _refuse_tables(own):
    """Refuse tables of other names, as [robot]."""
    unknown = [name for name in own if isinstance(own[name], dict) and name != "links"]
    if unknown:
        raise ValueError(
            f"there is no table {', '.join(unknown)}; the known ones are links,"
            f" {', '.join(SECTIONS)}. Lengths and masses stand in none of them, but at the top,"
            ' before the first table: l11 = "90 mm"'
        )


def _kind_of(table):
    """Return the kind that a table names, None where its parameters say it."""
    if "kind" in table:
        if table["kind"] not in KINDS:
            raise ValueError(f'kind must be "five-bar" or "biglide", not {table["kind"]!r}')
        return KINDS[table["kind"]]
    if LENGTHS & set(table) and not (OF_BIGLIDES - LENGTHS) & set(table):
        raise ValueError(
            "l1 and l2 are a biglide's, or those of a five-bar with two equal legs: write"
            ' kind = "biglide", or l11, l12, l21, l22'
        )
    return None
