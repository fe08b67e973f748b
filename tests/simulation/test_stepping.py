"""Steps of arrays against `simulate` and `simulate_many`, whose accuracy is tested elsewhere."""

import casadi
import numpy as np
import pytest

import fivebar as fb
from tests.models.test_arrays import HEAVY, library

LIBRARIES = "numpy", "jax.numpy", "torch"
ROBOT = fb.FiveBar()
TASK_1 = fb.line((0.09, 0.06796322), (0.0, 0.1), 2.0)
PERIOD = 0.01
LOOPS = {
    "computed torque": (ROBOT, fb.ComputedTorque(ROBOT, 100, 20), TASK_1),
    "pd": (ROBOT, fb.PD(ROBOT, 2.0, 0.3), TASK_1),
    "another robot": (
        fb.FiveBar(m=0.7, l12=0.095),
        fb.ComputedTorque(ROBOT, (80, 120), 20),
        TASK_1,
    ),
    "biglide": (
        fb.Biglide(),
        fb.ComputedTorque(fb.Biglide(), 100, 20),
        fb.line(fb.dgm(fb.Biglide(), (0.0, 0.0)).xi, fb.dgm(fb.Biglide(), (0.03, 0.05)).xi, 1.0),
    ),
    "gravity": (
        HEAVY,
        fb.PD(HEAVY, 0.5, 0.05, gravity=True),
        fb.line((0.02, 0.12), (0.03, 0.14), 1.0),
    ),
}


def start_of(robot, reference):
    xi, xi_dot, _ = reference(0.0)
    return fb.ikm(fb.igm(robot, xi), xi_dot)


def follow(step, xp, controller, reference, starts, **parameters):
    """States (steps + 1, n, 8) and torques (steps, n, 2) of a loop from some starts."""
    if xp.__name__.startswith("jax"):  # twenty times as fast
        import jax

        step = jax.jit(step)
    times = np.arange(round(reference.duration / PERIOD)) * PERIOD
    target = controller.target(times, reference)
    state = np.stack([np.concatenate(bars(start)) for start in starts])
    states, torques = [xp.asarray(state)], []
    for row in zip(target.rates.pose.q, target.rates.q_dot, target.q_ddot):
        state, tau = step(states[-1], *map(xp.asarray, row), **parameters)
        states.append(state)
        torques.append(tau)
    return tuple(np.stack([np.asarray(each) for each in rows]) for rows in (states, torques))


def bars(rates):
    """Angles of the four bars and their rates, by the passive joints."""
    turning = rates.pose.robot.turns
    angles, turns = np.empty(4), np.empty(4)
    angles[::2], turns[::2] = rates.pose.q, rates.q_dot
    angles[1::2] = rates.pose.q_passive + turning * rates.pose.q
    turns[1::2] = rates.q_passive_dot + turning * rates.q_dot
    return angles, turns


@pytest.mark.every(16)
@pytest.mark.parametrize("name", LIBRARIES)
@pytest.mark.parametrize("loop", LOOPS)
def test_a_closed_loop_is_that_of_simulate(name, loop):
    robot, controller, reference = LOOPS[loop]
    xp = library(name)
    start = start_of(robot, reference)
    run = fb.simulate(
        robot,
        controller,
        reference,
        start=start,
        control_period=PERIOD,
        step=PERIOD,
        integrator=fb.Integrator("dop8"),
    )
    step = fb.stepper(robot, PERIOD, to=xp, controller=controller)
    states, torques = follow(step, xp, controller, reference, [start])
    assert states[:, 0, [0, 2]] == pytest.approx(run.q, abs=1e-12)
    assert states[:, 0, [4, 6]] == pytest.approx(run.q_dot, abs=1e-11)
    assert torques[:, 0] == pytest.approx(run.tau[:-1], rel=1e-10, abs=1e-11)


@pytest.mark.every(3)
@pytest.mark.parametrize("name", LIBRARIES)
def test_robots_of_their_own_lengths_and_masses_are_those_of_simulate_many(name):
    """The parameters differ along the batch."""
    xp = library(name)
    values = {"l12": [0.09, 0.095, 0.088], "m": [0.5, 0.3, 0.9]}
    robots = [fb.FiveBar(**dict(zip(values, each))) for each in zip(*values.values())]
    controller = fb.ComputedTorque(ROBOT, 100, 20)
    starts = [start_of(robot, TASK_1) for robot in robots]
    runs = fb.simulate_many(
        robots,
        controller,
        TASK_1,
        starts,
        control_period=PERIOD,
        step=PERIOD,
        integrator=fb.Integrator("dop8"),
    )
    unknown = fb.FiveBar(**{name: casadi.SX.sym(name) for name in values})
    step = fb.stepper(unknown, PERIOD, to=xp, controller=controller)
    given = {name: xp.asarray(np.array(value)) for name, value in values.items()}
    states, torques = follow(step, xp, controller, TASK_1, starts, **given)
    for k, run in enumerate(runs):
        assert states[:, k, [0, 2]] == pytest.approx(run.q, abs=1e-12)
        assert torques[:, k] == pytest.approx(run.tau[:-1], rel=1e-10, abs=1e-11)


