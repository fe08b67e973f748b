"""The change in a student's own formulas that makes a wrong function right, or two of them: nothing
is told that was not tried.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from ..models.robots import Robot
from .following import Helped, builds_on, reached, spread, with_right_called
from .formulas import MATH, OLD, long_formulas, short_formulas
from .judge import call_text, numbers_of, numbers_right
from .labs import Lab
from .needed import AT_ONCE, Needs, batches
from .program import Program
from .questions import AskedRows, Questions, rows_from
from .ten_models import TEN, columns_of, motions
from .worker.student import Tried
from .worker.wire import Change

LIKELY, WAVES = 2, 3  # waves of likely changes, of all
MOST_SURE = 30  # changes right in a few rows that are asked all of them
FEW = 4  # rows that the others must have right first
MOST_KEPT = 8  # rows of a check of a right function that are asked again
MOST_FUNCTIONS = 8  # of a file that are looked at
MOST_CHANGES = 2  # that are told: with more of them, a formula is another one
MOST_COMPARED = 16  # formulas that make all right, of which one may help other functions, too
MOST_FIRST = 2  # changes that make more numbers right, to each of which a second one is sought
MOST_NEEDED = 8  # rows in which values are looked for that a function needs
MOST_FORMULAS = 2  # of a place
BY_CHANCE = 0.1  # of the numbers, that may be right by two mistakes
_NAME = re.compile(r"[A-Za-z_]\w*")
UNLIKELY = 10  # letters by which a formula counts longer in the place of a name
DOUBLED = 3  # by which a multiple of an angle does
OTHERS = 16  # rows for a robot of other lengths
HINTS = {
    "a sign": "Go through the signs of your formula: which terms add, and which subtract?",
    "a square": "Write the unit of each term beside it: all terms of a sum have the same.",
    "a root": "Write the unit of each term beside it: all terms of a sum have the same.",
    "a factor": "Write the unit of each term beside it, and ask where each factor comes from.",
    "an operator": "Write the unit of each term beside it: all terms of a sum have the same.",
    "a number": "Where does each number in your formula come from?",
    "a whole number": "What does an array of whole numbers do with a fraction that is put into it?",
    "a term": "Derive the formula once more on paper: how many terms does it have?",
    "a formula": "Derive this line once more on paper: which lengths and angles does it hold?",
    "a bracket": "In which order does Python compute your formula? Where do brackets belong?",
    "a variable": "Read each name in your formula: which leg, which bar, which derivative is it?",
    "an index": "Read each index in your formula: which row, which column, which leg is it?",
    "a function": "Draw the angle: which side of the triangle is the cosine, which the sine?",
    "the order": "In which order are these wanted?",
    "the order of lines": "Which values have your names when each line is reached?",
    "a transpose": "Write the shapes and the meaning of rows and columns beside each matrix.",
    "an inverse": "Solve the equation for what you look for: which matrix is on the other side?",
    "a matrix of ones": "Multiply a matrix of ones by a vector: is that the vector?",
    "a matrix product": "What does * do with two arrays, and what does @ do?",
    "a call": "What does each function that you call do with its argument?",
    "a comparison": "Go through your conditions: which case do they choose, and when?",
    "a direction": "Draw the vector: which way does it point, and which way should it?",
    "a conjugate": "Multiply two complex numbers on paper: is that their scalar product?",
    "an array in place": "Which other name means the same array, and changes with it?",
    "the indentation": "Which lines belong to the loop or to the condition, and which come after?",
    "a line unlike the other leg's": "Compare this line with that of the other leg.",
    "a line": "What does each line change? Is it needed?",
}


@dataclass(frozen=True)
class Mend:
    """Changes that make a function right, in words: the name without the place, and the place.

    helps: how many other wrong functions become right with them, too; after: those for another
    function that are made before.
    """

    changes: tuple[Change, ...]
    function: str
    made: Tried
    helps: int = 0
    after: Mend | None = None

    @property
    def name(self) -> str:
        count = "one thing" if len(self.changes) == 1 else "two things"
        return f"right but for {count}: {' and '.join(map(self._told, self.changes))}"

    def _told(self, change):
        inside = change.function
        return change.kind + ("" if inside == self.function else f", in your {inside}")

    @property
    def hint(self) -> str:
        return " ".join(dict.fromkeys(HINTS[change.kind] for change in self.changes))

    def spot(self, where: Callable[[int], str]) -> str:
        """Return where it is and what would be right; where: a line in its author's words."""
        told = [
            f"{where(change.line)}: {change.old}: right answers come with {change.new}"
            for change in self.changes
        ]
        first = sorted(set().union(*(mend.inside for mend in self.with_before[1:])))
        also = f", after the change in your {' and '.join(first)}" if first else ""
        return "; and ".join(told) + also

    @property
    def inside(self) -> set[str]:
        """The functions that are changed."""
        return {change.function for change in self.changes}

    @property
    def with_before(self) -> list[Mend]:
        """This one, and those before it, the last one first."""
        return [self, *(self.after.with_before if self.after else ())]

    @property
    def step(self) -> tuple:
        """All that is changed, as the first step for another function."""
        [numbers] = self.made.numbers
        last = tuple((self.made.wave, number) for number in numbers)
        return self.function, (*self.made.steps, *last)


