"""What a student's numbers have to do with the right ones where no known mistake gives them: plain relations only."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.grading import Exercise, Reply, judge
from fivebar.grading.fits import number_text

ROBOT = fb.FiveBar()  # l = 0.09, d = 0.118, zz1 = zz2 = 0.002, m = 0.5
A, B = np.random.default_rng(2).uniform(0.2, 1.0, (2, 12))
SIGNS = np.where(np.arange(12) % 3, 1.0, -1.0)
X, Y = A * B, A - 2 * B
Q = 6 * A - 3
M = np.stack([np.stack([A, B], -1), np.stack([A * A, A - B], -1)], axis=1)
HOLED = M * [[1, 0], [1, 1]]

PAIR = Exercise("f(a, b) -> x, y", lambda robot, a, b: (a * b, a - 2 * b))
ONE = Exercise("f(a, b) -> x", lambda robot, a, b: a * b)
NOUGHT = Exercise("f(a, b) -> x", lambda robot, a, b: 0 * a)
ANGLE = Exercise("f(a, b) -> q", lambda robot, a, b: 6 * a - 3, angles=("q",))
ANGLES = Exercise("f(a, b) -> q, x", lambda robot, a, b: (6 * a - 3, a * b), angles=("q",))
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
    "exchanged": (PAIR, (Y, X), "x and y exchanged"),
    "a sign": (PAIR, (-X, Y), "the sign of x is wrong in every row"),
    "the other sign": (PAIR, (X, -Y), "the sign of y is wrong in every row"),
    "signs": (PAIR, (-X, -Y), "the sign of x and y is wrong in every row"),
    "some signs": (PAIR, (SIGNS * X, Y), "right but for signs, which differ from row to row"),
    "factor": (PAIR, (0.18 * X, Y), "x is 0.18 = 2 l times the right one"),
    "factor of all": (PAIR, (-3 * X, -3 * Y), "-3 times the right answer in every row"),
    "two factors": (PAIR, (3 * X, 7 * Y), "x is 3 times the right one; y is 7 times the right one"),
    "small factor": (PAIR, (X, 1e-4 * Y), "y is 0.0001 times the right one"),
    "large factor": (PAIR, (X, 7e5 * Y), "y is 7e+05 times the right one"),
    "offset": (PAIR, (X + 0.118, Y), "x is off by 0.118 = d"),
    "offset of all": (PAIR, (X - 0.0123, Y - 0.0123), "off by -0.0123 in every row"),
    "two offsets": (PAIR, (X + 0.0123, Y + 0.3), "x is off by 0.0123; y is off by 0.3"),
    "argument": (PAIR, (X + A, Y), "x is off by a"),
    "argument too few": (PAIR, (X, Y - B), "y is off by -b"),
    "multiple of an argument": (PAIR, (X, Y - 3 * B), "y is off by -3 b"),
    "zero": (PAIR, (0 * X, 0 * Y), "always (0, 0): unfinished?"),
    "zero alone": (ONE, (0 * X,), "always 0: unfinished?"),
    "constant": (PAIR, (0 * X + 1, 0 * Y), "always the same answer, whatever the arguments"),
    "of nought no factor": (NOUGHT, (X - X + 0.0123,), "off by 0.0123 in every row"),
    "one factor": (ONE, (4 * X,), "4 times the right answer in every row"),
    "rounded": (PAIR, (np.round(X, 4), Y), "rounded after 4 decimals"),
    "cut off": (ANGLE, (np.trunc(Q * 1000) / 1000 + 0.0,), "rounded after 3 decimals"),
    "grid": (ONE, (np.round(X * 40) / 40,), "a grid's value, a multiple of 1/40, not refined"),
    "fine grid": (
        ONE,
        (np.round(X * 19997) / 19997,),
        "a grid's value, a multiple of 1/19997, not refined",
    ),
    "half a turn": (ANGLE, (Q + np.pi,), "off by -3.142 = -pi in every row"),
    "angle's offset": (ANGLE, (Q + 0.2 + 2 * np.pi * (SIGNS > 0),), "off by 0.2 in every row"),
    "angle and argument": (ANGLE, (Q + B - 2 * np.pi * (SIGNS > 0),), "off by b in every row"),
    "angle less argument": (ANGLE, (Q - A,), "off by -a in every row"),
    "angle and double": (ANGLE, (Q - 2 * B,), "off by -2 = -1/m b in every row"),
    "angle and half": (ANGLE, (Q + 0.5 * B,), "off by 0.5 = 1/2 b in every row"),
    "an angle's sign": (ANGLES, (-Q, X), "the sign of q is wrong in every row"),
    "angle beside a right one": (ANGLES, (Q + 0.2, X), "q is off by 0.2"),
    "right angle beside a factor": (
        ANGLES,
        (Q + 2 * np.pi * (SIGNS > 0), 3 * X),
        "x is 3 times the right one",
    ),
    "transposed": (MATRIX, (M.swapaxes(1, 2), X), "M transposed"),
    "a matrix's factor": (MATRIX, (M / 9, X), "M is 0.1111 times the right one"),
    "a matrix's sign": (MATRIX, (-M, X), "the sign of M is wrong in every row"),
    "one number the same": (MATRIX, (HOLED, X), "M[0][1] is 0 in every row: all else is right"),
    "a matrix the same": (MATRIX, (0 * M, X), "M is 0 in every row: all else is right"),
    "whole numbers": (ANGLE, (np.trunc(Q),), "whole numbers: the decimals are cut off"),
    "nearly": (PAIR, (X * (1 + 1e-6 * SIGNS), Y), "right to 1e-06, and no closer"),
    "times nearly 1": (ONE, (X * (1 + 2e-7),), "right to 2e-07, and no closer"),
    "beside a matrix": (MATRIX, (M, X + 0.118), "x is off by 0.118 = d"),
}


@pytest.mark.parametrize(("exercise", "came", "name"), RELATIONS.values(), ids=RELATIONS)
def test_a_relation_that_holds_in_all_rows_is_named(exercise, came, name):
    assert named(exercise, *came) == name
    assert named(exercise, *came, refused=(0, 9)) == name
    if "sign" in name or "exchanged" in name or "transposed" in name:  # without any arithmetic
        assert named(exercise, *came, tolerance=0) == name
    # Four rows tell it, and three tell nothing; for signs alone eight are needed.
    fewest = 8 if "but for signs" in name else 4
    assert named(exercise, *came, rows=fewest) in (name, None if "turn" in name else name)
    assert named(exercise, *came, rows=fewest - 1) is None


@pytest.mark.parametrize(("exercise", "came", "name"), RELATIONS.values(), ids=RELATIONS)
@pytest.mark.parametrize("row", [0, 7, 11])
def test_and_in_all_but_one_it_is_not(exercise, came, name, row):
    spoilt = [np.array(part, float) for part in came]
    spoilt[-1][row] += 1.7e-4 * max(1, np.abs(spoilt[-1]).max())
    assert named(exercise, *spoilt) is None


@pytest.mark.parametrize(
    ("exercise", "came"),
    [
        (ANGLE, (3 * Q,)),  # of angles a factor says nothing
        (ANGLE, (Q - 3 * B,)),
        (MATRIX, (M + 0.1, X)),
        (PAIR, (3 * X, Y + A * A)),  # one is explained, the other is not
        (ONE, (np.round(X * 40 + 2) / 40 + 0.01 * A,)),
        (PAIR, (np.round(X, 3) + 2e-3, Y)),  # round, but farther off
        (ONE, (np.round(40 * A * A) / 40,)),  # on a grid, but far off
    ],
)
def test_what_is_no_plain_relation_is_not_named(exercise, came):
    assert named(exercise, *came) is None


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.25, "0.25 = 1/4"), (1 / 3, "0.3333 = 1/3"), (0.5, "0.5 = 1/2"), (2.0, "2 = 1/m"), (-2.0, "-2 = -1/m"),
        (3.0, "3"), (-4.0, "-4"), (np.pi / 2, "1.571 = pi/2"), (-np.pi, "-3.142 = -pi"), (2**0.5, "1.414 = sqrt 2"),
        (np.pi / 180, "0.01745 = pi/180"), (180 / np.pi, "57.3 = 180/pi"), (0.09, "0.09 = l"), (0.18, "0.18 = 2 l"),
        (0.045, "0.045 = 1/2 l"), (0.36, "0.36 = 4 l"), (0.0225, "0.0225 = 1/4 l"), (1 / 0.09, "11.11 = 1/l"),
        (2 / 0.09, "22.22 = 2/l"), (0.5 / 0.118, "4.237 = 1/2/d"), (0.118**2, "0.01392 = d^2"),
        (-(0.118**2) / 4, "-0.003481 = -1/4 d^2"), (1 / 0.118**2, "71.82 = 1/d^2"), (4 / 0.118**2, "287.3 = 4/d^2"),
        (0.09 * (1 + 1e-8), "0.09"), (2 + 1e-7, "2"), (0.25 + 5e-9, "0.25"),
        (1000.0, "1000"), (0.7, "0.7"), (1.0, "1 = 2 m"), (12345.678, "1.235e+04"),
    ],
)  # fmt: skip
def test_a_number_says_what_it_may_be_made_of(value, text):
    assert number_text(value, ROBOT) == text
    own = text.split(" = ")[-1]
    assert number_text(value, None) == (text.split(" = ")[0] if set(own) & set("ldmz") else text)


def test_what_is_nearly_another_number_is_not_it_and_unequal_bars_have_their_own_names():
    other = replace(ROBOT, l12=0.1, l22=0.11)
    assert number_text(2.0, replace(ROBOT, m=0.5 * (1 + 3e-9))) == "2"
    assert (
        number_text(1.0, replace(ROBOT, m=1.0)) == "1"
        and number_text(8.0, replace(ROBOT, m=2.0)) == "8 = 2 m^2"
    )
    assert number_text(1.00001 * ROBOT.zz1**2, ROBOT) == "4e-06"
    assert [number_text(x, other) for x in (0.1, 0.22, 0.09)] == [
        "0.1 = l12",
        "0.22 = 2 l22",
        "0.09 = l11",
    ]
