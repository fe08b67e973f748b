"""A robot's fields: what each may be, and which of them it shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any, ClassVar

from ..base.backend import is_symbolic
from ..base.checks import (
    base,
    inertia,
    moment,
    not_negative,
    not_too_different,
    not_too_narrow,
    size,
    two_numbers,
)
from ..base.errors import warn
from ..base.units import METRES, unusual
from .physics import named

if TYPE_CHECKING:
    from ..base.tables import TextFile
    from .links import Link

MAY_BE_NEGATIVE = (
    "zz1",
    "zz2",
    "m",
)  # what is grouped, of a heavy bar whose centre of mass is not between its ends
_asked: list[str] = []  # the length that was asked about: once, a sweep has thousands of robots


def _rule(robot, name):
    """Return the rule for a field by its name."""
    if name[0] == "l":
        return size
    if name == "d":
        return base
    if name[0] == "f":
        return not_negative
    if name.startswith("mx") or name.startswith("my") or name in robot.turning_names:
        return moment
    if name in MAY_BE_NEGATIVE and any(named(getattr(robot, each)) for each in robot.turning_names):
        return moment
    return inertia


def check_values(robot):
    """Make every field a float: lengths of bars > 0, all others >= 0, none so large or small that
    products fail.
    """
    # First those that say whether others may be negative.
    for f in sorted(fields(robot), key=lambda f: f.name not in robot.turning_names):
        value = getattr(robot, f.name)
        if f.name == "gravity":
            object.__setattr__(robot, "gravity", _gravity(value))
            continue
        if is_symbolic(value):
            if value.numel() == 1 and not value.is_constant():
                continue  # what a compiled function is told later
            if value.numel() == 1:
                value = float(value)  # CasADi's numbers are numbers
        object.__setattr__(robot, f.name, _rule(robot, f.name)(value, f.name))
    lengths = {f.name: getattr(robot, f.name) for f in fields(robot) if f.name[0] == "l"}
    if not any(map(is_symbolic, lengths.values())):
        not_too_different(lengths)
        not_too_narrow(robot.d, max(lengths.values()))
        ask_about_units(lengths)
    for rub, own in zip(("fv1", "fv2", "fs1", "fs2"), robot.words.inertias * 2):
        value = getattr(robot, rub)
        inertia_of = getattr(robot, own)
        if named(value) and not named(inertia_of):
            raise ValueError(
                f"{rub} = {value} is the friction of a drive, but {own} = 0: there is nothing that"
                " it slows"
            )


def ask_about_units(lengths: Mapping[str, float]) -> None:
    """Warn of the first length of a bar {name: m} that is more likely in another unit."""
    for name, length in lengths.items():
        question = name[0] == "l" and unusual(length, METRES, is_bar=True)
        if question and not _asked:
            warn(f"{name}: {question} Lengths are in m")
            _asked.append(name)


def _gravity(value):
    """Return (gx, gy), numbers or symbols."""
    symbols = is_symbolic(value) and value.numel() == 2
    if symbols or (
        isinstance(value, (tuple, list)) and len(value) == 2 and any(map(is_symbolic, value))
    ):
        return value[0], value[1]
    return two_numbers(value, "gravity")


class Named:
    """What a robot shows of itself: the first `lab` parameters, the lab's, and of the others those
    that are named.
    """

    lab = 0
    links: Mapping[str, Link] = {}  # whose inertias the robot has; {}: not known
    __dataclass_fields__: ClassVar[dict]

    def __repr__(self):
        return (
            f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self.parameters.items())})"
        )

    @property
    def parameters(self) -> dict[str, Any]:
        """{name: value} of the lab's parameters and of those beyond that are not 0."""
        names = list(self.__dataclass_fields__)
        always = names[: self.lab]
        values = {name: getattr(self, name) for name in names}
        return {
            k: v
            for k, v in values.items()
            if k in always or (any(map(named, v)) if k == "gravity" else named(v))
        }

    def save(self, path: TextFile) -> None:
        """Write the parameters as TOML, which `load_robot` and `--robot` read.

        Parameters
        ----------
        path : path or file
            A name that ends with .toml.

        Raises
        ------
        ValueError
            For another ending, or CasADi symbols among the parameters.
        """
        from .robot_writing import write_robot  # here, as few robots are written

        write_robot(path, self)
