"""A robot's parameters as TOML, which `robot_files` reads."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ..base.backend import is_symbolic
from ..base.tables import TextFile, written
from ..base.units import unusual
from .parameter_units import units_of


def write_robot(
    path: TextFile,
    robot: Any,
    sd: Mapping[str, float] = {},
    comments: Iterable[str] = (),
    tables: Mapping[str, Mapping[str, Any]] = {},
) -> None:
    """Write a robot as TOML, under lines of comment, with standard deviations, and tables."""
    if isinstance(path, (str, os.PathLike)) and Path(path).suffix.lower() != ".toml":
        raise ValueError(f"a robot is written to a .toml file, not {os.fspath(path)!r}")
    if symbols := [name for name, value in robot.parameters.items() if is_symbolic(value)]:
        raise ValueError(f"a robot with CasADi symbols cannot be written: {', '.join(symbols)}")
    with written(path) as out:
        out.writelines(f"# {line}\n" for line in comments)
        out.write(f'kind = "{robot.words.title.removesuffix(" robot")}"\n')
        for name, value in robot.parameters.items():
            known = f"  # sd {sd[name]:.2g}" if name in sd else ""
            out.write(f"{name} = {_toml(value, name, robot.turns)}{known}\n")
        for title, table in tables.items():
            out.write(f"\n[{title}]\n")
            for name, value in table.items():
                out.write(f"{name} = {_toml(value, name, robot.turns)}\n")


def _toml(value, name, turns):
    if isinstance(value, tuple | list):
        return f"[{', '.join(_toml(part, name, turns) for part in value)}]"
    if isinstance(value, Mapping):
        parts = (f"{key} = {_toml(part, key, turns)}" for key, part in value.items())
        return "{" + ", ".join(parts) + "}"
    units = units_of(name, turns)
    if isinstance(value, float) and unusual(value, units, name[0] == "l"):
        return f'"{value!r} {next(iter(units))}"'
    return repr(value)
