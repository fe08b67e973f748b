"""Discs and rectangles in aspects: closed forms, published circles, brute force on the rim, and random search."""

import json
from itertools import combinations

import numpy as np
import pytest

import fivebar as fb
from fivebar.constraints.disc import _polished, clearance_at, largest_disc, punctures
from fivebar.constraints.rectangle import largest_rectangle
from fivebar.singularities.aspects import aspects
from fivebar.singularities.regions import points_of_largest_clearance
from tests.helpers import DATA

REFERENCE = json.loads((DATA / "workspace.json").read_text("utf-8"))
LIU = {letter: fb.ROBOTS[f"liu-2006-{letter}"].robot for letter in "abcde"}
ROBOTS = {
    "amoro": fb.FiveBar(),
    "unequal": fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.1),
    "hoang": fb.ROBOTS["hoang-2015"].robot,
    "coaxial": fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0),
}


@pytest.fixture(scope="module")
def found():
    return {name: aspects(robot) for name, robot in (ROBOTS | LIU).items()}


def in_mode(parts, working):
    return [part for part in parts if part.working == working]


@pytest.mark.every(2)
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
    assert fb.locus_distance(LIU[letter], (center.real, center.imag), (1, -1))[0] == pytest.approx(
        radius, abs=1e-12
    )
    if letter in "bc":
        assert largest_disc(part).radius == pytest.approx(radius, abs=1e-12)
    else:
        assert largest_disc(part).radius > radius


