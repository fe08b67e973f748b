"""What a motion must keep: rooms against formulations of their own, paths that break it, discs that keep it."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.constraints.boundaries import boundaries
from fivebar.constraints.constraints import distance_inside
from fivebar.constraints.link_collisions import segment_distance

ROBOT = fb.FiveBar()
UNEQUAL = fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.1)


def poses(robot, n=300, working=(1, -1)):
    xi = np.random.default_rng(1).uniform(-0.25, 0.25, (20 * n, 2))
    pose = fb.igm(robot, xi, working, unreachable="nan")
    return fb.igm(robot, xi[np.isfinite(pose.det_A)][:n], working)


def test_segments_against_points_along_them():
    rng, t = np.random.default_rng(2), np.linspace(0, 1, 400)
    for _ in range(60):
        a, b, c, d = rng.normal(size=(4, 2)) @ (1, 1j)
        brute = np.abs((a + t * (b - a))[:, None] - (c + t * (d - c))).min()
        found = float(segment_distance(a, b, c, d))
        ends = np.linalg.solve(
            [[(b - a).real, (c - d).real], [(b - a).imag, (c - d).imag]],
            [(c - a).real, (c - a).imag],
        )
        if ((ends > 0) & (ends < 1)).all():
            assert found < 0
        else:
            assert found == pytest.approx(brute, abs=2e-2) and 0 <= found <= brute


@pytest.mark.parametrize("working", [(1, 1), (1, -1)])
def test_bars_against_the_bars_of_the_pose(working):
    pose = poses(UNEQUAL, 60, working)
    clearances = fb.LinkCollisions((0.01, 0.02, 0.03, 0.04), posts=0.005).clearances(pose)
    posts = (
        ("12", "left"),
        ("12", "right"),
        ("22", "left"),
        ("22", "right"),
        ("11", "right"),
        ("21", "left"),
    )
    assert set(clearances) == {
        f"bars {pair}" for pair in ("11 and 21", "11 and 22", "12 and 21")
    } | {f"bar {bar} and the {side} post" for bar, side in posts}
    t = np.linspace(0, 1, 300)[:, None]
    q1, q2 = pose.q.T
    left = [-0.05 + t * 0.12 * np.exp(1j * q1)], [0.05 + t * 0.08 * np.exp(1j * q2)]
    brute = np.abs(left[0][0][:, None] - left[1][0]).min(axis=(0, 1)) - 0.02
    apart_ = brute > 0
    np.testing.assert_allclose(clearances["bars 11 and 21"][apart_], brute[apart_], atol=1e-3)
    assert set(fb.LinkCollisions(0.01, layers=(1, 2, 1, 3)).clearances(pose)) == {"bars 11 and 21"}
    assert fb.LinkCollisions(0.01, layers=(1, 2, 3, 4)).clearances(pose) == {}


@pytest.mark.parametrize("robot", [UNEQUAL, fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.0)])
@pytest.mark.parametrize(
    "layers, post_layers", [((1, 1, 1, 1), 1), ((1, 2, 1, 2), (2, 1)), ((2, 1, 3, 2), 2)]
)
def test_rooms_of_bars_against_points_along_them_and_those_of_symbols(robot, layers, post_layers):
    widths, t = (0.01, 0.02, 0.03, 0.04), np.linspace(0, 1, 120)
    bars, layer = (
        fb.LinkCollisions(widths, layers, 0.007, post_layers),
        dict(zip(("11", "12", "21", "22"), layers)),
    )
    half = {bar: width / 2 for bar, width in zip(layer, widths)}
    batch = poses(robot, 12)
    every = bars.clearances(batch)
    for k, point in enumerate(batch.xi):
        pose, xi = fb.igm(robot, point, (1, -1)), complex(*point)
        clearances = {name: clearance[k] for name, clearance in every.items()}
        base = {"1": -robot.d / 2, "2": robot.d / 2}
        lengths = {"1": robot.l11, "2": robot.l21}
        elbow = {leg: base[leg] + lengths[leg] * np.exp(1j * q) for leg, q in zip("12", pose.q)}
        along = {
            bar: elbow[bar[0]] + t * ((base[bar[0]] if bar[1] == "1" else xi) - elbow[bar[0]])
            for bar in layer
        }
        expected = {}
        for one, other in (("11", "21"), ("11", "22"), ("12", "21")):
            if layer[one] == layer[other] and not (robot.d == 0 and other + one == "2111"):
                gap = np.abs(along[one][:, None] - along[other]).min()
                expected[f"bars {one} and {other}"] = gap - half[one] - half[other]
        for leg, side in (("1", "left"), ("2", "right")):
            for bar in layer:
                of_a_base = bar[1] == "1" and (bar[0] == leg or robot.d == 0)
                if not of_a_base and layer[bar] in np.atleast_1d(post_layers):
                    gap = np.abs(along[bar] - base[leg]).min() - half[bar]
                    expected[f"bar {bar} and the {side} post"] = gap - 0.007
        assert set(clearances) == set(expected)
        for name, clearance in clearances.items():
            crossing = expected[name] - clearance > 2e-3 and "post" not in name
            assert crossing or float(clearance) == pytest.approx(expected[name], abs=1.5e-3), name
        np.testing.assert_allclose(
            np.ravel(bars.smooth(pose)), list(clearances.values()), rtol=0, atol=2e-9
        )


def test_bars_that_cross_are_less_than_apart_by_the_end_that_is_least_across():
    a, b, c, d = np.array([0, 4, 1 - 1j, 1 + 3j])
    assert (
        segment_distance(a, b, c, d)
        == segment_distance(b, a, c, d)
        == segment_distance(c, d, a, b)
        == segment_distance(d, c, b, a)
        == -1
    )
    assert segment_distance(a, b, (c + d) / 4, d) == 0.5
    one = np.complex128(1)
    assert {
        float(segment_distance(*each))
        for each in ((a, b, one, d), (a, b, d, one), (one, d, a, b), (d, one, a, b))
    } == {0.0}


def test_rooms_one_by_one():
    """Angles by their full turns, a polygon by angles around a point and by points along its sides."""
    pose, corners = (
        poses(UNEQUAL),
        np.array([(10, 0), (10, 15), (5, 5), (0, 15), (-5, 5), (-10, 15), (-10, 0)]) / 100,
    )
    constraints = fb.Constraints(
        joints=((-1, 2.5), (0.5, 4)),
        half_planes=[(3, 4, 0.1)],
        region=corners,
        det_A=0.3,
        sin=0.2,
        collisions=fb.LinkCollisions(0.01),
    )
    clearances, turns = constraints.clearances(pose), 2 * np.pi * np.arange(-3, 4)[:, None]
    for name, q, low, high in (("q11", pose.q[:, 0], -1, 2.5), ("q21", pose.q[:, 1], 0.5, 4)):
        expected = np.minimum(q + turns - low, high - q - turns).max(axis=0)
        np.testing.assert_allclose(
            clearances.pop(f"joint limits of {name}"), expected, rtol=0, atol=1e-14
        )
    np.testing.assert_allclose(
        clearances.pop("0.6 x + 0.8 y >= 0.02 m"), pose.xi @ (0.6, 0.8) - 0.02, rtol=0, atol=1e-15
    )
    away = np.array(corners) @ (1, 1j) - (pose.xi @ (1, 1j))[:, None]
    around = np.angle(np.roll(away, -1, axis=1) / away).sum(axis=1)
    sides = away[..., None] + (np.roll(away, -1, axis=1) - away)[..., None] * np.linspace(0, 1, 501)
    signed = np.abs(sides).min(axis=(1, 2)) * np.where(np.abs(around) > 3, 1, -1)
    points = pose.xi.reshape(15, 20, 2) @ (1, 1j)
    np.testing.assert_array_equal(
        clearances["region"].reshape(15, 20), distance_inside(corners @ (1, 1j), points)
    )
    np.testing.assert_allclose(clearances.pop("region"), signed, rtol=0, atol=2e-4)
    np.testing.assert_array_equal(clearances.pop("|det A| >= 0.3"), np.abs(pose.det_A) - 0.3)
    np.testing.assert_array_equal(
        clearances.pop("|sin q_i2| >= 0.2"), np.abs(pose.sines).min(axis=0) - 0.2
    )
    assert (
        clearances.keys() == constraints.collisions.clearances(pose).keys()
        and fb.Constraints().clearances(pose) == {}
        and fb.Constraints().satisfied(pose).all()
    )
    np.testing.assert_array_equal(
        constraints.satisfied(pose),
        np.min(list(constraints.clearances(pose).values()), axis=0) >= 0,
    )


def test_smooth_rooms_one_by_one():
    pose, length = fb.igm(UNEQUAL, (0.03, 0.12), (1, -1)), 0.07
    constraints = fb.Constraints(
        joints=(None, (0.5, 4)),
        half_planes=[(3, 4, 0.1)],
        region=[(0, 0), (0, 1), (2, 0)],
        collisions=fb.LinkCollisions(0.01),
    )
    (x, y), bars = pose.xi, list(constraints.collisions.clearances(pose).values())
    planes = (3 * x + 4 * y - 0.1) / 5, x, (2 - x - 2 * y) / np.sqrt(5), y
    expected = [np.cos(pose.q[1] - 2.25) - np.cos(1.75), *np.array([*planes, *bars]) / length]
    np.testing.assert_allclose(
        [float(each) for each in constraints.smooth(pose, length)], expected, rtol=0, atol=1e-7
    )


@pytest.mark.deep
def test_legs_cross_in_the_roomiest_discs_of_aspects_3_and_6():
    parts, bars = fb.aspects(ROBOT), fb.LinkCollisions(0.01)
    crossing = []
    for part in parts:
        centre = fb.igm(ROBOT, fb.largest_disc(part).center, part.working)
        if min(float(clearance) for clearance in bars.clearances(centre).values()) < 0:
            crossing.append(part.number)
    assert crossing == [3, 6]
    for number in crossing:
        disc = fb.largest_disc(parts[number - 1], constraints=fb.Constraints(collisions=bars))
        assert 0.03 < disc.radius < fb.largest_disc(parts[number - 1]).radius


KEEPS = {
    "half-plane": fb.Constraints(half_planes=[(0, 1, 0.02)]),
    "joints": fb.Constraints(joints=((-1, 2.5), (0.5, 4))),
    "polygon": fb.Constraints(
        region=[(-0.05, 0.05), (0.08, 0.05), (0.02, 0.09), (0.08, 0.14), (-0.05, 0.14)]
    ),
    "margins": fb.Constraints(det_A=0.3, sin=0.2),
    "bars": fb.Constraints(collisions=fb.LinkCollisions(0.01, posts=0.01)),
}


@pytest.mark.deep
@pytest.mark.parametrize("name", KEEPS)
def test_discs_keep_it_and_no_point_has_more_room(name):
    constraints, rng = KEEPS[name], np.random.default_rng(3)
    for part in (fb.aspect(UNEQUAL, 1), fb.aspect(ROBOT, 4)):
        disc = fb.largest_disc(part, constraints=constraints)
        angle = np.linspace(0, 2 * np.pi, 500)[:, None]
        rim = disc.center + disc.radius * (1 - 1e-5) * np.concatenate(
            [np.cos(angle), np.sin(angle)], axis=1
        )
        assert (
            part.contains(rim).all()
            and constraints.satisfied(fb.igm(part.robot, rim, part.working)).all()
        )
        outside = disc.center + 1.01 * (rim - disc.center)
        outside = fb.igm(part.robot, outside, part.working, unreachable="nan")
        assert not (part.contains(outside.xi) & constraints.satisfied(outside)).all()
        # No disc of 1.02 times the radius is kept: around any point something on its rim is broken.
        outline = part.polygons[0]
        for center in rng.uniform(outline.min(axis=0), outline.max(axis=0), (150, 2)):
            ring = center + 1.02 * (rim[::5] - disc.center) / (1 - 1e-5)
            if part.contains(ring).all():
                assert not constraints.satisfied(fb.igm(part.robot, ring, part.working)).all(), (
                    center
                )


def test_bars_touch_all_along_their_walls():
    constraints, number = fb.Constraints(collisions=fb.LinkCollisions(0.01, posts=0.01)), 0
    assert repr(constraints.collisions) in repr(constraints)
    for arc in boundaries(UNEQUAL, (1, -1), constraints):
        z = arc.at(arc.s[1:-1])
        pose = fb.igm(UNEQUAL, np.stack([z.real, z.imag], axis=-1), (1, -1), unreachable="nan")
        clearances = np.abs(
            list(constraints.clearances(pose).values())
        )  # those of one leg may be where the other does not reach
        assert arc.locus.kind == "traced" and np.nanmin(clearances, axis=0).max() < 1e-13
        number += len(z)
    assert number > 300


@pytest.mark.parametrize("robot", [UNEQUAL, fb.Biglide()])
def test_rooms_without_kinks_are_those_with(robot):
    """The same sign everywhere, and distances over the length that they are divided by."""
    x = (0.0, 0.1) if robot.turns else (-0.04, 0.05)
    y = 0.1 if robot.turns else 0.25
    xi = np.random.default_rng(4).uniform((-0.25, -0.1), (0.25, 0.4), (3000, 2))
    pose = fb.igm(robot, xi, (1, -1), unreachable="nan")
    pose = fb.igm(robot, xi[np.isfinite(pose.det_A)], (1, -1))
    assert len(pose.xi) > 200
    corners = [(x[0], 0.02), (x[1], 0.03), (0.08, y), (-0.07, 0.9 * y)]
    joints = tuple(np.quantile(pose.q, (0.2, 0.9), axis=0).T.tolist())
    for given in (
        dict(joints=joints),
        dict(joints=(None, joints[1])),
        dict(half_planes=[(3, 4, 0.02), (-1, 0.2, -0.1)]),
        dict(region=corners),
        dict(region=corners[::-1]),
        dict(joints=joints, half_planes=[(0, 1, 0.05)]),
    ):
        constraints = fb.Constraints(**given)
        smooth, kept = np.array(constraints.smooth(pose, 0.07)), constraints.satisfied(pose)
        assert 20 < kept.sum() < len(kept) - 20
        np.testing.assert_array_equal((smooth >= 0).all(axis=0), kept)
        if "joints" not in given or not robot.turns:
            clearances = np.min(list(constraints.clearances(pose).values()), axis=0)
            np.testing.assert_allclose(
                0.07 * smooth.min(axis=0)[kept], clearances[kept], rtol=0, atol=1e-15
            )
    # One that is not convex has no such rooms.
    assert fb.Constraints(region=[*corners[:2], (0.0, 0.05), *corners[2:]]).smooth(pose, 1.0) == []


def test_joint_limits_bound_by_exact_arcs():
    constraints, part = fb.Constraints(joints=((-1.0, 2.5), None)), fb.aspect(ROBOT, 1)
    disc = fb.largest_disc(part, constraints=constraints)
    elbow = np.array([-0.059, 0.0]) + 0.09 * np.array([np.cos(2.5), np.sin(2.5)])
    gaps = [
        fb.locus_distance(ROBOT, disc.center, part.working)[0],
        abs(np.linalg.norm(disc.center - elbow) - 0.09),
    ]
    assert min(gaps) == pytest.approx(disc.radius, rel=1e-9)


def test_check_path_names_what_is_broken_and_when():
    path = fb.circle((0.0, 0.1), 0.03, 2.0)  # y = 0.1 + 0.03 sin(pi t)
    check = fb.check_path(
        ROBOT, path, constraints=fb.Constraints(half_planes=[(0, 1, 0.08)], det_A=0.05)
    )
    (only,) = check.broken
    assert only.what == "0 x + 1 y >= 0.08 m" and only.time == pytest.approx(
        1 + np.arcsin(2 / 3) / np.pi, abs=1e-12
    )
    assert only.by == pytest.approx(0.01, abs=1e-12) and only.worst == pytest.approx(1.5, abs=1e-5)
    assert check.singularity_free and fb.check_path(ROBOT, path).broken == ()
    low = 0.07 + 1e-9  # a graze between samples
    (graze,) = fb.check_path(
        ROBOT, path, constraints=fb.Constraints(half_planes=[(0, 1, low)])
    ).broken
    assert graze.by == pytest.approx(1e-9, rel=1e-3)
    q = fb.igm(ROBOT, path(np.linspace(0, 2, 20001))[0], (-1, -1)).q[:, 0]
    (joint,) = fb.check_path(
        ROBOT, path, constraints=fb.Constraints(joints=((q.min() - 1, q.max() - 0.01), None))
    ).broken
    assert joint.what == "joint limits of q11" and joint.by == pytest.approx(0.01, abs=1e-6)
    crossing = fb.line((0.0, -0.05), (0.0, -0.12), 1.0)
    broken = fb.check_path(
        ROBOT, crossing, (1, -1), constraints=fb.Constraints(collisions=fb.LinkCollisions(0.004))
    ).broken
    assert "bars 11 and 21" in {each.what for each in broken}
    biglide = fb.Biglide()
    held = fb.check_path(
        biglide,
        fb.line((0.0, 0.2), (0.0, 0.25), 1.0),
        constraints=fb.Constraints(joints=((-0.01, 0.02), None)),
    ).broken
    y = fb.line((0.0, 0.2), (0.0, 0.25), 1.0)(held[0].time)[0][1]
    foot = y - np.sqrt(biglide.l1**2 - (biglide.d / 2) ** 2)
    assert held[0].what == "joint limits of q11" and foot == pytest.approx(0.02, abs=1e-12)


@pytest.mark.parametrize(
    "given, words",
    [
        (
            dict(joints=((1, 0), None)),
            r"joints of q11 must be \(low, high\), low < high.* apart, not \(1, 0\)",
        ),
        (
            dict(joints=((0, 1), (1, 1))),
            r"joints of q21 must be \(low, high\), low < high.* apart, not \(1, 1\)",
        ),
        (dict(joints=(None, "a")), "Constraints: joints of q21"),
        (dict(joints=(None,)), r"two ranges \(low, high\) or None, not \(None,\)"),
        (dict(joints=((0, 7), None)), "at most a full turn"),
        (dict(joints=1.0), "joints must be two ranges"),
        (dict(joints=((0, 1, 2), None)), "joints of q11 must be"),
        (dict(half_planes="a"), r"half_planes must be a list of \(a, b, c\), not 'a'"),
        (dict(half_planes=["a"]), "Constraints: half_planes"),
        (dict(region=["a"]), "Constraints: region"),
        *(
            (dict(half_planes=p), "half_planes must be")
            for p in ([(0, 0, 1)], [(0, 1)], [0, 1, 1], [[(0, 1, 1)]])
        ),
        *((dict(region=r), "corners") for r in ([(0, 0), (1, 1)], [(0, 0, 1)] * 3, [0, 1, 2])),
        (dict(region=[(0, 0), (1, 1), (1, 1), (0, 2)]), "the same corner twice"),
        (dict(region=[(0, 0), (1, 1), (0, 2), (0, 0)]), "the same corner twice"),
        (dict(region=[(0, 0), (1, 1), (1, 0), (0, 1)]), "sides 1 and 3 of the region meet"),
        (dict(region=[(0, 0), (1, 1), (1, -1), (2, 0)]), "sides 2 and 4 of the region meet"),
        (dict(region=[(0, 0), (2, 0), (2, 2), (1, 0)]), "sides 1 and 3 of the region meet"),
        (
            dict(region=[(0, 0), (4, 0), (4, 4), (0, 4), (1, -1)]),
            "sides 1 and 4 of the region meet",
        ),
        (dict(det_A=2), "Constraints: det_A must be"),
        (dict(sin=-0.1), "Constraints: sin must be"),
        (dict(collisions=0.01), "collisions must be a LinkCollisions"),
        (dict(torque=0.0), "Constraints: torque must be finite and from 1e-24"),
        (dict(torque=(1, 2, 3)), "torque must be one number or one per joint"),
        (dict(joint_speed=-1), "joint_speed must be"),
        (dict(acceleration=(1, 1)), "acceleration must be a number"),
        (dict(clearance=-0.1), "clearance must be"),
    ],
)
def test_what_cannot_be_kept(given, words):
    with pytest.raises((ValueError, TypeError), match=words):
        fb.Constraints(**given)


def test_what_is_kept_is_told_in_one_way():
    constraints = fb.Constraints(
        joints=[[0, 2 * np.pi], None],
        half_planes=np.array([(3, 4, 0.1)]),
        region=np.array([(0, 0), (1, 0), (0, 1)]),
        det_A=1,
        sin=0.5,
    )
    assert (constraints.joints, constraints.region) == (
        ((0.0, 2 * np.pi), None),
        ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)),
    )
    assert constraints.half_planes == (pytest.approx((0.6, 0.8, 0.02), abs=1e-15),) and (
        constraints.det_A,
        constraints.sin,
    ) == (1.0, 0.5)
    assert fb.Constraints(half_planes=[]).half_planes == () and fb.Constraints(
        joints=((0, 0.5), None)
    ).joints == ((0.0, 0.5), None)
    bars = fb.LinkCollisions(0.01, (1.0, 2, 1, 2), 1, 2.0)
    assert bars == fb.LinkCollisions(
        (0.01,) * 4, (1, 2, 1, 2), 1.0, (2,)
    ) and fb.LinkCollisions() == fb.LinkCollisions(0, (1,) * 4, 0, (1,))
    assert all(isinstance(each, int) for each in (*bars.layers, *bars.post_layers))


def test_bars_that_are_none():
    for given, words in (
        (
            dict(widths=(1, 2)),
            r"LinkCollisions: widths must be four, of the bars 11, 12, 21 and 22, not \(1, 2\)",
        ),
        (dict(layers=(1, 2, 3)), r"LinkCollisions: layers must be four, .*, not \(1, 2, 3\)"),
        (
            dict(layers=(1, 2, 1.5, 3)),
            r"LinkCollisions: layers must be whole numbers, not \(1, 2, 1.5, 3\)",
        ),
        (dict(post_layers=1.5), r"LinkCollisions: post_layers must be whole numbers, not 1.5"),
        (
            dict(post_layers=[[1]]),
            r"LinkCollisions: post_layers must be whole numbers, not \[\[1\]\]",
        ),
        (dict(widths=-1), "LinkCollisions: widths must be"),
        (dict(posts=-1), "LinkCollisions: posts must be"),
        *(
            (dict([(name, "a")]), f"LinkCollisions: {name}")
            for name in ("widths", "layers", "posts", "post_layers")
        ),
    ):
        with pytest.raises(ValueError, match=words):
            fb.LinkCollisions(**given)
    with pytest.raises(TypeError, match="must be a FiveBar, not Biglide"):
        fb.LinkCollisions().clearances(fb.igm(fb.Biglide(), (0.0, 0.3)))
    with pytest.raises(ValueError, match="no pose in it keeps the constraints"):
        fb.largest_disc(fb.aspect(ROBOT, 1), constraints=fb.Constraints(half_planes=[(0, 1, 1)]))
