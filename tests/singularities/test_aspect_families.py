"""Aspects of robots in round numbers, change-point robots and those that nearly are, against a count on a grid.

The grid's geometry is its own: circles by hand, det A by a cross product. A few robots of each family; with
FIVEBAR_NIGHTLY=1 four hundred.
"""

import os

import numpy as np
import pytest
from scipy import ndimage

import fivebar as fb
from fivebar.constraints.disc import clearance_at
from fivebar.singularities.locus import MODES

COUNT = 400 if os.environ.get("FIVEBAR_NIGHTLY") else 6
N = 300  # nodes along either side, none of them on the line of the bases
THICK = 7  # steps: what is as far from its border is found on the grid and in the aspects


def centimetres(rng):
    return rng.integers(1, 26, 5) / 100


def millimetres(rng):
    return rng.integers(5, 251, 5) / 1000


def touching(rng):
    """A circle of the left leg touches one of the right."""
    l11, l12, l21, l22 = rng.integers(1, 26, 4)
    left, right = (abs(a + rng.choice([-1, 1]) * b) for a, b in ((l11, l12), (l21, l22)))
    return np.array([l11, l12, l21, l22, rng.choice([left + right, abs(left - right)])]) / 100


def change_points(rng):
    bars = rng.integers(1, 26, 4)
    return np.array([*bars, abs(rng.choice([-1, 1], 4) @ bars)]) / 100


def nearly_change_points(rng):
    lengths = change_points(rng)
    lengths[4] = abs(lengths[4] + rng.choice([-1, 1]) * 10 ** rng.uniform(-12, -3))
    return lengths


def coaxial(rng):
    return np.array([*rng.integers(1, 26, 4), 0]) / 100


def equal_distal_bars(rng):
    lengths = centimetres(rng)
    lengths[3] = lengths[1]
    return lengths


def disparate(rng):
    """Bars in ratios to 1 : 1000."""
    return 0.3 * 10 ** rng.uniform(-3, 0, 5)


FAMILIES = (
    centimetres,
    millimetres,
    touching,
    change_points,
    nearly_change_points,
    coaxial,
    equal_distal_bars,
    disparate,
)


def robots(family):
    rng, found = np.random.default_rng(sum(map(ord, family.__name__))), []
    while len(found) < COUNT:
        try:
            found.append(fb.FiveBar(*family(rng).tolist()))
        except ValueError:  # it can never close
            pass
    return found


def det_a(robot, x, y, working):
    """Of poses by working modes, nan out of reach: elbows by the cosine rule, the cross product of the distal bars."""
    distal = []
    for side, l1, l2, mode in (
        (-0.5, robot.l11, robot.l12, working[0]),
        (0.5, robot.l21, robot.l22, working[1]),
    ):
        away = x - side * robot.d + 1j * y
        reach = np.abs(away)
        cosine = (l1 * l1 + reach * reach - l2 * l2) / (2 * l1 * reach)
        turn = np.where(np.abs(cosine) <= 1, np.arccos(np.clip(cosine, -1, 1)), np.nan)
        distal.append((away - l1 * away / reach * np.exp(1j * mode * turn)) / l2)
    return (distal[0].conj() * distal[1]).imag


def parallel_touch(robot):
    """Whether the elbows of equal distal bars meet in one pose: on that circle det A is 0 and keeps its sign."""
    sums = robot.d - robot.l11 - robot.l21, robot.d - abs(robot.l11 - robot.l21)
    return robot.l12 == robot.l22 and min(map(abs, sums)) < 1e-4


def grid(robot):
    """x (n,) and y (n,) over all that both legs reach, and the larger step."""
    reach = robot.l11 + robot.l12, robot.l21 + robot.l22
    left, right = (
        max(-robot.d / 2 - reach[0], robot.d / 2 - reach[1]),
        min(-robot.d / 2 + reach[0], robot.d / 2 + reach[1]),
    )
    x = left + (right - left) * (np.arange(N) + 0.5) / N
    y = min(reach) * ((2 * np.arange(N) + 1) / N - 1)
    return x, y, max(x[1] - x[0], y[1] - y[0])


def agree(own, inside, x, y, step, what, apart_too=True):
    """The parts of one working and assembly mode against a flood fill of what is inside on the grid."""
    cell = (x[1] - x[0]) * (y[1] - y[0])
    labels, count = ndimage.label(inside)
    counted, total = np.count_nonzero(labels) * cell, sum(part.area for part in own)
    border = 2 * (np.ptp(x) + np.ptp(y)) * step
    assert total == pytest.approx(counted, rel=0.02, abs=border), what
    room = ndimage.distance_transform_cdt(np.pad(labels > 0, 1))[1:-1, 1:-1]
    for label in range(1, count + 1):
        i, j = np.unravel_index(np.argmax(np.where(labels == label, room, 0)), labels.shape)
        if room[i, j] >= THICK:
            within = [part.number for part in own if part.contains((x[i], y[j]))]
            assert len(within) == 1, (what, x[i], y[j], within)
    apart, _ = ndimage.label(room > 1)  # what meets in a point does not on the grid either
    where = [
        apart[np.abs(x - part.point[0]).argmin(), np.abs(y - part.point[1]).argmin()]
        for part in own
        if clearance_at(part, complex(*part.point)) > THICK * step
    ]
    assert 0 not in where and not (apart_too and len(set(where)) != len(where)), what


@pytest.mark.every(9)
@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.__name__)
def test_no_part_is_lost_and_none_is_two(family):
    for robot in robots(family):
        found = fb.aspects(robot)
        x, y, step = grid(robot)
        for working in MODES:
            values = det_a(robot, x[:, None], y[None, :], working)
            for assembly in (1, -1):
                own = [
                    part for part in found if (part.working, part.assembly) == (working, assembly)
                ]
                what = robot, working, assembly
                agree(own, -assembly * values > 1e-9, x, y, step, what, not parallel_touch(robot))
