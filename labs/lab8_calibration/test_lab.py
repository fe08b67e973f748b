"""What lab 8 checks; its models are in exercises.py, and a calibration is judged by what it finds."""

from pathlib import Path
from runpy import run_path

import numpy as np
import pytest

from fivebar.grading import Exercise
from fivebar.grading.values import Unfit, read

BUILT = run_path(str(Path(__file__).parent / "exercises.py"))
NOMINAL, as_drawn, rows_of = BUILT["NOMINAL"], BUILT["as_drawn"], BUILT["rows_of"]
misses, from_elbow, calibrate = BUILT["misses"], BUILT["from_elbow"], BUILT["calibrate"]

FOUND = BUILT["CALIBRATE"]
OWN = Exercise("own_robot(q, xi) -> l11, l12, l21, l22, d", None)
NAMES = FOUND.returns
NEARLY = 1e-5  # m and rad: a calibration that is on its way comes so close in two steps
FAR = 0.5  # m: no step from the drawing's numbers goes so far


def some_rows(draw, n=12):
    """Columns of values and measured rows, not of one robot: the formulas hold for any."""
    lengths = np.array(NOMINAL)[:, None] * draw.uniform(0.8, 1.2, (7, n))
    lengths[5:] = draw.uniform(-0.5, 0.5, (2, n))
    return *lengths, *draw.uniform(-3, 3, (2, n)), *draw.uniform(-0.15, 0.15, (2, n))


def numbers(ask, exercise, *row, limit=None):
    """The numbers that one call gives, as an array; a verdict where it gives others."""
    value = ask.call(exercise.name, *row, limit=limit)
    try:
        found = read(exercise, value)[0]
    except Unfit as unfit:
        ask.verdict(0.0, str(unfit))
    if not np.isfinite(found).all():
        ask.verdict(0.0, "returned nan or infinity")
    return found


def judge_found(ask, found, truth, tolerance, others=()):
    """others: which points are left out, in words, and what a fit of the others gives."""
    off = np.abs(np.clip(found, -1e6, 1e6) - truth)
    good = off <= np.asarray(tolerance)
    if good.all():
        return ask.verdict(1.0)
    worst = int(np.argmax(off / tolerance))
    unit = (1e3, "mm") if worst < 5 else (180 / np.pi, "degrees")
    words = f"{NAMES[worst]} is off by {unit[0] * off[worst]:.3g} {unit[1]}"
    if off[:5].max() > FAR:
        longest = int(np.argmax(off[:5]))
        words = (
            f"{NAMES[longest]} came out as {found[longest]:.3g} m: which way do the steps lead? Look at"
            " the sign with which a step is taken"
        )
    if np.allclose(found, np.array(NOMINAL)[: len(found)], atol=1e-12):
        words = "these are the numbers of the drawing: nothing was calibrated"
    if np.allclose(found[:5] / 1000, truth[:5], atol=1e-3):
        words = "these lengths are in millimetres: metres are asked"
    if len(found) == len(NAMES) and off.max() < NEARLY:
        words += (
            ": the steps lead there. Do you take enough of them, and what is small enough to stop?"
        )
    for left_out, numbers in others:
        if np.allclose(found, numbers, atol=1e-7):
            words = f"these numbers fit all points{left_out}: the wrong one is kept"
    return ask.verdict(0.0, words, off=float(off[worst]))


@pytest.mark.points(3)
def test_misses(ask, draw):
    """misses: any lengths, offsets and points"""
    ask("misses", *some_rows(draw))


@pytest.mark.points(5)
def test_derivatives(ask, draw):
    """derivatives: by lengths and offsets, at any point"""
    ask("derivatives", *some_rows(draw))


@pytest.mark.points(2)
def test_unseen(ask, draw):
    """unseen: what a picture of unknown scale does not show"""
    rows = some_rows(draw, 8)
    ask("unseen", *rows[:7], draw.uniform(0.5, 2.0, 8))


@pytest.mark.points(4)
def test_calibrate_exact(ask, draw):
    """calibrate: exact points, lengths to 1e-9 m"""
    truth = as_drawn(draw)
    rows = rows_of(truth, draw, 20, 0.0)
    found = numbers(ask, FOUND, rows[:, :2].tolist(), rows[:, 2:].tolist())
    judge_found(ask, found, truth, [1e-9] * 5 + [1e-8] * 2)


@pytest.mark.points(2)
def test_calibrate_noisy(ask, draw):
    """calibrate: points with noise of 0.05 mm"""
    truth = as_drawn(draw)
    rows = rows_of(truth, draw, 40, 5e-5)
    found = numbers(ask, FOUND, rows[:, :2].tolist(), rows[:, 2:].tolist())
    judge_found(ask, found, truth, [1.5e-4] * 5 + [3e-3] * 2)  # more than 6 standard deviations


def far_off(rows, place, slip):
    """The rows with one point moved by `slip`, complex; and whether its bars miss it by the most after a fit of all."""
    moved = rows.copy()
    moved[place, 2:] += slip.real, slip.imag
    return moved, largest_miss(fit(moved), moved) == place


def largest_miss(numbers, rows):
    """The number of the row that the bars of a robot with these numbers miss by the most."""
    e = misses(None, *np.repeat(numbers[:, None], len(rows), axis=1), *rows.T)
    return np.abs(e).max(axis=0).argmax()


def fit(rows):
    return np.array(calibrate(None, rows[:, :2], rows[:, 2:]))


def with_hidden_slip(draw):
    """A robot, and measured rows of which the first one is wrong, and another one has the largest e."""
    while True:
        truth = as_drawn(draw)
        rows = rows_of(truth, draw, 10, 5e-6)
        for bar in from_elbow((*truth, *rows[0])):
            # Only the other leg notices a slip at a right angle to its bar.
            moved, is_largest = far_off(rows, 0, 0.01j * bar / abs(bar))
            if not is_largest:
                return truth, moved


def judge_own_robot(ask, truth, rows):
    all_points = fit(rows)
    largest, others = largest_miss(all_points, rows), [("", all_points[:5])]
    for k in range(len(rows)):
        one = " but the one with the largest e" if k == largest else " but one that is right"
        others.append((one, fit(np.delete(rows, k, axis=0))[:5]))
    found = numbers(ask, OWN, rows[:, :2].tolist(), rows[:, 2:].tolist(), limit=10.0)
    judge_found(ask, found, truth[:5], [1e-4] * 5, others)


@pytest.mark.points(2)
def test_own_robot(ask, draw):
    """own_robot: points of which one is wrong, lengths to 0.1 mm"""
    truth = as_drawn(draw)
    rows = rows_of(truth, draw, 30, 2e-5)
    slip = draw.uniform(8e-3, 15e-3) * np.exp(1j * draw.uniform(-np.pi, np.pi))
    judge_own_robot(ask, truth, far_off(rows, 29, slip)[0])


@pytest.mark.points(2)
def test_own_robot_hidden(ask, draw):
    """own_robot: few points, of which another one than the wrong one has the largest e"""
    judge_own_robot(ask, *with_hidden_slip(draw))
