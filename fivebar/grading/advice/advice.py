"""What is told of a program's wrong functions when its checks are done: a change with which each of
them is right.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ..judging.questions import AskedRows
from ..judging.results import Check, checked
from ..judging.with_right_ones import Budget, builds_on, reached
from ..labs import Lab
from ..report.text import not_started
from .search import MOST_FUNCTIONS, Mend, find_mend

if TYPE_CHECKING:
    from ..plugin import Checks

MOST_SECONDS = 20.0  # of processor time, of the changes that are tried in a file
SHARE, LEAST = 0.6, 0.15  # of what is left, for one function, and for one that has a name
BY_LEGS = "ikm", "ikm2"  # a slip of one leg spoils one number of theirs alone: they come first
MENDED = "value nan exception shape type accepted".split()


def is_named(check: Check) -> bool:
    """Return whether it is known what is wrong, not only in which function."""
    name = check.misconception
    return bool(name) and not name.startswith("consistent with your")


def may_be_mended(check: Check) -> bool:
    """Return whether a check got wrong answers from a function that is written to its end."""
    ended = check.share > 0 or "is a return missing" not in check.text
    return check.reason in MENDED and not not_started(check) and ended


class Advice:
    """What is found out about the wrong functions of one program, and told in its checks."""

    def __init__(self, checks: Checks, lab: Lab):
        self._checks, self._lab, self._program = checks, lab, checks.program
        self._asked: dict[str, list[AskedRows]] = {}
        for ask in checks.asks:
            for rows in ask.rows_asked:
                self._asked.setdefault(rows.exercise.name, []).append(rows)
        self._seconds = MOST_SECONDS
        self._mends: dict[str, Mend] = {}  # of the functions that pay
        self._cut: list[str] = []  # functions of which not all was tried

    def tell(self) -> None:
        """Tell where one change makes a function right; what else builds on the function that is
        changed is judged with the change.
        """
        names = {check.function: None for check in self._checks.found if may_be_mended(check)}
        written = [name for name in names if name in self._asked]
        written.sort(key=lambda name: name not in BY_LEGS)
        for function in written[:MOST_FUNCTIONS]:
            mistakes = self._mistakes(function)
            # One that builds on a function changed before may be right by now.
            if not mistakes:
                continue
            # It is still to be written, or answers by chance.
            if not all(mistake and mistake.idle for mistake in mistakes):
                self._search(function, mistakes)
        if self._cut:
            names = " and ".join(dict.fromkeys(self._cut))
            self._checks.notes.append(
                f"What is wrong in {names} was not searched to the end: a file has"
                f" {MOST_SECONDS:g} s of computing for that."
            )

    def _places(self, function):
        """Return the numbers of a function's checks that are not all right."""
        found = enumerate(self._checks.found)
        return [k for k, check in found if check.function == function and check.share < 1]

    def _mistakes(self, function):
        """Return what is known of a function's wrong checks, None for each of which nothing is."""
        places = self._places(function)
        if not any(may_be_mended(self._checks.found[k]) for k in places):
            return []
        known = self._checks.verdicts
        return [known[k].diagnosis if k in known else None for k in places]

    def _search(self, function, mistakes):
        """Look for what makes a function right, tell it, and judge others with it."""
        named = all(mistake and mistake.model for mistake in mistakes)
        budget = Budget((LEAST if named else SHARE) * self._seconds)
        self._seconds -= budget.left
        wrong = {check.function for check in self._checks.found if check.share < 1}
        outline, asked, made = self._program.student.outline, self._asked, ()
        for mend in self._mends.values():
            made = mend.change if builds_on(outline, function, mend.inside) else made
        best = find_mend(self._program, self._lab, function, asked, wrong, not named, budget, made)
        self._seconds += max(budget.left, 0)
        if best:
            self._mends[function] = best
            # With an earlier slip mended, too, all who pay would be right.
            self._judge_with(best, self._mends.keys() if made else {function})
            self._tell(best, function)
        elif named:
            self._forgive(function, {mistake.name for mistake in mistakes})
        elif budget.left < 0:
            self._cut.append(function)

    def _forgive(self, function, names):
        """Give the points for these mistakes to others that call a helper of this function, too."""
        outline = self._program.student.outline
        helpers = reached(outline, function) - self._lab.exercises().keys()
        for k, check in enumerate(self._checks.found):
            is_other = check.function != function and helpers & reached(outline, check.function)
            if is_other and check.misconception in names:
                remarks = *check.remarks, f"the same mistake as in {function}, which pays for it"
                self._checks.found[k] = replace(
                    check,
                    share=1.0,
                    points=check.max_points,
                    outcome="right",
                    misconception="",
                    hint="",
                    remarks=remarks,
                )

    def _tell(self, mend, function):
        """Tell what was found in those checks of a function that are not right."""
        told_at_all = self._lab.spots_from() is not None
        for k in self._places(function):
            check = self._checks.found[k]
            told = {"spot": mend.spot(self._program.where)} if told_at_all else {}
            if not is_named(check):
                told |= {"misconception": mend.name, "hint": mend.hint}
            self._checks.found[k] = replace(check, **told)

    def _judge_with(self, mend, paying):
        """Judge the other functions that call the one that is to be mended with the change made."""
        outline, changed = self._program.student.outline, mend.inside
        for k, check in enumerate(self._checks.found):
            failed = self._checks.failed.get(check.name)
            if failed is None or check.share == 1 or check.function in paying:
                continue
            asked = failed.ask.asked
            if not any(builds_on(outline, name, changed) for name in asked):
                continue
            given = self._checks.called(self._lab, asked)
            ask, share, left = self._checks.again(failed.item, self._lab, given, mend.made)
            if share > check.share:
                count = "one change" if len(mend.changes) == 1 else "two changes"
                helper = " and ".join(sorted(changed))
                ask.remark(f"judged with {count} in your {helper}, for which {mend.function} pays")
                made = checked(check.name, check.title, check.max_points, ask.record, left)
                self._checks.found[k] = made
