"""The values that a formula needs so that a function is right, and a formula of them."""

import ast
import math
import re
import sys
from itertools import chain

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fivebar.grading.advice.formulas import OLD, Values, long_formulas, short_formulas
from fivebar.grading.advice.needed_values import Place
from fivebar.grading.advice.search import _size
from fivebar.grading.advice.values_beside import known_values
from fivebar.grading.grade import grade
from fivebar.grading.intake.program import Job
from fivebar.grading.labs import find_lab
from fivebar.grading.worker import places
from fivebar.grading.worker.wire import MOST_BESIDE, Change, Garbled, beside_of, visits_of
from tests.helpers.hand_ins import FOLDER

sys.path.insert(0, str(places.CELL))
from changes import Trials  # noqa: E402
from watched import flat  # noqa: E402

sys.path.remove(str(places.CELL))

FRAMES = (FOLDER / "fresh/amoro_frames.py").read_text("utf-8")
NAMES = "a", "b", "w", "l"


def samples(seed, n=8):
    """Values of some names, none of them near 0, and l the same in all samples."""
    draw = np.random.default_rng(seed)
    found = {name: draw.uniform(0.3, 1.4, n) * draw.choice([-1, 1], n) for name in "abw"}
    return found | {"l": np.full(n, 0.237)}


def formulas(values):
    """All formulas, short ones first."""
    return chain(short_formulas(values), long_formulas(values))


def worth(text, known, old):
    """The value of a formula in all samples, one after the other."""
    columns = zip(old, *known.values())
    scopes = [dict(zip((OLD, *known), row)) for row in columns]
    return np.array([eval(text, {"abs": abs}, scope) for scope in scopes])


NEEDED = {
    "a sign": ("a*b", "-a*b"),
    "a factor": ("a*b", "a*b/2"),
    "a square": ("a*w", "(a*w)**2"),
    "a root": ("a*a", "abs(a)"),
    "a variable": ("a*b", "w"),
    "a number": ("a*b", "0*a + 3"),
    "a factor of another name": ("a*b", "a*b*l"),
    "a factor of two": ("a*b", "a*b*w/l"),
    "a term": ("a*b", "a*b + w"),
    "a term of two": ("a*b", "a*b - 2*w*l"),
    "a term of a square": ("a*b", "a*b - l*w**2"),
    "a quotient": ("a*b", "w*a/l/2"),
    "a hypotenuse": ("a*b", "abs(a*b + 1j*w)"),
}


@pytest.mark.parametrize(("old", "wanted"), NEEDED.values(), ids=NEEDED)
def test_what_is_needed_is_found_and_is_so_in_other_samples(old, wanted):
    here, elsewhere = samples(1), samples(2)
    values = Values(worth(old, here, here["a"]), worth(wanted, here, here["a"]), here)
    _, text = next(formulas(values))
    before = worth(old, elsewhere, elsewhere["a"])
    assert worth(text, elsewhere, before) == pytest.approx(worth(wanted, elsewhere, before))


@settings(max_examples=30, deadline=None)
@given(
    st.sampled_from(["a", "b", "w", "a*b", "l*w", "b/w", "w**2"]),
    st.sampled_from([1, -1, 2, -2, 0.5, -0.25, 1.5]),
    st.sampled_from(["+", "*"]),
)
def test_a_forgotten_term_or_factor_is_found(term, factor, operator):
    here, elsewhere = samples(3), samples(4)
    wanted = f"{OLD} {operator} {factor}*({term})"
    old, before = (worth("a*a*b", known, known["a"]) for known in (here, elsewhere))
    _, text = next(formulas(Values(old, worth(wanted, here, old), here)))
    assert worth(text, elsewhere, before) == pytest.approx(worth(wanted, elsewhere, before))


def test_what_no_formula_of_few_names_gives_is_not_guessed():
    here = samples(5)
    wanted = np.exp(here["a"]) + np.sin(3 * here["b"]) * here["w"] ** 3
    assert not [*formulas(Values(here["a"] * here["b"], wanted, here))]


def test_an_angle_may_differ_by_whole_turns():
    here = samples(6)
    values = Values(here["a"], here["a"] + np.pi - 2 * np.pi * (here["b"] > 0), here, turns=True)
    assert next(formulas(values)) == ("a term", f"{OLD} + __import__('math').pi")


def test_products_of_matrices_are_known_beside_one():
    draw = np.random.default_rng(8)
    visits = [
        {"AD": draw.normal(size=4).tolist(), "J": draw.normal(size=4).tolist(), OLD: [0.0] * 4}
        for _ in range(3)
    ]
    known = known_values(visits, 4)
    right = [np.reshape(v["AD"], (2, 2)) @ np.reshape(v["J"], (2, 2)) for v in visits]
    assert known["(AD @ J)"] == pytest.approx(np.ravel(right))


