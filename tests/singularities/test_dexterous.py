"""Dexterous regions against integrals over slices, Monte Carlo, closed forms and the models."""

import os

import mpmath
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import fivebar as fb
from fivebar.singularities.dexterous import dexterous
from fivebar.singularities.locus import MODES
from tests.singularities.test_aspect_families import det_a

SAMPLES = 10**8 if os.environ.get("FIVEBAR_NIGHTLY") else 10**6
ROBOTS = {
    "amoro": fb.FiveBar(),
    "unequal": fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.1),
    "hoang": fb.ROBOTS["hoang-2015"].robot,
    "grashof": fb.FiveBar(0.2, 0.5, 0.45, 0.3, 0.25),
    "coaxial": fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0),
    "change point": fb.FiveBar(0.3, 0.2, 0.25, 0.35, 0.5),
}


def total(found, working, assembly):
    return sum(part.area for part in found if (part.working, part.assembly) == (working, assembly))


class Slices:
    """Area in one working and assembly mode: over r, the distance from the left base joint, the angle that is inside.

    The limits of the angle are solved for in mpmath, elbows by the cosine rule.
    """

    def __init__(self, robot, working, assembly, k, s):
        self.robot, self.working, self.assembly, self.k = robot, working, assembly, k
        cosine = mpmath.sqrt(1 - mpmath.mpf(s) ** 2)
        self.legs = [
            tuple(map(mpmath.mpf, leg)) for leg in ((robot.l11, robot.l12), (robot.l21, robot.l22))
        ]
        self.rings = [
            [mpmath.sqrt(a * a + b * b + 2 * side * a * b * cosine) for side in (-1, 1)]
            for a, b in self.legs
        ]

    def room(self, r, angle):
        ends = r * mpmath.expj(angle), r * mpmath.expj(angle) - mpmath.mpf(self.robot.d)
        distal = []
        for (a, b), end, mode in zip(self.legs, ends, self.working):
            away = abs(end)
            turn = mpmath.acos((a * a + away * away - b * b) / (2 * a * away))
            distal.append((end - a * end / away * mpmath.expj(mode * turn)) / b)
        return -self.assembly * (mpmath.conj(distal[0]) * distal[1]).imag - mpmath.mpf(self.k)

    def rough(self, r, angle):
        x, y = r * np.cos(angle) - self.robot.d / 2, r * np.sin(angle)
        return -self.assembly * det_a(self.robot, x, y, self.working) - self.k

    def angle(self, r):
        d = mpmath.mpf(self.robot.d)
        low, high = (
            mpmath.acos(min(max((r * r + d * d - ring * ring) / (2 * r * d), -1), 1))
            for ring in self.rings[1]
        )
        if not low < high:
            return mpmath.mpf(0)
        found = mpmath.mpf(0)
        for a, b in ((low, high), (-high, -low)):
            grid = float(a) + float(b - a) * (
                0.5 - 0.5 * np.cos(np.linspace(1e-7, np.pi - 1e-7, 200))
            )  # finer at its ends
            values = self.rough(float(r), grid)
            step = grid[1] - grid[0]
            for k in (
                np.flatnonzero(np.diff(np.sign(np.diff(values)))) + 1
            ):  # two limits may be nearer than the grid
                if abs(values[k]) < 0.02:
                    sign = -np.sign(values[k + 1] - values[k])
                    best = minimize_scalar(
                        lambda t, sign=sign: -sign * float(self.rough(float(r), t)),
                        bounds=(grid[k - 1], grid[k + 1]),
                        method="bounded",
                        options=dict(xatol=1e-10 * step),
                    ).x
                    grid = np.sort(np.append(grid, best))
            values = self.rough(float(r), grid)
            limits = [a]
            for k in np.flatnonzero(values[:-1] * values[1:] < 0):
                own = mpmath.findroot(
                    lambda t: self.room(r, t), (grid[k], grid[k + 1]), solver="anderson", tol=1e-30
                )
                limits.append(own)
            limits.append(b)
            # On either side of a limit the sign is another.
            inside = values[0] > 0
            for one, other in zip(limits, limits[1:]):
                found += (other - one) * inside
                inside = not inside
        return found

    def area(self, cuts):
        """cuts: distances at which a boundary ends or turns back, to which limits of the angle may be as the root."""
        (inner, outer), d = self.rings[0], mpmath.mpf(self.robot.d)
        turns = [abs(d + side * ring) for ring in self.rings[1] for side in (1, -1)]
        cuts = sorted(
            c for c in [*map(mpmath.mpf, cuts), *turns] if inner + 1e-9 < c < outer - 1e-9
        )
        result = mpmath.mpf(0)
        for low, high in zip([inner, *cuts], [*cuts, outer]):
            for x, weight in zip(*np.polynomial.legendre.leggauss(28)):
                u = (1 + mpmath.mpf(x)) * mpmath.pi / 4
                r = low + (high - low) * mpmath.sin(u) ** 2
                result += (
                    weight * r * self.angle(r) * (high - low) * mpmath.sin(2 * u) * mpmath.pi / 4
                )
        return result


