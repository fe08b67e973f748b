"""The closed-form loci against definitions that share nothing with them: the sextic, and the signs of det A."""

import itertools

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import fivebar as fb
from fivebar.singularities.distance import locus_distance
from fivebar.singularities.leg_circles import size_of
from fivebar.singularities.loci import singularity_loci
from fivebar.singularities.margins import Singularity

MODES = tuple(itertools.product((-1, 1), repeat=2))
GENERIC = {
    "amoro": fb.FiveBar(),
    "grashof": fb.FiveBar(0.2, 0.5, 0.45, 0.3, 0.25),
    "not grashof": fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.1),
    "double crank": fb.FiveBar(0.3, 0.2, 0.25, 0.28, 0.06),
    "double rocker": fb.FiveBar(0.4, 0.1, 0.35, 0.15, 0.6),
    "long distal bars": fb.FiveBar(0.3, 1.1, 0.5, 0.4, 0.55),
    "tiny distal bar": fb.FiveBar(0.3, 0.25, 0.35, 0.002, 0.2),
    "almost equal distal bars": fb.FiveBar(0.12, 0.1, 0.08, 0.1 + 1e-7, 0.1),
    "almost a change point": fb.FiveBar(0.3, 0.2, 0.25, 0.35 - 1e-7, 0.5),
    **{
        name: fb.ROBOTS[name].robot
        for name in ("hoang-2015", "liu-2006-a", "liu-2006-b", "liu-2006-c", "liu-2006-f")
    },
}
DEGENERATE = {
    "coaxial": fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0),
    "coaxial, equal bars in each leg": fb.FiveBar(0.12, 0.12, 0.1, 0.1, 0),
    "nearly coaxial": fb.FiveBar(0.12, 0.1, 0.08, 0.15, 1e-9),
    "change point": fb.FiveBar(0.3, 0.2, 0.25, 0.35, 0.5),
    "parallelogram": fb.FiveBar(0.1, 0.15, 0.1, 0.05, 0.2),
    "kite, left": fb.FiveBar(0.3, 0.1, 0.2, 0.2, 0.2),
    "kite, right": fb.FiveBar(0.2, 0.1, 0.3, 0.2, 0.2),
    "folded kite": fb.FiveBar(0.1, 0.3, 0.2, 0.2, 0.2),
    "rhombus": fb.FiveBar(0.2, 0.1, 0.2, 0.1, 0.2),
    "one pose only is stretched": fb.FiveBar(0.1, 0.3, 0.2, 0.2, 0.2),
    "base joint at the limit of reach": fb.FiveBar(0.1, 0.1, 0.15, 0.05, 0.2),
    "long base": fb.FiveBar(0.1, 0.1, 0.1, 0.1, 0.4),
}
ROBOTS = GENERIC | DEGENERATE


def det_a(robot, xi, working):
    return fb.igm(robot, xi, working, unreachable="nan").det_A


def condition(robot, xi, working):
    """(sum |d det A / dp| |p| over xi and the lengths, |d det A / dxi|) by the complex step, from elbows written out
    anew."""
    names = ("l11", "l12", "l21", "l22", "d")
    given_ = {name: getattr(robot, name) for name in names} | {"x": xi[:, 0], "y": xi[:, 1]}

    def det(p):
        bars = []
        for side, leg, mode in ((-1, "l1", working[0]), (1, "l2", working[1])):
            x, y, l1, l2 = p["x"] - side * p["d"] / 2, p["y"], p[leg + "1"], p[leg + "2"]
            w = x * x + y * y
            along = (w + l1 * l1 - l2 * l2) / (2 * w)
            across = mode * np.sqrt(l1 * l1 / w - along * along + 0j)
            bars.append(((x - along * x + across * y) / l2, (y - along * y - across * x) / l2))
        (ax, ay), (bx, by) = bars
        return ax * by - ay * bx

    slopes = {
        name: np.abs(det(given_ | {name: p + 1e-30j}).imag) / 1e-30 for name, p in given_.items()
    }
    return sum(slope * np.abs(given_[name]) for name, slope in slopes.items()), np.hypot(
        slopes["x"], slopes["y"]
    )


def sign_changes(f, low, high, samples=48):
    """Points where f changes its sign along the segments from low to high (n, 2), by bisection to rounding."""
    s = np.linspace(0, 1, samples)[:, None, None]
    x = low + s * (high - low)
    sign = np.sign(f(x))
    changes = sign[:-1] * sign[1:] == -1
    a, b, at_a = x[:-1][changes], x[1:][changes], sign[:-1][changes]
    for _ in range(56):
        middle = (a + b) / 2
        same = (np.sign(f(middle)) == at_a)[:, None]
        a, b = np.where(same, middle, a), np.where(same, b, middle)
    return (a + b) / 2


