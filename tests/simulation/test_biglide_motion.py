"""The biglide in motion: simulation, control, plans and the tracker, against an integration that knows none of it."""

import json

import casadi
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fivebar as fb
from fivebar import cli
from fivebar.control.laws import PD
from tests.models.test_biglide import LAB, UNEQUAL

MASSES = {robot: np.array([robot.mf1, robot.mf2, robot.m, robot.m]) for robot in (LAB, UNEQUAL)}


def constrained(robot, z, tau):
    """(q1, q2, x, y)'' and the multipliers of |xi - F_i|^2 = l_i^2: Lagrange's equations as one 6 x 6 system."""
    (q1, q2, x, y), v = z[:4], z[4:]
    r = np.array([[x + robot.d / 2, y - q1], [x - robot.d / 2, y - q2]])
    G = np.array([[-r[0, 1], 0, *r[0]], [0, -r[1, 1], *r[1]]])
    r_dot = np.array([[v[2], v[3] - v[0]], [v[2], v[3] - v[1]]])
    K = np.block([[np.diag(MASSES[robot]), -G.T], [G, np.zeros((2, 2))]])
    return np.linalg.solve(K, np.concatenate([tau, [0, 0], -(r_dot**2).sum(axis=1)]))


def integrated(robot, z, tau, duration):
    found = solve_ivp(
        lambda _, z: np.concatenate([z[4:], constrained(robot, z, tau)[:4]]),
        (0, duration),
        z,
        method="DOP853",
        rtol=1e-12,
        atol=1e-14,
    )
    return found.y[:, -1]


def computed_force(robot, z, target, target_dot, target_ddot, kp, kd):
    """Forces that give the feet the accelerations of computed torque: from the constraints' geometry alone."""
    wanted = target_ddot + kd * (target_dot - z[4:6]) + kp * (target - z[:2])
    r = np.array([[z[2] + robot.d / 2, z[3] - z[0]], [z[2] - robot.d / 2, z[3] - z[1]]])
    r_dot = np.array([[z[6], z[7] - z[4]], [z[6], z[7] - z[5]]])
    xi_ddot = np.linalg.solve(r, r[:, 1] * wanted - (r_dot**2).sum(axis=1))
    mu = np.linalg.solve(r.T, robot.m * xi_ddot)
    return MASSES[robot][:2] * wanted + r[:, 1] * mu


def feet(robot, xi, xi_dot, xi_ddot):
    """Positions, rates and accelerations of the feet below an end-effector, by the chain rule."""
    q = []
    for side, bar in ((-1, robot.distal[0]), (1, robot.distal[1])):
        u, du, ddu = xi[0] - side * robot.d / 2, xi_dot[0], xi_ddot[0]
        s = np.sqrt(bar**2 - u**2)
        ds = -u * du / s
        q.append((xi[1] - s, xi_dot[1] - ds, xi_ddot[1] + (du**2 + u * ddu + ds**2) / s))
    return np.array(q).T


@pytest.mark.parametrize("robot", [LAB, UNEQUAL], ids=["lab", "unequal"])
def test_computed_torque_agrees_with_a_constrained_integration(robot):
    reference = fb.line((0.0, 0.2), (0.06, 0.35), 1.0)
    run = fb.simulate(robot, fb.ComputedTorque(robot, 100, 20), reference, step=1e-3)
    start = fb.igm(robot, (0.0, 0.2))
    z = np.concatenate([start.q, start.xi, np.zeros(4)])
    for k in range(100):
        tau = computed_force(robot, z, *feet(robot, *reference(0.01 * k)), 100, 20)
        np.testing.assert_allclose(run.control.applied[k], tau, rtol=0, atol=1e-8)
        z = integrated(robot, z, tau, 0.01)
        np.testing.assert_allclose(
            np.concatenate([run.q[10 * k + 10], run.xi[10 * k + 10]]), z[:4], rtol=0, atol=1e-8
        )
    assert np.abs(run.error).max() < 2e-4 and run.events == ()
    # The guides push across only: the forces alone change the momentum along y.
    momentum = run.q_dot @ MASSES[robot][:2] + robot.m * np.gradient(run.xi[:, 1], run.t)
    pushed = np.concatenate([[0], np.cumsum(run.tau[:-1].sum(axis=1)) * 1e-3])
    assert np.abs(momentum - pushed)[5:-5].max() < 1e-3 * np.abs(pushed).max()


