"""Aspects against published numbers, closed forms, grids and the models."""

import json

import numpy as np
import pytest
from scipy import ndimage

import fivebar as fb
from fivebar.singularities import aspects as module
from fivebar.singularities import regions
from fivebar.singularities.aspects import aspect, aspects
from fivebar.singularities.loci import singularity_loci
from fivebar.singularities.locus import MODES
from fivebar.singularities.maps import singularity_map
from fivebar.singularities.margins import Singularity
from tests.helpers import DATA

REFERENCE = json.loads((DATA / "workspace.json").read_text("utf-8"))
AMORO = fb.FiveBar()
UNEQUAL = fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.1)
LIU = {letter: fb.ROBOTS[f"liu-2006-{letter}"].robot for letter in "abcdef"}
ROBOTS = {
    "amoro": AMORO,
    "unequal": UNEQUAL,
    "hoang": fb.ROBOTS["hoang-2015"].robot,
    "grashof": fb.FiveBar(0.2, 0.5, 0.45, 0.3, 0.25),
    "double rocker": fb.FiveBar(0.4, 0.1, 0.35, 0.15, 0.6),
    "equal distal bars": fb.FiveBar(0.13, 0.1, 0.08, 0.1, 0.12),
    "equal bars in each leg": fb.FiveBar(0.1, 0.1, 0.06, 0.06, 0.07),
    "coaxial": fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0),
    "nearly coaxial": fb.FiveBar(0.12, 0.1, 0.08, 0.15, 1e-9),
    "change point": fb.FiveBar(0.3, 0.2, 0.25, 0.35, 0.5),
    "parallelogram": fb.FiveBar(0.1, 0.15, 0.1, 0.05, 0.2),
    "rhombus": fb.FiveBar(0.2, 0.1, 0.2, 0.1, 0.2),
    "base joint at the limit of reach": fb.FiveBar(0.1, 0.1, 0.15, 0.05, 0.2),
}


@pytest.fixture(scope="module")
def found():
    return {name: aspects(robot) for name, robot in (ROBOTS | LIU).items()}


def in_mode(parts, working):
    return [part for part in parts if part.working == working]


def lens_area(radius, d):
    """Of two discs of this radius whose centers are d apart."""
    return 2 * radius**2 * np.arccos(d / 2 / radius) - d / 2 * np.sqrt(4 * radius**2 - d**2)


def test_lens_of_the_amoro_robot(found):
    assert 1e6 * lens_area(0.18, 0.118) == pytest.approx(
        float(REFERENCE["lens_area_equal_bars_mm2"]), rel=1e-14
    )
    for working in MODES:
        total = sum(part.area for part in in_mode(found["amoro"], working))
        assert total == pytest.approx(lens_area(0.18, 0.118), rel=1e-12)


@pytest.mark.parametrize("name, key", [("amoro", "AMORO"), ("hoang", "Hoang_2015_70_200_250")])
def test_reference_counted_on_a_grid(found, name, key):
    reference = REFERENCE["aspects_mm2"][key]
    assert len(found[name]) == reference["n_aspects"]
    for working in MODES:
        label = "".join("+" if mode > 0 else "-" for mode in working)
        mine = sorted((-part.assembly, 1e6 * part.area) for part in in_mode(found[name], working))
        # There the sign is that of det A, so the other one of the lab's assembly mode.
        theirs = sorted((part["assembly"], part["area"]) for part in reference["aspects"][label])
        assert len(mine) == reference["n_aspects_per_mode"][label] == len(theirs)
        np.testing.assert_allclose(
            mine, theirs, rtol=0, atol=2 * reference["max_area_change_1500_to_3000"]
        )


def test_areas_of_liu(found):
    for letter, case in zip("ef", REFERENCE["areas"]):
        area = float(case["theoretical_workspace_area"])
        modes = [working for working in MODES if in_mode(found[letter], working)]
        assert modes == ([(1, -1), (-1, 1)] if letter == "e" else list(MODES))
        for working in modes:
            assert sum(part.area for part in in_mode(found[letter], working)) == pytest.approx(
                area, rel=1e-12
            )


def test_closed_forms(found):
    # Coaxial bases, both elbows on the circle that the distal bars stretched in one line reach: two rings.
    l11, l12, l21, l22 = 0.12, 0.1, 0.08, 0.15
    c = l12 + l22
    at = (l21**2 - l11**2 - c**2) / (
        -2 * c
    )  # from the left elbow along the line to the foot of the base joint
    ring = np.pi * (l11**2 - at**2 + (l12 - at) ** 2)
    inner, outer = np.pi * 0.07**2, np.pi * 0.22**2
    for working in ((1, -1), (-1, 1)):
        areas = sorted(part.area for part in in_mode(found["coaxial"], working))
        assert sum(areas) == pytest.approx(outer - inner, rel=1e-13)
        if inner < ring < outer:
            np.testing.assert_allclose(areas, sorted([outer - ring, ring - inner]), rtol=1e-12)
    # Elbows that only touch: on the circle of self-motion det A is 0 without a change of sign.
    parts = in_mode(aspects(fb.FiveBar(1, 1, 1, 1, 2)), (1, -1))
    assert parts[0].area == pytest.approx(np.pi, rel=1e-12)
    assert [part.assembly for part in parts] == [1, 1, -1] or [part.assembly for part in parts] == [
        1,
        -1,
        1,
    ]