@pytest.mark.every(3)
@pytest.mark.parametrize("name", ["amoro", "unequal", "hoang"])
def test_no_point_is_farther_from_the_loci_than_the_disc_center(found, name):
    robot = ROBOTS[name]
    for part in found[name][: len(found[name]) // 2]:  # the others are their images upside down
        disc = largest_disc(part)
        assert part.contains(disc.center)
        assert disc.radius == pytest.approx(
            fb.locus_distance(robot, disc.center, part.working)[0], rel=1e-12
        )
        clearances = points_of_largest_clearance(part.boundary, punctures(part), part.area, 4)
        sizes = [clearance for _, clearance in clearances]
        assert len(clearances) in (3, 4) and sizes == sorted(sizes, reverse=True)
        assert sizes[0] == pytest.approx(disc.radius, rel=0.01)
        assert all(
            0.99 * clearance < clearance_at(part, z) <= clearance for z, clearance in clearances
        )
        assert all(
            abs(z - y) > 0.5 * max(clearance, own)
            for (z, clearance), (y, own) in combinations(clearances, 2)
        )
        outline = part.polygons[0]
        xi = np.random.default_rng(5).uniform(outline.min(axis=0), outline.max(axis=0), (500, 2))
        xi = np.concatenate(
            [xi, disc.center + disc.radius * np.random.default_rng(6).normal(0, 1e-3, (100, 2))]
        )
        inside = xi[part.contains(xi)]
        assert fb.locus_distance(robot, inside, part.working)[0].max() <= disc.radius * (1 + 1e-12)
        smaller = largest_disc(part, constraints=fb.Constraints(clearance=disc.radius / 4))
        assert smaller.radius == pytest.approx(0.75 * disc.radius, rel=1e-12)
    with pytest.raises(
        ValueError,
        match=f"disc in aspect {part.number} keeps a clearance of 1 m: its largest clearance is {disc.radius:.6g}",
    ):
        largest_disc(part, constraints=fb.Constraints(clearance=1.0))


@pytest.mark.every(2)
@pytest.mark.parametrize("name", ["unequal", "amoro"])
def test_a_rectangle_that_is_refused_names_the_largest_disc_as_the_clearance(found, name):
    for part in found[name][2:5]:
        radius = largest_disc(part).radius
        for share in (0.995, 1.001):
            constraints = fb.Constraints(clearance=share * radius)
            with pytest.raises(ValueError) as caught:
                largest_rectangle(part, constraints)
                raise ValueError(f"one is found in aspect {part.number}")
            asked = f"keeps a clearance of {share * radius:g} m: its largest clearance is {radius:.6g} m"
            assert share < 1 or asked in str(caught.value)
            assert share > 1 or "keeps a clearance" not in str(caught.value)


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
    assert largest_rectangle(part, fb.Constraints(clearance=margin)).area == pytest.approx(
        best, rel=1e-8
    )


@pytest.mark.every(3)
@pytest.mark.parametrize("ratio", [0.2, 1.0, 3.0])
def test_rectangles_of_a_ratio_in_closed_form(found, ratio):
    # A disc of radius 3 without its middle: half of it, upright or level, as the ratio asks.
    (part,) = in_mode(found["e"], (1, -1))
    box = largest_rectangle(part, ratio=ratio)
    upright = 4 * ratio / (1 + 4 * ratio**2)
    level = 4 * ratio / (4 + ratio**2)
    assert box.area == pytest.approx(9 * max(upright, level), rel=1e-7)
    assert (box.x_max - box.x_min) / (box.y_max - box.y_min) == pytest.approx(ratio, rel=1e-9)
    with pytest.raises(ValueError, match="ratio must be"):
        largest_rectangle(part, ratio=-ratio)


@pytest.mark.deep
def test_rectangles_in_which_more_is_kept(found):
    # Of a disc of radius 3 a quarter is left: area a b with a^2 + b^2 = 9.
    (part,) = in_mode(found["e"], (1, -1))
    quarter = largest_rectangle(
        part, constraints=fb.Constraints(half_planes=[(0, 1, 0), (1, 0, 0)])
    )
    assert quarter.area == pytest.approx(4.5, rel=1e-8)
    # Bars that touch, on which nothing is known in closed form: kept all over, and on no side any farther.
    constraints = fb.Constraints(collisions=fb.LinkCollisions(0.01, layers=(1, 2, 1, 3)))
    part = found["amoro"][0]
    box = largest_rectangle(part, constraints=constraints)
    borders = np.array([box.x_min, box.x_max, box.y_min, box.y_max])

    def kept(borders):
        x, y = (np.linspace(*borders[k : k + 2], 201) for k in (0, 2))
        xi = np.stack(np.meshgrid(x, y), axis=-1)
        return (
            part.contains(xi).all()
            and constraints.satisfied(fb.igm(part.robot, xi, part.working, unreachable="nan")).all()
        )

    inwards = np.array([1, -1, 1, -1])
    assert kept(borders + 1e-9 * inwards)
    assert not any(
        kept(borders + 1e-9 * inwards - 3e-5 * inwards * (np.arange(4) == k)) for k in range(4)
    )
    with pytest.raises(
        ValueError, match="no rectangle in aspect 1: no pose in it keeps the constraints"
    ):
        largest_rectangle(part, constraints=fb.Constraints(half_planes=[(0, 1, 1.0)]))


@pytest.mark.deep
@pytest.mark.parametrize(
    "name, count, margin", [("amoro", 5, 0.0), ("unequal", 5, 0.0), ("hoang", 1, 0.01)]
)
def test_rectangles_are_inside_and_cannot_grow(found, name, count, margin):
    for part in found[name][:count]:  # the others are their images upside down
        box = largest_rectangle(part, fb.Constraints(clearance=margin))
        borders = np.array([box.x_min, box.x_max, box.y_min, box.y_max])
        step = 1e-6 * (box.x_max - box.x_min)
        assert _clear(part, borders + 0.1 * step * np.array([1, -1, 1, -1]), margin)
        for k, outwards in enumerate((-1, 1, -1, 1)):
            grown = borders.copy()
            grown[k] += 5 * outwards * step
            assert not _clear(part, grown, margin)
        assert 0.2 * part.area < box.area < 0.7 * part.area or margin > 0
    with pytest.raises(ValueError, match="no rectangle in aspect"):
        largest_rectangle(part, constraints=fb.Constraints(clearance=1.0))


def _clear(part, borders, margin):
    """Whether a dense rim, finest at the corners, is in the aspect and keeps the margin."""
    x_min, x_max, y_min, y_max = borders
    t = (1 - np.cos(np.linspace(0, np.pi, 1001))) / 2
    x, y = x_min + t * (x_max - x_min), y_min + t * (y_max - y_min)
    sides = [(x, np.full_like(x, y_min)), (x, np.full_like(x, y_max)), (np.full_like(y, x_min), y)]
    rim = np.concatenate(
        [np.stack(side, axis=-1) for side in (*sides, (np.full_like(y, x_max), y))]
    )
    if not part.contains(rim).all():
        return False
    return margin == 0 or fb.locus_distance(part.robot, rim, part.working)[0].min() >= margin


def test_rectangle_between_arcs_that_meet(found):
    """A larger one than the search on a lattice knew: x +-0.1631, y 0.1523 to 0.4029 lies inside."""
    part = aspects(fb.FiveBar(0.2, 0.37, 0.2, 0.37, 0.48))[0]
    box = largest_rectangle(part)
    assert _clear(part, (-0.1631, 0.1631, 0.1523, 0.4029), 0.0) and box.area > 0.0820
    # The whole rim keeps the margin, not its corners only.
    box = largest_rectangle(found["amoro"][3], fb.Constraints(clearance=0.02))
    assert _clear(found["amoro"][3], (box.x_min, box.x_max, box.y_min, box.y_max), 0.02)


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(8))
def test_random_rectangles_keep_the_margin_and_none_is_larger(seed):
    draw = np.random.default_rng(seed)
    while True:
        lengths = (
            draw.uniform(0.05, 0.5, 5) if seed % 2 else np.round(draw.uniform(0.05, 0.5, 5), 2)
        )
        if seed % 4 == 0:
            lengths[2:4] = lengths[:2]
        try:
            parts = aspects(fb.FiveBar(*lengths))
        except (ValueError, ArithmeticError):
            continue
        break
    part = parts[draw.integers(len(parts))]
    margin = draw.choice([0.0, draw.uniform(0, 0.9) * largest_disc(part).radius])
    box = largest_rectangle(part, fb.Constraints(clearance=margin))
    borders = np.array([box.x_min, box.x_max, box.y_min, box.y_max])
    assert _clear(part, borders, margin)
    arcs = [arc for loop in part.boundary for arc in loop]
    spacing = sum(np.abs(np.diff(arc.z)).sum() for arc in arcs) / 40000
    z = np.concatenate([*(arc.dense(spacing) for arc in arcs), part.punctures @ (1, 1j)])
    assert _apart(z, borders).min() >= margin
    # Climbs from the answer and from points all over, among rectangles so much smaller that the samples do not matter.
    inwards = 2 * spacing * np.array([1, -1, 1, -1])
    points = draw.uniform(*(f(part.polygons[0], axis=0) for f in (np.min, np.max)), (300, 2))
    clearances = [np.abs(z - x - 1j * y).min() - margin for x, y in points[part.contains(points)]]
    order = np.argsort(clearances)[::-1][:8]
    starts = [borders + inwards] + [
        np.repeat(xy, 2) - 0.7 * clearances[k] * np.array([1, -1, 1, -1])
        for k, xy in zip(order, points[part.contains(points)][order])
        if clearances[k] > 0
    ]
    for v in starts:
        for _ in range(150):
            sides = np.repeat([v[1] - v[0], v[3] - v[2]], 2)
            moved = v + (draw.random(4) < 0.5) * draw.normal(0, 1, 4) * sides * 10 ** draw.uniform(
                -3.5, -0.7
            )
            overlaps = np.minimum(moved, v)[[1, 3]] > np.maximum(moved, v)[[0, 2]]
            larger = moved[1] > moved[0] and moved[3] > moved[2] and _area(moved) > _area(v)
            # Most are refused by a few of the samples.
            if (
                overlaps.all()
                and larger
                and all(_apart(own, moved).min() >= margin for own in (z[::64], z))
            ):
                v = moved
        assert _area(np.array(v) + inwards / 2) <= box.area * (1 + 1e-3)


def _area(borders):
    return (borders[1] - borders[0]) * (borders[3] - borders[2])


def _apart(z, borders):
    """Distance of points from a rectangle, less than 0 inside."""
    x_min, x_max, y_min, y_max = borders
    x, y = np.maximum(x_min - z.real, z.real - x_max), np.maximum(y_min - z.imag, z.imag - y_max)
    return np.where((x > 0) & (y > 0), np.hypot(x, y), np.maximum(x, y))


def test_constraints_that_no_region_keeps_are_refused(found):
    for largest in (largest_disc, largest_rectangle):
        with pytest.raises(ValueError, match="the constraint torque is not kept here"):
            largest(found["amoro"][0], fb.Constraints(torque=1.0))