@pytest.mark.every(2)
@pytest.mark.parametrize("robot", [LAB, UNEQUAL], ids=["lab", "unequal"])
def test_free_motion_goes_on_through_every_singularity(robot):
    start = fb.ikm(fb.igm(robot, (0.075, 0.2), (-1, 1)), (-1.2, 0.1))
    run = fb.simulate(robot, duration=2.0, start=start, integrator=fb.Integrator(method="dop8"))
    kinds = [int(event.type) for event in run.events]
    assert kinds.count(2) >= 2 and kinds.count(1) >= 2
    assert {event.margin for event in run.events} == {"sin phi1", "sin phi2", "det A"}
    for event in run.events:  # exactly the mode that it names has changed
        k = ("sin phi1", "sin phi2", "det A").index(event.margin)
        assert [a != b for a, b in zip(event.before, event.after)] == [i == k for i in range(3)]
    assert np.ptp(run.energy) < 1e-10 * run.energy[0]
    z = np.concatenate([start.pose.q, start.pose.xi, start.q_dot, start.xi_dot])
    z = integrated(robot, z, np.zeros(2), 2.0)
    np.testing.assert_allclose(np.concatenate([run.q[-1], run.xi[-1]]), z[:4], rtol=0, atol=1e-9)
    with pytest.raises(fb.SingularityError, match=r"joint chart \(det A = "):
        fb.simulate(robot, duration=2.0, start=start, integrator=fb.Integrator(chart="joint"))
    with pytest.raises(fb.SingularityError, match=r"task chart \(sin phi"):
        fb.simulate(robot, duration=2.0, start=start, integrator=fb.Integrator(chart="task"))


def test_each_chart_is_the_same_motion():
    start = fb.ikm(fb.igm(LAB, (0.01, 0.2)), (0.1, 0.3))
    runs = [fb.simulate(LAB, duration=0.3, start=start)]
    runs += [
        fb.simulate(
            LAB, duration=0.3, start=start, integrator=fb.Integrator(chart=each, method="dop8")
        )
        for each in ("auto", "joint", "task")
    ]
    for run in runs[1:]:
        np.testing.assert_allclose(run.xi, runs[0].xi, rtol=0, atol=1e-11)


def test_joints_that_slide_do_not_wrap():
    far = np.array([10.0, -7.0])
    assert PD(LAB, 2.0, 0.0).law(
        np.zeros(2), np.zeros(2), far, np.zeros(2), np.zeros(2)
    ) == pytest.approx(2 * far)
    q, law = casadi.SX.sym("q", 2), fb.ComputedTorque(LAB, 3.0, 0.0)
    M, c = fb.dynamic_model(fb.dkm(fb.dgm(LAB, (0.0, 0.0)), (0.0, 0.0)))
    force = law.law(np.zeros(2), np.zeros(2), np.array([5.0, 5.0]), np.zeros(2), np.zeros(2))
    assert force == pytest.approx(M @ [15.0, 15.0] + c)
    symbolic = casadi.Function(
        "f", [q], [law.law(q, casadi.DM([0, 0]), casadi.DM([5, 5]), casadi.DM([0, 0]), 0)]
    )
    assert symbolic([0.0, 0.0]).full().ravel() == pytest.approx(force)
    # A reference 8 m further on: from standstill, not from the next of many turns.
    reference = fb.line((0.0, 8.2), (0.0, 8.2001), 1.0)
    start = fb.dkm(fb.dgm(LAB, (0.0, 0.0)), (0.0, 0.0))
    run = fb.simulate(LAB, fb.ComputedTorque(LAB, 100, 20), reference, start=start, duration=1.5)
    assert run.q_error[0] == pytest.approx([-8.0, -8.0], abs=1e-3)
    assert np.abs(run.q_error[-1]).max() < 1e-3
    assert np.abs(np.diff(run.q, axis=0)).max() < 0.1


