"""`time_path`: known least times, limits between the nodes, both bounds, crossings of Type 2, what it refuses."""

import io
import math
import os
import warnings

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import beta

import fivebar as fb
from fivebar.paths.curve import Path
from fivebar.paths.pieces import Arc, Line
from fivebar.paths.timing.jerk import refuse_kinks
from tests.helpers.paths_to_time import (
    ELBOWS,
    ROBOTS,
    almost_along_the_bars,
    random_limits,
    random_path,
    used,
)

ROBOT = fb.FiveBar()
HOME = (0.09, 0.06796322)
REGULAR = Path((Line(HOME, (0.0, 0.1)),))  # control task 1 of the lab
ACROSS = Path((Line(HOME, (0.05, 0.0)),))  # and 2, which passes Type 2
NIGHTLY = os.environ.get("FIVEBAR_NIGHTLY") == "1"
CROSSING = brentq(lambda x: fb.igm(ROBOT, (x, 0.05)).det_A, -0.09, -0.085, xtol=1e-16), 0.05


def encloses(motion, least, share=1e-8):
    return motion.lower_bound <= least * (1 + share) and least <= motion.duration * (1 + share)


def test_a_line_under_an_acceleration_limit_alone():
    motion = fb.time_path(ROBOT, REGULAR, constraints=fb.Constraints(acceleration=5.0))
    assert encloses(motion, 2 * math.sqrt(REGULAR.length / 5.0)) and motion.gap < 1e-6


def test_a_line_under_a_speed_limit_too():
    motion = fb.time_path(ROBOT, REGULAR, constraints=fb.Constraints(acceleration=5.0, speed=0.3))
    assert encloses(motion, REGULAR.length / 0.3 + 0.3 / 5.0) and motion.gap < 1e-3


def test_an_arc_under_an_acceleration_limit_alone():
    """u = sqrt(a^2 - (x / r)^2): x = a r sin(2 s / r) until all of it is needed to turn; then at an even speed."""
    radius, limit = 0.02, 5.0
    path = Path((Arc((0.0, 0.13), radius, 0.3, 6.5),))
    start = radius * math.pi / 4
    least = 2 * (radius / 2) * beta(0.25, 0.5) / 2 / math.sqrt(limit * radius)
    least += (path.length - 2 * start) / math.sqrt(limit * radius)
    motion = fb.time_path(ROBOT, path, constraints=fb.Constraints(acceleration=limit))
    assert encloses(motion, least) and motion.gap <= 1e-3


def test_a_drive_alone_that_is_accelerated_to_the_middle():
    """Without an end-effector a leg's torque is its inertia times q'': along its circle 2 sqrt(Z angle / tau)."""
    robot = fb.FiveBar(m=0.0)
    pose = fb.dgm(robot, np.stack([np.linspace(0.0, -0.5, 60), np.zeros(60)], axis=-1))
    elbow = pose.elbows[0, 1]
    angles = np.unwrap(np.arctan2(*(pose.xi - elbow).T[::-1]))
    path = Path((Arc(tuple(elbow), 0.09, angles[0], angles[-1]),))
    motion = fb.time_path(robot, path, constraints=fb.Constraints(torque=0.01))
    assert encloses(motion, 2 * math.sqrt(robot.zz1 * 0.5 / 0.01)) and motion.gap <= 1e-3


def timed_at_random(robot, torque, centre, width, seeds):
    """[TimedPath] of random paths, which keep their limits; at most one in 50 is timed worse than to 1e-3."""
    found, misses = [], []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        path, limits = random_path(rng, centre, width), random_limits(rng, robot, torque)
        try:
            motion = fb.time_path(robot, path, constraints=fb.Constraints(**limits))
        except (fb.UnreachableError, fb.SingularityError):
            continue
        except fb.TimingError as error:
            misses.append((seed, str(error)))
            continue
        found.append(motion)
        assert used(motion, limits, 100 if NIGHTLY else 30) <= 1.0, (seed, motion)
        assert motion.gap > 0, (seed, motion)
        if motion.gap > 1e-3:
            misses.append((seed, motion.gap, motion))
    assert len(misses) <= len(seeds) // 50, misses
    return found


