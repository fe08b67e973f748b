"""Robots near degenerate ones, to the last digits, and of every size: no face is lost, areas are equal or scale."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fivebar as fb
from fivebar.singularities.degenerate import NEAR, RELATIONS, settled

EQUAL = 0.2277875447
LENGTHS = 0.1, 0.13, 0.09, 0.12, 0.11


def lengths_of(robot):
    return np.array([robot.l11, robot.l12, robot.l21, robot.l22, robot.d])


def areas(robot):
    """By working mode: of the aspects, largest first."""
    found = {}
    for each in fb.aspects(robot):
        found.setdefault(each.working, []).append(each.area)
    return found


@pytest.mark.every(7)
@pytest.mark.parametrize("off", [0.0, 1e-16, 3e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8])
@pytest.mark.parametrize("longer", [(4,), (1, 3), (0, 1), (2,), (1, 2, 4)])
def test_equal_bars_but_for_the_last_digits(longer, off):
    lengths = np.full(5, EQUAL)
    lengths[list(longer)] += off
    found = areas(fb.FiveBar(*lengths))
    equal = areas(fb.FiveBar(*np.full(5, EQUAL)))
    for working, large in equal.items():
        assert sum(found[working]) == pytest.approx(sum(large), rel=1e-6)
        assert found[working][0] == pytest.approx(large[0], rel=2e-3)


def test_a_change_point_robot_whose_locus_hugs_a_circle():
    found = areas(
        fb.FiveBar(
            0.1356615020369238,
            0.5726939258212818,
            0.19045987233356187,
            0.4371001396531531,
            0.190527588202357,
        )
    )
    assert sum(found[1, 1]) == pytest.approx(sum(found[1, -1]), rel=1e-9)


def test_a_face_that_has_no_width_in_the_middle_of_its_border():
    robot = fb.FiveBar(
        0.32622899694190594,
        0.43753712336373407,
        0.4792101136272472,
        0.4375370874041772,
        0.15298111428466915,
    )
    assert len(fb.aspects(robot)) == 10


@pytest.mark.deep
@settings(deadline=None, max_examples=20)
@given(
    relations=st.lists(st.integers(0, len(RELATIONS) - 1), min_size=1, max_size=3, unique=True),
    seed=st.integers(0, 2**32 - 1),
    off=st.floats(-16, -8),
)
def test_near_any_relation_of_lengths_all_modes_have_one_workspace(relations, seed, off):
    """`aspects` proves its faces and the equal areas itself; a lost face is an ArithmeticError."""
    rng = np.random.default_rng(seed)
    rows = RELATIONS[relations]
    lengths = rng.uniform(0.1, 0.6, 5)
    lengths -= np.linalg.pinv(rows) @ (rows @ lengths)
    lengths = lengths * (1 + 10**off * rng.choice([-1, 0, 1], 5))
    lengths[:4] = np.maximum(lengths[:4], 0.02)
    longest = lengths.argmax()
    if 2 * lengths[longest] > lengths.sum() or not 0.01 < lengths[4]:
        return
    robot = fb.FiveBar(*lengths)
    assert np.abs(lengths_of(settled(robot)) - lengths).max() <= 20 * NEAR * lengths.sum()
    fb.aspects(robot)
    fb.dexterous(robot, det_A=0.2, sin=0.2)


def test_a_robot_that_is_no_degenerate_one_stays_itself():
    for robot in (fb.FiveBar(), fb.FiveBar(*LENGTHS), fb.FiveBar(*np.full(5, EQUAL))):
        assert settled(robot) is robot


def test_a_sum_of_decimals_closes_in_one_point():
    """0.25 + 0.04 + 0.11 + 0.16 is 0.56 but in the last bit."""
    robot = fb.FiveBar(0.25, 0.04, 0.11, 0.16, 0.56)
    pose = fb.igm(robot, (0.56 / 2 - 0.27, 0.0))
    assert pose.q == pytest.approx([0.0, np.pi], abs=1e-7)
    assert fb.aspects(robot) == ()
    for lengths in product((0.1, 0.2, 0.3, 0.7), repeat=4):
        fb.FiveBar(*lengths, round(sum(lengths), 1))
        fb.Biglide(*lengths[:2], round(sum(lengths[:2]), 1))
    with pytest.raises(ValueError, match="can never close"):
        fb.FiveBar(0.25, 0.04, 0.11, 0.16, 0.56 * (1 + 1e-14))


@pytest.mark.deep
@pytest.mark.parametrize("scale", [5e-8, 6e-6, 1e-3, 1e3, 1e7])
def test_regions_scale_with_the_robot(scale):
    unit = fb.FiveBar(*LENGTHS)
    robot = fb.FiveBar(*(scale * x for x in LENGTHS))
    for function in (fb.aspects, lambda robot: fb.dexterous(robot, 0.3, 0.3)):
        for one, other in zip(function(unit), function(robot), strict=True):
            assert other.working == one.working
            assert other.area == pytest.approx(scale**2 * one.area, rel=1e-12)
    one, other = (fb.largest_disc(fb.aspects(each)[1]) for each in (unit, robot))
    assert other.radius == pytest.approx(scale * one.radius, rel=1e-9)
    one, other = (fb.largest_rectangle(fb.aspects(each)[1]) for each in (unit, robot))
    assert other.area == pytest.approx(scale**2 * one.area, rel=1e-6)


@pytest.mark.parametrize("scale", [5e-8, 6e-6, 1e3, 1e7])
def test_motions_scale_with_the_robot(scale):
    """Torques by the square of the size, at one mass: the same motion in the same time."""

    def duration(scale):
        robot = fb.FiveBar(*(scale * x for x in LENGTHS), 1e-3 * scale**2, 1.2e-3 * scale**2, 0.2)
        path = fb.path([(0.01 * scale, 0.15 * scale), (0.03 * scale, 0.16 * scale)])
        limits = fb.Constraints(torque=scale**2)
        return fb.time_path(robot, path, constraints=limits, working=(1, -1)).duration

    assert duration(scale) == pytest.approx(duration(1.0), rel=1e-5)


@pytest.mark.parametrize("scale", (1e-3, 1.0, 1e3))
def test_lengths_that_are_almost_equal_are_settled_at_any_size(scale):
    def robot(share):
        lengths = np.array([0.1, 0.1 * (1 + share), 0.12, 0.15]) * scale
        return fb.FiveBar(*lengths.tolist(), d=0.07 * scale)

    near = settled(robot(1e-11))
    assert near.l11 == pytest.approx(near.l12, rel=1e-15) and near != robot(1e-11)
    assert settled(robot(1e-9)) == robot(1e-9)
