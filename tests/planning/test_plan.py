"""Plans rechecked with the models on fine grids, by simulation, by exact scaling laws and against finer meshes."""

import time

import numpy as np
import pytest

import fivebar as fb
from fivebar.planning import collocation, plans
from fivebar.planning import program as transcription
from fivebar.planning.guess import first_guess
from fivebar.planning.plan import plan
from fivebar.singularities.margins import Singularity

from ..conftest import UNEQUAL
from .conftest import HOME, IN_MODES, ROBOT, TASK_1, TASK_2, fine, poses


def margins(motion):
    """(sin q12, sin q22, det A) along a plan, by the public models."""
    pose = fb.igm(motion.robot, motion(fine(motion))[0], motion.problem.working)
    return np.stack([*pose.sines, pose.det_A], axis=-1)


def check_motion(motion, tolerance=1.1e-3):
    """The planned motion is what the bar-force model makes of its torques, at times that are no nodes."""
    t = fine(motion)
    xi, xi_dot, xi_ddot = motion(t)
    rates = fb.ikm(fb.igm(motion.robot, xi, motion.problem.working), xi_dot)
    made = fb.forward_dynamics(rates, motion.torques(t)).xi_ddot
    assert np.abs(made - xi_ddot).max() <= 2 * tolerance * np.linalg.norm(xi_ddot, axis=1).max()
    assert motion.status == "Solve_Succeeded" and motion.error <= tolerance
    for name, value in motion.violations.items():
        assert value <= tolerance * motion.problem.unit(name), name
    numeric = (motion(t[1:-1] + 1e-6)[0] - motion(t[1:-1] - 1e-6)[0]) / 2e-6
    np.testing.assert_allclose(numeric, xi_dot[1:-1], atol=1e-6)
    conditions = motion.problem.stops[0][0], motion.problem.stops[-1][0]
    for at, given in zip((0, -1), conditions):
        for order, value in given.items():
            np.testing.assert_allclose(motion(t)[order][at], value, atol=1e-7)


def test_task_2_crosses_with_finite_torque(crossing):
    check_motion(crossing)
    assert np.abs(crossing.torques(fine(crossing))).max() <= 0.0026  # 0.01 N m was asked for
    assert np.abs(crossing.bar_forces(fine(crossing))).max() <= 1.0
    modes = np.sign(margins(crossing))
    assert modes[0].tolist() == [1, 1, 1] and modes[-1].tolist() == [1, 1, -1]
    assert np.count_nonzero(np.diff(modes[:, 2])) == 1


def test_task_2_is_planned_within_a_second():
    began = time.process_time()  # of this process: other load does not count
    found = plan(ROBOT, HOME, TASK_2, 4.0)
    assert time.process_time() - began <= 1.0
    assert found.iterations <= 25 and len(found.meshes) <= 3


def test_criterion_comes_out_at_the_crossing(crossing):
    t = np.linspace(2.9, 3.1, 20001)
    acc = crossing.accelerations(t)
    at = int(np.argmin(np.abs(acc.rates.pose.det_A)))
    (x, y), xi_ddot = [column[at] for column in acc.rates.pose.u2[0]], acc.xi_ddot
    assert (
        abs(-y * xi_ddot[at, 0] + x * xi_ddot[at, 1])
        <= 1e-3 * np.linalg.norm(xi_ddot, axis=1).max()
    )


def test_torques_alone_make_the_motion_through_the_singularity(crossing):
    step = 0.001
    run = fb.simulate(
        ROBOT,
        lambda t, *_: crossing.torques(t + step / 2),
        crossing,
        control_period=step,
        step=step,
    )
    assert np.linalg.norm(run.error, axis=1).max() <= 1e-7
    assert [event.type for event in run.events] == [Singularity.PARALLEL]


def test_tracking_through_the_singularity(crossing):
    controller = fb.FeedForward(ROBOT, 0.5, 0.05)
    heavier = fb.FiveBar(m=0.51, zz1=0.00204, zz2=0.00204)
    for robot, bound in ((ROBOT, 1e-6), (heavier, 1e-4)):
        run = fb.simulate(robot, controller, crossing, control_period=0.01)
        assert np.linalg.norm(run.error, axis=1).max() <= bound
        assert len(run.events) == 1


@pytest.mark.parametrize("degree", [3, 4])
def test_defects_between_nodes_shrink_with_their_order(degree):
    start, goal = ({0: xi, 1: (0, 0)} for xi in (HOME, TASK_1))
    weights = {"effort": 1.0, "time": 0.0, "jerk": 0.0}
    stops = (start, 0.0), (goal, 2.0)
    problem = plans.Problem(
        ROBOT, stops, (-1, -1), weights, fb.Constraints(sin=0.05), collocation.Scheme(degree)
    )
    guess, durations = first_guess(problem)
    errors = []
    for n in (6, 12, 24):
        mesh = [np.linspace(0, 1, n + 1)]
        interval = transcription.Interval(problem, mesh, durations, guess)
        found = transcription.solve(interval, mesh, durations, guess, 30)
        errors.append(plans.Plan(problem, found.pieces, found.objective, found.status).error)
    measured = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.abs(measured - degree).max() <= 0.35


