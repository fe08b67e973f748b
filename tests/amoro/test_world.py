"""The lab's Robot in this process: its home, its steps against an integration of their own, its clock and its ends."""

import threading
import time

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fivebar as fb
from fivebar.amoro.ros_free import parallel_robot, rclpy
from fivebar.amoro.ros_free import world as place
from fivebar.amoro.ros_free.clock import EPOCH, SimulatedClock
from fivebar.amoro.ros_free.world import GRACE, MOST_IDLE, MOST_STOPS, Stopped, World

HOME = {"five_bar": (0.09, 0.06796322535018479), "biglide": (0.0, 0.2)}
PASSIVE = {"five_bar": (0.8558782490506787, 2.2857144045391147), "biglide": (0.7853981, 2.3561945)}
# Efforts of 40 steps, N m or N, which move each robot a good way, regular throughout.
SIZE = {"five_bar": 0.02, "biglide": 3.0}
EFFORTS = np.array([(np.sin(0.3 * k), np.cos(0.2 * k) - 0.4) for k in range(40)])


@pytest.fixture
def left():
    """What the runtime was given up for."""
    return []


@pytest.fixture
def make(monkeypatch, left):
    monkeypatch.setattr(rclpy, "_initialised", False)

    def make(kind, until=10.0, exact=False):
        monkeypatch.setattr(
            place, "world", World(until, SimulatedClock(), exact, left.append), raising=False
        )
        rclpy.shutdown()
        rclpy.init(args=None)
        robot = parallel_robot.Robot(kind)
        parallel_robot.start_robot(robot)
        return robot

    return make


def values(robot, what):
    names = "active_left_joint", "active_right_joint", "passive_left_joint", "passive_right_joint"
    return np.array([getattr(getattr(robot, name), what) for name in names])


def end(robot, what):
    return np.array([getattr(robot.end_effector, f"{what}_{axis}") for axis in "xy"])


@pytest.mark.parametrize("kind", HOME)
def test_a_robot_begins_at_rest_at_home(make, kind):
    robot = make(kind)
    assert values(robot, "position")[:2] == pytest.approx([0.0, 0.0], abs=1e-15)
    assert values(robot, "position")[2:] == pytest.approx(PASSIVE[kind], abs=1e-7)
    assert end(robot, "position") == pytest.approx(HOME[kind], abs=1e-7)
    for name in ("velocity", "acceleration"):
        assert not values(robot, name).any() and not end(robot, name).any()
    assert not values(robot, "effort").any() and robot.get_time() == 0.0


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("kind", HOME)
def test_steps_are_10_ms_of_the_models_of_the_lab(make, kind, exact):
    """tau = M q'' + c, integrated in the active joints; accelerations are differences of velocities, as in the lab."""
    robot, model = make(kind, exact=exact), place.ROBOTS[kind]()

    def slope(_, state, tau):
        rates = fb.dkm(fb.dgm(model, state[:2]), state[2:])
        M, c = fb.dynamic_model(rates)
        return np.concatenate([state[2:], np.linalg.solve(M, tau - c)])

    state, passive = np.zeros(4), np.zeros(2)
    for k, tau in enumerate(SIZE[kind] * EFFORTS):
        before = state
        state = solve_ivp(
            slope, (0.0, 0.01), state, "DOP853", args=(tau,), rtol=1e-11, atol=1e-13
        ).y[:, -1]
        robot.apply_efforts(tau[0], np.array([[tau[1]]]))
        rates = fb.dkm(fb.dgm(model, state[:2]), state[2:])
        q_ddot, passive_before = slope(0.0, state, tau)[2:], passive
        passive = rates.q_passive_dot
        right = fb.dkm2(rates, q_ddot)
        accelerations = np.append(q_ddot, right.q_passive_ddot)
        if not exact:
            accelerations = np.append(state[2:] - before[2:], passive - passive_before) / 0.01
        assert values(robot, "position")[:2] == pytest.approx(state[:2], abs=1e-9)
        assert values(robot, "velocity") == pytest.approx([*state[2:], *passive], abs=1e-7)
        assert values(robot, "acceleration") == pytest.approx(accelerations, rel=1e-5, abs=1e-5)
        assert end(robot, "position") == pytest.approx(rates.pose.xi, abs=1e-9)
        assert end(robot, "velocity") == pytest.approx(rates.xi_dot, abs=1e-7)
        assert end(robot, "acceleration") == pytest.approx(right.xi_ddot, rel=1e-5, abs=1e-6)
        assert values(robot, "effort")[:2] == pytest.approx(tau)
        assert robot.get_time() == pytest.approx(0.01 * (k + 1))
    assert np.abs(state[:2]).max() > 0.02
    run = place.world.run()
    assert run.t[-1] == pytest.approx(0.4) and len(run.t) == 401
    assert run.q[-1] == pytest.approx(state[:2], abs=1e-9)
    assert run.tau[10 * np.arange(40) + 5] == pytest.approx(SIZE[kind] * EFFORTS)