def cuts(found, base):
    """Distances from a base joint at which the regions' boundaries end or turn back."""
    own = []
    for arc in [arc for part in found for loop in part.boundary for arc in loop]:
        z, tangent = arc.curve(arc.s)
        slope = ((z - base) * tangent.conj()).real
        own += [abs(z[0] - base), abs(z[-1] - base)]
        if np.ptp(np.abs(z - base)) < 1e-12:
            continue
        for k in np.flatnonzero((slope[:-1] * slope[1:] <= 0) & (slope[:-1] != 0)):
            low, high = arc.s[k], arc.s[k + 1]
            for _ in range(60):
                middle = (low + high) / 2
                on, along = arc.curve(middle)
                low, high = (
                    (middle, high)
                    if ((on - base) * along.conjugate()).real * slope[k] > 0
                    else (low, middle)
                )
            own.append(abs(arc.at(low) - base))
    own = np.sort(own)
    return own[np.diff(own, prepend=-1) > 1e-9]


@pytest.mark.deep
@pytest.mark.parametrize(
    "name, k, s, working",
    [("amoro", 0.3, 0.2, (1, -1)), ("unequal", 0.5, 0.15, (1, 1)), ("grashof", 0.9, 0.4, (1, -1))],
)
def test_areas_are_those_of_slices(name, k, s, working):
    robot = ROBOTS[name]
    found = dexterous(robot, k, s)
    for assembly in (1, -1):
        own = [part for part in found if (part.working, part.assembly) == (working, assembly)]
        with mpmath.workdps(20):
            area = float(Slices(robot, working, assembly, k, s).area(cuts(own, -robot.d / 2)))
        assert total(found, working, assembly) == pytest.approx(area, rel=1e-12, abs=0)


