"""What a stretch allows of x = s'^2 at its ends, against the models' torques and speeds all along it."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.paths.curve import Path
from fivebar.paths.pieces import Arc, Line
from fivebar.paths.timing.constraint_rows import Limits, rows_of
from fivebar.paths.timing.lower_bound import caps, ceiling
from fivebar.paths.timing.mesh import mesh_of
from fivebar.paths.timing.polygons import polygons
from fivebar.paths.timing.solve import _directions
from tests.helpers.paths_to_time import ROBOTS, almost_along_the_bars

ACROSS = Path((Line((0.09, 0.068), (0.05, 0.0)),))
ARC = Path((Arc((0.0, 0.1), 0.02, 0.3, 2.8),))
LAB = fb.FiveBar()
CASES = {  # robot, path, limits
    "torques": (LAB, ARC, Limits((0.1, 0.12))),
    "motors": (ROBOTS["all"][0], ARC, Limits(stall=(0.9, 0.8), no_load=(9.0, 7.0))),
    "accelerations": (LAB, ARC, Limits(None, None, (30.0, 40.0), None, 3.0)),
    "speeds": (LAB, ARC, Limits((0.5, 0.5), (2.0, 2.5), None, 0.15)),
    "across Type 2": (replace(LAB, fs1=0.01, fs2=0.02), ACROSS, Limits((0.1, 0.12))),
    "gravity": (replace(LAB, gravity=(0.0, 0.5), fv1=0.01), ACROSS, Limits((0.3, 0.32))),
    "along the bars": (LAB, almost_along_the_bars(0.0, 0.0), Limits((0.3, 0.3))),
    "elbows": (replace(LAB, fv12=0.003, fv22=0.002), ACROSS, Limits((0.1, 0.12))),
}
CROSSING = "across Type 2", "along the bars", "elbows"  # where what is drawn is feasible at it


def above_of(mesh, limits):
    """The rows that a motion keeps, and a curve that none is above."""
    speed = np.full(len(mesh), limits.speed or np.inf)
    about = mesh.side, mesh.turns, _directions(np.zeros(len(mesh))), speed
    outside = rows_of(mesh.factors, limits, *about, False)
    ends = caps(outside)
    top = np.minimum(np.append(ends[0], np.inf), np.insert(ends[1], 0, np.inf))
    length = mesh.stretches.length
    high = np.full(len(mesh), np.inf)
    above = ceiling(outside, length, top, high, mesh.rest)
    return rows_of(mesh.factors, limits, *about, True), above


def most_used(robot, path, limits, s, x, u):
    """The largest share of a limit at places of a path with these x and u, by the models."""
    xi, xi_s, xi_ss, _ = path(s)
    rates = fb.ikm(fb.igm(robot, xi, (-1, -1)), xi_s * np.sqrt(x)[..., None])
    acc = fb.ikm2(rates, xi_ss * x[..., None] + xi_s * u[..., None])
    tau = fb.inverse_dynamics(acc)
    values = [np.zeros((*s.shape, 2))]
    if limits.torque:
        values.append(tau / limits.torque)
    if limits.stall:
        values.append(tau / limits.stall + rates.q_dot / limits.no_load)
    if limits.joint_speed:
        values.append(rates.q_dot / limits.joint_speed)
    if limits.joint_acceleration:
        values.append(acc.q_ddot / limits.joint_acceleration)
    for vector, limit in ((rates.xi_dot, limits.speed), (acc.xi_ddot, limits.acceleration)):
        if limit:
            values.append(np.linalg.norm(vector, axis=-1, keepdims=True) / limit)
    return np.abs(np.concatenate(values, axis=-1)).max(axis=(1, 2))


@pytest.mark.parametrize("name", CASES)
def test_a_stretch_allows_what_keeps_the_limits_all_along(name):
    """And hardly less; on Type 2 x is free, or with the elbows' friction given."""
    robot, path, limits = CASES[name]
    rng = np.random.default_rng(2)
    mesh = mesh_of(robot, path, (-1, -1))
    rows, above = above_of(mesh, limits)
    while not np.isfinite(above.size).all():
        mesh = mesh.split(1 + ~np.isfinite(above.size))
        rows, above = above_of(mesh, limits)
    n = len(mesh)
    length = mesh.stretches.length
    near = 0.5 * above.x
    off = np.full(n, 0.01 * mesh.tied.any())
    bent = rng.uniform(-0.7, 0.7, (2, n))[0] * above.size / length
    table, bends = polygons(rows, length, above, bent, near, off, mesh)
    tied = mesh.tied.any()
    beside = mesh.crossing[1:] | mesh.crossing[:-1]
    fits, possible = np.zeros((2, 2), dtype=int)
    for _ in range(20 if tied else 6):
        if tied:
            x = near * rng.uniform(0.96, 1.04, n + 1)
            x0, x1 = np.where(mesh.tied, near, x)[:-1], np.where(mesh.tied, near, x)[1:]
        else:
            x0 = np.maximum(above.x[:-1] * rng.uniform(0.02, 1.2, n), 1e-9)
            x1 = x0 + 2 * length * above.size * rng.uniform(-1.6, 1.6, n)
        form = np.stack([x0, x1, np.ones(n)], axis=1)
        curve = (bends * form).sum(axis=1)
        allowed = (np.einsum("nrk,nk->nr", table, form) <= 0).all(axis=1)
        gone = length[:, None] * np.linspace(0.02, 0.98, 9)
        u0 = (x1 - x0) / (2 * length) - curve * length / 2
        u = u0[:, None] + curve[:, None] * gone
        x = x0[:, None] + gone * (u0[:, None] + u)
        good = (x > 0).all(axis=1)
        share = np.full(n, np.inf)
        s = mesh.s[:-1, None] + gone
        share[good] = most_used(robot, path, limits, s[good], x[good], u[good])
        assert share[allowed].max() <= 1 + 1e-9
        good &= (share < 0.97) & (np.abs(u).max(axis=1) < 2 * above.size)
        good &= x.max(axis=1) < np.maximum(above.x[1:], above.x[:-1])
        for k, where in enumerate((~beside, beside)):
            possible[k] += (good & where).sum()
            fits[k] += (good & allowed & where).sum()
    assert fits[0] > 0.9 * possible[0] > 80
    assert fits[1] == possible[1] and (possible[1] > 0) == (name in CROSSING)
