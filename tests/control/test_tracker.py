"""The model-predictive tracker in closed loop: what it keeps, what it falls back to, and what it is asked."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.control.qp import Status
from fivebar.control.tracker import Tracker
from fivebar.models.four_joints import bars_rates
from fivebar.study.control_cases import CASES, case
from tests.benchmarks import qp_solvers
from tests.conftest import UNEQUAL

ROBOT = fb.FiveBar()
TASK_1 = fb.line((0.09, 0.06796322), (0.0, 0.1), 2.0)


def rms(run):
    return float(np.sqrt(np.mean(np.sum(run.error**2, axis=1))))


def largest(run):
    return float(np.linalg.norm(run.error, axis=1).max())


BETTER = {"task-1": 5, "torque-limit": 3, "mass": 10, "delay": 10, "encoder": 1.5, "crossing": 20}


@pytest.mark.every(6)
@pytest.mark.parametrize("name", CASES)
def test_case_is_tracked_better_than_by_computed_torque(name):
    chosen = case(name)
    runs = {controller: chosen.simulate(controller) for controller in ("ctc", "ctc-stiff", "mpc")}
    run = runs["mpc"]
    assert not run.log.status.any()
    assert rms(run) * BETTER[name] < min(rms(runs["ctc"]), rms(runs["ctc-stiff"]))
    if limit := chosen.torque_limit:
        assert np.abs(run.control.commanded).max() <= limit
    if name == "crossing":
        assert largest(run) < 5e-6 and [int(event.type) for event in run.events] == [2]


def estimated(tracker):
    a = tracker.estimator.state.tolist()
    return bars_rates(tracker.robot, tuple(a[:4]), tuple(a[4:])).pose.xi


def test_crossing_off_the_plan_stays_within_a_tenth_of_a_millimetre():
    """The degree-8 polynomial comes within sin q22 = 0.06 of Type 1 where it crosses, 20 times faster than the plan."""
    rest, singular = {1: (0, 0), 2: (0, 0)}, (0.0525327138758270, 0.00430328475849708)
    midway = {0: singular, 1: (-0.0253611967131164, -0.0430907147919202), 2: (0, 0)}
    reference = fb.polynomial(
        [(0, {0: (0.09, 0.06796322), **rest}), (2, midway), (4, {0: (0.05, 0.0), **rest})]
    )
    tracker, estimates = Tracker(ROBOT, constraints=fb.Constraints(torque=0.1)), []

    def controller(t, q, q_dot, reference):
        tau = tracker(t, q, q_dot, reference)
        estimates.append(estimated(tracker))
        return tau

    run = fb.simulate(ROBOT, controller, reference, torque_limit=0.1)
    assert largest(run) < 1e-4 and not tracker.log.status.any()
    assert [(round(event.t, 1), int(event.type)) for event in run.events] == [(2.0, 2)]
    # The end-effector is known throughout, though at Type 2 the joints do not tell it.
    assert np.linalg.norm(np.array(estimates) - run.xi[:-1:10], axis=1).max() < 1e-6


def test_constant_disturbance_leaves_no_offset_at_rest():
    tracker, offset = (
        Tracker(ROBOT, constraints=fb.Constraints(torque=0.05)),
        np.array([0.003, -0.002]),
    )
    run = fb.simulate(fb.FiveBar(m=0.6), lambda *a: tracker(*a) + offset, TASK_1, duration=3.0)
    assert np.linalg.norm(run.error[-1]) < 1e-9
    np.testing.assert_allclose(tracker.log.disturbance[-1], offset, atol=1e-7)
    held = fb.simulate(
        ROBOT, lambda *a: fb.ComputedTorque(ROBOT, 100, 20)(*a) + offset, TASK_1, duration=3.0
    )
    assert np.linalg.norm(held.error[-1]) > 1e-4  # which computed torque leaves


@pytest.mark.parametrize(
    "reference", [TASK_1, fb.line((0.0, 0.1), (0.09, 0.06796322), 2.0)], ids=["there", "back"]
)
def test_limits_of_torque_and_speed_are_kept(reference):
    tracker = Tracker(ROBOT, constraints=fb.Constraints(torque=0.006, joint_speed=1.0))
    run = fb.simulate(ROBOT, tracker, reference, duration=2.5)
    assert np.abs(run.control.commanded).max() <= 0.006
    assert 0.99 < np.abs(run.q_dot).max() < 1.001
    assert not tracker.log.status.any() and tracker.log.iterations.max() > 10


@pytest.mark.deep
def test_speed_limit_across_type_2():
    chosen = case("crossing")
    asked = np.abs(fb.simulate(ROBOT, Tracker(ROBOT), chosen.reference).q_dot).max()
    tracker = Tracker(ROBOT, constraints=fb.Constraints(torque=0.05, joint_speed=0.8 * asked))
    run = chosen.simulate(tracker)
    assert (
        np.abs(run.q_dot).max() < 0.8 * asked * 1.001
        and not tracker.log.status.any()
        and len(run.events) == 1
    )


@pytest.mark.every(2)
def test_one_millisecond_and_other_robots(robot):
    reference = fb.line((0.05, 0.09), (0.03, 0.11), 0.4)
    for period, better in ((0.01, 10), (0.001, 2)):
        runs = [
            fb.simulate(robot, controller, reference, control_period=period)
            for controller in (Tracker(robot, period=period), fb.ComputedTorque(robot, 100, 20))
        ]
        assert rms(runs[0]) < rms(runs[1]) / better


@pytest.mark.parametrize("working", [(1, 1), (1, -1), (-1, 1)])
def test_other_modes(working):
    reference = fb.line((0.02, 0.1), (-0.03, 0.12), 1.0)
    start = fb.ikm(fb.igm(ROBOT, (0.02, 0.1), working), (0.0, 0.0))
    tracker = Tracker(ROBOT, assembly=int(start.pose.assembly))
    assert (
        largest(fb.simulate(ROBOT, tracker, reference, start=start)) < 2e-5
        and not tracker.log.status.any()
    )


def test_start_in_motion_and_a_stop_that_is_no_motion():
    """A circle ends at full speed: its last second is not trackable, and no step fails for it."""
    for robot in (ROBOT, UNEQUAL):
        circle, tracker = fb.circle((0.0, 0.1), 0.03, 1.0), Tracker(robot)
        run = fb.simulate(robot, tracker, circle)
        assert not tracker.log.status.any()
        assert np.linalg.norm(run.error[:600], axis=1).max() < 2e-4


def test_a_new_simulation_starts_afresh():
    tracker = Tracker(ROBOT, delay=1)
    runs = [
        fb.simulate(ROBOT, tracker, TASK_1, duration=0.3, measurement=fb.Measurement(delay=1))
        for _ in range(2)
    ]
    np.testing.assert_array_equal(runs[0].tau, runs[1].tau)
    assert len(tracker.log.t) == 30
    tracker.reset()
    assert len(tracker.log.t) == 0 and tracker.log.disturbance.shape == (0, 2)


def test_a_tracker_that_counts_on_another_delay_is_named_where_it_runs_away():
    heavy = fb.FiveBar(gravity=(0.0, -9.81))
    late = fb.Measurement(delay=1)
    words = "singularities: the controller counts on a delay of 0 periods, the measurement has 1"
    with pytest.warns(RuntimeWarning, match=words):
        fb.simulate(heavy, Tracker(heavy), TASK_1, measurement=late)
    run = fb.simulate(heavy, Tracker(heavy, delay=1), TASK_1, measurement=late)
    assert np.linalg.norm(run.error, axis=1).max() < 2e-3


def failing(tracker, when):
    """Make the tracker's QP fail in its steps number `when`."""
    solve, count = tracker.qp, iter(range(10**6))

    def hook(*arguments):
        return (None, 7, Status.QP_FAILED) if next(count) in when else solve(*arguments)

    tracker.qp = hook