@pytest.mark.every(6)
@pytest.mark.parametrize("name", ROBOTS)
def test_random_paths_keep_their_limits_between_nodes_and_are_timed_to_a_thousandth(name):
    seeds = range(100 if NIGHTLY else 3)
    assert len(timed_at_random(*ROBOTS[name], seeds)) >= len(seeds) - 1


@pytest.mark.deep
@pytest.mark.parametrize(
    ("robot", "some"),
    [(ROBOT, (0, 6, 13, 16)), (ROBOTS["rubbing"][0], (33, 111)), (ELBOWS, (40,))],
    ids=["lab", "rubbing", "with friction in the criterion"],
)
def test_random_paths_across_type_2_keep_their_limits(robot, some):
    found = timed_at_random(robot, 0.1, (0.03, 0.03), 0.05, range(60) if NIGHTLY else some)
    assert len(found) >= len(some) and sum(motion.crossing.sum() for motion in found) >= len(some)


@pytest.mark.parametrize("path", [REGULAR, ACROSS], ids=["regular", "across Type 2"])
def test_the_path_is_followed_by_a_continuous_motion(path):
    motion = fb.time_path(ROBOT, path, constraints=fb.Constraints(torque=0.1))
    t = np.linspace(0.0, motion.duration, 4001)
    xi, xi_dot, xi_ddot = motion(t)
    direction = (path.pieces[0].end - np.array(HOME)) / path.length
    off = (xi - HOME) @ np.array([-direction[1], direction[0]])
    assert np.abs(off).max() < 1e-15
    step = t[1] - t[0]
    assert np.abs(np.diff(xi, axis=0) / step - (xi_dot[1:] + xi_dot[:-1]) / 2).max() < 1e-4
    assert (
        np.abs(np.cumsum((xi_ddot[1:] + xi_ddot[:-1]) / 2 * step, axis=0) - xi_dot[1:]).max() < 1e-3
    )
    assert np.abs(xi_dot[[0, -1]]).max() < 1e-15 and np.allclose(
        xi[-1], path.pieces[0].end, atol=1e-15
    )
    before, after = motion(-1.0), motion(motion.duration + 1.0)
    assert (
        (before[1] == 0).all()
        and (after[2] == 0).all()
        and np.allclose(after[0], xi[-1], atol=1e-15)
    )


def test_type_2_is_crossed_by_the_criterion_with_finite_torque():
    motion = fb.time_path(ROBOT, ACROSS, constraints=fb.Constraints(torque=0.1))
    found = fb.check_path(ROBOT, motion)
    assert found.type == fb.Singularity.PARALLEL and found.criterion_holds and motion.gap < 1e-3
    at = motion.times[motion.crossing][0]
    assert abs(found.time - at) < 1e-9
    # Torques beside it agree with the inverse model where this has digits, and reach on to it from either side.
    for side in (-1, 1):
        near, far = motion.torques(at + side * np.array([1e-9, 1e-6]))
        assert np.abs(near - far).max() < 1e-3 and np.abs(
            motion.torques(at + side * 1e-9)
        ).max() <= 0.1 * (1 + 1e-6)


@pytest.mark.deep
def test_a_path_through_type_2_is_replayed_within_its_torques():
    motion = fb.time_path(
        ROBOT, ACROSS, constraints=fb.Constraints(torque=0.0195)
    )  # what is left is the controller's
    controller = fb.FeedForward(ROBOT, 0.2, 0.01, ahead=0.0005)
    run = fb.simulate(
        ROBOT, controller, motion, control_period=0.001, duration=motion.duration + 0.05
    )
    assert np.linalg.norm(run.error, axis=-1).max() < 1e-4
    assert np.abs(run.tau).max() < 0.02


@pytest.mark.parametrize("size", [1e-4, 1.0, 1e4])
def test_curvature_jumps_or_does_not_whatever_the_size(size):
    corners = size * np.array([(0, 0), (1, 0), (1, 1), (2, 1.5)])
    refuse_kinks(fb.path(corners, deviation=0.05 * size, curvature=True))
    quarter = Arc((size, size), size, -math.pi / 2, 0.0)
    with pytest.raises(ValueError, match="curvature does not jump, as it does at s = "):
        refuse_kinks(Path((Line((0.0, 0.0), (size, 0.0)), quarter)))


