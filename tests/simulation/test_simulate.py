"""Simulated motion against the reference's numbers, its own power balance, and the singularities it meets."""

import math
import sys

import numpy as np
import pytest

import fivebar as fb
from fivebar.models.four_joints import bars_rates
from tests.benchmarks.free_motions import random_motion
from tests.helpers import DATA

ROBOT = fb.FiveBar()
TASK_1 = fb.line((0.09, 0.06796322), (0.0, 0.1), 2.0)
FREE_END = (0.0087618923917, 0.1480740333255)  # of the free motion at 2 s, good to 5e-13 m


@pytest.fixture(scope="module")
def free_start():
    return fb.ikm(fb.igm(ROBOT, (0.01, 0.12), working=(1, -1)), (0.02, -0.30))


def kinetic(run):
    """Energy along a run from its joint rates, by a difference formula for xi' that no model of ours enters."""
    xi_dot = np.gradient(run.xi, run.t, axis=0, edge_order=2)
    return 0.5 * (
        run.q_dot**2 @ (run.robot.zz1, run.robot.zz2) + run.robot.m * np.sum(xi_dot**2, axis=1)
    )


def test_a_controller_that_reads_another_assembly_mode_is_warned_of():
    """The working modes (-1, 1) reach task 1 in assembly mode +1; a PD without gravity reads none."""
    gains = dict(kp=100, kd=20, working=(-1, 1))
    with pytest.warns(
        RuntimeWarning, match=r"in assembly mode \+1, .* mode -1: give it assembly=1"
    ):
        wrong = fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, **gains), TASK_1)
    with pytest.warns(RuntimeWarning, match="give it assembly=1"):
        fb.simulate_many(ROBOT, [fb.ComputedTorque(ROBOT, **gains)], TASK_1)
    right = fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, assembly=1, **gains), TASK_1)
    assert 20 * abs(right.error).max() < abs(wrong.error).max()
    fb.simulate(ROBOT, fb.PD(ROBOT, 1.0, 0.1, working=(-1, 1)), TASK_1)


def test_sampled_computed_torque_of_the_reference():
    import json

    data = json.loads((DATA / "sampled_control.json").read_text("utf-8"))
    for case in data["computed_torque_lab_task_1"]["runs"]:
        controller = fb.ComputedTorque(ROBOT, case["Kp"], case["Kd"])
        run = fb.simulate(
            ROBOT,
            controller,
            TASK_1,
            duration=2.5,
            measurement=fb.Measurement(delay=case["delay_samples"]),
        )
        sampled = run.q_error[10::10]
        assert np.abs(sampled).max(axis=0) == pytest.approx(
            case["max_abs_joint_error_rad"], rel=1e-9
        )
        assert np.sqrt(np.mean(sampled**2, axis=0)) == pytest.approx(
            case["rms_joint_error_rad"], rel=1e-9
        )
        assert np.abs(sampled[-1]) == pytest.approx(case["final_joint_error_rad"], rel=1e-6)
        assert np.linalg.norm(run.error[10::10], axis=1).max() == pytest.approx(
            case["max_tip_error_m"], rel=1e-9
        )
        assert np.abs(run.tau).max(axis=0) == pytest.approx(case["max_abs_tau_Nm"], rel=1e-9)
        assert run.control.t == pytest.approx(run.t[:-1:10])
        assert run.control.q == pytest.approx(run.q[:-1:10], abs=1e-15)


def _ellipse_of_arrays(t):
    c, s = np.cos(6 * t), np.sin(6 * t)
    return (
        np.array([0.02 * c, 0.1 + 0.01 * s]),
        np.array([-0.12 * s, 0.06 * c]),
        np.array([-0.72 * c, -0.36 * s]),
    )


def _ellipse_of_numbers(t):
    c, s = math.cos(6 * t), math.sin(6 * t)
    return [0.02 * c, 0.1 + 0.01 * s], [-0.12 * s, 0.06 * c], [-0.72 * c, -0.36 * s]


