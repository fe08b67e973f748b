"""What a robot's file can say against what each command and each function uses: `robot_uses.toml`.

A command or a function asks the table, in place of checks of its own: what it cannot use is refused
or left out by name. No lower room knows a Machine: `fivebar/__init__` sets `machine_room`.
"""

from __future__ import annotations

import inspect
import os
import tomllib
from collections.abc import Callable, Iterable
from dataclasses import fields, replace
from functools import cache, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, Concatenate, NamedTuple, ParamSpec, Protocol, TypeVar, Union

from .errors import warn

if TYPE_CHECKING:
    from ..models.robots import Robot

P = ParamSpec("P")
T = TypeVar("T")

machine_room: Callable[[], Any] | None = None


class Built(Protocol):
    """A Machine, of which lower rooms know no more than this."""

    @property
    def robot(self) -> Any: ...

    def used_by(self, user: str) -> tuple[Any, str]: ...


AnyRobot = Union["Robot", Built, str, os.PathLike]


class Use(NamedTuple):
    """What one command or function makes of the rows of the table.

    used, kept: names of rows; kept are those that go unchanged into the robot file that is written.
    left_out, refused: {row: reason}; unsaid: rows whose leaving out changes no answer.
    """

    used: tuple[str, ...]
    kept: tuple[str, ...]
    left_out: dict[str, str]
    refused: dict[str, str]
    unsaid: tuple[str, ...]

    def words(self, user: str) -> str:
        """Return in words what the command or function makes of a robot's file."""
        names = uses()[0]
        parts = [f"Of a robot's file {user} uses {', '.join(names[row] for row in self.used)}"]
        if self.kept:
            parts.append(f"keeps {', '.join(names[row] for row in self.kept)}")
        if self.left_out:
            parts.append(f"leaves out {_by_reason(self.left_out, self.left_out)}")
        if self.refused:
            parts.append(f"refuses {_by_reason(self.refused, self.refused)}")
        return ". It ".join(parts) + "."


@cache
def uses() -> tuple[dict[str, str], dict[str, Use]]:
    """Return the words of each row, and the Use of each command and function by its name."""
    table = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))

    def rows(words):
        for word in words.split():
            group = table["groups"].get(word)
            yield from [word] if group is None else rows(group)

    def reasons(by_reason):
        of_row: dict[str, str] = {}
        for key, words in by_reason.items():
            of_row |= dict.fromkeys(rows(words), table["reasons"][key])
        return of_row

    unsaid = table["unsaid"].split()
    found: dict[str, Use] = {}
    for entry in table["use"]:
        use = Use(
            tuple(rows(entry["used"])),
            tuple(rows(entry.get("kept", ""))),
            reasons(entry.get("left_out", {})),
            reasons(entry.get("refused", {})),
            tuple(rows(" ".join(entry.get("left_out", {}).get(k, "") for k in unsaid))),
        )
        found |= dict.fromkeys(entry["of"], use)
    return table["rows"], found


def left_out(user: str, said: Iterable[str]) -> tuple[list[str], str]:
    """Return which rows of those that are said a command or function leaves out, and so in words;
    ValueError where it refuses one.
    """
    use = uses()[1][user]
    said = list(said)
    if refused := _by_reason(use.refused, said):
        raise ValueError(f"{user} refuses a robot with {refused}")
    words = _by_reason(use.left_out, [row for row in said if row not in use.unsaid])
    return [row for row in said if row in use.left_out], words and f"{user} leaves out {words}"


def freed(value: T, names: Iterable[str]) -> T:
    """Return a dataclass with the defaults of these of its fields."""
    named = set(names)
    defaults = {f.name: f.default for f in fields(value) if f.name in named}  # type: ignore
    return replace(value, **defaults)  # type: ignore


def _by_reason(reasons, said):
    names = uses()[0]
    rows: dict[str, list[str]] = {}
    for row in said:
        if row in reasons:
            rows.setdefault(reasons[row], []).append(names[row])
    return "; ".join(f"{', '.join(of_one)}: {reason}" for reason, of_one in rows.items())


def used(value: Any, user: str, name: str = "robot") -> Any:
    """Return a robot as it is; of a Machine, or of the name or file of one, the Machine without
    what a function leaves out, of which it warns.

    Raises
    ------
    TypeError, ValueError, OSError
        It is none of these, there is no such robot, or the function refuses what it says.
    """
    by_name = isinstance(value, (str, os.PathLike)) or hasattr(value, "tables")
    if by_name and machine_room is not None:
        value = machine_room().load_machine(value)
    if not hasattr(value, "used_by"):
        from .checks import robot as must_be_robot  # brings NumPy, without which the program begins

        turns = must_be_robot(value, name).turns  # type: ignore[attr-defined]
        left_out(user, () if turns else ("biglide",))
        return value
    machine, note = value.used_by(user)
    if note:
        warn(note)
    return machine


def _own_robot(found):
    """Return the robot of a Machine; any other as it is, for a Smoothed one has a robot, too."""
    return found.robot if hasattr(found, "used_by") else found


def robot_for(user: str) -> Callable:
    """Rule: the robot alone of what `used` takes."""

    def rule(value, name):
        return _own_robot(used(value, user, name))

    return rule


def takes_robot(
    *others: type, **rules: Callable
) -> Callable[[Callable[Concatenate[Any, P], T]], Callable[Concatenate[Any, P], T]]:
    """Return `takes` for a function of a robot, a Machine, or the name or file of one.

    The function gets the robot. What a Machine says beside it, and the function uses by the table,
    goes into the other arguments: the path is led by its tool in its frame, and its constraints
    hold where the call names no others.

    Parameters
    ----------
    *others : type
        What else the argument robot may be.
    **rules
        As of `takes`.
    """

    def decorate(function):
        signature = inspect.signature(function)
        user = "fb." + function.__qualname__.partition(".")[0]
        robot_is_optional = signature.parameters["robot"].default is None

        from .checks import takes  # brings NumPy

        checked = takes(**rules)(function)

        @wraps(function)
        def with_robot(*args, **kwargs):
            try:
                call = signature.bind(*args, **kwargs)
            except TypeError:  # the function itself says best what is missing
                return function(*args, **kwargs)
            given = call.arguments
            value = given.get("robot")
            if not (isinstance(value, others) or (value is None and robot_is_optional)):
                found = used(value, user)
                given["robot"] = _own_robot(found)
                if found is not given["robot"]:
                    _give(found, given, signature.parameters)
            return checked(*call.args, **call.kwargs)

        return with_robot

    return decorate


def _give(machine, given, parameters):
    """Give the arguments what a Machine says of them."""
    if "constraints" in parameters:
        given["constraints"] = machine.constraints.under(given.get("constraints"))
    if "tool" in parameters:
        given.setdefault("tool", machine.tool)
    elif "path" in given:
        given["path"] = machine.led(given["path"], given.get("working", (-1, -1)))