@pytest.mark.deep
def test_paths_along_the_bars_cross_without_a_criterion_or_not_at_all():
    along = np.array(fb.igm(ROBOT, CROSSING).u2[0])
    across = np.array([-along[1], along[0]])
    straight = Path((Line(tuple(CROSSING - 0.02 * along), tuple(CROSSING + 0.015 * along)),))
    limits = {"torque": 0.05}
    motion = fb.time_path(ROBOT, straight, constraints=fb.Constraints(**limits))
    assert motion.crossing.sum() == 1 and motion.gap < 1e-3 and used(motion, limits) <= 1
    for angle in (-1e-2, 1e-7):  # that of 1e-4 is timed in test_timing_by_collocation
        motion = fb.time_path(
            ROBOT, almost_along_the_bars(angle), constraints=fb.Constraints(**limits)
        )
        assert motion.crossing.sum() == 1 and motion.gap < 1e-3 and used(motion, limits) <= 1
    with pytest.raises(fb.SingularityError, match=r"along the distal bars .* at s = 0\.02 m"):
        fb.time_path(ROBOT, almost_along_the_bars(0.0), constraints=fb.Constraints(**limits))
    graze = Path((Line(tuple(CROSSING - 0.02 * across), tuple(CROSSING + 0.015 * across)),))
    with pytest.raises(fb.SingularityError, match=r"grazes Type 2 .* at s = 0\.0(2|19999\d*) m"):
        fb.time_path(ROBOT, graze, constraints=fb.Constraints(**limits))
    first = Line(HOME, CROSSING)
    toward = np.subtract(HOME, CROSSING)
    almost = Line(HOME, tuple(CROSSING + 1e-8 * toward / np.linalg.norm(toward)))
    for pieces in (
        (first, Line(CROSSING, (-0.09, 0.1))),
        (first,),
        (Line(CROSSING, HOME),),
        (almost,),
    ):
        with pytest.raises(fb.SingularityError, match="rests on Type 2 at s = "):
            fb.time_path(ROBOT, Path(pieces), constraints=fb.Constraints(**limits))


@pytest.mark.deep
def test_a_given_duration_takes_the_least_share_of_the_torques():
    for path in (REGULAR, ACROSS):
        least = fb.time_path(ROBOT, path, constraints=fb.Constraints(torque=0.1))
        slow = fb.time_path(ROBOT, path, 2 * least.duration, constraints=fb.Constraints(torque=0.1))
        free = fb.time_path(ROBOT, path, 2 * least.duration)
        t = np.linspace(0, slow.duration, 5001)
        assert slow.duration == pytest.approx(2 * least.duration, rel=1e-12) == free.duration
        assert (
            slow.lower_bound == pytest.approx(least.lower_bound, rel=1e-3) and free.lower_bound == 0
        )
        for motion in (
            slow,
            free,
        ):  # without friction and gravity, torques go as the square of the pace
            assert np.abs(motion.torques(t)).max() == pytest.approx(0.025, rel=2e-3)
    with pytest.raises(
        fb.TimingError, match=r"is 0\.2\d* s below what is proved to be the least, 0\.48"
    ):
        fb.time_path(ROBOT, REGULAR, 0.25, constraints=fb.Constraints(torque=0.1))


@pytest.mark.deep
def test_a_duration_for_a_robot_with_gravity_and_friction():
    robot, _, _, _ = ROBOTS["all"]
    path = Path((Arc((0.0, 0.1), 0.02, 0.3, 3.5),))
    for duration in (0.4, 5.0):
        motion = fb.time_path(robot, path, duration, constraints=fb.Constraints(torque=1.0))
        assert motion.duration == pytest.approx(duration, rel=1e-12)
        assert used(motion, {"torque": 1.0}) <= 1