@pytest.mark.parametrize("reference", [_ellipse_of_arrays, _ellipse_of_numbers])
@pytest.mark.parametrize("duration", [0.001, 0.2])  # of two rows, as many as a point has numbers
def test_a_reference_of_ones_own_is_called_with_one_time(reference, duration, tmp_path):
    law = fb.ComputedTorque(ROBOT, 400, 40)
    run = fb.simulate(ROBOT, law, reference, duration=duration)
    many = fb.simulate_many([ROBOT, ROBOT], law, reference, duration=duration)
    tracked = fb.simulate(ROBOT, fb.Tracker(ROBOT), reference, duration=duration)
    expected = np.column_stack([0.02 * np.cos(6 * run.t), 0.1 + 0.01 * np.sin(6 * run.t)])
    for each in (run, *many, tracked):
        assert each.xi_ref == pytest.approx(expected, abs=1e-16)
        assert np.abs(each.error).max() < 2e-4
        each.to_csv(tmp_path / "run.csv")
    assert many[1].q == pytest.approx(run.q, abs=1e-11)


@pytest.mark.parametrize(
    "answer", [((0.0, 0.1), (0, 0)), ((0.0, 0.1, 0.0),) * 3, 0.1, ((0.0, 0.1), (0, 0), None)]
)
def test_a_reference_that_gives_no_three_pairs_is_refused_before_the_run(answer):
    calls = []
    start = fb.dkm(fb.dgm(ROBOT, (0, 0)), (0, 0))
    for options in ({}, {"start": start}):
        with pytest.raises(ValueError, match=r"each \(2,\), at t = 0 s, not"):
            fb.simulate(
                ROBOT, lambda *at: calls.append(at), lambda t: answer, duration=0.1, **options
            )
    with pytest.raises(ValueError, match=r"each \(2,\), at t = 0 s, not"):
        fb.simulate_many([ROBOT], fb.PD(ROBOT, 1, 1), lambda t: answer, [start], duration=0.1)
    assert not calls


@pytest.mark.parametrize(
    "controller",
    [
        fb.PD(fb.Biglide(), 10, 1),
        fb.ComputedTorque(fb.Biglide(), 100, 20),
        fb.Tracker(fb.Biglide()),
    ],
)
def test_a_controller_of_another_kind_of_robot_is_refused(controller):
    words = "the controller is of a biglide robot, the robot is a five-bar robot"
    with pytest.raises(ValueError, match=words):
        fb.simulate(ROBOT, controller, TASK_1)
    if isinstance(controller, fb.PD):
        with pytest.raises(ValueError, match=words):
            fb.simulate_many([ROBOT, ROBOT], controller, TASK_1)


@pytest.mark.parametrize(
    "torques, cause",
    [
        (lambda t, q, q_dot, tau: tau - 1e6 * q_dot, "20020 steps do not bring it to 0.01 s"),
        (lambda t, q, q_dot, tau: tau - 1e12 * q_dot, r"a step of 8\S* s is too long"),
        (lambda t, q, q_dot, tau: tau - np.sign(q_dot), r"a step of 8\S* s is too long"),
    ],
)
def test_torques_that_are_too_stiff_are_no_fast_motion(torques, cause):
    with pytest.raises(ArithmeticError, match=f"is slow, but .* too stiff or jumps: {cause}"):
        fb.simulate(fb.LoadedRobot(ROBOT, torques), fb.ComputedTorque(ROBOT, 100, 20), TASK_1)


def test_power_balance_along_a_driven_motion():
    def torque(t, q, q_dot, reference):
        return 0.02 * np.cos(t), -0.016 * np.cos(t)

    run = fb.simulate(ROBOT, torque, duration=1.0, control_period=0.001, step=1e-3)
    work = np.concatenate([[0], np.cumsum(np.sum(np.diff(run.q, axis=0) * run.tau[:-1], axis=1))])
    assert run.energy == pytest.approx(work, rel=1e-9, abs=1e-16)
    assert kinetic(run)[5:-5] == pytest.approx(work[5:-5], rel=2e-4, abs=1e-8)