def segments(robot, count, seed):
    reach = max(robot.l11 + robot.l12, robot.l21 + robot.l22)
    rng = np.random.default_rng(seed)
    return rng.uniform(-reach, reach, (count, 2)), rng.uniform(-reach, reach, (count, 2))


def interior(locus, count=24):
    return locus.at(np.linspace(*locus.interval, count + 2)[1:-1])


def wrapped(angle):
    return np.angle(np.exp(1j * angle))


@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
def test_sextic(robot):
    for locus in singularity_loci(robot).task:
        if locus.kind not in ("stretched", "folded", "self-motion"):
            continue
        d, (x, y), s = robot.d, locus.points.T, 1 if locus.kind == "stretched" else -1
        p = ((x + d / 2) ** 2 + y**2 + robot.l12**2 - robot.l11**2) / (2 * robot.l12)
        q = -s * ((x - d / 2) ** 2 + y**2 + robot.l22**2 - robot.l21**2) / (2 * robot.l22)
        residual = (y * (p - q)) ** 2 + (p * d - (p - q) * (x + d / 2)) ** 2 - (y * d) ** 2
        # Relative to what is added up, p and q included.
        p_sum = ((x + d / 2) ** 2 + y**2 + robot.l12**2 + robot.l11**2) / (2 * robot.l12)
        q_sum = ((x - d / 2) ** 2 + y**2 + robot.l22**2 + robot.l21**2) / (2 * robot.l22)
        total = (
            (y * (p_sum + q_sum)) ** 2
            + (p_sum * d + (p_sum + q_sum) * np.abs(x + d / 2)) ** 2
            + (y * d) ** 2
        )
        assert (np.abs(residual) <= 1e-12 * total).all(), (
            locus.kind,
            np.max(np.abs(residual) / total),
        )


@pytest.mark.every(4)
@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
@pytest.mark.parametrize("mode", MODES, ids=str)
def test_det_a_changes_sign_on_the_loci_only(robot, mode):
    """1000 random segments in each working mode."""
    if mode in singularity_loci(robot).everywhere:
        return
    points = sign_changes(lambda x: det_a(robot, x, mode), *segments(robot, 1000, 1))
    if len(points):
        distance, kind = locus_distance(robot, points, working=mode)
        assert distance.max() <= 1e-10 * max(1, size_of(robot)), points[np.argmax(distance)]


@pytest.mark.every(3)
@pytest.mark.parametrize("robot", GENERIC.values(), ids=GENERIC)
def test_every_type_2_piece_is_one_in_its_modes_and_no_other(robot):
    for locus in singularity_loci(robot).task:
        if locus.type != Singularity.PARALLEL:
            continue
        s = np.linspace(*locus.interval, 27)[1:-1]
        xi, tangent = locus.at(s), locus.tangent(s)
        normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=-1)
        normal *= 1e-7 * size_of(robot) / np.linalg.norm(tangent, axis=1, keepdims=True)
        assert len(locus.working) == 1
        for mode in MODES:
            sides = det_a(robot, xi + normal, mode) * det_a(robot, xi - normal, mode)
            inside = np.isfinite(sides)
            changes = sides[inside] < 0
            if mode in locus.working:
                assert inside.any() and changes.all()
                # With the pose's own sines far from 0 the modes of both sides are the locus' own.
                pose = fb.igm(robot, xi[inside], mode)
                good = np.min(np.abs(pose.sines), axis=0) > 1e-3
                assert (
                    np.abs(pose.det_A[good]) <= 1e-12 * condition(robot, xi[inside][good], mode)[0]
                ).all()
            else:
                assert not changes.any() or np.mean(changes) < 0.2, (locus.kind, mode)
                assert np.nanmedian(np.abs(det_a(robot, xi, mode))) > 1e-6


@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
def test_det_a_is_0_on_every_type_2_point(robot):
    """|det A| <= 1e-12 kappa through igm, which finds every point in reach but a base joint, where a leg is free."""
    for locus in singularity_loci(robot).task:
        if locus.type == Singularity.PARALLEL:
            xi = locus.points
            for mode in locus.working:
                value = np.abs(det_a(robot, xi, mode))
                with np.errstate(all="ignore"):
                    kappa, _ = condition(robot, xi, mode)
                known = np.isfinite(value) & np.isfinite(kappa)
                assert known.mean() > 0.9
                assert (value[known] <= 1e-12 * kappa[known]).all(), (
                    locus.kind,
                    np.max(value[known] / kappa[known]),
                )
                if robot in GENERIC.values():
                    assert (np.abs(np.abs(xi[np.isnan(value)]) - (robot.d / 2, 0)) < 1e-12).all()


