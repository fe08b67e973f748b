"""The change in a student's own formulas that makes a wrong function right, or two of them: nothing
is told that was not tried.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import chain, combinations, compress, islice

import numpy as np

from ...models.robots import Robot
from ..columns import largest
from ..intake.program import Program
from ..judging.diagnosis import difference
from ..judging.judge import limits_of, numbers_of
from ..judging.questions import AskedRows, rows_from
from ..judging.with_right_ones import (
    A_CALL,
    Budget,
    BudgetSpentError,
    Helped,
    builds_on,
    reached,
    spread,
    with_right_called,
)
from ..labs import Lab
from ..models import MODELS
from ..robots import has_models, parameters_of
from ..ten_models import TEN, columns_of, motions
from ..worker.student import Tried
from ..worker.wire import Change
from .formulas import MATH, OLD, long_formulas, short_formulas
from .names import named
from .needed_values import AT_ONCE, Needs, batches

SLOW = 5e-3  # s, of a watched call: of slower ones only changes are tried
AT_A_TIME, LEAST_AT_ONCE = 5.0, 16  # s of calls that are asked together, and changes
WAVES = 2  # of changes
TOGETHER = 2  # number of the wave that holds all changes
PAIRED = 2  # rows in which two changes are looked for
MOST_LIKELY = 250  # changes of which any two are tried
ALIKE, DIGITS = 1e-7, 6  # of the largest right answer, in which two answers are the same
MOST_SURE = 30  # changes right in a few rows that are asked all of them
FEW = 4  # rows that the others must have right first
MOST_KEPT = 8  # rows of a check of a right function that are asked again
MOST_FUNCTIONS = 8  # of a file that are looked at
MOST_COMPARED = 16  # formulas that make all right, of which one may help other functions, too
MOST_NEEDED = 8  # rows in which values are looked for that a function needs
MOST_FORMULAS = 2  # of a place
_NAME = re.compile(r"[A-Za-z_]\w*")
PLAIN_NUMBERS = {"math", "np", "numpy", "pi"}
UNLIKELY = 10  # letters by which a formula counts longer in the place of a name
DOUBLED = 3  # by which a multiple of an angle does
OTHERS = 16  # rows for a robot of other lengths


@dataclass(frozen=True)
class Mend:
    """Changes that make a function right, in words: the name without the place, and the place.

    helps: how many other wrong functions become right with them, too.
    """

    changes: tuple[Change, ...]
    function: str
    made: Tried
    helps: int = 0
    names: tuple[tuple[str, str], ...] = ()  # name and hint of each change

    @property
    def name(self) -> str:
        told = []
        for (name, _), change in zip(self.names, self.changes):
            inside = change.function
            told.append(name + ("" if inside == self.function else f", in your {inside}"))
        return "; and ".join(told)

    @property
    def hint(self) -> str:
        return " ".join(dict.fromkeys(hint for _, hint in self.names))

    def spot(self, where: Callable[[int], str]) -> str:
        """Return where it is and what would be right; where: a line in its author's words."""
        return "; and ".join(
            f"{where(change.line)}: {change.old}: right answers come with {change.new}"
            for change in self.changes
        )

    @property
    def worth(self) -> tuple[int, int]:
        """What makes one better than another: more functions are right with fewer changes."""
        return self.helps, -len(self.changes)

    @property
    def inside(self) -> set[str]:
        """The functions that are changed."""
        return {change.function for change in self.changes}

    @property
    def change(self) -> tuple:
        """All that is changed, as what is made before something else is asked."""
        function, made = self.made.function, self.made.made
        wave = self.made.wave
        return made if wave is None else (*made, (function, wave, self.made.numbers[0]))


def find_mend(
    program: Program,
    lab: Lab,
    function: str,
    asked: dict[str, list[AskedRows]],
    wrong: set[str],
    deep: bool,
    budget: Budget,
    made: tuple = (),
) -> Mend | None:
    """Return the changes that make a function right, None where none are found.

    asked: what the checks asked of all functions: what is right stays right; wrong: the wrong
    functions of the lab, of which right ones stand in for those that are called; deep: whether
    long formulas are tried as well; budget: of all that is tried, after which what was found
    until then is returned; made: changes made before.
    """
    with with_right_called(program, lab, function, wrong) as other:
        search = _Search(other, lab, function, asked[function], made)
        search.student.budget = budget
        with suppress(BudgetSpentError):
            for name in asked.keys() - {function}:
                search.keep(name, asked[name])
            search.look(deep)
        search.student.budget = None
        return search.best and search.named(search.best)