def test_energy_of_the_free_motion(free_start):
    for options, bound in (
        (dict(step=5e-4, integrator=fb.Integrator("rk4")), 1e-8),
        (dict(step=1e-4, integrator=fb.Integrator("rk4")), 1e-10),
        ({}, 1e-10),
    ):
        energy = fb.simulate(ROBOT, duration=10.0, start=free_start, **options).energy
        assert energy[0] == pytest.approx(fb.energy(free_start), rel=1e-14)
        assert np.abs(energy / energy[0] - 1).max() <= bound


@pytest.mark.parametrize("chart", ["joint", "task", "auto"])
def test_rk4_has_order_4(chart):
    def torque(t, q, q_dot, reference):
        return 0.008 * np.cos(2 * np.pi * t), -0.006 * np.cos(2 * np.pi * t)

    def end(step):
        integrator = fb.Integrator("rk4", chart)
        options = dict(duration=1.28, control_period=0.16, step=step, integrator=integrator)
        return fb.simulate(ROBOT, torque, **options).q[-1]

    exact = end(0.16 / 512)
    errors = [np.linalg.norm(end(0.16 / n) - exact) for n in (16, 32, 64)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4, abs=0.1)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(4, abs=0.1)


def test_free_motion_passes_all_its_singularities(free_start):
    run = fb.simulate(ROBOT, duration=2.0, start=free_start, step=1e-4)
    assert run.xi[-1] == pytest.approx(FREE_END, abs=1e-11)
    assert [(event.margin, int(event.type)) for event in run.events[:3]] == [
        ("det A", 2),
        ("det A", 2),
        ("sin q22", 1),
    ]
    assert [event.t for event in run.events[:3]] == pytest.approx([0.1164, 0.604, 0.6768], abs=4e-4)
    assert run.events[0].before == (1, -1, -1) and run.events[0].after == (1, -1, 1)
    assert repr(run) == f"<Run: five-bar robot, 2 s in 20001 rows, {len(run.events)} crossings>"
    assert np.abs(np.diff(run.q, axis=0)).max() < 0.1  # continuous


@pytest.mark.parametrize(
    "options, bound",
    [({}, 1e-12), ({"step": 0.01}, 1e-12), ({"integrator": fb.Integrator("dop8")}, 1e-10)],
)
def test_times_of_crossings(free_start, options, bound):
    """Against zeros of polynomials of degree 9 through ten cross products of the bars as drawn, 1e-4 s apart."""
    times = [0.11642284070442, 0.60381734505384, 0.67684312033517]
    run = fb.simulate(ROBOT, duration=0.8, start=free_start, **options)
    assert [event.t for event in run.events] == pytest.approx(times, abs=bound)


@pytest.mark.deep
@pytest.mark.parametrize("chart, name", [("joint", "det A"), ("task", "sin q22")])
def test_a_chart_held_fast_refuses_to_jump(free_start, chart, name):
    for step in np.linspace(4e-4, 4e-3, 25):
        with pytest.raises(
            fb.SingularityError, match=f"jumps the singularity of the {chart} chart \\({name}"
        ):
            fb.simulate(
                ROBOT,
                duration=2.0,
                start=free_start,
                step=float(step),
                integrator=fb.Integrator(chart=chart),
            )