@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
def test_type_1_circles_are_limits_of_their_leg(robot):
    for locus in singularity_loci(robot).task:
        if locus.type != Singularity.SERIAL or len(locus.points) == 1:
            continue
        assert set(locus.working) == set(MODES)
        leg = 0 if locus.kind.startswith("left") else 1
        l1, l2, base = ((robot.l11, robot.l12, -robot.d / 2), (robot.l21, robot.l22, robot.d / 2))[
            leg
        ]
        radius = l1 + l2 if "stretched" in locus.kind else abs(l1 - l2)
        xi = interior(locus)
        np.testing.assert_allclose(np.hypot(xi[:, 0] - base, xi[:, 1]), radius, rtol=1e-14)
        inwards = 1e-6 * (1 if "folded" in locus.kind else -1)
        centre = np.array([base, 0])
        for mode in MODES:
            assert np.isfinite(det_a(robot, centre + (xi - centre) * (1 + inwards), mode)).all()
            assert np.isnan(det_a(robot, centre + (xi - centre) * (1 - inwards), mode)).all()


def polyline_distance(polylines, x, wrap=lambda v: v):
    """Distances (n,) to the nearest polyline, minus what it may miss of its curve; `wrap` is applied to differences."""
    best = np.full(len(x), np.inf)
    for points in polylines:
        a, b = (points[:-1], points[1:]) if len(points) > 1 else (points, points)
        to, along = wrap(x[:, None] - a), b - a
        square = np.maximum((along**2).sum(-1), 1e-300)
        s = np.clip((to * along).sum(-1) / square, 0, 1)
        distance = np.linalg.norm(to - s[..., None] * along, axis=-1) - 0.01 * np.sqrt(square)
        best = np.minimum(best, distance.min(axis=1))
    return best


def reachable(robot, xi):
    return np.isfinite(det_a(robot, xi, (1, 1)))


@pytest.mark.every(5)
@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
def test_the_workspace_ends_on_type_1_only(robot):
    points = sign_changes(lambda x: np.where(reachable(robot, x), 1, -1), *segments(robot, 300, 2))
    circles = [
        p.points for p in singularity_loci(robot).task if p.kind.startswith(("left", "right"))
    ]
    if len(points):
        assert polyline_distance(circles, points).max() <= 1e-9 * size_of(robot)
        assert locus_distance(robot, points)[0].max() <= 1e-10 * max(1, size_of(robot))


@pytest.mark.every(5)
@pytest.mark.parametrize("assembly", (-1, 1))
@pytest.mark.parametrize("robot", GENERIC.values(), ids=GENERIC)
def test_joint_space(robot, assembly):
    loci = singularity_loci(robot).joint
    low, high = np.random.default_rng(3).uniform(-np.pi, np.pi, (2, 150, 2))

    def pose(q, mode=assembly):
        return fb.dgm(robot, q, mode, unreachable="nan")

    def on(pieces, q):
        return (
            len(q) == 0 or polyline_distance([p.points for p in pieces], q, wrapped).max() <= 1e-9
        )

    for leg, name in enumerate(("left", "right")):
        chosen = [p for p in loci if p.kind.startswith(name) and assembly in p.assembly]
        assert on(chosen, sign_changes(lambda q, leg=leg: pose(q).sines[leg], low, high, 160))
        for locus in chosen:
            assert locus.assembly == (assembly,)
            here, other = (pose(interior(locus), mode).sines[leg] for mode in (assembly, -assembly))
            good = np.abs(pose(interior(locus)).det_A) > 1e-3
            assert np.abs(here[good]).max(initial=0) <= 1e-10
            assert np.nanmedian(np.abs(other)) > 1e-9
    chosen = [p for p in loci if p.kind in ("stretched", "folded")]
    assert on(
        chosen, sign_changes(lambda q: np.where(np.isnan(pose(q).det_A), -1, 1), low, high, 160)
    )
    for locus in chosen:
        reach = robot.l12 + robot.l22 if locus.kind == "stretched" else abs(robot.l12 - robot.l22)
        elbows = [d.pivot((np.cos(q), np.sin(q))) for d, q in zip(robot.drives, locus.points.T)]
        np.testing.assert_allclose(
            np.hypot(*np.subtract(*elbows)), reach, rtol=0, atol=1e-14 * max(1, size_of(robot))
        )


