"""What a lab asks of one function: its signature, the right model, and the wrong ones that students
fall for.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ..base.errors import SingularityError, UnreachableError
from ..models.robots import Robot

_SIGNATURE = re.compile(r"\s*(\w+)\s*\(([\w\s,]*)\)\s*->\s*(\w[\w\s,]*)")


@dataclass(frozen=True)
class Misconception:
    """A wrong model with a name and a hint that leads without telling; `model` has the form of
    Exercise.answer.

    idle: the answers say nothing of the robot, so nothing follows.
    """

    name: str
    hint: str
    model: Any = field(repr=False)  # None where no model is meant
    idle: bool = False


@dataclass(frozen=True)
class Exercise:
    """One function of a lab: `Exercise("dgm(q11, q21, assembly_mode) -> x, y", answer, wrong)`.

    answer(robot, *columns): the right model, on columns of shape (n,), gives one array (n, *shape)
    per returned name (a single one need not be in a tuple), nan where the model has no answer; one
    that raises UnreachableError or SingularityError is asked row by row.
    wrong: the Misconceptions. angles: returned names compared modulo one turn; axes: modulo half a
    turn, as the direction of an axis is. shapes: name -> shape of the returned names that are no
    plain numbers.
    guessable: few values are possible,
        so that all rows must be right to earn anything. of_lists: its arguments are lists, and
        answer(robot, *arguments) answers one call.
    """

    signature: str
    answer: Any = field(repr=False)
    wrong: tuple[Misconception, ...] = ()
    angles: tuple[str, ...] = ()
    axes: tuple[str, ...] = ()
    shapes: dict[str, tuple[int, ...]] = field(default_factory=dict)
    guessable: bool = False
    of_lists: bool = False

    def __post_init__(self):
        if not _SIGNATURE.fullmatch(self.signature):
            raise ValueError(f'a signature reads "name(a, b) -> x, y", not {self.signature!r}')
        unknown = {*self.angles, *self.axes, *self.shapes} - set(self.returns)
        if unknown:
            raise ValueError(f"{self.name} does not return {', '.join(sorted(unknown))}")

    @cached_property
    def _parts(self):
        name, arguments, returns = _SIGNATURE.fullmatch(self.signature).groups()
        return name, _names(arguments), _names(returns)

    @property
    def name(self) -> str:
        return self._parts[0]

    @property
    def arguments(self) -> tuple[str, ...]:
        return self._parts[1]

    @property
    def returns(self) -> tuple[str, ...]:
        return self._parts[2]

    def shape(self, name: str) -> tuple[int, ...]:
        """Return shape of a returned name, () for a number."""
        return tuple(self.shapes.get(name, ()))

    def outcome(self, model: Callable, robot: Robot, columns: tuple[np.ndarray, ...]) -> np.ndarray:
        """Return the model's answers to all rows as one array (n, numbers returned)."""
        n = len(columns[0])
        try:
            with np.errstate(all="ignore"):  # a model with a mistake may have no answer
                answers = model(robot, *columns)
        except (UnreachableError, SingularityError):  # in one of the rows at least
            if n == 1:
                return np.full((1, len(self.turns)), np.nan)
            rows = zip(*(np.split(column, n) for column in columns))
            return np.concatenate([self.outcome(model, robot, row) for row in rows])
        if len(self.returns) == 1 and not isinstance(answers, tuple):
            answers = (answers,)
        flat = [
            np.broadcast_to(a, (n, *self.shape(name))).reshape(n, -1)
            for name, a in zip(self.returns, answers)
        ]
        return np.concatenate(flat, axis=1).astype(float)

    def parts(self, numbers: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return the arrays (n, *shape) in the numbers (n, k): the inverse of `outcome`."""
        sizes = np.cumsum([int(np.prod(self.shape(name))) for name in self.returns])[:-1]
        split = np.split(numbers, sizes, axis=1)
        return tuple(part.reshape(-1, *self.shape(name)) for name, part in zip(self.returns, split))

    def is_angle(self) -> np.ndarray:
        """Return which of the numbers in `outcome` are angles, (numbers,)."""
        return np.isfinite(self.turns)

    @cached_property
    def turns(self) -> np.ndarray:
        """By how much each of the numbers in `outcome` may differ, (numbers,): a turn, of an axis
        half a turn, infinite of what is no angle.
        """
        turn = dict.fromkeys(self.angles, 2 * np.pi) | dict.fromkeys(self.axes, np.pi)
        sizes = [int(np.prod(self.shape(name))) for name in self.returns]
        return np.repeat([turn.get(name, np.inf) for name in self.returns], sizes)


def _names(part):
    return tuple(word.strip() for word in part.split(",") if word.strip())