def test_compiled_loops_are_the_same():
    reference = fb.line((0.0, 0.2), (0.05, 3.9), 1.0)
    pose = fb.igm(LAB, np.array([(0.0, 0.2), (0.01, 0.21), (-0.02, 0.15)]))
    starts = fb.ikm(pose, np.zeros((3, 2)))
    for controller in (fb.ComputedTorque(LAB, 100, 20), fb.PD(LAB, 250, 50)):
        for k, run in enumerate(
            fb.simulate_many(LAB, controller, reference, starts, torque_limit=200.0)
        ):
            own = fb.ikm(fb.igm(LAB, pose.xi[k]), (0.0, 0.0))
            one = fb.simulate(
                LAB,
                controller,
                reference,
                start=own,
                integrator=fb.Integrator(chart="joint"),
                torque_limit=200.0,
            )
            np.testing.assert_allclose(run.q, one.q, rtol=0, atol=1e-11)
            np.testing.assert_allclose(run.tau, one.tau, rtol=0, atol=1e-8)


def test_compiled_models():
    function = fb.compile(
        LAB, ["q", "q_dot", "tau"], ["xi", "q_passive", "q_ddot", "M", "energy"], assembly=1
    )
    rates = fb.dkm(fb.dgm(LAB, (0.1, 0.02), 1), (0.3, -0.4))
    got = function([0.1, 0.02], [0.3, -0.4], [2.0, 1.0])
    wanted = (
        rates.pose.xi,
        rates.pose.q_passive,
        fb.forward_dynamics(rates, (2.0, 1.0)).q_ddot,
        fb.dynamic_model(rates)[0],
        fb.energy(rates),
    )
    for a, b in zip(got, wanted):
        np.testing.assert_allclose(a.full().squeeze(), b, rtol=1e-14)


def test_a_plan_crosses_type_2_with_little_force():
    plan = fb.plan(
        LAB,
        *(fb.igm(LAB, xi, (-1, 1)) for xi in ((0.05, 0.2), (-0.05, 0.3))),
        2.0,
        constraints=fb.Constraints(sin=0.05, torque=5.0),
    )
    t = np.linspace(0, 2, 4000)
    det = fb.igm(LAB, plan(t)[0], plan.working).det_A
    assert det[0] * det[-1] < 0 and plan.error < 1e-3
    assert np.abs(plan.torques(t)).max() < 2.0
    k = int(np.flatnonzero(det[1:] * det[:-1] < 0)[0])
    # At the crossing no inertial force points along the bars' common normal, which no bar can push along.
    free = fb.igm(LAB, plan(t[k])[0], plan.working).A[0] @ np.array([[0, 1], [-1, 0]])
    assert abs(free @ plan(t[k])[2]) < 0.02 * np.linalg.norm(plan(t)[2], axis=1).max()
    run = fb.simulate(LAB, fb.FeedForward(LAB, 250, 50, working=plan.working), plan)
    assert [int(event.type) for event in run.events] == [2] and np.abs(run.error).max() < 1e-4
    # What is asked to pay no attention to it pays.
    straight = fb.line((0.05, 0.2), (-0.04, 0.3), 2.0)
    when = fb.check_path(LAB, straight, (-1, 1)).time
    xi, xi_dot, xi_ddot = straight(np.array([when - 1e-6]))
    tau = fb.inverse_dynamics(fb.ikm2(fb.ikm(fb.igm(LAB, xi, (-1, 1)), xi_dot), xi_ddot))
    assert np.abs(tau).max() > 1e3


