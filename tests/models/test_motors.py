"""Motors with a torque-speed line: at rest, in a least time, in a plan, in a simulation, in a file."""

import casadi
import numpy as np
import pytest

import fivebar as fb

LAB = fb.FiveBar()
MOTOR = fb.Motor(0.06, 300.0, 0.05, 1e-7, 20.0, 0.8)
SLOW = fb.Motor(stall_torque=0.12, no_load_speed=4.0)


def test_at_the_joint():
    assert MOTOR.stall == pytest.approx(0.96) and MOTOR.torque == pytest.approx(0.8)
    assert MOTOR.speed == 15.0 and MOTOR.inertia == pytest.approx(4e-5)
    q_dot = np.linspace(-40, 40, 81)
    low, high = MOTOR.bounds(q_dot)
    np.testing.assert_array_equal(low, -high[::-1])
    # By the voltage of a DC motor: tau = k (V - k q') / R, |V| <= the one that gives the line.
    by_voltage = 0.96 - 0.96 / 15 * q_dot
    np.testing.assert_allclose(high, np.clip(by_voltage, -0.8, 0.8), atol=1e-15)
    rate = casadi.SX.sym("rate")
    symbolic = casadi.Function("bounds", [rate], MOTOR.bounds(rate))
    for each, k in ((low, 0), (high, 1)):
        np.testing.assert_allclose(np.array(symbolic(q_dot[None])[k]).ravel(), each, atol=1e-15)


@pytest.mark.parametrize(
    "values, words",
    [
        ((0.0, 1.0), "stall_torque must be"),
        ((1.0, -1.0), "no_load_speed must be"),
        ((1.0, 1.0, 0.0), "largest_torque must be"),
        ((1.0, 1.0, None, -1.0), "rotor_inertia must be"),
        ((1.0, 1.0, None, 0.0, 0.0), "gear must be"),
        ((1.0, 1.0, None, 0.0, 1.0, 1.5), "efficiency must be"),
        ((1.0, 1.0, None, 0.0, 1.0, 0.0), "efficiency must be above 0"),
    ],
)
def test_what_is_no_motor(values, words):
    with pytest.raises(ValueError, match=words):
        fb.Motor(*values)


@pytest.mark.parametrize(
    "motors, words",
    [
        ("big", "no motor 'big'; the known ones are ax-12a"),
        ({"stall_torque": 1.0}, "needs no_load_speed too"),
        ({"stall_torque": 1.0, "speed": 2.0}, "no speed of a motor"),
        ((SLOW, SLOW, SLOW), "must be a Motor or two of them"),
        (3.0, "must be a Motor, a motor's name or a table of its parameters, not 3.0"),
    ],
)
def test_what_are_no_motors(motors, words):
    with pytest.raises((ValueError, TypeError), match=words):
        fb.Constraints(motors=motors)


def test_a_constraint_on_motors_limits_the_torque_too():
    constraints = fb.Constraints(motors=(MOTOR, SLOW), torque=0.5)
    assert constraints.torque == pytest.approx((0.5, 0.12))
    tau, q_dot = (
        np.array([[0.25, 0.0], [0.0, 0.06], [0.0, -0.06]]),
        np.array([[0, 0], [0, 2], [0, 2]]),
    )
    # Half of the limit; half of the torque and half of the speed; braking, half of the torque.
    assert constraints.torque_share(tau, q_dot) == pytest.approx([0.5, 1.0, 0.5])
    assert fb.Constraints().torque_share(tau, q_dot).tolist() == [0, 0, 0]


def line_share(motion, motor, count=4001):
    """By `inverse_dynamics` alone: the largest shares of torque and line, (count,) each."""
    t = np.linspace(0, motion.duration, count + 2)[1:-1]  # at rest, dry friction has no value
    accelerations = motion.accelerations(t)
    tau, q_dot = motion.torques(t), accelerations.rates.q_dot
    return np.abs(tau / motor.stall + q_dot / motor.speed).max(1), np.abs(tau / motor.torque).max(1)


