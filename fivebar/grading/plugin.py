"""The pytest plugin: `pytest labs/lab1_geometry --submission my.py`, with fixtures `ask`, `robot`
and `draw`.

A lab's check is a plain test: its docstring's first line is its title, `@pytest.mark.points(n)` its
worth (1 without). What it asks through `ask` is recorded even where the check crashes; such a crash
is the lab's fault, not the student's.
"""

from __future__ import annotations

import hashlib
from collections.abc import Generator
from dataclasses import dataclass, replace
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ..models.robots import Robot
from .advice.advice import Advice
from .intake.program import Job, Program
from .intake.students_robots import PUBLIC_SEED
from .judging.ask import Ask, Wrong
from .judging.diagnosis import consistent
from .judging.judge import Verdict
from .judging.results import checked
from .judging.with_right_ones import NEVER, helped, may_help, remark
from .labs import Lab
from .report.text import check_lines, number
from .worker.cell.stand_in import FORMS
from .worker.sandbox import IsolationError, KilledError

_ASK = pytest.StashKey[Ask]()


@dataclass(frozen=True)
class Failed:
    """A test that failed, with what it asked first, and its arguments."""

    item: pytest.Function
    ask: Ask
    arguments: dict


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("fivebar", "checks of a student's program")
    group.addoption("--submission", metavar="FILE", help="the student's .py file or notebook")
    group.addoption(
        "--seed", default=PUBLIC_SEED, help="of the inputs that are asked (default: %(default)s)"
    )


def pytest_configure(config: pytest.Config) -> None:
    config.option.importmode = "importlib"  # all labs have files of the same names
    config.pluginmanager.register(_from_options(config), "fivebar checks")


def _from_options(config):
    """Return the checks of a plain pytest run on one submission, graded like `fivebar check`."""
    option = config.option
    if not option.submission:
        return Checks(None, option.seed)
    path = Path(option.submission)
    if not path.is_file():
        raise pytest.UsageError(f"--submission: no file {option.submission!r}")
    try:
        program = Job(path, seed=option.seed).open()
    except IsolationError as error:
        raise pytest.UsageError(str(error)) from None
    config.add_cleanup(program.student.close)
    return Checks(program, option.seed)


def _diagnosis(error):
    """Return the mistake that a failed check is known by, None where none is."""
    return error.verdict.diagnosis if isinstance(error, Wrong) else None


