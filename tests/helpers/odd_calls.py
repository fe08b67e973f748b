"""Odd calls of every public function: usual arguments of which some are made strange, and what may come of it.

An answer, or a documented error: TypeError or ValueError that names an argument that was strange, UnreachableError,
SingularityError, another ArithmeticError of a simulation, PlanError, TimingError, OSError of a file; all raised by the
package. No other exception, no warning, nothing printed, no nan where it was not asked for, no call longer than its
time.
"""

import io
import math
import os
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from contextlib import contextmanager
from dataclasses import dataclass, field
from fractions import Fraction

import casadi
import numpy as np

import fivebar as fb
from fivebar import linkages

ROBOT = fb.FiveBar()
POSE = fb.dgm(ROBOT, (0.2, -0.1))
RATES = fb.dkm(POSE, (0.7, -1.1))
ACCELERATIONS = fb.dkm2(RATES, (3.0, 2.5))
FOUR_BAR = linkages.FourBar(0.2, 0.06, 0.16, 0.14)
LINE = fb.line((0.09, 0.068), (0.08, 0.075), 0.05)

# Of numbers and arrays: what may be meant for a number, and what cannot be.
NUMBERS = [
    0,
    1,
    -1,
    2,
    0.5,
    -0.3,
    1e-3,
    7,
    math.pi,
    1e-30,
    1e-300,
    5e-324,
    1e6,
    1e30,
    1e100,
    1e200,
    1e308,
    -1e308,
    10**20,
    10**400,
    math.nan,
    math.inf,
    -math.inf,
    True,
    False,
    -0.0,
    np.float32(0.1),
    np.float64("nan"),
    np.int8(-1),
    np.uint64(3),
    np.array(0.1),
    np.array([0.1]),
    np.array(1j),
    Fraction(1, 3),
    1j,
    2**63,
    -(2**63) - 1,
]
ARRAYS = [
    (),
    [],
    (0.1,),
    (0.1, 0.2),
    (0.1, 0.2, 0.3),
    (0.1, math.nan),
    (math.inf, 0.0),
    (1e200, 1.0),
    (1, -1),
    (-1, -1),
    (1, 1),
    (0, 0),
    (2, 1),
    [(0.1, 0.2)],
    np.zeros((3, 2)),
    np.zeros((0, 2)),
    np.full((2, 2), math.nan),
    np.eye(2),
    np.array([[0.1, 0.05], [math.nan, 0.0]]),
    np.array(["1", "2"]),
    ("0.1", "0.2"),
    ["a", "b"],
    [None, None],
    np.zeros((2, 2, 2)),
    np.array([1, 2], dtype=object),
    [[1], [1, 2]],
    np.array([True, False]),
    np.zeros(10),
    np.array([0.1, 0.2], dtype=np.float32),
    np.ma.array([0.1, 0.2]),
    (0.1j, 0.2),
    np.array([[0.1, 0.1]] * 4),
    (10**400, 0),
    np.array(["2020-01-01", "2020-01-02"], dtype="M8[D]"),
]
SYMBOLS = [
    casadi.SX.sym("s"),
    casadi.MX.sym("m"),
    casadi.SX.sym("v", 2),
    casadi.SX.sym("w", 3, 2),
    casadi.DM([1, 2]),
    casadi.DM(0.1),
    casadi.SX(0.1),
    casadi.DM.nan(2),
    casadi.MX.sym("n", 2),
]
OBJECTS = [
    None,
    "",
    "x",
    "raise",
    "nan",
    "task",
    "\0",
    b"x",
    object(),
    object,
    int,
    lambda *a: 5,
    lambda *a: None,
    {},
    {"a": 1},
    {0: (0.1, 0.1)},
    set(),
    range(3),
    iter(()),
    Ellipsis,
    slice(1),
    ROBOT,
    fb.FiveBar,
    fb.Biglide(),
    POSE,
    RATES,
    ACCELERATIONS,
    FOUR_BAR,
    LINE,
    fb,
    Exception("e"),
    memoryview(b"ab"),
    io.StringIO("a"),
    NotImplemented,
    fb.dgm(ROBOT, np.zeros((3, 2))),
    fb.dgm(ROBOT, (3.0, 0.1), unreachable="nan"),
    fb.Singularity.PARALLEL,
]
POOL = NUMBERS + ARRAYS + SYMBOLS + OBJECTS
KINDS = NUMBERS, ARRAYS, SYMBOLS, OBJECTS


@dataclass
class Case:
    """A function and arguments of a usual call; seconds that a call may take, names that its messages may use."""

    call: object
    usual: dict
    seconds: float = 2.0
    words: tuple = ()
    symbols: bool = True  # whether CasADi's values are among the strange ones
    nan: bool = False  # whether what it gives may hold nan
    options: dict = field(default_factory=dict)  # more strange values of an argument


@dataclass
class Report:
    """What came of the odd calls of one function."""

    calls: int = 0
    answered: int = 0
    errors: Counter = field(default_factory=Counter)
    wrong: list = field(default_factory=list)  # (arguments, what)
    seconds: float = 0.0


class TookTooLong(BaseException):
    """A call was interrupted."""


