"""A mistake is paid for once: where a function calls a wrong one, it is judged with the right one in its place."""

import math

import numpy as np
import pytest

from fivebar.grading import check
from fivebar.grading.grade import grade
from fivebar.grading.intake.program import Job
from fivebar.grading.judging.judge import Verdict, varies
from fivebar.grading.judging.with_right_ones import Helped, modelled, reached
from fivebar.grading.labs import Lab, find_lab
from fivebar.grading.worker.cell.stand_in import StandIn
from fivebar.grading.worker.student import Student
from fivebar.grading.worker.submission import Submission

from ..helpers.grading_lab import written
from ..helpers.lab_session import SOLUTIONS

EXERCISES = """
import numpy as np
from fivebar.grading import Exercise, Misconception

def reach(robot, q, s):
    return np.where(np.abs(q) < 3, robot.l11 * np.cos(q) + s, np.nan), s * np.sin(q)

def area(robot, q, s):
    x, y = reach(robot, q, s)
    return x * y

EXERCISES = [
    Exercise("reach(q, s) -> x, y", reach, wrong=(Misconception(
        "sine and cosine exchanged", "Try q = 0.", lambda robot, q, s: (robot.l11 * np.sin(q) + s, s * np.cos(q))),)),
    Exercise("area(q, s) -> a", area),
]
USES = {"area": ("reach",), "widest": ("reach",)}
"""
CHECKS = """
import pytest

def test_reach(ask, draw):
    "reach: anywhere"
    ask("reach", *draw.uniform(-1, 1, (2, 12)))

def test_area(ask, draw):
    "area: anywhere"
    ask("area", *draw.uniform(-1, 1, (2, 12)))

@pytest.mark.points(2)
def test_widest(ask, robot):
    "widest: of four"
    ask.verdict(float(abs(ask.call("widest", 0.5) - robot.l11 - 0.5) < 1e-9), "not the widest")
"""
HAND_IN = """
from math import cos, sin
l11 = 0.09
def reach(q, s, l=l11): return {reach}
def product(pair): return pair[0] * pair[1]
def area(q, s): return {area}
def widest(s): return max(reach(s=s, q=k * 0.1)[0] for k in range(4))
"""
RIGHT, WRONG = "[l * cos(q) + s, s * sin(q)]", "[l * sin(q) + s, s * cos(q)]"
NO_MODEL = "[l * 17, 2.0]"
AREA = "product(reach(q, s))"


@pytest.fixture
def lab(tmp_path):
    folder = tmp_path / "labs" / "two"
    folder.mkdir(parents=True)
    (folder / "exercises.py").write_text(EXERCISES, encoding="utf-8")
    (folder / "test_lab.py").write_text(CHECKS, encoding="utf-8")
    return Lab(folder)


TOLD = "judged with the right reach in place of your own, which is wrong"


def points_and_remarks(report):
    assert not report.faults
    return [c.points for c in report.checks], {
        remark for c in report.checks for remark in c.remarks if c.points
    }


@pytest.mark.parametrize(
    "reach, area, points",
    [(WRONG, AREA, [0, 1, 2]), (WRONG, f"2 * {AREA}", [0, 0, 2]), (NO_MODEL, AREA, [0, 0, 0])],
    ids=["right-but-for-the-called", "wrong-itself", "nothing-to-follow-from"],
)
def test_who_calls_a_wrong_function_is_judged_with_the_right_one(lab, reach, area, points):
    space = {}
    exec(HAND_IN.format(reach=reach, area=area), space)
    functions = {name: space[name] for name in ("reach", "area", "widest")}
    report = check("two", labs=lab.folder.parent, **functions)
    assert points_and_remarks(report) == (points, {TOLD} if any(points) else set())
    assert space["reach"] is functions["reach"]


def test_a_file_gets_the_points_that_its_session_gets(lab, tmp_path):
    report = grade(lab, Job(written(tmp_path / "my.py", HAND_IN.format(reach=WRONG, area=AREA))))
    assert points_and_remarks(report) == ([0, 1, 2], {TOLD})


