"""What lab 7 checks; its models are in exercises.py. The bonus' trajectories are judged by the exact model."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial import polynomial as power

import fivebar as fb
from fivebar.grading.columns import batch, joints
from fivebar.grading.samples import (
    accelerated,
    beside_type_1,
    beside_type_2,
    moving,
    poses,
    unequal_biglide,
)

NEAR = np.array([1, -1] * 6) * np.logspace(-1.5, -3.5, 12)
AT = np.arange(12) >= 8
CROSSING = (1, -1)  # the working modes of the bonus
SPEED = 0.5  # of the end-effector along x and y, at most, m/s
SHORTEST = 0.01  # s from an end to the crossing


def velocity(draw, n):
    return draw.uniform(-SPEED, SPEED, (2, n))


@pytest.mark.points(1)
def test_dgm_regular(ask, robot, draw):
    """dgm: regular poses, assembly mode -1"""
    pose = poses(robot, draw, 16, assembly=-1)
    ask("dgm", *pose.q.T, pose.assembly)


@pytest.mark.points(1)
def test_dgm_unequal(ask, draw):
    """dgm: both assembly modes, bars of different lengths"""
    other = unequal_biglide(draw)
    pose = poses(other, draw, 16)
    ask("dgm", *pose.q.T, pose.assembly, robot=other)


@pytest.mark.points(1)
def test_dgm_unreachable(ask, robot, draw):
    """dgm: feet too far apart"""
    some = poses(robot, draw, 8).q
    apart = (
        np.sqrt((robot.l1 + robot.l2) ** 2 - robot.d**2)
        * draw.uniform(1.02, 2, 8)
        * draw.choice([-1, 1], 8)
    )
    left = draw.uniform(-0.3, 0.3, 8)
    q = np.concatenate([some, np.stack([left, left + apart], -1)])
    ask("dgm", *q.T, draw.choice([-1, 1], 16), refuse=np.arange(16) >= 8)


@pytest.mark.points(1)
def test_igm_regular(ask, robot, draw):
    """igm: regular poses of all four working modes"""
    pose = poses(robot, draw, 16)
    ask("igm", *pose.xi.T, *pose.working.T)


@pytest.mark.points(1)
def test_igm_unequal(ask, draw):
    """igm: bars of different lengths"""
    other = unequal_biglide(draw)
    pose = poses(other, draw, 16)
    ask("igm", *pose.xi.T, *pose.working.T, robot=other)


@pytest.mark.points(1)
def test_igm_unreachable(ask, robot, draw):
    """igm: end-effector out of reach of a bar"""
    pose = poses(robot, draw, 8)
    x = draw.choice([-1, 1], 8) * (max(robot.distal) - robot.d / 2 + draw.uniform(0.005, 0.1, 8))
    rows = (
        (*pose.xi.T, *pose.working.T),
        (x, draw.uniform(-0.3, 0.3, 8), *draw.choice([-1, 1], (2, 8))),
    )
    ask("igm", *batch(*rows), refuse=np.arange(16) >= 8)


@pytest.mark.points(1)
def test_dgm_passive(ask, draw):
    """dgm_passive: both assembly modes, bars of different lengths"""
    other = unequal_biglide(draw)
    pose = poses(other, draw, 16)
    ask("dgm_passive", *pose.q.T, pose.assembly, robot=other)


@pytest.mark.points(1)
def test_dkm_regular(ask, robot, draw):
    """dkm: regular poses of all modes"""
    ask("dkm", *joints(poses(robot, draw, 16)), *velocity(draw, 16))


@pytest.mark.points(1)
def test_dkm_singularity(ask, robot, draw):
    """dkm: close to a Type-2 singularity, and at one"""
    near = joints(beside_type_2(robot, draw, NEAR[:8]))
    phi = draw.uniform(0.5, 1.2, 4)
    at = draw.uniform(-0.3, 0.3, 4), phi, draw.uniform(-0.3, 0.3, 4), phi
    limit = np.concatenate([1e-9 + 1e-14 / NEAR[:8] ** 2, np.ones(4)])
    ask("dkm", *batch(near, at), *velocity(draw, 12), tolerance=limit, refuse=AT)


@pytest.mark.points(1)
def test_ikm_regular(ask, robot, draw):
    """ikm: regular poses of all modes"""
    ask("ikm", *joints(poses(robot, draw, 16)), *velocity(draw, 16))


@pytest.mark.points(1)
def test_ikm_singularity(ask, robot, draw):
    """ikm: close to a Type-1 singularity, and at one"""
    near = [joints(beside_type_1(robot, draw, NEAR[leg:8:2], leg)) for leg in (0, 1)]
    flat = np.array(joints(beside_type_1(robot, draw, NEAR[:4], 0)))
    flat[1] = 0.0  # the left bar lies across its guide
    limit = np.concatenate(
        [1e-9 + 1e-14 / NEAR[:8:2] ** 2, 1e-9 + 1e-14 / NEAR[1:8:2] ** 2, np.ones(4)]
    )
    ask("ikm", *batch(*near, flat), *velocity(draw, 12), tolerance=limit, refuse=AT)


@pytest.mark.points(1)
def test_dkm_passive(ask, draw):
    """dkm_passive: all modes, bars of different lengths, also close to Type 2"""
    other = unequal_biglide(draw)
    rates = [
        fb.ikm(pose, velocity(draw, 12).T)
        for pose in (poses(other, draw, 12), beside_type_2(other, draw, NEAR))
    ]
    rows = batch(*((*joints(part.pose), *part.q_dot.T, *part.xi_dot.T) for part in rates))
    ask("dkm_passive", *rows, robot=other)


@pytest.mark.points(1)
def test_dkm2_regular(ask, robot, draw):
    """dkm2: regular poses of all modes"""
    ask("dkm2", *moving(poses(robot, draw, 16), draw, SPEED), *draw.uniform(-3, 3, (2, 16)))


@pytest.mark.points(1)
def test_dkm2_unequal(ask, draw):
    """dkm2: bars of different lengths, also close to Type 2"""
    other = unequal_biglide(draw)
    rows = batch(
        *(
            moving(pose, draw, SPEED)
            for pose in (poses(other, draw, 8), beside_type_2(other, draw, NEAR[:8]))
        )
    )
    limit = 1e-9 + np.concatenate([np.zeros(8), 1e-14 / NEAR[:8] ** 2])
    ask("dkm2", *rows, *draw.uniform(-3, 3, (2, 16)), tolerance=limit, robot=other)


@pytest.mark.points(1)
def test_ikm2(ask, draw):
    """ikm2: all modes, bars of different lengths"""
    other = unequal_biglide(draw)
    ask(
        "ikm2",
        *moving(poses(other, draw, 16), draw, SPEED),
        *draw.uniform(-3, 3, (2, 16)),
        robot=other,
    )


@pytest.mark.points(1)
def test_dkm2_passive(ask, draw):
    """dkm2_passive: all modes, bars of different lengths"""
    other = unequal_biglide(draw)
    ask("dkm2_passive", *accelerated(poses(other, draw, 16), draw, SPEED, 3.0), robot=other)


@pytest.mark.points(2)
def test_dynamic_model_regular(ask, robot, draw):
    """dynamic_model: regular poses of all modes"""
    ask("dynamic_model", *moving(poses(robot, draw, 16), draw, SPEED))


@pytest.mark.points(2)
def test_dynamic_model_unequal(ask, draw):
    """dynamic_model: bars and masses all different"""
    other = unequal_biglide(draw)
    ask("dynamic_model", *moving(poses(other, draw, 16), draw, SPEED), robot=other)


@pytest.mark.points(1)
def test_efforts(ask, robot, draw):
    """efforts: bonus, regular poses and both sides of Type 2"""
    other = replace(robot, mf2=robot.mf1 + 0.3)
    parts = poses(other, draw, 8), beside_type_2(other, draw, NEAR[:6])
    rows = batch(*((*pose.xi.T, *pose.working.T) for pose in parts))
    n = len(rows[0])
    limit = 1e-9 + np.concatenate([np.zeros(8), 1e-13 / NEAR[:6] ** 2])
    ask(
        "efforts",
        *rows[:2],
        *velocity(draw, n),
        *draw.uniform(-3, 3, (2, n)),
        *rows[2:],
        tolerance=limit,
        robot=other,
    )


def tasks(robot, draw):
    """Three motions to be designed: from rest on one side of the y axis to rest on the other, never symmetric."""
    room = robot.l1 - robot.d / 2
    for side in draw.choice([-1, 1], 3).tolist():
        near, far = side * room * draw.uniform(0.4, 0.5), -side * room * draw.uniform(0.65, 0.75)
        y0, y1 = draw.uniform(0.0, 0.03, 2) * (
            side,
            -side,
        )  # never along the bars, where the criterion holds by luck
        yield tuple(round(float(value), 4) for value in (near, y0, far, y1, draw.uniform(1.5, 2.5)))


def coefficients(value):
    """The polynomial (k, 2) of what came, or why it is none."""
    if (
        not (isinstance(value, list) or isinstance(value, np.ndarray) and value.ndim)
        or len(value) != 2
    ):
        return None, "two lists are asked: the coefficients of x(t) and of y(t)"
    try:
        a, b = (np.asarray(part).ravel() for part in value)
    except ValueError:
        a = b = np.array("lists of different lengths")
    if not all(part.dtype.kind in "bif" for part in (a, b)):
        return None, "the coefficients must be numbers"
    if not all(1 <= len(part) <= 20 and (np.abs(part) < 1e9).all() for part in (a, b)):
        return None, "each list must hold 1 to 20 numbers below 1e9"
    c = np.zeros((max(len(a), len(b)), 2))
    c[: len(a), 0], c[: len(b), 1] = a, b
    return c, ""


def at(c, t, order=0):
    """The polynomial's derivative at times t, (*t.shape, 2)."""
    return np.moveaxis(power.polyval(t, power.polyder(c, order)), 0, -1)


