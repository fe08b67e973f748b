"""Drives and dyads alone: their slopes by differences, what they reach, and bars in line whatever the rounding."""

import casadi
import mpmath as mp
import numpy as np
import pytest

import fivebar as fb
from fivebar.models.dyads import Crank, Slider, cross, dot
from fivebar.models.four_joints import closed, loop_gap, rates_from_joint_state
from fivebar.models.robots import must_close

from ..conftest import UNEQUAL


@pytest.mark.parametrize("drive", [Crank(-0.06, 0.02, 0.13), Slider(-0.2, 0.03)])
def test_what_a_drive_says_of_its_pivot(drive):
    q, h, u2 = 0.7, 1e-4, (np.cos(1.9), np.sin(1.9))
    before, at, after = (np.array(drive.pivot(drive.direction(q + step))) for step in (-h, 0.0, h))
    direction, v2 = drive.direction(q), np.array([-u2[1], u2[0]])
    assert drive.coordinate(direction) == pytest.approx(q, abs=1e-15)
    slope, bend = (after - before) / (2 * h), (after - 2 * at + before) / h**2
    assert drive.tangent(direction) == pytest.approx(slope, abs=1e-8)
    sine, cosine = drive.sine(direction, u2), drive.cosine(direction, u2)
    assert drive.velocity_coefficients(sine, cosine) == pytest.approx(
        (u2 @ slope, v2 @ slope), abs=1e-8
    )
    assert drive.acceleration_coefficients(sine, cosine) == pytest.approx(
        (u2 @ bend, v2 @ bend), abs=1e-6
    )
    assert drive.absolute(drive.relative(0.3, 0.1), 0.1) == pytest.approx(0.3)
    assert drive.extent(direction) >= np.abs(at).sum()
    # Its limits are where the leg straightens or folds: of the distance from `apart`.
    bar, far = 0.05, np.array([0.31, -0.24])
    for limit, outer in drive.limits(bar):
        away = np.array(drive.apart(*far))
        for inside in (True, False):
            nearer = 1 - 1e-9 if inside == outer else 1 + 1e-9
            xi = far + away * (limit / np.hypot(*away) * nearer - 1)
            assert (
                np.isfinite(drive.coordinate(drive.direction_in(drive.close(xi, bar, 1)))) == inside
            ), (limit, inside)
    assert np.isfinite(drive.apart(0.3, 0.0)).all() and drive.apart(*drive[:2]) == (0.0, 0.0)
    assert len(drive.limits(bar)) == (2 if isinstance(drive, Crank) else 1)


@pytest.mark.parametrize("branch", [1, -1])
def test_a_dyad_closes_from_both_pivots_on_the_side_of_its_branch(branch):
    first, second = np.array([0.03, -0.02]), np.array([0.14, 0.05])
    dyad = Crank(*second, 0.09).close(first, 0.07, branch)
    joint = second + 0.09 * np.array(dyad.first)
    assert joint + 0.07 * np.array(dyad.last) == pytest.approx(first, abs=1e-16)
    assert first + 0.07 * np.array(dyad.second) == pytest.approx(joint, abs=1e-16)
    assert dyad.sine == pytest.approx(cross(dyad.first, dyad.second), abs=1e-15)
    assert np.sign(cross(first - second, joint - second)) == branch
    span = np.hypot(*(first - second))
    assert dyad.clearances == pytest.approx((0.16 - span, span - 0.02), abs=1e-16)
    slides = Slider(0.1, 0.02).close((0.16, 0.3), 0.09, branch)
    foot = np.array([0.1, 0.02 + slides.slide])
    assert np.array([0.16, 0.3]) + 0.09 * np.array(slides.first) == pytest.approx(foot, abs=1e-16)
    assert slides.sine == pytest.approx(cross(slides.first, slides.second), abs=1e-15)
    assert np.sign(foot[1] - 0.3) == branch and dot(slides.second, (0.0, 1.0)) == 0
    assert slides.height == pytest.approx(-0.06, abs=1e-16)  # on the guide's right
    assert slides.clearances == (pytest.approx(0.03, abs=1e-16),)


def test_short_bars_in_line_between_far_elbows_close_whatever_the_rounding():
    """Elbows exactly l12 + l22 or |l12 - l22| apart, to the rounding of pivots that are 100 times as far away."""
    rng = np.random.default_rng(7)
    for k in range(300):
        base, near = rng.uniform(-1, 1), rng.uniform(0.01, 0.03)
        q1 = rng.uniform(0.5, 1.5)
        elbow = -0.25 + np.cos(q1) + near * np.cos(base) - 0.25, np.sin(q1) + near * np.sin(base)
        l21, q2 = np.hypot(*elbow), np.arctan2(elbow[1], elbow[0])
        turn = l21 * mp.expj(mp.mpf(q2)) - mp.expj(mp.mpf(q1)) + 0.5
        span = float(abs(turn))
        share = rng.uniform(0.3, 0.7)
        bars = (share * span, span - share * span) if k % 2 else (span + share * span, share * span)
        pose = fb.dgm(fb.FiveBar(1.0, bars[0], l21, bars[1], 0.5), (q1, q2), unreachable="nan")
        assert np.isfinite(pose.xi).all() and abs(pose.det_A) < 1e-5, k