def test_torque_limit_delay_and_encoder():
    controller = fb.ComputedTorque(ROBOT, 100, 20)
    run = fb.simulate(ROBOT, controller, TASK_1, torque_limit=0.006)
    assert np.abs(run.tau).max() == 0.006 and np.abs(run.control.commanded).max() > 0.006
    assert run.control.applied == pytest.approx(np.clip(run.control.commanded, -0.006, 0.006))
    run = fb.simulate(ROBOT, controller, TASK_1, measurement=fb.Measurement(delay=2))
    assert not run.control.applied[:2].any()
    assert (run.control.applied[2:] == run.control.commanded[:-2]).all()
    resolution = 2 * np.pi / 4096
    run = fb.simulate(
        ROBOT, controller, TASK_1, measurement=fb.Measurement(encoder_resolution=resolution)
    )
    counts = run.control.q / resolution
    assert counts == pytest.approx(np.round(counts), abs=1e-9)
    assert run.control.q_dot[1:] == pytest.approx(np.diff(run.control.q, axis=0) / 0.01, abs=1e-12)
    assert np.linalg.norm(run.error, axis=1).max() < 1e-3


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_delay_and_encoder_together(delay):
    """The controller gets what was rounded at its own sample; only its torque comes late."""
    controller, resolution = fb.ComputedTorque(ROBOT, 100, 20), 2 * np.pi / 4096
    run = fb.simulate(
        ROBOT,
        controller,
        TASK_1,
        measurement=fb.Measurement(delay=delay, encoder_resolution=resolution),
    )
    control = run.control
    assert (control.q == np.round(run.q[:-1:10] / resolution) * resolution).all()
    assert control.q_dot[1:] == pytest.approx(np.diff(control.q, axis=0) / 0.01, abs=1e-12)
    told = [controller(*row, TASK_1) for row in zip(control.t, control.q, control.q_dot)]
    assert (control.commanded == told).all() and not control.applied[:delay].any()
    assert (control.applied[delay:] == control.commanded[: len(told) - delay]).all()
    assert (run.tau[:-1] == np.repeat(control.applied, 10, axis=0)).all()


@pytest.mark.parametrize("working", [(-1, -1), (-1, 1), (1, -1), (1, 1)])
def test_joint_errors_are_in_the_working_modes_of_the_start(working):
    reference = fb.line((0.0, 0.1), (0.02, 0.12), 1.0)
    assembly = int(fb.igm(ROBOT, (0.0, 0.1), working).assembly)
    controller = fb.ComputedTorque(ROBOT, 100, 20, working, assembly)
    run = fb.simulate(ROBOT, controller, reference)
    q_ref = fb.igm(ROBOT, run.xi_ref, working).q
    assert np.abs(run.q_error).max() < 1e-2
    assert (
        run.q_error == pytest.approx(np.angle(np.exp(1j * (run.q - q_ref))), abs=1e-13)
        and run.q_error.any()
    )


def test_step_error_is_the_error_of_steps_ten_times_as_fine_as_the_tolerance(
    free_start, monkeypatch
):
    exact = fb.simulate(ROBOT, duration=0.5, start=free_start)
    for tolerance in (1e-4, 1e-6, 1e-8):
        run = fb.simulate(
            ROBOT, duration=0.5, start=free_start, integrator=fb.Integrator(tolerance=tolerance)
        )
        with monkeypatch.context() as patch:
            patch.setattr(sys.modules["fivebar.simulation.simulate"], "TOLERANCE", tolerance / 10)
            coarse = fb.simulate(ROBOT, duration=0.5, start=free_start)
        assert run.step_error == pytest.approx(np.abs(coarse.q - exact.q).max(), rel=0.01)
        assert np.abs(run.q - exact.q).max() < 0.01 * run.step_error <= 0.01 * tolerance


@pytest.mark.parametrize("period", [0.01, 0.05])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-10])
def test_step_error_where_the_controllers_periods_are_the_steps(period, tolerance):
    """Both passes took the same steps, so their difference was 0; in the task chart are others."""
    law = fb.ComputedTorque(ROBOT, 40, 10)
    reference = fb.line((0.09, 0.068), (0.03, 0.1), 0.5)
    run, other = (
        fb.simulate(ROBOT, law, reference, control_period=period, integrator=integrator)
        for integrator in (fb.Integrator(tolerance=tolerance), fb.Integrator("dop8", "task"))
    )
    assert 0 < np.abs(run.q - other.q).max() <= run.step_error <= tolerance