@pytest.mark.deep
@pytest.mark.parametrize(
    "robot",
    [LAB, fb.FiveBar(fv1=0.01, fv2=0.01, fs1=0.01, fs2=0.01), fb.FiveBar(gravity=(0.0, -0.05))],
    ids=["lab", "friction", "gravity"],
)
@pytest.mark.parametrize("goal", [(0.03, 0.1), (0.05, 0.0)], ids=["free", "across Type 2"])
def test_a_least_time_uses_the_line_and_keeps_it(robot, goal):
    path = fb.path([(0.09, 0.068), goal])
    timed = fb.time_path(robot, path, constraints=fb.Constraints(motors=SLOW))
    assert timed.gap < 5e-3
    line, torque = line_share(timed, SLOW)
    assert line.max() <= 1 + 1e-6 and torque.max() <= 1 + 1e-6
    # Somewhere each is at its limit, and the motion drives and brakes at others.
    assert np.mean(np.maximum(line, torque) > 1 - 1e-3) > 0.75
    box = fb.time_path(robot, path, constraints=fb.Constraints(torque=0.12, joint_speed=4.0))
    assert timed.lower_bound > box.duration
    # As fast a motor as one likes is the limit on torque alone.
    fast = fb.time_path(robot, path, constraints=fb.Constraints(motors=fb.Motor(0.12, 1e7)))
    alone = fb.time_path(robot, path, constraints=fb.Constraints(torque=0.12))
    assert fast.duration == pytest.approx(alone.duration, rel=2e-3)


@pytest.mark.deep
def test_a_duration_and_a_jerk_with_motors():
    path = fb.path([(0.09, 0.068), (0.03, 0.1)])
    constraints = fb.Constraints(motors=SLOW, jerk=200.0)
    smooth = fb.time_path(LAB, path, constraints=constraints)
    assert max(each.max() for each in line_share(smooth, SLOW)) <= 1 + 1e-6
    slow = fb.time_path(LAB, path, 2.0, constraints=fb.Constraints(motors=SLOW))
    assert slow.duration == pytest.approx(2.0)
    assert max(each.max() for each in line_share(slow, SLOW)) < 0.9


@pytest.mark.deep
def test_a_plan_keeps_the_line(tmp_path):
    constraints = fb.Constraints(motors=SLOW)
    ends = (0.09, 0.068), (0.0, 0.1)
    plan = fb.plan(LAB, *ends, objective="time", constraints=constraints)
    line, torque = line_share(plan, SLOW)
    assert max(line.max(), torque.max()) < 1.02 and plan.saturated > 0.3
    box = fb.plan(LAB, *ends, objective="time", constraints=fb.Constraints(torque=0.12))
    assert plan.duration > 1.02 * box.duration
    plan.to_csv(tmp_path / "plan.csv")
    assert fb.Plan.from_csv(tmp_path / "plan.csv").problem.constraints == plan.problem.constraints


def test_a_row_is_at_the_limit_of_its_own_speed():
    """The torque that is asked for stays for ten rows, and the motor's line falls in each."""
    motor = fb.Motor(0.12, 12.0)
    line = fb.line((0.09, 0.068), (0.0, 0.1), 0.4)
    run = fb.simulate(LAB, fb.ComputedTorque(LAB, 400, 40), line, torque_limit=motor)
    asked = np.repeat(run.control.commanded, 10, axis=0)
    by_speed = 0.12 * run.q_dot[:-1] / 12.0
    high = np.minimum(0.12 - by_speed, 0.12)
    low = np.maximum(-0.12 - by_speed, -0.12)
    at_limit = (asked >= high) | (asked <= low)
    assert 0.1 < at_limit.mean() < 0.9
    np.testing.assert_array_equal(run.saturated[:-1], at_limit)
    # Friction brakes it, so that the line rises; the last row repeats the torque before it.
    robot = fb.FiveBar(fv1=0.05, fv2=0.05)
    start = fb.dkm(fb.dgm(robot, (0.2, 0.4)), (8.0, -8.0))

    def late(t, *_):
        return (1.0, -1.0) if t > 0.015 else (0.0, 0.0)

    braked = fb.simulate(robot, late, duration=0.021, start=start, torque_limit=motor)
    assert braked.saturated.tolist() == 20 * [[False, False]] + 2 * [[True, True]]


