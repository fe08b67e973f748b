"""Encoders where joint angles pass +-pi: their differences are rates, and never a jump by a turn."""

from functools import cache

import numpy as np
import pytest

import fivebar as fb

ROBOT = fb.FiveBar()
RESOLUTION = 1e-3


@cache
def through_half_a_turn(count, seed):
    """Lines (start, goal, working, joint) on which an active joint of `igm` passes +-pi, far from singularities."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        a, b = rng.uniform(-0.17, 0.17, (2, 2))
        working = tuple(int(mode) for mode in rng.choice([-1, 1], 2))
        pose = fb.igm(
            ROBOT, a + np.linspace(0, 1, 200)[:, None] * (b - a), working, unreachable="nan"
        )
        if not (np.abs(np.stack([*pose.sines, pose.det_A])) > 0.15).all():
            continue
        jumps = np.abs(np.diff(pose.q, axis=0)) > np.pi
        if jumps.any() and np.linalg.norm(b - a) > 0.05:
            found.append((a, b, working, int(pose.assembly[0])))
    return found


def test_the_line_of_the_report():
    reference = fb.line((-0.077, -0.05), (0.078, -0.073), 2.0)
    controller = fb.ComputedTorque(ROBOT, 100, 20, (-1, -1), 1)
    run = fb.simulate(
        ROBOT, controller, reference, measurement=fb.Measurement(encoder_resolution=RESOLUTION)
    )
    assert np.linalg.norm(run.error, axis=1).max() < 2e-3
    assert np.abs(run.control.q_dot[1:]).max() < 2 * np.abs(run.q_dot).max() + RESOLUTION / 0.01


@pytest.mark.deep
@pytest.mark.parametrize(
    "chart, method", [("auto", None), ("task", "rk4"), ("joint", "rk4"), ("auto", "rk4")]
)
def test_twelve_lines_through_half_a_turn(chart, method):
    for a, b, working, assembly in through_half_a_turn(12, seed=22):
        controller, reference = (
            fb.ComputedTorque(ROBOT, 100, 20, working, assembly),
            fb.line(a, b, 2.0),
        )
        options = dict(
            measurement=fb.Measurement(encoder_resolution=RESOLUTION),
            integrator=fb.Integrator(method, chart),
        )
        run = fb.simulate(ROBOT, controller, reference, **options)
        # What an encoder tells lags behind by half a period and errs by a step over a period.
        at = np.searchsorted(run.t, run.control.t + 1e-9) - 1
        mean = (run.q[at[1:]] - run.q[at[:-1]]) / 0.01
        assert np.abs(run.control.q_dot[1:] - mean).max() <= 1.001 * RESOLUTION / 0.01
        assert np.abs(run.control.q - run.q[at]).max() <= 0.501 * RESOLUTION or chart == "task"
        assert np.linalg.norm(run.error, axis=1).max() < 3e-3
        if method:
            (many,) = fb.simulate_many([ROBOT], controller, reference, **options)
            assert many.q == pytest.approx(run.q, abs=1e-9)
            assert many.control.q_dot == pytest.approx(run.control.q_dot, abs=1e-9)


def test_a_tracker_with_encoders_through_half_a_turn():
    a, b, working, assembly = through_half_a_turn(1, seed=5)[0]
    tracker = fb.Tracker(ROBOT, 10, encoder_resolution=RESOLUTION, assembly=assembly)
    start = fb.ikm(fb.igm(ROBOT, a, working), (0.0, 0.0))
    run = fb.simulate(
        ROBOT,
        tracker,
        fb.line(a, b, 2.0),
        start=start,
        measurement=fb.Measurement(encoder_resolution=RESOLUTION),
    )
    assert np.linalg.norm(run.error, axis=1).max() < 3e-3


LAW = {"pd": fb.PD, "computed torque": fb.ComputedTorque}


@pytest.mark.parametrize(
    "robot, law, delay, limit, chart",
    [
        (ROBOT, "computed torque", 0, None, "auto"),
        (fb.FiveBar(0.1, 0.12, 0.09, 0.11, 0.13), "computed torque", 2, 0.02, "task"),
        (fb.Biglide(), "pd", 1, None, "auto"),
        (fb.Biglide(0.3, 0.25, 0.35), "computed torque", 0, 20.0, "joint"),
    ],
    ids=["lab", "unequal", "biglide", "unequal biglide"],
)
def test_many_runs_with_encoders_and_delays_are_single_ones_sample_by_sample(
    robot, law, delay, limit, chart
):
    """Encoders round, so that the least difference of a law would show as a whole step of them."""
    working = (-1, -1)
    start = fb.dgm(robot, (0.0, 0.0)).xi
    gain = 40.0 if law == "computed torque" else 2.0 * robot.m
    controller = LAW[law](robot, gain, gain / 4)
    reference = fb.line(start, start + np.array([-0.02, 0.015]), 0.3)
    options = dict(
        measurement=fb.Measurement(delay, 2e-3),
        integrator=fb.Integrator("rk4", chart),
        torque_limit=limit,
        duration=0.4,
    )
    begin = fb.ikm(fb.igm(robot, start, working), (0.0, 0.0))
    run = fb.simulate(robot, controller, reference, start=begin, **options)
    (many,) = fb.simulate_many([robot], controller, reference, [begin], **options)
    for name in ("t", "q", "q_dot", "tau"):
        np.testing.assert_allclose(getattr(many, name), getattr(run, name), atol=1e-12)
    for name, one, other in zip(run.control._fields, many.control, run.control):
        np.testing.assert_allclose(one, other, atol=1e-11, err_msg=name)
    np.testing.assert_allclose(many.error, run.error, atol=1e-12)
    steps = many.control.q / 2e-3
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    at = np.searchsorted(run.t, run.control.t + 1e-9) - 1
    assert np.abs(many.control.q - many.q[at]).max() < 0.5001 * 2e-3