@pytest.mark.parametrize(
    "reach",
    ["[l.cosine(q) + s, s * sin(q)]", "[l * cos(q) + s, s * sin(q)"],
    ids=["raises", "lost"],
)
def test_a_function_that_raises_costs_as_much_as_a_wrong_one(lab, tmp_path, reach):
    report = grade(lab, Job(written(tmp_path / "my.py", HAND_IN.format(reach=reach, area=AREA))))
    assert points_and_remarks(report) == ([0, 1, 2], {TOLD})


def test_from_what_is_still_to_be_written_nothing_follows(lab, tmp_path):
    source = HAND_IN.format(reach="None", area=AREA).replace(
        "return None", "raise NotImplementedError('task 1')"
    )
    report = grade(lab, Job(written(tmp_path / "my.py", source)))
    assert points_and_remarks(report) == ([0, 0, 0], set())


COLUMNS = (SOLUTIONS / "matrices/lab5.py").read_text("utf-8")
LAST = "np.linalg.solve(M, np.array([[tau1], [tau2]]) - c)"


@pytest.mark.every(3)
@pytest.mark.parametrize(
    "last",
    [LAST, "M.I * (np.matrix([[tau1], [tau2]]) - c)", "M[0] * tau1, c @ np.ones(2)"],
    ids=["columns", "matrices", "wrong-itself"],
)
def test_what_takes_columns_or_matrices_gets_them_from_the_right_one_of_a_function_that_raises(
    tmp_path, last
):
    source = COLUMNS.replace("np.hstack", "np.hstak").replace(LAST, last)
    report = grade(find_lab("lab5"), Job(written(tmp_path / "my.py", source)))
    lost = {check.function for check in report.checks if check.share < 1}
    assert lost == {"dynamic_model", *(["forward_dynamics"] if "@" in last else [])}


def test_a_mistake_has_one_name_beside_a_function_that_is_still_to_be_written(tmp_path):
    old = "return np.hstack([torques(*motion, 1, 0) - c, torques(*motion, 0, 1) - c]), c"
    assert old in COLUMNS
    source = COLUMNS.replace(old, "return np.eye(2), np.ones((2, 1))").replace(
        "[tau2]]) - c", "[tau2]]) + c"
    )
    report = grade(find_lab("lab5"), Job(written(tmp_path / "my.py", source)))
    found = [check for check in report.checks if check.function == "forward_dynamics"]
    assert {check.misconception for check in found} <= {"c of the wrong sign", "the sign of c"}
    assert any("your dynamic_model is wrong, too" in check.remarks for check in found)


@pytest.mark.deep
def test_one_element_that_is_always_0_is_a_model_with_a_mistake(tmp_path):
    old = "    return np.hstack([torques(*motion, 1, 0) - c, torques(*motion, 0, 1) - c]), c"
    new = "    M = np.hstack([torques(*motion, 1, 0) - c, torques(*motion, 0, 1) - c])\n    M[1, 0] = 0\n    return M, c"
    report = grade(find_lab("lab5"), Job(written(tmp_path / "my.py", COLUMNS.replace(old, new))))
    wrong = [check for check in report.checks if check.share < 1]
    assert {check.function for check in wrong} == {"dynamic_model"}
    assert not any("-M" in check.spot for check in wrong)  # (-M)[1, 0] = 0 changes no answer


FORMS = {
    "tuple": (lambda a, b: (a, b), (1.5, 2.5)),
    "column": (lambda a, b: np.array([[a], [b]]), np.array([[1.5], [2.5]])),
    "integers": (lambda a, b: np.array([0, 0]), np.array([1.5, 2.5])),
    "nested": (lambda a, b: [[a], (b,)], [[1.5], (2.5,)]),
    "another count": (lambda a, b: 7, (1.5, 2.5)),
    "no numbers": (lambda a, b: ("x", b), (1.5, 2.5)),
    "raises": (lambda a, b: 1 / 0, (1.5, 2.5)),
}