def test_a_drive_that_is_not_free_stays_where_the_loop_is_closed():
    rng, off = np.random.default_rng(1), np.array([1e-8, -2e-8, 3e-8, 1e-8])
    for robot, start in ((UNEQUAL, (0.02, 0.15)), (fb.Biglide(), (0.02, 0.2))):
        pose = fb.igm(robot, start)
        a = np.array(
            [pose.q[0], np.arctan2(*pose.u2[0][::-1]), pose.q[1], np.arctan2(*pose.u2[1][::-1])]
        )
        a_dot = rng.normal(size=4)
        for free in ((0.0, 1.0), (1.0, 0.0)):
            held = 2 * free.index(0.0)
            still = np.where(np.arange(4) == held, 0.0, a_dot)
            found, rates_found, rates = closed(robot, tuple(a + off), tuple(still), free)
            assert found[held] == (a + off)[held] and rates_found[held] == 0
            assert np.hypot(*loop_gap(rates.pose)) < 1e-15
            seen = rates_from_joint_state(
                robot, found[::2], rates.pose.point, rates._q_dot, rates._xi_dot
            )
            assert seen.phi_dot == pytest.approx((rates_found[1], rates_found[3]), abs=1e-8)


@pytest.mark.parametrize("robot", [UNEQUAL, fb.Biglide()])
@pytest.mark.parametrize("alone", [True, False])
def test_a_large_batch_is_many_small_ones(robot, alone):
    """The end-effector of more than 8192 poses is found by stretches, the rest of them late."""
    rng = np.random.default_rng(3)
    q, modes = rng.uniform(-0.1, 0.1, (2, 4200, 2)), rng.choice([-1, 1], (2, 4200))
    modes = -1 if alone else modes
    whole, last = fb.dgm(robot, q, modes), (1, slice(4000, 4200))
    part = fb.dgm(robot, q[last], modes if alone else modes[last])
    for name in (
        "xi",
        "A",
        "B",
        "q_passive",
        "elbows",
        "assembly",
        "working",
        "reach_margin",
        "det_A",
    ):
        np.testing.assert_array_equal(getattr(whole, name)[last], getattr(part, name), err_msg=name)


def test_symbols_take_no_batch_of_modes_and_close_unasked():
    xi = casadi.SX.sym("xi", 2)
    with pytest.raises(
        ValueError, match="working must be plain ints for CasADi symbols, not a batch"
    ):
        fb.igm(fb.FiveBar(), xi, np.ones((3, 2)))
    with pytest.raises(
        ValueError, match=r"working must be two modes in one argument, .* not shape \(3,\)"
    ):
        fb.igm(fb.FiveBar(), (0.0, 0.1), np.ones(3))
    with pytest.raises(
        ValueError, match=r"assembly of shape \(4,\) does not fit a batch of shape \(3,\)"
    ):
        fb.dgm(fb.FiveBar(), np.zeros((3, 2)), np.ones(4))
    with pytest.raises(ValueError, match="longest = 2 m is longer than a \\+ b = 1.5 m, by 0.5 m"):
        must_close("loop", {"a": 1.0, "longest": 2.0, "b": 0.5})
    must_close("loop", {"a": 1.0, "longest": 1.5, "b": 0.5})


POSE = fb.igm(fb.FiveBar(), (0.05, 0.09))


@pytest.mark.parametrize(
    "call",
    [
        lambda: fb.dgm(fb.FiveBar(), 0.2, -0.1),
        lambda: fb.igm(fb.FiveBar(), 0.05, 0.09),
        lambda: fb.igm(fb.Biglide(), np.float64(0.05), (-1, -1)),
        lambda: fb.dkm(POSE, 0.2),
        lambda: fb.ikm2(fb.ikm(POSE, (0.1, 0.0)), 1),
        lambda: fb.locus_distance(fb.FiveBar(), 0.05, (-1, -1)),
    ],
)
def test_a_single_number_for_a_pair_is_told_to_go_into_one_argument(call):
    with pytest.raises(
        ValueError, match=r"^\w+ must be two numbers in one argument, \(a, b\), not"
    ):
        call()


def test_torques_of_a_motion_at_given_times_are_named_like_its_joints():
    """`tau` is an array: of a Run, of a log, of a point of a motion."""
    for motion in (fb.Plan, fb.TimedPath):
        assert not hasattr(motion, "tau") and {"torques", "joints"} <= set(dir(motion))
