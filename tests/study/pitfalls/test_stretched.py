"""sqrt(l^2 - a^2) is nan for bars that are just stretched, and loses what a short bar is measured against."""

import mpmath
import numpy as np
import pytest

from tests.study.pitfalls.stretched import dyad_height, printed_height, stretch

EPS = np.finfo(float).eps


def exact_height(span, r1, r2):
    with mpmath.workdps(50):
        (x, y), a, b = map(mpmath.mpf, map(float, span)), mpmath.mpf(r1), mpmath.mpf(r2)
        square = x * x + y * y
        heron = ((a + b) ** 2 - square) * (square - (a - b) ** 2)
        return float(mpmath.sqrt(max(heron, 0) / square) / 2)


def errors(case, height, r1, r2):
    return np.abs(height - [[exact_height(xy, r1, r2) for xy in span.T] for span in case.spans])


@pytest.mark.parametrize("r1, r2, share", [(0.09, 0.09, 0.05), (0.14, 0.12, 0.9)])
def test_exactly_stretched(r1, r2, share):
    """To a span of r1 + r2, rounded, a joint exists: its height is 0 to the root of rounding."""
    case = stretch(r1, r2, [0.0])

    def is_there(height):
        return bool(
            np.isfinite(height).all() and np.abs(height).max() < 4 * np.sqrt(EPS) * (r1 + r2)
        )

    assert is_there(case.dyad)
    assert not is_there(case.printed)
    assert np.isnan(case.printed).mean() > share


def test_a_short_bar():
    """Cancellation is measured against r1^2 in one form, against r1 r2 in the other."""
    r1, r2 = 0.1, 1e-4
    case = stretch(r1, r2, [3e-4, 1e-3, 1.5e-3], count=100)

    def keeps_its_digits(height):
        return bool(errors(case, height, r1, r2).max() < 4 * EPS * r1)

    assert keeps_its_digits(case.dyad)
    assert not keeps_its_digits(case.printed)


def test_near_stretched_equal_bars_both_lose_the_same_digits():
    """What is lost there is lost in the span itself: ours is better by a small factor only."""
    short = 10.0 ** -np.arange(2, 15, 3)
    case = stretch(0.09, 0.09, short, count=100)
    ours, printed = (
        errors(case, height, 0.09, 0.09).max(axis=1) for height in (case.dyad, case.printed)
    )
    assert (ours < 1.01 * printed).all() and (printed < 6 * ours).all()
    assert (ours <= EPS * 0.09 / np.sqrt(short)).all()


def test_both_forms_are_the_same_where_nothing_cancels():
    span = (np.array([0.05, 0.1]), np.array([0.03, -0.02]))
    for bars in ((0.09, 0.09), (0.14, 0.12)):
        assert printed_height(span, *bars) == pytest.approx(dyad_height(span, *bars), rel=1e-13)