@pytest.mark.parametrize("own, wanted", FORMS.values(), ids=FORMS)
def test_the_right_numbers_come_in_the_form_of_ones_own(own, wanted):
    asked = []
    stand_in = StandIn(own, lambda row: asked.append(row) or [1.5, 2.5])
    for given in (stand_in(1, 2), stand_in(b=2, a=1), stand_in(1, b=2), stand_in(1, 2)):
        assert type(given) is type(wanted) and np.array_equal(given, wanted)
    assert asked == [[1, 2]] * 4
    with pytest.raises(TypeError, match="missing"):
        stand_in(1)


@pytest.mark.filterwarnings("ignore:the matrix subclass")
def test_where_there_is_no_answer_ones_own_function_refuses():
    with pytest.raises(ZeroDivisionError):
        StandIn(lambda a: 1 / a, lambda row: None)(0)
    matrix = StandIn(lambda a: np.matrix(np.eye(2)), lambda row: [[[1.0, 2.0], [3.0, 4.0]]])(0)
    assert isinstance(matrix, np.matrix) and matrix[1, 0] == 3.0


def test_arguments_that_are_no_number_have_no_right_answer():
    lab = find_lab("amoro")
    right = Helped(None, lab.exercises(), lab.robot())._right("dgm", lab.robot())
    assert right([0.1, 0.2, 1]) is not None
    assert right([0.1, 0.2, math.nan]) is None and right([math.nan, 0.2, 1]) is None


def test_arguments_that_are_lists_have_as_many_right_answers():
    lab = find_lab("amoro")
    right = Helped(None, lab.exercises(), lab.robot())._right("dgm", lab.robot())
    together = right([[0.1, 0.3], [0.2, -0.4], 1])
    for k, row in enumerate(([0.1, 0.2, 1], [0.3, -0.4, 1])):
        assert np.array(together)[..., k] == pytest.approx(np.array(right(row)), abs=1e-15)
    assert right([[0.1, 0.3], [0.2, 0.4, 0.5], 1]) is None and right([["x"], 0.2, 1]) is None


def test_who_calls_a_wrong_function_with_arrays_is_judged_with_the_right_one(lab, tmp_path):
    text = HAND_IN.replace("from math import", "from numpy import arange,")
    text = text.replace(
        "max(reach(s=s, q=k * 0.1)[0] for k in range(4))", "max(reach(arange(4) * 0.1, s)[0])"
    )
    report = grade(lab, Job(written(tmp_path / "my.py", text.format(reach=WRONG, area=AREA))))
    assert points_and_remarks(report) == ([0, 1, 2], {TOLD})


def test_what_a_function_may_call_is_what_it_mentions():
    source = (
        "def a(): return b()\ndef b(): return [c for _ in d]\nc = d = lambda x, y=1: 0\n"
        "f = lambda: a()\ndef g(): pass\n"
    )
    with Student(Submission("a.py", source)) as program:
        outline = program.outline
    assert reached(outline, "a") == {"b", "c", "d"}
    assert reached(outline, "f") == {"a", "b", "c", "d"}
    assert reached(outline, "g") == reached(outline, "none") == set()
    assert outline["c"][0] == ["x", "y"] and outline["a"][0] == []


def test_what_is_written_gives_other_answers_to_other_questions():
    draw = np.random.default_rng(3)
    right = draw.uniform(-1, 1, (16, 4))
    assert varies(draw.uniform(-1, 1, right.shape), right)
    assert not varies(np.where([True, True, True, False], right, 0.0), right)
    assert varies(np.where([True, True, True, False], right, 0.0), right * [1, 1, 1, 0])
    assert not varies(np.full(right.shape, np.nan), right)
    assert (
        not modelled(Verdict(0.0))
        and modelled(Verdict(0.1))
        and modelled(Verdict(0.0, varies=True))
    )
