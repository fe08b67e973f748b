"""Sampled laws: what full turns of the measured angles do to them."""

import numpy as np
import pytest

import fivebar as fb

ROBOT = fb.FiveBar()
TASK_1 = fb.line((0.09, 0.06796322), (0.0, 0.1), 2.0)


@pytest.mark.parametrize("turns", [(1, 0), (0, -1), (-2, 3)])
@pytest.mark.parametrize(
    "law", [fb.ComputedTorque(ROBOT, 100, 20), fb.PD(ROBOT, 0.4, 0.08)], ids=["ctc", "pd"]
)
def test_full_turns_of_the_measured_angles_do_not_matter(law, turns):
    q, q_dot = np.array([0.2, 0.1]), np.array([0.3, -0.2])
    torque = law(0.7, q, q_dot, TASK_1)
    assert law(0.7, q + 2 * np.pi * np.array(turns), q_dot, TASK_1) == pytest.approx(
        torque, rel=1e-12
    )


def test_errors_across_half_a_turn_are_small():
    """Measured and wanted angle on either side of pi."""
    robot, q_dot = fb.FiveBar(0.1, 0.1, 0.1, 0.1, 0.05), np.zeros(2)
    wanted, measured = np.array([np.pi - 0.01, 2.0]), np.array([-np.pi + 0.02, 2.0])
    pose = fb.dgm(robot, wanted)

    def reference(t):
        return pose.xi, q_dot, q_dot

    working = tuple(pose.working.tolist())
    assert fb.PD(robot, 2.0, 0.1, working)(0.0, measured, q_dot, reference) == pytest.approx(
        [-0.06, 0.0], abs=1e-12
    )
    M, _ = fb.dynamic_model(fb.dkm(fb.dgm(robot, measured), q_dot))
    torque = fb.ComputedTorque(robot, 100, 20, working)(0.0, measured, q_dot, reference)
    assert torque == pytest.approx(M @ (-3.0, 0.0), abs=1e-9)