@pytest.mark.every(4)
@pytest.mark.parametrize("space", ("task", "joint"))
@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
def test_points(robot, space):
    """Less than 1 degree from point to point, exact parameters, their derivative, pieces joined to the last bit."""
    ends = {}
    for locus in getattr(singularity_loci(robot), space):
        chord = np.diff(locus.points, axis=0) @ (1, 1j)
        scale = size_of(robot) if space == "task" else 2 * np.pi
        exact = np.abs(chord) > 1e-7 * scale
        turn = np.abs(np.angle(chord[1:] * chord[:-1].conj()))[exact[1:] & exact[:-1]]
        assert turn.max(initial=0) < np.radians(1)
        if locus.closed and space == "task":
            assert abs(np.angle(chord[0] * chord[-1].conj())) < np.radians(1)
            assert (locus.points[0] == locus.points[-1]).all()
        np.testing.assert_allclose(
            locus.at(locus.parameters), locus.points, rtol=0, atol=1e-14 * scale
        )
        assert locus.at(locus.interval[0]).shape == (2,)
        if len(locus.points) > 1:
            s, h = np.linspace(*locus.interval, 9)[1:-1], 1e-6 * np.diff(locus.interval)
            slope = (locus.at(s + h) - locus.at(s - h)) / (2 * h)
            tangent = locus.tangent(s)
            np.testing.assert_allclose(
                slope, tangent, rtol=0, atol=1e-5 * np.abs(tangent).max() + 1e-9 * scale
            )
            if locus.kind in ("stretched", "folded") and not locus.closed:
                for point in locus.points[[0, -1]]:
                    ends[tuple(point)] = ends.get(tuple(point), 0) + 1
    if space == "task":
        assert all(count % 2 == 0 for count in ends.values())


@pytest.mark.parametrize("robot", GENERIC.values(), ids=GENERIC)
def test_type_3_points(robot):
    """Each lies on a circle of its leg, and there the distal bars are in line in the modes that meet."""
    type3 = singularity_loci(robot).type3
    for xi, q, working in zip(type3.xi, type3.q, type3.working):
        assert 0 in working
        for leg in np.flatnonzero(working == 0):
            l1, l2, base = (
                (robot.l11, robot.l12, -robot.d / 2),
                (robot.l21, robot.l22, robot.d / 2),
            )[leg]
            distance = np.hypot(xi[0] - base, xi[1])
            assert min(abs(distance - l1 - l2), abs(distance - abs(l1 - l2))) <= 1e-14 * max(
                1, size_of(robot)
            )
        elbows = np.array([d.pivot((np.cos(a), np.sin(a))) for d, a in zip(robot.drives, q)])
        (ax, ay), (bx, by) = (xi - elbows) / np.array(robot.distal)[:, None]
        assert abs(ax * by - ay * bx) <= 1e-13


lengths = st.floats(0.05, 1)


@pytest.mark.deep
@settings(max_examples=15, deadline=None, derandomize=True)
@given(lengths, lengths, lengths, lengths, st.just(0.0) | st.floats(1e-12, 1))
@example(0.90625, 0.21875, 0.140625, 1.0, 0.28125)  # almost a cusp: chords of 1e-7 there
@example(
    1.0, 1.0, 1.0, 1.0, 2**-24
)  # both legs all but coincide: det A is small everywhere, its rounding is not
def test_any_robot(l11, l12, l21, l22, d):
    try:
        robot = fb.FiveBar(l11, l12, l21, l22, d)
    except ValueError:
        return
    loci = singularity_loci(robot)
    for locus in loci.task + loci.joint:
        chord = np.diff(locus.points, axis=0) @ (1, 1j)
        told = np.minimum(np.abs(chord[1:]), np.abs(chord[:-1])) > 1e-7
        assert np.abs(np.angle(chord[1:] * chord[:-1].conj()))[told].max(initial=0) < np.radians(1)
    for mode in MODES:
        if mode not in loci.everywhere:
            points = sign_changes(
                lambda x, mode=mode: det_a(robot, x, mode), *segments(robot, 40, 5)
            )
            if len(points):
                kappa, slope = condition(
                    robot, points, mode
                )  # rounding moves a change of sign by kappa eps / slope
                distance = locus_distance(robot, points, working=mode)[0]
                assert (distance * slope <= 1e-10 * slope + 1e-15 * kappa).all()


def test_bad_input():
    with pytest.raises(ValueError, match="no robot 'gantry': the known ones are amoro"):
        singularity_loci("gantry")
