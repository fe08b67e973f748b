"""A student's program in its worker: what it returns, how it fails, and what it finds around it."""

import linecache
import os
import time
from dataclasses import replace

import numpy as np
import pytest

from fivebar.grading.worker import places
from fivebar.grading.worker.live import from_functions
from fivebar.grading.worker.replies import Reply
from fivebar.grading.worker.sandbox import IsolationError
from fivebar.grading.worker.student import Student
from fivebar.grading.worker.submission import Submission

VALUES = """
import numpy as np
from collections import namedtuple
Point = namedtuple("Point", "x y")
gave = [
    1.5, 3, True, None, "text", 1 + 2j, float("inf"), -0.0, (1, 2.5), [1, (2, 3)], Point(1.0, 2.0), np.float64(0.1),
    np.int32(7), np.bool_(True), np.complex128(1j), np.longdouble(0.5), np.array(2.5), np.array([1.0]),
    np.array([[1.0], [2.0]]), np.matrix([[1, 2]]), np.array([1, np.nan]), np.zeros((2, 0)), np.array([True, False]),
    np.array([1j, 0]), np.ma.array([1.0, 2.0]), {"a": 1}, {1}, object, 10**400, b"bytes", np.array(["a"]),
]
def value(i): return gave[i]
"""
CAME = [
    1.5,
    3,
    True,
    None,
    "text",
    1 + 2j,
    float("inf"),
    -0.0,
    [1, 2.5],
    [1, [2, 3]],
    [1.0, 2.0],
    0.1,
    7,
    True,
    1j,
    0.5,
    np.array(2.5),
    np.array([1.0]),
    np.array([[1.0], [2.0]]),
    np.array([[1, 2]]),
    np.array([1, np.nan]),
    np.zeros((2, 0)),
    np.array([True, False]),
    np.array([1j, 0]),
    np.array([1.0, 2.0]),
    [["a", 1]],
    "set",
    "type",
    "int",
    "bytes",
    np.array(["a"], dtype=object),
]


def student(source, **options):
    return Student(Submission("a.py", source), **options)


def test_numpys_warning_of_a_nan_is_not_what_a_program_prints():
    with student("import numpy as np\ndef f(x):\n    return np.sqrt(x)\n") as worker:
        assert np.isnan(worker.ask("f", [(-1.0,)])[0].value)
    assert worker.output == ""


def test_values_of_all_kinds_come_as_they_are(isolate):
    with student(VALUES, isolate=isolate) as worker:
        replies = worker.ask("value", [(i,) for i in range(len(CAME))])
    for came, wanted in zip(replies, CAME, strict=True):
        assert came.kind == "value", came
        if isinstance(wanted, list) and isinstance(came.value, dict):
            assert came.value == {"~": "dict", "pairs": wanted}
        elif isinstance(came.value, dict):
            assert came.value["~"] == "other" and came.value["type"] == wanted
        elif isinstance(wanted, np.ndarray):
            assert came.value.shape == wanted.shape and came.value.dtype == wanted.dtype
            assert (came.value.tolist() == wanted.tolist()) or np.array_equal(
                came.value, wanted, equal_nan=True
            )
        else:
            assert type(came.value) is type(wanted) and repr(came.value) == repr(wanted)


def test_numbers_arrive_to_the_last_bit():
    numbers = np.random.default_rng(3).standard_normal(200) * 10.0 ** np.arange(-100, 100)
    with student("def same(x): return x\ndef kind(x): return type(x).__name__") as worker:
        assert [r.value for r in worker.ask("same", numbers[:, None])] == numbers.tolist()
        assert np.isnan(worker.ask("same", [(np.nan,)])[0].value)
        rows = [(np.int64(-1),), (np.float64(2),), (True,), ("a",), ([1, 2],), (np.zeros(2),)]
        assert [r.value for r in worker.ask("kind", rows)] == [
            "int",
            "float",
            "bool",
            "str",
            "list",
            "list",
        ]
        assert worker.ask("same", []) == []


def test_failures_name_the_students_own_line():
    source = """
import numpy as np
def helper(x):
    return 1 / x

def through(x):
    return helper(x) + 1

def library(x):
    return np.linalg.inv(np.zeros((2, 2)))

def todo(x):
    raise NotImplementedError("lab1 task 1: the direct model")

def evaluated(x):
    return eval("1 +")
"""
    with student(source) as worker:
        assert worker.trouble is None and worker.names == (
            "helper",
            "through",
            "library",
            "todo",
            "evaluated",
        )
        one = worker.ask("through", [(0,)])[0]
        assert (one.kind, one.text, one.line) == (
            "exception",
            "ZeroDivisionError: division by zero",
            4,
        )
        assert one.source == "return 1 / x"
        two = worker.ask("library", [(0,)])[0]
        assert (two.text, two.line) == ("LinAlgError: Singular matrix", 10)
        assert (
            worker.ask("todo", [(0,)])[0].text
            == "NotImplementedError: lab1 task 1: the direct model"
        )
        assert worker.ask("evaluated", [(0,)])[0].line == 16
        assert worker.ask("through", [(1, 2)])[0].text.startswith("TypeError: through() takes 1")
        assert worker.ask("igm", [(1,), (2,)]) == [Reply("missing", text="no function igm")] * 2
        assert worker.ask("To_do", [(1,)])[0].text == "no function To_do: is your todo meant?"
        assert worker.ask("np", [(1,)])[0].kind == "missing"