class Checks:
    """One student's checks in a pytest session; `found` holds a Check per test, `trouble` the lab's
    own faults.
    """

    program: Any  # Program, None where a lab is only listed

    def __init__(self, program: Program | None, seed: str):
        self.program, self.seed = program, seed
        self.found: list = []
        self.trouble: list = []
        self.notes: list[str] = []  # on the whole file
        self.interrupted = False
        self.explains = True  # what is wrong, and with what it would be right
        self.killed: Any = None
        self.bar = None  # of who watches
        self._hopeless: dict = {}
        self.verdicts: dict = {}  # place in `found` -> Verdict
        self.asks: list[Ask] = []
        self.failed: dict[str, Failed] = {}  # by a test's name

    def pytest_configure(self, config: pytest.Config) -> None:
        config.addinivalue_line("markers", "points(n): what a check is worth")
        # Without a terminal nobody sees tracebacks, and they take a third of the time.
        vars(config.option).setdefault("tbstyle", "no")

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        if self.program is None and any(
            "ask" in getattr(item, "fixturenames", ()) for item in items
        ):
            raise pytest.UsageError("which file is to be checked? Give --submission FILE")

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        if self.bar is not None:
            self.bar.reset(len(session.items))

    def pytest_runtest_logfinish(self) -> None:
        if self.bar is not None:
            self.bar.update()

    @pytest.fixture
    def ask(self, request: pytest.FixtureRequest) -> Ask:
        lab, order = Lab(request.path.parent), self._drawn("order", request.node)
        ask = Ask(self.program, lab, self._hopeless, order)
        request.node.stash[_ASK] = ask
        self.asks.append(ask)
        return ask

    @pytest.hookimpl(wrapper=True)
    def pytest_pyfunc_call(self, pyfuncitem: pytest.Function) -> Generator[None, Any, Any]:
        try:
            return (yield)
        except AssertionError as error:
            if not self.explains or self.program is None or _ASK not in pyfuncitem.stash:
                raise
            self._with_right_ones(pyfuncitem, error)
            return True

    def _with_right_ones(self, item, error):
        """Run the check once more, with right functions in place of wrong ones called whose mistake
        is paid for elsewhere; raises what is then wrong.
        """
        lab, first = Lab(item.path.parent), item.stash[_ASK]
        self.failed[item.name] = Failed(item, first, dict(item.funcargs))
        before = error.verdict if isinstance(error, Wrong) else Verdict(0.0, "value")
        if before.reason in NEVER or "RecursionError" in before.text:
            raise error
        given = self.called(lab, first.asked)
        if given:
            ask, after, left = self._in_best_form(item, lab, given)
            doubtful = given.keys() - self._right()
            judged = {name: rows for name, rows in ask.rows.items() if name in doubtful}
            wrong = first.wrong_ones(judged) if after > before.share else []
            if wrong:
                item.stash[_ASK] = ask
                ask.remark(remark(wrong))
                error = left
            elif after > before.share or before.diagnosis is None and _diagnosis(left):
                error = self._told(item, error, sorted(doubtful or given), left)
        if error is not None:
            raise error from None

    def _in_best_form(self, item, lab, given):
        """Return what `again` gives with the right ones of these functions, in the form of their
        answers with which it earns most: one that raises shows no form of its own.
        """
        raising = {check.function for check in self.found if check.reason == "exception"}
        student, tried = self.program.student, {}
        for form in FORMS if raising & given.keys() else [student.form]:
            student.form = form
            tried[form] = self.again(item, lab, given)
        student.form = max(tried, key=lambda form: tried[form][1])
        return tried[student.form]

    def called(self, lab, asked):
        """Return the lab's functions that those asked may call, none where all are right."""
        names = may_help(self.program.student.outline, lab, asked)
        if names <= self._right():
            return {}
        return {name: lab.exercises()[name] for name in names}

    def _right(self):
        """Return the functions of which all checks so far are right."""
        wrong = {check.function for check in self.found if check.share < 1}
        return {check.function for check in self.found} - wrong

    def again(self, item, lab, given, change=None):
        """Return the Ask of a check run with the right ones of these functions, the share of its
        points that it earns, and what is wrong, None where nothing is; change: of the program, made
        in it, too.
        """
        robot = self.program.robot_in(lab)
        with helped(self.program, given, robot, lab.constants(), change) as program:
            ask = Ask(program, lab, {}, self._drawn("order", item))
            known = self.failed[item.name].arguments | {"ask": ask, "draw": self._drawn("", item)}
            share, left = 1.0, None
            try:
                item.obj(**{name: known[name] for name in signature(item.obj).parameters})
            except AssertionError as second:
                left = second
                share = second.verdict.share if isinstance(second, Wrong) else 0.0
            ask.rows = program.student.rows
        return ask, share, left

    def _told(self, item, error, names, left):
        """Return the error of a function that pays for wrong ones of these names that it calls."""
        if not isinstance(error, Wrong):
            return error
        names, last = " and ".join(names), _diagnosis(left)
        verdict = replace(error.verdict, diagnosis=consistent(names))
        if last is not None:
            remarks = *verdict.remarks, f"your {names} is wrong, too"
            verdict = replace(verdict, diagnosis=last, remarks=remarks)
        record = item.stash[_ASK].record
        record[-1] = replace(record[-1], verdict=verdict)
        return Wrong(verdict)

    @pytest.fixture
    def robot(self, request: pytest.FixtureRequest) -> Robot:
        return self.program.robot_in(Lab(request.path.parent))

    @pytest.fixture
    def draw(self, request: pytest.FixtureRequest) -> np.random.Generator:
        return self._drawn("", request.node)

    def _drawn(self, what, item):
        text = "\0".join([self.seed, item.path.parent.name, item.name, *filter(None, [what])])
        return np.random.default_rng(int.from_bytes(hashlib.sha256(text.encode()).digest()))

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo
    ) -> Generator[None, Any, Any]:
        report = yield
        error = call.excinfo.value if call.excinfo else None
        if isinstance(error, KilledError):
            self.killed, item.session.shouldstop = error, str(error)
        elif self.program is not None and (report.when == "call" or error is not None):
            self._record(item, report, error)
        return report

    def _record(self, item, report, error):
        marker = item.get_closest_marker("points")
        title = (item.obj.__doc__ or item.name).strip().splitlines()[0]
        ask = item.stash.get(_ASK, None)
        check = checked(
            item.name, title, marker.args[0] if marker else 1, ask.record if ask else [], error
        )
        if self.found and self.found[-1].name == check.name:
            self.found.pop()  # its teardown failed too
        self.found.append(check)
        if isinstance(error, Wrong):
            self.verdicts[len(self.found) - 1] = error.verdict
            report.longrepr = "\n".join(check_lines(check, 100))
        elif check.outcome == "broken":
            self.trouble.append(f"{check.title}: {check.text}")

    def tell_advice(self, lab: Lab) -> None:
        """Tell what makes wrong functions right, and judge again what builds on them."""
        if self.program is not None and self.program.confined:
            self._tell_advice_of_session(lab)
        elif self.explains and self.program is not None and self.program.again is not None:
            Advice(self, lab).tell()

    def _tell_advice_of_session(self, lab):
        """Tell it of a session's functions: what is tried runs in a process of its own."""
        live = self.program
        if all(check.share == 1 for check in self.found):
            return
        try:
            other = live.confined()
        except IsolationError:
            return
        with other.student:
            self.program = replace(other, robot=live.robot_in(lab))
            if other.student.trouble is None:
                self.tell_advice(lab)
        self.program = live

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self.trouble.append(str(report.longrepr).strip().splitlines()[-1])

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        if self.found:
            points = sum(check.points for check in self.found)
            most = sum(check.max_points for check in self.found)
            terminalreporter.write_line(f"{number(round(points, 2))} of {number(most)} points")

    def pytest_keyboard_interrupt(self, excinfo: pytest.ExceptionInfo) -> None:
        self.interrupted |= (
            excinfo.type is KeyboardInterrupt
        )  # a lab that cannot be read ends with a subclass