class _Search:
    """Search of changes for one function, in a process of its own."""

    def __init__(
        self, program: Program, lab: Lab, function: str, asked: list[AskedRows], made: tuple
    ):
        self.function, self.tried = function, Tried(function, tuple(lab.exercises()), made=made)
        self.student: Helped = program.student
        self.asked = []
        for each in asked:
            self.asked += [rows for rows in _answerable(each, program, lab) if len(rows.good)]
        # Where no answer exists, a change that makes all right gives none either: also where an
        # answer is given and nothing else is wrong.
        wrong = any(len(rows.wrong) for rows in asked)
        refused = [rows.part(rows.refuse & (rows.good | (not wrong))) for rows in asked]
        self.asked += [rows for rows in refused if len(rows.good)]
        # First of robots of which no two lengths or masses are equal.
        self.asked.sort(key=lambda rows: -len({*parameters_of(rows.robot).values()}))
        self.kept: list[tuple[str, AskedRows]] = []
        self.others: dict[str, list[AskedRows]] = {}
        self.best: Mend | None = None  # of the changes that make all right

    def keep(self, name: str, asked: list[AskedRows]) -> None:
        """Let a right function stay right where it calls the one that is changed; a wrong one that
        calls the same helper may become right, also where it has its points in spite of the helper.
        """
        outline, parts = self.student.outline, []
        for rows in asked:
            places = spread(len(rows.good), MOST_KEPT)
            answered = places[~rows.refuse[places]]
            parts += [rows.part(answered)] if len(answered) else []
        if all((rows.good | rows.refuse).all() for rows in asked):
            self.kept += [(name, rows) for rows in parts]
        elif reached(outline, name) & reached(outline, self.function):
            self.others[name] = parts

    def look(self, deep: bool) -> None:
        """Look for the first change after which all rows are right, and as many other functions as
        can be: it is the best one.
        """
        if self._wrong_rows() is None:
            return
        for wave in range(WAVES):
            if not self._is_found():
                self._single(replace(self.tried, wave=wave))
        # A formula that helps some may stand for a mistake in a helper that spoils more.
        if not self._is_found():
            self._written(deep=deep or bool(self.others))

    def _is_found(self):
        """Return whether all other wrong functions that call the same helpers become right with
        the best change, too.
        """
        return self.best is not None and self.best.helps == len(self.others)

    def named(self, mend: Mend) -> Mend:
        """Return the mend with what its changes are called."""
        rows = max(self.asked, key=lambda rows: (not rows.constants, len(rows.wrong)))
        rows = rows.part(rows.wrong) if len(rows.wrong) else rows
        names = named(self.student, self.tried, mend.change, mend.changes, rows)
        return replace(mend, names=names)

    def _single(self, tried):
        """Look for changes of a wave that make all right."""
        rows = self._wrong_rows()
        seconds = [reply.seconds for reply in self._replies(rows, tried, [[]])]
        row = rows.part([np.argmin(seconds)])
        size = max(LEAST_AT_ONCE, int(AT_A_TIME / (min(seconds) + A_CALL)))
        for some in batches([[k] for k in range(self.student.count)], size):
            right = self._right(row, tried, some).all(axis=(1, 2))
            for numbers in compress(some, right):
                if mend := self._sure(tried, numbers):
                    self._take(mend)
                    if self._is_found():
                        return

    def _written(self, deep):
        """Look for formulas, written where other values are needed, that make all right; deep:
        whether long ones are looked for.
        """
        needs = Needs(self.student, self.tried, self._wrong_rows(MOST_NEEDED))
        # Of slow calls, thousands take too long: as many as values are looked for with.
        if needs.seconds > SLOW:
            return
        known = [(need.place, needs.values(need)) for need in needs.all()]
        known = [pair for pair in known if pair[1] is not None]
        found = _found(known, short_formulas)
        if not self._surest(found, needs) and deep and not self._paired():
            # Where a name gets its value, the same is said better than where it is used.
            known = [pair for pair in known if not pair[0].text.isidentifier()]
            self._surest(found + _found(known, long_formulas), needs)

    def _paired(self):
        """Return whether there are changes, one or two, that make all right: of the likeliest, the
        best ones.
        """
        tried = replace(self.tried, wave=TOGETHER)
        for pair in islice(self._pairs(tried, self._wrong_rows(PAIRED)), MOST_SURE):
            if mend := self._sure(tried, pair):
                self._take(mend)
                if self._is_found():
                    break
        return self.best is not None

    def _pairs(self, tried, rows):
        """Yield changes, one or two, that make these rows right: first pairs of which each brings
        its own part of what is missing, then any two of the likely ones.
        """
        expected, scale = rows.expected, largest(rows.expected)
        limit, turns = ALIKE * scale, rows.exercise.turns
        before = self._came(rows, tried, [[]])
        came = self._came(rows, tried, [[k] for k in range(self.student.count)])
        came[np.isinf(came)] = np.nan
        brought = came - before
        good = np.sum(difference(came, expected, turns) <= limit, axis=(1, 2))
        yield from np.argwhere(good == expected.size).tolist()
        moving = np.flatnonzero((np.abs(brought) > limit).any(axis=(1, 2)))
        for place, one in enumerate(moving):
            others = moving[place + 1 :]
            off = difference(came[one] + brought[others], expected, turns)
            for other in others[(off <= limit).all(axis=(1, 2))]:
                yield [int(one), int(other)]
        _, different = np.unique(np.round(came[moving] / scale, DIGITS), axis=0, return_index=True)
        likely = sorted(moving[different].tolist(), key=lambda k: (-good[k], k))
        pairs = [[*pair] for pair in combinations(likely[:MOST_LIKELY], 2)]
        right = self._right(rows.part([0]), tried, pairs).all(axis=(1, 2))
        yield from compress(pairs, right)

    def _surest(self, found, needs):
        """Return whether there is a change or one of these formulas that makes all right: of the
        short ones, the best one.
        """
        different = {(place.number, *written): (place, *written) for place, *written in found}
        every = _together(sorted(different.values(), key=_size), needs.wrong)
        steps = ((*self.tried.made, (self.function, None, written)) for written in every)
        mends = (self._sure(replace(self.tried, made=step), []) for step in steps)
        for mend in islice(filter(None, mends), MOST_COMPARED if self.others else 1):
            self._take(mend)
        return self.best is not None

    def _sure(self, tried, numbers):
        """Return the mend of these changes if all rows are right with them, and those of right
        functions stay so.
        """
        if not all(self._right(rows, tried, [numbers]).all() for rows in self.asked):
            return None
        changes = self.student.changes
        inside = {change.function for change in changes}
        outline = self.student.outline
        kept = [rows for name, rows in self.kept if builds_on(outline, name, inside)]
        if not all(self._right(rows, tried, [numbers]).all() for rows in kept):
            return None
        helps = 0
        for name, asked in self.others.items():
            if builds_on(outline, name, inside):
                helps += all(self._right(rows, tried, [numbers]).all() for rows in asked)
        made = replace(tried, numbers=[numbers])
        return Mend(tuple(changes), self.function, made, helps)

    def _take(self, mend):
        """Let a mend be the best one, if it is better than what was found before."""
        if self.best is None or mend.worth > self.best.worth:
            self.best = mend

    def _wrong_rows(self, most=FEW):
        """Return a few of the rows that have wrong answers, None where none has: if possible,
        numbers.
        """
        for rows in self.asked:
            wrong = ~self._right(rows, self.tried, [[]])[0].all(axis=1)
            answered = np.isfinite(self._came(rows, self.tried, [[]])[0]).all(axis=1)
            places = np.flatnonzero(wrong & answered if any(wrong & answered) else wrong)
            if len(places):
                return rows.part(places[spread(len(places), most)])
        return None

    def _right(self, rows: AskedRows, tried: Tried, changes: list[list[int]]) -> np.ndarray:
        """Return which numbers are right, or none where there is no answer, with each of these
        changes: (changes, rows, numbers).
        """
        exercise, came = rows.exercise, self._came(rows, tried, changes)
        limits = limits_of(exercise, rows.expected, rows.tolerance)
        right = difference(came, rows.expected, exercise.turns) <= limits
        none = ~np.isfinite(came).all(axis=2, keepdims=True)
        return np.where(rows.refuse[:, None], none, right)

    def _came(self, rows, tried, changes):
        """Return the answers (changes, rows, numbers) with each of these changes."""
        count = len(rows.good)
        some = batches(changes, max(1, AT_ONCE // count))
        replies = [*chain(*(self._replies(rows, tried, each) for each in some))]
        came = numbers_of(rows.exercise, replies)
        return came.reshape(len(changes), count, came.shape[1])

    def _replies(self, rows, tried, changes):
        """Return the replies to all rows with each of these changes."""
        plain = rows_from(rows.columns)
        asked = tried and replace(tried, numbers=[each for each in changes for _ in plain])
        name, every = rows.exercise.name, plain * len(changes)
        return self.student.ask(name, every, rows.constants, tried=asked)


def _found(known, formulas):
    """Return (place, kind, formula) of what may be written."""
    return [
        (place, kind, text)
        for place, values in known
        for kind, text in islice(formulas(values), MOST_FORMULAS)
    ]


def _size(found):
    """Return by what short formulas, and those that make more numbers right, come first."""
    place, kind, text = found
    long = len(text.replace(MATH, "").replace(OLD, "x")) + (kind == "a formula")
    # What a name is worth is better said where it gets its value, and an argument in the call.
    if place.text.isidentifier():
        long += UNLIKELY if kind in ("a formula", "a number") else kind != "a variable"
    # Nobody forgets a term that is divided by something.
    long += UNLIKELY * (kind == "a term" and re.search(r"/[A-Za-z_]", text) is not None)
    # Nobody forgets a term of pi, or a factor of 2.
    if not set(_NAME.findall(place.text)) - PLAIN_NUMBERS:
        long += UNLIKELY * (kind != "a number")
    long += 2 * place.is_argument
    # With bars of one length an angle may well be twice another one, but nobody forgets that.
    if place.turns and kind == "a factor":
        long += DOUBLED
    used = set(_NAME.findall(text))
    if used & set(place.unread):
        long -= UNLIKELY  # what was computed is to be used
    return long, -place.moved.sum(), len(place.text)


def _together(found, wrong):
    """Yield formulas to be written, one or two in places apart, so that all numbers that are wrong
    are covered.
    """
    for count, (place, *one) in enumerate(found[:MOST_SURE]):
        left, first = wrong & ~place.moved, (place.number, *one)
        if not left.any():
            yield (first,)
            continue
        for other, *more in found[count + 1 :]:
            apart = not (other.moved & place.moved & wrong).any()
            if apart and other.moved[left].all():
                yield first, (other.number, *more)
                break


def _with_others(robot, program, lab, longer):
    """Return the robot with other masses and inertias, or longer bars and its bases farther apart
    as well, and the file's constants for it: those that it gives a number.
    """
    constants, own = lab.constants() or {key: (key,) for key in robot.parameters}, {}
    names = [key for key in constants if key in program.student.constants]
    # Between bases farther apart, short bars do not meet.
    longer = longer and any(constants[name][0][0] == "l" for name in names)
    for name in names:
        first = constants[name][0]
        if longer or first[0] not in "ld":
            # A value of few digits would pass for a number that somebody has typed.
            factor = (1.37 + 0.11 * len(own)) * (2 if first[0] == "l" else 1)
            own[name] = factor * getattr(robot, first)
    changed = {key: value for name, value in own.items() for key in constants[name]}
    return replace(robot, **changed), own


def _answerable(rows, program, lab):
    """Yield the rows that have an answer, and the same for other masses and lengths where the file
    lets them be set.
    """
    asked, name = [rows], rows.exercise.name
    # With longer bars, right files stop on a way that leaves the reach of a leg.
    moves = name in TEN and rows.exercise.arguments == tuple(MODELS[name][1])
    if not rows.constants and has_models(rows.robot):
        for longer in {False, moves}:
            robot, constants = _with_others(rows.robot, program, lab, longer)
            moved = moving(rows, robot) if longer else rows
            asked.append(replace(moved, robot=robot, constants=constants))
    for each in asked:
        places = np.flatnonzero(np.isfinite(each.expected).all(axis=1) & ~each.refuse)
        yield each.part(places)


def moving(rows: AskedRows, robot: Robot) -> AskedRows:
    """Return rows for one of the lab's ten functions with motions that another robot can make: on
    angles and rates that do not belong together, right formulas differ.
    """
    columns = columns_of(rows.exercise.name, motions(robot, np.random.default_rng(0), OTHERS))
    tolerance, none = np.full(OTHERS, rows.tolerance.max()), np.zeros(OTHERS, bool)
    return replace(rows, columns=columns, tolerance=tolerance, refuse=none, good=none)