def test_stops_dwells_and_feeds_of_the_path():
    corner = (0.06, 0.08)
    pieces = Line(HOME, corner), Line(corner, (0.05, 0.1))
    motion = fb.time_path(
        ROBOT,
        Path(pieces, dwells={pieces[0].length: 0.25}, feed=(np.inf, 0.02)),
        constraints=fb.Constraints(torque=0.1),
    )
    bare = fb.time_path(ROBOT, Path(pieces), constraints=fb.Constraints(torque=0.1))
    reached = motion.times[np.abs(motion.s - pieces[0].length).argmin()]
    assert (
        np.allclose(motion(reached - 0.1)[0], corner, atol=1e-12)
        and (motion(reached - 0.1)[1] == 0).all()
    )
    assert motion.duration > bare.duration + 0.25 + 0.8
    t = np.linspace(reached, motion.duration, 1001)
    assert np.linalg.norm(motion(t)[1], axis=1).max() == pytest.approx(0.02, rel=1e-6)


def test_a_timed_path_is_saved_with_its_first_and_last_instant():
    motion = fb.time_path(ROBOT, ACROSS, constraints=fb.Constraints(torque=0.1))
    file = io.StringIO()
    motion.to_csv(file, rate=200.0)
    rows = [line.split(",") for line in file.getvalue().splitlines()[2:]]
    assert float(rows[0][0]) == 0.0 and float(rows[-1][0]) == motion.duration
    assert np.allclose(np.array(rows[-1][1:3], float), ACROSS.pieces[0].end, atol=1e-15)
    assert "crosses Type 2 1 x" in repr(motion)


@pytest.mark.deep
def test_the_picture_shows_the_motion_under_its_curves():
    figure = fb.time_path(ROBOT, ACROSS, constraints=fb.Constraints(torque=0.1)).plot()
    titles = [axes.get_title() for axes in figure.axes]
    assert any("proved: none below" in title for title in titles) and "torques" in titles


def jerks(motion):
    """|xi'''| as differences of xi'' show it."""
    t = np.linspace(0.0, motion.duration, 100001)
    return np.linalg.norm(np.diff(motion(t)[2], axis=0), axis=1) / (t[1] - t[0])


@pytest.mark.deep
def test_a_jerk_limit_on_a_line_comes_near_the_known_least_time():
    """T = a / J + sqrt((a / J)^2 + 4 L / a) where the acceleration is reached."""
    motion = fb.time_path(ROBOT, REGULAR, constraints=fb.Constraints(acceleration=5.0, jerk=100.0))
    least = 0.05 + math.sqrt(0.05**2 + 4 * REGULAR.length / 5.0)
    assert motion.lower_bound < least < motion.duration < 1.01 * least
    assert 90 < jerks(motion).max() <= 100 and used(motion, {"acceleration": 5.0}) <= 1
    slow = fb.time_path(
        ROBOT, REGULAR, 0.5, constraints=fb.Constraints(acceleration=5.0, jerk=100.0)
    )
    assert slow.duration == pytest.approx(0.5, rel=1e-12) and jerks(slow).max() < 60
    with pytest.raises(fb.TimingError, match="the least that was found with this jerk limit"):
        fb.time_path(ROBOT, REGULAR, 0.33, constraints=fb.Constraints(acceleration=5.0, jerk=100.0))


@pytest.mark.deep
@pytest.mark.parametrize(
    "speed, limits",
    [(1.0, {}), (0.1, {"torque": 20.0}), (1.0, {"acceleration": 0.7}), (0.1, {"acceleration": 50})],
)
def test_a_jerk_limit_that_rules_gives_s_curves(speed, limits):
    """Each straight way L takes L / v + 2 sqrt(v / j), or 4 (L / 2 j)^(1/3) where v is not reached,
    whatever larger force is there.
    """
    robot = fb.FiveBar(0.12, 0.16, 0.12, 0.16, 0.1, zz1=2e-4, zz2=2e-4, m=0.1)
    corner = fb.path([(-0.05, 0.2), (0.05, 0.2), (0.05, 0.22)])
    constraints = fb.Constraints(speed=speed, jerk=2.0, **limits)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # The bound leaves the jerk out.
        motion = fb.time_path(robot, corner, constraints=constraints, working=(1, -1))
    least = 0.0
    for way in (0.1, 0.02):
        top = min(speed, np.cbrt(2.0 * way**2 / 4))
        least += way / top + 2 * np.sqrt(top / 2.0)
    assert 1 - 1e-6 < motion.duration / least < 1.05
    assert jerks(motion).max() <= 2.0 and used(motion, {"speed": speed, **limits}, 30) <= 1
    assert motion.lower_bound < motion.duration