def crossing_of(robot, c, task):
    """Time at which the polynomial passes Type 2, or why it is no motion of the kind that is asked."""
    x0, y0, x1, y1, T = task
    for t, point in ((0.0, (x0, y0)), (T, (x1, y1))):
        for order, (wanted, what) in enumerate(
            [(point, "is not at the point"), (0, "moves"), (0, "accelerates")]
        ):
            off = np.abs(at(c, np.array(t), order) - wanted).max()
            if not off < 1e-6:
                return (
                    None,
                    f"at t = {t:g} s it {what}: {off:.3g} m{('', '/s', '/s²')[order]} too much",
                )
    t = np.linspace(0, T, 4004)  # no node where one would choose to cross
    pose = fb.igm(robot, at(c, t), CROSSING, unreachable="nan")
    sines = np.abs(np.array(pose.sines))
    if np.isnan(sines).any() or sines.min() < 0.05:
        return None, "it leaves the space that both bars reach, or comes close to its edge (Type 1)"
    regular = np.flatnonzero(pose.det_A)  # a time on the locus itself is on neither side
    changes = np.flatnonzero(pose.det_A[regular[1:]] * pose.det_A[regular[:-1]] < 0)
    if len(changes) != 1:
        return None, f"it meets Type 2 {len(changes)} times, not once"
    low, high = t[regular[changes[0]]], t[regular[changes[0] + 1]]
    start = pose.det_A[0]
    for _ in range(60):
        middle = (low + high) / 2
        beyond = fb.igm(robot, at(c, np.array(middle)), CROSSING).det_A * start <= 0
        low, high = (low, middle) if beyond else (middle, high)
    if not SHORTEST < high < T - SHORTEST:
        return (
            None,
            f"it meets Type 2 at its very {'start' if high <= SHORTEST else 'end'}, t = {high:.3g} s",
        )
    if abs(at(c, np.array(high), 1)[0]) < 0.01:
        return None, "at the crossing it hardly moves: it must pass through"
    return high, ""


