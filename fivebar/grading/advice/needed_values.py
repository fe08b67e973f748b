"""Which value a formula in a student's program would need, so that its function is right."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, starmap

import numpy as np

from ...base.backend import wrap
from ..columns import largest
from ..judging.judge import numbers_of
from ..judging.questions import AskedRows, rows_from
from ..judging.with_right_ones import Helped
from ..worker.replies import Reply
from ..worker.student import Tried
from ..worker.wire import Change
from .formulas import OLD, Values
from .values_beside import known_values

ARGUMENT = "an argument"
ALL = -1  # in place of a place whose visits are told
SCREENED = 2  # rows in which a place is looked at first
MOST_UNKNOWNS = 4  # numbers of a place in one call that are looked for
STEPS = 12  # of Newton's method
SOLVED = 1e-9  # of the largest right answer
HALVINGS = 4  # of a step that leads nowhere
STARTS = (  # factors of a place's numbers
    (1, -1),
    (-1, 1),
    (-1, -1),
    (0.5, 0.5),
    (0.1, 0.1),
    (2, 2),
)
NEARLY = 1e-6  # of the largest right answer: what other signs leave where it is the signs
SLOW = 0.9  # of the error, that a step leaves: where it leaves more, there is no such value
FARTHEST = 1e4  # that a number goes in a step: a loop that subtracts turns must come to its end
STEP = 1e-6  # of a number, to see what depends on it
SMALLEST = 1e-2  # number of which such a step is taken
AT_ONCE = 1_000  # calls of one request


@dataclass(frozen=True)
class Place:
    """A place of a program: its number, what a worker told of it, which numbers of the answer
    depend on it, and whether all these are angles.
    """

    number: int
    told: Change
    moved: np.ndarray
    turns: bool

    function = property(lambda self: self.told.function)
    text = property(lambda self: self.told.old)
    is_argument = property(lambda self: self.told.kind == ARGUMENT)
    unread = property(lambda self: self.told.new.split())  # names that its function does not use


@dataclass(frozen=True)
class Need:
    """A place with what it is worth in each call (calls, numbers), and what it would need to be, so
    that the numbers of the answer that depend on it are right.
    """

    place: Place
    old: np.ndarray
    wanted: np.ndarray


class Needs:
    """The values that the places of a function need, in some rows of a check."""

    def __init__(self, student: Helped, tried: Tried, rows: AskedRows):
        self._student, self.rows = student, rows
        self._tried = replace(tried, watched=True)
        self._plain = rows_from(rows.columns)
        exercise = rows.exercise
        self._right = rows.expected
        self._angles = exercise.is_angle()
        self._parts = np.where(self._angles, exercise.turns / (2 * np.pi), 1.0)
        self._scale = np.where(self._angles, 1.0, largest(self._right))
        replies = self._replies([(row, ()) for row in range(len(self._plain))], ALL)
        off = self._off(replies, range(len(self._plain)))
        self.wrong = ~(np.abs(off) <= SOLVED * self._scale).all(axis=0)
        self._told = [*student.changes]
        self._visits = [reply.visits for reply in replies]
        self.seconds = max(reply.seconds for reply in replies)  # of a call that is watched

    def all(self) -> Iterator[Need]:
        """Yield the needs of all places that can make numbers right that are wrong."""
        starts = self._starts()
        found = self._solve(starts, range(min(SCREENED, len(self._plain))))
        whole = {number: starts[number] for number in found}
        every = range(len(self._plain))
        for number, (wanted, moved) in self._solve(whole, every).items():
            turns = bool(self._angles[moved].all())
            place = Place(number, self._told[number], moved, turns)
            yield Need(place, starts[number], wanted)

    def _visits_of(self, number):
        """Return the visits of a place in each row."""
        return [seen.get(number, []) for seen in self._visits]

    def _shape(self, number):
        """Return how many visits a place has in each row, and how many numbers in each visit; 0, 0
        where these are not the same.
        """
        visits = self._visits_of(number)
        counts = {*map(len, visits)}
        sizes = {len(numbers) for row in visits for numbers in row}
        same = len(counts) == len(sizes) == 1
        return (max(counts), max(sizes)) if same else (0, 0)

    def _starts(self):
        """Return place -> what it is worth (rows, numbers), of those whose numbers are few."""
        starts = {}
        for number in range(len(self._told)):
            count, size = self._shape(number)
            if 0 < count * size <= MOST_UNKNOWNS:
                starts[number] = np.reshape(self._visits_of(number), (-1, count * size))
        return starts

    def _solve(self, starts, rows):
        """Return place -> (the numbers with which what depends on it is right (rows, numbers), what
        depends on it), of those places that have such numbers in these rows.
        """
        rows = list(rows)
        now = {number: start[rows].copy() for number, start in starts.items()}
        off = self._errors(now, rows)
        moved, solved, last = {}, {}, {}
        for _ in range(STEPS):
            slopes = self._slopes(now, off, rows)
            for number in [*now]:
                depends = (np.abs(slopes[number]) > 0).any(axis=(0, 1))
                known = moved.get(number, False) | depends
                moved[number] = known
                if not (known & self.wrong).any() or known.sum() < now[number].shape[1]:
                    del now[number]
            if not now:
                break
            steps = {}
            for number in now:
                slope, error = slopes[number], off[number]
                if np.isfinite(slope).all() and np.isfinite(error).all():
                    depends = moved[number]
                    steps[number] = np.array(
                        [
                            np.linalg.lstsq(one[:, depends].T, -each[depends])[0]
                            for one, each in zip(slope, error)
                        ]
                    )
            now, off = self._stepped(now, steps, rows)
            for number in [*now]:
                left = self._left(off[number], moved[number]).max()
                # One step more, as small numbers need more digits than the answer shows.
                if left <= SOLVED and last.get(number, np.inf) <= SOLVED:
                    solved[number] = now.pop(number), moved[number]
                elif number in last and not left <= max(SLOW * last[number], SOLVED):
                    del now[number]
                else:
                    last[number] = left
        return solved

    def _stepped(self, now, steps, rows):
        """Return the numbers after a step, and the errors with them."""
        made = {}
        for number, step in steps.items():
            made[number] = now[number] + np.clip(step, -FARTHEST, FARTHEST)
        return made, self._errors(made, rows)

    def _left(self, off, moved):
        """Return the largest error of each row (rows,) among the numbers that move."""
        return np.abs(off / self._scale)[:, moved].max(axis=1)

    def _errors(self, put, rows):
        """Return place -> errors (rows, numbers) with these numbers put in it."""
        if not put:
            return {}
        calls = []
        for number, values in put.items():
            for k, row in enumerate(rows):
                calls.append((row, ((number, values[k]),)))
        off = self._off(self._replies(calls), [row for row, _ in calls])
        return dict(zip(put, off.reshape(len(put), len(rows), -1)))

    def _slopes(self, now, off, rows):
        """Return place -> slopes (rows, its numbers, numbers of the answer)."""
        calls, widths = [], []
        for number, values in now.items():
            for k, row in enumerate(rows):
                for j in range(values.shape[1]):
                    size = max(abs(values[k, j]), SMALLEST)
                    width = STEP * size
                    other = values[k].copy()
                    other[j] += width
                    widths.append(width)
                    calls.append((row, ((number, other),)))
        errors = self._off(self._replies(calls), [row for row, _ in calls])
        slopes, start = {}, 0
        for number, values in now.items():
            count = values.size
            some = errors[start : start + count].reshape(*values.shape, -1)
            size = np.array(widths[start : start + count])
            size = size.reshape(*values.shape, 1)
            with np.errstate(invalid="ignore"):
                change = self._turned(some - off[number][:, None])
                slopes[number] = change / size
            start += count
        return slopes

    def _replies(self, calls, told=None) -> list[Reply]:
        rows, replies = self.rows, []
        for some in batches(calls, AT_ONCE):
            numbers = [[told, *starmap(self._put, put)] for _, put in some]
            replies += self._student.ask(
                rows.exercise.name,
                [self._plain[row] for row, _ in some],
                rows.constants,
                tried=replace(self._tried, numbers=numbers),
            )
        return replies

    def _put(self, number, values):
        visits = len(self._visits[0][number])
        return [number, np.reshape(values, (visits, -1)).tolist()]

    def _off(self, replies, rows):
        """Return errors (calls, numbers), nan where there is no answer."""
        came = numbers_of(self.rows.exercise, replies)
        return self._turned(came - self._right[[*rows]])

    def _turned(self, off):
        with np.errstate(invalid="ignore"):
            return np.where(self._angles, wrap(off / self._parts) * self._parts, off)

    def values(self, need: Need) -> Values | None:
        """Return what stands beside a place, None where its calls do not show it."""
        number, count = need.place.number, len(need.wanted)
        calls = [(row, ((number, values),)) for row, values in enumerate(need.wanted)]
        told = count * len(self._visits[0][number])
        visits = [*chain.from_iterable(reply.beside for reply in self._replies(calls, number))]
        size = need.wanted.size // told
        beside = known_values(visits, size) if len(visits) == told else {}
        if OLD not in beside:
            return None
        return Values(beside.pop(OLD), need.wanted.ravel(), beside, need.place.turns, size)


def batches(parts: list, size: int) -> Iterator[list]:
    """Yield the parts, so many at a time."""
    return (parts[start : start + size] for start in range(0, len(parts), size))
