"""The search of least times in its steps: both bounds meet after little work, and motions keep their limits."""

import math
import time

import numpy as np
import pytest

import fivebar as fb
from fivebar.paths.curve import Path
from fivebar.paths.timing import solve as solve_module
from fivebar.paths.timing.constraint_rows import Limits
from fivebar.paths.timing.lower_bound import Ceiling
from fivebar.paths.timing.mesh import mesh_of
from fivebar.paths.timing.solve import Solved, TimingError, refined
from fivebar.paths.timing.time_path import _timed
from tests.helpers.paths_to_time import ROBOTS, random_limits, random_path, used
from tests.paths.test_polygons import CASES


@pytest.mark.every(2)
@pytest.mark.parametrize(
    "name, gap, looks",
    [
        ("torques", 1e-3, 1650),
        ("accelerations", 1e-3, 1700),
        ("across Type 2", 1e-2, 3600),
        ("elbows", 0.03, 5000),
        ("along the bars", 1e-3, 1100),
    ],
)
def test_both_bounds_meet_after_few_looks_at_stretches(name, gap, looks):
    """Where the last motion helps to bound the next one; else it would be many times as many."""
    robot, path, limits = CASES[name]
    mesh = mesh_of(robot, path, (-1, -1))
    mesh, found = refined(mesh, limits, gap, time.thread_time() + 3.0)
    motion = _timed(limits, mesh, found)
    assert 0 < motion.gap <= gap and found.looks <= looks
    asked = {key: getattr(limits, key) for key in ("torque", "joint_acceleration", "acceleration")}
    assert used(motion, {key: value for key, value in asked.items() if value}, 10) <= 1
    assert math.isfinite(motion.duration)


LIMITS = fb.Constraints(torque=0.1)


@pytest.fixture(scope="module")
def resting():
    """A path with rests, and its fastest motion."""
    robot, path, _ = CASES["torques"]
    path = Path(path.pieces, dwells={0.0: 0.25, path.length: 0.5})
    return path, fb.time_path(robot, path, constraints=LIMITS)


def test_a_wanted_duration_counts_the_rests(resting):
    """They are the same in all motions."""
    path, plain = resting
    assert 0.999 * plain.duration < plain.lower_bound < plain.duration
    slow = fb.time_path(fb.FiveBar(), path, 1.5, constraints=LIMITS)
    assert slow.duration == pytest.approx(1.5) and slow.lower_bound == plain.lower_bound
    np.testing.assert_allclose(slow.ceiling, plain.ceiling)
    share = ((plain.duration - 0.75) / 0.75) ** 2
    assert used(slow, {"torque": 0.1}, 10) == pytest.approx(share, rel=0.01)


@pytest.mark.deep
def test_a_wanted_duration_without_limits_takes_the_least_torque(resting):
    path, plain = resting
    free = fb.time_path(fb.FiveBar(), path, 1.5)
    assert free.duration == pytest.approx(1.5) and free.lower_bound == 0.0
    share = ((plain.duration - 0.75) / 0.75) ** 2
    assert used(free, {"torque": 0.1 * share}, 10) == pytest.approx(1.0, rel=0.02)


def test_a_wanted_duration_that_is_too_short_is_told_the_bounds(resting):
    path, plain = resting
    lower = plain.lower_bound
    between = (lower + plain.duration) / 2
    words = {
        1.0: f"1 s is {lower - 1:.4g} s below what is proved to be the least, {lower:.6g} s",
        between: f"{between:g} s is less than {plain.duration:.6g} s, the least that was found"
        f" (proved: none below {lower:.6g} s)",
    }
    for duration, text in words.items():
        with pytest.raises(TimingError) as short:
            fb.time_path(fb.FiveBar(), path, duration, constraints=LIMITS)
        assert str(short.value) == f"time_path: duration = {text}, under these limits"
        assert short.value.proved == (duration == 1.0) and short.value.s == 0.0
    with pytest.raises(
        ValueError, match="rests for 0.75 s, which leaves no time to move in 0.75 s"
    ):
        fb.time_path(fb.FiveBar(), path, 0.75, constraints=LIMITS)
    with pytest.raises(ValueError, match="a least time needs a torque, an acceleration, a joint"):
        fb.time_path(fb.FiveBar(), path, constraints=fb.Constraints(speed=1.0))