@dataclass(frozen=True)
class Lead:
    """What is known of a wrong value if no formula is, in words that hold; name: "" where this is
    only where it stands.
    """

    name: str
    line: int
    told: str

    @property
    def hint(self) -> str:
        if self.name:
            return "A root and an arc have no sign of their own: what tells you which one is right?"
        return "Work this value out by hand for one call: what would be right?"

    def spot(self, where: Callable[[int], str]) -> str:
        """Return the line in its author's words, and what is known."""
        return f"{where(self.line)}: {self.told}"


def find_mend(
    program: Program,
    lab: Lab,
    function: str,
    asked: dict[str, list[AskedRows]],
    wrong: set[str],
    deep: bool,
    before: Sequence[Mend] = (),
) -> Mend | Lead | None:
    """Return the changes that make a function right, else the last wrong value, None where there
    is none of which all others follow.

    asked: what the checks asked of all functions: what is right stays right; wrong: the wrong
    functions of the lab, of which right ones stand in for those that are called; deep: whether
    unlikely changes, and two at once, are tried as well; before: what was found for other
    functions in helpers that this one may call, too, the last one first.
    """
    with with_right_called(program, lab, function, wrong) as other:
        search = _Search(other, lab, function, asked[function])
        begun = any(search.begin_after(mend, False) for mend in before)
        for name in asked.keys() - {function}:
            search.keep(name, asked[name])
        found = search.mend(deep)
        if found is None and before and not begun and search.begin_after(before[0], True):
            found = search.mend(deep)
        return search.lead() if found is None and deep else found


