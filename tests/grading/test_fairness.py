"""Right work never loses a point, whatever its form; nothing earns one by accident."""

import json
import os
import re
import signal

import numpy as np
import pytest

import fivebar as fb
from fivebar.grading import check
from fivebar.grading.grade import grade
from fivebar.grading.intake.program import Job
from fivebar.grading.labs import find_lab
from fivebar.grading.worker import student as worker
from fivebar.grading.worker.sandbox import KilledError
from fivebar.grading.worker.student import Student
from fivebar.grading.worker.submission import Submission
from tests.helpers import DATA
from tests.helpers.lab_session import results

from ..helpers.grading_lab import RIGHT, write_lab, written

LAB1, LAB4, LAB6 = (DATA.joinpath(f"solutions/lab{k}.py").read_text("utf-8") for k in (1, 4, 6))


def points(lab, tmp_path, source, **choices):
    return grade(find_lab(lab), Job(written(tmp_path / "my.py", source), **choices))


def without(source, name):
    return "".join(
        line for line in source.splitlines(keepends=True) if not line.startswith(f"{name} = ")
    )


@pytest.mark.every(2)
@pytest.mark.parametrize(
    "change",
    [
        lambda s: without(s, "m") + "# of mass m\n",
        lambda s: (
            "import math as m\n" + re.sub(r"\b(cos|sin|sqrt|hypot)\(", r"m.\1(", without(s, "m"))
        ),
        lambda s: s.replace("d = 0.118\n", "d = 0.118\nhalf = d / 2\n").replace("d / 2,", "half,"),
        lambda s: s.replace("d = 0.118\n", "d = 118\nd /= 1000\n"),
        lambda s: s.replace("l11 = 0.09\nl12 = 0.09\n", "l11, l12 = 90e-3, 90 / 1000\n"),
        lambda s: s.replace("l11 = 0.09\nl12 = 0.09\n", "if True:\n    l11 = l12 = 0.09\n"),
        lambda s: "import numpy as np\n" + s.replace("d = 0.118", "d: float = np.float64(0.118)"),
        lambda s: s.replace(
            "(q11, q21, assembly_mode):", "(q11, q21, assembly_mode, first=l11, d=d):"
        ),
    ],
    ids="unused-name module-named-m derived in-millimetres in-one-line under-an-if numpy-number default".split(),
)
def test_a_right_file_of_any_form_gets_all_points(tmp_path, change):
    source = change(LAB1)
    assert source != LAB1
    report = points("lab1", tmp_path, source)
    assert [
        (c.title, c.text) for c in report.checks if c.outcome != "right"
    ] == [] and report.points == 20


def test_what_a_file_computes_from_the_robots_numbers_follows_them():
    source = (
        "import math as m\nfrom functools import lru_cache\nl = 0.09\nR2 = l / 2\ntimes = 0\n"
        "class Robot:\n    half = R2\n"
        "@lru_cache\ndef f(x, own=l): return [l, R2, own, Robot.half, m.sqrt(4)]\n"
        "def count():\n    global times\n    times += 1\n    return times\n"
    )
    with Student(Submission("a.py", source)) as program:
        assert program.constants == {"l": 0.09, "R2": 0.045, "times": 0.0}
        assert program.ask("f", [(1,)], {"l": 0.2})[0].value == [0.2, 0.1, 0.2, 0.1, 2.0]
        assert program.ask("f", [(1,)])[0].value == [0.09, 0.045, 0.09, 0.045, 2.0]
        assert [
            program.ask("count", [()], c)[0].value for c in ({"l": 0.1}, {"l": 0.1}, None, None)
        ] == [1, 1, 1, 2]
        assert program.ask("f", [(1,)], {"m": 0.5})[0].text == "the file has no constant m"


def test_a_notebook_computes_what_its_functions_read_and_no_more():
    source = (
        "l = 0.09\ndef half(x): return x / 2\nR = half(l)\nQ = R * half(4)\nQ *= 2\nresult = open('data.txt').read()\n"
        "x = open('data.txt')\nshown = f(1.0)\ndef f(x):\n    y = x\n    return [l, Q * y]\n"
    )
    with Student(Submission("a.ipynb", source, "notebook")) as program:
        assert program.trouble is None
        assert np.allclose(program.ask("f", [(1.0,)])[0].value, [0.09, 0.18])
        assert np.allclose(program.ask("f", [(1.0,)], {"l": 0.2})[0].value, [0.2, 0.4])


@pytest.mark.deep
def test_a_file_without_the_labs_names_is_told_why_it_loses(tmp_path):
    source = re.sub(r"\bl[12]{2}\b", "l", LAB1)
    report = points("lab1", tmp_path, source)
    assert 0 < report.points < 20 and "gives no number to l11, l12, l21, l22" in report.notes[0]
    report = points("lab1", tmp_path, f"def igm(x):\n    return x\n\n{without(LAB1, 'm')}")
    assert report.points == 20 and not report.notes


