"""What the tracker does without a solution, against the laws written out by hand."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.control.fallback import reference_torques, safe_torque

ROBOT = fb.FiveBar()
INERTIA = 0.01
LINE = fb.line((0.09, 0.068), (0.0, 0.1), 2.0)
Q, Q_DOT = np.array([0.3, 0.1]), np.array([0.4, -0.2])


def joints(t, working):
    """Angles, rates and accelerations of the line by the bars' geometry and differences."""

    def angles(t):
        x, y = LINE(t)[0]
        found = []
        for sign, base in zip(working, (-0.059, 0.059)):
            reach = np.hypot(x - base, y)
            # Both bars are 90 mm: the elbow is half way, on the side of the working mode.
            found.append(np.arctan2(y, x - base) + sign * np.arccos(reach / 0.18))
        return np.array(found)

    h = 1e-4
    before, now, after = angles(t - h), angles(t), angles(t + h)
    return now, (after - before) / (2 * h), (after - 2 * now + before) / h**2


@pytest.mark.parametrize("working", [(-1, -1), (1, -1), (-1, 1), (1, 1)])
def test_the_angles_by_hand_are_those_of_the_model(working):
    pose = fb.igm(ROBOT, LINE(0.7)[0], working)
    assert joints(0.7, working)[0] == pytest.approx(pose.q, abs=1e-12)


@pytest.mark.parametrize("working", [(-1, -1), (1, 1)])
@pytest.mark.parametrize("assembly", [-1, 1])
def test_away_from_type_2_it_is_computed_torque(working, assembly):
    """In the working mode whose sines are the margins'."""
    margins = (-working[0] * 0.5, -working[1] * 0.5, 0.21)
    q, q_dot, q_ddot = joints(0.7, working)
    rates = fb.dkm(fb.dgm(ROBOT, Q, assembly), Q_DOT)
    M, c = fb.dynamic_model(rates)
    expected = M @ (q_ddot + 20 * (q_dot - Q_DOT) + 100 * (q - Q)) + c
    tau = safe_torque(ROBOT, INERTIA, margins, assembly, (0.7, Q, Q_DOT, LINE))
    assert tau == pytest.approx(expected, rel=1e-5, abs=1e-7)


@pytest.mark.parametrize("det_A", [0.2, -0.2, 0.0])
def test_near_type_2_it_is_pd(det_A):
    q, q_dot, _ = joints(0.7, (-1, 1))
    expected = INERTIA * (100 * (q - Q) + 20 * (q_dot - Q_DOT))
    tau = safe_torque(ROBOT, INERTIA, (0.5, -0.5, det_A), -1, (0.7, Q, Q_DOT, LINE))
    assert tau == pytest.approx(expected, rel=1e-5)


class FreePlan:
    """A plan whose legs may change their modes."""

    working = None
    start, duration = 0.0, 2.0

    def joints(self, t):
        return np.array([0.1 * t, 0.2]), np.array([0.1, 0.0])

    def torques(self, t):
        return np.stack([np.asarray(t) * 1.0, np.asarray(t) * 2.0], axis=-1)


def test_along_a_plan_free_of_modes_it_is_feed_forward():
    tau = safe_torque(ROBOT, INERTIA, (0.5, 0.5, 0.5), -1, (0.7, Q, Q_DOT, FreePlan()))
    ahead = 0.7 + fb.FeedForward(ROBOT, 0, 0).ahead
    error, rate = np.array([0.07, 0.2]) - Q, np.array([0.1, 0.0]) - Q_DOT
    expected = np.array([ahead, 2 * ahead]) + INERTIA * (100 * error + 20 * rate)
    assert tau == pytest.approx(expected, rel=1e-12)
    times = np.array([0.1, 0.2])
    torques = reference_torques(ROBOT, (0, 0, 0), FreePlan(), times)
    assert torques.tolist() == [[0.1, 0.2], [0.2, 0.4]]


@pytest.mark.parametrize("det_A", [0.5, 0.1])
def test_where_the_reference_is_out_of_reach_it_is_damping(det_A):
    away = fb.line((0.5, 0.1), (0.6, 0.1), 2.0)
    tau = safe_torque(ROBOT, INERTIA, (0.5, 0.5, det_A), -1, (0.7, Q, Q_DOT, away))
    assert tau == pytest.approx(-20 * INERTIA * Q_DOT)
    assert not reference_torques(ROBOT, (0.5, 0.5, 1), away, np.array([0.1, 0.2])).any()


@pytest.mark.parametrize("working", [(-1, -1), (1, 1)])
def test_torques_of_a_reference_are_those_of_its_working_mode(working):
    margins = (-working[0] * 0.5, -working[1] * 0.5, 0.5)
    times = np.array([0.3, 0.9])
    xi, xi_dot, xi_ddot = LINE(times)
    rates = fb.ikm(fb.igm(ROBOT, xi, working), xi_dot)
    expected = fb.inverse_dynamics(fb.ikm2(rates, xi_ddot))
    found = reference_torques(ROBOT, margins, LINE, times)
    assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    "t,ahead", [(0.0, 0.005), (1.9, 0.005), (1.998, 0.005), (2.0, None), (3.0, None)]
)
def test_feed_forward_reads_the_plan_ahead_and_is_a_pd_after_its_end(t, ahead):
    law = fb.FeedForward(ROBOT, (10, 20), (1, 2))
    q_ref, q_ref_dot = FreePlan().joints(t)
    feedback = (q_ref - Q) * (10, 20) + (q_ref_dot - Q_DOT) * (1, 2)
    fed = 0.0 if ahead is None else FreePlan().torques(min(t + ahead, 2.0))
    assert law(t, Q, Q_DOT, FreePlan()) == pytest.approx(fed + feedback, rel=1e-12)
