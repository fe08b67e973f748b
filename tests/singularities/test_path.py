"""Paths with known crossings: the lab's task 2, its compliant variant, paths that touch a locus or leave."""

import json
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.polynomial import polynomial

import fivebar as fb
from fivebar.constraints.path_check import check_path
from fivebar.singularities.criterion import crossing_acceleration, force_at, largest_force
from fivebar.singularities.loci import singularity_loci
from fivebar.singularities.margins import Singularity
from tests.helpers import DATA

REFERENCE = json.loads((DATA / "five_bar.json").read_text("utf-8"))


@dataclass(frozen=True, eq=False)
class Polynomial:
    """A path with these coefficients (degree + 1, 2), lowest power first."""

    coefficients: np.ndarray
    duration: float
    start: float = 0.0

    def __call__(self, t):
        c = [np.asarray(self.coefficients, dtype=float)]
        for _ in range(2):
            c.append(polynomial.polyder(c[-1]) if len(c[-1]) > 1 else np.zeros((1, 2)))
        return tuple(polynomial.polyval(np.asarray(t), each).T for each in c)


def quintic(a, b, duration):
    a, b = np.array(a), np.array(b)
    return Polynomial(
        np.array(
            [a, 0 * a, 0 * a, *(k * (b - a) / duration**p for p, k in ((3, 10), (4, -15), (5, 6)))]
        ),
        duration,
    )


def straight(point, velocity, duration, start=0.0):
    """Passes the point in the middle of its time."""
    point, velocity = np.array(point), np.array(velocity)
    return Polynomial(
        np.array([point - velocity * (start + duration / 2), velocity]), duration, start
    )


def test_lab_task_2():
    """It meets Type 2 off the criterion."""
    expected = REFERENCE["lab_task_2"]["meets_type_2"][0]
    check = check_path(fb.FiveBar(), quintic((0.09, 0.06796322), (0.05, 0), 4.0))
    assert check.time == pytest.approx(float(expected["t"]), abs=1e-12)
    assert check.type is Singularity.PARALLEL and not check.touching
    assert check.reachable and not check.singularity_free and check.leaves is None
    assert check.criterion == pytest.approx(float(expected["criterion_ts_dot_wrench_N"]), rel=1e-12)
    assert check.criterion_holds is False
    np.testing.assert_allclose(check.pose.xi, [float(v) for v in expected["p"]], rtol=0, atol=1e-14)
    np.testing.assert_allclose(check.pose.q, [float(v) for v in expected["q"]], rtol=0, atol=1e-13)
    assert check.min_margin == 0 and check.min_margin_time == check.time


def test_lab_task_1_is_free():
    path = quintic((0.09, 0.06796322), (0, 0.1), 2.0)
    check = check_path(fb.FiveBar(), path)
    assert check.reachable and check.singularity_free
    assert (check.time, check.pose, check.type, check.criterion) == (
        None,
        None,
        Singularity.NONE,
        None,
    )
    t = np.linspace(0, 2, 100001)
    pose = fb.igm(fb.FiveBar(), path(t)[0])
    smallest = np.abs([*pose.sines, pose.det_A]).min()
    assert smallest - 1e-9 <= check.min_margin <= smallest


def test_compliant_crossing():
    """The nine-condition polynomial of the reference crosses at 2 s with no acceleration along the free direction."""
    c = REFERENCE["compliant_crossing"]
    coefficients = np.array([[float(v) for v in c[name]] for name in ("coef_x", "coef_y")]).T
    check = check_path(fb.FiveBar(), Polynomial(coefficients, float(c["T"])))
    assert check.type is Singularity.PARALLEL and check.criterion_holds
    assert check.time == pytest.approx(2.0, abs=1e-12) and abs(check.criterion) < 1e-12


@pytest.mark.parametrize("share, holds", [(0.9, True), (-0.9, True), (1.1, False), (-1.1, False)])
def test_the_criterion_holds_to_a_millionth_of_the_largest_force(share, holds):
    """The same crossing with that much acceleration along the free direction."""
    c = REFERENCE["compliant_crossing"]
    coefficients = np.array([[float(v) for v in c[name]] for name in ("coef_x", "coef_y")]).T
    path = Polynomial(coefficients, float(c["T"]))
    largest = np.linalg.norm(path(np.linspace(0, path.duration, 20001))[2], axis=1).max()
    free = share * 1e-6 * largest * np.array([float(v) for v in c["uncontrollable_dir"]])
    coefficients[:3] += np.outer((2.0, -2.0, 0.5), free)  # (t - 2)^2 / 2
    check = check_path(fb.FiveBar(), path)
    assert check.time == pytest.approx(2.0, abs=1e-12) and check.criterion_holds is holds
    assert check.criterion == pytest.approx(0.5 * share * 1e-6 * largest, rel=1e-3)