@pytest.mark.every(2)
@pytest.mark.parametrize(
    "options", [dict(degree=3), dict(degree=2, tolerance=5e-3), dict(degree=5)]
)
def test_schemes_agree(options, crossing):
    found = plan(ROBOT, HOME, TASK_2, 4.0, collocation=fb.Collocation(**options))
    check_motion(found, options.get("tolerance", 1e-3) * 1.1)
    assert abs(found.objective / crossing.objective - 1) <= 1e-4
    t = fine(found)
    squares = np.sum(found.torques(t) ** 2, axis=1)
    assert abs(np.trapezoid(squares, t) / found.objective - 1) <= 1e-3


@pytest.mark.deep
@pytest.mark.every(2)
@pytest.mark.parametrize("degree", [2, 3])
def test_minimum_time_on_a_mesh_four_times_finer(degree):
    coarse, finer = (
        plan(
            ROBOT,
            HOME,
            TASK_1,
            objective="time",
            constraints=fb.Constraints(torque=0.02),
            collocation=fb.Collocation(degree=degree, intervals=n),
        )
        for n in (20, 80)
    )
    check_motion(coarse)
    assert abs(coarse.duration / finer.duration - 1) <= 2e-4  # 5e-3 was asked for
    assert finer.duration == pytest.approx(finer.objective, rel=1e-12)


def test_minimum_time_is_bang_bang(fastest):
    check_motion(fastest)
    tau = np.abs(fastest.torques(fine(fastest)))
    assert tau.max() <= 0.02 * (1 + 1e-6)  # between nodes too
    assert np.mean(tau.max(axis=1) >= 0.01999) >= 0.98 and fastest.saturated >= 0.98
    assert np.mean((tau >= 0.01999).all(axis=1)) >= 0.8


def test_time_scales_as_the_root_of_the_torque(fastest):
    quarter = plan(
        ROBOT, HOME, TASK_1, objective="time", constraints=fb.Constraints(torque=(0.08, 0.08))
    )
    assert quarter.duration == pytest.approx(fastest.duration / 2, rel=2e-4)


@pytest.mark.every(3)
@pytest.mark.parametrize(
    "limit, measured",
    [
        (dict(joint_speed=1.5), lambda p: np.abs(p.accelerations(fine(p)).rates.q_dot).max()),
        (dict(acceleration=0.25), lambda p: np.linalg.norm(p(fine(p))[2], axis=1).max()),
        (
            dict(region=((-0.001, 0.0675), (0.091, 0.0675), (0.091, 0.1005), (-0.001, 0.1005))),
            lambda p: -p(fine(p))[0][:, 1].min(),
        ),
    ],
)
def test_limits_hold_between_nodes_and_bind(limit, measured, fastest):
    found = plan(
        ROBOT,
        HOME,
        TASK_1,
        objective="time",
        constraints=fb.Constraints(torque=0.02, **limit),
        collocation=fb.Collocation(tolerance=2e-3),
    )
    check_motion(found, 2.2e-3)
    bound = {"joint_speed": 1.5, "acceleration": 0.25, "region": -0.0675}[next(iter(limit))]
    assert measured(fastest) > bound + 1e-3
    assert measured(found) == pytest.approx(bound, rel=2e-3)
    assert found.duration > fastest.duration


@pytest.mark.deep
def test_mesh_is_refined_for_limits_alone(monkeypatch):
    monkeypatch.setattr(
        plans.Plan, "_relative_defects", property(lambda self: np.zeros(len(self.pieces.xi)))
    )
    limits = fb.Constraints(torque=0.02, joint_speed=1.3)
    coarse, found = (
        plan(
            ROBOT,
            HOME,
            TASK_1,
            objective="time",
            constraints=limits,
            collocation=fb.Collocation(tolerance=tolerance, intervals=5, degree=5),
        )
        for tolerance in (0.5, 1e-3)
    )
    assert coarse.violations["joint_speed"] > 3e-3
    assert found.violations["joint_speed"] <= 1.3e-3 and len(found.meshes) > 1


@pytest.mark.deep
def test_distance_to_singularities_is_kept():
    ends = poses(ROBOT, ((0.0664, -0.1119), (0.0306, 0.1181)), (1, -1))
    options = dict(collocation=fb.Collocation(tolerance=2e-3))
    free = plan(ROBOT, *ends, 2.0, constraints=IN_MODES, **options)
    assert set(np.sign(margins(free)[:, 2])) == {-1.0, 1.0}  # the cheapest way crosses twice
    kept = plan(ROBOT, *ends, 2.0, constraints=fb.Constraints(sin=0.05, det_A=0.4), **options)
    check_motion(kept, 2.2e-3)
    assert np.abs(margins(kept)[:, 2]).min() == pytest.approx(0.4, abs=2.5e-3)
    wide = plan(ROBOT, *ends, 2.0, constraints=fb.Constraints(sin=0.45), **options)
    assert np.abs(margins(free)[:, :2]).min() < 0.4
    assert np.abs(margins(wide)[:, :2]).min() == pytest.approx(0.45, abs=2.5e-3)