def efforts_beside(robot, c, t):
    """The exact largest effort at times t, (n,)."""
    rates = fb.ikm(fb.igm(robot, at(c, t), CROSSING), at(c, t, 1))
    return np.abs(fb.inverse_dynamics(fb.ikm2(rates, at(c, t, 2)))).max(axis=-1)


def wrench_along_free_direction(robot, c, t):
    """t_s . (m xi'') at the crossing, N; and m |xi''|, the largest that it could be in this motion."""
    ux, uy = fb.igm(robot, at(c, np.array(t)), CROSSING).A[0]
    x, y = at(c, np.array(t), 2)
    largest = np.linalg.norm(at(c, np.linspace(0, t, 200), 2), axis=-1).max()
    return robot.m * (uy * x - ux * y), robot.m * largest


def judge_crossings(ask, robot, draw, function, compliant):
    """A quarter for a motion that crosses, the rest for efforts of the kind that is asked; mean of three."""
    shares, reason, asked = [], "", ""
    for task in tasks(robot, draw):
        c, why = coefficients(ask.call(function, *task))
        t, why = (None, why) if c is None else crossing_of(robot, c, task)
        if t is None:
            share = 0.0
        else:
            force, largest = wrench_along_free_direction(robot, c, t)
            near, nearer = efforts_beside(robot, c, t - np.array([1e-3, 1e-5]))
            grows = nearer > 10 * near
            kept = abs(force) < 1e-6 * largest and not grows
            share = 1.0 if kept == compliant and grows != compliant else 0.25
            why = (
                f"at the crossing, t = {t:.6g} s, t_s . (m xi'') = {force:.3g} N, and the efforts go from {near:.3g} N "
                f"one millisecond before to {nearer:.3g} N ten microseconds before"
            )
        shares.append(share)
        if share < 1 and not reason:
            reason, asked = why, f"{function}({', '.join(f'{value:g}' for value in task)})"
    ask.verdict(np.mean(shares), reason, asked)


@pytest.mark.points(2)
def test_compliant_crossing(ask, robot, draw):
    """compliant_crossing: bonus, through Type 2 with finite efforts"""
    judge_crossings(ask, robot, draw, "compliant_crossing", True)


@pytest.mark.points(1)
def test_non_compliant_crossing(ask, robot, draw):
    """non_compliant_crossing: bonus, through Type 2 with efforts that grow without bound"""
    judge_crossings(ask, robot, draw, "non_compliant_crossing", False)
