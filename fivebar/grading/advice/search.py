"""The change in a student's own formulas that makes a wrong function right, or two of them: nothing
is told that was not tried.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import chain, islice

import numpy as np

from ...models.robots import Robot
from ..intake.program import Program
from ..judging.diagnosis import difference
from ..judging.judge import limits_of, numbers_of
from ..judging.questions import AskedRows, rows_from
from ..judging.with_right_ones import (
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
from ..robots import has_models
from ..ten_models import TEN, columns_of, motions
from ..worker.student import Tried
from ..worker.wire import Change
from .formulas import MATH, OLD, long_formulas, short_formulas
from .names import named
from .needed_values import AT_ONCE, Needs, batches

SLOW, TIMED = 5e-3, 8  # s, of a call of which only likely changes are tried; calls timed
AT_A_TIME, LEAST_AT_ONCE = 5.0, 16  # s of calls that are asked together, and changes
WAVES = 2  # of changes
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
        return self.made.made or (self.made.wave, *self.made.numbers[0])


def find_mend(
    program: Program,
    lab: Lab,
    function: str,
    asked: dict[str, list[AskedRows]],
    wrong: set[str],
    deep: bool,
    budget: Budget,
) -> Mend | None:
    """Return the changes that make a function right, None where none are found.

    asked: what the checks asked of all functions: what is right stays right; wrong: the wrong
    functions of the lab, of which right ones stand in for those that are called; deep: whether
    long formulas are tried as well; budget: of all that is tried, after which what was found
    until then is returned.
    """
    with with_right_called(program, lab, function, wrong) as other:
        search = _Search(other, lab, function, asked[function])
        search.student.budget = budget
        with suppress(BudgetSpentError):
            for name in asked.keys() - {function}:
                search.keep(name, asked[name])
            search.look(deep)
        search.student.budget = None
        return search.best and search.named(search.best)


class _Search:
    """Search of changes for one function, in a process of its own."""

    def __init__(self, program: Program, lab: Lab, function: str, asked: list[AskedRows]):
        self.function, self.tried = function, Tried(function, tuple(lab.exercises()))
        self.student: Helped = program.student
        self.asked = []
        for each in asked:
            self.asked += [rows for rows in _answerable(each, program, lab) if len(rows.good)]
        # Where no answer exists, a change that makes all right gives none either: also where an
        # answer is given and nothing else is wrong.
        wrong = any(len(rows.wrong) for rows in asked)
        refused = [rows.part(rows.refuse & (rows.good | (not wrong))) for rows in asked]
        self.asked += [rows for rows in refused if len(rows.good)]
        self.kept: list[tuple[str, AskedRows]] = []
        self.others: dict[str, list[AskedRows]] = {}
        self.best: Mend | None = None  # of the changes that make all right

    def keep(self, name: str, asked: list[AskedRows]) -> None:
        """Let a right function stay right where it calls the one that is changed; a wrong one that
        calls the same helper may become right, also where it has its points in spite of the helper.
        """
        outline, parts = self.student.outline, []
        for rows in asked:
            places = np.arange(len(rows.good))[:: max(1, len(rows.good) // MOST_KEPT)]
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
        if self._wrong_rows(self.asked) is None:
            return
        for wave in range(WAVES):
            if not self._is_found():
                self._single(replace(self.tried, wave=wave))
        # A formula that helps some may stand for a mistake in a helper that spoils more.
        # Of slow calls, thousands take too long: as many as values are looked for with.
        if self._is_found() or self._fastest(self._wrong_rows(self.asked))[1] > SLOW:
            return
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
        few = self._wrong_rows(self.asked)
        fastest, seconds = self._fastest(few)
        before = self._right(few, tried, [[]])[0]
        every = [[k] for k in range(self.student.count)]
        count = 0
        for some in batches(every, max(LEAST_AT_ONCE, int(AT_A_TIME / seconds))):
            right = self._right(few.part([fastest]), tried, some)[:, 0]
            more = right >= before[fastest]
            more = more.all(axis=1) & (right > before[fastest]).any(axis=1)
            candidates = [some[k] for k in np.flatnonzero(more)]
            now = self._right(few, tried, candidates)
            for numbers, good in zip(candidates, now):
                if good.all() and count < MOST_SURE and (mend := self._sure(tried, numbers)):
                    count += 1
                    self._take(mend)
                    if not self.others:
                        return

    def _fastest(self, rows):
        """Return the row of the fastest call of the function as it is, and its seconds."""
        # Of processor time, as a busy machine makes no function slow.
        start = time.process_time()
        replies = self._replies(rows, self.tried, [[]] * TIMED)
        own = (time.process_time() - start) / len(replies)
        seconds = np.reshape([reply.seconds for reply in replies], (TIMED, -1)).mean(axis=0)
        row = int(np.argmin(seconds))
        return row, seconds[row] + own

    def _written(self, deep):
        """Look for formulas, written where other values are needed, that make all right; deep:
        whether long ones are looked for.
        """
        needs, known = self._needs()
        found = _found(known, short_formulas)
        if not self._surest(found, needs) and deep:
            self._surest(found + _found(known, long_formulas), needs)

    def _surest(self, found, needs):
        """Return whether one of these formulas makes all right: the shortest is the best one, and
        first of all one in a helper with which other functions become right, too.
        """
        different = {(place.number, *written): (place, *written) for place, *written in found}
        found = sorted(different.values(), key=_size)
        helpers = [one for one in found if one[0].function != self.function]
        mends = self._sure_ones(helpers, needs) if self.others else ()
        helpful = [mend for mend in islice(mends, MOST_COMPARED) if mend.helps]
        good = helpful or [*islice(self._sure_ones(found, needs), 1)]
        for mend in good:
            self._take(mend)
        return bool(good)

    def _sure_ones(self, found, needs):
        for written in _together(found, needs.wrong):
            tried = replace(self.tried, made=written)
            if mend := self._sure(tried, []):
                yield mend

    def _needs(self):
        """Return what is needed, and the places that need it with what stands beside them."""
        rows = self._wrong_rows(self.asked[::-1], MOST_NEEDED)
        needs = Needs(self.student, self.tried, rows)
        known = [(need.place, needs.values(need)) for need in needs.all()]
        return needs, [pair for pair in known if pair[1] is not None]

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

    def _wrong_rows(self, asked, most=FEW):
        """Return a few of these rows that have wrong answers, None where none has."""
        for rows in asked:
            places = np.flatnonzero(~self._right(rows, self.tried, [[]])[0].all(axis=1))
            if len(places):
                return rows.part(places[spread(len(places), most)])
        return None

    def _right(self, rows: AskedRows, tried: Tried, changes: list[list[int]]) -> np.ndarray:
        """Return which numbers are right, or none where there is no answer, with each of these
        changes: (changes, rows, numbers).
        """
        exercise, count = rows.exercise, len(rows.good)
        some = batches(changes, max(1, AT_ONCE // count))
        replies = [*chain(*(self._replies(rows, tried, each) for each in some))]
        came = numbers_of(exercise, replies).reshape(len(changes), count, len(exercise.turns))
        expected = exercise.outcome(exercise.answer, rows.robot, rows.columns)
        limits = limits_of(exercise, expected, rows.tolerance)
        right = difference(came, expected, exercise.turns) <= limits
        none = ~np.isfinite(came).all(axis=2, keepdims=True)
        return np.where(rows.refuse[:, None], none, right)

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
            factor = (1.3 + 0.1 * len(own)) * (2 if first[0] == "l" else 1)
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
        with np.errstate(all="ignore"):
            right = each.exercise.outcome(each.exercise.answer, each.robot, each.columns)
        places = np.flatnonzero(np.isfinite(right).all(axis=1) & ~each.refuse)
        yield each.part(places)


def moving(rows: AskedRows, robot: Robot) -> AskedRows:
    """Return rows for one of the lab's ten functions with motions that another robot can make: on
    angles and rates that do not belong together, right formulas differ.
    """
    columns = columns_of(rows.exercise.name, motions(robot, np.random.default_rng(0), OTHERS))
    tolerance, none = np.full(OTHERS, rows.tolerance.max()), np.zeros(OTHERS, bool)
    return replace(rows, columns=columns, tolerance=tolerance, refuse=none, good=none)
