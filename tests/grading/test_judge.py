"""The judge: what real files return is read, what is wrong is named, and nothing else is diagnosed."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.grading import Exercise, Misconception, Reply, judge
from fivebar.grading.judging.judge import came_text
from fivebar.grading.labs import find_lab
from fivebar.grading.worker.replies import KINDS

Q = np.random.default_rng(1).uniform(-0.5, 0.5, (2, 12))
MODES = np.tile([1, -1], 6)


def dgm(robot, q11, q21, assembly_mode):
    return tuple(
        fb.dgm(robot, np.stack([q11, q21], -1), np.asarray(assembly_mode, int), "nan").xi.T
    )


def other_mode(robot, q11, q21, assembly_mode):
    return dgm(robot, q11, q21, -assembly_mode)


OTHER = Misconception(
    "other assembly mode", "Which of the two circle intersections is it?", other_mode
)
DGM = Exercise("dgm(q11, q21, assembly_mode) -> x, y", dgm, (OTHER,))
RIGHT = np.stack(dgm(fb.FiveBar(), *Q, MODES), -1)


def verdict(values, **choices):
    replies = [value if isinstance(value, Reply) else Reply("value", value) for value in values]
    return judge(DGM, fb.FiveBar(), (*Q, MODES), replies, **choices)


@pytest.mark.parametrize(
    "form",
    [
        lambda row: list(row),
        lambda row: row,
        lambda row: row[:, None],
        lambda row: [np.array(row[0]), np.array([row[1]])],
        lambda row: [np.array([[row[0]]]), float(row[1])],
        lambda row: [[row[0]], row[1]],
    ],
)
def test_every_form_of_the_right_answer_is_read(form):
    found = verdict([form(row) for row in RIGHT])
    assert (found.share, found.reason, found.diagnosis) == (1.0, "", None)


def test_a_column_where_floats_were_asked_is_remarked():
    assert "shape (2, 1)" in verdict([row[:, None] for row in RIGHT]).remarks[0]


@pytest.mark.parametrize(
    ("value", "reason", "word"),
    [
        (None, "type", "return missing"),
        ("0.1", "shape", "string"),
        ([0.1, "0.2"], "type", "string"),
        ([0.1, None], "type", "None"),
        ([0.1, 0.2j], "type", "complex"),
        ([0.1, 0.2, 0.3], "shape", "3 values"),
        ([0.1], "shape", "one value where 2 (x, y) are asked: is the return inside a loop?"),
        (0.1, "shape", "one number"),
        ([0.1, [0.2, 0.3]], "shape", "y has shape (2,)"),
        ([float("nan"), 0.1], "nan", "nan"),
        ([float("inf"), 0.1], "nan", "infinity"),
        (Reply("timeout"), "timeout", "time limit"),
        (Reply("exception", text="ValueError: no", line=3), "exception", "ValueError"),
    ],
)
def test_what_is_wrong_is_named(value, reason, word):
    found = verdict([value] + [list(row) for row in RIGHT[1:]])
    assert (found.share, found.wrong, found.reason) == (pytest.approx(11 / 12), 1, reason)
    assert word in found.text
    assert found.asked.startswith("dgm(q11=") and found.diagnosis is None


def test_calls_that_were_not_asked_are_told_apart_from_those_that_hang():
    left = [Reply("timeout", text="no answer within 2 s")]
    left += [Reply("unasked", text="the calls before it took all of the time")] * 3
    found = verdict(left[1:] + left[:1] + [list(row) for row in RIGHT[4:]])
    assert (found.share, found.wrong, found.reason) == (pytest.approx(8 / 12), 1, "timeout")
    assert "3 more calls were not asked, as these took all of the time" in found.text


def test_the_misconception_is_named_and_its_error_measured():
    wrong = np.stack(other_mode(fb.FiveBar(), *Q, MODES), -1)
    found = verdict([list(row) for row in wrong])
    assert found.share == 0 and found.diagnosis is OTHER
    assert found.off == pytest.approx(np.max(np.abs(wrong[0] - RIGHT[0])), rel=1e-12)


def test_one_stray_answer_is_no_misconception():
    wrong = np.stack(other_mode(fb.FiveBar(), *Q, MODES), -1)
    wrong[5] += 1e-6
    assert verdict([list(row) for row in wrong]).diagnosis is None


def test_an_error_of_1e_8_is_wrong_and_of_1e_12_is_right():
    found = verdict([list(row * (1 + 1e-8)) for row in RIGHT])
    assert found.share < 1 and found.text == "wrong value"
    assert verdict([list(row * (1 + 1e-12)) for row in RIGHT]).share == 1


def test_refusals_count_only_beside_right_answers():
    refuse = np.arange(12) >= 9
    refusals = [
        Reply("exception", text="ValueError: math domain error"),
        Reply("value", [np.nan, np.nan]),
        Reply("value"),
    ]
    assert verdict([*[list(row) for row in RIGHT[:9]], *refusals], refuse=refuse).share == 1
    assert verdict([Reply("exception", text="ValueError: no")] * 12, refuse=refuse).share == 0
    broken = Reply("exception", text="NotImplementedError: lab1 task 1")
    assert (
        verdict([*[list(row) for row in RIGHT[:9]], broken, *refusals[1:]], refuse=refuse).reason
        == "exception"
    )
    accepted = verdict([list(row) for row in RIGHT], refuse=refuse)
    assert (accepted.share, accepted.reason) == (0.75, "accepted")


def test_no_mistakes_are_sought_where_nothing_came():
    exercise, calls = find_lab("lab1").exercises()["dgm"], []
    wrong = Misconception("a mistake", "?", lambda *row: calls.append(1) or exercise.answer(*row))
    counted = replace(exercise, wrong=(wrong, wrong))
    todo = [Reply("exception", text="NotImplementedError: lab1 task 1")] * 12
    assert judge(counted, fb.FiveBar(), (*Q, MODES), todo).diagnosis is None
    assert not calls
    judge(counted, fb.FiveBar(), (*Q, MODES), [*todo[1:], Reply("value", [1.0, 2.0])])
    assert len(calls) >= 2


def test_where_refusals_are_asked_for_the_report_says_what_became_of_them():
    refuse = np.arange(12) >= 9
    refusals = [Reply("exception", text="ValueError: math domain error")] * 3
    found = verdict([*[[x + 1, y] for x, y in RIGHT[:9]], *refusals], refuse=refuse)
    assert (found.share, found.wrong) == (0, 12)
    assert (
        found.text
        == "wrong value of x (where no answer exists, refusing earns points only if another answer is right)"
    )
    found = verdict([Reply("value"), *[list(row) for row in RIGHT[1:9]], *refusals], refuse=refuse)
    assert (found.wrong, found.text) == (
        1,
        "returned None, as if there were no answer: is a return missing?",
    )


def test_angles_are_compared_modulo_a_turn():
    igm = Exercise("igm(x) -> q11", lambda robot, x: x, angles=("q11",))
    x = np.array([0.1, -3.0])
    assert judge(igm, None, (x,), [Reply("value", value + 2 * np.pi) for value in x]).share == 1
    assert judge(igm, None, (x,), [Reply("value", value + np.pi) for value in x]).share == 0


def test_matrices_and_vectors_are_read():
    model = Exercise(
        "f(a) -> M, c",
        lambda robot, a: (a[:, None, None] * np.eye(2), a[:, None] * np.ones(2)),
        shapes={"M": (2, 2), "c": (2,)},
    )
    a = np.array([1.0, 2.0])
    for c in (lambda v: np.full((2, 1), v), lambda v: [v, v], lambda v: np.full(2, v)):
        assert (
            judge(model, None, (a,), [Reply("value", [v * np.eye(2), c(v)]) for v in a]).share == 1
        )
    assert (
        judge(model, None, (a,), [Reply("value", [np.eye(3), [v, v]]) for v in a]).reason == "shape"
    )


def test_a_guess_of_few_values_earns_nothing():
    kind = Exercise("kind(a) -> n", lambda robot, a: a > 0, guessable=True)
    assert judge(kind, None, (np.array([1.0, -1.0]),), [Reply("value", 1)] * 2).share == 0


def test_a_signature_that_cannot_be_read_is_refused():
    with pytest.raises(ValueError, match="a signature reads"):
        Exercise("dgm -> x, y", dgm)


LINE = Exercise("f(a, b) -> x, q", lambda robot, a, b: (a * b, 1e-3 * a + 0 * b), angles=("q",))
A, B = np.array([1.0, 2.0, 4.0]), np.array([0.25, -2.0, 0.125])


def line(x, q, **choices):
    return judge(LINE, None, (A, B), [Reply("value", list(row)) for row in zip(x, q)], **choices)


def test_an_error_is_measured_by_the_largest_answer_of_its_number_an_angles_by_one_radian():
    exact = A * B, 1e-3 * A
    for size, share in ((0.9e-9, 1.0), (1.1e-9, 0.0)):
        assert line(exact[0] + 4 * size, exact[1]).share == share
        assert line(exact[0], exact[1] - size + 2 * np.pi).share == share
    assert line(*exact, tolerance=0).share == 1 and line(*exact, tolerance=0).rows == 3
    per_row = np.array([1e-3, 1e-5, 1e-2])
    assert (
        line(exact[0] + 0.9 * 4 * per_row, exact[1] - 0.9 * per_row, tolerance=per_row).share == 1
    )
    assert line(
        exact[0] + 4 * np.roll(per_row, 1), exact[1], tolerance=per_row
    ).share == pytest.approx(1 / 3)


def test_the_first_wrong_call_is_told_with_all_that_belongs_to_it():
    replies = [
        Reply("value", [0.25, 1e-3]),
        Reply("value", [np.array([-4.0]), 0.5], line=3, source="return"),
        Reply("exit"),
    ]
    found = judge(LINE, None, (A, B), replies)
    assert (found.share, found.reason, found.text) == (
        pytest.approx(1 / 3),
        "value",
        "wrong value of q",
    )
    assert (found.wrong, found.rows, found.line, found.source) == (2, 3, 3, "return")
    assert (found.asked, found.came) == ("f(a=2, b=-2)", "([-4.], 0.5)")
    assert found.off == pytest.approx(0.498, rel=1e-12)
    assert found.remarks == (
        "x was returned with shape (1,) where a number is asked, which counts as well",
    )
    assert found.sample == {
        "inputs": {"a": 2.0, "b": -2.0},
        "expected": [-4.0, 2e-3],
        "came": [-4.0, 0.5],
    }
    none = judge(LINE, None, (A, B), [Reply("exit", line=9)] * 3)
    assert (none.share, none.off, none.came, none.text) == (
        0,
        None,
        KINDS["exit"],
        Reply("exit").words,
    )
    with pytest.raises(ValueError, match="the right f has no answer in row 1"):
        judge(LINE, None, (A, np.array([1.0, np.nan, 2.0])), replies)


def test_the_labs_own_measure_is_told_beside_the_verdict():
    def told(x, q, most=0.1, measure=lambda numbers: numbers):
        return line(x, q, threshold=(most, measure)).beside

    x, q = A * B, 1e-3 * A
    assert told(x + 0.3, q + 0.05) == "mean errors 0.3 and 0.05: error in model (threshold 0.1)"
    assert (
        told(x + [0.1, -0.1, 0.04], q + 0.05 + 2 * np.pi)
        == "mean errors 0.08 and 0.05: OK (threshold 0.1)"
    )
    assert (
        told(x + 0.5, q + 0.05, 0.5) == "mean errors 0.5 and 0.05: error in model (threshold 0.5)"
    )
    assert told(x + 0.05, q + 0.2) == "mean errors 0.05 and 0.2: error in model (threshold 0.1)"
    assert (
        told(x + 0.2, q - 0.2, 0.5, lambda n: n * (2, 0.5))
        == "mean errors 0.4 and 0.1: OK (threshold 0.5)"
    )
    assert told(x + np.nan, q) == "" == line(x, q + 0.2).beside


@pytest.mark.parametrize(
    ("reply", "text"),
    [
        (Reply("exception", text="ValueError: " + "x" * 300), ("ValueError: " + "x" * 300)[:200]),
        (Reply("timeout"), KINDS["timeout"]),
        (Reply("value", 1 / 3), "0.333333333"),
        (Reply("value", [1 / 3, "a", None, [2, 0.5]]), "(0.333333333, 'a', None, (2, 0.5))"),
        (Reply("value", list(range(20))), "(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, ...)"),
        (Reply("value", ["x" * 150] * 3), ("(" + ", ".join([repr("x" * 150)] * 3) + ")")[:200]),
        (Reply("value", "y" * 300), repr("y" * 300)[:200]),
        (
            Reply("value", np.array([[1 / 3, 2], [0, 1]])),
            "[[0.333333333, 2.         ],  [0.         , 1.         ]]",
        ),
        (Reply("value", np.arange(13.0)), "[ 0.,  1.,  2., ..., 10., 11., 12.]"),
    ],
)
def test_what_came_fits_into_a_line(reply, text):
    assert came_text(reply) == text
