"""Both bounds of `time_path`: found again closer together they agree, and no motion is above a ceiling."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.paths.curve import Path
from fivebar.paths.pieces import Line
from fivebar.paths.timing import solve as timing_solve
from tests.helpers.paths_to_time import ROBOTS, random_limits, random_path, used

ACROSS = Path((Line((0.09, 0.06796322), (0.05, 0.0)),))


@pytest.mark.parametrize("name", ["lab", "all", "across Type 2"])
def test_closer_bounds_lie_between_wide_ones(name):
    robot, torque, centre, width = ROBOTS.get(name, ROBOTS["lab"])
    rng = np.random.default_rng(502)
    path, limits = random_path(rng, centre, width), random_limits(rng, robot, torque)
    if name == "across Type 2":
        path, limits = ACROSS, {"torque": 0.05}
    wide = fb.time_path(robot, path, gap=2e-2, constraints=fb.Constraints(**limits))
    close = fb.time_path(robot, path, gap=2e-4, constraints=fb.Constraints(**limits))
    assert wide.lower_bound <= close.lower_bound * (
        1 + 1e-6
    ) and close.duration <= wide.duration * (1 + 1e-6)
    assert close.lower_bound <= close.duration and close.gap <= 2e-4 < wide.gap
    # s'^2 of the faster motion at the other's nodes, between its own as it moves there.
    passed = np.searchsorted(close.s, wide.s[1:-1], side="right") - 1
    gone = wide.s[1:-1] - close.s[passed]
    length = np.diff(close.s)[passed]
    u0 = np.diff(close.x)[passed] / (2 * length) - close.bent[passed] * length / 2
    x = close.x[passed] + gone * (2 * u0 + close.bent[passed] * gone)
    assert (x <= wide.ceiling[1:-1] * (1 + 1e-9)).all()


def test_the_work_that_is_done_ends_the_search(monkeypatch):
    monkeypatch.setattr(timing_solve, "LOOKS", 2000)
    path, given = (
        Path((Line((0.09, 0.06796322), (0.0, 0.1)),)),
        {"gap": 1e-7, "constraints": fb.Constraints(torque=0.05)},
    )
    one, again, less = (
        fb.time_path(fb.FiveBar(), path, **given, max_time=most) for most in (60.0, 1e6, 1e-9)
    )
    assert (
        (one.x == again.x).all()
        and one.lower_bound == again.lower_bound
        and used(one, {"torque": 0.05}) <= 1
    )
    assert 1e-7 < one.gap < less.gap and len(less.x) < len(one.x)


def test_a_path_that_is_proved_impossible_is_told_from_one_that_is_not_found():
    """With gravity, just before rest beyond Type 2, no torque of this size slows the motion that the crossing needs."""
    heavy = fb.FiveBar(gravity=(0.0, -9.81))
    with pytest.raises(
        fb.TimingError, match="no motion along the path keeps these limits"
    ) as caught:
        fb.time_path(heavy, ACROSS, constraints=fb.Constraints(torque=1.0))
    assert caught.value.proved and 0.06 < caught.value.s < ACROSS.length


@pytest.mark.parametrize("seed", [5, 27, 31])
def test_type_2_is_crossed_under_gravity_at_the_speed_that_it_needs(seed):
    """There the robot cannot be held at rest: it has to pass, and the criterion has a constant part."""
    robot, limits = fb.FiveBar(gravity=(0.0, -3.0)), {"torque": 1.0}
    start, goal = (
        np.array([0.05, 0.03]) + np.random.default_rng(0).uniform(-0.06, 0.06, (seed + 1, 2, 2))
    )[-1]
    motion = fb.time_path(
        robot, Path((Line(tuple(start), tuple(goal)),)), constraints=fb.Constraints(**limits)
    )
    assert motion.crossing.sum() == 1 and motion.gap <= 1e-3 and used(motion, limits, 30) <= 1
    assert fb.check_path(robot, motion).criterion_holds