@pytest.mark.deep
def test_plans_speak_of_this_robot(tmp_path):
    plan = fb.plan(
        LAB,
        (0.0, 0.2),
        (0.05, 0.3),
        None,
        objective={"time": 1.0},
        constraints=fb.Constraints(torque=5.0, joint_speed=0.5),
    )
    rates = plan.accelerations(np.linspace(0, plan.duration, 500)).rates
    assert np.abs(rates.q_dot).max() <= 0.5 * (1 + 1e-3)
    plan.to_csv(tmp_path / "plan.csv")
    again = fb.Plan.from_csv(tmp_path / "plan.csv")
    assert again.robot == LAB and again.duration == plan.duration
    figure = plan.plot(tmp_path / "plan.png")
    assert [axes.get_ylabel().split()[0] for axes in figure.axes] == ["y", "force", "sine"]
    with pytest.raises(fb.PlanError, match=r"violated: force by .* N \(limit 0\.01\)"):
        fb.plan(LAB, (0.0, 0.2), (0.05, 0.3), 0.5, constraints=fb.Constraints(torque=0.01))
    with pytest.raises(ValueError, match=r"\(m, mf1, mf2 are 0\): no motion costs a force"):
        fb.plan(fb.Biglide(m=0, mf1=0, mf2=0), (0.0, 0.2), (0.05, 0.3), 1.0)


def test_crossing_polynomial():
    path = fb.crossing_polynomial(
        LAB, (0.05, 0.2), (-0.04, 0.3), (0.0, 0.26), (-0.08, 0.05), (0, 1, 2), working=(-1, 1)
    )
    check = fb.check_path(LAB, path, (-1, 1))
    assert check.time == pytest.approx(1.0, abs=1e-6) and check.criterion_holds
    t = np.linspace(0, 2, 2001)[np.abs(np.linspace(0, 2, 2001) - 1) > 1e-6]
    xi, xi_dot, xi_ddot = path(t)
    tau = fb.inverse_dynamics(fb.ikm2(fb.ikm(fb.igm(LAB, xi, (-1, 1)), xi_dot), xi_ddot))
    assert np.abs(tau).max() < 5.0


@pytest.mark.deep
def test_the_tracker_follows_a_line_and_a_long_way():
    for goal, duration in (
        ((0.06, 0.35), 1.0),
        ((0.0, 5.0), 2.0),
    ):  # the second farther than any angle goes
        reference = fb.line((0.0, 0.2), goal, duration)
        run = fb.simulate(
            LAB,
            fb.Tracker(LAB, constraints=fb.Constraints(torque=100.0)),
            reference,
            torque_limit=100.0,
        )
        assert (run.log.status == 0).all()
        assert np.abs(run.error).max() < 1e-5 * np.linalg.norm(goal)
    heavy, limit = fb.Biglide(m=3.6), 20.0
    tracker = fb.Tracker(
        LAB, encoder_resolution=1e-5, delay=1, constraints=fb.Constraints(torque=limit)
    )
    measurement = fb.Measurement(delay=1, encoder_resolution=1e-5)
    options = dict(torque_limit=limit, measurement=measurement, duration=1.5)
    run = fb.simulate(heavy, tracker, fb.line((0.0, 0.2), (0.06, 0.35), 1.0), **options)
    assert (run.log.status == 0).all() and np.abs(run.error[-1]).max() < 1e-4


def test_the_tracker_goes_on_across_type_2():
    plan = fb.plan(
        LAB,
        *(fb.igm(LAB, xi, (-1, 1)) for xi in ((0.05, 0.2), (-0.05, 0.3))),
        1.0,
        constraints=fb.Constraints(sin=0.05),
    )
    start = fb.ikm(fb.igm(LAB, (0.05, 0.2), (-1, 1)), (0.0, 0.0))
    tracker = fb.Tracker(
        LAB, assembly=int(start.pose.assembly), constraints=fb.Constraints(torque=20.0)
    )
    run = fb.simulate(LAB, tracker, plan, start=start, torque_limit=20.0, duration=1.2)
    assert [int(event.type) for event in run.events] == [2]
    assert np.abs(run.error).max() < 1e-4