@pytest.mark.deep
def test_a_simulation_saturates_by_the_speed(tmp_path):
    robot, reference = LAB, fb.line((0.09, 0.068), (0.0, 0.1), 0.4)
    controller = fb.ComputedTorque(robot, 400, 40)
    run = fb.simulate(robot, controller, reference, torque_limit=SLOW, control_period=0.002)
    rows = np.searchsorted(run.t, run.control.t)
    low, high = np.moveaxis(
        [m.bounds(run.q_dot[rows, k]) for k, m in enumerate((SLOW, SLOW))], 0, -1
    )
    np.testing.assert_allclose(run.control.applied, np.clip(run.control.commanded, low, high))
    low, high = np.moveaxis([SLOW.bounds(run.q_dot[:-1, k]) for k in range(2)], 0, -1)
    assert (run.tau[:-1] <= high + 1e-12).all() and (run.tau[:-1] >= low - 1e-12).all()
    assert 0.01 < run.saturated.mean() < 1
    at_limit = np.abs(run.control.applied - run.control.commanded) > 1e-9
    assert (run.saturated[rows] >= at_limit).all()
    assert run.largest_torque == 0.12 and np.abs(run.tau).max() == pytest.approx(0.12)
    run.to_csv(tmp_path / "run.csv")
    again = fb.Run.from_csv(tmp_path / "run.csv")
    assert again.torque_limit == run.torque_limit == (SLOW, SLOW)
    assert np.array_equal(again.saturated, run.saturated)
    assert run.plot(tmp_path / "run.png") is not None


def test_motors_in_a_file(tmp_path):
    for motors in ((MOTOR, SLOW), "xl430-w250"):
        machine = fb.Machine(LAB, constraints=fb.Constraints(motors=motors))
        machine.save(tmp_path / "robot.toml")
        assert fb.load_machine(tmp_path / "robot.toml") == machine
    (tmp_path / "robot.toml").write_text('l11 = 0.1\n[constraints]\nmotors = "ax-12a"\n', "utf-8")
    assert fb.load_machine(tmp_path / "robot.toml").constraints.motors == (fb.MOTORS["ax-12a"],) * 2


@pytest.mark.deep
def test_a_tracker_that_knows_the_line_asks_for_no_more():
    path = fb.path([(0.09, 0.068), (0.03, 0.1)])
    motion = fb.time_path(LAB, path, constraints=fb.Constraints(motors=SLOW))
    beyond, errors = [], []
    for constraints in (fb.Constraints(motors=SLOW), fb.Constraints(torque=SLOW.torque)):
        tracker = fb.Tracker(LAB, period=0.002, seconds=0.1, constraints=constraints)
        run = fb.simulate(LAB, tracker, motion, torque_limit=SLOW, control_period=0.002)
        beyond.append(np.abs(run.control.commanded - run.control.applied).max())
        errors.append(np.abs(run.error).max())
    assert errors[0] < errors[1] < 1e-4
    assert beyond[0] < 1e-4 < 1e-3 < beyond[1]


@pytest.mark.deep
def test_a_strong_slow_motor_has_a_motion():
    # The line is stiff: over a stretch a motor faster than it may be would stop many times over.
    robot = fb.FiveBar(0.12, 0.16, 0.12, 0.16, 0.1, m=0.4)
    path = fb.path([(-0.03, 0.12), (0.03, 0.12), (0.03, 0.15), (-0.03, 0.15)], deviation=2e-5)
    motor = fb.Motor(3.4, 3.14)
    timed = fb.time_path(robot, path, constraints=fb.Constraints(motors=motor), working=(1, -1))
    box = fb.Constraints(torque=3.4, joint_speed=3.14)
    fast = fb.time_path(robot, path, constraints=box, working=(1, -1))
    assert fast.lower_bound < timed.duration and timed.gap < 5e-3
    assert max(each.max() for each in line_share(timed, motor)) <= 1 + 1e-6
