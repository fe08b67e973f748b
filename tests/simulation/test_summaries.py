"""Summaries of many runs are those of the runs, whatever the chunks, workers and executors."""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import casadi
import numpy as np
import pytest

import fivebar as fb

ROBOTS = [fb.FiveBar(m=m, l11=l11) for m in (0.4, 0.6) for l11 in (0.088, 0.09, 0.093)]
CONTROLLER = fb.ComputedTorque(fb.FiveBar(), kp=100, kd=20)
LINE = fb.line((0.09, 0.068), (0.06, 0.09), duration=0.2)
CROSSING = fb.dkm(
    fb.dgm(fb.FiveBar(), np.tile((0.0, 0.0), (4, 1))), [(9.0, -9.0), (1, 1), (-8, 3), (0, 0)]
)


def latest(run):
    return float(run.t[np.argmax(np.linalg.norm(run.error, axis=1))])


def failing(run):
    if run.robot.m > 0.5:
        raise RuntimeError("too heavy")
    return 1.0


def summarized(robots=ROBOTS, controller=CONTROLLER, reference=LINE, starts=None, **options):
    names = {"control_period", "torque_limit", "measurement", "integrator", "duration"}
    simulated = {name: options.pop(name) for name in names & options.keys()}
    summary = fb.Summary(**options)
    return fb.simulate_many(robots, controller, reference, starts, summary=summary, **simulated)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"torque_limit": 0.01, "measurement": fb.Measurement(1, 0.001)},
        {"integrator": fb.Integrator("dop8", chart="task")},
    ],
)
def test_figures_are_those_of_the_runs(options):
    runs = fb.simulate_many(ROBOTS, CONTROLLER, LINE, **options)
    table = summarized(functions={"latest": latest}, **options)
    assert len(table) == len(runs) and table.errors == ()
    for k, run in enumerate(runs):
        assert run.torque_limit == options.get("torque_limit") and run.robot == ROBOTS[k]
        error = np.linalg.norm(run.error, axis=1)
        expected = {
            "q11": run.q[-1, 0],
            "q21_dot": run.q_dot[-1, 1],
            "y": run.xi[-1, 1],
            "max_error_m": error.max(),
            "rms_error_m": np.sqrt(np.mean(error**2)),
            "final_error_m": error[-1],
            "peak_tau1": np.abs(run.tau[:, 0]).max(),
            "crossings": len(run.events),
            "latest": latest(run),
            "m": run.robot.m,
            "l11": run.robot.l11,
            "kd2": 20.0,
        }
        found = {name: table[name][k] for name in expected}
        assert found == pytest.approx(expected, rel=1e-13)


def test_crossings_and_last_states_without_a_reference_to_track():
    torqueless = fb.PD(fb.FiveBar(), 0.0, 0.0)
    runs = fb.simulate_many(fb.FiveBar(), torqueless, LINE, CROSSING, duration=0.6)
    table = summarized(fb.FiveBar(), torqueless, LINE, CROSSING, duration=0.6)
    counts = [len(run.events) for run in runs]
    assert table["crossings"].tolist() == counts and max(counts) > 2 and min(counts) == 0
    assert table["x"].tolist() == [run.xi[-1, 0] for run in runs]


@pytest.mark.deep
def test_chunks_workers_executors_and_folders_change_nothing(tmp_path):
    expected = summarized(functions={"latest": latest})
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        tables = [
            summarized(functions={"latest": latest}, chunk=2, workers=2),
            summarized(functions={"latest": latest}, chunk=4, executor=pool),
            summarized(functions={"latest": latest}, chunk=5, out=tmp_path, workers=1),
            fb.Summary.load(tmp_path),
        ]
    for table in tables:
        for name in (*expected.names, *expected.figures):
            assert np.array_equal(table[name], expected[name]), name


def test_the_same_call_goes_on_and_another_is_refused(tmp_path):
    first = summarized(chunk=2, out=tmp_path, workers=1)
    (tmp_path / "chunk-000001.npz").unlink()
    kept = {path.name: path.stat().st_mtime_ns for path in tmp_path.glob("*.npz")}
    again = summarized(chunk=2, out=tmp_path, workers=1)
    for name, time in kept.items():
        assert (tmp_path / name).stat().st_mtime_ns == time
    assert np.array_equal(again["rms_error_m"], first["rms_error_m"])
    for change in (
        {"torque_limit": 0.1},
        {"controller": fb.PD(fb.FiveBar(), 1.0, 0.1)},
        {"reference": fb.line((0.09, 0.068), (0.06, 0.091), duration=0.2)},
        {"functions": {"latest": latest}},
        {"robots": [replace(robot, m=0.1) for robot in ROBOTS]},
    ):
        with pytest.raises(ValueError, match=r"out: .* holds (another summary|other cases)"):
            summarized(chunk=2, out=tmp_path, workers=1, **change)