def test_reset_is_home_at_time_0_and_keeps_the_run_before(make):
    robot = make("five_bar")
    robot.reset_simulation()
    assert place.world.run() is None and place.world.resets == []
    for _ in range(3):
        robot.apply_efforts(0.01, -0.02)
    robot.reset_simulation()
    assert robot.get_time() == 0.0 and not values(robot, "effort").any()
    assert end(robot, "position") == pytest.approx(HOME["five_bar"])
    assert place.world.resets == [0.03] and place.world.run().t[-1] == pytest.approx(0.03)
    assert robot.active_left_joint.effort == robot.active_right_joint.effort == 0.0
    robot.apply_efforts(0.0, 0.0)
    robot.reset_simulation()
    assert place.world.resets == [0.03, 0.04]
    assert place.world.clock.elapsed() == 40_000_000  # the clock goes on


@pytest.mark.parametrize("kind, effort, limit", [("five_bar", 2e-4, 0.05), ("biglide", 0.01, 0.01)])
def test_oscillations_turn_where_a_joint_has_passed_its_limit(make, kind, effort, limit):
    robot = make(kind, until=60.0)
    robot.continue_oscillations()
    assert robot.get_time() == 0.0  # not begun
    robot.start_oscillate()
    assert robot.get_time() == 0.01 and not values(robot, "effort").any()
    wanted, turns = np.array([effort, -effort]), 0
    while turns < 2:
        q = values(robot, "position")[:2]
        past = (wanted * q > 0) & (np.abs(q) > limit)
        turns += int(past[0])
        wanted = np.where(past, -wanted, wanted)
        robot.continue_oscillations()
        assert values(robot, "effort")[:2] == pytest.approx(wanted)
    assert robot.get_time() < 30
    robot.stop_oscillate()
    robot.continue_oscillations()
    assert robot.get_time() == 0.0


def test_a_state_is_new_once(make):
    robot = make("five_bar")
    assert [robot.data_updated() for _ in range(3)] == [True, False, False]
    robot.apply_efforts(0.0, 0.0)
    assert [robot.data_updated() for _ in range(2)] == [True, False]
    place.world.started = False
    robot.apply_efforts(0.0, 0.0)
    assert not robot.data_updated()


@pytest.mark.parametrize(
    "started, steps, why",
    [
        (True, 1, "the last apply_efforts was at t = 0.01 s"),
        (True, 0, "the script never called apply_efforts"),
        (False, 0, "start_robot\\(robot\\) was never called"),
    ],
)
def test_waiting_without_end_is_ended(make, started, steps, why):
    robot = make("five_bar")
    for _ in range(steps):
        robot.apply_efforts(0.0, 0.0)
    place.world.started = started
    robot.data_updated()
    place.world.idle = MOST_IDLE - 1
    assert not robot.data_updated()
    with pytest.raises(Stopped, match=f"{MOST_IDLE} times with no new state: {why}"):
        robot.data_updated()


