"""Least times across Type 2 with viscous and dry friction in motors and elbows: both bounds meet."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.paths.curve import Path
from fivebar.paths.pieces import Line
from tests.helpers.paths_to_time import bezier, used


def case(seed, friction, crossings):
    """A random robot, its working mode, a path across Type 2 so many times at least, and a torque."""
    rng = np.random.default_rng(seed)
    while True:
        lengths = rng.uniform(0.07, 0.14, 4).tolist()
        d = float(rng.uniform(0.06, 0.15))
        motors, elbows = rng.uniform(0, friction, 4), rng.uniform(0, friction / 2, 2)
        robot = fb.FiveBar(
            *lengths,
            d,
            *rng.uniform(5e-4, 3e-3, 2).tolist(),
            float(rng.uniform(0.2, 0.8)),
            **dict(zip(("fv1", "fv2", "fs1", "fs2"), motors.tolist())),
            **dict(zip(("fv12", "fv22"), elbows.tolist())),
        )
        working = tuple(int(mode) for mode in rng.choice([-1, 1], 2))
        points = rng.uniform(-0.12, 0.12, (rng.integers(2, 5), 2)) + [0, 0.05]
        if len(points) == 2:
            path = Path((Line(tuple(points[0]), tuple(points[1])),))
        else:
            size = float(np.abs(np.diff(points, axis=0)).sum())
            path = Path((bezier([tuple(point) for point in points], size),))
        s = np.linspace(0, path.length, 2000)
        pose = fb.igm(robot, path(s)[0], working, unreachable="nan")
        det = pose.det_A
        if not np.isfinite(det).all() or min(np.abs(sine).min() for sine in pose.sines) < 0.15:
            continue
        signs = np.count_nonzero(np.diff(np.sign(det)))
        if signs < crossings or abs(det[0]) < 0.1 or abs(det[-1]) < 0.1:
            continue
        return robot, working, path, float(rng.uniform(0.03, 0.3))


def both_bounds_meet(seed, friction, crossings):
    robot, working, path, torque = case(seed, friction, crossings)
    motion = fb.time_path(
        robot, path, constraints=fb.Constraints(torque=torque), working=working, max_time=300.0
    )
    assert motion.lower_bound <= motion.duration <= 1.005 * motion.lower_bound
    assert used(motion, {"torque": torque}) <= 1


@pytest.mark.every(3)
@pytest.mark.parametrize("seed", [105, 118, 134])
def test_one_crossing(seed):
    both_bounds_meet(seed, 0.02, 1)


@pytest.mark.deep
@pytest.mark.parametrize(("seed", "friction"), [(150, 0.02), (314, 0.05), (324, 0.05)])
def test_between_two_crossings_friction_takes_speed(seed, friction):
    """Gaps of 25 %, 13 % and a refusal, as long as a torque that hardly accelerates bounded x loosely, and as x
    was lowered by one share on both crossings."""
    both_bounds_meet(seed, friction, 1 if seed == 150 else 2)


@pytest.mark.deep
def test_speeds_beside_type_2_that_friction_leaves_out():
    """A gap of 7.7 %: beside the crossing no acceleration is feasible from x = 0.009 up to a large x, where one is
    again, which no motion reaches. By collocation the least time is 0.8198 to 0.8204 s."""
    both_bounds_meet(121, 0.02, 1)


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(400, 416))
def test_light_friction(seed):
    both_bounds_meet(seed, 0.004, 2)


@pytest.mark.parametrize("friction", [(0.01, 0.02), (0.03, 0.005)])
def test_at_its_ends_a_motion_has_the_friction_of_moving(friction):
    """The limit holds to the very last instant, and the torques are those of a moment before."""
    fs1, fs2 = friction
    robot = fb.FiveBar(0.08, 0.11, 0.1, 0.095, 0.12, 0.001, 0.002, 0.4, fs1=fs1, fs2=fs2)
    path = fb.path([(-0.03, 0.12), (0.03, 0.12), (0.03, 0.14)])
    motion = fb.time_path(robot, path, constraints=fb.Constraints(torque=0.8), working=(1, -1))
    end = motion.duration
    inner = np.array([1e-9, end - 1e-9])
    assert np.abs(motion.torques(np.array([0.0, end])) - motion.torques(inner)).max() < 1e-5
    assert np.abs(motion.torques(np.append(motion.times, end))).max() < 0.8 + 1e-9
    stands = motion.torques(np.array([-1.0, end + 1.0]))
    assert np.abs(stands).max() == 0.0
