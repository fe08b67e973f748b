"""A lab's checks on a file of solutions in this process: `ask`, `robot`, `draw` as its tests get them."""

import importlib.util
import inspect
import re
import zlib
from functools import cache
from types import ModuleType

import numpy as np

import fivebar as fb
from fivebar.grading import Reply, Verdict, judge
from fivebar.grading.judging.judge import TOLERANCE
from tests.helpers import DATA, LABS

FOLDERS = {folder.name.split("_")[0]: folder for folder in sorted(LABS.glob("lab*_*"))}
SOLUTIONS, MISTAKES = (DATA / name for name in ("solutions", "mistakes"))


class Lost(AssertionError):
    """A check that is not all right."""


@cache
def load(lab, part):
    """A lab's exercises.py or test_lab.py as a module of its own."""
    spec = importlib.util.spec_from_file_location(f"{lab}_{part}", FOLDERS[lab] / f"{part}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@cache
def compiled(source):
    return compile(source, "student.py", "exec")


class Ask:
    """noise: relative, on every float that comes back, as rounding has it."""

    def __init__(self, exercises, source, robot, noise):
        self.exercises = {exercise.name: exercise for exercise in exercises}
        self.student = ModuleType("student")
        exec(compiled(source), self.student.__dict__)
        self.robot, self.noise, self.verdict_given = robot, np.random.default_rng(0), None
        self.size = noise

    def __call__(
        self, name, *columns, robot=None, constants=None, tolerance=None, refuse=None, limit=None
    ):
        robot = robot or self.robot
        replies = [
            self.reply(robot, constants, name, row)
            for row in zip(*(np.asarray(c).tolist() for c in columns))
        ]
        found = judge(
            self.exercises[name],
            robot,
            columns,
            replies,
            TOLERANCE if tolerance is None else tolerance,
            refuse,
        )
        self.give(found)

    def reply(self, robot, constants, name, row):
        values = vars(robot) | (constants or {})
        self.student.__dict__.update(values)
        try:
            with np.errstate(all="ignore"):
                return Reply("value", self.decoded(getattr(self.student, name)(*row)))
        except Exception as error:
            return Reply("exception", text=f"{type(error).__name__}: {error}")

    def call(self, name, *row, limit=None):
        reply = self.reply(self.robot, None, name, row)
        if reply.kind != "value":
            self.give(Verdict(0.0, reply.kind, reply.text))
        if reply.value is None:
            self.give(Verdict(0.0, "type", "returned None: is a return missing?"))
        return reply.value

    def decoded(self, value):
        """Tuples as lists, as they come over a pipe."""
        if isinstance(value, (tuple, list)):
            return [self.decoded(part) for part in value]
        if isinstance(value, (float, np.ndarray)):
            return value * (1 + self.size * self.noise.uniform(-1, 1, np.shape(value)))
        return value

    def verdict(self, share, reason="", asked="", came="", off=None):
        self.give(
            Verdict(share, "" if share == 1 else "value", reason, asked=asked, came=came, off=off)
        )

    def give(self, found):
        self.verdict_given = found
        if found.share < 1:
            raise Lost(found.text)


def results(lab, source, robot=None, seed=0, only="", noise=0.0):
    """{check's title: (points, Verdict)} of a file's source; a title begins with the function's name and a colon.

    only: the checks of this function.
    """
    checks, exercises = load(lab, "test_lab"), load(lab, "exercises")
    robot = robot or getattr(exercises, "ROBOT", fb.FiveBar())
    found = {}
    for name, test in vars(checks).items():
        if not name.startswith("test_") or (only and not test.__doc__.startswith(f"{only}:")):
            continue
        ask = Ask(exercises.EXERCISES, source, robot, noise)
        given = {
            "ask": ask,
            "robot": robot,
            "draw": np.random.default_rng([seed, zlib.crc32(name.encode())]),
        }
        try:
            test(**{key: given[key] for key in inspect.signature(test).parameters})
        except Lost:
            pass
        assert ask.verdict_given is not None, f"{name} gave no verdict"
        found[test.__doc__] = test.pytestmark[0].args[0], ask.verdict_given
    return found


def mistakes(lab):
    """(function, misconception's name, the solution's source with it) of each block in tests/data/mistakes."""
    right = (SOLUTIONS / f"{lab}.py").read_text("utf-8")
    for block in (MISTAKES / f"{lab}.txt").read_text("utf-8").split("\n\n")[1:]:
        title, *lines = block.strip("\n").split("\n")
        function, name = title.split(": ", 1)
        source = right
        for hunk in re.findall(r"(?:^-.*\n)+(?:^\+.*\n)*", "\n".join(lines) + "\n", re.MULTILINE):
            old, new = (
                "".join(f"{line[1:]}\n" for line in hunk.splitlines() if line[0] == sign)
                for sign in "-+"
            )
            assert f"\n{source}".count(f"\n{old}") == 1, (
                f"{title}: {old!r} is not once in the solution"
            )
            source = f"\n{source}".replace(f"\n{old}", f"\n{new}")[1:]
        yield function, name, source


def score(found):
    return sum(points * verdict.share for points, verdict in found.values())
