"""Newton on the loop closure finds whichever assembly mode lies downhill, and loses digits beside Type 2."""

from types import SimpleNamespace

import mpmath
import numpy as np
import pytest

import fivebar as fb
from fivebar.study.pitfalls.newton_dgm import newton_dgm

ROBOT = fb.FiveBar()
EPS = np.finfo(float).eps
HOME = (
    0.8558782490506787,
    2.2857144045391147,
)  # absolute angles of the distal bars, where users start
SINGULAR = (-0.863378416753482613, 1.02684600098692143)  # Type 2: where the lab's task 2 meets it
AWAY = np.array([1.0, -1.0]) / np.sqrt(2)


@pytest.fixture(scope="module")
def poses():
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (2000, 2))
    pose = fb.dgm(ROBOT, q, unreachable="nan")
    return q[np.abs(np.sin(np.diff(pose.q + pose.q_passive, axis=1)[:, 0])) > 0.05]  # False for nan


def closes_in_mode_minus_one(q, xi):
    """At every pose both distal bars have their length, and the elbows are on the side that was asked for."""
    elbows = [
        np.stack([base + 0.09 * np.cos(angle), 0.09 * np.sin(angle)], axis=1)
        for base, angle in zip((-0.059, 0.059), q.T)
    ]
    (ax, ay), (bx, by) = ((xi - elbow).T for elbow in elbows)
    lengths = np.hypot([ax, bx], [ay, by])
    return bool((np.abs(lengths - 0.09) < 1e-12).all() and (ax * by - ay * bx > 0).all())


def test_from_a_far_start(poses):
    found = np.array([newton_dgm(ROBOT, q, HOME).xi for q in poses])
    assert closes_in_mode_minus_one(poses, fb.dgm(ROBOT, poses).xi)
    assert not closes_in_mode_minus_one(poses, found)
    converged = np.array([newton_dgm(ROBOT, q, HOME).converged for q in poses])
    near = np.linalg.norm(found - fb.dgm(ROBOT, poses).xi, axis=1) < 1e-9
    # It is the method as it should be: from a start that is near it works.
    assert (converged & near).mean() > 0.5
    assert (converged & ~near).mean() > 0.1 and (~converged).mean() > 0.01


def test_a_step_out_of_all_numbers_ends_it():
    """From distal bars that are parallel but for the least number."""
    found = newton_dgm(ROBOT, (1.0, 2.0), (0.0, 1e-310))
    assert not found.converged and found.iterations == 0 and np.isfinite(found.xi).all()


def exact_dgm(q):
    with mpmath.workdps(50):
        bar, half = mpmath.mpf(ROBOT.l11), mpmath.mpf(ROBOT.d) / 2
        (x1, y1), (x2, y2) = (
            (s * half + bar * mpmath.cos(a), bar * mpmath.sin(a))
            for s, a in zip((-1, 1), q.tolist())
        )
        dx, dy = (x2 - x1) / 2, (y2 - y1) / 2
        share = mpmath.sqrt(bar * bar / (dx * dx + dy * dy) - 1)
        return float(x1 + dx - share * dy), float(y1 + dy + share * dx)


def keeps_its_digits(q, xi, sine):
    """No error beyond what rounding of the elbows' positions must cost."""
    error = np.linalg.norm(xi - [exact_dgm(angles) for angles in q], axis=1)
    return bool((error <= 10 * EPS * 0.18 / np.abs(sine)).all())


def near_singular(distances, off):
    """Both methods at these distances from Type 2; Newton starts with the bars turned by (off, -off) rad."""
    q = np.asarray(SINGULAR) + np.multiply.outer(distances, AWAY)
    pose = fb.dgm(ROBOT, q)
    phi = pose.q + pose.q_passive
    found = [newton_dgm(ROBOT, angles, bars + (off, -off)) for angles, bars in zip(q, phi)]
    return SimpleNamespace(
        q=q,
        closed=pose.xi,
        newton=np.array([each.xi for each in found]),
        iterations=[each.iterations for each in found],
        sine=np.sin(phi[:, 1] - phi[:, 0]),
    )


def test_beside_type_2():
    case = near_singular(10.0 ** -np.arange(1, 13), off=0.1)
    assert keeps_its_digits(case.q, case.closed, case.sine)
    assert not keeps_its_digits(case.q, case.newton, case.sine)
    lost = np.linalg.norm(case.newton - case.closed, axis=1) * np.abs(case.sine) / (EPS * 0.18)
    assert lost.max() > 1e4  # four digits more than need be
    assert case.iterations[0] <= 5 and case.iterations[-1] >= 12  # the convergence is linear there


def test_started_beyond_type_2():
    case = near_singular(10.0 ** -np.arange(2, 5), off=-0.1)
    assert closes_in_mode_minus_one(case.q, case.closed)
    assert not closes_in_mode_minus_one(case.q, case.newton)
    assert (np.linalg.norm(case.newton - case.closed, axis=1) > 1e-3).all()
