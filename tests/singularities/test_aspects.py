"""Aspects against published numbers, closed forms, grids and the models; discs and rectangles against all of these."""

import json

import numpy as np
import pytest
from scipy import ndimage

import fivebar as fb
from fivebar.singularities import regions
from fivebar.singularities.aspects import aspect, aspects
from fivebar.singularities.disc import _polished, largest_disc
from fivebar.singularities.locus import MODES
from fivebar.singularities.maps import singularity_map
from fivebar.singularities.rectangle import largest_rectangle
from tests.helpers import DATA

REFERENCE = json.loads((DATA / "workspace.json").read_text())
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
    assert 1e6 * lens_area(0.18, 0.118) == pytest.approx(float(REFERENCE["lens_area_equal_bars_mm2"]), rel=1e-14)
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
        np.testing.assert_allclose(mine, theirs, rtol=0, atol=2 * reference["max_area_change_1500_to_3000"])


def test_areas_of_liu(found):
    for letter, case in zip("ef", REFERENCE["areas"]):
        area = float(case["theoretical_workspace_area"])
        modes = [working for working in MODES if in_mode(found[letter], working)]
        assert modes == ([(1, -1), (-1, 1)] if letter == "e" else list(MODES))
        for working in modes:
            assert sum(part.area for part in in_mode(found[letter], working)) == pytest.approx(area, rel=1e-12)


def test_closed_forms(found):
    # Coaxial bases, both elbows on the circle that the distal bars stretched in one line reach: two rings.
    l11, l12, l21, l22 = 0.12, 0.1, 0.08, 0.15
    c = l12 + l22
    at = (l21**2 - l11**2 - c**2) / (-2 * c)  # from the left elbow along the line to the foot of the base joint
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
    assert [part.assembly for part in parts] == [1, 1, -1] or [part.assembly for part in parts] == [1, -1, 1]


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
            counted = ndimage.sum_labels(np.ones_like(layer), labels, np.arange(1, count + 1)) * cell
            mine = [part.area for part in in_mode(found[name], working) if part.assembly == assembly]
            large = 120 * cell  # what is smaller may fall apart, or between the nodes
            expected, got = (np.sort([a for a in areas if a > large]) for areas in (counted, mine))
            np.testing.assert_allclose(got, expected, rtol=0.03, atol=40 * cell)


@pytest.mark.parametrize("name", ROBOTS | LIU)
def test_areas_have_converged(found, name, monkeypatch):
    for part in found[name]:
        arcs = [arc for loop in part.boundary for arc in loop]
        polygons = [np.concatenate([arc.dense(np.sqrt(part.area) / 2000) for arc in loop]) for loop in part.boundary]
        shoelace = sum((z.conj() * np.roll(z, -1)).imag.sum() / 2 for z in polygons)
        assert part.area == pytest.approx(shoelace, rel=1e-5)
        monkeypatch.setattr(regions, "PANEL", 3)
        finer = sum(regions.Arc(arc.locus, arc.start, arc.end).moment for arc in arcs)
        monkeypatch.undo()
        assert part.area == pytest.approx(finer, rel=1e-10)


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
        if in_mode(found[name], working):
            np.testing.assert_array_equal(assembly[regular], pose.assembly[regular])
        assert not assembly[~regular].any()