def test_fallback_is_clipped_computed_torque_and_reported():
    tracker, limit, when = (
        Tracker(ROBOT, constraints=fb.Constraints(torque=0.004)),
        0.004,
        range(20, 60),
    )
    failing(tracker, when)
    run = fb.simulate(ROBOT, tracker, TASK_1, duration=1.0, torque_limit=limit)
    status = tracker.log.status
    assert (
        (status[20:60] == Status.QP_FAILED).all()
        and not status[:20].any()
        and not status[60:].any()
    )
    assert (tracker.log.iterations[20:60] == 7).all()
    computed = fb.ComputedTorque(ROBOT, 100, 20)
    for k in when:
        asked = computed(run.control.t[k], run.control.q[k], run.control.q_dot[k], TASK_1)
        np.testing.assert_allclose(
            run.control.commanded[k], np.clip(asked, -limit, limit), atol=1e-12
        )


@pytest.mark.deep
def test_fallback_is_pd_near_type_2_and_knows_the_mode_behind_it():
    chosen = case("crossing")
    tracker = Tracker(ROBOT, constraints=fb.Constraints(torque=0.05))
    failing(tracker, [*range(295, 310), *range(380, 390)])
    run = chosen.simulate(tracker)
    assert (tracker.log.status[295:310] == Status.QP_FAILED).all() and not tracker.log.status[
        310:380
    ].any()
    controllers = {302: fb.PD(ROBOT, 100 * tracker.inertia, 20 * tracker.inertia)}
    controllers |= dict.fromkeys(range(380, 390), fb.ComputedTorque(ROBOT, 100, 20, assembly=1))
    for k, controller in controllers.items():
        asked = controller(
            run.control.t[k], run.control.q[k], run.control.q_dot[k], chosen.reference
        )
        np.testing.assert_allclose(run.control.commanded[k], np.clip(asked, -0.05, 0.05), atol=1e-9)
    assert np.abs(run.control.commanded).max() <= 0.05 and np.linalg.norm(run.error[-1]) < 1e-6