def test_model_mismatch_costs_accuracy():
    heavy = fb.ComputedTorque(fb.FiveBar(m=0.6), 100, 20)
    worst = [
        np.linalg.norm(fb.simulate(ROBOT, c, TASK_1).error, axis=1).max()
        for c in (fb.ComputedTorque(ROBOT, 100, 20), heavy)
    ]
    assert 3 * worst[0] < worst[1] < 1e-3


def test_pd_tracks_less_well():
    run = fb.simulate(ROBOT, fb.PD(ROBOT, 0.4, 0.08), TASK_1)
    worst = np.linalg.norm(run.error, axis=1).max()
    assert 1e-4 < worst < 2e-2 and f"rows, error at most {1e6 * worst:.4g} um" in repr(run)


def test_other_robots_and_modes(robot, reachable):
    xi, working = reachable
    start = fb.ikm(fb.igm(robot, xi[3], tuple(working[3].tolist())), (0.05, 0.02))
    coarse, fine = (
        fb.simulate(robot, duration=0.5, start=start, step=step) for step in (1e-3, 2.5e-4)
    )
    assert coarse.xi[-1] == pytest.approx(fine.xi[-1], abs=1e-8)


def test_run_is_saved_and_read_back(tmp_path, free_start):
    for run in (
        fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), TASK_1, torque_limit=0.006),
        fb.simulate(ROBOT, duration=0.7, start=free_start),
    ):
        run.to_csv(tmp_path / "run.csv")
        back = fb.Run.from_csv(tmp_path / "run.csv")
        assert (
            back.robot == run.robot
            and back.torque_limit == run.torque_limit
            and back.events == run.events
        )
        for name in ("t", "q", "q_dot", "xi", "tau", "energy", "xi_ref"):
            np.testing.assert_array_equal(getattr(back, name), getattr(run, name))
    (tmp_path / "other.csv").write_text("t,x,y\n0,0,0\n", encoding="utf-8")
    with pytest.raises(ValueError, match="line 1: not a file written by Run.to_csv"):
        fb.Run.from_csv(tmp_path / "other.csv")
    with pytest.raises(ValueError, match="no reference"):
        run.error  # noqa: B018


@pytest.mark.parametrize(
    "options, message",
    [
        (dict(step=0), "step must be finite and > 0"),
        (dict(step=0.003), "control_period = 0.01 s must be a multiple of step = 0.003 s"),
        (dict(duration=1e7), r"duration = 1e\+07 s is 1e\+10 steps of 0.001 s: at most 1e\+07"),
        (dict(torque_limit=-1.0), "torque_limit must be finite and > 0"),
        (dict(duration=np.inf), "duration must be finite"),
        (dict(controller=lambda *_: (1, 2, 3)), r"must return two torques, not \(1, 2, 3\)"),
        (dict(controller=lambda *_: "1 2"), "the controller must return two torques, not '1 2'"),
        (dict(controller=lambda *_: [1j, 0]), r"must return two torques, not \[1j, 0\]"),
        (dict(controller=lambda *_: None), "must return two torques, not None"),
        (
            dict(controller=lambda *_: (np.nan, 0)),
            r"the controller's torque is \[nan, 0.0\] N m at t = 0 s",
        ),
        (dict(reference=None), "needs a duration"),
        (
            dict(
                reference=fb.polynomial(
                    [(t, {0: (x, 0.1), 1: (0.0, 0.0)}) for t, x in ((-3.0, 0.02), (-1.0, -0.02))]
                )
            ),
            "the reference ends at t = -1 s, and a run begins at 0",
        ),
        (
            dict(controller=lambda *_: (1e8, -1e8)),
            "too fast: 20020 steps do not bring it to 0.01 s .joint",
        ),
        (
            dict(controller=lambda *_: (1e8, -1e8), integrator=fb.Integrator("rk4")),
            "too fast for steps of 0.001 s",
        ),
        (dict(reference=None, duration=0.1), "ComputedTorque needs a reference to track"),
        (dict(controller=fb.FeedForward(ROBOT, 1, 1)), "FeedForward needs a Plan as the reference"),
        (
            dict(start=fb.dkm(fb.dgm(fb.FiveBar(d=0.1), (0, 0)), (0, 0))),
            "start is of another robot",
        ),
        (
            dict(start=fb.dkm(fb.dgm(ROBOT, np.zeros((3, 2))), (0, 0))),
            "start must be the Rates of a single pose",
        ),
    ],
)
def test_bad_simulations(options, message):
    given = dict(controller=fb.ComputedTorque(ROBOT, 100, 20), reference=TASK_1) | options
    with pytest.raises((ValueError, ArithmeticError), match=message):
        fb.simulate(ROBOT, **given)


