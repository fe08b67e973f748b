"""Torques of the user's own: against the package's friction, other integrators and a tracker that knows them."""

import io
import math
import pickle

import casadi
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fivebar as fb
from fivebar.models.loaded_robot import LoadedRobot, robot_and_torques

ROBOT = fb.FiveBar(0.1, 0.12, 0.08, 0.11, 0.07, zz1=0.003, m=0.4)
LINE = fb.line((0.03, 0.15), (-0.02, 0.13), duration=0.5)
CONTROLLER = fb.ComputedTorque(ROBOT, 100, 20)
VISCOUS = 0.01


def viscous(t, q, q_dot, tau):
    return tau - VISCOUS * q_dot


def viscous_of_floats(t, q, q_dot, tau):
    return [float(tau[k]) - VISCOUS * float(q_dot[k]) for k in (0, 1)]


def driven(t, q, q_dot, tau):
    """A gear with losses, cogging, and something that pulls."""
    return 0.8 * tau * (1 + 0.1 * np.cos(6 * q)) + np.array([0.05, -0.02]) * np.sin(20 * t)


def driven_of_floats(t, q, q_dot, tau):
    pull = math.sin(20 * t)
    return [
        0.8 * tau[0] * (1 + 0.1 * math.cos(6 * q[0])) + 0.05 * pull,
        0.8 * tau[1] * (1 + 0.1 * math.cos(6 * q[1])) - 0.02 * pull,
    ]


def simulated(robot, **options):
    return fb.simulate(robot, CONTROLLER, LINE, **options)


@pytest.mark.every(3)
@pytest.mark.parametrize("torques", [viscous, viscous_of_floats])
@pytest.mark.parametrize("coulomb", [0.0, 0.02])
def test_friction_of_the_users_own_is_that_of_the_package(torques, coulomb):
    """With dry friction beside it, which sticks and slips."""
    dry = dict(fs1=coulomb, fs2=coulomb)
    kept = {name: getattr(ROBOT, name) for name in ("l11", "l12", "l21", "l22", "d", "zz1", "m")}
    own = simulated(LoadedRobot(fb.FiveBar(**kept, **dry), torques))
    known = simulated(fb.FiveBar(**kept, **dry, fv1=VISCOUS, fv2=VISCOUS))
    assert np.abs(own.q - known.q).max() < 1e-13
    assert np.abs(own.friction_loss - known.friction_loss).max() < 1e-15
    assert np.abs(own.energy_error).max() < 1e-13 and own.friction_loss[-1] > 1e-6


def test_a_drive_and_a_disturbance_against_an_integrator_of_scipy():
    start = fb.ikm(fb.igm(ROBOT, (0.03, 0.15)), (0.02, -0.1))
    run = fb.simulate(LoadedRobot(ROBOT, driven), duration=0.4, start=start)
    other = fb.simulate(LoadedRobot(ROBOT, driven_of_floats), duration=0.4, start=start)

    def slope(t, y):
        rates = fb.dkm(fb.dgm(ROBOT, y[:2]), y[2:])
        tau = driven_of_floats(t, y[:2], y[2:], np.zeros(2))
        return [*y[2:], *fb.forward_dynamics(rates, tau).q_ddot]

    begin = [*start.pose.q, *start.q_dot]
    there = solve_ivp(slope, (0, 0.4), begin, method="DOP853", rtol=1e-12, atol=1e-13).y[:2, -1]
    assert np.abs(run.q[-1] - there).max() < 1e-10
    assert np.abs(run.q - other.q).max() < 1e-12 and np.abs(run.energy_error).max() < 1e-12
    assert np.abs(run.q[-1] - run.q[0]).max() > 0.01


@pytest.mark.parametrize("method,chart", [("rk4", "auto"), ("dop8", "task"), ("dop8", "joint")])
def test_fixed_steps_in_any_chart(method, chart):
    exact = simulated(LoadedRobot(ROBOT, driven))
    fixed = simulated(LoadedRobot(ROBOT, driven), integrator=fb.Integrator(method, chart=chart))
    assert np.abs(fixed.q - exact.q).max() < 1e-9
    assert np.abs(fixed.friction_loss - exact.friction_loss).max() < 1e-6


def test_a_run_is_read_back_with_what_was_taken():
    run = simulated(LoadedRobot(ROBOT, driven))
    file = io.StringIO()
    run.to_csv(file)
    file.seek(0)
    assert np.array_equal(fb.Run.from_csv(file).friction_loss, run.friction_loss)


def test_what_is_compiled_and_what_is_called():
    symbol = casadi.SX.sym("k")
    kinds = {
        driven: True,
        driven_of_floats: False,  # Python's sine of a symbol is nan
        lambda t, q, v, tau: tau if v[0] > 0 else -tau: False,
        lambda t, q, v, tau: casadi.if_else(v > 0, tau, -tau): True,
    }
    for torques, is_compiled in kinds.items():
        robot, known = robot_and_torques(LoadedRobot(ROBOT, torques))
        assert robot is ROBOT and (known.text is not None) == is_compiled
    wrong = {
        "must return two torques, not 1": lambda t, q, v, tau: tau[0],
        "must return two torques, not 3": lambda t, q, v, tau: [float(t)] * 3,
        "must return two torques, not None": lambda t, q, v, tau: None,
        "depend on the symbol k": lambda t, q, v, tau: symbol * tau,
        r"torques are \[nan, 0.0\] at t = 0.1": lambda t, q, v, tau: [
            math.nan if t > 0.1 else 0.0,
            0.0,
        ],
    }
    for message, torques in wrong.items():
        with pytest.raises((ValueError, ArithmeticError), match=message):
            simulated(LoadedRobot(ROBOT, torques))


def test_what_needs_a_compiled_function_says_so():
    plant = LoadedRobot(ROBOT, viscous_of_floats)
    for call in (
        lambda: simulated(plant, integrator=fb.Integrator("rk4")),
        lambda: simulated(plant, integrator=fb.Integrator(jit=True)),
        lambda: fb.Tracker(plant),
    ):
        with pytest.raises(ValueError, match=r"is compiled, but .* casadi.if_else in place of if"):
            call()


def test_redefined_constants_are_not_those_of_the_last_call():
    """A function that reads a variable outside is traced in each call."""
    runs = []
    for pull in (0.0, 0.05):

        def pulled(t, q, q_dot, tau, pull=lambda: pull):
            return tau + pull()

        runs.append(simulated(LoadedRobot(ROBOT, pulled)))
    assert np.abs(runs[1].q - runs[0].q).max() > 1e-4


def test_a_tracker_that_knows_the_torques_follows_better():
    plant = LoadedRobot(ROBOT, driven)
    errors = []
    for known in (ROBOT, plant):
        tracker = pickle.loads(pickle.dumps(fb.Tracker(known, delay=1)))
        run = fb.simulate(plant, tracker, LINE, measurement=fb.Measurement(delay=1))
        assert not tracker.log.status.any()
        errors.append(np.linalg.norm(run.error, axis=1).max())
    assert 4 * errors[1] < errors[0]
