"""The lab's task 2 through its singularity: torque without bound, and a motion that crosses with little."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.study.pitfalls.crossing import OpenLoop, beside_crossing, compliant, straight, torque

ROBOT = fb.FiveBar()
PERIOD = 1e-3


def numbers(values):
    return np.array(values, dtype=float)


def peak(case):
    return np.abs(case.torque).max()


def needs_little_torque(case):
    return peak(case) < 0.1


def test_exact_torque_beside_the_singularity(five_bar_numbers):
    naive, crossing = beside_crossing(ROBOT, straight()), beside_crossing(ROBOT, compliant(ROBOT))
    assert needs_little_torque(crossing)
    assert not needs_little_torque(naive)
    (met,) = five_bar_numbers["lab_task_2"]["meets_type_2"]
    assert naive.crossing == pytest.approx(float(met["t"]), abs=1e-12)
    assert torque(ROBOT, straight(), float(met["t"]) - 1e-6) == pytest.approx(
        numbers(met["tau_1us_before"]), rel=1e-6
    )
    # As the inverse of the time: ten times nearer, ten times the torque.
    assert peak(beside_crossing(ROBOT, straight(), 1e-7)) / peak(naive) == pytest.approx(
        10, rel=1e-3
    )
    assert peak(beside_crossing(ROBOT, compliant(ROBOT), 1e-7)) == pytest.approx(
        peak(crossing), rel=1e-2
    )


def test_the_compliant_motion_is_the_references(five_bar_numbers):
    data = five_bar_numbers["compliant_crossing"]
    reference, powers = compliant(ROBOT), np.arange(9)
    for t in np.linspace(0, 4, 9):
        xi = [numbers(data[f"coef_{axis}"]) @ t**powers for axis in "xy"]
        assert reference(t)[0] == pytest.approx(xi, abs=1e-13)
    for case in data["tau_at"]:
        assert torque(ROBOT, reference, float(case["t"])) == pytest.approx(
            numbers(case["tau"]), abs=1e-10
        )
    grid = np.linspace(0, 4, 2001)
    peak = np.abs(torque(ROBOT, reference, grid[grid != 2.0])).max(axis=0)
    assert peak == pytest.approx(numbers(data["peak_abs_tau_2000pts"]), rel=2e-3)
    for side, name in ((-1, "tau_limit_left"), (1, "tau_limit_right")):
        assert torque(ROBOT, reference, 2.0 + side * 1e-8) == pytest.approx(
            numbers(data[name]), abs=1e-7
        )
    # At the singularity itself the torque's limit makes the acceleration that the polynomial has there: none.
    at = fb.ikm(fb.igm(ROBOT, numbers(data["ps"])), numbers(data["vs"]))
    assert fb.forward_dynamics(at, numbers(data["tau_limit_left"])).xi_ddot == pytest.approx(
        [0, 0], abs=1e-8
    )


def crosses(controller, reference):
    run = fb.simulate(ROBOT, controller, reference, control_period=PERIOD)
    (event,) = run.events
    assert event.margin == "det A" and event.before[2] == -1 and event.after[2] == 1
    return np.abs(run.tau).max() < 0.06 and np.linalg.norm(run.error, axis=1).max() < 1e-5


@pytest.mark.deep
def test_simulated():
    """The torque of the compliant motion alone, without feedback, carries the robot through."""
    assert crosses(OpenLoop(ROBOT, PERIOD), compliant(ROBOT))
    assert not crosses(fb.ComputedTorque(ROBOT, 100, 20), straight())


@pytest.mark.deep
def test_what_the_sampled_loop_does():
    """At any period it jumps off the path by millimetres, with torques that depend on where a sample falls."""
    peaks = []
    for period in (0.01, 0.005, 0.002, 0.001):
        controller = fb.ComputedTorque(ROBOT, 100, 20)
        run = fb.simulate(ROBOT, controller, straight(), control_period=period, step=1e-3)
        error = np.linalg.norm(run.error, axis=1)
        assert error[run.t < 3.1].max() < 1e-5 and 1e-3 < error.max() < 1e-2
        peaks.append(np.abs(run.tau).max())
    assert min(peaks) > 1 and max(peaks) > 100