@pytest.mark.deep
def test_runs_are_saved_and_drawn_in_the_robots_words(tmp_path):
    run = fb.simulate(
        LAB, fb.PD(LAB, 250, 50), fb.line((0.0, 0.2), (0.06, 0.35), 0.5), torque_limit=10.0
    )
    run.to_csv(tmp_path / "run.csv")
    header = (tmp_path / "run.csv").read_text("utf-8").splitlines()[1]
    measured = (
        "q1_measured,q2_measured,q1_dot_measured,q2_dot_measured,tau1_commanded,tau2_commanded"
    )
    assert header == f"t,q1,q2,q1_dot,q2_dot,x,y,tau1,tau2,energy,x_ref,y_ref,{measured}"
    again = fb.Run.from_csv(tmp_path / "run.csv")
    assert (
        again.robot == LAB
        and np.array_equal(again.q, run.q)
        and np.array_equal(again.q_error, run.q_error)
    )
    bars = np.linalg.norm(np.diff(run.points, axis=1), axis=2)
    np.testing.assert_allclose(bars, np.broadcast_to(LAB.distal, bars.shape), rtol=1e-12)
    figure = run.plot(tmp_path / "run.png")
    assert figure.axes[-1].get_title() == "motor forces" and figure.axes[-1].get_ylabel().endswith(
        "N)"
    )
    run.animate(tmp_path / "run.html")
    page = (tmp_path / "run.html").read_text("utf-8")
    assert "<title>biglide robot" in page
    with pytest.raises(ValueError, match="nothing named 'colour' can be shown"):
        run.animate(tmp_path / "run.html", "colour")
    with pytest.raises(ValueError, match="'colour'"):
        run.page(tmp_path / "run.html", "colour")
    table = fb.compare({"pd": run})
    assert (
        "peak force (N)" in str(table)
        and table.figures["pd"]["peak_force_N"] == np.abs(run.tau).max(axis=0).tolist()
    )
    table.plot(tmp_path / "compared.png")
    other = fb.simulate(fb.FiveBar(), reference=fb.line((0.09, 0.068), (0.08, 0.07), 0.1))
    with pytest.raises(ValueError, match="different kinds of robots"):
        fb.compare({"a": run, "b": other})


def test_errors_in_the_robots_units():
    start = fb.dkm(fb.dgm(LAB, (0.0, 0.0)), (0.0, 0.0))
    with pytest.raises(ArithmeticError, match=r"controller's force is \[nan, 0\.0\] N at"):
        fb.simulate(LAB, lambda *_: (np.nan, 0.0), duration=0.1, start=start)
    with pytest.raises(ValueError, match="must return two forces"):
        fb.simulate(LAB, lambda *_: 1.0, duration=0.1, start=start)
    with pytest.raises(ArithmeticError, match=r"rates .* m/s, forces .* N; sin phi1"):
        fb.simulate(LAB, lambda *_: (1e12, -1e12), duration=0.1, start=start)
    with pytest.raises(ValueError, match="mf1 must be finite and > 0"):
        fb.Tracker(fb.Biglide(mf1=0))


@pytest.mark.deep
def test_track_on_the_command_line(tmp_path, capsys):
    line = ["--from", "0", "0.2", "--to", "0.05", "0.3", "--duration", "0.5"]
    assert cli.main(["track", "--robot", "biglide", *line, "--controller", "pd", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert (
        figures["max_error_m"] < 0.02
        and len(figures["peak_force_N"]) == len(figures["max_joint_error_m"]) == 2
    )
    assert cli.main(["track", "--robot", "biglide", *line, "--out", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "peak force" in out and " mN\n" in out and "rad" not in out and "N m" not in out
    assert (tmp_path / "animation.html").exists()