def test_constants_are_set_for_one_ask():
    with student("l = 0.09\ndef length(): return l\nother = 1") as worker:
        assert [
            worker.ask("length", [()], c)[0].value
            for c in ({"l": 0.2}, None, {"l": np.float64(0.3)}, {})
        ] == [0.2, 0.09, 0.3, 0.09]
        assert worker.ask("length", [()], {"l": 1.0, "l11": 2.0}) == [
            Reply("missing", text="the file has no constant l11")
        ]
        assert worker.ask("length", [()])[0].value == 0.09


BROKEN = """from __future__ import annotations
import numpy as np
from lab_amoro.parallel_robot import *

l = 0.09

def dgm(q11: Unknown, q21):
    return l * np.cos(q11), q21

L = half(l)

def igm(x, y)
    return x, y

class Robot:
    def reach(self):
        return 2 * l

@staticmethod
def reach():
    return Robot().reach()

while True print(1)

def needs():
    return L
if l > 0:
    def inner():
        return 1
else:
    pass
"""


def test_a_file_that_fails_is_graded_as_far_as_it_goes():
    with student(BROKEN) as worker:
        assert worker.trouble.kind == "import" and worker.trouble.line == 12
        assert (
            worker.trouble.text == "SyntaxError: expected ':'"
            and worker.trouble.source == "def igm(x, y)"
        )
        assert worker.ask("dgm", [(0.0, 1)])[0].value == [0.09, 1]
        assert (
            worker.ask("reach", [()])[0].value == 0.18 and worker.ask("inner", [()])[0].value == 1
        )
        assert worker.ask("igm", [(1, 2)])[0] == replace(worker.trouble, kind="exception")
        assert worker.outline["igm"][0] == ["x", "y"]
        lost = worker.ask("needs", [()])[0]
        assert (lost.kind, lost.text, lost.line) == (
            "exception",
            "NameError: name 'L' is not defined",
            26,
        )
    with student(BROKEN.replace("y)\n", "y):\n").replace("True print", "0: print")) as worker:
        assert worker.trouble.text.startswith(
            "ModuleNotFoundError: lab_amoro is not available here"
        )
        assert worker.trouble.line == 3 and worker.ask("igm", [(1, 2)])[0].value == [1, 2]
    with student("raise MemoryError") as worker:
        assert worker.trouble.text == "ran out of memory"


def test_a_main_program_does_not_run_and_input_is_at_its_end():
    source = 'if __name__ == "__main__":\n    1 / 0\nname = __name__\ndef called(): return name\ndef f(): return input()'
    with student(source) as worker:
        assert worker.trouble is None and worker.ask("called", [()])[0].value == "student"
        assert worker.ask("f", [()])[0].text.startswith("EOFError: EOF when reading a line: nobody")


def test_a_notebook_gives_its_definitions_only():
    source = (
        "import numpy as np\nl, d = 0.09, 0.118\nP: float = np.array([0, d / 2])\nplt.show()\n"
        "def f(x):\n    return l * x\ng = lambda x: x + P[1]\n"
        "result = f(open('data.txt').read())\n1 / 0\nfor i in x: pass\ny = 1 +\ndef h(x): return 3\n"
    )
    with Student(Submission("a.ipynb", source, "notebook")) as worker:
        assert worker.trouble.text == "SyntaxError: invalid syntax" and worker.trouble.line == 11
        assert [worker.ask(name, [(2.0,)])[0].value for name in "fgh"] == [0.18, 2.059, 3]
    with Student(Submission("a.ipynb", source.replace("y = 1 +\n", ""), "notebook")) as worker:
        assert worker.trouble is None


