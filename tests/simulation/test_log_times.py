"""The times of a log: in order, and of which a step is left."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.estimation.logs.columns import order, since_1970


def test_rows_of_one_time_keep_their_order():
    t = np.repeat(0.01 * np.arange(150), 2)
    t[100:104] = t[[102, 103, 100, 101]]
    assert order(t).tolist() == sorted(
        range(300), key=t.__getitem__
    )  # Python's own sorting is stable


@pytest.mark.parametrize("late", [2e14, 1e17, 1e40])
def test_a_time_of_which_no_step_is_left(late):
    t = [*0.01 * np.arange(8), late]
    with pytest.raises(
        ValueError, match="row 8: t = .* s is no time of a log with rows every 0.01 s"
    ):
        fb.from_log(t, np.linspace(0.1, 0.2, 9), np.linspace(0.2, 0.3, 9))


@pytest.mark.parametrize("t", [np.empty(0), np.full(3, np.nan)])
def test_no_times_are_of_no_clock(t):
    notes = []
    assert since_1970(t, False, notes) is t and notes == []