@pytest.mark.deep
def test_nothing_follows_from_what_is_no_model(tmp_path):
    source = (
        "dynamic_model = lambda *q: ([[q[0], 0], [0, q[0]]], [0, 0])\n"
        "def inverse_dynamics(*row):\n"
        "    M, c = dynamic_model(*row[:8])\n"
        "    return M[0][0] * row[8], M[1][1] * row[9]\n"
    )
    assert points("lab5", tmp_path, source).points == 0
    assert (
        points(
            "lab2", tmp_path, "B = lambda *q: [[0, 0], [0, 0]]\ndkm = lambda *row: (0, 0)\n"
        ).points
        == 0
    )


def test_a_robot_whose_numbers_are_computed_is_the_files_at_home(tmp_path):
    source = RIGHT.replace("0.118", "120 / 1000")
    lab = find_lab("elbow", write_lab(tmp_path / "mylabs"))
    report = grade(lab, Job(written(tmp_path / "my.py", source)), home=True)
    assert report.points == 4 and report.robot["d"] == 0.12


NUMBERS = """
import enum, cmath
from decimal import Decimal
from fractions import Fraction
from collections import OrderedDict
import numpy as np
class Length(float): pass
class Kind(enum.IntEnum): SERIAL = 1
class Word(str): pass
gave = [
    (1 + 0j, np.complex128(2)), {"y": 2.0, "x": 1.0}, OrderedDict(x=1, y=Length(2)), (Fraction(1), Decimal(2)),
    (Length(1.0), Kind.SERIAL + 1), np.array([1 + 1e-17j, 2]), [Fraction(2, 2), np.array([Decimal("2.0")])],
    (cmath.sqrt(1), np.longdouble(2)),
]
def pair(i): return gave[int(i)]
"""


def test_numbers_of_every_kind_are_read(tmp_path):
    lab = tmp_path / "labs" / "forms"
    written(
        lab / "exercises.py",
        "from fivebar.grading import Exercise\n"
        "EXERCISES = [Exercise('pair(i) -> x, y', lambda robot, i: (1 + 0 * i, 2 + 0 * i))]\n",
    )
    written(
        lab / "test_lab.py",
        "def test_pair(ask):\n    'pair: all forms'\n    ask('pair', range(8))\n",
    )
    report = grade(find_lab("forms", lab.parent), Job(written(tmp_path / "my.py", NUMBERS)))
    assert (report.points, report.checks[0].text) == (1, "")
    bad = (
        NUMBERS.replace("1 + 0j", "1 + 1e-3j")
        .replace('"y": 2.0', '"z": 2.0')
        .replace("Fraction(1)", "{1: 2}")
    )
    bad = bad.replace("Length(1.0)", "Word('1')")
    with Student(Submission("a.py", bad)) as program:
        replies = program.ask("pair", [(i,) for i in range(5)])
    from fivebar.grading.judging.judge import judge

    exercise = find_lab("forms", lab.parent).exercises()["pair"]
    texts = [
        judge(exercise, fb.FiveBar(), [np.array([k])], [reply]).text
        for k, reply in enumerate(replies)
    ]
    words = "complex", "a dict of z, x", "", "a dict", "a string"
    assert all(word in text for word, text in zip(words, texts)), texts
    assert texts[2] == ""


@pytest.mark.deep
def test_a_crossing_on_a_sample_time_is_one_crossing():
    """Halves of equal duration cross in the middle of 101 samples, where det A may be 0 to the last bit."""
    even = LAB6.replace("half = s * duration", "half = duration / 2")
    assert even != LAB6
    for seed in range(12):
        found = results("lab6", even, seed=seed, only="crossing_trajectory")
        lost = [verdict.text for _, verdict in found.values() if verdict.share < 1]
        assert not any("exactly once" in text for text in lost), (seed, lost)


@pytest.mark.deep
def test_an_answer_by_the_number_of_the_call_earns_nothing(tmp_path):
    """The types come in a fixed order from the lab, but not to the program."""
    counter = (
        "n = -1\ndef singularity_type(q11, q12, q21, q22):\n    global n\n    n += 1\n"
        "    return ([0] * 6 + [2] * 6 + [1] * 8 + [3] * 4 + [0] * 9)[n % 33]\n"
    )
    for seed in map(str, range(4)):
        assert points("lab4", tmp_path, counter, seed=seed).points == 0
    assert points("lab4", tmp_path, LAB4, seed="0").points == 20


def test_the_same_seed_asks_in_the_same_order(tmp_path):
    source = RIGHT.replace("    return", "    print(q11)\n    return")
    lab = find_lab("elbow", write_lab(tmp_path / "mylabs"))
    a, b, c = (
        grade(lab, Job(written(tmp_path / "my.py", source), seed=seed)).output
        for seed in ("a", "a", "b")
    )
    assert a == b != c


