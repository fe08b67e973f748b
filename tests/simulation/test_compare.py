"""Comparing runs: the figures against the runs' own numbers, the table, the picture, and the shipped cases."""

import dataclasses

import matplotlib.pyplot as plt
import numpy as np
import pytest

import fivebar as fb
from fivebar.control.qp import Status
from fivebar.simulation.comparison import compare
from fivebar.study.control_cases import CASES, CONTROLLERS, case, run_case


@pytest.fixture(scope="module")
def runs():
    return run_case("torque-limit")


def test_figures_are_the_runs_own(runs):
    figures = compare(runs).figures
    for name, run in runs.items():
        size = np.linalg.norm(run.error, axis=1)
        assert figures[name]["rms_error_m"] == pytest.approx(np.sqrt(np.mean(size**2)), rel=1e-12)
        assert (
            figures[name]["max_error_m"] == size.max()
            and figures[name]["final_error_m"] == size[-1]
        )
        assert figures[name]["peak_torque_Nm"] == np.abs(run.tau).max(axis=0).tolist()
        assert max(figures[name]["peak_torque_Nm"]) == pytest.approx(run.torque_limit)
        at_limit = sum(0.001 for row in run.tau[:-1] if max(abs(row)) == run.torque_limit)
        assert figures[name]["saturated_s"] == pytest.approx(at_limit) and at_limit > 1
    log = runs["mpc"].log
    assert figures["mpc"]["median_solve_s"] == np.median(log.solve_time)
    assert figures["mpc"]["p99_solve_s"] == np.percentile(log.solve_time, 99)
    assert figures["mpc"]["fallbacks"] == 0 and np.isnan(figures["ctc"]["fallbacks"])


def test_fallbacks_are_counted(runs):
    log = runs["mpc"].log
    status = np.where(np.arange(len(log.t)) < 3, Status.CHECK_FAILED, Status.SOLVED)
    copy = dataclasses.replace(runs["mpc"])
    object.__setattr__(copy, "log", log._replace(status=status))
    assert compare({"mpc": copy}).figures["mpc"]["fallbacks"] == 3


def test_table_has_a_row_for_each_run_and_only_columns_with_numbers(runs):
    lines = str(compare(runs)).splitlines()
    assert len(lines) == 1 + len(runs) and len({len(line) for line in lines}) == 1
    assert "saturated (s)" in lines[0] and "solve, median (ms)" in lines[0]
    assert lines[1].startswith("ctc ") and lines[1].rstrip().endswith("-") and "17" in lines[1]
    bare = str(compare(run_case("task-1", ["ctc"])))
    assert "saturated" not in bare and "solve" not in bare and "12.1" in bare


@pytest.mark.deep
def test_picture_shows_errors_torques_limits_and_solve_times(runs, tmp_path):
    path, before = tmp_path / "comparison.png", plt.get_fignums()
    figure = compare(runs).plot(path)
    assert path.read_bytes()[:4] == b"\x89PNG" and plt.get_fignums() == before
    errors, times, left, right = figure.axes
    assert "at the limit" in left.get_legend().get_texts()[2].get_text()
    assert errors.get_yscale() == "log" and len(errors.lines) == len(runs)
    for axes, motor in ((left, 0), (right, 1)):
        drawn = np.array([line.get_ydata() for line in axes.lines[: len(runs)]])
        np.testing.assert_allclose(drawn, [1e3 * run.tau[:, motor] for run in runs.values()])
        limits = [line.get_ydata()[0] for line in axes.lines[len(runs) :]]
        assert sorted(limits) == pytest.approx(
            [-1e3 * runs["mpc"].torque_limit, 1e3 * runs["mpc"].torque_limit]
        )
    assert times.get_title() == "solve time"
    assert sum(patch.get_height() for patch in times.patches) == len(runs["mpc"].log.t)


def test_picture_without_solve_times_and_without_limits(runs):
    figure = compare({"ctc": runs["ctc"], "ctc-stiff": runs["ctc-stiff"]}).plot()
    assert [axes.get_title() for axes in figure.axes][1:] == ["left motor", "right motor"]
    (text,) = compare(run_case("task-1", ["ctc"])).plot().axes[1].get_legend().get_texts()
    assert text.get_text() == "ctc"


def test_what_cannot_be_compared():
    with pytest.raises(ValueError, match="at least one run"):
        compare({})
    with pytest.raises(ValueError, match="the run 'free' has no reference"):
        compare({"free": fb.simulate(fb.FiveBar(), duration=0.1)})


def test_cases_differ_from_task_1_in_what_they_say():
    assert set(CASES) == {"task-1", "torque-limit", "mass", "delay", "encoder", "crossing"}
    chosen = {name: case(name) for name in CASES if name != "crossing"}
    for each in chosen.values():
        assert (
            each.reference(0.0)[0] == pytest.approx((0.09, 0.06796322))
            and each.reference.duration == 2.0
        )
        assert each.reference(2.0)[0] == pytest.approx((0.0, 0.1), abs=1e-15)
    assert chosen["torque-limit"].torque_limit == pytest.approx(0.6 * 0.00867, rel=2e-3)
    assert chosen["mass"].plant.m == 0.6 and chosen["mass"].model.m == 0.5
    assert chosen["delay"].measurement == fb.Measurement(delay=1)
    assert chosen["encoder"].measurement == fb.Measurement(0, 2 * np.pi / 4096)
    tracker = CONTROLLERS["mpc"](chosen["delay"])
    assert tracker.delay == 1 and tracker.period == 0.01


def test_the_crossing_is_task_2_of_the_lab_across_type_2():
    """Along the line, from home to (0.05, 0) in 4 s: det A changes its sign once, at 3 s, within the torque limit."""
    crossing = case("crossing")
    plan = crossing.reference
    assert plan.duration == 4.0 and crossing.torque_limit == 0.05
    assert plan(0.0)[0] == pytest.approx((0.09, 0.06796322)) and plan(4.0)[0] == pytest.approx(
        (0.05, 0.0)
    )
    t = np.linspace(0.0, 4.0, 401)
    signs = np.sign(fb.igm(crossing.model, plan(t)[0], (-1, -1)).det_A)
    assert t[np.flatnonzero(np.diff(signs))] == pytest.approx([3.0], abs=0.02)
    assert np.abs(plan.torques(t)).max() < 0.05


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: case("task-9"), "no case 'task-9'; the known ones are task-1, "),
        (
            lambda: case("task-1").simulate("lqr"),
            "no controller 'lqr'; the known ones are ctc, ctc-stiff, mpc$",
        ),
    ],
)
def test_unknown_names(call, words):
    with pytest.raises(ValueError, match=words):
        call()


def test_torques_of_motors_and_forces_of_slides_are_not_compared():
    robot, slides = fb.FiveBar(), fb.Biglide()
    runs = {}
    for name, each, at in (("a", robot, (0.05, 0.1)), ("b", slides, (0.0, 0.0))):
        line = fb.line(at, at, 0.02)
        runs[name] = fb.simulate(each, fb.PD(each, 1.0, 0.1), line, duration=0.02)
    assert compare({"b": runs["b"]}).figures["b"]["peak_force_N"] == pytest.approx(
        [0.0, 0.0], abs=1e-9
    )
    with pytest.raises(ValueError, match="of different kinds of robots"):
        compare(runs)
