"""The change that makes a function right: tried in the student's own process, told if it holds."""

import ast
import linecache
import os
import subprocess
import sys

import pytest

from fivebar.grading.grade import check, grade
from fivebar.grading.intake.program import Job
from fivebar.grading.labs import find_lab
from fivebar.grading.worker import places
from fivebar.grading.worker.wire import Garbled, told, whole
from tests.helpers.hand_ins import FOLDER, hand_ins
from tests.helpers.lab_session import SOLUTIONS

sys.path.insert(0, str(places.CELL))
from changes import WAVES, Trials, Variants  # noqa: E402

sys.path.remove(str(places.CELL))

FRAMES = (FOLDER / "fresh/amoro_frames.py").read_text("utf-8")


def listed(source, function):
    """The program with its list of changes, the likely ones first."""
    return Variants(ast.parse(source).body, function, [], [], WAVES[-1])


def outcomes(source, function, *row):
    """(kind, old, new) of the changes after which the function gives what the source below gives."""
    right, wrong, space = source[0], source[1], {}
    exec(right, space)
    wanted = space[function](*row)
    found = []
    variants, own = listed(wrong, function), {}
    exec(wrong, own)
    variants.install(own, [])
    for number, change in enumerate(variants.changes):
        variants.switch(own, [number])
        try:
            if own[function](*row) == pytest.approx(wanted, rel=1e-12):
                found.append(change.told[1:2] + change.told[3:])
        except Exception:  # noqa: S110  most changes make no sense
            pass
    return found


TRIED = {
    "a sign": ("return a - b * l", "return a + b * l"),
    "a square": ("return a**2 + l", "return a * 2 + l"),
    "a bracket": ("return a / (2 * b)", "return a / 2 * b"),
    "a function": ("return l * sin(a) + b", "return l * cos(a) + b"),
    "a number": ("return 6 * a + b", "return 5 * a + b"),
    "a variable": (
        "q11, q21 = a, b\n    return q11 + 3 * q21",
        "q11, q21 = a, b\n    return q11 + 3 * q11",
    ),
    "a whole number": (
        "c = array([0.0, 0])\n    c[1] = a * b\n    return c[1]",
        "c = array([0, 0])\n    c[1] = a * b\n    return c[1]",
    ),
    "an index": ("p = [a, b]\n    return p[1] * l", "p = [a, b]\n    return p[0] * l"),
    "the order": ("return atan2(a, b)", "return atan2(b, a)"),
    "a product": ("return a * cos(b) - b * sin(a)", "return a * sin(a) + b * cos(b)"),
    "steps": ("return sum(a**k for k in range(200))", "return sum(a**k for k in range(7))"),
    "a typed number": ("return l * a + l / 2 * b", "return 0.09 * a + 0.045 * b"),
}
HEAD = """from math import atan2, cos, sin, sqrt
from numpy import array, ones
from numpy.linalg import inv
l = 0.09


def A(a, b):
    return array([[1.0, a], [a * b, 3.0]])


def f(a, b):
    """


@pytest.mark.parametrize(("right", "wrong"), TRIED.values(), ids=TRIED)
def test_each_kind_of_slip_is_undone_by_a_change(right, wrong, request):
    found = outcomes((HEAD + right, HEAD + wrong), "f", 0.37, 0.61)
    kind = request.node.callspec.id
    assert kind in {told[0] for told in found}, found


HELPERS = {
    "another argument": ("g(a) + b", "a term", "a", "b + a"),
    "an angle in degrees": ("radians(a) * b", "a function", "radians(a)", "a"),
    "digits cut off": ("round(a, 1) * b", "a function", "round(a, 1)", "a"),
    "a conjugate": (
        "(complex(a, 2) * complex(1, b)).real",
        "a conjugate",
        "(complex(a, 2) * complex(1, b)).real",
        "(complex(a, 2).conjugate() * complex(1, b)).real",
    ),
}


@pytest.mark.parametrize(("wrong", "kind", "old", "new"), HELPERS.values(), ids=HELPERS)
def test_a_slip_in_a_helper_of_two_numbers_is_undone(wrong, kind, old, new):
    head = "from math import cos, radians\ndef g(a): return cos(a)\ndef f(x, y): return h(x, y)\n"
    right = wrong.replace("g(a)", "g(b + a)") if old == "a" else wrong.replace(old, new)
    sources = [f"{head}def h(a, b): return {formula}\n" for formula in (right, wrong)]
    assert (kind, old, new) in outcomes(sources, "f", 0.37, 0.61)


