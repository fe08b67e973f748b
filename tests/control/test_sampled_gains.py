"""Gains beyond what sampling allows are named where a simulation fails, and the limit is the simulated robot's."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.control.laws import why_unstable

PERIOD = 0.01


def grows(robot, pose, controller, delay, direction):
    """Whether a deviation of 1e-8 rad in this direction is larger after 150 samples than after 75."""
    reference = fb.line(pose.xi, pose.xi, 1.5)
    start = fb.dkm(fb.dgm(robot, pose.q + 1e-8 * direction, pose.assembly), (0.0, 0.0))
    measurement = fb.Measurement(delay=delay)
    sizes = []

    def watched(t, q, q_dot, reference):
        sizes.append(np.linalg.norm([*(q - pose.q), *(PERIOD * q_dot)]))
        return controller(t, q, q_dot, reference)

    try:
        fb.simulate(robot, watched, reference, start=start, measurement=measurement, step=PERIOD)
    except (ArithmeticError, fb.UnreachableError):
        return True
    return max(sizes[-20:]) > max(sizes[60:90])


def case(seed):
    draw = np.random.default_rng(seed)
    bars = draw.uniform(0.08, 0.14, 4)
    masses = dict(
        zz1=draw.uniform(1e-3, 5e-3), zz2=draw.uniform(1e-3, 5e-3), m=draw.uniform(0.1, 1)
    )
    robot = fb.FiveBar(*bars, d=draw.uniform(0.06, 0.12), **masses)
    return robot, fb.igm(robot, (draw.uniform(-0.02, 0.02), draw.uniform(0.1, 0.13)))


@pytest.mark.every(3)
@pytest.mark.parametrize("delay", [0, 1])
@pytest.mark.parametrize("seed", range(3))
def test_the_limit_of_pd_is_that_of_the_simulated_robot(seed, delay):
    robot, pose = case(seed)
    M, _ = fb.dynamic_model(fb.dkm(pose, (0.0, 0.0)))
    inertias, directions = np.linalg.eigh(M)
    lightest = inertias[0]
    p = 0.1
    if delay:
        low = (1 - np.sqrt(1 - 4 * p)) / 2 + p / 2  # r (1 - r) = p
        high = (1 + np.sqrt(1 - 4 * p)) / 2 + p / 2
    else:
        low, high = p / 2, 2.0
    for q, stable in ((high - 0.04, True), (high + 0.04, False), (low - 0.04, False)):
        control = fb.PD(robot, p * lightest / PERIOD**2, q * lightest / PERIOD)
        words = why_unstable(control, pose, PERIOD, delay)
        assert (words == "") == stable
        assert grows(robot, pose, control, delay, directions[:, 0]) == (not stable), (q, words)


@pytest.mark.deep
def test_a_failure_names_the_gains():
    robot = fb.FiveBar()
    line = fb.line((0.09, 0.06796322), (0.0, 0.1), 2.0)
    with pytest.raises(
        ArithmeticError, match=r"q = kd h = 49\.7, and it must be p / 2 < q < 2; th"
    ):
        fb.simulate(robot, fb.PD(robot, 100, 20), line, duration=0.12)
    late = fb.Measurement(delay=1)
    with pytest.raises(ArithmeticError, match=r"p = kp h\^2 = 0\.81 and .* p < r \(1 - r\)"):
        fb.simulate(robot, fb.ComputedTorque(robot, 8100, 180), line, measurement=late)


@pytest.mark.deep
def test_a_run_that_whirls_is_told_why():
    robot = fb.FiveBar()
    line = fb.line((0.09, 0.06796322), (0.0, 0.1), 2.0)
    with pytest.warns(RuntimeWarning, match=r"crosses \d+ .*q = kd h = 2\.48, and it must"):
        run = fb.simulate(robot, fb.PD(robot, 10, 1), line, duration=0.7)
    assert run.events


def test_stable_gains_and_other_laws_are_not_blamed():
    robot = fb.FiveBar()
    pose = fb.igm(robot, (0.0, 0.1))
    for control in (fb.PD(robot, 40, 0.6), fb.ComputedTorque(robot, 100, 20), lambda *_: (0, 0)):
        assert why_unstable(control, pose, PERIOD, 0) == ""
    biglide = fb.Biglide()
    assert "p / 2 < q < 2" in why_unstable(
        fb.PD(biglide, [1e5, 1], [10, 1]), fb.dgm(biglide, (0, 0)), PERIOD, 0
    )