def test_reference_out_of_reach_is_approached_with_bounded_torque():
    reference = fb.line((0.02, 0.1), (0.08, 0.12), 1.0)  # the left leg cannot reach its end
    tracker = Tracker(ROBOT, constraints=fb.Constraints(torque=0.05))
    run = fb.simulate(ROBOT, tracker, reference, duration=1.2)
    assert np.isfinite(run.tau).all() and np.abs(run.control.commanded).max() <= 0.05
    assert np.linalg.norm(run.error[-1]) < 0.01


def test_a_jump_of_the_measurement_is_taken_for_a_new_motion():
    tracker, home = Tracker(ROBOT, constraints=fb.Constraints(torque=0.05)), np.zeros(2)
    tracker(0.0, home, home, TASK_1)
    tracker(0.01, home, home, TASK_1)
    elsewhere = fb.igm(ROBOT, (-0.05, 0.12))
    tracker(0.02, elsewhere.q, home, TASK_1)
    np.testing.assert_allclose(estimated(tracker), (-0.05, 0.12), atol=1e-9)


def test_full_turns_of_the_measured_angles_do_not_matter():
    torques = []
    for turns in (0, 1):
        tracker = Tracker(ROBOT)
        tracker(0.0, np.zeros(2), np.zeros(2), TASK_1)
        angles = np.array([0.0, -2 * np.pi * turns])
        torques.append([tracker(0.01 * k, angles, np.zeros(2), TASK_1) for k in (1, 2, 3)])
    np.testing.assert_allclose(torques[1], torques[0], atol=1e-12)


def test_warm_start_is_the_last_plan_shifted():
    tracker, plans = Tracker(ROBOT, seconds=0.2), []
    solve = tracker.qp
    tracker.qp = lambda *arguments: plans.append(solve(*arguments)) or plans[-1]
    tracker(0.0, np.zeros(2), np.zeros(2), TASK_1)
    np.testing.assert_array_equal(tracker.guess[:-2], plans[0][0][2:])
    np.testing.assert_array_equal(tracker.guess[-2:], plans[0][0][-2:])