def test_a_jerk_limit_with_a_stop_on_the_way():
    corner = (0.04, 0.1)
    pieces = Line(HOME, corner), Line(corner, (0.04, 0.06))
    limits = {"torque": 0.1}
    motion = fb.time_path(
        ROBOT,
        Path(pieces, dwells={pieces[0].length: 0.1}),
        constraints=fb.Constraints(jerk=50.0, **limits),
    )
    assert jerks(motion).max() <= 50 and used(motion, limits, 30) <= 1
    at = motion.times[np.abs(motion.s - pieces[0].length).argmin()]
    rest = motion(at - np.linspace(1e-6, 0.1 - 1e-6, 11))
    assert np.abs(rest[0] - corner).max() < 1e-12 and np.abs(rest[1]).max() < 1e-9
    t = np.linspace(0.0, motion.duration, 20001)
    xi, xi_dot, _ = motion(t)
    assert np.abs(np.diff(xi, axis=0) / t[1] - (xi_dot[1:] + xi_dot[:-1]) / 2).max() < 1e-7
    # A corner that is blended: where the curvature should be 0, on both sides of a blend, rounding is no jump of it.
    blended = fb.path([(0.05, 0.07), (0.08, 0.07), (0.08, 0.1)], deviation=1e-3, curvature=True)
    assert (
        jerks(fb.time_path(ROBOT, blended, constraints=fb.Constraints(jerk=50.0, **limits))).max()
        <= 50
    )


KINKED = Path((Line((0.0, 0.07), (0.02, 0.07)), Arc((0.02, 0.09), 0.02, -math.pi / 2, 0.0)))
VERTICAL = ROBOTS["vertical"][0]
REFUSED = [
    (dict(path=ACROSS), dict(jerk=10.0), fb.SingularityError, "not known across Type 2"),
    (dict(path=KINKED), dict(jerk=10.0), ValueError, r"curvature does not jump.* s = 0\.02 m"),
    (
        dict(path=Path((Line(HOME, (0.3, 0.1)),))),
        {},
        fb.UnreachableError,
        "leaves the workspace before s = .*left leg",
    ),
    ({}, dict(torque=None), ValueError, "a least time needs a torque"),
    (dict(robot=fb.ROBOTS["plotclock"].robot), {}, ValueError, "no masses, so a torque limits"),
    (dict(duration=-1.0), {}, ValueError, "duration must be"),
    (dict(path="square.svg"), {}, TypeError, "path must be a Path"),
    (dict(working=(1, 2)), {}, ValueError, "working"),
    ({}, dict(clearance=0.01), ValueError, "time_path: the constraint clearance is not kept"),
    (
        dict(robot=VERTICAL),
        dict(torque=0.05),
        fb.TimingError,
        "no motion along the path keeps these limits near s = 0 m of .*, joint C at .* in the"
        " robot's own frame: to hold it there against gravity takes .* N m, and the limit is 0.05,",
    ),
    (
        dict(robot=VERTICAL, path=Path((Line((-0.05, 0.06), (0.05, 0.14)),))),
        dict(torque=0.29),
        fb.TimingError,
        "no motion along the path .*keeps these limits near s = ",
    ),
]


@pytest.mark.parametrize(("given", "limits", "error", "words"), REFUSED)
def test_what_cannot_be_timed_is_said_with_its_place(given, limits, error, words):
    constraints = fb.Constraints(**{"torque": 0.1} | limits)
    usual = {"robot": ROBOT, "path": REGULAR, "constraints": constraints}
    with pytest.raises(error, match=words):
        fb.time_path(**usual | given)


def test_what_must_be_kept_is_looked_at_first():
    robot, path = fb.FiveBar(), fb.path([(0.05, 0.1), (-0.05, 0.1)])
    above = fb.Constraints(
        torque=0.05, half_planes=((0, 1, 0.05),), joints=((-math.pi, math.pi), None)
    )
    assert fb.time_path(robot, path, constraints=above).duration > 0
    with pytest.raises(
        ValueError, match=r"1 x \+ 0 y >= 0 m is not kept from s = 0\.05\d* m, by at most 0\.05 at"
    ):
        fb.time_path(robot, path, constraints=fb.Constraints(half_planes=((1, 0, 0),), torque=0.05))