@pytest.mark.every(3)
@pytest.mark.parametrize("name", ROBOTS)
def test_components_and_areas_of_a_grid(found, name):
    robot, n = ROBOTS[name], 451
    data = singularity_map(robot, shape=(n, n))
    cell = (data.x[1] - data.x[0]) * (data.y[1] - data.y[0])
    for working, layer in zip(data.modes, data.values):
        total = sum(part.area for part in in_mode(found[name], working))
        assert total == pytest.approx(np.isfinite(layer).sum() * cell, rel=0.01)
        for assembly in (1, -1):
            labels, count = ndimage.label(-assembly * layer > 0)
            counted = (
                ndimage.sum_labels(np.ones_like(layer), labels, np.arange(1, count + 1)) * cell
            )
            mine = [
                part.area for part in in_mode(found[name], working) if part.assembly == assembly
            ]
            large = 120 * cell  # what is smaller may fall apart, or between the nodes
            expected, got = (np.sort([a for a in areas if a > large]) for areas in (counted, mine))
            np.testing.assert_allclose(got, expected, rtol=0.03, atol=40 * cell)


@pytest.mark.every(3)
@pytest.mark.parametrize("name", ROBOTS | LIU)
def test_areas_have_converged(found, name, monkeypatch):
    for part in found[name]:
        arcs = [arc for loop in part.boundary for arc in loop]
        polygons = [
            np.concatenate([arc.dense(np.sqrt(part.area) / 2000) for arc in loop])
            for loop in part.boundary
        ]
        shoelace = sum((z.conj() * np.roll(z, -1)).imag.sum() / 2 for z in polygons)
        assert part.area == pytest.approx(shoelace, rel=1e-5)
        monkeypatch.setattr(regions, "PANEL", 3)
        finer = sum(regions.LocusArc(arc.locus, arc.start, arc.end).moment for arc in arcs)
        monkeypatch.undo()
        assert part.area == pytest.approx(finer, rel=1e-10)


@pytest.mark.every(2)
@pytest.mark.parametrize("name", ["amoro", "unequal", "hoang", "coaxial", "rhombus", "e"])
def test_each_regular_point_is_in_one_aspect(found, name):
    robot = (ROBOTS | LIU)[name]
    reach = robot.l11 + robot.l12 + robot.d
    xi = np.random.default_rng(3).uniform(-reach, reach, (20000, 2))
    for working in MODES:
        pose = fb.igm(robot, xi, working, unreachable="nan")
        assembly = np.zeros(len(xi))
        for part in in_mode(found[name], working):
            inside = part.contains(xi)
            assert not assembly[inside].any()
            assembly[inside] = part.assembly
            assert part.contains(part.point) is True
        regular = pose.assembly != 0
        np.testing.assert_array_equal(assembly[regular], pose.assembly[regular])
        assert not assembly[~regular].any()


