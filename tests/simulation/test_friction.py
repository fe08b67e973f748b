"""Gravity and friction in the plant: the balance of energy, and dry friction that sticks, slips and lets go exactly."""

import io
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fivebar as fb
from fivebar.models.charts import CHARTS
from fivebar.models.dynamics import held_by
from fivebar.models.four_joints import bars_of
from fivebar.models.physics import smoothed
from fivebar.simulation.steps import block_function
from fivebar.simulation.stick_slip import StickSlip, plant_of

from ..helpers.full_bodies import FullBodies
from ..helpers.physics_cases import CASES, ELBOWS, bodies_of_case, heavy_biglide, robot_of_case

IRI = robot_of_case(CASES[0])
SWINGING = {
    "heavy bars": replace(IRI, fv1=0, fv2=0),
    "viscous": IRI,
    "dry": replace(IRI, fs1=0.1, fs2=0.05),
    "all": robot_of_case(CASES[3], elbows=ELBOWS),
    "lab's under gravity": fb.FiveBar(gravity=(0.0, -9.81)),
    "biglide": heavy_biglide()[0],
}


@pytest.mark.every(3)
@pytest.mark.parametrize("name", SWINGING)
def test_energy_balances_to_1e_9_over_10_s_through_both_types(name):
    robot = SWINGING[name]
    q = (0.9, 2.0) if robot.turns else (0.05, -0.05)
    start = fb.dkm(fb.dgm(robot, q), (0.0, 0.0))
    if not robot.turns:  # the feet fall for ever: half a second of it
        run = fb.simulate(
            robot, lambda t, *_: (5.0 + np.sin(9 * t), 4.0), duration=0.5, start=start
        )
    else:
        run = fb.simulate(robot, duration=10.0, start=start)
        kinds = {event.type for event in run.events}
        assert name == "all" or kinds == {fb.Singularity.SERIAL, fb.Singularity.PARALLEL}
    assert np.ptp(run.potential) > 0.5
    assert np.abs(run.energy_error).max() < 1e-9
    assert (run.friction_loss is None) == (name in ("heavy bars", "lab's under gravity"))
    assert np.hypot(*run.loop_gap.T).max() < 1e-12