def test_the_largest_force_on_a_path_under_gravity_is_that_of_its_hardest_moment():
    robot, path = fb.FiveBar(gravity=(0.3, -9.81)), quintic((0.02, 0.1), (-0.03, 0.12), 0.31)
    force = robot.m * (path(np.linspace(0, path.duration, 20001))[2] - (0.3, -9.81))
    hardest = np.linalg.norm(force, axis=1).max()
    assert largest_force(robot, path, (-1, -1), np.nan) == pytest.approx(hardest, rel=1e-6)
    # Where the robot reaches none of it, m (xi'' - g) bounds the force.
    beyond = quintic((2.0, 0.1), (2.1, 0.1), 0.31)
    bound = robot.m * (3.0 + np.hypot(0.3, 9.81))
    assert largest_force(robot, beyond, (-1, -1), 3.0) == pytest.approx(bound, rel=1e-12)


HEAVY = dict(
    gravity=(0.3, -9.81),
    mx11=0.02,
    my11=0.01,
    mx21=0.03,
    my21=-0.01,
    zz12=1e-3,
    zz22=2e-3,
    my12=0.02,
)


@pytest.mark.parametrize("given", [{}, dict(gravity=(0.3, -9.81)), HEAVY])
def test_what_crosses_type_2_asks_for_nothing_across_its_bars(given):
    robot, velocity = fb.FiveBar(d=0.15, **given), np.array([0.3, -0.2])
    piece = next(
        p for p in fb.singularity_loci(robot).task if p.kind == "stretched" and len(p.points) > 20
    )
    for xi in piece.points[10:-10:40]:
        pose = fb.igm(robot, xi, piece.working[0])
        (x, y), (ax, ay) = pose.u2[0], crossing_acceleration(pose, velocity, 0.7)
        assert ax * x + ay * y == pytest.approx(0.7, abs=1e-12)
        fx, fy = force_at(pose, velocity, np.array([ax, ay]))
        assert x * fy - y * fx == pytest.approx(0, abs=1e-12 * (1 + np.hypot(fx, fy)))
        if given is not HEAVY:  # then it is m (a - g)
            gx, gy = given.get("gravity", (0.0, 0.0))
            assert x * ay - y * ax == pytest.approx(x * gy - y * gx, abs=1e-11)
            assert (fx, fy) == pytest.approx((robot.m * (ax - gx), robot.m * (ay - gy)), abs=1e-13)


def test_forces_of_many_poses_are_those_of_each_and_heavy_bars_have_a_part_in_them():
    robot, light = fb.FiveBar(**HEAVY), fb.FiveBar(gravity=HEAVY["gravity"])
    xi, rates = (
        np.array([[0.02, 0.1], [-0.03, 0.12]]),
        np.random.default_rng(1).normal(size=(2, 2, 2)),
    )
    found = np.transpose(force_at(fb.igm(robot, xi, (-1, -1)), *rates))
    for k, wanted in enumerate(found):
        own = xi[k], (-1, -1)
        assert force_at(fb.igm(robot, *own), rates[0][k], rates[1][k]) == pytest.approx(
            wanted, rel=1e-13
        )
        bare = np.array(force_at(fb.igm(light, *own), rates[0][k], rates[1][k]))
        assert bare == pytest.approx(light.m * (rates[1][k] - HEAVY["gravity"]), rel=1e-13)
        assert np.abs(wanted - bare).min() > 1e-3
    # Where a leg is in line its rates are not known, and the end-effector's own weight alone is told.
    stretched = next(
        p
        for p in fb.singularity_loci(robot).task
        if p.type == Singularity.SERIAL and len(p.points) > 1
    )
    flat = fb.igm(robot, stretched.points[5], (-1, -1))
    assert force_at(flat, rates[0][0], rates[1][0]) == pytest.approx(
        robot.m * (rates[1][0] - HEAVY["gravity"])
    )


