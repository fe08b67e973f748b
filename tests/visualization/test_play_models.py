"""What the live page computes: loci, aspects, discs, motions and paths against the exact models."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.visualization.play.live import _start

from ..conftest import UNEQUAL
from ..helpers.browsing import settle
from ..helpers.pages import browser, computing, opened  # noqa: F401  fixtures
from ..helpers.playing import LENGTHS, STILL, drag, pose_of

ROBOT = fb.FiveBar()
MODES = [(1, 1), (1, -1), (-1, 1), (-1, -1)]


def length(points):
    points = np.asarray(points)
    return float(np.hypot(*np.diff(points, axis=0).T).sum()) if len(points) > 1 else 0.0


ODD = [
    (0.2, 0.1, 0.2, 0.1, 0.0),
    (0.1, 0.1, 0.1, 0.1, 0.2),
    (0.1, 0.2, 0.1, 0.2, 0.1),
    (0.3, 0.05, 0.1, 0.07, 0.3),
]


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("play") / "play.html"
    fb.play().save(path)
    return path


@pytest.fixture
def page(opened, path):  # noqa: F811
    return opened(path, **STILL)


@pytest.mark.deep
def test_loci_are_on_the_exact_curves_with_their_modes(page):
    rng = np.random.default_rng(3)
    robots = [UNEQUAL, *(each.robot for each in fb.ROBOTS.values() if each.robot.turns)]
    robots += [fb.FiveBar(*lengths) for lengths in ODD]
    while len(robots) < 20:
        lengths = rng.uniform(0.03, 0.3, 5).round(3)
        if 2 * lengths.max() < lengths.sum():
            robots.append(fb.FiveBar(*lengths))
    found = page.evaluate(
        """robots => robots.map(p => { const {task, joint, arcs} = lociOf(p); return {
            task: task.map(({kind, signs, rows}) => [kind, signs, rows.map(row => [row[0], row[1]])]),
            joint: joint.map(({type, kind, signs, rows}) => [type, kind, signs, rows.map(row => [row[2], row[3]])]),
            arcs: arcs.map(({points}) => points)}; })""",
        [[getattr(robot, name) for name in LENGTHS] for robot in robots],
    )
    for robot, own in zip(robots, found):
        loci, size = fb.singularity_loci(robot), sum(getattr(robot, name) for name in LENGTHS)
        points = [point for *_, rows in own["task"] for point in rows[::29]] + [
            arc[k] for arc in own["arcs"] for k in (0, 3)
        ]
        assert np.max(fb.locus_distance(robot, points)[0], initial=0) <= 1e-12 * max(size, 1)
        for mode in MODES:
            for kind in ("stretched", "folded", "self-motion"):
                exact = sum(
                    length(each.points)
                    for each in loci.task
                    if each.kind == kind and mode in each.working
                )
                here = sum(
                    length(rows)
                    for own_kind, signs, rows in own["task"]
                    if own_kind == kind and all(s in (0, -m) for s, m in zip(signs, mode))
                )
                assert here == pytest.approx(exact, rel=2e-3, abs=2e-3 * size), (robot, mode, kind)
        exact = sum(length(each.points) for each in loci.task if each.circle)
        assert sum(map(length, own["arcs"])) == pytest.approx(exact, rel=2e-3), robot
        for assembly in (1, -1):
            for kind in {each.kind for each in loci.joint}:
                exact = sum(
                    length(each.points)
                    for each in loci.joint
                    if each.kind == kind and assembly in each.assembly
                )
                here = sum(
                    length(np.unwrap(rows, axis=0))
                    for type_, own_kind, signs, rows in own["joint"]
                    if own_kind == kind and (type_ == 2 or signs[2] in (0, -assembly))
                )
                assert here == pytest.approx(exact, rel=5e-3, abs=0.05), (robot, assembly, kind)


# All parts in a working mode of a robot; the largest disc in that which holds a point.
PARTS = """([lengths, working, point, sign]) => {
    const loci = lociOf(lengths), parts = regionsOf(loci, lengths, working);
    const region = regionAt(parts, point, sign), holes = loci.holes.filter(hole => inMode(hole, working));
    const disc = largestDisc(region, holes, true), areas = parts.regions.map(({area}) => area);
    return {areas, area: region.area, shown: areaText(region.area, 3), radius: disc.radius,
        middle: [disc.x, disc.y], shownRadius: lengthText(disc.radius)};
}"""
UNITS = {"m²": 1, "cm²": 1e-4, "mm²": 1e-6, "m": 1, "mm": 1e-3, "µm": 1e-6}


def is_rounded(shown, exact, count):
    """Return whether so many digits with a unit are the exact value, rounded."""
    digits, unit = shown.split()
    last = 10.0 ** (np.floor(np.log10(exact / UNITS[unit])) + 1 - count)
    return abs(float(digits) - exact / UNITS[unit]) <= 0.51 * last


def compare(page, robot, aspects, chosen):
    lengths = [getattr(robot, name) for name in LENGTHS]
    least = 1e-9 * sum(lengths) ** 2
    for aspect in chosen:
        place = [lengths, list(aspect.working), aspect.point.tolist(), -aspect.assembly]
        found = page.evaluate(PARTS, place)
        exact = [each.area for each in aspects if each.working == aspect.working]
        mine = sorted(area for area in found["areas"] if area > least)
        theirs = sorted(area for area in exact if area > least)
        np.testing.assert_allclose(mine, theirs, rtol=1e-6, err_msg=str(robot))
        disc = fb.largest_disc(aspect)
        assert is_rounded(found["shown"], aspect.area, 3), (robot, aspect, found)
        largest = disc.radius
        if found["radius"] > largest:  # then that disc must be free of singularities, too
            distance, _ = fb.locus_distance(robot, found["middle"], aspect.working)
            assert fb.singularity(fb.igm(robot, found["middle"], aspect.working)) == 0
            assert largest <= distance * (1 + 1e-9), (robot, aspect, found)
            largest = float(distance)
        assert is_rounded(found["shownRadius"], largest, 4), (robot, aspect, found)


@pytest.mark.deep
@pytest.mark.parametrize("part", range(8))
def test_aspects_and_discs_are_exact(page, part):
    """400 robots: areas of all aspects of a mode, the disc of one of them, in the digits shown."""
    rng = np.random.default_rng([32, part])
    count = 0
    while count < 50:
        lengths = rng.uniform(0.03, 0.3, 5).round(3)
        if 2 * lengths.max() >= lengths.sum():
            continue
        count += 1
        robot = fb.FiveBar(*lengths)
        aspects = fb.aspects(robot)
        large = [each for each in aspects if each.area > 1e-6 * lengths.sum() ** 2]
        compare(page, robot, aspects, [large[rng.integers(len(large))]])


@pytest.mark.deep
@pytest.mark.parametrize(
    "lengths, working, point, area, radius",
    [
        ((1.5, 1.5, 1.5, 1.5, 0.0), (1, -1), (0.0, 1.5), 28.2743, 1.5),  # liu-2006-e
        ((0.1, 0.1, 0.1, 0.1, 0.2), (1, -1), (0.01, -0.13), 88.6e-4, 0.1 / 3),
        (
            (0.1, 0.4, 0.4, 0.1, 0.3),
            (-1, 1),
            (-0.06, -0.366),
            0.0491244,
            0.0771927,
        ),  # two of 77.2 mm
    ],
)
def test_aspects_that_pixels_told_wrong(computing, lengths, working, point, area, radius):  # noqa: F811
    found = computing.evaluate(PARTS, [lengths, working, point, 0])
    assert found["area"] == pytest.approx(area, rel=1e-3)
    assert found["radius"] == pytest.approx(radius, rel=1e-3)


@pytest.mark.deep
def test_aspects_of_special_robots(page):
    """Small whole lengths: curves that touch, coincide or shrink to points."""
    rng = np.random.default_rng(5)
    robots = [each.robot for each in fb.ROBOTS.values() if each.robot.turns]
    while len(robots) < 40:
        lengths = rng.integers(1, 5, 5) / 10
        if 2 * lengths.max() < lengths.sum():
            robots.append(fb.FiveBar(*lengths))
    for robot in robots:
        aspects = fb.aspects(robot)
        large = [each for each in aspects if each.area > 1e-6 * robot.l12**2]
        compare(page, robot, aspects, [large[rng.integers(len(large))]])


@pytest.mark.deep
def test_a_disc_that_just_fits(page):
    page.get_by_label("robot by name").select_option("minitaur-leg")
    page.get_by_label("check whether a disc fits").check()
    page.evaluate("wanted = 0.1; ask()")
    settle(page)
    assert page.locator("#verdict").text_content().startswith("✓ A disc of radius 100 mm fits")


@pytest.mark.parametrize("lengths", [(0.1, 0.1, 0.1, 0.1, 0.4), (0.2, 0.1, 0.2, 0.1, 0.0)])
def test_areas_of_extreme_bases(computing, lengths):  # noqa: F811
    areas = computing.evaluate(
        "p => regionsOf(lociOf(p), p, [-1, 1]).regions.map(({area}) => area)", lengths
    )
    ring = np.pi * (0.3**2 - 0.1**2) if lengths[4] == 0 else 0.0
    assert sum(areas) == pytest.approx(ring, rel=1e-6, abs=1e-12)


@pytest.mark.deep
def test_let_go_is_the_exact_motion(page):
    """The lab's free motion, through Type 2 twice and a folded leg (reference/five_bar.json)."""
    found = page.evaluate(
        """() => { modes = [1, -1]; take(igm([0.01, 0.12], modes, p)); letGo([0.02, -0.3], {tau: [0, 0]});
            const first = totalEnergy().total, good = flow(2);
            return {good, xi: motion.seen.xi, lost: totalEnergy().total / first - 1, crossings: motion.crossings}; }"""
    )
    np.testing.assert_allclose(found["xi"], (0.0087618923917, 0.1480740333255), atol=2e-9)
    assert found["good"] and abs(found["lost"]) < 1e-10 and found["crossings"] >= 2
    upright = fb.ROBOTS["iri-vertical"].robot
    start = fb.igm(upright, (0.05, 0.2), (-1, -1))
    run = fb.simulate(
        upright, lambda *_: (0.1, -0.2), start=fb.dkm(start, (0.0, 0.0)), duration=0.5
    )
    found = page.evaluate(
        """() => { restore({robot: content.presets["iri-vertical"].robot, modes: [-1, -1], xi: [0.05, 0.2]});
            letGo([0, 0], {tau: [0.1, -0.2]}); return [flow(0.5), ...motion.seen.xi]; }"""
    )
    np.testing.assert_allclose(found[1:], run.xi[-1], atol=1e-8)


