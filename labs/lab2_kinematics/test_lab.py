"""What lab 2 checks; its models are in exercises.py."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.grading.columns import batch, joints
from fivebar.grading.samples import beside_type_1, beside_type_2, poses, unequal_robot

NEAR = np.array([1, -1] * 6) * np.logspace(-1.5, -3.5, 12)
# Sines on both sides of 1e-9, with which one of the bars' pairs is almost singular, twice.
AT = np.array([1e-13, 3e-12, 1e-8, 1e-5] * 2)
SINES = np.append(np.ones(4), AT)
REFUSED = SINES < 1e-9
# Of the largest answer, which is that at 1e-8; the sines are accurate to rounding error.
TOLERANCES = 1e-8 / SINES * (1e-9 + 1e-13 / SINES)


def velocity(draw, n, size=0.3):
    return draw.uniform(-size, size, (2, n))


@pytest.mark.points(1)
def test_a_regular(ask, robot, draw):
    """A: regular poses, assembly mode -1"""
    ask("A", *joints(poses(robot, draw, 16, assembly=-1)))


@pytest.mark.points(1)
def test_a_modes(ask, draw):
    """A: all modes, bars of different lengths"""
    other = unequal_robot(draw)
    ask("A", *joints(poses(other, draw, 16)), robot=other)


@pytest.mark.points(2)
def test_b_regular(ask, robot, draw):
    """B: regular poses of all modes"""
    ask("B", *joints(poses(robot, draw, 16)))


@pytest.mark.points(1)
def test_b_unequal(ask, draw):
    """B: four bars of different lengths"""
    other = unequal_robot(draw)
    ask("B", *joints(poses(other, draw, 16)), robot=other)


@pytest.mark.points(2)
def test_dkm_regular(ask, robot, draw):
    """dkm: regular poses, assembly mode -1"""
    ask("dkm", *joints(poses(robot, draw, 16, assembly=-1)), *velocity(draw, 16, 3.0))


@pytest.mark.points(1)
def test_dkm_modes(ask, robot, draw):
    """dkm: all modes"""
    ask("dkm", *joints(poses(robot, draw, 16)), *velocity(draw, 16, 3.0))


@pytest.mark.points(1)
def test_dkm_unequal(ask, draw):
    """dkm: four bars of different lengths"""
    other = unequal_robot(draw)
    ask("dkm", *joints(poses(other, draw, 16)), *velocity(draw, 16, 3.0), robot=other)


@pytest.mark.points(1)
def test_dkm_near_singularity(ask, robot, draw):
    """dkm: close to a Type-2 singularity"""
    pose = beside_type_2(robot, draw, NEAR)
    ask("dkm", *joints(pose), *velocity(draw, 12, 3.0), tolerance=1e-9 + 1e-14 / NEAR**2)


@pytest.mark.points(1)
def test_dkm_at_singularity(ask, robot, draw):
    """dkm: at a Type-2 singularity"""
    singular = beside_type_2(robot, draw, AT * np.repeat([1, -1], 4))
    rows = batch(joints(poses(robot, draw, 4)), joints(singular))
    ask("dkm", *rows, *velocity(draw, 12, 3.0), tolerance=TOLERANCES, refuse=REFUSED)


@pytest.mark.points(2)
def test_ikm_regular(ask, robot, draw):
    """ikm: regular poses of all modes"""
    ask("ikm", *joints(poses(robot, draw, 16)), *velocity(draw, 16))


@pytest.mark.points(1)
def test_ikm_unequal(ask, draw):
    """ikm: four bars of different lengths"""
    other = unequal_robot(draw)
    ask("ikm", *joints(poses(other, draw, 16)), *velocity(draw, 16), robot=other)


@pytest.mark.points(1)
def test_ikm_near_singularity(ask, robot, draw):
    """ikm: close to a Type-1 singularity"""
    rows = batch(*(joints(beside_type_1(robot, draw, NEAR, leg)) for leg in (0, 1)))
    ask("ikm", *rows, *velocity(draw, 24), tolerance=1e-9 + 1e-14 / np.tile(NEAR, 2) ** 2)


@pytest.mark.points(1)
def test_ikm_at_singularity(ask, robot, draw):
    """ikm: at a Type-1 singularity"""
    flat = [list(joints(beside_type_1(robot, draw, np.full(4, 1e-6), leg))) for leg in (0, 1)]
    flat[0][1], flat[1][3] = AT[:4], -AT[:4]  # the leg is almost straight
    rows = batch(joints(poses(robot, draw, 4)), *flat)
    ask("ikm", *rows, *velocity(draw, 12), tolerance=TOLERANCES, refuse=REFUSED)


@pytest.mark.points(2)
def test_dkm_passive_regular(ask, robot, draw):
    """dkm_passive: regular poses of all modes"""
    rates = fb.ikm(poses(robot, draw, 16), velocity(draw, 16).T)
    ask("dkm_passive", *joints(rates.pose), *rates.q_dot.T, *rates.xi_dot.T)


@pytest.mark.points(1)
def test_dkm_passive_unequal(ask, draw):
    """dkm_passive: four bars of different lengths"""
    other = unequal_robot(draw)
    rates = fb.ikm(poses(other, draw, 16), velocity(draw, 16).T)
    ask("dkm_passive", *joints(rates.pose), *rates.q_dot.T, *rates.xi_dot.T, robot=other)


@pytest.mark.points(1)
def test_dkm_passive_near_singularity(ask, robot, draw):
    """dkm_passive: close to singularities of both types, where it stays regular"""
    parallel = fb.ikm(beside_type_2(robot, draw, NEAR), velocity(draw, 12).T)
    serial = fb.dkm(beside_type_1(robot, draw, NEAR, 0), velocity(draw, 12, 3.0).T)
    rows = [(*joints(rates.pose), *rates.q_dot.T, *rates.xi_dot.T) for rates in (parallel, serial)]
    ask("dkm_passive", *batch(*rows))