def test_the_free_direction_is_the_kernel_of_a():
    check = check_path(fb.FiveBar(), quintic((0.09, 0.06796322), (0.05, 0), 4.0))
    direction = [float(v) for v in REFERENCE["compliant_crossing"]["uncontrollable_dir"]]
    np.testing.assert_allclose(check.pose.A @ direction, 0, atol=1e-14)
    acceleration = [float(v) for v in REFERENCE["lab_task_2"]["meets_type_2"][0]["a"]]
    assert check.criterion == pytest.approx(0.5 * np.dot(direction, acceleration), rel=1e-10)


@pytest.mark.deep
@pytest.mark.parametrize(
    "start, goal, duration, options",
    [
        ((0.09, 0.068), (0.05, 0.0), 4.0, {}),
        ((0.09, 0.068), (0.05, 0.0), 4.0, dict(tolerance=1e-2)),
        ((0.09, 0.068), (0.05, 0.0), 4.0, dict(tolerance=1e-6)),
        ((0.08, 0.09), (0.03, -0.02), 2.0, {}),
        ((0.05, 0.0), (0.1, 0.05), 1.0, dict(degree=5)),
    ],
)
def test_a_plans_own_crossing_holds_as_exactly_as_it_is_planned(start, goal, duration, options):
    planned = fb.plan(fb.FiveBar(), start, goal, duration, collocation=fb.Collocation(**options))
    check = check_path(fb.FiveBar(), planned)
    assert check.type is Singularity.PARALLEL and check.criterion_holds
    largest = (
        fb.FiveBar().m * np.linalg.norm(planned(np.linspace(0, duration, 2049))[2], axis=1).max()
    )
    missed = abs(check.criterion) / largest
    assert missed <= max(planned.error, 1e-6)
    assert not check_path(fb.FiveBar(), planned, tolerance=missed / 2).criterion_holds
    # Off the criterion by more than its error, a path is not excused by it.
    line = fb.line(start, goal, duration)
    object.__setattr__(line, "error", planned.error)
    assert not check_path(fb.FiveBar(), line).criterion_holds


@pytest.mark.parametrize("side", (1, -1))
@pytest.mark.parametrize("piece", (4, 5, 8))
def test_touching_type_2(piece, side):
    """A parabola with the locus' tangent, bent away from it: det A has a double zero at its vertex."""
    robot = fb.FiveBar()
    locus = singularity_loci(robot).task[piece]
    s = 0.4 * locus.interval[0] + 0.6 * locus.interval[1]
    point, tangent = locus.at(s), locus.tangent(s)
    tangent = tangent / np.linalg.norm(tangent)
    bend = 50 * side * np.array([-tangent[1], tangent[0]])
    t0 = 0.31234
    path = Polynomial(
        np.array(
            [
                point - tangent * t0 * 0.01 + bend * t0**2 * 1e-4,
                tangent * 0.01 - 2e-4 * bend * t0,
                1e-4 * bend,
            ]
        ),
        1.0,
    )
    check = check_path(robot, path, locus.working[0])
    assert check.type is Singularity.PARALLEL and check.touching
    assert check.time == pytest.approx(t0, abs=1e-7)
    np.testing.assert_allclose(check.pose.xi, point, atol=1e-9)
    shifted = Polynomial(path.coefficients + np.array([bend * 1e-8, 0 * bend, 0 * bend]), 1.0)
    near = check_path(robot, shifted, locus.working[0])
    assert near.singularity_free and 0 < near.min_margin < 1e-3
    assert near.min_margin_time == pytest.approx(t0, abs=0.1)
    through = Polynomial(path.coefficients - np.array([bend * 1e-9, 0 * bend, 0 * bend]), 1.0)
    twice = check_path(robot, through, locus.working[0])
    assert not twice.touching and t0 - 0.1 < twice.time < t0


def test_touching_the_limit_of_reach():
    """A line along the tangent of a circle from inside an annulus touches Type 1 and stays reachable."""
    robot = fb.FiveBar(0.3, 0.2, 0.25, 0.28, 0.06)
    point = np.array([-0.03, 0.1])
    check = check_path(robot, straight(point, (0.02, 0.0), 2.0))
    assert check.reachable and check.type is Singularity.SERIAL and check.touching
    assert check.time == pytest.approx(1.0, abs=1e-6)
    free = check_path(robot, straight(point + (0, 1e-6), (0.02, 0.0), 2.0))
    assert free.reachable and free.singularity_free and free.min_margin < 1e-2


