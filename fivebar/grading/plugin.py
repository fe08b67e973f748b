"""The pytest plugin: `pytest labs/lab1_geometry --submission my.py`, with fixtures `ask`, `robot`
and `draw`.

A lab's check is a plain test: its docstring's first line is its title, `@pytest.mark.points(n)` its
worth (1 without). What it asks through `ask` is recorded even where the check crashes; such a crash
is the lab's fault, not the student's.
"""

from __future__ import annotations

import hashlib
from collections.abc import Generator
from dataclasses import replace
from functools import partial
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ..models.robots import Robot
from .ask import Ask, Wrong
from .following import NEVER, helped, may_help, remark
from .judge import Verdict
from .labs import Lab
from .program import Job, Program
from .report.text import check_lines, number
from .results import checked
from .variants import PUBLIC_SEED, robot_for
from .worker.sandbox import IsolationError, KilledError

_ASK = pytest.StashKey[Ask]()


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("fivebar", "checks of a student's program")
    group.addoption("--submission", metavar="FILE", help="the student's .py file or notebook")
    group.addoption(
        "--seed", default=PUBLIC_SEED, help="of the inputs that are asked (default: %(default)s)"
    )
    group.addoption(
        "--isolate", choices=("process", "bwrap"), default="process", help="(default: %(default)s)"
    )
    group.addoption("--time-limit", type=float, metavar="S", help="for what one check asks")
    group.addoption("--student", default="", metavar="ID", help="whose robot, with --secret-file")
    group.addoption("--secret-file", type=Path, metavar="FILE", help="the course's secret")


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
    job = Job(path, option.student, option.seed, None, option.isolate, option.time_limit)
    try:
        program = job.open()
    except IsolationError as error:
        raise pytest.UsageError(str(error)) from None
    config.add_cleanup(program.student.close)
    if option.secret_file:
        secret = option.secret_file.read_bytes().strip()
        program = replace(program, robot_from_standard=partial(robot_for, option.student, secret))
    return Checks(program, option.seed)


class Checks:
    """One student's checks in a pytest session; `found` holds a Check per test, `trouble` the lab's
    own faults.
    """

    program: Any  # Program, None where a lab is only listed

    def __init__(self, program: Program | None, seed: str):
        self.program, self.seed = program, seed
        self.found: list = []
        self.trouble: list = []
        self.interrupted = False
        self.killed: Any = None
        self.bar = None  # of who watches
        self._hopeless: dict = {}
        self._known: dict = {}  # of all checks; the latter: diagnoses by function

    def pytest_configure(self, config: pytest.Config) -> None:
        config.addinivalue_line("markers", "points(n): what a check is worth")

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
        ask = Ask(self.program, lab, self._hopeless, order, self._known)
        request.node.stash[_ASK] = ask
        return ask

    @pytest.hookimpl(wrapper=True)
    def pytest_pyfunc_call(self, pyfuncitem: pytest.Function) -> Generator[None, Any, Any]:
        try:
            return (yield)
        except AssertionError as error:
            if self.program is None or _ASK not in pyfuncitem.stash:
                raise
            self._with_right_ones(pyfuncitem, error)
            return True

    def _with_right_ones(self, item, error):
        """Run the check once more, with the right functions in place of wrong ones called; raises
        what is then wrong.
        """
        first, lab = item.stash[_ASK], Lab(item.path.parent)
        before = error.verdict if isinstance(error, Wrong) else Verdict(0.0, "value")
        hopeless = before.reason in NEVER or "RecursionError" in before.text
        names = set() if hopeless else may_help(self.program.source, lab, first.asked)
        shares = {name: [] for name in names}
        for check in self.found:
            if check.function in names:
                shares[check.function].append(check.share)
        if all(set(judged) == {1} for judged in shares.values()):
            raise error  # nothing is called, or only right functions
        with helped(
            self.program,
            {name: lab.exercises()[name] for name in names},
            self.program.robot_in(lab),
        ) as program:
            ask = Ask(program, lab, {}, self._drawn("order", item))
            given = {"ask": ask, "draw": self._drawn("", item)}
            try:
                item.obj(
                    **{
                        name: given.get(name, item.funcargs[name])
                        for name in signature(item.obj).parameters
                    }
                )
                after, left = 1.0, None
            except AssertionError as second:
                after, left = second.verdict.share if isinstance(second, Wrong) else 0.0, second
        wrong = first.mistakes(program.student.rows) if after > before.share else {}
        if not wrong:
            raise error
        item.stash[_ASK] = ask
        ask.remark(remark(wrong))
        if left is not None:
            raise left from None

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
            report.longrepr = "\n".join(check_lines(check, 100))
        elif check.outcome == "broken":
            self.trouble.append(f"{check.title}: {check.text}")

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