def test_constraints_on_poses_are_looked_at_first():
    robot, path, _ = CASES["torques"]
    below = fb.Constraints(torque=0.1, half_planes=[(0.0, -1.0, -0.11)])  # y <= 0.11
    with pytest.raises(
        ValueError, match=r"^time_path: .* is not kept from s = .*, joint C at \("
    ) as refused:
        fb.time_path(robot, path, constraints=below)
    words = str(refused.value)
    begins = float(words.split("from s = ")[1].split(" m")[0])
    assert path(begins)[0][1] == pytest.approx(0.11, abs=1e-8)
    top = np.linspace(0, path.length, 20_001)
    assert f"by at most {path(top)[0][:, 1].max() - 0.11:.4g}"[:-1] in words
    above = fb.Constraints(torque=0.1, half_planes=[(0.0, 1.0, 0.05)])
    assert fb.time_path(robot, path, constraints=above).duration < 1


def test_a_search_ends_after_its_work(monkeypatch):
    robot, path, limits = CASES["torques"]
    mesh = mesh_of(robot, path, (-1, -1))
    monkeypatch.setattr(solve_module, "LOOKS", 2000)
    monkeypatch.setattr(solve_module, "WORK", 0)
    split, found = refined(mesh, limits, 1e-7, math.inf)
    assert len(mesh) < len(split) < 500 and found.looks <= 2000
    monkeypatch.setattr(solve_module, "solve", lambda mesh, *given: nothing(mesh))
    seen = []

    def nothing(mesh):
        seen.append(len(mesh))
        none = np.zeros(len(mesh))
        nodes = np.zeros(len(mesh) + 1)
        above = Ceiling(nodes, none + 1, none, none, None)
        return Solved(above, nodes, nodes, none, none + np.inf, (7,), 3 * len(mesh))

    monkeypatch.setattr(solve_module, "LOOKS", 3 * 15 * len(mesh))
    with pytest.raises(
        TimingError, match="no motion along the path was found that keeps"
    ) as failed:
        refined(mesh, limits, 1e-3, math.inf)
    first = len(mesh)
    assert seen == [first, 2 * first, 4 * first, 8 * first] and not failed.value.proved
    assert failed.value.s == mesh.s[7] or failed.value.s < mesh.s[7]


STAR = (
    (40, 5),
    (50, 30),
    (75, 30),
    (55, 42),
    (62, 58),
    (40, 48),
    (18, 58),
    (25, 42),
    (5, 30),
    (30, 30),
)  # mm
USUAL = {"speed": 0.1, "acceleration": 0.5}  # of `fivebar draw`


@pytest.fixture(scope="module")
def star():
    """A star of ten corners, rounded by 20 um at most."""
    corners = np.array([*STAR, STAR[0]]) * [1e-3, -1e-3] + [-0.04, 0.095]
    return fb.path(corners, deviation=2e-5)


def test_a_star_with_small_blends_is_timed_within_a_thousandth(star):
    """It took 77 s once, where 5 are possible: on stretches beside blends no motion was found."""
    motion = fb.time_path(fb.FiveBar(), star, constraints=fb.Constraints(**USUAL))
    assert 0 < motion.gap <= 1e-3
    assert used(motion, {"acceleration": 0.5}, 20) <= 1
    speed = np.linalg.norm(motion(np.linspace(0, motion.duration, 20001))[1], axis=1)
    assert speed.max() <= 0.1


def test_a_motion_far_from_its_bound_comes_with_a_warning(star, monkeypatch):
    monkeypatch.setattr(solve_module, "LOOKS", 0)
    monkeypatch.setattr(solve_module, "WORK", 0)
    with pytest.warns(RuntimeWarning, match="motion takes .* % over the bound: it is proved only"):
        motion = fb.time_path(fb.FiveBar(), star, constraints=fb.Constraints(**USUAL))
    assert motion.gap > 0.01
    # A larger gap was asked for.
    fb.time_path(fb.FiveBar(), star, constraints=fb.Constraints(**USUAL), gap=0.9)


def test_a_search_without_a_motion_says_that_its_time_ran_out():
    """On the first mesh there is none; it is not told as if none kept the limits."""
    robot, torque, centre, width = ROBOTS["rubbing"]
    rng = np.random.default_rng(3)
    path, limits = random_path(rng, centre, width), random_limits(rng, robot, torque)
    with pytest.raises(TimingError, match="max_time ran out before a motion .* was found") as late:
        fb.time_path(robot, path, constraints=fb.Constraints(**limits), max_time=1e-9)
    assert not late.value.proved