def test_runs_that_fail_are_nan_and_say_why():
    table = summarized(functions={"failing": failing, "latest": latest})
    assert np.isnan(table["failing"]).tolist() == [False] * 3 + [True] * 3
    assert table.errors == tuple((k, "failing: RuntimeError: too heavy") for k in (3, 4, 5))
    assert np.isfinite(table["latest"]).all()
    wild = [fb.PD(fb.FiveBar(), kp, 0.0) for kp in (1.0, 1e7)]
    table = summarized(fb.FiveBar(), wild)
    assert np.isfinite(table["x"][0]) and np.isnan(table["x"][1])
    ((number, message),) = table.errors
    assert number == 1 and "too fast for steps of 0.001 s" in message


@pytest.mark.parametrize(
    "options,words",
    [
        ({"functions": [latest]}, r"functions must be \{name: function\}"),
        ({"functions": {"x": latest}}, "x is the name of a built-in figure"),
        ({"chunk": 0}, "chunk"),
        ({"executor": 3}, "executor must be"),
        ({"out": 3}, "out must be a folder's path"),
    ],
)
def test_bad_options(options, words):
    with pytest.raises((TypeError, ValueError), match=words):
        summarized(**options)


class Saturating(fb.PD):
    """A law of the user's own."""

    def law(self, q, q_dot, q_ref, q_ref_dot, q_ref_ddot):
        tau = super().law(q, q_dot, q_ref, q_ref_dot, q_ref_ddot)
        return 0.05 * np.tanh(tau / 0.05)


class OfNumbers(fb.PD):
    def law(self, q, q_dot, q_ref, q_ref_dot, q_ref_ddot):
        return q - q_ref if q[0] > 0 else q_ref - q


class Called(fb.PD):
    def __call__(self, t, q, q_dot, reference):
        return np.zeros(2)


def test_runs_of_several_calls_are_those_of_one(monkeypatch):
    together = fb.simulate_many(ROBOTS, CONTROLLER, LINE)
    monkeypatch.setattr("fivebar.simulation.many.TOGETHER", 4)
    for one, other in zip(together, fb.simulate_many(ROBOTS, CONTROLLER, LINE), strict=True):
        assert one.robot == other.robot
        np.testing.assert_allclose(other.q, one.q, rtol=0, atol=1e-14)


def test_a_law_that_is_overridden_is_compiled():
    laws = [Saturating(fb.FiveBar(), kp, 0.5) for kp in (5.0, 9.0)]
    runs = fb.simulate_many("amoro", laws, LINE)  # a name is one robot, not a sequence of letters
    for law, run in zip(laws, runs):
        alone = fb.simulate(fb.FiveBar(), law, LINE, integrator=fb.Integrator("rk4"))
        assert np.abs(run.q - alone.q).max() < 1e-11 and np.abs(run.tau).max() <= 0.05
    with pytest.raises(ValueError, match="OfNumbers.law fails where it is compiled"):
        fb.simulate_many(ROBOTS, OfNumbers(fb.FiveBar(), 1.0, 0.1), LINE)
    with pytest.raises(ValueError, match=r"Called overrides __call__, which would not be called"):
        fb.simulate_many(ROBOTS, Called(fb.FiveBar(), 1.0, 0.1), LINE)


def rubbed(t, q, q_dot, tau):
    return tau - 0.01 * casadi.tanh(q_dot / 0.1) + 0.005 * casadi.sin(30 * t)


def test_torques_of_the_users_own_in_many_loops():
    plants = [fb.LoadedRobot(robot, rubbed) for robot in ROBOTS]
    runs = fb.simulate_many(plants, CONTROLLER, LINE)
    for plant, run in zip(plants, runs):
        alone = fb.simulate(plant, CONTROLLER, LINE, integrator=fb.Integrator("rk4"))
        assert np.abs(run.q - alone.q).max() < 1e-12
        assert np.allclose(run.friction_loss, alone.friction_loss, rtol=0, atol=1e-12)
    table = summarized(plants, workers=2, chunk=3)
    assert table["q11"].tolist() == [run.q[-1, 0] for run in runs]
    with pytest.raises(ValueError, match="the same torques: number 1 has others"):
        fb.simulate_many([plants[0], ROBOTS[0]], CONTROLLER, LINE)