def test_a_name_comes_before_a_number_that_it_may_have():
    here = samples(11) | {"m": np.full(8, 3.0), "n": np.full(8, 1.0)}
    assert next(formulas(Values(here["m"], here["n"], here))) == ("a variable", "n")


def test_where_nothing_can_be_divided_by_products_are_looked_for_all_the_same():
    known = {"q11D": samples(5)["a"]}
    values = Values(samples(5)["b"], samples(5)["w"], known)
    assert list(long_formulas(values)) == []
    assert list(long_formulas(Values(values.old, values.wanted, {}))) == []


def test_nobody_forgets_to_divide_by_a_rate():
    here = samples(12)
    values = Values(here["a"], here["a"] / here["w"], {"wD": here["w"]})
    assert not [*formulas(values)]
    assert next(formulas(Values(values.old, values.wanted, {"w": here["w"]})))[0] == "a factor"


def test_a_term_of_four_factors_is_found():
    here, elsewhere = samples(9), samples(10)
    for known in (here, elsewhere):
        known["__import__('math').cos(a)"] = np.cos(known["a"])
    old, before = here["w"], elsewhere["w"]
    new = old - here["l"] * here["b"] ** 2 * np.cos(here["a"])
    texts = [text for _, text in formulas(Values(old, new, here))]
    assert texts and all("cos(a)" in text for text in texts)
    right = before - elsewhere["l"] * elsewhere["b"] ** 2 * np.cos(elsewhere["a"])
    assert worth(texts[0], elsewhere, before) == pytest.approx(right)


def test_a_product_with_the_square_of_a_sum_of_rates_is_found():
    draw = np.random.default_rng(13)
    known = {name: draw.uniform(0.3, 1.4, 8) for name in ("xD", "yD", "qD", "pD")}
    known |= {"l": np.full(8, 0.237), "(qD + pD)": known["qD"] + known["pD"]}
    right = known["l"] ** 2 * known["(qD + pD)"] ** 2
    found = [text for _, text in formulas(Values(known["xD"], right, known))]
    assert found[0] == "l**2*(qD + pD)**2"


def test_a_matrix_may_need_a_number_for_a_factor_but_no_other_matrix():
    draw = np.random.default_rng(15)
    known = {name: draw.uniform(0.3, 1.4, 12) for name in ("J", "(J.T @ A)")}
    known["m"] = np.repeat(draw.uniform(0.3, 1.4, 3), 4)
    old = draw.uniform(0.3, 1.4, 12)
    right = Values(old, known["m"] * known["(J.T @ A)"], known, size=4)
    assert [*formulas(right)] == [("a formula", "(J.T @ A)*m")]
    by_elements = Values(old, known["J"] * known["(J.T @ A)"], known, size=4)
    assert not [*long_formulas(by_elements)]


SOURCE = """
from math import cos, sin
l = 0.3
def bar(q):
    return l * cos(q)
def f(q11, q21):
    b1 = bar(q11) * 2
    b2 = bar(q21) * 2
    c = [l * cos(q11), l * sin(q11)]
    return b1, b2 + c[1]
"""


def watched(source=SOURCE, function="f"):
    """The groups of places of a program, by what stands there, and a function to call it."""
    request = {"function": function, "apart": [], "made": [], "watched": True, "wave": None}
    program = Trials(ast.parse(source).body).of(request)
    space = {}
    exec(source, space)
    program.install(space, [])

    def called(numbers, *row):
        program.switch(space, numbers)
        return space[function](*row), [*program.seen(space).values()]

    words = program.told([[-1]])["changes"]
    groups = {
        (word[3], len(group)): k for k, (word, group) in enumerate(zip(words, program.groups))
    }
    return program, groups, called


def test_a_place_shows_its_visits_and_takes_other_values():
    _, groups, called = watched()
    place = groups["l * cos(q)", 1]
    plain, (seen,) = called([-1], 0.4, 0.7)
    assert dict(map(tuple, seen))[place] == [[0.3 * math.cos(0.4)], [0.3 * math.cos(0.7)]]
    other, _ = called([None, [place, [[1.0], [2.0]]]], 0.4, 0.7)
    assert other == pytest.approx((2.0, plain[1] - 2 * 0.3 * math.cos(0.7) + 4.0))


def test_an_array_that_holds_no_number_is_not_told():
    assert flat(np.array([0.5, 2.0])) == [0.5, 2.0]
    assert flat(np.array([0.5, np.nan])) is None and flat(np.array([np.inf])) is None