@pytest.mark.deep
def test_work_grows_as_the_number_of_pieces():
    """A zigzag in one stroke, with blends: within a thousandth, and as many looks for each piece."""
    looks = []
    for corners in (50, 200):
        x = np.linspace(-0.03, 0.03, corners)
        y = np.where(np.arange(corners) % 2, 0.1, 0.105)
        path = fb.path(np.stack([x, y], axis=1), deviation=1e-5)
        mesh = mesh_of(fb.FiveBar(), path, (-1, -1))
        limits = Limits(speed=0.1, acceleration=2.0)
        mesh, found = refined(mesh, limits, 1e-3, math.inf)
        assert found.gap <= 1e-3
        looks.append(found.looks / len(path.pieces))
    assert looks[1] < 1.3 * looks[0] < 1000


@pytest.mark.deep
def test_a_jerk_limit_slows_small_blends_down(star):
    """All of it was slowed to the pace of the blends: 56 s, where the bound without jerk is 4.3 s;
    the mean of a long while passed them too fast: 14 s.
    """
    path = fb.path(
        np.array([*STAR, STAR[0]]) * [1e-3, -1e-3] + [-0.04, 0.095], deviation=2e-5, curvature=True
    )
    limits = fb.Constraints(**USUAL, jerk=5.0)
    motion = fb.time_path(fb.FiveBar(), path, constraints=limits, gap=1e-2)
    assert motion.duration < 9 and motion.path is path
    t = np.linspace(0, motion.duration, 40_001)
    rises = np.linalg.norm(np.diff(motion(t)[2], axis=0), axis=1) / t[1]
    assert np.sort(rises)[-200] <= 5.0 * 1.001  # but where it jumps


def test_a_jerk_limit_far_below_the_accelerations_is_warned_of():
    path = fb.path([(0.05, 0.09), (0.06, 0.09), (0.06, 0.1)], deviation=1e-4)
    limits = fb.Constraints(**USUAL, jerk=0.05)
    words = "that of .* s leaves the limit on jerk out. .*, or none, with which it rests there"
    with pytest.warns(RuntimeWarning, match=words):
        fb.time_path(fb.FiveBar(), path, constraints=limits, gap=1e-2)


@pytest.mark.every(2)
@pytest.mark.parametrize("jerk, share", [(20.0, 1.3), (200.0, 1.05)])
def test_tiny_blends_cost_little_more_than_rests_at_the_corners(jerk, share):
    """They took 7 and 3 times as long: the mean passed the blends too fast, so all of it was slowed down."""
    angle = np.linspace(0, 2 * np.pi, 11)
    wide = 0.03 * np.cos(angle) * (1 + 0.2 * np.cos(2.3 * angle))
    high = 0.12 + 0.02 * np.sin(angle) * (1 - 0.1 * angle / 6)
    paths = [fb.path(np.column_stack([wide, high]), deviation=off) for off in (0.0, 5e-6)]
    robot = fb.FiveBar(l11=0.08, l12=0.1, l21=0.08, l22=0.1, d=0.06)
    limits = fb.Constraints(speed=0.2, acceleration=3.0, jerk=jerk)
    timed = [fb.time_path(robot, path, constraints=limits, working=(1, -1)) for path in paths]
    at_rest, motion = timed
    assert motion.duration < share * at_rest.duration
    t = np.linspace(0, motion.duration, 100_001)
    rises = np.linalg.norm(np.diff(motion(t)[2], axis=0), axis=1) / t[1]
    assert np.sort(rises)[-200] <= jerk


@pytest.mark.parametrize("speed, duration", [(None, None), (0.2, None), (None, 0.5)])
def test_a_jerk_limit_alone_gives_a_least_time(speed, duration):
    """Of a straight way T = (32 L / j)^(1/3), or L / v + 2 sqrt(v / j)."""
    path = fb.path([(0.0, 0.1), (0.04, 0.1)])
    limits = fb.Constraints(jerk=400.0, speed=speed)
    motion = fb.time_path(fb.FiveBar(), path, duration, constraints=limits)
    least = 0.04 / speed + 2 * math.sqrt(speed / 400) if speed else (32 * 0.04 / 400) ** (1 / 3)
    assert motion.lower_bound == 0.0 and least < motion.duration
    assert (
        motion.duration < 0.501 if duration else motion.duration < (1.01 if speed else 1.2) * least
    )
    t = np.linspace(0, motion.duration, 20_001)
    rises = np.linalg.norm(np.diff(motion(t)[2], axis=0), axis=1) / t[1]
    assert np.sort(rises)[-20] <= 400.0
