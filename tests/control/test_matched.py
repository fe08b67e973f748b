"""A tracker's weights by its motion: written out once more by the scaling of time along a path."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.control import matched as m
from fivebar.control import tracker

ROBOT = fb.FiveBar()
HALF = fb.FiveBar(0.045, 0.06, 0.05, 0.07, 0.06)  # its shortest bar is half as long as 0.09 m
WORKING = (-1, -1)


def line(duration):
    return fb.line((0.09, 0.068), (0.0, 0.1), duration)


@pytest.mark.parametrize("duration", [0.05, 2.0, 40.0])
def test_the_peak_acceleration_is_that_of_the_quintic(duration):
    """10 / sqrt 3 of the distance over the time's square, whenever the motion starts."""
    expected = 10 / np.sqrt(3) * np.hypot(0.09, 0.032) / duration**2
    assert m.peak_acceleration(line(duration), 0.0, duration) == pytest.approx(expected, rel=1e-4)


def test_the_peak_is_looked_for_where_the_motion_is_and_as_densely_as_it_is_long():
    times = []

    def reference(t):
        times.append(t)
        pulse = np.where((t > 6.99) & (t < 7.0), -3.0, 0.5)
        return 0 * t, 0 * t, np.stack([0 * t, pulse], axis=1)

    assert m.peak_acceleration(reference, 5.0, 2.0) == 3.0
    assert times[0][[0, -1]].tolist() == [5.0, 7.0] and len(times[0]) == 16_000
    m.peak_acceleration(reference, 0.0, 0.01)
    m.peak_acceleration(reference, 0.0, 1e3)
    assert [len(t) for t in times[1:]] == [1000, 40_000]


@pytest.mark.parametrize("robot,smaller", [(ROBOT, 1), (HALF, 2)])
@pytest.mark.parametrize(
    "acceleration,period",
    [(1e-3, 5e-3), (6.3, 5e-3), (6.5, 4e-3), (39, 2e-3), (150, 1e-3), (600, 5e-4), (1e9, 2.5e-4)],
)
def test_the_period_is_the_longest_whose_error_is_not_seen(robot, smaller, acceleration, period):
    """a h^2 / 8 <= 20 um of a robot of 90 mm, in proportion of a smaller one."""
    assert m.period_for(robot, acceleration / smaller) == period


def test_a_fast_motion_that_the_torque_allows_asks_for_it():
    motion = line(0.5)  # 2.2 m/s^2
    peak = m.peak_acceleration(motion, 0.0, 0.5)
    xi, xi_dot, xi_ddot = motion(np.linspace(0.0, 0.5, 20_001))
    rates = fb.ikm(fb.igm(ROBOT, xi, WORKING), xi_dot)
    needed = np.abs(fb.inverse_dynamics(fb.ikm2(rates, xi_ddot))).max()
    assert m.asks_for_it(ROBOT, motion, 0.01, None, WORKING) == peak
    assert m.asks_for_it(ROBOT, motion, 0.01, needed * 1.001, WORKING) == peak
    assert m.asks_for_it(ROBOT, motion, 0.01, needed * 0.999, WORKING) is None


def test_a_motion_that_is_slow_coarse_or_out_of_reach_does_not():
    assert m.asks_for_it(ROBOT, line(2.0), 0.01, None, WORKING) is None  # 0.14 m/s^2
    motion = line(0.5)
    peak = m.peak_acceleration(motion, 0.0, 0.5)
    coarse = np.sqrt(8 * 5e-3 * 0.09 / peak)  # whose error is 0.005 of a distal bar
    assert m.asks_for_it(ROBOT, motion, 0.999 * coarse, None, WORKING) == peak
    assert m.asks_for_it(ROBOT, motion, 1.001 * coarse, None, WORKING) is None
    away = fb.line((0.09, 0.068), (0.5, 0.1), 0.5)
    assert m.asks_for_it(ROBOT, away, 0.01, None, WORKING) is None


@pytest.mark.parametrize("robot,smaller", [(ROBOT, 1), (HALF, 2)])
@pytest.mark.parametrize("acceleration,share", [(0.0, 1), (0.3, 1), (3.0, 0.1), (30.0, 0.01)])
def test_weights_of_a_faster_motion_are_as_much_smaller(
    monkeypatch, robot, smaller, acceleration, share
):
    monkeypatch.setattr(m, "Tracker", lambda *args, **options: (args, options))
    args, options = m.matched(robot, acceleration, 1e-3, fb.Constraints(torque=2.5), 1, 2, 1e-4)
    assert args == (robot, 20, 1e-3)
    given = {name: options.pop(name) for name in ("constraints", "assembly", "delay")}
    assert given == {"constraints": fb.Constraints(torque=2.5), "assembly": 1, "delay": 2}
    assert options.pop("encoder_resolution") == 1e-4
    moved = (robot.zz1 + robot.zz2) / 2 + robot.m * max(robot.l11, robot.l21) ** 2
    expected = {
        "seconds": 0.02,
        "position": 1e4 * smaller,
        "acceleration": 10 * share,
        "torque_rate": tracker.RATE / (tracker.ARM * moved) * share,
    }
    assert options == pytest.approx(expected, rel=1e-12)


def test_a_robot_without_inertia_is_left_to_the_tracker(monkeypatch):
    """Which then says so itself."""
    monkeypatch.setattr(m, "Tracker", lambda *args, **options: options)
    massless = fb.FiveBar(zz1=0.0, zz2=0.0, m=0.0)
    assert m.matched(massless, 1.0, 1e-3, fb.Constraints(), -1)["torque_rate"] is None