def test_a_call_gets_its_arguments_in_the_order_of_their_names():
    source = "def g(a, b, c, d, e): return a - b * c + d / e\ndef f(a, b, c, d, e): return g(a, b, c, d, e)\n"
    wrong = source.replace("return g(a, b, c, d, e)", "return g(e, c, b, a, d)")
    found = outcomes((source, wrong), "f", 0.3, 0.7, 1.1, 0.2, 0.9)
    assert ("the order", "g(e, c, b, a, d)", "g(a, b, c, d, e)") in found


def test_signs_of_the_function_itself_come_before_those_in_what_it_calls():
    source = "def g(a):\n    return -(a + a**2 + a**3)\ndef f(a):\n    return 1 - g(a)\n"
    told = [
        change.told for change in Variants(ast.parse(source).body, "f", [], [], WAVES[-1]).changes
    ]
    signs = [function for _, kind, function, *_ in told if kind == "a sign"]
    assert signs[0] == "f" and "g" in signs


LAB_2 = """import numpy as np
l11 = l12 = l21 = l22 = 0.09
d = 0.118
def unit(a):
    return np.array([np.cos(a), np.sin(a)])
def distal(a, b):
    return unit(a + b)
def turn(u):
    return np.array([-u[1], u[0]])
def A(q11, q12, q21, q22):
    return np.array([distal(q11, q12), distal(q21, q22)])
def B(q11, q12, q21, q22):
    return np.diag([l11 * turn(unit(q11)) @ distal(q11, q12), l21 * turn(unit(q21)) @ distal(q21, q22)])
def dkm(q11, q12, q21, q22, q11D, q21D):
    if abs(np.sin(q11 + q12 - q21 - q22)) < 1e-9:
        raise ZeroDivisionError
    return np.linalg.inv(A(q11, q12, q21, q22)) @ B(q11, q12, q21, q22) @ [q11D, q21D]
def ikm(q11, q12, q21, q22, xD, yD):
    if min(abs(np.sin([q12, q22]))) < 1e-9:
        raise ZeroDivisionError
    return np.linalg.solve(B(q11, q12, q21, q22), A(q11, q12, q21, q22) @ [xD, yD])
def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    v = [xD, yD]
    a = turn(distal(q11, q12)) @ (v - l11 * q11D * turn(unit(q11))) / l12 - q11D
    b = turn(distal(q21, q22)) @ (v - l21 * q21D * turn(unit(q21))) / l22 - q21D
    return a, b
"""


@pytest.mark.every(3)
@pytest.mark.parametrize(
    ("old", "new", "spot"),
    [
        ("unit(a + b)", "unit(b)", "line 7: b: right answers come with a + b"),
        (
            "[np.cos(a), np.sin(a)]",
            "[np.cos(a := np.deg2rad(a)), np.sin(a)]",
            "line 5: np.deg2rad(a): right answers come with a",
        ),
    ],
)
def test_a_slip_in_a_helper_of_all_functions_is_paid_for_by_the_first(tmp_path, old, new, spot):
    path = tmp_path / "my.py"
    path.write_text(LAB_2.replace(old, new), "utf-8")
    found = grade(find_lab("lab2"), Job(path, seed="mends"))
    wrong = [check for check in found.checks if check.share < 1]
    assert found.points == 18 and {check.function for check in wrong} == {"A"}
    assert {check.spot for check in wrong} == {spot}


def test_what_refused_rightly_does_so_after_a_change(tmp_path):
    """With the cosine for the sine in the condition, nothing is refused any more."""
    path = tmp_path / "my.py"
    path.write_text(LAB_2.replace("[q12, q22]))) < 1e-9", "[q12, q22]))) < 1e-6"), "utf-8")
    found = grade(find_lab("lab2"), Job(path, seed="mends"))
    (wrong,) = (check for check in found.checks if check.share < 1)
    assert wrong.function == "ikm" and "cos" not in wrong.spot


def test_the_last_term_of_a_sum_is_taken_out_of_its_product():
    right = "def f(a, b):\n    return a * (b - 2) + 3\n"
    found = outcomes((right, "def f(a, b):\n    return a * (b - 2 + 3)\n"), "f", 0.3, 0.7)
    assert ("a bracket", "a * (b - 2 + 3)", "a * (b - 2) + 3") in found


def test_a_change_in_two_places_comes_before_one_in_four():
    source = "def f(q11, q21):\n    return q11 * q11 * q11 + q21 * q11\n"
    places = [len(change.members) for change in listed(source, "f").changes]
    assert max(places) > 2
    assert min(k for k, count in enumerate(places) if count > 2) > places.index(2)