def test_contains_is_exact(found):
    for part in found["amoro"] + found["unequal"]:
        for loop in part.boundary:
            for arc in loop:
                s = arc.s[[len(arc.s) // 3, len(arc.s) // 2]]
                z, tangent = arc.curve(s)
                normal = 1e-10 * 1j * tangent / np.abs(tangent)
                assert part.contains(_pairs(z + normal)).all()
                assert not part.contains(_pairs(z - normal)).any()
    assert part.contains(np.zeros((0, 2))).shape == (0,)
    assert part.contains(np.zeros((3, 4, 2))).shape == (3, 4)
    with pytest.raises(ValueError, match="shape"):
        part.contains([1.0, 2.0, 3.0])


def _pairs(z):
    return np.stack([z.real, z.imag], axis=-1)


def test_numbers_are_stable(found):
    for name, parts in found.items():
        assert [part.number for part in parts] == list(range(1, len(parts) + 1))
        order = [(MODES.index(part.working), -part.area) for part in parts]
        assert all(a[0] < b[0] or (a[0] == b[0] and a[1] <= b[1] * (1 - 1e-5)) for a, b in zip(order, order[1:])), name
    home = next(part for part in found["amoro"] if part.working == (-1, -1) and part.contains((0.09, 0.0679632)))
    assert (home.number, home.assembly) == (9, -1)
    assert aspect(AMORO, 9).area == home.area
    for number in (0, 11, -1, 1.5):
        with pytest.raises(ValueError, match=rf"no aspect {number}: this robot has 10, numbered from 1"):
            aspect(AMORO, number)


def test_no_aspect_in_a_point_or_where_all_is_singular(found):
    assert aspects(fb.FiveBar(0.1, 0.1, 0.1, 0.1, 0.4)) == ()
    (only,) = in_mode(found["e"], (1, -1))
    np.testing.assert_array_equal(only.punctures, [[0, 0]])
    assert not only.contains((0.0, 0.0)) and only.contains((1e-6, 0.0))


@pytest.mark.parametrize("letter", "abcd")
def test_maximum_inscribed_circles_of_liu(found, letter):
    """Liu's usable workspace is what lies above the stretched locus with the elbows outside: modes (1, -1), y > 0.

    With two of the four sets a larger disc lies in the same aspect elsewhere: theirs is a local maximum.
    """
    case = next(case for case, own in zip(REFERENCE["MIC"], "abcd") if own == letter)
    radius, y = float(case["r_MIC"]), float(case["y_MIC"])
    part = next(part for part in in_mode(found[letter], (1, -1)) if part.contains((0, y)))
    center = _polished(part, complex(1e-3, y - 2e-3))
    assert center == pytest.approx(1j * y, abs=1e-9)
    assert fb.locus_distance(LIU[letter], (center.real, center.imag), (1, -1))[0] == pytest.approx(radius, abs=1e-12)
    if letter in "bc":
        assert largest_disc(part).radius == pytest.approx(radius, abs=1e-12)
    else:
        assert largest_disc(part).radius > radius


@pytest.mark.parametrize("name", ["amoro", "unequal", "hoang"])
def test_no_point_is_farther_from_the_loci_than_the_disc_center(found, name):
    robot = ROBOTS[name]
    for part in found[name][: len(found[name]) // 2]:  # the others are their images upside down
        disc = largest_disc(part)
        assert part.contains(disc.center)
        assert disc.radius == pytest.approx(fb.locus_distance(robot, disc.center, part.working)[0], rel=1e-12)
        outline = part.polygons[0]
        xi = np.random.default_rng(5).uniform(outline.min(axis=0), outline.max(axis=0), (500, 2))
        xi = np.concatenate([xi, disc.center + disc.radius * np.random.default_rng(6).normal(0, 1e-3, (100, 2))])
        inside = xi[part.contains(xi)]
        assert fb.locus_distance(robot, inside, part.working)[0].max() <= disc.radius * (1 + 1e-12)
        smaller = largest_disc(part, margin=disc.radius / 4)
        assert smaller.radius == pytest.approx(0.75 * disc.radius, rel=1e-12)
    with pytest.raises(ValueError, match=f"no disc in aspect {part.number} keeps a margin of 1 m"):
        largest_disc(part, margin=1.0)


def test_discs_in_closed_form(found):
    # A ring, and a disc without its center: any of many discs.
    for part in in_mode(found["e"], (1, -1)):
        assert largest_disc(part).radius == pytest.approx(1.5, rel=1e-12)
    widths = sorted(largest_disc(part).radius for part in in_mode(found["coaxial"], (1, 1)))
    assert widths[-1] <= (0.22 - 0.07) / 2 * (1 + 1e-12)


def test_rectangles_in_closed_form(found):
    # In half a disc of radius r, y is free: half its width a, height 2 b, a^2 + b^2 = r^2, area 2 a b.
    (part,) = in_mode(found["e"], (1, -1))
    assert largest_rectangle(part).area == pytest.approx(9.0, rel=1e-8)
    margin, r = 0.2, 2.8
    angle = np.linspace(0, np.pi / 2, 2_000_001)
    best = ((r * np.cos(angle) - margin) * 2 * r * np.sin(angle)).max()
    assert largest_rectangle(part, margin).area == pytest.approx(best, rel=1e-8)


@pytest.mark.parametrize("name, count, margin", [("amoro", 5, 0.0), ("unequal", 5, 0.0), ("hoang", 1, 0.01)])
def test_rectangles_are_inside_and_cannot_grow(found, name, count, margin):
    for part in found[name][:count]:  # the others are their images upside down
        box = largest_rectangle(part, margin)
        borders = np.array([box.x_min, box.x_max, box.y_min, box.y_max])
        step = 1e-6 * (box.x_max - box.x_min)
        assert _clear(part, borders + 0.1 * step * np.array([1, -1, 1, -1]), margin)
        for k, outwards in enumerate((-1, 1, -1, 1)):
            grown = borders.copy()
            grown[k] += 5 * outwards * step
            assert not _clear(part, grown, margin)
        assert 0.2 * part.area < box.area < 0.7 * part.area or margin > 0
    with pytest.raises(ValueError, match="no rectangle in aspect"):
        largest_rectangle(part, margin=1.0)


def _clear(part, borders, margin):
    """Whether a dense rim, finest at the corners, is in the aspect and keeps the margin."""
    x_min, x_max, y_min, y_max = borders
    t = (1 - np.cos(np.linspace(0, np.pi, 1001))) / 2
    x, y = x_min + t * (x_max - x_min), y_min + t * (y_max - y_min)
    sides = [(x, np.full_like(x, y_min)), (x, np.full_like(x, y_max)), (np.full_like(y, x_min), y)]
    rim = np.concatenate([np.stack(side, axis=-1) for side in (*sides, (np.full_like(y, x_max), y))])
    if not part.contains(rim).all():
        return False
    return margin == 0 or fb.locus_distance(part.robot, rim, part.working)[0].min() >= margin


@pytest.mark.parametrize("margin", [-1.0, np.nan, np.inf, (0.1, 0.2)])
def test_margins_are_checked(found, margin):
    for largest in (largest_disc, largest_rectangle):
        with pytest.raises(ValueError, match="margin must be finite and >= 0"):
            largest(found["amoro"][0], margin)


@pytest.mark.parametrize("lengths", [(0.05, 0.12, 0.05, 0.09, 0.03), (0.1, 0.2, 0.1, 0.3, 0.1)])
def test_lost_parts_are_refused(lengths):
    """The outer circles touch from inside on a Type-2 locus: no answer is better than a wrong one."""
    with pytest.raises(ArithmeticError, match="loci of this robot touch so closely"):
        aspects(fb.FiveBar(*lengths))
