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
    steps = joint_space.whole_steps(4, 1e-3)
    attempts = [joint_space.free_motion_by(ROBOT, "LSODA", 1e-3)]
    ours = joint_space.free_motion_of_ours(ROBOT, 2e-3)
    naive = joint_space.free_motion_by_steps(ROBOT, steps)
    by_steps = joint_space.free_motion_of_ours_by_steps(ROBOT, steps[::2])
    figure = pictures.free_motion(attempts, ours, naive, by_steps)
    left, right = figure.axes
    assert curves(left)["fivebar"] == [list(ours.t), list(1e3 * ours.xi[:, 1])]
    (end,) = (line for line in left.lines if line.get_label() == "true end")
    assert end.get_markerfacecolor() == "white"  # the end of our curve shows inside
    assert end.get_ydata()[0] == pytest.approx(1e3 * ours.xi[-1, 1], abs=1e-6)
    naive_label = next(label for label in curves(right) if "finished" in label)
    size = np.abs(naive.energy_error)
    ends = np.isfinite(size)
    assert curves(right)[naive_label] == [list(1e3 * steps[ends]), list(size[ends])]
    assert curves(right)["fivebar"] == [list(1e3 * by_steps.step), list(by_steps.energy_error)]
    return figure


def draw_closure():
    start = joint_space.free_start(ROBOT)
    run = fb.simulate(ROBOT, duration=0.5, start=start, step=2e-3)
    motions = {"no stabilisation": redundant.redundant_motion(ROBOT, start, 0.5, 2e-3)}
    figure = pictures.closure(motions, (run.t, redundant.closure(ROBOT, run.q, run.xi)))
    drawn = curves(figure.axes[0])
    assert drawn["no stabilisation"][0] == list(motions["no stabilisation"].t)
    assert drawn["no stabilisation"][1][1:] == list(motions["no stabilisation"].closure[1:])
    assert max(drawn["fivebar"][1]) < 1e-12 < max(drawn["no stabilisation"][1])
    return figure


def draw_energy():
    drifts = [
        energy_drift.drift_by("explicit Euler", duration=0.5),
        energy_drift.drift_of_ours(duration=0.5),
    ]
    figure = pictures.energy(drifts)
    for drift, line in zip(drifts, figure.axes[0].lines):
        assert line.get_label().startswith(drift.name) and list(line.get_xdata()) == list(drift.t)
        so_far = line.get_ydata()
        assert so_far[-1] == np.abs(drift.error).max() and (np.diff(so_far) >= 0).all()
        assert drift.error[0] == 0.0
    return figure


def draw_crossing():
    pair = (crossing.straight(), crossing.compliant(ROBOT))
    cases = [crossing.beside_crossing(ROBOT, reference) for reference in pair]
    figure = pictures.crossing(*cases)
    for side, axes in zip((-1, 1), figure.axes):
        for case, (t, tau) in zip(cases, curves(axes).values()):
            here = side * case.offset > 0
            assert t == list(np.abs(case.offset[here]))
            assert tau == list(np.abs(case.torque[here]).max(axis=1))
    return figure


def draw_stability():
    limits = [sampled.measure_limit(ROBOT, delay, count=2, resolution=1e-2) for delay in (0, 1)]
    figure = pictures.stability(limits)
    for limit, axes in zip(limits, figure.axes):
        assert limit.worst < 0.05 and limit.measured.shape == limit.exact.shape == (2, 2)
        measured = curves(axes)["limit on the simulated robot"]
        assert measured == limit.measured.T.tolist()
        p, q = curves(axes)["critically damped"]
        assert np.allclose(np.square(q), 4 * np.array(p))
    return figure


def draw_differentiation():
    curve = differentiation.error_curve(ROBOT, np.geomspace(1e-12, 1, 13))
    figure = pictures.differentiation(curve)
    drawn = curves(figure.axes[0])
    for name in ("velocity", "acceleration"):
        (label,) = (each for each in drawn if each.startswith(name))
        assert drawn[label] == [list(curve.step), list(getattr(curve, name))]
    return figure


def curves(axes):
    """{label: [x, y]} of the lines with a label."""
    lines = [line for line in axes.lines if not line.get_label().startswith("_")]
    return {line.get_label(): [list(each) for each in line.get_data()] for line in lines}


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
def test_pictures(draw):
    figure = draw()
    for axes in figure.axes:
        assert "(" in axes.get_xlabel() and axes.get_ylabel() and axes.get_title()
        assert axes.get_legend() is not None
        for line in axes.lines:  # ours in ink, in one stroke; the others in colours, each its own
            ours = line.get_label().startswith(("fivebar", "compliant"))
            if line.get_linestyle() != "None" and draw is not draw_stability:
                assert (line.get_color() == pictures.INK) == ours
                assert (line.get_linestyle() == "-") == ours