@pytest.mark.deep
def test_a_hang_costs_its_own_row():
    source = (
        "import time\nn = 0\ndef f(x):\n"
        "    while x < 0:\n        try: time.sleep(9)\n        except: pass\n    return x\n"
        "def count():\n    global n\n    n += 1\n    return n\n"
    )
    with student(source, limit=1.0) as worker:
        assert [worker.ask("count", [(), ()])[1].value, worker.ask("count", [()])[0].value] == [
            2,
            3,
        ]
        replies = worker.ask("f", [(1,), (-1,), (2,), (3,)])
        assert [r.kind for r in replies] == ["value", "timeout", "value", "value"]
        assert replies[1].text == "no answer within 1 s"
        assert worker.ask("count", [()])[0].value == 1  # a new worker
        replies = worker.ask("f", [(-1,), (1,), (-1,), (1,)] * 2)
        assert [r.kind for r in replies] == ["timeout", "value"] * 4
    with student("import time\ndef f(x): time.sleep(0.1)", total=1.0) as worker:
        replies = worker.ask("f", [(0,)] * 50)
        assert {r.kind for r in replies} == {"value", "unasked"} and replies[-1].text.endswith(
            "all of the time"
        )


def test_a_call_that_hangs_is_told_with_its_line_and_keeps_its_worker(isolate):
    source = "n = 0\ndef f(x):\n    global n\n    n += 1\n    while x < 0:\n        x -= 1\n    return n\n"
    with student(source, isolate=isolate, limit=0.2) as worker:
        replies = worker.ask("f", [(-1,), (1,)] * 5)
    assert [r.value for r in replies[1::2]] == [2, 4, 6, 8, 10]
    assert {(r.kind, r.text) for r in replies[::2]} == {("timeout", "no answer within 0.2 s")}
    assert all(r.line in (5, 6) for r in replies[::2])


@pytest.mark.deep
def test_a_whole_submission_has_a_limit_of_time_too(monkeypatch):
    """Calls just within their own limit, in many asks, hold a grader no longer than that."""
    monkeypatch.setattr("fivebar.grading.worker.student.LOAD_LIMIT", 1.0)
    monkeypatch.setattr("fivebar.grading.worker.student.MOST_CALLS", 0)
    with student("import time\ndef f(x):\n    time.sleep(0.5)\n    return x", limit=5) as worker:
        replies = [worker.ask("f", [(k,)])[0] for k in range(10)]
    assert (
        replies[0].kind == "value"
        and replies[-1].kind == "unasked"
        and "all of the time" in replies[-1].text
    )


def test_time_on_the_processor_is_limited_too(isolate):
    with student("def f():\n    while True: pass", isolate=isolate, cpu=1, limit=60) as worker:
        reply = worker.ask("f", [()])[0]
    assert (reply.kind, reply.text) == ("timeout", "its time on the processor is used up")


@pytest.mark.deep
def test_a_file_that_cannot_be_loaded_is_tried_three_times_only(monkeypatch):
    monkeypatch.setattr("fivebar.grading.worker.student.LOAD_LIMIT", 1.0)
    source = "__import__('time').sleep(99)\n" * 4 + "def f(): return 1\n"
    with student(source) as worker:
        assert worker.trouble == Reply(
            "import",
            None,
            "ran past its time limit: not done within 1 s",
            1,
            "__import__('time').sleep(99)",
        )
        monkeypatch.setattr("fivebar.grading.worker.student.SandboxWorker", None)
        assert worker.ask("f", [(), ()]) == [worker.trouble] * 2


def test_what_it_prints_is_kept_and_capped():
    source = 'import sys\nprint("start")\ndef f(n):\n    print("x" * n)\n    print("é\\x1b[1m", file=sys.stderr)\n'
    with student(source) as worker:
        worker.ask("f", [(3,)])
        end = time.monotonic() + 60
        while worker.output.count("\n") < 3 and time.monotonic() < end:
            time.sleep(0.01)  # what is printed comes by another way than the answer
        assert worker.output.split("\n")[:3] == ["start", "xxx", "é\N{REPLACEMENT CHARACTER}[1m"]
        assert worker.ask("f", [(1_000_000,)])[0].kind == "value"
    assert 63_990 < len(worker.output) <= 64_000


def test_a_thousand_calls_print_a_line_each():
    with student("def f(n):\n    print(n, n, n)\n    return n") as worker:
        assert [r.value for r in worker.ask("f", [(i,) for i in range(1000)])] == list(range(1000))


