"""What a student's numbers have to do with the right ones where no known mistake gives them: facts,
not guesses.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from ..models.robots import Robot
from .exercise import Exercise, Misconception
from .variants import parameters

FEWEST = 4  # rows: fewer fit anything
EXACT = 1e-9
MOST_GRID = 20_000
MOST_DECIMALS = 8
NEARLY, SMALL = (
    1e-4,
    0.1,
)  # of each number; of one that is smaller than that part of the largest, of this part


def _fact(name, hint):
    return Misconception(name, hint, None)


def number_text(value: float, robot: Robot | None) -> str:
    """A number with what it may be made of: "0.18 (2 l)"."""
    text = f"{value:.4g}"
    power = np.log10(abs(value)) if value else 0.0
    if abs(power) > 1.5 and np.isclose(power, round(power), rtol=0, atol=EXACT):
        return text  # a unit: nothing of the robot's
    plain = {
        "1/4": 0.25,
        "1/3": 1 / 3,
        "1/2": 0.5,
        "2": 2.0,
        "3": 3.0,
        "4": 4.0,
        "pi/2": np.pi / 2,
        "pi": np.pi,
        "pi/180": np.pi / 180,
        "180/pi": 180 / np.pi,
        "sqrt 2": 2**0.5,
    }
    for word, size in plain.items():
        if np.isclose(abs(value), size, rtol=EXACT, atol=0):
            own = {
                name
                for name, number in _numbers(robot)
                if np.isclose(abs(value), 1 / number, rtol=EXACT, atol=0)
            }
            sign = "-" if value < 0 else ""
            also = f" = {sign}1/{min(own)}" if own else ""
            return f"{sign}{word}{also}" if word == f"{size:g}" else f"{text} = {sign}{word}{also}"
    for (word, size), (times, factor), power in product(
        _numbers(robot),
        (("", 1.0), ("2 ", 2.0), ("1/2 ", 0.5), ("4 ", 4.0), ("1/4 ", 0.25)),
        (1, -1, 2, -2),
    ):
        if np.isclose(abs(value), factor * size**power, rtol=EXACT, atol=0):
            shown = {
                1: f"{times}{word}",
                -1: f"{times or '1'}/{word}".replace(" /", "/"),
                2: f"{times}{word}^2",
            }
            shown[-2] = f"{times or '1'}/{word}^2".replace(" /", "/")
            return f"{text} = {'-' if value < 0 else ''}{shown[power]}"
    return text


def _numbers(robot):
    """The robot's numbers that are not 0 or 1; equal bars under one name."""
    found = {} if robot is None else parameters(robot)
    bars = {value for name, value in found.items() if name[0] == "l"}
    if len(bars) == 1:
        found = {"l": bars.pop()} | {name: value for name, value in found.items() if name[0] != "l"}
    return [(name, value) for name, value in found.items() if value not in (0.0, 1.0)]


