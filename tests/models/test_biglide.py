"""The biglide: the lab's home, modes, what it says of bad input, the lab's ten functions, robots from parameters."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fivebar as fb
from fivebar import amoro
from fivebar.models.parameters import robot_of

LAB = fb.Biglide()
UNEQUAL = fb.Biglide(l1=0.5, l2=0.3, d=0.35, mf1=0.7, mf2=1.4, m=2.0)
MODES = [(a, b) for a in (1, -1) for b in (1, -1)]


def test_the_labs_home():
    pose = fb.dgm(LAB, (0.0, 0.0))
    assert pose.xi == pytest.approx((0.0, math.sqrt(0.2828427**2 - 0.2**2)), abs=1e-16)
    assert pose.q_passive == pytest.approx((0.7853981, 2.3561945), abs=1e-7)
    assert (int(pose.assembly), pose.working.tolist()) == (-1, [-1, -1])
    assert fb.igm(LAB, pose.xi).q == pytest.approx((0.0, 0.0), abs=1e-16)
    assert fb.ROBOTS["biglide"].robot == LAB


@pytest.mark.parametrize("robot", [LAB, UNEQUAL], ids=["lab", "unequal"])
def test_four_working_and_two_assembly_modes(robot):
    rng = np.random.default_rng(3)
    xi = np.stack([rng.uniform(-0.07, 0.07, 200), rng.uniform(-3, 3, 200)], axis=1)
    poses = [fb.igm(robot, xi, mode) for mode in MODES]
    for mode, pose in zip(MODES, poses):
        assert (pose.working == mode).all() and (
            np.diagonal(pose.B, axis1=1, axis2=2) * mode < 0
        ).all()
        regular = pose.assembly != 0
        back = fb.dgm(robot, pose.q[regular], pose.assembly[regular])
        assert np.abs(back.xi - xi[regular]).max() < 1e-9
        assert (back.working == pose.working[regular]).all()
        assert (np.sign(np.linalg.det(pose.A)) == -pose.assembly).all()
        # The bar's angle is absolute, and the foot is below the end-effector by its rise.
        rise = np.array(robot.distal) * np.sin(pose.q_passive)
        np.testing.assert_allclose(pose.q, xi[:, 1:] - rise, atol=1e-15)
    assert len({tuple(np.round(pose.q[0], 9)) for pose in poses}) == 4


@given(st.floats(-0.08, 0.08), st.floats(-50, 50), st.sampled_from(MODES), st.floats(-20, 20))
def test_moving_along_the_guides_changes_nothing_else(x, y, mode, by):
    here, there = fb.igm(LAB, (x, y), mode), fb.igm(LAB, (x, y + by), mode)
    assert there.q == pytest.approx(here.q + by, abs=1e-13)
    assert (there.sines, there.u2) == (here.sines, here.u2)
    rates = fb.ikm(here, (0.0, 3.0))
    assert rates.q_dot == pytest.approx((3.0, 3.0), rel=1e-15) and (rates.q_passive_dot == 0).all()


def test_unreachable_says_by_how_much_and_which_leg():
    with pytest.raises(
        fb.UnreachableError,
        match=r"left leg.*guide are 0\.3 m apart.*0\.2828427 m \(gap 0\.0172 m\)",
    ):
        fb.igm(LAB, (0.1, 5.0))
    with pytest.raises(fb.UnreachableError, match="right leg") as error:
        fb.igm(LAB, [(0.0, 0.0), (-0.1, 0.2)])
    assert error.value.index == (1,) and error.value.gap == pytest.approx(
        0.3 - 0.2828427, abs=1e-15
    )
    with pytest.raises(
        fb.UnreachableError, match=r"the feet are 0\.64.* m apart, the longest"
    ) as error:
        fb.dgm(LAB, (0.0, 0.5))
    assert error.value.gap == pytest.approx(math.hypot(0.4, 0.5) - 0.5656854, abs=1e-15)
    with pytest.raises(fb.UnreachableError, match="the feet are .* the shortest"):
        fb.dgm(fb.Biglide(l1=0.9, l2=0.3), (0.0, 0.1))
    with pytest.raises(fb.SingularityError, match="the feet coincide: phi1 and phi2 are left free"):
        fb.dgm(fb.Biglide(d=0.0), (0.2, 0.2))
    nan = fb.igm(LAB, [(0.1, 0.0), (0.0, 0.0)], unreachable="nan")
    assert np.isnan(nan.q[0]).any() and np.isfinite(nan.q[1]).all()
    assert nan.assembly.tolist() == [0, -1]


@pytest.mark.parametrize("k", range(200))
def test_a_bar_across_its_guide_is_reached(k):
    """One in a few of these ends rounds to beyond the bar's length."""
    rng = np.random.default_rng(k)
    l1, d = rng.uniform(0.1, 1), rng.uniform(0.1, 0.9)
    robot = fb.Biglide(l1=l1, l2=1.5, d=d)
    pose = fb.igm(robot, (-d / 2 + l1, 0.3))
    assert np.isfinite(pose.q).all() and abs(pose.sines[0]) < 1e-7