def test_a_change_is_made_in_both_legs_alike():
    wrong = FRAMES.replace("u1 = rot(q11 + q12)", "u1 = rot(q11 - q12)")
    wrong = wrong.replace("u2 = rot(q21 + q22)", "u2 = rot(q21 - q22)")
    variants = listed(wrong, "rows")
    made = [
        ast.unparse(ast.Module(variants.changed([number])[0], []))
        for number, change in enumerate(variants.changes)
        if change.told[3:] == ("q11 - q12", "q11 + q12, in 2 formulas")
    ]
    assert any("rot(q11 + q12)" in source and "rot(q21 + q22)" in source for source in made)


def test_a_loop_that_a_change_makes_endless_ends():
    source = "def f(a):\n    while a > 3:\n        a = a - 6\n    return a\n"
    found = outcomes((source, source.replace("a > 3", "a < 3")), "f", 10.0)
    assert ("a comparison", "a < 3", "a > 3") in found


def test_a_second_change_is_in_the_line_of_the_first():
    source = "\n\ndef f(a, b):\n    return (a + b**2 - b**2)\n"
    first = listed(source, "f")
    numbers = [k for k, c in enumerate(first.changes) if c.told[4] == "a + (b ** 2 - b ** 2)"]
    [body] = first.changed(numbers)[0]
    lines = {getattr(part, "lineno", 4) for part in ast.walk(body)}
    assert lines == {3, 4}


def test_what_reads_alike_but_for_a_sign_is_changed_at_once():
    """The bases of the legs are at -d/2 and d/2."""
    right = "def f(a):\n    b = pow(a + 3, 2)\n    c = pow(a - 3, 2)\n    return b + 10 * c\n"
    wrong = right.replace("(a + 3, 2)", "(2, a + 3)").replace("(a - 3, 2)", "(2, a - 3)")
    found = outcomes((right, wrong), "f", 0.4)
    assert ("the order", "pow(2, a + 3)", "pow(a + 3, 2), in 2 formulas") in found


def test_two_numbers_of_a_file_are_exchanged_in_one_part_of_a_list():
    right = "m = 2.0\nk = 3.0\n\n\ndef f(a):\n    return [m + k * a, m + k * a**2]\n"
    wrong = right.replace("m + k * a**2", "k + m * a**2")
    found = outcomes((right, wrong), "f", 0.4)
    assert ("a variable", "k + m * a ** 2", "m + k * a ** 2") in found


def test_a_name_given_to_an_argument_of_that_name_is_the_last_to_be_wrong():
    source = "def g(q21):\n    return q21\n\n\ndef f(q21, q22):\n    return g(q21) * g(q22)\n"
    changes = Variants(ast.parse(source).body, "f", [], [], WAVES[-1]).changes
    told = [change.told[3:] for change in changes if change.told[2] == "f"]
    assert told.index(("q22", "q21")) < told.index(("q21", "q22"))


def test_the_sign_of_a_term_comes_before_one_in_it():
    body = ast.parse("def f(a, b):\n    return a * pow(b, 3) + 1\n").body
    told = [change.told[3:] for change in Variants(body, "f", [], [], WAVES[-1]).changes]
    inside, whole = ("b", "-b"), ("a * pow(b, 3)", "-(a * pow(b, 3))")
    assert told.index(whole) < told.index(inside)


