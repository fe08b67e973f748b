"""What lab 5 checks; its models are in exercises.py."""

import numpy as np
import pytest

from fivebar.grading.columns import resting
from fivebar.grading.samples import beside_type_2, moving, poses, unequal_robot

NEAR = np.array([1, -1] * 6) * np.logspace(-1.2, -2.2, 12)


@pytest.mark.points(1)
def test_dynamic_model_at_rest(ask, robot, draw):
    """dynamic_model: at rest"""
    ask("dynamic_model", *resting(poses(robot, draw, 12)))


@pytest.mark.points(3)
def test_dynamic_model_regular(ask, robot, draw):
    """dynamic_model: regular poses, assembly mode -1"""
    ask("dynamic_model", *moving(poses(robot, draw, 16, assembly=-1), draw))


@pytest.mark.points(1)
def test_dynamic_model_modes(ask, robot, draw):
    """dynamic_model: all modes"""
    ask("dynamic_model", *moving(poses(robot, draw, 16), draw))


@pytest.mark.points(3)
def test_dynamic_model_unequal(ask, draw):
    """dynamic_model: bars and inertias all different"""
    other = unequal_robot(draw)
    ask("dynamic_model", *moving(poses(other, draw, 16), draw), robot=other)


@pytest.mark.points(1)
def test_dynamic_model_near_singularity(ask, robot, draw):
    """dynamic_model: close to a Type-2 singularity"""
    ask(
        "dynamic_model",
        *moving(beside_type_2(robot, draw, NEAR), draw),
        tolerance=1e-9 + 1e-13 / NEAR**2,
    )


@pytest.mark.points(1)
def test_inverse_dynamics_at_rest(ask, robot, draw):
    """inverse_dynamics: at rest"""
    ask("inverse_dynamics", *resting(poses(robot, draw, 12)), *draw.uniform(-20, 20, (2, 12)))


@pytest.mark.points(2)
def test_inverse_dynamics_regular(ask, robot, draw):
    """inverse_dynamics: regular poses of all modes"""
    ask("inverse_dynamics", *moving(poses(robot, draw, 16), draw), *draw.uniform(-20, 20, (2, 16)))


@pytest.mark.points(2)
def test_inverse_dynamics_unequal(ask, draw):
    """inverse_dynamics: bars and inertias all different"""
    other = unequal_robot(draw)
    rows = moving(poses(other, draw, 16), draw)
    ask("inverse_dynamics", *rows, *draw.uniform(-20, 20, (2, 16)), robot=other)


@pytest.mark.points(1)
def test_forward_dynamics_at_rest(ask, robot, draw):
    """forward_dynamics: at rest"""
    ask("forward_dynamics", *resting(poses(robot, draw, 12)), *draw.uniform(-0.2, 0.2, (2, 12)))


@pytest.mark.points(2)
def test_forward_dynamics_regular(ask, robot, draw):
    """forward_dynamics: regular poses of all modes"""
    ask(
        "forward_dynamics", *moving(poses(robot, draw, 16), draw), *draw.uniform(-0.2, 0.2, (2, 16))
    )


@pytest.mark.points(2)
def test_forward_dynamics_unequal(ask, draw):
    """forward_dynamics: bars and inertias all different"""
    other = unequal_robot(draw)
    rows = moving(poses(other, draw, 16), draw)
    ask("forward_dynamics", *rows, *draw.uniform(-0.2, 0.2, (2, 16)), robot=other)


@pytest.mark.points(1)
def test_forward_dynamics_near_singularity(ask, robot, draw):
    """forward_dynamics: close to a Type-2 singularity"""
    rows = moving(beside_type_2(robot, draw, NEAR), draw)
    ask(
        "forward_dynamics",
        *rows,
        *draw.uniform(-0.2, 0.2, (2, 12)),
        tolerance=1e-9 + 1e-14 / NEAR**4,
    )