def killed(monkeypatch, moments):
    """Kill the workers' processes from outside: moments(k) says when the k-th worker dies, of start, load, ask."""
    made = []

    class Victim(worker.SandboxWorker):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            made.append(self)
            self.moment = moments(len(made))
            self._strike("start")

        def _strike(self, moment):
            if self.moment == moment:
                self.moment = None
                if self._first is None:
                    os.kill(self._process.pid, signal.SIGKILL)
                else:
                    signal.pidfd_send_signal(self._first, signal.SIGKILL)

        def send(self, data, limit):
            self._strike("load" if "source" in data else "ask")
            return super().send(data, limit)

    monkeypatch.setattr(worker, "SandboxWorker", Victim)
    return made


def test_a_worker_killed_from_outside_is_asked_again(tmp_path, monkeypatch, isolate):
    when = {1: "start", 2: "load", 3: "ask", 4: "ask"}
    made = killed(monkeypatch, when.get)
    report = points("lab1", tmp_path, LAB1, isolate=isolate)
    assert (report.points, report.trouble, len(made)) == (20, "", 5), [
        (c.title, c.text) for c in report.checks
    ]


def test_and_is_no_result_where_it_is_killed_again_and_again(tmp_path, monkeypatch):
    for moment in ("start", "load", "ask"):
        made = killed(monkeypatch, lambda k, moment=moment: moment)
        with pytest.raises(KilledError, match="killed its process 5 times"):
            points("lab1", tmp_path, LAB1)
        assert len(made) == worker.MOST_KILLED


def test_functions_of_a_session_whose_module_has_a_constants_name():
    scope = {}
    exec(
        without(LAB1, "m").replace("from math import", "import math as m\nfrom math import"), scope
    )
    report = check("lab1", **{name: scope[name] for name in ("dgm", "igm", "dgm_passive")})
    assert report.points == 20, [c.text for c in report.checks]
    assert json.loads(json.dumps(report.as_json()))["points"] == 20


CLASS = """
from math import cos, sin, sqrt, hypot, atan2
class Robot:
    def __init__(self):
        self.l11 = self.l12 = self.l21 = self.l22 = 0.09
        self.d = 0.118
    def elbow(self, base, l, q):
        return base + l * cos(q), l * sin(q)
    def dgm(self, q11, q21, assembly_mode):
        xl, yl = self.elbow(-self.d / 2, self.l11, q11)
        xr, yr = self.elbow(self.d / 2, self.l21, q21)
        D = hypot(xl - xr, yl - yr)
        ux, uy = (xl - xr) / D, (yl - yr) / D
        a = (D**2 + self.l22**2 - self.l12**2) / (2 * D)
        h = assembly_mode * sqrt(self.l22**2 - a**2)
        return xr + a * ux - h * uy, yr + a * uy + h * ux
class Unfinished:
    def __init__(self, which): pass
    def igm(self): pass
"""


def test_methods_of_a_class_are_functions_and_its_numbers_the_robots(tmp_path):
    found = points("lab1", tmp_path, CLASS)
    shares = {check.share for check in found.checks if check.function == "dgm"}
    assert shares == {1.0} and found.points == 7
    assert found.checks[5].text.startswith("is not defined: no function igm")


@pytest.mark.parametrize(
    "returned",
    [
        "{'x': x, 'y': y}.values()",
        "(part for part in (x, y))",
        "map(float, (x, y))",
        "zip((x,), (y,))",
        "(x + 0j, complex(y, 1e-19))",
        "reversed((y, x))",
    ],
)
def test_pairs_of_any_form_are_read(returned):
    source = f"def f(x, y):\n    return {returned}\ndef g(x): return iter(int, 1)\n"
    from fivebar.grading.judging.judge import judge

    pair = find_lab("lab1").exercises()["dgm"]
    rows = np.linspace(0, 0.5, 8), np.linspace(0, 0.3, 8), -np.ones(8)
    x, y = pair.answer(fb.FiveBar(), *rows)
    with Student(Submission("a.py", source)) as program:
        replies = program.ask("f", list(zip(x.tolist(), y.tolist())))
        assert program.ask("g", [(1,)])[0].kind in ("value", "flood")
    found = judge(pair, fb.FiveBar(), rows, replies)
    assert found.share == 1 or "zip" in returned and found.reason == "shape"


@pytest.mark.deep
@pytest.mark.parametrize(
    "lab, file",
    [
        ("amoro", "biglide_blocks"),
        pytest.param("amoro-biglide", "amoro_blocks", marks=pytest.mark.deep),
    ],
)
def test_the_other_robots_file_is_told(tmp_path, lab, file):
    source = (DATA / f"hand_ins/fresh/{file}.py").read_text("utf-8")
    other = "amoro" if lab == "amoro-biglide" else "amoro-biglide"
    told = f"This is the file of {other}, not of {lab}"
    assert points(lab, tmp_path, source).notes[0].startswith(told)