def test_contains_is_exact(found):
    for part in found["amoro"] + found["unequal"]:
        for loop in part.boundary:
            for arc in loop:
                np.testing.assert_allclose(
                    arc.locus.points, arc.locus.at(arc.locus.parameters), rtol=0, atol=1e-15
                )
                s = arc.s[[len(arc.s) // 3, len(arc.s) // 2]]
                z, tangent = arc.curve(s)
                normal = 1e-10 * 1j * tangent / np.abs(tangent)
                assert part.contains(_pairs(z + normal)).all()
                assert not part.contains(_pairs(z - normal)).any()
    assert part.contains(np.zeros((0, 2))).shape == (0,)
    assert part.contains(np.zeros((3, 4, 2))).shape == (3, 4)
    for wrong, shape in (
        ([1.0, 2.0, 3.0], r"\(3,\)"),
        (1.0, r"\(\)"),
        (np.zeros((2, 1)), r"\(2, 1\)"),
    ):
        with pytest.raises(
            ValueError, match=rf"xi must have shape \(2,\) or \(\*batch, 2\), not {shape}"
        ):
            part.contains(wrong)


def _pairs(z):
    return np.stack([z.real, z.imag], axis=-1)


def test_numbers_are_stable(found):
    for name, parts in found.items():
        assert [part.number for part in parts] == list(range(1, len(parts) + 1))
        order = [(MODES.index(part.working), -part.area) for part in parts]
        assert all(
            a[0] < b[0] or (a[0] == b[0] and a[1] <= b[1] * (1 - 1e-5))
            for a, b in zip(order, order[1:])
        ), name
        for a, b in zip(parts, parts[1:]):
            size = sum((a.robot.l11, a.robot.l12, a.robot.l21, a.robot.l22, a.robot.d))
            if (
                a.working == b.working and abs(a.area - b.area) < 1e-9 * size**2
            ):  # mirror images in the symmetric robot
                (x, y), (x_next, y_next) = a.point, b.point
                assert y > y_next + 1e-6 * size or (abs(y - y_next) < 1e-6 * size and x > x_next), (
                    name
                )
    home = next(
        part
        for part in found["amoro"]
        if part.working == (-1, -1) and part.contains((0.09, 0.0679632))
    )
    assert (home.number, home.assembly) == (9, -1)
    assert aspect(AMORO, 9).area == home.area
    for number in (0, 11, -1, 1.5):
        with pytest.raises(
            ValueError, match=rf"no aspect {number}: this robot has 10, numbered from 1"
        ):
            aspect(AMORO, number)


def test_no_aspect_in_a_point_or_where_all_is_singular(found):
    assert aspects(fb.FiveBar(0.1, 0.1, 0.1, 0.1, 0.4)) == ()
    (only,) = in_mode(found["e"], (1, -1))
    np.testing.assert_array_equal(only.punctures, [[0, 0]])
    assert not only.contains((0.0, 0.0)) and only.contains((1e-6, 0.0))


@pytest.mark.parametrize("name", ["amoro", "unequal"])
def test_a_boundary_that_is_lost_is_told(name, monkeypatch):
    """Without Type 2 both signs of det A are in one face; without faces a curve of det A has no side."""
    loci, robot = singularity_loci(ROBOTS[name]), ROBOTS[name]
    limits = [
        piece for piece in loci.task if piece.type == Singularity.SERIAL and (1, 1) in piece.working
    ]
    words = r"in working modes \(1, 1\) a boundary was lost: around \(0.0\d+, -0.1\d+\) m det A or the sines are on"
    with pytest.raises(ArithmeticError, match=words):
        list(module.in_mode(robot, limits, loci.touches, (1, 1)))
    faces = module.faces
    for wrong in (lambda edges, size: [], lambda edges, size: 2 * list(faces(edges, size))):
        monkeypatch.setattr(module, "faces", wrong)
        words = r"in working modes \(1, 1\) a region at the curve of det A around \(-?0.\d+, -?0.\d+\) m was lost or is two"
        with pytest.raises(ArithmeticError, match=words):
            fb.dexterous(robot, 0.3, 0.1)


def test_where_a_circle_passes_a_point():
    circle = next(piece for piece in singularity_loci(UNEQUAL).task if piece.circle)
    low, high = circle.interval
    for s in np.linspace(low, high, 7)[1:-1]:
        point = circle.at(s) @ (1, 1j)
        assert module._parameter(regions.LocusArc(circle, low, high), point) == pytest.approx(
            s, abs=1e-12
        )
        assert module._parameter(regions.LocusArc(circle, low, s - 0.01), point) is None
        assert module._parameter(regions.LocusArc(circle, s - 0.01, high), point) == pytest.approx(
            s, abs=1e-12
        )
        assert module._parameter(regions.LocusArc(circle, s + 0.01, high), point) is None


def test_circles_of_both_legs_that_are_one():
    same = fb.FiveBar(0.1, 0.07, 0.08, 0.09, 0)  # stretched, both reach 0.17
    both = [
        regions.LocusArc(piece, *piece.interval)
        for piece in singularity_loci(same).task
        if piece.circle
    ]
    radii = [abs(arc.z[0]) for arc in both]
    for a, r in zip(both, radii):
        for b, s in zip(both, radii):
            assert module._same(a, b) == (abs(r - s) < 1e-12)
    assert sum(abs(r - 0.17) < 1e-12 for r in radii) > 1
    for working in MODES:  # a ring, all of which is there
        total = sum(part.area for part in in_mode(aspects(same), working))
        assert total == pytest.approx(np.pi * (0.17**2 - 0.03**2), rel=1e-12)
    part = next(
        piece for piece in singularity_loci(UNEQUAL).task if piece.circle and not piece.closed
    )
    assert not module._same(*[regions.LocusArc(part, *part.interval)] * 2)  # not closed


@pytest.mark.parametrize(
    ("lengths", "areas"),
    [
        ((0.15, 0.07, 0.22, 0.19, 0.05), (0.0870, 0.0449)),
        ((0.11, 0.13, 0.12, 0.02, 0.08), (0.0233, 0.00685)),
        ((0.05, 0.12, 0.05, 0.09, 0.03), None),
        ((0.1, 0.2, 0.1, 0.3, 0.1), None),
    ],
)
def test_circles_that_touch_on_a_type_2_locus(lengths, areas):
    """A Type-2 locus leaves the touching point and comes back to it."""
    parts = aspects(fb.FiveBar(*lengths))
    totals = [sum(part.area for part in in_mode(parts, working)) for working in MODES]
    assert totals == pytest.approx([totals[0]] * 4, rel=1e-12)
    if areas:
        assert [part.area for part in in_mode(parts, (1, 1))] == pytest.approx(areas, rel=5e-3)