def test_what_it_finds_around_it(isolate):
    source = """
import os, sys
import scipy.optimize, scipy.integrate, scipy.spatial.transform
def root(): return scipy.optimize.brentq(lambda x: x**2 - 2, 0, 2)
def user(): return [os.getuid(), os.getgid()] + os.getgroups()
def folder():
    try:
        return [os.getcwd(), *os.listdir(".")]
    except PermissionError:
        return [os.getcwd(), "not to be listed"]
def environment(): return sorted(os.environ)
def arguments(): return sys.argv
def fresh(): return [m for m in ("json.tool", "xml.dom", "email.mime.text", "numpy.fft") if not __import__(m)]
def linear():
    import numpy
    a = numpy.random.default_rng(0).standard_normal((200, 200))
    return float(abs(a @ numpy.linalg.inv(a) - numpy.eye(200)).max())
"""
    with student(source, isolate=isolate, limit=10) as worker:
        assert worker.trouble is None
        found = {name: worker.ask(name, [()])[0].value for name in worker.names}
        assert (
            abs(found["root"] - 2**0.5) < 1e-12 and found["linear"] < 1e-9 and found["fresh"] == []
        )
        assert found["folder"] == (
            ["/student"] if isolate == "bwrap" else ["/", "not to be listed"]
        )
        assert found["arguments"] == ["student"]
        names = {"HOME", "LANG", "LC_CTYPE", "MPLCONFIGDIR", "PATH", "PWD"}
        assert {n for n in found["environment"] if not n.endswith("NUM_THREADS")} <= names
        if os.getuid() == 0:
            assert found["user"][0] == found["user"][1] >= 61_200 and len(found["user"]) == 2
            assert worker.notes == (
                f"running as root: the student's program runs as user {found['user'][0]}",
            )
        else:
            assert found["user"][0] == os.getuid() and worker.notes == ()


def test_what_is_missing_is_said(monkeypatch, tmp_path):
    with pytest.raises(ValueError, match="isolate is .* not 'docker'"):
        student("", isolate="docker")
    with monkeypatch.context() as patch:
        patch.setattr("fivebar.grading.worker.launch.CELL", tmp_path / "cell")
        with pytest.raises(IsolationError, match="did not start: .*cell"):
            student("")
    with monkeypatch.context() as patch:
        patch.setattr("fivebar.grading.worker.launch.interpreter", lambda: tmp_path / "python")
        before = set(os.listdir("/proc/self/fd"))
        with pytest.raises(IsolationError, match="cannot be started: .*python"):
            student("")
        assert set(os.listdir("/proc/self/fd")) <= before
    monkeypatch.setenv("PATH", str(tmp_path))
    places.bwrap_command.cache_clear()
    places.bwrap_trouble.cache_clear()
    try:
        with pytest.raises(
            IsolationError,
            match="bwrap cannot isolate a worker here: bwrap .bubblewrap. is not installed",
        ):
            student("", isolate="bwrap")
        assert places.bwrap_trouble()
    finally:
        places.bwrap_trouble.cache_clear()


def test_live_functions_answer_as_a_submission_does():
    space = {"__name__": "session"}
    source = VALUES.replace("np.matrix", "np.array") + (
        "l = 2.0\ndef scaled(x): return l / x\ndef leave(): raise SystemExit(3)\ndef stop(): raise KeyboardInterrupt\n"
    )
    exec(compile(source, "<session>", "exec"), space)
    linecache.cache["<session>"] = (
        len(source),
        None,
        source.splitlines(keepends=True),
        "<session>",
    )  # as notebooks do
    rows = [(i,) for i in range(len(CAME))]
    live = from_functions(**{name: space[name] for name in ("value", "scaled", "leave", "stop")})
    with live, student(source) as worker:
        for mine, theirs in zip(live.ask("value", rows), worker.ask("value", rows)):
            assert (mine.kind, repr(mine.value)) == (theirs.kind, repr(theirs.value))
        for arguments in (
            ("scaled", [(4,), (0,)], {"l": 1.0}),
            ("scaled", [(1,)]),
            ("leave", [()]),
            ("nothing", [()]),
        ):
            mine, theirs = live.ask(*arguments), worker.ask(*arguments)
            assert [(r.kind, r.value, r.text, r.line, r.source) for r in mine] == [
                (r.kind, r.value, r.text, r.line, r.source) for r in theirs
            ]
        assert (
            live.ask("scaled", [(1,)], {"nothing": 1})[0].text
            == "the session has no constant nothing"
        )
        with pytest.raises(KeyboardInterrupt):
            live.ask("stop", [()])
    assert space["l"] == 2.0 and live.names[0] == "value" and live.trouble is None
    with pytest.raises(TypeError, match="dgm is a float, not a function"):
        from_functions(dgm=1.0)


@pytest.mark.deep
@pytest.mark.parametrize("isolate", ["process", *([] if places.bwrap_trouble() else ["bwrap"])])
def test_packages_that_a_course_allows_come_with_what_they_require(isolate):
    source = (
        "import matplotlib.pyplot as plt\nimport mpmath\nplt.plot([1, 2])\n"
        "def slope(a):\n    return float(mpmath.diff(lambda x: x**2, a))\n"
    )
    packages = ("mpmath", "matplotlib")
    with Student(Submission("a.py", source), isolate, packages=packages) as student:
        assert student.trouble is None and student.ask("slope", [[3.0]])[0].value == 6.0
    for other in ("pytest", "fivebar", "casadi"):
        with Student(
            Submission("a.py", f"import {other}\n"), isolate, packages=packages
        ) as student:
            assert f"{other} is not available here" in student.trouble.text