def test_the_end_of_the_time_is_an_interrupt_and_then_an_end(make, left):
    robot = make("five_bar", until=0.05)
    for _ in range(5):
        robot.apply_efforts(0.0, 0.0)
    with pytest.raises(KeyboardInterrupt):
        robot.data_updated()
    for _ in range(GRACE):  # the motors may be brought to rest
        robot.apply_efforts(0.0, 0.0)
    assert robot.get_time() == pytest.approx(0.05 + 0.01 * GRACE)
    for k in range(MOST_STOPS + 1):
        with pytest.raises(Stopped, match="at 0.05 s of simulated time.* still stepping 1 s later"):
            robot.apply_efforts(0.0, 0.0)
        assert len(left) == (k == MOST_STOPS)
    assert "swallowed" in left[0]


def test_the_end_in_another_thread_interrupts_the_main_one(make):
    robot = make("five_bar", until=0.01)
    answers = []

    def script():
        robot.apply_efforts(0.01, 0.0)
        answers.append(robot.data_updated())

    thread = threading.Thread(target=script)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        thread.join()
        time.sleep(20)
    thread.join()
    assert answers == [False]


def test_after_the_end_another_thread_moves_nothing(make):
    robot = make("five_bar", until=0.01)
    robot.apply_efforts(0.01, 0.0)
    with pytest.raises(KeyboardInterrupt):
        robot.data_updated()
    moved = []

    def script():
        moved.append(robot.apply_efforts(0.0, 0.0))
        moved.append(robot.data_updated())
        place.world.ended = True
        try:
            robot.apply_efforts(0.0, 0.0)
        except SystemExit:
            moved.append("ended")

    thread = threading.Thread(target=script)
    thread.start()
    thread.join(20)
    assert moved == [None, False, "ended"] and robot.get_time() == 0.01


@pytest.mark.parametrize(
    "effort, error, words",
    [
        (np.zeros(2), TypeError, r"at t = 0 s: the right effort is an array of shape \(2,\)"),
        ("1", TypeError, "the right effort is '1', not one number"),
        (True, TypeError, "the right effort is True"),
        (np.nan, ValueError, "the right effort is nan"),
    ],
)
def test_an_effort_that_is_no_number_is_named(make, effort, error, words):
    robot = make("five_bar")
    with pytest.raises(error, match=words):
        robot.apply_efforts(0.0, effort)
    assert robot.get_time() == 0.0


def test_efforts_too_large_end_the_simulation_for_good(make):
    robot = make("five_bar")
    for _ in range(2):
        with pytest.raises(ArithmeticError, match=r"at t = 0 s: efforts .* N m drive the robot"):
            robot.apply_efforts(1e12, -1e12)


def test_a_second_robot_an_unknown_one_and_a_start_without_one(make):
    robot = make("five_bar")
    with pytest.raises(RuntimeError, match="there is a Robot already"):
        parallel_robot.Robot("biglide")
    place.world.kind = None
    with pytest.raises(ValueError, match="the known ones are 'five_bar', 'biglide'"):
        place.world.make("delta")
    with pytest.raises(TypeError, match="needs a Robot, not 3"):
        parallel_robot.start_robot(3)
    with pytest.raises(AttributeError, match="Robot has no 'fly'"):
        robot.fly()


def test_rclpy_begins_once_and_before_the_robot(monkeypatch):
    monkeypatch.setattr(rclpy, "_initialised", False)
    with pytest.raises(RuntimeError, match="Robot before rclpy.init"):
        rclpy.must_be_initialised("Robot")
    rclpy.init()
    rclpy.must_be_initialised("Robot")
    with pytest.raises(RuntimeError, match="called twice"):
        rclpy.init()
    rclpy.shutdown()
    rclpy.init()


def test_the_simulated_clock_counts_steps_and_sleep(monkeypatch):
    for name in "time time_ns perf_counter perf_counter_ns monotonic monotonic_ns sleep".split():
        monkeypatch.setattr(time, name, getattr(time, name))
    clock = SimulatedClock()
    clock.install()
    clock.tick()
    clock.tick()
    time.sleep(1.5)
    with pytest.raises(ValueError, match="non-negative"):
        time.sleep(-1)
    assert clock.elapsed() == time.perf_counter_ns() == time.monotonic_ns() == 1_520_000_000
    assert time.time_ns() == EPOCH * 1_000_000_000 + 1_520_000_000
    assert time.time() == pytest.approx(EPOCH + 1.52) and time.perf_counter() == 1.52
    assert time.monotonic() == 1.52