def test_two_limits_of_torque_are_refused_by_what_is_known():
    controller = fb.ComputedTorque(ROBOT, 100, 20)
    with pytest.raises(TypeError, match=r"one number for both joints, or motors, not \(1, 2\)"):
        fb.simulate(ROBOT, controller, TASK_1, torque_limit=(1, 2))


@pytest.mark.parametrize(
    "setting, options, message",
    [
        (fb.Measurement, dict(delay=-1), "delay must be a whole number"),
        (fb.Measurement, dict(delay=1.5), "delay must be a whole number"),
        (fb.Measurement, dict(delay=True), "delay must be a whole number"),
        (fb.Measurement, dict(delay=10**12), "delay must be at most"),
        (fb.Measurement, dict(encoder_resolution=0), "encoder_resolution must be"),
        (fb.Integrator, dict(chart="polar"), "chart must be one of auto, task, joint"),
        (fb.Integrator, dict(method="euler"), "method must be one of"),
        (fb.Integrator, dict(jit=2), "jit must be"),
        (fb.Integrator, dict(tolerance=1e-20), "tolerance = 1e-20 is below rounding"),
        (fb.Integrator, dict(tolerance=1e-6, method="rk4"), "tolerance chooses the steps"),
        (fb.Integrator, dict(tolerance=1e-6, chart="task"), "tolerance chooses the steps"),
    ],
)
def test_bad_settings(setting, options, message):
    with pytest.raises(ValueError, match=f"{setting.__name__}: {message}"):
        setting(**options)


def test_a_reference_out_of_reach_says_when():
    with pytest.raises(
        fb.UnreachableError, match="controller at t = 0.[0-9]+ s: unreachable: left leg"
    ):
        fb.simulate(
            ROBOT, fb.ComputedTorque(ROBOT, 100, 20), fb.line((0.09, 0.068), (0.3, 0.0), 2.0)
        )


def test_one_step_and_a_start_at_type_1():
    assert len(fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), TASK_1, duration=1e-10).t) == 2
    stretched = fb.igm(ROBOT, (-0.059 + 0.18 * np.cos(0.9), 0.18 * np.sin(0.9)))
    run = fb.simulate(ROBOT, None, TASK_1, duration=0.01, start=fb.dkm(stretched, (0.5, 0.1)))
    assert np.isfinite(run.q_error).all()


@pytest.mark.parametrize("gain", [-1, np.nan, (1, 2, 3)])
def test_bad_gains(gain):
    with pytest.raises(ValueError, match="kp must be one number or one per joint"):
        fb.PD(ROBOT, gain, 1)


def test_the_start_is_in_the_controllers_working_modes(robot):
    working = (1, -1)
    reference = fb.line((0.0, 0.1), (0.02, 0.12), 1.0)
    run = fb.simulate(robot, fb.ComputedTorque(robot, 100, 20, working=working), reference)
    assert fb.igm(robot, reference(0.0)[0], working).q == pytest.approx(run.q[0], abs=1e-14)
    assert np.abs(run.error).max() < 1e-3 and not run.events


def test_a_controller_in_other_working_modes_than_its_plan_is_refused(robot):
    plan = fb.plan(
        robot,
        *(fb.igm(robot, xi, (1, -1)) for xi in ((0.0, 0.1), (0.02, 0.12))),
        1.0,
        constraints=fb.Constraints(sin=0.05),
    )
    with pytest.raises(
        ValueError, match=r"plan has working modes \(1, -1\), its controller \(-1, -1\)"
    ):
        fb.simulate(robot, fb.ComputedTorque(robot, 100, 20), plan)