def test_a_change_has_the_same_number_in_every_process():
    """A set of texts has another order in each process."""
    path = places.CELL
    lines = f"""import ast, sys
sys.path.insert(0, {str(path)!r})
from changes import WAVES, Variants
body = ast.parse(sys.stdin.read()).body
for change in Variants(body, "dkm2", [], [], WAVES[-1]).changes:
    print(*change.told, len(change.members))
"""
    found = set()
    for seed in "12":
        run = subprocess.run(
            [sys.executable, "-c", lines],
            input=FRAMES,
            env=os.environ | {"PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        )
        found.add(run.stdout)
    assert len(found) == 1 and found.pop().count("\n") > 100


def test_a_second_change_is_made_in_what_the_first_one_left():
    wrong = "def f(a, b):\n    return a * 2 + b\n"
    trials = Trials(ast.parse(wrong).body)
    request = {"function": "f", "apart": [], "wave": 2, "made": [], "watched": False}
    signs = [
        k for k, change in enumerate(trials.of(request).changes) if change.told[4] == "a * 2 - b"
    ]
    second = trials.of(request | {"made": [["f", 2, signs[:1]]]})
    own = {}
    exec(wrong, own)
    second.install(own, [])
    squares = [k for k, change in enumerate(second.changes) if change.told[4] == "a ** 2"]
    second.switch(own, squares[:1])
    assert own["f"](0.4, 0.7) == pytest.approx(0.4**2 - 0.7)


def test_a_method_and_a_lambda_are_changed_too():
    source = "class R:\n    def f(self, a):\n        return a + 1\ng = lambda a: a + 1\n"
    for name in ("f", "g"):
        told = [change.told for change in listed(source, name).changes]
        assert any(old == "a + 1" and new == "a - 1" for *_, old, new in told)


ARRAYS = """from numpy import array
y = array([{y}])
R = array([[0.0, -1.0], [1.0, 0.0]])
w = R @ y
old = array([1.0, 2.0])
old *= 2
kept = array([3.0, 4.0])
twice = array([1.0])
twice = array([2.0])
table = array([{table}])
def f(a, b):
    return w @ [a, b]
def g(a, b):
    kept[0] = a
    return old[0] + kept @ [a, b] + twice[0] + table[0]
""".replace("{table}", ", ".join(["0.5"] * 200))


def test_an_array_of_the_file_is_changed_and_what_is_computed_from_it():
    right, wrong = ARRAYS.format(y="0.0, 1.0"), ARRAYS.format(y="1.0, 0.0")
    found = outcomes((right, wrong), "f", 0.3, 0.7)
    assert ("the order", "[1.0, 0.0]", "[0.0, 1.0]") in found
    # What a program changes itself stays as it is, and so do data.
    inside = {change.told[2] for change in listed(wrong, "g").changes}
    assert inside == {"g"}


def test_an_array_that_cannot_be_made_stays_as_it_is():
    space = {}
    exec(ARRAYS.format(y="1.0, 0.0"), space)
    variants = listed(ARRAYS.format(y="1.0, 0.0"), "f")
    variants.install(space, [])
    del space["array"]
    variants.switch(space, [])
    assert space["f"](0.3, 0.7) == pytest.approx(0.7)


@pytest.mark.deep
def test_a_slip_in_a_vector_of_the_file_is_paid_for_once(tmp_path):
    old = "S = np.array([[0.0, -1.0], [1.0, 0.0]])"
    assert old in FRAMES
    path = tmp_path / "five_bar_models.py"
    path.write_text(FRAMES.replace(old, "S = np.array([[0.0, 1.0], [-1.0, 0.0]])"), "utf-8")
    graded = grade(find_lab("amoro"), Job(path, seed="mends"))
    wrong = [check for check in graded.checks if check.share < 1]
    assert len({check.function for check in wrong}) == 1
    assert all("line 10: np.array([[0.0, 1.0], [-1.0, 0.0]])" in check.spot for check in wrong)


def test_a_source_without_the_function_has_no_changes():
    assert not listed("x = 1", "f").changes


@pytest.mark.parametrize("data", [None, -1, 2.0, True, "3", 10**7])
def test_what_is_no_count_is_refused(data):
    with pytest.raises(Garbled):
        whole(data)


@pytest.mark.parametrize(
    "data", [None, [1], [[1, "a"]], [["1", "a", "f", "x", "y"]], [[1, 2, 3, 4, 5]]]
)
def test_what_is_no_list_of_changes_is_refused(data):
    with pytest.raises(Garbled):
        told(data)


def report(tmp_path, title, file="fresh/third.txt"):
    (case,) = (c for c in hand_ins(file) if c.title == title)
    path = tmp_path / "my.py"
    path.write_text(case.source, "utf-8")
    return grade(find_lab(case.lab), Job(path, seed="mends"))


@pytest.mark.deep
def test_a_slip_in_a_helper_is_told_once_and_the_others_keep_their_points(tmp_path):
    found = report(tmp_path, "speed not squared")
    wrong = [check for check in found.checks if check.share < 1]
    assert found.points == 18 and {check.function for check in wrong} == {"ikm2"}
    assert {check.misconception for check in wrong} == {
        "a bracket in the wrong place, in your squares"
    }
    assert all("(l * (q11D + q12D)) ** 2" in check.spot for check in wrong)


@pytest.mark.deep
def test_a_helper_of_lab_8_is_paid_for_once(tmp_path):
    assert report(tmp_path, "offset taken off").points == 17


@pytest.mark.deep
def test_two_slips_in_one_function_are_told_together(tmp_path):
    path = tmp_path / "my.py"
    wrong = FRAMES.replace("(v - J1[:, 0] * q11D) / l", "(v - J1[:, 0] * q11D)")
    wrong = wrong.replace("(v - J2[:, 0] * q21D) / l", "(v + J2[:, 0] * q21D) / l")
    path.write_text(wrong, "utf-8")
    found = grade(find_lab("amoro"), Job(path, seed="mends"))
    checks = [check for check in found.checks if check.function == "dkm_passive"]
    (name,) = {check.misconception for check in checks}
    assert found.points == 18
    assert (
        name == "division by l forgotten in the left passive joint's answer; and the sign of q21D"
    )
    (spot,) = {check.spot for check in checks}
    assert (
        spot.count("right answers come with") == 2
        and "line 101: q21D: right answers come with -q21D" in spot
    )


@pytest.mark.deep
@pytest.mark.parametrize(
    ("lab", "replaced", "name"),
    [
        (
            "lab3",
            ("(q1D + q2D) ** 2", "(q1D - q2D) ** 2", "elbow = -l1", "elbow = l1"),
            "a wrong sign in the rate of the distal bar, in your bias;"
            " and the sign of the centripetal term of the proximal bar, in your bias",
        ),
        (
            "lab8",
            ("J[i, 2 * i + 1] = -1", "J[i, 2 * i + 1] = 1", "-ux / 2", "-ux"),
            "a wrong sign; and division by 2 forgotten",
        ),
    ],
)
def test_two_slips_that_spoil_the_same_numbers_are_told_together(lab, replaced, name, tmp_path):
    source = (SOLUTIONS / f"{lab}.py").read_text("utf-8")
    for old, new in zip(replaced[::2], replaced[1::2]):
        assert old in source
        source = source.replace(old, new, 1)
    path = tmp_path / "my.py"
    path.write_text(source, "utf-8")
    found = grade(find_lab(lab), Job(path, seed="mends"))
    told = {check.misconception for check in found.checks if check.share < 1}
    assert told == {name}


@pytest.mark.deep
def test_who_pays_for_a_named_mistake_pays_for_its_helper(tmp_path):
    """No change of the helper is found, as another elbow on a circle leads to the same point."""
    source = (FOLDER / "fresh/lab1_cosines.py").read_text("utf-8")
    path = tmp_path / "my.py"
    helper = "def elbow(q11):\n    return l11 * cos(q11), l11 * sin(q11)\n\n\ndef dgm("
    source = source.replace("def dgm(", helper, 1)
    source = source.replace(
        "    xa = -d / 2 + l11 * cos(q11)\n    ya = l11 * sin(q11)\n", "    xa, ya = elbow(q11)\n"
    )
    source = source.replace(
        "atan2(y - l11 * sin(q11), x + d / 2 - l11 * cos(q11))",
        "atan2(y - elbow(q11)[1], x - elbow(q11)[0])",
    )
    path.write_text(source, "utf-8")
    found = grade(find_lab("lab1"), Job(path, seed="mends"))
    assert {check.function for check in found.checks if check.share < 1} == {"dgm"}


@pytest.mark.deep
def test_both_elements_beside_the_diagonal_are_missed(tmp_path):
    source = (SOLUTIONS / "lab6.py").read_text("utf-8")
    path = tmp_path / "my.py"
    wrong = source.replace(" + M[0][1] * a2", "").replace("M[1][0] * a1 + ", "")
    path.write_text(wrong, "utf-8")
    found = grade(find_lab("lab6"), Job(path, seed="mends"))
    told = {check.misconception for check in found.checks if check.share < 1}
    assert told == {"a1 * M[0][1] forgotten; and a2 * M[0][1] forgotten"}


@pytest.mark.deep
def test_a_session_is_told_the_same_as_a_file(monkeypatch):
    source = (FOLDER / "fresh/lab1.py").read_text("utf-8")
    source = source.replace("D = np.linalg.norm(PQ)", "D = np.linalg.norm(PQ) ** 2")
    lines = source.splitlines(keepends=True)
    monkeypatch.setitem(linecache.cache, "<cell 1>", (len(source), None, lines, "<cell 1>"))
    space = {"__name__": "__main__"}
    exec(compile(source, "<cell 1>", "exec"), space)
    functions = {name: space[name] for name in ("dgm", "igm", "dgm_passive")}
    found = check("lab1", **functions)
    spots = {c.spot for c in found.checks if c.function == "dgm" and c.share < 1}
    assert spots == {"line 5 of dgm: 2: right answers come with 1"}


def test_a_session_whose_source_is_not_to_be_had_is_told_no_change():
    space = {"__name__": "__main__"}
    exec("def dgm(q11, q21, assembly_mode):\n    return q11 * q21, q11 + q21\n", space)
    found = check("lab1", dgm=space["dgm"])
    assert found.points == 0 and not any(c.spot for c in found.checks)