def test_via_points():
    found = plan(
        ROBOT, HOME, TASK_1, 2.0, via=[(0.7, {0: (0.07, 0.1), 1: (0, 0.01)}), (None, (0.05, 0.12))]
    )
    check_motion(found)
    xi, xi_dot, _ = found(0.7)
    np.testing.assert_allclose(xi, (0.07, 0.1), atol=1e-8)
    np.testing.assert_allclose(xi_dot, (0, 0.01), atol=1e-8)
    after = np.linalg.norm(found(fine(found))[0] - (0.05, 0.12), axis=1)
    assert after.min() <= 1e-4 and fine(found)[after.argmin()] > 0.7
    assert found.duration == pytest.approx(2.0, rel=1e-12)
    free = plan(
        ROBOT,
        HOME,
        TASK_1,
        via=[(None, (0.05, 0.12))],
        objective="time",
        constraints=fb.Constraints(torque=0.02),
        collocation=fb.Collocation(tolerance=5e-3),
    )
    assert np.linalg.norm(free(fine(free))[0] - (0.05, 0.12), axis=1).min() <= 2e-4


def test_jerk_and_a_mix_with_free_time():
    smooth = plan(ROBOT, HOME, TASK_1, 2.0, objective="jerk")
    s = fine(smooth)[:, None] / 2
    blend = (
        2.5 * s**2 - 2.5 * s**4 + s**5
    )  # sixth derivative 0, and no jerk at the ends, whose accelerations are free
    np.testing.assert_allclose(
        smooth(fine(smooth))[0], HOME + blend * np.subtract(TASK_1, HOME), atol=1e-6
    )
    still = {1: (0, 0), 2: (0, 0)}
    quintic = plan(ROBOT, {0: HOME, **still}, {0: TASK_1, **still}, 2.0, objective="jerk")
    np.testing.assert_allclose(
        quintic(fine(quintic))[0], fb.line(HOME, TASK_1, 2.0)(fine(quintic))[0], atol=1e-6
    )
    mixed = plan(ROBOT, HOME, TASK_1, objective={"time": 1.0, "effort": 1e4, "jerk": 1e-4})
    check_motion(mixed)
    a, t = mixed(fine(mixed))[2], fine(mixed)
    jerk = np.trapezoid(np.sum(np.gradient(a, t, axis=0) ** 2, axis=1), t)
    effort = np.trapezoid(np.sum(mixed.torques(t) ** 2, axis=1), t)
    assert mixed.duration + 1e4 * effort + 1e-4 * jerk == pytest.approx(mixed.objective, rel=2e-3)


@pytest.mark.every(3)
@pytest.mark.parametrize(
    "ends, working",
    [
        (((0.05, 0.15), (-0.05, 0.1)), (-1, -1)),
        (((-0.0482, -0.0693), (0.0282, 0.0612)), (-1, 1)),
        (((0.1452, 0.1525), (0.0043, -0.0623)), (1, -1)),  # round the hole at a base joint
    ],
)
def test_unequal_robot(ends, working):
    found = plan(UNEQUAL, *poses(UNEQUAL, ends, working), 2.0, constraints=IN_MODES)
    check_motion(found)
    t = np.linspace(0, 2, 7)
    regular = np.abs(found.accelerations(t).rates.pose.det_A) > 0.2
    exact = fb.inverse_dynamics(found.accelerations(t[regular]))
    np.testing.assert_allclose(
        found.torques(t[regular]), exact, atol=0.02 * np.abs(found.torques(t)).max()
    )


@pytest.mark.deep
def test_random_problems():
    """All of a sample are planned, round holes and along loci too."""
    rng, solved = np.random.default_rng(11), 0
    while solved < 12:
        robot, working = (ROBOT, UNEQUAL)[rng.integers(2)], tuple(map(int, rng.choice([-1, 1], 2)))
        ends = rng.uniform(-0.2, 0.2, (2, 2))
        pose = fb.igm(robot, ends, working, unreachable="nan")
        far = (np.abs([*pose.sines, pose.det_A]) > 0.2).all()
        if not far or (solved % 2 and pose.det_A[0] * pose.det_A[1] < 0):
            continue
        limits = dict(det_A=0.15) if solved % 2 else {}
        limits |= {} if solved % 3 else dict(torque=0.03)
        options = dict(duration=2.0) if solved % 3 else dict(objective="time")
        constraints = fb.Constraints(sin=0.05, **limits)
        check_motion(plan(robot, *poses(robot, ends, working), constraints=constraints, **options))
        solved += 1