@pytest.mark.parametrize("start", (0.0, 5.0))
def test_leaving_the_workspace(start):
    robot = fb.FiveBar()
    check = check_path(robot, straight((0.0, 0.16), (0.0, 0.05), 1.0, start))
    corner = np.sqrt(0.18**2 - 0.059**2)
    assert not check.reachable and not check.singularity_free
    assert (
        check.leaves == check.time == pytest.approx(start + 0.5 + (corner - 0.16) / 0.05, abs=1e-12)
    )
    assert check.type is Singularity.SERIAL and not check.touching and check.criterion is None
    np.testing.assert_allclose(check.pose.xi, (0, corner), atol=1e-14)


def test_crossing_before_leaving():
    """Along the y axis the mode (-1, 1) meets a circle of self-motion before it ends in the corner."""
    check = check_path(fb.FiveBar(), straight((0.0, 0.12), (0.0, 0.1), 1.3), working=(-1, 1))
    assert check.leaves is not None and not check.reachable
    assert check.type is Singularity.PARALLEL and check.time < check.leaves
    np.testing.assert_allclose(check.pose.xi, (0, np.sqrt(0.09**2 - 0.059**2) + 0.09), atol=1e-14)


def test_starting_outside():
    check = check_path(fb.FiveBar(), straight((0.5, 0.0), (0.0, 0.1), 1.0, 2.0))
    assert not check.reachable and check.leaves == check.time == 2.0
    assert np.isnan(check.pose.q).all()


def test_brief_crossing_between_samples():
    """In and out again within a thousandth of the path's time."""
    robot = fb.FiveBar()
    locus = singularity_loci(robot).task[5]
    s = np.mean(locus.interval)
    point, tangent = locus.at(s), locus.tangent(s) / np.linalg.norm(locus.tangent(s))
    normal = np.array([-tangent[1], tangent[0]])
    t0, height = 0.123456, 1e-2
    for depth in (3e-4, -3e-4):
        path = Polynomial(
            np.array(
                [
                    point + height * normal * (t0**2 - abs(depth) ** 2),
                    -2 * height * normal * t0,
                    height * normal,
                ]
            ),
            1.0,
        )
        check = check_path(robot, path, locus.working[0])
        assert check.time == pytest.approx(t0 - 3e-4, abs=1e-9) and not check.touching


def test_touching_and_then_leaving():
    """Starts at rest on the outer circle, goes in, and leaves through the other leg's circle."""
    robot = fb.FiveBar()
    corner = np.sqrt(0.18**2 - 0.059**2)
    check = check_path(robot, quintic((0.121, 0.0), (-0.2, 0.01), 2.0))
    assert check.type is Singularity.SERIAL and check.touching and check.time == 0
    assert 0 < check.leaves < 2 and not check.reachable
    outside = check_path(robot, quintic((0.0, corner), (0.0, 0.2), 2.0))
    assert outside.leaves == outside.time == 0 and not outside.touching


def test_resting_on_a_singularity():
    locus = singularity_loci(fb.FiveBar()).task[5]
    point = locus.at(np.mean(locus.interval))
    check = check_path(fb.FiveBar(), Polynomial(point[None], 1.0), locus.working[0])
    assert (
        check.time == 0
        and check.type is Singularity.PARALLEL
        and check.touching
        and check.criterion_holds
    )


class Torn:
    """A path of which a part is nan for a while."""

    def __init__(self, path, part):
        self.path, self.part, self.duration = path, part, path.duration

    def __call__(self, t):
        answer = [np.array(value) for value in self.path(t)]
        answer[self.part][(1.0 < t) & (t < 1.1), 1] = np.nan
        return answer


