"""What is told of a program's wrong functions when its checks are done: a change with which each of
them is right, and which one pays for a mistake that several share.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from .following import builds_on
from .labs import Lab
from .mends import MOST_FUNCTIONS, Lead, Mend, find_mend
from .questions import AskedRows
from .report.text import not_started
from .results import Check, checked
from .shared_mistakes import SharedMistakes

if TYPE_CHECKING:
    from .plugin import Checks

MOST_IN_VAIN = 2  # long searches of a file that find nothing: a draft has many mistakes
BY_LEGS = "ikm", "ikm2"  # a slip of one leg spoils one number of theirs alone: they come first
MENDED = ("value", "nan", "exception", "shape", "type", "accepted")


def is_named(check: Check) -> bool:
    """Return whether it is known what is wrong, not only in which function."""
    name = check.misconception
    return bool(name) and not name.startswith("consistent with your")


def may_be_mended(check: Check) -> bool:
    """Return whether a check got wrong answers from a function that is written to its end."""
    ended = "is a return missing" not in check.text
    return check.reason in MENDED and not not_started(check) and ended


class Advice:
    """What is found out about the wrong functions of one program, and told in its checks."""

    def __init__(self, checks: Checks, lab: Lab):
        self._checks, self._lab, self._program = checks, lab, checks.program
        self._asked: dict[str, list[AskedRows]] = {}
        for ask in checks.asks:
            for rows in ask.rows_asked:
                self._asked.setdefault(rows.exercise.name, []).append(rows)
        self._shared = SharedMistakes(checks.program, lab, self._wrong())
        self._mends: list[Mend] = []
        self._in_vain: dict[str, list[Mend]] = {}  # function -> changes found before the search

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
            if not mistakes or self._is_paid_elsewhere(function, mistakes):
                continue
            # It is still to be written, or answers by chance.
            if not all(mistake and mistake.idle for mistake in mistakes):
                self._search(function, mistakes)
        # What a function needs may be a change that was found for another one after it.
        for function, before in [*self._in_vain.items()]:
            unnamed = [k for k in self._places(function) if not is_named(self._checks.found[k])]
            if unnamed and self._mends_of_helpers(function) != before:
                self._search(function, self._mistakes(function))

    def _wrong(self):
        return {check.function for check in self._checks.found if check.share < 1}

    def _places(self, function):
        """Return the numbers of a function's checks that are not all right."""
        found = enumerate(self._checks.found)
        return [k for k, check in found if check.function == function and check.share < 1]

    def _mistakes(self, function):
        """Return what is known of a function's wrong checks, None for each of which nothing is."""
        places = self._places(function)
        if not any(may_be_mended(self._checks.found[k]) for k in places):
            return []
        known = self._checks.verdicts.get(function, {})
        return [known[k].diagnosis if k in known else None for k in places]

    def _search(self, function, mistakes):
        """Look for what makes a function right, tell it, and judge others with it."""
        named = _are_named(mistakes)
        deep = not named and len(self._in_vain.keys() - {function}) < MOST_IN_VAIN
        before = self._mends_of_helpers(function)
        mend = find_mend(
            self._program, self._lab, function, self._asked, self._wrong(), deep, before
        )
        if isinstance(mend, Mend):
            self._mends.append(mend)
            self._tell(mend, function, self._judge_with(mend))
            return
        if mend is not None:
            self._tell(mend, function)
        if deep:
            self._in_vain[function] = before
        self._shared.let_pay(function, self._asked[function], named)

    def _mends_of_helpers(self, function):
        """Return the changes found in helpers that a function may call, the last one first."""
        outline, exercises = self._program.student.outline, self._lab.exercises().keys()
        found = []
        for mend in reversed(self._mends):
            helpers = mend.inside - exercises
            if helpers and builds_on(outline, function, helpers):
                found.append(mend)
        return found

    def _tell(self, mend, function, others=frozenset()):
        """Tell what was found in those checks of a function that are not right.

        others: names of mistakes of the functions that are right with it, too. Where these are not
        the same, each only happens to give the same answers.
        """
        told_at_all = self._lab.spots_from() is not None
        for k in self._places(function):
            check = self._checks.found[k]
            named = is_named(check)
            if isinstance(mend, Lead) and named:
                continue
            told = {"spot": mend.spot(self._program.where)} if told_at_all else {}
            if not named or others - {check.misconception}:
                told |= {"misconception": mend.name, "hint": mend.hint}
            self._checks.found[k] = replace(check, **told)

    def _is_paid_elsewhere(self, function, mistakes):
        """Return whether a function is wrong by values of a helper for which another one pays; it
        gets its points then.
        """
        failed, asked = [], []
        for k in self._places(function):
            check = self._checks.found[k]
            if check.name not in self._checks.failed:
                continue
            ask = self._checks.failed[check.name].ask
            rows = [rows for rows in ask.rows_asked if len(rows.wrong)]
            if rows:
                failed.append((k, ask))
                asked += rows
        if not failed:
            return False
        payer, helper = self._shared.payer(function, asked, _are_named(mistakes))
        for k, ask in failed if payer else ():
            ask.remark(f"wrong by the same values of your {helper} as {payer}, which pays for them")
            self._renew(k, ask, None)
        return bool(payer)

    def _judge_with(self, mend):
        """Judge the other functions that call the one that is to be mended with the change made;
        return the names of mistakes that these had.
        """
        names = set()
        outline, changed = self._program.student.outline, mend.inside
        payers = {each.function for each in mend.with_before}
        for k, check in enumerate(self._checks.found):
            failed = self._checks.failed.get(check.name)
            if failed is None or check.share == 1 or check.function in payers:
                continue
            asked = failed.ask.asked
            if not any(builds_on(outline, name, changed) for name in asked):
                continue
            given = self._checks.called(self._lab, asked)
            ask, share, left = self._checks.again(failed.item, self._lab, given, True, mend.made)
            if share > check.share:
                count = "one change" if len(mend.changes) == 1 else "two changes"
                helper = " and ".join(sorted(changed))
                ask.remark(f"judged with {count} in your {helper}, for which {mend.function} pays")
                if is_named(check):
                    names.add(check.misconception)
                self._renew(k, ask, left)
        return names

    def _renew(self, place, ask, error):
        """Put a check in its place that ended with this error, None for a right one."""
        check = self._checks.found[place]
        made = checked(check.name, check.title, check.max_points, ask.record, error)
        self._checks.found[place] = made


def _are_named(mistakes):
    """Return whether all wrong answers of a function are those of known mistakes."""
    return all(mistake and mistake.model for mistake in mistakes)