def test_uncertainty_at_first_is_the_measurement_s_on_the_closed_loop():
    """Of the end-effector by the joints' Jacobian, an independent way; and none across the closure."""
    tracker = Tracker(ROBOT)
    tracker(0.0, np.zeros(2), np.zeros(2), TASK_1)
    known, rates = tracker.estimator, fb.dkm(fb.dgm(ROBOT, (0.0, 0.0)), (0.0, 0.0))
    C = tracker.model.look(known.state)[1].reshape(4, 8)
    J = np.linalg.solve(rates.pose.A, rates.pose.B)
    expected = np.kron(np.diag([1e-12, 1e-8]), J @ J.T)
    found = C @ known.covariance[:8, :8] @ C.T
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * expected.max())
    assert np.linalg.matrix_rank(known.covariance[:8, :8], tol=1e-20) == 4


def test_uncertainty_stays_on_the_closed_loop():
    """After 1,000 samples the filter is as sure as after one that both legs end in one point."""
    reference, period = fb.circle((0.0, 0.1), 0.03, 1.0), 0.005
    known, tau = Tracker(ROBOT, period=period).estimator, np.zeros(2)
    for k in range(1001):
        xi, xi_dot, xi_ddot = reference(k * period)
        rates = fb.ikm(fb.igm(ROBOT, xi), xi_dot)
        if k == 0:
            known.locate(rates.pose.q, rates.q_dot)
        else:
            assert known.follow((k - 1) * period, tau, rates.pose.q, rates.q_dot)
        tau = fb.inverse_dynamics(fb.ikm2(rates, xi_ddot))

    def gap(q1, phi1, q2, phi2):
        left = -0.059 + 0.09 * np.exp(1j * q1) + 0.09 * np.exp(1j * phi1)
        return left - 0.059 - 0.09 * np.exp(1j * q2) - 0.09 * np.exp(1j * phi2)

    steps = 1e-6 * np.eye(4)
    slope = np.array([gap(*known.state[:4] + e) - gap(*known.state[:4] - e) for e in steps]) / 2e-6
    variance = (slope @ known.covariance[:4, :4] @ slope.conj()).real
    assert abs(variance) < (1e-7) ** 2


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"horizon": 1}, "horizon must be a whole number >= 2"),
        ({"horizon": 20.0}, "horizon must be a whole number"),
        ({"delay": -1}, "delay must be a whole number >= 0"),
        ({"period": 0.0}, "period must be finite and > 0"),
        ({"seconds": 0.1}, "seconds = 0.1 is less than horizon = 20 periods"),
        ({"constraints": fb.Constraints(torque=(1.0, 2.0))}, "torque must be the same for both"),
        ({"constraints": fb.Constraints(sin=0.1)}, "Tracker: the constraint sin is not kept"),
        ({"encoder_resolution": 0}, "encoder_resolution must be finite and > 0"),
        ({"position": 0.0}, "position must be finite and > 0"),
        ({"acceleration": np.nan}, "acceleration must be finite"),
        ({"torque_rate": "much"}, "torque_rate"),
        ({"assembly": 0}, "assembly must be"),
    ],
)
def test_options_that_make_no_sense(options, message):
    with pytest.raises(ValueError, match=message):
        Tracker(ROBOT, **options)


def test_wrong_period_and_massless_robot():
    tracker = Tracker(ROBOT, period=0.01)
    with pytest.raises(
        ValueError, match="made for a period of 0.01 s was called again after 0.001 s"
    ):
        fb.simulate(ROBOT, tracker, TASK_1, control_period=0.001)
    with pytest.raises(ValueError, match="m must be finite and > 0"):
        Tracker(fb.FiveBar(m=0.0))


@pytest.mark.deep
def test_compiled_is_the_same(compiler):
    runs = [
        fb.simulate(ROBOT, Tracker(ROBOT, jit=jit), TASK_1, duration=0.5) for jit in (False, True)
    ]
    np.testing.assert_allclose(runs[0].tau, runs[1].tau, atol=1e-9)


@pytest.mark.deep
def test_benchmark_runs(compiler, capfd):
    qp_solvers.main(quick=True)
    rows = [
        line.split()
        for line in capfd.readouterr().out.splitlines()
        if line.startswith("daqp condensed")
    ]
    assert len(rows) == 3 and all(
        row[5:7] == ["0", "0"] for row in rows
    )  # none failed, none silently
