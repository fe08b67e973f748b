"""What lab 3 checks; its models are in exercises.py."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.grading.columns import batch, joint_motion, resting
from fivebar.grading.samples import (
    accelerated,
    beside_type_1,
    beside_type_2,
    moving,
    poses,
    unequal_robot,
)

NEAR = np.array([1, -1] * 6) * np.logspace(-1.2, -3, 12)
LOOSE = 1e-9 + 1e-14 / NEAR**2


@pytest.mark.points(1)
def test_dkm2_at_rest(ask, robot, draw):
    """dkm2: at rest"""
    ask("dkm2", *resting(poses(robot, draw, 12)), *draw.uniform(-20, 20, (2, 12)))


@pytest.mark.points(2)
def test_dkm2_regular(ask, robot, draw):
    """dkm2: regular poses, assembly mode -1"""
    ask("dkm2", *moving(poses(robot, draw, 16, assembly=-1), draw), *draw.uniform(-20, 20, (2, 16)))


@pytest.mark.points(1)
def test_dkm2_modes(ask, robot, draw):
    """dkm2: all modes"""
    ask("dkm2", *moving(poses(robot, draw, 16), draw), *draw.uniform(-20, 20, (2, 16)))


@pytest.mark.points(2)
def test_dkm2_unequal(ask, draw):
    """dkm2: four bars of different lengths"""
    other = unequal_robot(draw)
    rows = moving(poses(other, draw, 16), draw)
    ask("dkm2", *rows, *draw.uniform(-20, 20, (2, 16)), robot=other)


@pytest.mark.points(1)
def test_dkm2_near_singularity(ask, robot, draw):
    """dkm2: close to a Type-2 singularity"""
    rows = moving(beside_type_2(robot, draw, NEAR), draw)
    ask("dkm2", *rows, *draw.uniform(-20, 20, (2, 12)), tolerance=LOOSE)


@pytest.mark.points(1)
def test_ikm2_at_rest(ask, robot, draw):
    """ikm2: at rest"""
    ask("ikm2", *resting(poses(robot, draw, 12)), *draw.uniform(-2, 2, (2, 12)))


@pytest.mark.points(2)
def test_ikm2_regular(ask, robot, draw):
    """ikm2: regular poses of all modes"""
    ask("ikm2", *moving(poses(robot, draw, 16), draw), *draw.uniform(-2, 2, (2, 16)))


@pytest.mark.points(2)
def test_ikm2_unequal(ask, draw):
    """ikm2: four bars of different lengths"""
    other = unequal_robot(draw)
    rows = moving(poses(other, draw, 16), draw)
    ask("ikm2", *rows, *draw.uniform(-2, 2, (2, 16)), robot=other)


@pytest.mark.points(1)
def test_ikm2_near_singularity(ask, robot, draw):
    """ikm2: close to a Type-1 singularity"""
    rates = [
        fb.dkm(beside_type_1(robot, draw, NEAR, leg), draw.uniform(-3, 3, (12, 2)))
        for leg in (0, 1)
    ]
    rows = batch(*(joint_motion(part) for part in rates))
    ask("ikm2", *rows, *draw.uniform(-2, 2, (2, 24)), tolerance=np.tile(LOOSE, 2))


@pytest.mark.points(3)
def test_dkm2_passive_regular(ask, robot, draw):
    """dkm2_passive: regular poses, assembly mode -1"""
    ask("dkm2_passive", *accelerated(poses(robot, draw, 16, assembly=-1), draw))


@pytest.mark.points(1)
def test_dkm2_passive_modes(ask, robot, draw):
    """dkm2_passive: all modes"""
    ask("dkm2_passive", *accelerated(poses(robot, draw, 16), draw))


@pytest.mark.points(2)
def test_dkm2_passive_unequal(ask, draw):
    """dkm2_passive: four bars of different lengths"""
    other = unequal_robot(draw)
    ask("dkm2_passive", *accelerated(poses(other, draw, 16), draw), robot=other)


@pytest.mark.points(1)
def test_dkm2_passive_near_singularity(ask, robot, draw):
    """dkm2_passive: close to a Type-2 singularity, where it stays regular"""
    ask("dkm2_passive", *accelerated(beside_type_2(robot, draw, NEAR), draw))