@pytest.mark.deep
def test_the_motion_is_that_of_full_bodies():
    """A second of swinging, integrated by SciPy from bodies that are not grouped, closed by constraint forces."""
    bodies, start = bodies_of_case(CASES[0]), fb.dkm(fb.dgm(IRI, (0.9, 2.0)), (0.3, -0.2))
    a, a_dot = (np.array(each, dtype=float) for each in bars_of(start))

    def slope(t, y):
        M, h, phi, bias = (np.array(each, dtype=float) for each in bodies.terms(y[:4], y[4:])[:4])
        f = (
            -h.ravel()
            - np.array([0.0176 * y[4], 0, 0.0176 * y[6], 0])
            + np.array([0.2, 0, -0.1, 0])
        )
        system = np.block([[M, phi.T], [phi, np.zeros((2, 2))]])
        return np.concatenate(
            [y[4:], np.linalg.solve(system, np.concatenate([f, -bias.ravel()]))[:4]]
        )

    end = solve_ivp(slope, (0, 1), [*a, *a_dot], method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    run = fb.simulate(IRI, lambda *_: (0.2, -0.1), duration=1.0, start=start)
    assert len(run.events) > 1
    np.testing.assert_allclose(run.q[-1], end[[0, 2]], atol=1e-8)
    np.testing.assert_allclose(run.q_dot[-1], end[[4, 6]], atol=1e-7)


@pytest.mark.deep
def test_what_sticks_does_not_creep_in_60_s():
    robot = fb.FiveBar(fs1=0.02, fs2=0.03, gravity=(0.0, -0.01))
    run = fb.simulate(robot, lambda *_: (0.01, -0.015), duration=60.0, step=0.01)
    assert np.ptp(run.q, axis=0).max() <= 1e-12 and np.abs(run.q_dot).max() <= 1e-12
    assert np.ptp(run.xi, axis=0).max() <= 1e-12 and run.friction_loss[-1] == 0


def test_a_drive_alone_slides_stops_and_lets_go_when_it_should():
    """With no mass at the end the drives are alone: zz q'' = tau - fs sign(q'), known in closed form."""
    robot = fb.FiveBar(m=0, zz1=0.002, zz2=0.003, fs1=0.02, fs2=0.03)
    start = fb.dkm(fb.dgm(robot, (0.2, 0.4)), (1.5, -1.0))
    run = fb.simulate(robot, lambda *_: (0.004, 0.006), duration=0.3, start=start)
    for k, (q, rate, tau, fs, zz) in enumerate(
        ((0.2, 1.5, 0.004, 0.02, 0.002), (0.4, -1.0, 0.006, 0.03, 0.003))
    ):
        slows = (tau - fs * np.sign(rate)) / zz
        stop = -rate / slows
        t = np.minimum(run.t, stop)
        assert 0.05 < stop < 0.25
        np.testing.assert_allclose(run.q[:, k], q + rate * t + slows * t * t / 2, atol=1e-13)
        assert np.all(run.q_dot[run.t > stop, k] == 0)
    # A ramp lets it go where the torque passes the friction, within the sample that holds it.
    ramp = fb.simulate(
        robot,
        lambda t, *_: (0.1 * t, 0.0),
        duration=0.3,
        start=fb.dkm(fb.dgm(robot, (0.2, 0.4)), (0, 0)),
    )
    first = ramp.t[np.argmax(ramp.q_dot[:, 0] > 0)]
    assert 0.2 <= first <= 0.2 + 0.0101 + 0.001 and np.all(ramp.q_dot[:, 1] == 0)
    assert np.all(np.diff(ramp.q[:, 0]) >= -1e-15)


def test_a_drive_that_sticks_stands_to_the_last_bit_while_the_other_swings():
    robot = fb.FiveBar(fs1=0.5, fs2=1e-4)
    run = fb.simulate(robot, duration=0.5, start=fb.dkm(fb.dgm(robot, (0.2, 0.4)), (0.0, 1.0)))
    assert np.ptp(run.q[:, 0]) == 0 and (run.q_dot[:, 0] == 0).all() and np.ptp(run.q[:, 1]) > 0.4
    assert np.abs(run.energy_error).max() < 1e-13 and np.abs(run.loop_gap).max() < 1e-15


def test_what_holds_a_drive_is_never_more_than_its_friction():
    """Driven to and fro at the limit: at every row each drive slips with its rate or is held, and both happen often."""
    robot = replace(IRI, fs1=0.8, fs2=0.6, gravity=(0.0, -2.0))
    start = fb.dkm(fb.dgm(robot, (0.9, 2.0)), (0.0, 0.0))
    plant = plant_of(robot, start, 1e-12)
    assert isinstance(plant, StickSlip)
    changes, before = 0, None
    for k in range(300):
        tau = np.array([1.4 * np.sin(0.05 * k), 1.1 * np.cos(0.083 * k)])
        plant.advance((k + 1) * 0.01, tau)
        standing = plant.state[4:7:2] == 0
        slip = tuple(np.where(standing, 0.0, np.sign(plant.state[4:7:2])))
        if standing.any():
            _, held = held_by(plant.rates, tuple(tau.tolist()), slip)
            assert np.all(np.abs(np.array(held))[standing] <= plant.friction[standing] * (1 + 1e-9))
        changes += before is not None and slip != before
        before = slip
    assert changes > 10
    t = np.linspace(0, 3, 301)
    assert np.all(np.diff(plant.friction_loss(t)) >= 0)


def test_smoothed_friction_comes_to_the_exact_one_as_its_rate_goes_to_0():
    """By fixed steps of the smoothed robot, which knows no events: the difference goes as the rate."""
    robot = replace(IRI, fs1=0.3, fs2=0.2)
    start = fb.dkm(fb.dgm(robot, (0.9, 2.0)), (0.0, 0.0))
    exact = fb.simulate(robot, duration=0.6, start=start)
    away = []
    for rate in (0.1, 0.01):
        soft = smoothed(robot, rate)
        begin = fb.dkm(fb.dgm(soft, (0.9, 2.0)), (0.0, 0.0))
        c, c_dot, _ = CHARTS["auto"].coordinates(begin)
        states = block_function(soft, CHARTS["auto"], "rk4", 2e-4, 3000)(
            [*c, *c_dot], [0, 0], [0, 0], 0
        )[0].full()
        away.append(np.abs(states[[0, 2], -1] - exact.q[-1]).max())
    assert away[1] < 0.25 * away[0] and away[1] < 4e-3


def test_a_plant_with_more_physics_than_its_controller_knows():
    simple, reference = fb.FiveBar(), fb.line((0.09, 0.068), (0.06, 0.1), 1.0)
    plant = fb.FiveBar(gravity=(0.0, -9.81), fv1=0.002, fv2=0.002)
    blind = fb.simulate(plant, fb.ComputedTorque(simple, 100.0, 20.0), reference)
    knows = fb.simulate(plant, fb.ComputedTorque(plant, 100.0, 20.0), reference)
    errors = [np.abs(run.error[-1]).max() for run in (blind, knows)]
    assert blind.robot == plant and errors[0] > 20 * errors[1] and errors[1] < 2e-4


@pytest.mark.parametrize("integrator", [fb.Integrator("rk4"), fb.Integrator(chart="task")])
def test_fixed_steps_refuse_dry_friction_by_name(integrator):
    robot = fb.FiveBar(fs2=0.01)
    with pytest.raises(ValueError, match="fs2: dry friction sticks"):
        fb.simulate(robot, duration=0.1, integrator=integrator)
    with pytest.raises(ValueError, match="fs2: dry friction sticks"):
        fb.simulate_many(
            [robot] * 2, fb.PD(robot, 1.0, 0.1), fb.line((0.09, 0.068), (0.06, 0.1), 1.0)
        )


def test_many_robots_with_their_own_physics_are_what_each_alone_is():
    robots = [fb.FiveBar(gravity=(0.0, -2.0)), fb.FiveBar(fv1=0.003), replace(IRI, d=0.13)]
    reference = fb.line((0.02, 0.15), (0.03, 0.12), 0.3)
    own = fb.PD(robots[0], 20.0, 0.5)
    for robot, run in zip(robots, fb.simulate_many(robots, own, reference)):
        alone = fb.simulate(robot, own, reference, integrator=fb.Integrator(method="rk4"))
        np.testing.assert_allclose(run.q, alone.q, atol=1e-9)
        exact = fb.simulate(robot, own, reference)
        np.testing.assert_allclose(run.q, exact.q, atol=1e-5)
        assert np.abs(run.energy_error).max() < 1e-5
    starts = [
        fb.ikm(fb.igm(robot, (0.02, 0.15 + 0.01 * k)), (0.1, 0.0)) for k, robot in enumerate(robots)
    ]
    for start, run in zip(starts, fb.simulate_many(robots, own, reference, starts)):
        alone = fb.simulate(
            start.pose.robot, own, reference, integrator=fb.Integrator(method="rk4"), start=start
        )
        np.testing.assert_allclose(run.q, alone.q, atol=1e-12)
    with pytest.raises(ValueError, match="start is of another robot"):
        fb.simulate_many(robots, own, reference, starts[::-1])
    for wrong in (5, "ab"):
        with pytest.raises(
            TypeError, match=f"starts must be the Rates of a batch, .* not {wrong!r}"
        ):
            fb.simulate_many(robots, own, reference, wrong)
    far = [robots[0], fb.FiveBar(fv1=0.003, l22=0.05), robots[1], fb.FiveBar(d=0.3)]
    with pytest.raises(
        ValueError,
        match=r"2 of 4 robots do not reach the .* start \(0\.02, 0\.15\) m: number 1, 3$",
    ):
        fb.simulate_many(far, own, reference)


def test_fixed_steps_balance_too():
    robot = fb.FiveBar(gravity=(0.0, -9.81), fv1=0.001, fv12=0.0005)
    run = fb.simulate(
        robot,
        duration=1.0,
        start=fb.dkm(fb.dgm(robot, (0.3, 1.2)), (0, 0)),
        integrator=fb.Integrator(method="dop8"),
        step=5e-4,
    )
    assert (
        np.abs(run.energy_error).max() < 1e-7 < run.friction_loss[-1] and run.friction_loss[0] == 0
    )


@pytest.mark.parametrize("reference", [None, fb.line((0.09, 0.068), (0.06, 0.1), 0.2)])
def test_a_run_keeps_its_friction_and_its_robot_in_a_file(reference):
    robot = fb.FiveBar(gravity=(0.0, -9.81), fs1=0.001, fv2=0.002, zz12=-1e-5, mx11=0.003)
    law = fb.PD(robot, 20.0, 0.5) if reference else None
    run = fb.simulate(robot, law, reference, duration=0.2)
    file = io.StringIO()
    run.to_csv(file)
    file.seek(0)
    back = fb.Run.from_csv(file)
    assert back.robot == robot
    np.testing.assert_array_equal(back.friction_loss, run.friction_loss)
    np.testing.assert_array_equal(back.potential, run.potential)
    np.testing.assert_array_equal(back.energy_error, run.energy_error)
    untold = io.StringIO(_written(replace(run, friction_loss=None)))  # as of a log
    assert np.isnan(fb.Run.from_csv(untold).friction_loss).all()
    assert "mx21" not in file.getvalue() and "gravity" not in _written(
        fb.simulate(fb.FiveBar(), duration=0.1)
    )


def _written(run):
    file = io.StringIO()
    run.to_csv(file)
    return file.getvalue()


def test_the_oracle_is_not_the_package():
    assert "fivebar" not in FullBodies.__init__.__code__.co_names


def test_a_start_that_stands_but_for_rounding_stands():
    """The first and second derivative of a line at its start are 1e-17, of either sign."""
    robot = fb.FiveBar(0.1, 0.12, 0.08, 0.11, 0.07, fs1=0.02, fs2=0.02, fv1=0.01)
    for x in np.linspace(0.02, 0.04, 9):
        line = fb.line((x, 0.15), (-0.02, 0.13), duration=0.5)
        run = fb.simulate(robot, fb.PD(robot, 0.1, 0.01), line, duration=0.02)
        assert run.friction_loss[-1] == 0 and not run.q_dot[1:].any()


def test_a_robot_that_stands_at_type_2_stands_there_until_it_is_driven():
    """The distal bars are in line to rounding: what is between drives that stick is not solved for."""
    robot = fb.FiveBar(fs1=0.02, fs2=0.02)
    for q1 in np.linspace(1.7, 2.0, 7):
        left = -robot.d / 2 + robot.l11 * np.exp(1j * q1)
        span = left - robot.d / 2
        reach = robot.l12 + robot.l22
        cosine = (abs(span) ** 2 + robot.l21**2 - reach**2) / (2 * abs(span) * robot.l21)
        right = robot.d / 2 + robot.l21 * np.exp(1j * (np.angle(span) - np.arccos(cosine)))
        middle = (left + right) / 2
        xi = middle.real, middle.imag
        start = fb.ikm(fb.igm(robot, xi, working=(1, -1)), (0.0, 0.0))
        assert abs(start.pose.det_A) < 1e-12

        def driven_from_20_ms(t, *_):
            return (0.0, 0.0) if t < 0.02 else (-0.2, 0.1)

        run = fb.simulate(robot, driven_from_20_ms, duration=0.03, start=start)
        np.testing.assert_allclose(run.xi[:21], np.tile(xi, (21, 1)), rtol=0, atol=1e-15)
        assert not run.q_dot[:21].any() and run.q_dot[-1].any()
