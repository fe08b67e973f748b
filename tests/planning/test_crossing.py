"""The polynomial that is made to cross Type 2, against the reference, and that a plan is cheaper."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.planning.crossing import crossing_polynomial

from .conftest import ROBOT, fine


def test_crossing_polynomial_against_the_reference(five_bar_numbers):
    case = five_bar_numbers["compliant_crossing"]
    p0, ps, pf, vs = (np.array(case[key], float) for key in ("p0", "ps", "pf", "vs"))
    path = crossing_polynomial(ROBOT, p0, pf, ps, vs, (0, 2, 4))
    t = np.linspace(0, 4, 81)
    expected = [np.polyval(np.array(case[key][::-1], float), t) for key in ("coef_x", "coef_y")]
    np.testing.assert_allclose(path(t)[0].T, expected, atol=2e-14)

    def torque(t):
        xi, xi_dot, xi_ddot = path(t)
        return fb.inverse_dynamics(fb.ikm2(fb.ikm(fb.igm(ROBOT, xi), xi_dot), xi_ddot))

    for sample in case["tau_at"]:
        np.testing.assert_allclose(
            torque(float(sample["t"])), np.array(sample["tau"], float), atol=1e-14
        )
    for side, key in ((-1, "tau_limit_left"), (1, "tau_limit_right")):
        near = [torque(2 + side * h) for h in (1e-3, 5e-4)]
        np.testing.assert_allclose(2 * near[1] - near[0], np.array(case[key], float), atol=2e-6)
    t = np.linspace(0, 4, 2001)
    peaks = np.abs(torque(t[t != 2.0])).max(axis=0)
    np.testing.assert_allclose(peaks, np.array(case["peak_abs_tau_2000pts"], float), rtol=1e-9)


def test_crossing_polynomial_keeps_the_criterion(five_bar_numbers):
    case = five_bar_numbers["compliant_crossing"]
    p0, ps, pf, vs, free = (
        np.array(case[key], float) for key in ("p0", "ps", "pf", "vs", "uncontrollable_dir")
    )
    xi_ddot = crossing_polynomial(ROBOT, p0, pf, ps, vs, (0, 2, 4), acceleration=(0.3, -0.1))(2.0)[
        2
    ]
    assert abs(free @ xi_ddot) <= 1e-12
    across = np.array([free[1], -free[0]])
    assert across @ xi_ddot == pytest.approx(across @ (0.3, -0.1), abs=1e-12)
    with pytest.raises(ValueError, match=r"at times \(0.0, 2.0, 1e\+20\): .* 1e-12 to 1e\+12"):
        crossing_polynomial(ROBOT, p0, pf, ps, vs, (0, 2, 1e20))
    with pytest.raises(ValueError, match="not on Type 2: det A = 0.0"):
        crossing_polynomial(ROBOT, p0, pf, ps + 1e-4, vs, (0, 2, 4))
    with pytest.raises(ValueError, match="does not cross the singularity"):
        crossing_polynomial(ROBOT, p0, pf, ps, (0.0, 0.0), (0, 2, 4))


def test_plan_is_cheaper_than_the_polynomial(crossing, five_bar_numbers):
    worst = max(map(float, five_bar_numbers["compliant_crossing"]["peak_abs_tau_2000pts"]))
    assert np.abs(crossing.torques(fine(crossing))).max() <= worst / 20
