"""What a lab asks of one function: its signature, the right model, and the wrong ones that students
fall for.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np

from ..models.robots import Robot

_SIGNATURE = re.compile(r"\s*(\w+)\s*\(([\w\s,]*)\)\s*->\s*(\w[\w\s,]*)")


@dataclass(frozen=True)
class Misconception:
    """A wrong model with a name and a hint that leads without telling; `model` has the form of
    Exercise.answer.

    turn: one turn in the unit of the model's angles. idle: the answers say nothing of the robot, so
        nothing follows.
    """

    name: str
    hint: str
    model: Any = field(repr=False)  # None where no model is meant
    turn: float = 2 * np.pi
    idle: bool = False


@dataclass(frozen=True)
class Slip:
    """A wrong step of a derivation with its name and hint: `steps` are keywords of
    Exercise.derivation.

    A step that is done once per leg may be a pair (left, right), None where the leg's is right.
    """

    name: str
    hint: str
    steps: dict = field(repr=False)

    def of(self, derivation: Callable) -> Misconception:
        """Return the misconception of who makes this slip and no other."""
        return Misconception(self.name, self.hint, partial(derivation, **self.steps))


@dataclass(frozen=True)
class Exercise:
    """One function of a lab: `Exercise("dgm(q11, q21, assembly_mode) -> x, y", answer, wrong)`.

    answer(robot, *columns): the right model, on columns of shape (n,), gives one array (n, *shape)
    per returned name (a single one need not be in a tuple), nan where the model has no answer.
    wrong: the Misconceptions. angles: returned names compared modulo one turn. shapes: name ->
        shape of the returned names that are no plain numbers.
    guessable: few values are possible,
        so that all rows must be right to earn anything. of_lists: its arguments are lists, and
        answer(robot, *arguments) answers one call. derivation: the right model step
    by step, derivation(robot, *columns, **steps); slips: what can go wrong in its steps.
    """

    signature: str
    answer: Any = field(repr=False)
    wrong: tuple[Misconception, ...] = ()
    angles: tuple[str, ...] = ()
    shapes: dict[str, tuple[int, ...]] = field(default_factory=dict)
    guessable: bool = False
    of_lists: bool = False
    derivation: Any = field(default=None, repr=False)
    slips: tuple[Slip, ...] = field(default=(), repr=False)

    def __post_init__(self):
        if not _SIGNATURE.fullmatch(self.signature):
            raise ValueError(f'a signature reads "name(a, b) -> x, y", not {self.signature!r}')
        unknown = (set(self.angles) | set(self.shapes)) - set(self.returns)
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
        with np.errstate(all="ignore"):  # a model with a mistake may have no answer
            answers = model(robot, *columns)
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
        return self._angle

    @cached_property
    def _angle(self):
        return np.concatenate(
            [np.full(int(np.prod(self.shape(n))), n in self.angles) for n in self.returns]
        )


def _names(part):
    return tuple(word.strip() for word in part.split(",") if word.strip())