class _Search:
    """Search of changes for one function, in a process of its own."""

    def __init__(self, program: Program, lab: Lab, function: str, asked: list[AskedRows]):
        self.function, self.tried = function, Tried(function, tuple(lab.exercises()))
        self.student: Helped = program.student
        questions = Questions(program, lab, {}, np.random.default_rng(0))
        self.asked = [rows for each in asked for rows in _answerable(each, questions)]
        self.kept: list[tuple[str, AskedRows]] = []
        self.others: dict[str, list[AskedRows]] = {}
        self.before: Mend | None = None

    def begin_after(self, mend: Mend, unseen: bool) -> bool:
        """Look for what is left after changes of a helper, if they spoil nothing here and change
        an answer; unseen: also if they change none, as what is forgotten may need them.
        """
        plain = replace(self.tried, wave=None)
        after = replace(plain, steps=(mend.step,))
        for rows in self.asked:
            lost = self._right(rows, after, [[]]) < self._right(rows, plain, [[]])
            if lost.mean() > BY_CHANCE:
                return False
            came = self._came(rows, after), self._came(rows, plain)
            unseen |= not np.array_equal(*came, equal_nan=True)
        if unseen:
            self.before, self.tried = mend, replace(self.tried, steps=after.steps)
        return unseen

    def keep(self, name: str, asked: list[AskedRows]) -> None:
        """Let a right function stay right where it calls the one that is changed; a wrong one that
        calls the same helper may become right, also where it has its points in spite of the helper.
        """
        outline = self.student.outline
        wrong = not all((rows.good | rows.refuse).all() for rows in asked)
        if wrong and not reached(outline, name) & reached(outline, self.function):
            return
        for rows in asked:
            places = np.arange(len(rows.good))[:: max(1, len(rows.good) // MOST_KEPT)]
            answered = places[~rows.refuse[places]]
            if not len(answered):
                continue
            if wrong:
                self.others.setdefault(name, []).append(rows.part(answered))
            else:
                self.kept.append((name, rows.part(answered)))

    def mend(self, deep: bool) -> Mend | None:
        """Return the first change after which all rows are right, or the first two."""
        if self._wrong_rows(self.tried.steps) is None:
            return None
        better: list[tuple[int, tuple]] = []
        best = None
        for found in self._one_after_the_other(deep, better):
            if found and self._helps_all(found):
                return found
            # A formula that helps some may stand for a mistake in a helper that spoils more.
            if found and (best is None or found.helps > best.helps):
                best = found
        return best or (self._two(better) if deep else None)

    def _one_after_the_other(self, deep, better):
        """Yield what each kind of search finds, the fastest first; None where it finds nothing."""
        steps = self.tried.steps
        yield self._likely(steps, better)
        yield self._written(steps, deep=deep or bool(self.others))
        for wave in range(LIKELY, WAVES) if deep or self.others else ():
            yield self._single(replace(self.tried, wave=wave), better)

    def _helps_all(self, mend):
        """Return whether all other wrong functions that call the same helpers become right."""
        return mend.helps == len(self.others)

    def lead(self) -> Lead | None:
        """Return a formula that is right but for its sign in some calls, or else the last one that
        makes the function right with another value: one number for two or more of the answer.
        """
        found: list[tuple[Needs, dict]] = []
        for rows in dict.fromkeys((*self.asked[-1:], *self.asked[:1])):
            every = spread(len(rows.good), MOST_NEEDED)
            needs = Needs(self.student, replace(self.tried, steps=()), rows.part(every))
            if needs.wrong.any():
                found.append((needs, {need.place.number: need for need in needs.all()}))
        if not found:
            return None
        needs, known = found[-1]
        common = set.intersection(*(set(each) for _, each in found))
        signs, leads = {*common}, {*common}
        for own, each in found:
            signs = {k for k in signs if each[k].is_sign and each[k].place.is_root}
            leads = {k for k in leads if own.leads(each[k])}
        if signs:
            last = known[max(signs)]
            told = f"{last.place.text} has the right size in all calls, but in some the wrong sign"
            return Lead("the sign of a root or an angle is lost", last.place.line, told)
        if not leads:
            return None
        needed = [known[number] for number in leads]
        inside = [need for need in needed if need.place.function == self.function]
        last = max(inside or needed, key=lambda need: (need.place.line, len(need.place.text)))
        off = np.abs(last.wanted - last.old)
        row, number = np.unravel_index(np.argmax(off), off.shape)
        call = call_text(needs.rows.exercise, needs.rows.columns, int(row))
        old, wanted = last.old[row, number], last.wanted[row, number]
        told = (
            f"{last.place.text} is {old:.6g}, but {wanted:.6g} is needed, in {call}; what is"
            " computed from it is right"
        )
        return Lead("", last.place.line, told)

    def _likely(self, steps, better):
        """Return a likely change after these steps, best one that helps other functions too."""
        found = None
        for wave in range(LIKELY):
            now = self._single(replace(self.tried, steps=steps, wave=wave), better)
            if now and self._helps_all(now):
                return now
            found = found or now
        return found

    def _two(self, better):
        """Return the first two changes: one that makes more numbers right, and another one."""
        better.sort(key=lambda one: -one[0])
        firsts = [step for _, step in better[:MOST_FIRST]]
        before = self.tried.steps
        for step in firsts:
            steps = *before, step
            if self._wrong_rows(steps) and (found := self._written(steps, deep=False)):
                return found
        for step in firsts:
            if found := self._likely((*before, step), []):
                return found
        return None

    def _single(self, tried, better):
        """Return the first change of a wave that makes all right; better: those that make more
        numbers right and none wrong are added.
        """
        if (few := self._wrong_rows(tried.steps)) is None:
            return None
        before = self._right(few, tried, [[]])[0]
        every = [[k] for k in range(self.student.changes_count)]
        right = self._right(few.part([0]), tried, every)[:, 0]
        more = (right >= before[0]).all(axis=1) & (right > before[0]).any(axis=1)
        candidates = [[k] for k in np.flatnonzero(more).tolist()]
        now = self._right(few, tried, candidates)
        whole = [k for k, good in zip(candidates, now) if good.all()]
        sure = []
        for numbers in whole[:MOST_SURE]:
            if found := self._sure(tried, numbers):
                sure.append(found)
                if not self.others:
                    break
        if sure:
            return max(sure, key=lambda mend: mend.helps)
        for numbers, good in zip(candidates, now):
            if (good >= before).all():
                better.append((int(good.sum()), (tried.wave, numbers[0])))
        return None

    def _written(self, steps, deep):
        """Return the formulas, written where other values are needed, that make all right; deep:
        whether long ones are looked for.
        """
        needs, known = self._needs(steps)
        found = [*needs.named(), *_found(known, short_formulas)]
        mend = self._surest(found, needs, steps)
        if mend or not deep:
            return mend
        found += _found(known, long_formulas)
        return self._surest(found, needs, steps)

    def _surest(self, found, needs, steps):
        """Return the mend of the shortest of these formulas that makes all right; first of all one
        in a helper with which other functions become right, too.
        """
        different = {(place.number, *written): (place, *written) for place, *written in found}
        found = sorted(different.values(), key=_size)
        helpers = [one for one in found if one[0].function != self.function]
        mends = self._sure_ones(helpers, needs, steps) if self.others else ()
        few = islice(mends, MOST_COMPARED)
        best = max(few, key=lambda mend: (mend.helps, -len(mend.changes)), default=None)
        if best and best.helps:
            return best
        return next(self._sure_ones(found, needs, steps), None)

    def _sure_ones(self, found, needs, steps):
        left = MOST_CHANGES - len(steps) + len(self.tried.steps)
        for written in _together(found, needs.wrong, left):
            tried = replace(self.tried, wave=None, steps=(*steps, written))
            if mend := self._sure(tried, []):
                yield mend

    def _needs(self, steps):
        """Return what is needed after these steps, and places with what stands beside them."""
        rows = self._wrong_rows(steps, reversed(self.asked), MOST_NEEDED)
        needs = Needs(self.student, replace(self.tried, steps=steps), rows)
        known = [(need.place, needs.values(need)) for need in needs.all()]
        known = [pair for pair in known if pair[1] is not None]
        return needs, [*known, *needs.in_part()]

    def _sure(self, tried, numbers):
        """Return the mend of these changes if all rows are right with them, and those of right
        functions stay so.
        """
        if not all(self._right(rows, tried, [numbers]).all() for rows in self.asked):
            return None
        self._right(self.asked[0].part([0]), tried, [numbers])
        changes = self.student.changes
        inside = {change.function for change in changes}
        outline = self.student.outline
        kept = [rows for name, rows in self.kept if builds_on(outline, name, inside)]
        if not all(self._right(rows, tried, [numbers]).all() for rows in kept):
            return None
        helps = 0
        for asked in self.others.values() if inside - {self.function} else ():
            helps += all(self._right(rows, tried, [numbers]).all() for rows in asked)
        made = replace(tried, numbers=[numbers])
        return Mend(tuple(changes), self.function, made, helps, self.before)

    def _wrong_rows(self, steps, asked=None, most=FEW):
        """Return a few rows that have wrong answers after these steps, None where none has."""
        tried = replace(self.tried, steps=steps, wave=None)
        for rows in asked or self.asked:
            places = np.flatnonzero(~self._right(rows, tried, [[]])[0].all(axis=1))
            if len(places):
                return rows.part(places[spread(len(places), most)])
        return None

    def _came(self, rows, tried):
        plain = rows_from(rows.columns)
        asked = replace(tried, numbers=[[] for _ in plain])
        replies = self.student.ask(rows.exercise.name, plain, rows.constants, tried=asked)
        return numbers_of(rows.exercise, replies)

    def _right(self, rows: AskedRows, tried: Tried, changes: list[list[int]]) -> np.ndarray:
        """Return which numbers are right with each of these changes: (changes, rows, numbers)."""
        plain, right = rows_from(rows.columns), []
        for some in batches(changes, max(1, AT_ONCE // len(plain))):
            numbers = [each for each in some for _ in plain]
            asked = replace(tried, numbers=numbers)
            replies = self.student.ask(
                rows.exercise.name, plain * len(some), rows.constants, tried=asked
            )
            good = numbers_right(rows.exercise, rows.robot, rows.columns, replies, rows.tolerance)
            right.append(good.reshape(len(some), len(plain), -1))
        count = len(rows.exercise.is_angle())
        return np.concatenate(right) if right else np.ones((0, len(plain), count), bool)


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
    long += 2 * place.is_argument
    # With bars of one length an angle may well be twice another one, but nobody forgets that.
    if place.turns and kind == "a factor":
        long += DOUBLED
    used = set(_NAME.findall(text))
    if used & set(place.unread):
        long -= UNLIKELY  # what was computed is to be used
    return long, -place.moved.sum(), len(place.text)


def _together(found, wrong, most):
    """Yield formulas to be written together so that all numbers that are wrong are covered; most:
    of them, 1 or 2.
    """
    for count, (place, *one) in enumerate(found[:MOST_SURE]):
        left, first = wrong & ~place.moved, (place.number, *one)
        if not left.any():
            yield (first,)
            continue
        for other, *more in found[count + 1 :] if most > 1 else ():
            apart = not (other.moved & place.moved & wrong).any()
            if apart and other.moved[left].all():
                yield first, (other.number, *more)
                break


def _answerable(rows, questions):
    """Yield the rows that have an answer, and the same for other masses and lengths where the file
    lets them be set.
    """
    asked = [rows]
    if not rows.constants:
        for longer in (False, True):
            robot, constants = questions.with_others(longer)
            moved = moving(rows, robot) if longer else rows
            asked.append(replace(moved, robot=robot, constants=constants))
    for each in asked:
        with np.errstate(all="ignore"):
            right = each.exercise.outcome(each.exercise.answer, each.robot, each.columns)
        places = np.flatnonzero(np.isfinite(right).all(axis=1) & ~each.refuse)
        if len(places):
            yield each.part(places)


def moving(rows: AskedRows, robot: Robot) -> AskedRows:
    """Return rows for one of the lab's ten functions with motions that another robot can make: on
    angles and rates that do not belong together, right formulas differ.
    """
    if rows.exercise.name not in TEN:
        return rows
    columns = columns_of(rows.exercise.name, motions(robot, np.random.default_rng(0), OTHERS))
    tolerance, none = np.full(OTHERS, rows.tolerance.max()), np.zeros(OTHERS, bool)
    return replace(rows, columns=columns, tolerance=tolerance, refuse=none, good=none)