@pytest.mark.deep
def test_a_drawn_path_is_checked_at_once(page):
    page.get_by_label("draw a path").check()
    page.evaluate("scrollTo(0, 0)")
    drag(page, (0.03, 0.1), (-0.02, 0.02), (-0.02, -0.06), (-0.02, -0.25))
    words, checked = page.locator("#said").text_content(), page.evaluate("checked")
    assert "crosses Type 2 once" in words and "leaves the workspace after" in words
    (mark,) = checked["marks"]
    distance, kind = fb.locus_distance(ROBOT, mark["point"], (-1, -1))
    assert distance < 1e-9 and kind & fb.Singularity.PARALLEL


@pytest.mark.deep
def test_every_named_robot(page):
    for name in fb.ROBOTS:
        if fb.ROBOTS[name].robot.turns:
            page.get_by_label("robot by name").select_option(name)
            settle(page)
            robot = fb.ROBOTS[name].robot
            assert pose_of(page)["p"] == [getattr(robot, each) for each in LENGTHS]
            assert "largest disc free of singularities" in page.locator("#verdict").text_content()


@pytest.mark.parametrize(
    "robot", [ROBOT, UNEQUAL, fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.1), fb.ROBOTS["hoang-2015"].robot]
)
def test_the_page_begins_far_from_singularities(robot):
    """As far as the best of many poses of the lab's modes above the bases, or a quarter farther than they are."""
    q = np.random.default_rng(3).uniform(-np.pi, np.pi, (20_000, 2))
    margins, lab = [], []
    for assembly in (-1, 1):
        pose = fb.dgm(robot, q, assembly, unreachable="nan")
        sines = np.abs(np.stack([*pose.sines, pose.det_A]))
        margins.append(np.nan_to_num(sines.min(axis=0)))
        lab.append((pose.working == -1).all(axis=1) & (pose.xi[:, 1] > 0))
    margins, lab = np.concatenate(margins), np.concatenate(lab)
    begun = _start(robot)
    own = min(np.abs([*begun.sines, begun.det_A]))
    weighted = np.where(lab, 1.0, 0.8) * margins
    in_lab = (begun.working == -1).all() and begun.xi[1] > 0
    assert (1.0 if in_lab else 0.8) * own > weighted.max() - 0.02