def test_singular_models_speak_of_this_robot():
    serial = fb.igm(LAB, (-0.2 + 0.2828427, 0.3))
    with pytest.raises(
        fb.SingularityError,
        match=r"ikm: B is singular \(Type 1\): sin phi1 = .* at q = \(.*\) m, xi",
    ):
        fb.ikm(serial, (0.1, 0.0))
    rates = fb.dkm(serial, (0.1, 0.2))
    assert np.isfinite(fb.forward_dynamics(rates, (1.0, 2.0)).q_ddot).all()
    parallel = fb.igm(LAB, (0.0, 0.3), (-1, 1))
    assert parallel.assembly == 0
    with pytest.raises(fb.SingularityError, match=r"dkm: A is singular \(Type 2\): det A"):
        fb.dkm(parallel, (0.1, 0.2))
    across = fb.forward_dynamics(fb.ikm(parallel, (0.2, 0.1)), (1.0, -2.0))
    assert np.isfinite(across.xi_ddot).all() and np.isfinite(across.q_ddot).all()
    with pytest.raises(ValueError, match="needs mf2 > 0, as it divides the force by it"):
        fb.forward_dynamics(fb.dkm(fb.dgm(fb.Biglide(mf2=0), (0, 0)), (0, 0)), (0, 0))
    both = fb.Biglide(l1=0.3, l2=0.3, d=0.6)
    with pytest.raises(fb.SingularityError, match="carry no force"):
        fb.forward_dynamics(fb.Rates(fb.igm(both, (0.0, 0.0)), (0.0, 0.0), (0.0, 0.0)), (1.0, 1.0))


@pytest.mark.parametrize(
    "change, words",
    [
        (dict(l1=0.0), "l1 must be finite and > 0"),
        (dict(mf1=-1), "mf1 must be finite and >= 0"),
        (dict(m=math.nan), "m must be finite"),
        (dict(d="wide"), "d must be a number"),
        (dict(l2=True), "l2 must be fin"),
        (
            dict(d=0.6),
            r"this robot can never close: d = 0\.6 m is longer than l1 \+ l2 = 0\.565685 m, by 0\.0343146 m",
        ),
    ],
)
def test_robots_that_cannot_be(change, words):
    with pytest.raises(ValueError, match=words):
        fb.Biglide(**change)


def test_a_long_bar_is_no_hindrance():
    pose = fb.igm(fb.Biglide(l1=0.1, l2=0.9), (-0.25, 0.0))
    assert np.isfinite(pose.q).all()


def test_robots_from_parameters():
    assert robot_of({"mf1": 2.0}) == fb.Biglide(mf1=2.0)
    assert robot_of({"m": 2.0}) == fb.FiveBar(m=2.0)
    with pytest.raises(
        ValueError,
        match="no parameter l3 of a biglide robot; the known ones are l1, l2, d, mf1, mf2, m",
    ):
        robot_of({"l1": 1.0, "l3": 2.0})


@pytest.mark.parametrize("robot", [LAB, UNEQUAL], ids=["lab", "unequal"])
def test_the_labs_ten_functions(robot):
    lab = amoro.models(robot)
    for mode in MODES:
        for xi in ((0.03, 0.2), (-0.05, -0.4)):
            pose = fb.igm(robot, xi, mode)
            rates = fb.ikm(pose, (0.2, -0.1))
            acc = fb.forward_dynamics(rates, (3.0, -2.0))
            q11, q21 = lab.igm(*xi, *mode)
            assert lab.dgm(q11, q21, int(pose.assembly)) == pytest.approx(xi, abs=1e-13)
            phi = lab.dgm_passive(q11, q21, int(pose.assembly))
            foot = np.array([-robot.d / 2, q11])
            assert foot + robot.l1 * np.array(
                [math.cos(phi[0]), math.sin(phi[0])]
            ) == pytest.approx(xi, abs=1e-13)
            joints = q11, phi[0], q21, phi[1]
            q11D, q21D = lab.ikm(*joints, 0.2, -0.1)
            assert lab.dkm(*joints, q11D, q21D) == pytest.approx((0.2, -0.1), abs=1e-12)
            phiD = lab.dkm_passive(*joints, q11D, q21D, 0.2, -0.1)
            assert phiD == pytest.approx(rates.q_passive_dot, rel=1e-10, abs=1e-11)
            motion = *joints, q11D, phiD[0], q21D, phiD[1]
            assert lab.dkm2(*motion, *acc.q_ddot) == pytest.approx(acc.xi_ddot, rel=1e-9, abs=1e-9)
            assert lab.ikm2(*motion, *acc.xi_ddot) == pytest.approx(acc.q_ddot, rel=1e-9, abs=1e-9)
            passive = lab.dkm2_passive(*motion, *acc.q_ddot, *acc.xi_ddot)
            assert passive == pytest.approx(acc.q_passive_ddot, rel=1e-9, abs=1e-9)
            M, c = lab.dynamic_model(*motion)
            assert M @ acc.q_ddot + c == pytest.approx([3.0, -2.0], abs=1e-9)