class Fit:
    """The numbers of the answered rows, (n, k), and how the parts of the answer are called."""

    def __init__(self, exercise: Exercise, robot: Robot, columns, came, expected, limits):
        rows = np.all(np.isfinite(came), axis=1) & np.all(np.isfinite(expected), axis=1)
        self.exercise, self.robot, self.rows = exercise, robot, rows
        self.came, self.right = came[rows], expected[rows]
        self.limits = np.broadcast_to(limits, came.shape)[rows]
        self.columns = dict(
            zip(exercise.arguments, (np.asarray(column, float)[rows] for column in columns))
        )
        self.angles = exercise.is_angle()
        self.names = [
            name for name in exercise.returns for _ in range(int(np.prod(exercise.shape(name))))
        ]

    def off(self, a, b):
        raw = np.abs(a - b)
        return np.where(self.angles, np.abs((raw + np.pi) % (2 * np.pi) - np.pi), raw)

    def wrong_names(self) -> list[str]:
        """Returned names of which any number is wrong."""
        bad = np.any(self.off(self.came, self.right) > self.limits, axis=0)
        return [
            name
            for name in self.exercise.returns
            if any(b for b, own in zip(bad, self.names) if own == name)
        ]

    def facts(self) -> Iterator[Misconception]:
        """What holds in all rows, most telling first."""
        if len(self.came) < FEWEST or not self.wrong_names():
            return
        yield from self._rearranged()
        yield from self._rounded()
        yield from self._stuck()
        yield from self._by_name(self._factor, "times the right one")
        yield from self._by_name(self._offset, "")
        yield from self._on_a_grid()

    def constant(self) -> Misconception | None:
        """The same answer whatever is asked."""
        if (
            len(self.came) < FEWEST
            or not np.ptp(self.came, axis=0).max() == 0
            or np.ptp(self.right, axis=0).max() == 0
        ):
            return None
        if not self.came.any():
            zeros = "(" + ", ".join("0" for _ in self.exercise.returns) + ")"
            zeros = zeros if len(self.exercise.returns) > 1 else "0"
            hint = "Your function gives 0 whatever it gets: is it still to be written?"
            return Misconception(f"always {zeros}: unfinished?", hint, None, idle=True)
        hint = "Which of the arguments does your function use on its way to what it returns?"
        return Misconception(
            "always the same answer, whatever the arguments", hint, None, idle=True
        )

    def _rearranged(self):
        """Two numbers exchanged, matrices transposed, signs."""
        returns = self.exercise.returns
        if len(returns) == 2:
            half = self.came.shape[1] // 2
            swapped = np.concatenate([self.came[:, half:], self.came[:, :half]], axis=1)
            if self._all(swapped):
                yield _fact(
                    f"{returns[0]} and {returns[1]} exchanged",
                    "In which order does the signature ask for the two?",
                )
        for name, part in self._parts():
            if len(self.exercise.shape(name)) == 2:
                turned = self.came.copy()
                turned[:, part] = (
                    self.came[:, part].reshape(-1, 2, 2).swapaxes(1, 2).reshape(len(self.came), -1)
                )
                if self._all(turned):
                    yield _fact(f"{name} transposed", f"Which index of {name} counts the rows?")
        wrong = np.any(self.off(self.came, self.right) > self.limits, axis=0)
        if self._all(np.where(wrong, -self.came, self.came)):
            words = []
            for name, part in self._parts():
                places = [self._place(name, k) for k in np.flatnonzero(wrong[part])]
                words += [name] if wrong[part].all() else places
            names = " and ".join(words)
            yield _fact(
                f"the sign of {names} is wrong in every row",
                "Which way does it go for a small step? Try one.",
            )
        elif len(self.came) >= 2 * FEWEST and np.all(
            np.abs(np.abs(self.came) - np.abs(self.right)) <= self.limits
        ):
            yield _fact(
                "right but for signs, which differ from row to row",
                "Where does a sign get lost: abs, a root, a square?",
            )

    def _rounded(self):
        """Cut off or rounded after some decimals, and right but for that."""
        apart = self.off(self.came, self.right)
        for k in range(MOST_DECIMALS + 1):
            if np.all(self.came[apart > self.limits] == 0):
                return  # missing, not rounded
            cut = np.abs(self.came - np.round(self.came, k)) <= 1e-15 * np.maximum(
                1.0, np.abs(self.came)
            )
            if np.all((cut & (apart < 10.0**-k)) | (apart <= self.limits)):
                if k == 0:
                    yield _fact(
                        "whole numbers: the decimals are cut off",
                        "An array that is made of integers keeps only integers: np.zeros(2) holds"
                        " floats, np.array([0, 0]) does not.",
                    )
                    return
                yield _fact(
                    f"rounded after {k} decimals",
                    "Who calculates on with it needs all digits: round what "
                    "you print, not what you return.",
                )
                return

    def _stuck(self):
        """Numbers that are the same in every row, all others right."""
        wrong = np.any(self.off(self.came, self.right) > self.limits, axis=0)
        same = np.ptp(self.came, axis=0) == 0
        if not np.all(same[wrong]) or not np.any(np.ptp(self.right, axis=0)[wrong] > 0):
            return
        places = {name: np.flatnonzero(wrong[part]) for name, part in self._parts()}
        words = [self._place(name, k) for name, found in places.items() for k in found]
        texts = [f"{word} is {value:.4g}" for word, value in zip(words, self.came[0, wrong])]
        for name, part in self._parts():
            if len(part) > 1 and wrong[part].all() and np.ptp(self.came[:, part]) == 0:
                texts = [
                    f"{name} is {self.came[0, part[0]]:.4g}",
                    *(t for t in texts if not t.startswith(f"{name}[")),
                ]
        values = "; ".join(texts)
        yield _fact(
            f"{values} in every row: all else is right",
            "It changes with the pose: on what does it depend?",
        )

    def _place(self, name, k):
        """ "M[0][1]" of the k-th of a returned name's numbers."""
        shape = self.exercise.shape(name)
        return name + "".join(f"[{i}]" for i in np.unravel_index(k, shape)) if shape else name

    def nearly(self) -> Misconception | None:
        """Right to some digits, and not to all."""
        if len(self.came) < FEWEST:
            return None
        sizes = np.maximum(np.abs(self.right), SMALL * np.max(np.abs(self.right)))
        apart = self.off(self.came, self.right) / np.where(self.angles | (sizes == 0), 1.0, sizes)
        if not 0 < (most := apart.max()) < NEARLY:
            return None
        return _fact(
            f"right to {most:.0e}, and no closer",
            "Is a constant rounded (pi), a difference taken for a derivative, a search ended early,"
            " or a float32 used?",
        )

    def _parts(self):
        for name in self.exercise.returns:
            yield name, np.flatnonzero([own == name for own in self.names])

    def _all(self, numbers):
        return np.all(self.off(numbers, self.right) <= self.limits)

    def _by_name(self, find, words):
        """One fact for each wrong name; none unless all of them have one."""
        wrong, found = self.wrong_names(), {}
        for name, part in self._parts():
            if name in wrong:
                found[name] = find(part)
        texts = list(found.values())
        if not texts or None in texts:
            return
        same = len(set(texts)) == 1
        if same and len(wrong) == len(self.exercise.returns):
            text = f"{texts[0]} {words or 'in every row'}"
            name = text if not words else f"{texts[0]} times the right answer in every row"
        else:
            name = "; ".join(f"{name} is {text} {words}".rstrip() for name, text in found.items())
        yield _fact(name, "The same in every row: a factor, a unit or a term too much, or too few?")

    def _factor(self, part):
        came, right = self.came[:, part], self.right[:, part]
        if self.angles[part].any():
            return None
        factor = np.sum(came * right) / np.sum(right * right)
        if (
            not factor
            or abs(factor - 1) < NEARLY
            or not np.all(
                np.abs(came - factor * right) <= np.maximum(1.0, abs(factor)) * self.limits[:, part]
            )
        ):
            return None
        return number_text(float(factor), self.robot)

    def _offset(self, part):
        """A constant, or one of the arguments, too much."""
        if len(part) > 1:
            return None
        apart, limit = (self.came - self.right)[:, part[0]], self.limits[:, part[0]]
        angle = self.angles[part[0]]
        candidates = [("", np.ones(len(apart)))] + [
            (name, c) for name, c in self.columns.items() if np.ptp(c) > 0
        ]
        for name, column in candidates:
            if angle:
                if name:
                    factors = (1.0, -1.0, 2.0, -2.0, 0.5, -0.5)
                else:
                    factors = ((apart[0] + np.pi) % (2 * np.pi) - np.pi,)
            else:
                factors = (np.sum(apart * column) / np.sum(column * column),)
            for factor in factors:
                rest = apart - factor * column
                rest = (rest + np.pi) % (2 * np.pi) - np.pi if angle else rest
                if factor and np.all(np.abs(rest) <= limit):
                    if not name:
                        return f"off by {number_text(float(factor), self.robot)}"
                    times = {1.0: "", -1.0: "-"}.get(round(float(factor), 9))
                    return (
                        "off by"
                        f" {number_text(float(factor), self.robot) + ' ' if times is None else times}{name}"
                    )
        return None

    def _on_a_grid(self):
        if self.came.shape[1] != 1:
            return
        apart = np.abs(self.came - self.right).max()
        for n in range(2, MOST_GRID):
            if apart > 1.5 / n:
                return
            if np.all(np.abs(self.came * n - np.round(self.came * n)) < 1e-9 * n):
                yield _fact(
                    f"a grid's value, a multiple of 1/{n}, not refined",
                    "You have found between which two samples it lies. How do you come closer?",
                )
                return
