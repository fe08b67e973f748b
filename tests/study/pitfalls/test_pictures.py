"""Every case's figure can be drawn from its result, with units on its axes."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.study.pitfalls import (
    crossing,
    differentiation,
    energy_drift,
    joint_space,
    pictures,
    redundant,
    sampled,
)

ROBOT = fb.FiveBar()


def draw_free_motion():
    steps = joint_space.whole_steps(20, 1e-3)
    attempts = [
        joint_space.free_motion_by(ROBOT, method, 1e-3) for method in ("RK45", "DOP853", "LSODA")
    ]
    ours = joint_space.free_motion_of_ours(ROBOT, 2e-3)
    naive = joint_space.free_motion_by_steps(ROBOT, steps)
    return pictures.free_motion(
        attempts, ours, naive, joint_space.free_motion_of_ours_by_steps(ROBOT, steps[::5])
    )


def draw_closure():
    start = joint_space.free_start(ROBOT)
    run = fb.simulate(ROBOT, duration=0.5, start=start, step=2e-3)
    motions = {"no stabilisation": redundant.redundant_motion(ROBOT, start, 0.5, 2e-3)}
    return pictures.closure(motions, (run.t, redundant.closure(ROBOT, run.q, run.xi)))


def draw_energy():
    drifts = [
        energy_drift.drift_by("explicit Euler", duration=0.5),
        energy_drift.drift_of_ours(duration=0.5),
    ]
    return pictures.energy(drifts)


def draw_crossing():
    pair = (crossing.straight(), crossing.compliant(ROBOT))
    return pictures.crossing(*(crossing.beside_crossing(ROBOT, reference) for reference in pair))


def draw_stability():
    return pictures.stability(
        [sampled.measure_limit(ROBOT, delay, count=2, resolution=1e-2) for delay in (0, 1)]
    )


def draw_differentiation():
    return pictures.differentiation(differentiation.error_curve(ROBOT, np.geomspace(1e-12, 1, 13)))


@pytest.mark.every(6)
@pytest.mark.parametrize(
    "draw",
    [
        draw_differentiation,
        draw_free_motion,
        draw_closure,
        draw_energy,
        draw_crossing,
        draw_stability,
    ],
)
def test_pictures(draw, tmp_path):
    figure = draw()
    figure.savefig(tmp_path / "figure.png")
    assert (tmp_path / "figure.png").stat().st_size > 10_000
    for axes in figure.axes:
        assert "(" in axes.get_xlabel() and axes.get_ylabel()
        assert axes.get_legend() is not None