@contextmanager
def _alarm(seconds):
    """After so long on the processor, or six times as long by the clock: others work on this machine, too."""

    def ring(*_):
        raise TookTooLong

    clocks = (
        (signal.SIGPROF, signal.ITIMER_PROF, seconds),
        (signal.SIGALRM, signal.ITIMER_REAL, 6 * seconds),
    )
    before = [signal.signal(number, ring) for number, _, _ in clocks]
    for _, clock, duration in clocks:
        signal.setitimer(clock, duration)
    try:
        yield
    finally:
        for (number, clock, _), handler in zip(clocks, before):
            signal.setitimer(clock, 0)
            signal.signal(number, handler)


@contextmanager
def _printed(out):
    """Into this file goes what is printed, also by compiled code."""
    sys.stdout.flush(), sys.stderr.flush()
    kept = os.dup(1), os.dup(2)
    os.dup2(out.fileno(), 1), os.dup2(out.fileno(), 2)
    try:
        yield
    finally:
        sys.stdout.flush(), sys.stderr.flush()
        for number, old in enumerate(kept, start=1):
            os.dup2(old, number)
            os.close(old)


def odd_calls(case, count, rng, seconds=math.inf, least=6):
    """Report of so many odd calls, fewer, but not below `least`, where they take longer than `seconds` of the
    processor."""
    report, began = Report(), time.process_time()
    with tempfile.TemporaryFile() as out:
        while (
            report.calls < least or report.calls < count and time.process_time() - began < seconds
        ):
            arguments, strange = _strange(case, rng)
            report.calls += 1
            _one(case, arguments, strange, report, out)
    report.seconds = time.process_time() - began
    return report


def _strange(case, rng):
    """The usual arguments with one, two or three of them made strange; which."""
    arguments, names = dict(case.usual), list(case.usual)
    strange = [
        names[k]
        for k in rng.choice(len(names), min(len(names), rng.choice([1, 1, 1, 2, 3])), replace=False)
    ]
    for name in strange:
        pool = KINDS[rng.integers(len(KINDS))]
        if pool is SYMBOLS and not case.symbols:
            pool = OBJECTS
        if name in case.options and rng.random() < 0.3:
            pool = case.options[name]
        arguments[name] = pool[rng.integers(len(pool))]
    return arguments, strange


def _one(case, arguments, strange, report, out):
    what = ""
    with _printed(out):
        try:
            with warnings.catch_warnings(), _alarm(case.seconds):
                warnings.simplefilter("error")
                answer = case.call(**arguments)
            what = "" if case.nan or any(map(_asks_for_nan, arguments.values())) else _holes(answer)
            report.answered += not what
        except TookTooLong:
            what = f"took longer than {case.seconds} s"
        except Exception as error:  # to be judged: that is what this is for
            report.errors[type(error).__name__] += 1
            what = _judged(error, strange, case.words)
    notes = ""
    if os.fstat(out.fileno()).st_size:
        notes = os.pread(out.fileno(), 1000, 0).decode(errors="replace")
        os.ftruncate(out.fileno(), 0), os.lseek(out.fileno(), 0, os.SEEK_SET)
    what = what or (f"printed {notes[:200]!r}" if notes else "")
    if what:
        report.wrong.append(({name: arguments[name] for name in strange}, what))


def _judged(error, strange, words):
    """Why this error is none that is documented; empty if it is."""
    if isinstance(error, (fb.UnreachableError, fb.SingularityError, fb.PlanError, fb.TimingError)):
        return ""
    if type(error) is ArithmeticError or isinstance(error, OSError):
        return ""
    if type(error) is UnicodeEncodeError and any(
        0xD800 <= ord(letter) < 0xE000 for letter in error.object
    ):
        return ""  # half a letter, which no file's name can hold: Python's own words
    if type(error) not in (TypeError, ValueError):
        return f"{type(error).__name__}: {error}"
    text = str(error)
    if not any(name in text for name in (*strange, *words)):
        return f"{type(error).__name__} names no argument: {text[:300]}"
    return ""


def _asks_for_nan(value):
    """Whether this is unreachable="nan", or a pose that somebody got by it."""
    if isinstance(value, fb.Pose) and not np.ndim(value.point[0]):
        return not np.isfinite(value.point[0])
    return isinstance(value, str) and value == "nan"


def _holes(answer):
    """Where an answer, or what it holds, is nan; empty if nowhere."""
    if isinstance(answer, (fb.Pose, fb.Rates, fb.Accelerations)):
        names = {fb.Pose: ("q", "xi"), fb.Rates: ("q_dot", "xi_dot", "q_passive_dot", "d")}
        parts = names.get(fb.Pose if isinstance(answer, fb.Pose) else fb.Rates)
        parts = ("q_ddot", "xi_ddot") if isinstance(answer, fb.Accelerations) else parts
        values = [getattr(answer, name) for name in parts]
    elif isinstance(answer, (tuple, list)) and not hasattr(answer, "_fields"):
        values = answer
    else:
        values = [answer]
    for value in values:
        if (
            isinstance(value, (float, np.ndarray, np.floating))
            and np.asarray(value).dtype.kind == "f"
        ):
            if not np.isfinite(value).all():
                return f"a silent {np.asarray(value)[~np.isfinite(value)].flat[0]}"
    return ""
