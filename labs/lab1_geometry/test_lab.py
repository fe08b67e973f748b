"""What lab 1 checks; its models are in exercises.py."""

import numpy as np
import pytest

from fivebar.grading.samples import beside_type_1, beside_type_2, poses, unequal_robot

NEAR = np.array([1, -1] * 6) * np.logspace(-2, -5, 12)


def opened(robot, draw, n):
    """Active angles for which the elbows are too far apart."""
    q = draw.uniform(-np.pi, np.pi, (400, 2))
    x = robot.d + robot.l21 * np.cos(q[:, 1]) - robot.l11 * np.cos(q[:, 0])
    gap = np.hypot(x, robot.l21 * np.sin(q[:, 1]) - robot.l11 * np.sin(q[:, 0])) / (
        robot.l12 + robot.l22
    )
    return q[gap > 1.01][:n]


@pytest.mark.points(3)
def test_dgm_regular(ask, robot, draw):
    """dgm: regular poses, assembly mode -1"""
    pose = poses(robot, draw, 16, assembly=-1)
    ask("dgm", *pose.q.T, pose.assembly)


@pytest.mark.points(1)
def test_dgm_modes(ask, robot, draw):
    """dgm: both assembly modes"""
    pose = poses(robot, draw, 16)
    ask("dgm", *pose.q.T, pose.assembly)


@pytest.mark.points(1)
def test_dgm_unequal(ask, draw):
    """dgm: four bars of different lengths"""
    other = unequal_robot(draw)
    pose = poses(other, draw, 16)
    ask("dgm", *pose.q.T, pose.assembly, robot=other)


@pytest.mark.points(1)
def test_dgm_near_singularity(ask, robot, draw):
    """dgm: distal bars almost in line"""
    pose = beside_type_2(robot, draw, NEAR)
    ask("dgm", *pose.q.T, pose.assembly, tolerance=1e-9 + 1e-14 / np.abs(NEAR))


@pytest.mark.points(1)
def test_dgm_unreachable(ask, robot, draw):
    """dgm: elbows too far apart"""
    pose, far = poses(robot, draw, 8), opened(robot, draw, 8)
    q, modes = np.concatenate([pose.q, far]), np.concatenate([pose.assembly, np.tile([-1, 1], 4)])
    ask("dgm", *q.T, modes, refuse=np.arange(16) >= 8)


@pytest.mark.points(3)
def test_igm_regular(ask, robot, draw):
    """igm: regular poses, working modes -1, -1"""
    pose = poses(robot, draw, 16, working=(-1, -1))
    ask("igm", *pose.xi.T, *pose.working.T)


@pytest.mark.points(2)
def test_igm_modes(ask, robot, draw):
    """igm: all four working modes"""
    modes = [(1, 1), (1, -1), (-1, 1), (-1, -1)]
    parts = [poses(robot, draw, 4, working=mode) for mode in modes]
    ask(
        "igm",
        *np.concatenate([p.xi for p in parts]).T,
        *np.concatenate([p.working for p in parts]).T,
    )


@pytest.mark.points(1)
def test_igm_unequal(ask, draw):
    """igm: four bars of different lengths"""
    other = unequal_robot(draw)
    pose = poses(other, draw, 16)
    ask("igm", *pose.xi.T, *pose.working.T, robot=other)


@pytest.mark.points(1)
def test_igm_near_singularity(ask, robot, draw):
    """igm: a leg almost stretched"""
    parts = [beside_type_1(robot, draw, NEAR, leg) for leg in (0, 1)]
    xi, modes = np.concatenate([p.xi for p in parts]), np.concatenate([p.working for p in parts])
    ask("igm", *xi.T, *modes.T, tolerance=1e-9 + 1e-14 / np.abs(np.tile(NEAR, 2)))


@pytest.mark.points(1)
def test_igm_unreachable(ask, robot, draw):
    """igm: end-effector out of reach of a leg"""
    pose = poses(robot, draw, 8)
    angle, far = draw.uniform(-1, 1, 8), draw.uniform(1.02, 1.3, 8)
    side = np.tile([1, -1], 4)
    span = far * (np.where(side > 0, robot.l11 + robot.l12, robot.l21 + robot.l22))
    x, y = side * (span * np.cos(angle) - robot.d / 2), span * np.sin(angle)
    modes = np.concatenate([pose.working, np.tile([[1, -1], [-1, -1]], (4, 1))])
    ask(
        "igm", np.r_[pose.xi[:, 0], x], np.r_[pose.xi[:, 1], y], *modes.T, refuse=np.arange(16) >= 8
    )


@pytest.mark.points(2)
def test_dgm_passive_regular(ask, robot, draw):
    """dgm_passive: regular poses, assembly mode -1"""
    pose = poses(robot, draw, 16, assembly=-1)
    ask("dgm_passive", *pose.q.T, pose.assembly)


@pytest.mark.points(1)
def test_dgm_passive_modes(ask, robot, draw):
    """dgm_passive: both assembly modes"""
    pose = poses(robot, draw, 16)
    ask("dgm_passive", *pose.q.T, pose.assembly)


@pytest.mark.points(1)
def test_dgm_passive_unequal(ask, draw):
    """dgm_passive: four bars of different lengths"""
    other = unequal_robot(draw)
    pose = poses(other, draw, 16)
    ask("dgm_passive", *pose.q.T, pose.assembly, robot=other)


@pytest.mark.points(1)
def test_dgm_passive_near_singularity(ask, robot, draw):
    """dgm_passive: distal bars almost in line"""
    pose = beside_type_2(robot, draw, NEAR)
    ask("dgm_passive", *pose.q.T, pose.assembly, tolerance=1e-9 + 1e-14 / np.abs(NEAR))