@pytest.mark.filterwarnings("ignore:the matrix subclass:PendingDeprecationWarning")
def test_a_matrix_shows_its_numbers_and_takes_others_as_a_matrix():
    source = (
        "import numpy as np\ndef f(a):\n    R = np.matrix([[0, -a], [a, 0]])\n    return R * R\n"
    )
    _, groups, called = watched(source)
    place = groups["np.matrix([[0, -a], [a, 0]])", 1]
    _, (seen,) = called([-1], 2.0)
    assert dict(map(tuple, seen))[place] == [[0.0, -2.0, 2.0, 0.0]]
    other, _ = called([None, [place, [[1.0, 1.0, 0.0, 1.0]]]], 2.0)
    assert other.tolist() == [[1.0, 2.0], [0.0, 1.0]]


def test_places_of_both_legs_are_one_group_with_the_names_of_the_first():
    _, groups, called = watched()
    pair = groups["bar(q11) * 2", 2]
    (b1, b2), (seen,) = called([pair, [pair, [[1.0], [2.0]]]], 0.4, 0.7)
    assert (b1, b2) == pytest.approx((1.0, 2.0 + 0.3 * math.sin(0.4)))
    first, second = (dict(map(tuple, visit)) for visit in seen)
    assert first["q11"] == [0.4] and second["q11"] == [0.7] and second["l"] == [0.3]
    assert second["__old__"] == [2 * 0.3 * math.cos(0.7)]


def test_what_is_written_for_one_leg_is_written_for_the_other_with_its_names():
    program, groups, _ = watched()
    body, words = program.changed([[groups["bar(q11) * 2", 2], "a term", f"{OLD} + q11"]])
    text = ast.unparse(ast.Module(body, []))
    assert "b1 = bar(q11) * 2 + q11" in text and "b2 = bar(q21) * 2 + q21" in text
    assert words == [[7, "a term", "f", "bar(q11) * 2", "bar(q11) * 2 + q11, in 2 formulas"]]


def test_what_a_function_computes_and_never_reads_is_told_and_comes_first():
    source = "def f(a, b):\n    c = a * b\n    e = c + 1\n    return e - a\n"
    program, _, _ = watched(source.replace("e - a", "a"))
    words = program.told([[-1]])["changes"]
    assert {(word[2], word[4]) for word in words} == {("f", "e")}
    assert program.told([[None]])["changes"] == []
    place = Place(0, Change(4, "", "f", "a", "e"), np.array([True]), False)
    long, short = _size((place, "a term", f"{OLD} + e*a")), _size((place, "a term", f"{OLD} + a"))
    assert long < short


def test_objects_made_before_are_of_the_class_that_is_watched():
    source = "class Leg:\n    def put(self, q):\n        self.q = q * 2\nleg = Leg()\n"
    source += "def f(q):\n    leg.put(q)\n    return leg.q\n"
    _, groups, called = watched(source)
    assert called([None, [groups["q * 2", 1], [[7.0]]]], 0.4)[0] == 7.0


@pytest.mark.parametrize(
    "data",
    [None, 3, [3], [[1]], [["a", [[1.0]]]], [[1, [1.0]]], [[1, [["x"]]]], [[1, [[math.inf]]]]],
)
def test_visits_that_are_none_are_refused(data):
    with pytest.raises(Garbled):
        visits_of(data)
    assert visits_of([[3, [[1.0], [2.0]]]]) == {3: [[1.0], [2.0]]}


@pytest.mark.parametrize(
    "data",
    [None, 3, [3], [[1]], [[[1, [1.0]]]], [[["a", 1.0]]], [[["a", [True]]]], [[["a", [1.0], 2]]]],
)
def test_values_that_are_none_are_refused(data):
    with pytest.raises(Garbled):
        beside_of(data)
    assert beside_of([[["a", [1.0]]], []]) == [{"a": [1.0]}, {}]


def test_a_program_that_tells_endless_values_is_refused():
    with pytest.raises(Garbled):
        beside_of([[[f"a{k}", [1.0]] for k in range(MOST_BESIDE + 1)]])


def graded(tmp_path, old, new):
    assert old in FRAMES
    path = tmp_path / "my.py"
    path.write_text(FRAMES.replace(old, new), "utf-8")
    return grade(find_lab("amoro"), Job(path, seed="needed"))


SLIPS = {
    "a corner of the triangle": (
        "alpha = np.arccos(n / (2 * l))",
        "alpha = np.arccos((2 * l**2 - n**2) / (2 * l**2))",
        r".*(formula|factor).*",
        r"right answers come with .*n",
    )
}


@pytest.mark.deep
@pytest.mark.parametrize(("old", "new", "name", "spot"), SLIPS.values(), ids=SLIPS)
def test_what_is_needed_is_told_of_a_hand_in(old, new, name, spot, tmp_path):
    report = graded(tmp_path, old, new)
    wrong = [check for check in report.checks if check.share < 1]
    assert report.points >= 18 and len({check.function for check in wrong}) == 1
    for check in wrong:
        assert re.fullmatch(name, check.misconception) and re.search(spot, check.spot)