@pytest.mark.every(6)
@pytest.mark.parametrize("name", [*LIBRARIES, "array_api_strict"])
def test_held_torques_through_type_2(name):
    """A push that crosses Type 2 within the steps; the loop stays closed and energy balances."""
    xp = library(name)
    step = fb.stepper(ROBOT, PERIOD, to=xp)
    start = fb.dkm(fb.dgm(ROBOT, (0.0, 0.0)), (0.0, 0.0))
    state, tau = xp.asarray(np.concatenate(bars(start))), xp.asarray(np.array([0.1, -0.1]))
    read = fb.compile(ROBOT, ["state"], ["xi", "energy", "A", "elbows"], to=xp)
    signs, states = set(), [np.asarray(state)]
    for _ in range(100):
        state = step(state, tau)
        states.append(np.asarray(state))
        xi, energy, A, elbows = map(np.asarray, read(state))
        signs.add(np.sign(np.linalg.det(A)))
        assert np.hypot(*(xi - elbows.reshape(2, 2)[1])) == pytest.approx(0.09, abs=1e-14)
        turned = states[-1][[0, 2]] - states[0][[0, 2]]
        assert energy == pytest.approx(turned @ (0.1, -0.1), rel=1e-5, abs=1e-12)
    assert signs == {-1.0, 1.0}
    run = fb.simulate(
        ROBOT,
        lambda *_: np.array([0.1, -0.1]),
        start=start,
        duration=1.0,
        control_period=PERIOD,
        step=PERIOD,
        integrator=fb.Integrator("dop8"),
    )
    assert np.stack(states)[:, [0, 2]] == pytest.approx(run.q, abs=1e-9)


@pytest.mark.deep
def test_in_a_scan_and_differentiated_through_two_seconds():
    """d (end of a run) / d m against differences of `simulate`."""
    xp = library("jax.numpy")
    import jax

    controller = fb.ComputedTorque(ROBOT, 100, 20)
    times = np.arange(200) * PERIOD
    target = controller.target(times, TASK_1)
    rows = tuple(map(xp.asarray, (target.rates.pose.q, target.rates.q_dot, target.q_ddot)))
    step = fb.stepper(fb.FiveBar(m=casadi.SX.sym("m")), PERIOD, to=xp, controller=controller)
    state = xp.asarray(np.concatenate(bars(start_of(ROBOT, TASK_1))))

    def end(m):
        return jax.lax.scan(lambda state, row: step(state, *row, m=m), state, rows)[0][:4:2]

    found = np.asarray(jax.jit(jax.jacfwd(end))(0.45))

    def ran(m):
        options = {"control_period": PERIOD, "step": PERIOD, "integrator": fb.Integrator("dop8")}
        return fb.simulate(
            fb.FiveBar(m=m), controller, TASK_1, start=start_of(fb.FiveBar(m=m), TASK_1), **options
        ).q[-1]

    assert found == pytest.approx((ran(0.451) - ran(0.449)) / 0.002, rel=1e-4)


@pytest.mark.parametrize(
    "arguments,words",
    [
        ((fb.FiveBar(fs1=0.1), 0.01, np), "dry friction"),
        ((ROBOT, 0.0, np), "period must be"),
        ((ROBOT, 0.01, casadi), "has no .*stack"),
        ((ROBOT, 0.01, np, fb.Tracker), "needs a PD or ComputedTorque controller"),
        ((ROBOT, 0.01, np, lambda *_: 0), "needs a PD or ComputedTorque controller, not function"),
    ],
)
def test_what_cannot_be_stepped_is_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        fb.stepper(*arguments)


def test_arrays_of_another_shape_are_refused():
    step = fb.stepper(ROBOT, 0.01, to=np, controller=fb.PD(ROBOT, 1, 1))
    with pytest.raises(ValueError, match=r"state must have shape \(\*batch, 8\), not \(3, 4\)"):
        step(np.zeros((3, 4)), *np.zeros((3, 3, 2)))
    with pytest.raises(TypeError, match="q_ref_ddot must be an array of numpy"):
        step(np.zeros((3, 8)), *np.zeros((2, 3, 2)), np.zeros((3, 2), int))