@pytest.mark.parametrize("seed", range(0, 90, 10))
def test_step_error_bounds_the_error(seed):
    robot, start = random_motion(seed)
    exact = fb.simulate(
        robot, duration=2.0, start=start, step=0.01, integrator=fb.Integrator(tolerance=1e-11)
    )
    for tolerance in (1e-4, 1e-8):
        run = fb.simulate(
            robot,
            duration=2.0,
            start=start,
            step=0.01,
            integrator=fb.Integrator(tolerance=tolerance),
        )
        assert 0 < np.abs(run.q - exact.q).max() <= run.step_error


@pytest.mark.parametrize("seed", [3, 14, 15])
def test_a_minute_of_free_motion_keeps_its_energy(seed):
    robot, start = random_motion(seed)
    energy = fb.simulate(robot, duration=60.0, start=start, step=0.02).energy
    assert np.abs(energy / energy[0] - 1).max() <= 1e-9


def test_crossings_are_the_motions_own_whatever_the_rows():
    """Two crossings of Type 2 within a row's step; times to 1e-12 s from rows 5 ms and 0.1 ms apart."""
    start = fb.ikm(fb.igm(ROBOT, (0.01, 0.12), working=(1, -1)), (0.02, -0.30))
    fine, coarse = (
        fb.simulate(ROBOT, duration=2.0, start=start, step=step) for step in (1e-4, 5e-3)
    )
    assert len(fine.events) >= 5 and [e[1:] for e in fine.events] == [e[1:] for e in coarse.events]
    assert [e.t for e in coarse.events] == pytest.approx([e.t for e in fine.events], abs=1e-12)
    wide = fb.simulate(
        ROBOT, duration=2.0, start=start, step=0.1
    )  # 0.604 and 0.677 s are in one step
    assert [e.t for e in wide.events[:3]] == pytest.approx(
        [e.t for e in fine.events[:3]], abs=1e-10
    )


def test_four_parallel_bars_are_refused_and_passed_by_nearby():
    robot = fb.FiveBar(0.1, 0.2, 0.15, 0.1, 0.05)  # l11 + l12 - l21 - l22 = d
    for speed in (0.5, 5.0):
        start = fb.dkm(fb.dgm(robot, (0.3, 0.2), -1), (-speed, -0.7 * speed))
        run = fb.simulate(robot, duration=10.0, start=start)
        assert np.abs(run.energy / run.energy[0] - 1).max() < 1e-9 and len(run.events) > 5
    flat = bars_rates(robot, (0.0, 0.0, 0.0, 0.0), (1.0, 1.0, 1.0, 1.0))
    with pytest.raises(
        ArithmeticError,
        match=r"a step of \d\S* s is too long .*all three are 0 all bars are parallel",
    ):
        fb.simulate(robot, duration=1.0, start=flat)


def test_a_run_proves_itself():
    free = fb.simulate(
        ROBOT, duration=10.0, start=fb.ikm(fb.igm(ROBOT, (0.01, 0.12), (1, -1)), (0.02, -0.30))
    )
    held = fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), TASK_1)
    slides = fb.simulate(
        fb.Biglide(), fb.PD(fb.Biglide(), 50, 20), fb.line((0.0, 0.2), (0.05, 0.3), 1.0)
    )
    for run in (free, held, slides):
        assert run.loop_gap.shape == (len(run.t), 2) and np.abs(run.loop_gap).max() < 1e-15
        turned = run.energy.max() + np.abs(np.diff(run.q, axis=0) * run.tau[:-1]).sum()
        assert np.abs(run.energy_error).max() <= 1e-10 * turned