def test_bad_input():
    robot = fb.FiveBar()
    path = quintic((0.09, 0.06796322), (0.05, 0), 4.0)
    with pytest.raises(ValueError, match="path must be callable"):
        check_path(robot, [(0.0, 0.1)])
    with pytest.raises(ValueError, match="with a duration"):
        check_path(robot, lambda t: t)
    with pytest.raises(ValueError, match="duration > 0"):
        check_path(robot, Polynomial(path.coefficients, 0.0))
    with pytest.raises(ValueError, match=r"path: at t = 0 s its xi is \[nan, nan\], not finite"):
        check_path(robot, Polynomial(path.coefficients * np.nan, 1.0))
    for part, name in enumerate(
        ("xi", "xi_dot", "xi_ddot")
    ):  # only inside, where the ends are in order
        with pytest.raises(
            ValueError, match=rf"path: at t = 1\.\d+ s its {name} is \[.*nan.*\], not finite"
        ):
            check_path(robot, Torn(path, part))
    for wrong in (-1e-3, np.nan, "exact"):
        with pytest.raises(ValueError, match="tolerance must be"):
            check_path(robot, path, tolerance=wrong)
    with pytest.raises(ValueError, match=r"working must be \+1 or -1"):
        check_path(robot, path, (0, 1))
    with pytest.raises(ValueError, match="working must have shape"):
        check_path(robot, path, (1, 1, 1))


def test_a_path_through_a_base_joint():
    """The leg of equal bars folds there, and has no sine: the check says Type 1."""
    check = check_path(fb.FiveBar(), fb.line((0.059, -0.03), (0.059, 0.03), 1.0), (1, -1))
    assert check.time is not None and not check.singularity_free


@pytest.mark.parametrize("working", [(-1, -1), (1, 1), (1, -1), (-1, 1)])
@pytest.mark.parametrize("kind", ["five-bar", "biglide"])
def test_modes_of_equal_legs_in_one_place_are_singular_everywhere(kind, working):
    """They are those in which both elbows are one point in all poses."""
    if kind == "five-bar":
        robot = fb.FiveBar(0.07, 0.09, 0.07, 0.09, 0.0, 1e-4, 1e-4, 0.1)
        a, b = (0.02, 0.08), (0.05, 0.1)
    else:
        robot = fb.Biglide(0.2, 0.2, 0.0)
        a, b = (0.05, 0.1), (0.1, 0.12)
    check = fb.check_path(robot, fb.line(a, b, 1.0), working)
    points = np.linspace(a, b, 7)
    elbows = fb.igm(robot, points, working).elbows
    same = np.abs(elbows[:, 0] - elbows[:, 1]).max() < 1e-12
    assert check.everywhere == same == (working[0] == working[1])
    path = fb.path([a, b])
    limits = fb.Constraints(acceleration=1.0, speed=0.1)
    if same:
        assert check.criterion is None and check.type == fb.Singularity.PARALLEL
        assert "in these modes the robot is singular everywhere" in repr(check)
        with pytest.raises(fb.SingularityError, match="in these modes the robot is singular every"):
            fb.time_path(robot, path, constraints=limits, working=working)
    else:
        assert check.singularity_free
        assert fb.time_path(robot, path, constraints=limits, working=working).gap < 1e-2


@pytest.mark.parametrize("change", [dict(d=1e-6), dict(l11=0.0701), dict(l22=0.0901)])
def test_of_legs_that_differ_no_mode_is_singular_everywhere(change):
    robot = fb.FiveBar(**dict(l11=0.07, l12=0.09, l21=0.07, l22=0.09, d=0.0) | change)
    check = fb.check_path(robot, fb.line((0.02, 0.08), (0.05, 0.1), 1.0))
    assert not check.everywhere and "everywhere" not in repr(check)


def test_a_plan_is_checked_in_its_own_modes_and_refused_where_it_has_none():
    robot = fb.FiveBar()
    ends = [fb.igm(robot, point, (1, -1)) for point in ((0.05, 0.12), (0.03, 0.1))]
    plan = fb.plan(robot, *ends, 1.0, constraints=fb.Constraints(sin=0.05))
    pose = plan.accelerations(np.linspace(0.0, 1.0, 2001)).rates.pose
    least = np.abs([*pose.sines, pose.det_A]).min()
    assert plan.working == (1, -1)
    assert fb.check_path(robot, plan).min_margin == pytest.approx(least, abs=1e-4)
    free = fb.plan(robot, *ends, 1.0)
    with pytest.raises(ValueError, match="this plan is free of modes"):
        fb.check_path(robot, free)
    assert fb.check_path(robot, free, (1, -1)).singularity_free