@pytest.mark.parametrize(
    "name, k, s", [("amoro", 0.3, 0.2), ("unequal", 0.1, 0.0), ("change point", 0.0, 0.3)]
)
def test_areas_are_those_of_a_monte_carlo(name, k, s):
    robot, rng = ROBOTS[name], np.random.default_rng(8)
    found = dexterous(robot, k, s)
    half = robot.l11 + robot.l12, robot.l21 + robot.l22
    low, high = (
        np.array([-robot.d / 2 - half[0], -min(half)]),
        np.array([robot.d / 2 + half[1], min(half)]),
    )
    hits, chunk = {}, 10**6
    for _ in range(SAMPLES // chunk):
        x, y = rng.uniform(low, high, (chunk, 2)).T
        squares = [(x + side * robot.d / 2) ** 2 + y * y for side in (1, -1)]
        legs = (robot.l11, robot.l12), (robot.l21, robot.l22)
        kept = np.all(
            [
                1 - ((r - a * a - b * b) / (2 * a * b)) ** 2 >= s * s
                for r, (a, b) in zip(squares, legs)
            ],
            axis=0,
        )
        for working in MODES[:2]:
            values = det_a(robot, x[kept], y[kept], working)
            for assembly in (1, -1):
                key = working, assembly
                hits[key] = hits.get(key, 0) + np.count_nonzero(-assembly * values >= max(k, 1e-12))
    box = np.prod(high - low)
    for key, count in hits.items():
        share = count / SAMPLES
        error = box * np.sqrt(max(share * (1 - share), 1 / SAMPLES) / SAMPLES)
        assert abs(total(found, *key) - box * share) < 4 * error, key


@pytest.mark.deep
def test_nothing_asked_gives_the_aspects_and_almost_nothing_almost():
    for robot in (ROBOTS["amoro"], ROBOTS["unequal"], ROBOTS["change point"]):
        parts, same = fb.aspects(robot), dexterous(robot)
        assert [(p.number, p.working, p.assembly, p.area) for p in parts] == [
            (p.number, p.working, p.assembly, p.area) for p in same
        ]
        smaller = [dexterous(robot, margin, margin) for margin in (1e-9, 1e-4, 0.01, 0.1)]
        for working in MODES:
            for assembly in (1, -1):
                areas = [total(found, working, assembly) for found in smaller]
                assert areas[0] == pytest.approx(total(parts, working, assembly), rel=1e-6)
                assert areas == sorted(areas, reverse=True)


@pytest.mark.deep
def test_rings_of_coaxial_motors_in_closed_form():
    """With both bases in one point all depends on the distance r alone."""
    robot, k, s = ROBOTS["coaxial"], 0.4, 0.25
    r = np.linspace(0, 0.22, 2_000_001)[1:]
    for working in MODES:
        values = det_a(robot, r, np.zeros(len(r)), working)
        for l1, l2 in ((robot.l11, robot.l12), (robot.l21, robot.l22)):
            values = np.where(
                1 - ((r * r - l1 * l1 - l2 * l2) / (2 * l1 * l2)) ** 2 >= s * s, values, np.nan
            )
        for assembly in (1, -1):
            own = [
                p for p in dexterous(robot, k, s) if (p.working, p.assembly) == (working, assembly)
            ]
            inside = -assembly * values >= k
            edges = np.flatnonzero(np.diff(inside.astype(int)))
            radii = (r[edges] + r[edges + 1]) / 2
            rings = np.pi * (radii[1::2] ** 2 - radii[::2] ** 2)
            np.testing.assert_allclose(sorted(p.area for p in own), sorted(rings), rtol=1e-5)
            for part in own:
                assert len(part.boundary) == 2 and all(
                    np.ptp(np.abs(arc.z)) < 1e-15 for lp in part.boundary for arc in lp
                )


@pytest.mark.every(2)
@pytest.mark.parametrize("name", ROBOTS)
def test_contains_is_what_the_margins_say(name):
    robot, k, s = ROBOTS[name], 0.35, 0.15
    found, parts = dexterous(robot, k, s), fb.aspects(robot)
    reach = robot.l11 + robot.l12 + robot.d
    xi = np.random.default_rng(4).uniform(-reach, reach, (20000, 2))
    for working in MODES:
        pose = fb.igm(robot, xi, working, unreachable="nan")
        margins = fb.singularity_margins(pose)
        kept = (np.abs(margins.parallel) >= k) & (np.abs(margins.serial) >= s).all(axis=-1)
        assembly = np.zeros(len(xi))
        for part in (p for p in found if p.working == working):
            inside = part.contains(xi)
            assert not assembly[inside].any() and part.contains(part.point)
            assembly[inside] = part.assembly
            (around,) = [a for a in parts if a.working == working and a.contains(part.point)]
            assert around.assembly == part.assembly and around.contains(xi[inside]).all()
        np.testing.assert_array_equal(assembly, np.where(kept, pose.assembly, 0))


def test_boundaries_are_where_a_margin_is_met():
    for name, robot in ROBOTS.items():
        for part in dexterous(robot, 0.35, 0.15):
            for arc in (arc for loop in part.boundary for arc in loop):
                z = arc.at(arc.start + np.array([0.1, 0.5, 0.9]) * (arc.end - arc.start))
                margins = fb.singularity_margins(
                    fb.igm(robot, np.stack([z.real, z.imag], axis=-1), part.working)
                )
                rest = np.concatenate(
                    [np.abs(margins.parallel)[:, None] - 0.35, np.abs(margins.serial) - 0.15],
                    axis=1,
                )
                assert rest.min() > -1e-12 and np.abs(rest).min(axis=1).max() < 1e-12, (
                    name,
                    part.number,
                )


@pytest.mark.deep
def test_discs_and_rectangles_keep_the_margins():
    for part in dexterous(ROBOTS["unequal"], 0.3, 0.2)[:3]:
        disc, rectangle = fb.largest_disc(part), fb.largest_rectangle(part)
        angle = np.linspace(0, 2 * np.pi, 721)
        rim = disc.center + disc.radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        x, y = (
            np.linspace(*ends, 60)
            for ends in ((rectangle.x_min, rectangle.x_max), (rectangle.y_min, rectangle.y_max))
        )
        sides = np.concatenate(
            [
                np.stack(np.meshgrid(x, y[[0, -1]]), axis=-1),
                np.stack(np.meshgrid(x[[0, -1]], y), axis=-1).swapaxes(0, 1),
            ],
            axis=1,
        )
        for points in (rim, sides):
            margins = fb.singularity_margins(fb.igm(part.robot, points, part.working))
            rest = np.min(
                [np.abs(margins.parallel) - 0.3, *np.moveaxis(np.abs(margins.serial) - 0.2, -1, 0)],
                axis=0,
            )
            assert -1e-9 < rest.min() < 1e-3


def test_what_is_refused():
    with pytest.raises(ValueError, match="strips without ends"):
        dexterous(fb.Biglide(), 0.3)
    for bad in (-0.1, 1.5, np.nan, "a", True):
        with pytest.raises(ValueError, match="det_A must be"):
            dexterous(ROBOTS["amoro"], det_A=bad)
        with pytest.raises(ValueError, match="sin must be"):
            dexterous(ROBOTS["amoro"], sin=bad)
    assert dexterous(ROBOTS["amoro"], 1.0) == dexterous(ROBOTS["amoro"], sin=1) == ()
    assert dexterous(ROBOTS["amoro"], 0.999999, 0.9999) == ()