@pytest.mark.deep
def test_a_plan_of_another_robot_starts_with_its_joints_in_its_assembly_mode():
    first, last = (fb.igm(fb.FiveBar(), (0.0, 0.1), working) for working in ((-1, -1), (-1, 1)))
    plan = fb.plan(fb.FiveBar(), first, last, 2.0)
    longer = fb.FiveBar(l12=0.092)
    run = fb.simulate(longer, fb.FeedForward(longer, 1.0, 0.1), plan, duration=0.01)
    np.testing.assert_allclose(run.q[0], first.q, atol=1e-12)
    np.testing.assert_allclose(
        run.xi[0], fb.dgm(longer, first.q, int(first.assembly)).xi, atol=1e-12
    )


def test_a_robot_without_inertia_is_said_to_have_none():
    start = fb.ikm(fb.igm(fb.load_robot("plotclock"), (0.0, 0.04)), (0.0, 0.0))
    with pytest.raises(ValueError, match="this robot has no inertia"):
        fb.simulate(start.pose.robot, start=start, duration=0.1)


@pytest.mark.parametrize("method", ["rk4", "dop8"])
def test_fixed_steps_with_much_viscous_friction(method):
    """From rest, where friction has taken a third of what its power at the step's end would say."""
    robot = fb.FiveBar(fv1=0.1, fv2=0.1)
    start = fb.dkm(fb.dgm(robot, (0, 0)), (0, 0))
    given = dict(duration=0.3, start=start)
    own = fb.simulate(robot, lambda *_: (0.01, 0.0), **given)
    fixed = fb.simulate(robot, lambda *_: (0.01, 0.0), integrator=fb.Integrator(method), **given)
    assert np.abs(fixed.q - own.q).max() < 1e-11
    many = fb.simulate_many(
        [fb.FiveBar(fv1=f, fv2=f) for f in (0.01, 0.1, 0.3)],
        fb.PD(fb.FiveBar(), 2.0, 0.1),
        fb.line((0.09, 0.068), (0.0, 0.1), 0.2),
        integrator=fb.Integrator(method),
        summary=fb.Summary(),
    )
    assert np.isfinite(many["rms_error_m"]).all() and many.errors == ()


def test_turns_between_wide_rows_are_kept():
    """Two proximal bars that go around several times, under a spring; energy says by how much."""
    robot = fb.FiveBar(0.1, 0.3, 0.1, 0.3, 0.02, m=0.1, fv1=0.001, fv2=0.001)
    start = fb.ikm(fb.igm(robot, (0, 0.3), (-1, -1)), (0, 0))
    spring = fb.LoadedRobot(robot, lambda t, q, q_dot, tau: tau - 0.02 * q)
    given = dict(duration=2.0, start=start, control_period=0.5)
    fine, wide = (
        fb.simulate(spring, lambda *_: (0.2, 0.2), step=step, **given) for step in (0.001, 0.5)
    )
    assert np.abs(wide.q - fine.q[::500]).max() < 1e-9 and fine.q.max() > 12
    assert np.abs(wide.energy_error).max() < 1e-10


def test_the_least_tolerance_is_one():
    assert fb.Integrator(tolerance=1e-12).tolerance == 1e-12
    with pytest.raises(ValueError, match="1e-12"):
        fb.Integrator(tolerance=0.9e-12)


def test_without_a_reference_it_begins_at_rest_in_the_labs_home():
    run = fb.simulate(ROBOT, duration=0.01)
    assert not run.q.any() and not run.q_dot.any()
    np.testing.assert_allclose(run.xi[0], (0.09, 0.06796322), atol=1e-8)


@pytest.mark.parametrize("count, end", [(5, ", 4"), (6, ", 4 ...")])
def test_robots_that_do_not_reach_the_start_are_numbered(count, end):
    small = [fb.FiveBar(0.02, 0.05, 0.02, 0.05, 0.03)] * count
    line = fb.line((0.09, 0.068), (0.0, 0.1), 0.1)
    words = f"{count} of {count} robots do not reach .*number 0, 1, 2, 3{end}$"
    with pytest.raises(ValueError, match=words):
        fb.simulate_many(small, fb.ComputedTorque(small[0], 100, 20), line)
