"""What a student's numbers have to do with the right ones where no known mistake gives them: plain relations only."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.grading import Exercise, Reply, judge

ROBOT = fb.FiveBar()  # l = 0.09, d = 0.118, zz1 = zz2 = 0.002, m = 0.5
A, B = np.random.default_rng(2).uniform(0.2, 1.0, (2, 12))
X, Y = A * B, A - 2 * B
Q = 6 * A - 3
M = np.stack([np.stack([A, B], -1), np.stack([A * A, A - B], -1)], axis=1)

PAIR = Exercise("f(a, b) -> x, y", lambda robot, a, b: (a * b, a - 2 * b))
ANGLE = Exercise("f(a, b) -> q", lambda robot, a, b: 6 * a - 3, angles=("q",))
MATRIX = Exercise(
    "f(a, b) -> M, x",
    lambda robot, a, b: (
        np.stack([np.stack([a, b], -1), np.stack([a * a, a - b], -1)], axis=1),
        a * b,
    ),
    shapes={"M": (2, 2)},
)


def named(exercise, *came, rows=12, refused=(), tolerance=1e-9):
    """The name that is given to these answers; all are wrong somewhere."""
    replies = [
        Reply("value", list(row) if len(row) > 1 else row[0]) for row in list(zip(*came))[:rows]
    ]
    for row in refused:
        replies[row] = Reply("exception", text="ValueError: no")
    refuse = np.isin(np.arange(rows), refused)
    found = judge(exercise, ROBOT, (A[:rows], B[:rows]), replies, tolerance, refuse)
    assert found.share < 1
    assert not found.diagnosis or found.diagnosis.hint.endswith((".", "?"))
    return found.diagnosis and found.diagnosis.name


RELATIONS = {
    "constant": (
        PAIR,
        (0 * X + 1, 0 * Y),
        "always the same answer, whatever the arguments: is it still to be written?",
    )
}


@pytest.mark.parametrize(("exercise", "came", "name"), RELATIONS.values(), ids=RELATIONS)
def test_a_relation_that_holds_in_all_rows_is_named(exercise, came, name):
    assert named(exercise, *came) == name
    assert named(exercise, *came, refused=(0, 9)) == name
    assert named(exercise, *came, rows=4) == name
    assert named(exercise, *came, rows=3) is None


@pytest.mark.parametrize(("exercise", "came", "name"), RELATIONS.values(), ids=RELATIONS)
@pytest.mark.parametrize("row", [0, 7, 11])
def test_a_relation_that_one_row_breaks_is_not_named(exercise, came, name, row):
    spoilt = [np.array(part, float) for part in came]
    spoilt[-1][row] += 1.7e-4 * max(1, np.abs(spoilt[-1]).max())
    assert named(exercise, *spoilt) is None


@pytest.mark.parametrize(
    ("exercise", "came"),
    [
        (ANGLE, (3 * Q,)),  # a factor of an angle says nothing
        (MATRIX, (M + A[:, None, None], X)),
        (PAIR, (3 * X, Y + A * A)),
        (PAIR, (0.18 * X, Y)),  # what a factor of the answer comes from is found in the formula
        (PAIR, (X + 0.118, -Y)),
    ],
)
def test_what_is_no_plain_relation_is_not_named(exercise, came):
    assert named(exercise, *came) is None


def test_a_number_where_no_answer_exists_has_no_relation():
    """All that has an answer is right, so no relation holds for what is wrong."""
    half = Exercise("f(a, b) -> x", lambda robot, a, b: np.where(a < 0.6, a * b, np.nan))
    replies = [Reply("value", x) for x in X]
    result = judge(half, ROBOT, (A, B), replies, 1e-9, refuse=A >= 0.6)
    assert 0 < result.share < 1
    assert result.diagnosis is None
