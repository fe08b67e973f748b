"""Eight families of robots: geometry, dynamics, loci and motions of each against what must hold for any robot.

A few robots of each; with FIVEBAR_NIGHTLY=1 two hundred.
"""

import os

import numpy as np
import pytest

import fivebar as fb
from fivebar.base.backend import EPS
from tests.helpers.families import FAMILIES, poses, robots

COUNT = 200 if os.environ.get("FIVEBAR_NIGHTLY") else 4
MOTIONS = COUNT // 2  # robots of each family whose free motion is simulated, there and back


@pytest.fixture(params=FAMILIES, ids=lambda family: family.__name__)
def family(request):
    return robots(request.param, COUNT, seed=22)


def length(robot):
    return robot.l11 + robot.l12 + robot.l21 + robot.l22 + robot.d


def gaps(robot, q, xi):
    """By how much both distal bars of poses miss their lengths, m: (n, 2), from angles and points alone."""
    found = []
    for side, l1, l2, angle in (
        (-0.5, robot.l11, robot.l12, q[:, 0]),
        (0.5, robot.l21, robot.l22, q[:, 1]),
    ):
        elbow = np.stack([side * robot.d + l1 * np.cos(angle), l1 * np.sin(angle)], axis=1)
        found.append(np.linalg.norm(xi - elbow, axis=1) - l2)
    return np.stack(found, axis=1)


def test_loops_close_and_the_models_invert_each_other(family):
    reached, rng = 0, np.random.default_rng(1)
    for robot in family:
        given, _ = poses(robot, 200, rng)
        if not given:
            continue  # a robot of ratio 1 : 1000 may have hardly a pose off its singularities
        q, assembly = map(np.array, zip(*given))
        pose = fb.dgm(robot, q, assembly)
        assert np.abs(gaps(robot, q, pose.xi)).max() <= 40 * EPS * length(robot)
        again = fb.igm(robot, pose.xi, pose.working)
        assert np.abs(gaps(robot, again.q, pose.xi)).max() <= 40 * EPS * length(robot)
        # Of q, what rounding of xi says of it: over the sine and the proximal bar.
        slack = (
            200
            * EPS
            * length(robot)
            / np.array([robot.l11, robot.l21])
            / np.abs(np.stack(pose.sines, axis=1))
        )
        assert (np.abs(robot.joint_difference(again.q - q)) <= slack).all()
        reached += len(q)
    assert reached > 20 * len(family)


def test_forward_and_inverse_dynamics_and_power(family):
    rng = np.random.default_rng(2)
    for robot in family:
        given, _ = poses(robot, 100, rng, margin=0.1)
        if not given:
            continue
        q, assembly = map(np.array, zip(*given))
        rates = fb.dkm(fb.dgm(robot, q, assembly), rng.normal(size=q.shape))
        q_ddot = rng.normal(size=q.shape)
        acc = fb.dkm2(rates, q_ddot)
        tau = fb.inverse_dynamics(acc)
        back = fb.forward_dynamics(rates, tau)
        M, c = fb.dynamic_model(rates)
        # What tau's rounding does to q'': M^-1 of it, and of the largest term of tau = M q'' + c.
        terms = np.abs(M) @ np.abs(q_ddot)[..., None]
        spread = np.abs(np.linalg.inv(M)) @ (terms + np.abs(c)[..., None])
        assert (np.abs(back.q_ddot - q_ddot) <= 1e-10 * (1 + spread[..., 0])).all()
        assert tau == pytest.approx(
            (M @ q_ddot[..., None])[..., 0] + c, rel=1e-9, abs=1e-9 * np.abs(tau).max()
        )
        energy = 0.5 * np.einsum("ni,nij,nj->n", rates.q_dot, M, rates.q_dot)
        assert fb.energy(rates) == pytest.approx(energy, rel=1e-9)


def test_points_of_the_loci_are_singular(family):
    looked = 0
    for robot in family:
        for locus in fb.singularity_loci(robot).task:
            points = locus.points[np.isfinite(locus.points).all(axis=1)][
                :: max(1, len(locus.points) // 40)
            ]
            for mode in locus.working[:1]:
                pose = fb.igm(robot, points, mode, unreachable="nan")
                margins = np.stack([*np.abs(pose.sines), np.abs(pose.det_A)])
                small = np.nanmin(margins, axis=0, initial=np.inf, where=~np.isnan(margins))
                shortest = min(robot.l11, robot.l12, robot.l21, robot.l22)
                # A sine grows with the root of the distance at the limit of reach.
                bound = 2e-7 * np.sqrt(length(robot) / shortest) * length(robot) / shortest
                assert (small[np.isfinite(small)] <= max(bound, 1e-6)).all()
                looked += np.isfinite(small).sum()
    assert looked > 100 * len(family)


def slow_start(robot, rng):
    """Rates of a regular pose that turn bars by about a radian a second; None without a regular pose."""
    given, _ = poses(robot, 1, rng, margin=0.2)
    if not given:
        return None
    q, assembly = given[0]
    pose = fb.dgm(robot, q, int(assembly))
    unit = fb.dkm(pose, rng.normal(size=2))
    fastest = np.abs(np.concatenate([unit.q_dot, unit.phi_dot])).max()
    return fb.dkm(pose, unit.q_dot / fastest)


def test_a_free_motion_keeps_its_energy_and_goes_back(family):
    rng, moved = np.random.default_rng(3), 0
    for robot in family[:MOTIONS]:
        start = slow_start(robot, rng)
        if start is None:
            continue
        run = fb.simulate(robot, start=start, duration=0.5, step=0.05)
        assert run.energy == pytest.approx(run.energy[0], rel=1e-9)
        assert np.abs(gaps(robot, run.q, run.xi)).max() <= 1e-12 * length(robot)
        # Back from its end with all rates reversed; where it ends on a singularity, dgm cannot tell the rates.
        assembly = run.events[-1].after[2] if run.events else int(start.pose.assembly)
        end = fb.dgm(robot, run.q[-1], int(assembly))
        if abs(float(end.det_A)) < 0.05:
            continue
        back = fb.simulate(robot, start=fb.dkm(end, -run.q_dot[-1]), duration=0.5, step=0.05)
        assert (
            np.abs(
                back.q[-1] - run.q[0] - np.round((back.q[-1] - run.q[0]) / (2 * np.pi)) * 2 * np.pi
            ).max()
            < 1e-6
        )
        assert np.abs(back.xi[-1] - run.xi[0]).max() < 1e-6 * length(robot)
        moved += 1
    assert moved >= 1
