"""Corners are blended and curves fitted within the stated deviation, and what is made goes on in curvature."""

import math
import time

import mpmath
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import fivebar as fb
from fivebar.paths.blend import blended
from fivebar.paths.curve import Path
from fivebar.paths.fit import Bezier, Ellipse, _Beziers, _Ellipses, _off, _quintics, fitted
from fivebar.paths.pieces import Arc, Line, Polynomial


def to_polyline(points, line):
    """Distance (n,) of points to a polyline, complex."""
    line = line[np.append(True, np.diff(line) != 0)]
    a, d = line[:-1], np.diff(line)
    w = np.clip(((points[:, None] - a) * d.conj()).real / np.abs(d) ** 2, 0, 1)
    return np.abs(points[:, None] - a - w * d).min(axis=1)


def dense(path, each=60):
    k, u = np.meshgrid(np.arange(len(path.pieces)), np.linspace(0, 1, each), indexing="ij")
    return path.on(k, u * np.diff(path.knots)[:, None])[0].reshape(-1, 2) @ (1, 1j)


def check_goes_on(path, curvature=True):
    """At knots that are no stops, point, tangent and, where asked, curvature go on, and |xi_s| is 1."""
    stops = {stop.s for stop in path.stops}
    for k, s in enumerate(path.knots[1:-1]):
        before, after = path.on(k, path.pieces[k].length), path.on(k + 1, 0.0)
        assert np.abs(before[0] - after[0]).max() <= 1e-12
        if float(s) not in stops:
            assert (
                np.abs(before[1] - after[1]).max() <= 1e-9
                and abs(np.linalg.norm(after[1]) - 1) <= 1e-9
            )
            if curvature:
                assert np.abs(before[2] - after[2]).max() <= 1e-6 * (1 + np.linalg.norm(after[2]))


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([1e-6, 1e-5, 1e-4, 3e-3]), st.integers(3, 12))
@example(60614, 1e-6, 5)  # one turns by 178.194 degrees
@example(465, 1e-5, 8)  # the first line passes the last corner at 2e-6
def test_polylines_are_blended_within_the_deviation(seed, deviation, count):
    points = np.random.default_rng(seed).uniform(-0.1, 0.1, (count, 2))
    path = fb.path(points, deviation=deviation)
    corners, curve = points @ (1, 1j), dense(path)
    assert to_polyline(curve, corners).max() <= deviation
    assert (
        to_polyline(corners, curve).max() <= deviation
    )  # the corners are as near to it, not cut away
    check_goes_on(path)
    turns = np.angle(np.diff(corners)[1:] / np.diff(corners)[:-1])
    back = np.cos(turns) <= -0.9995  # 178.2 degrees
    assert len(path.stops) == 2 + back.sum()
    assert ("it turns back" in " ".join(path.notes)) == back.any()
    if deviation <= 1e-5 and not back.any():  # there is room: it is used
        own = curve.reshape(len(path.pieces), -1)[
            [isinstance(piece, Polynomial) for piece in path.pieces]
        ]
        for corner, blend in zip(
            corners[1:-1], own, strict=True
        ):  # other lines may cross nearer to it
            assert to_polyline(corner[None], blend) >= 0.85 * deviation


def test_without_deviation_corners_stay():
    path = fb.path([(0, 0), (0.1, 0), (0.1, 0.1)])
    assert [type(piece) for piece in path.pieces] == [Line, Line] and len(path.stops) == 3


def test_lines_and_arcs_stay_exact_between_blends():
    arc = Arc((0.1, 0.02), 0.02, -np.pi / 2, np.pi)
    pieces = Line((0, 0), (0.1, 0)), arc, Line((0.08, 0.02), (0.02, 0.05))
    path = fb.path(list(pieces), deviation=1e-4)
    kinds = [type(piece).__name__ for piece in path.pieces]
    assert kinds == ["Line", "Arc", "Polynomial", "Line"]  # the line meets the arc without a corner
    assert path.pieces[1].centre == arc.centre and path.pieces[1].radius == arc.radius
    smooth = fb.path(list(pieces), deviation=1e-4, curvature=True)
    assert [type(piece).__name__ for piece in smooth.pieces] == [
        "Line",
        "Polynomial",
        "Arc",
        "Polynomial",
        "Line",
    ]
    check_goes_on(smooth)
    outline = np.concatenate(
        [[0, 0.1], arc(np.linspace(0, arc.length, 4001))[0] @ (1, 1j), [0.02 + 0.05j]]
    )
    assert to_polyline(dense(smooth), outline).max() <= 1e-4


def test_a_gentle_corner_is_rounded_as_far_as_its_sides_reach():
    """It is off by less than the deviation there: of sides without another corner 0.95 are used."""
    path = blended(Path((Line((0, 0), (1, 0)), Line((1, 0), (3, 0.04)))), 0.1)
    first, blend, last = path.pieces
    assert first.length == pytest.approx(0.05) and blend.length == pytest.approx(1.9, rel=1e-4)
    assert last.length == pytest.approx(math.hypot(2, 0.04) - 0.95)
    check_goes_on(path)


def test_pen_dwells_and_speeds_are_kept_over_blends():
    rough = Path(
        (Line((0, 0), (1, 0)), Line((1, 0), (1, 1)), Line((1, 1), (0, 1)), Line((0, 1), (0, 0.5))),
        pen=(True, True, False, False),
        dwells={3.0: 2.0},
        feed=(0.1, 0.2, np.inf, np.inf),
        lines=(2, 3, 4, 5),
    )
    path = blended(rough, 1e-3)
    assert len(path.pieces) == 5 and path.pen == (True, True, True, False, False)
    assert path.feed == (0.1, 0.1, 0.2, np.inf, np.inf) and path.lines == (2, 3, 3, 4, 5)
    assert [stop.seconds for stop in path.stops] == [0.0, 0.0, 2.0, 0.0]


def bezier(p, t):
    return (
        p[0] * (1 - t) ** 3 + 3 * p[1] * t * (1 - t) ** 2 + 3 * p[2] * t * t * (1 - t) + p[3] * t**3
    )


CURVES = {
    "plain": [0, 0.03 + 0.05j, 0.08 - 0.02j, 0.1],
    "loop": [0, 0.1 + 0.05j, -0.05 + 0.05j, 0.05],
    "cusp": [0, 0.1 + 0.1j, 0.1j, 0.1],
    "handles in the ends": [0, 0, 0.1j, 0.1 + 0.1j],
    "handles in one point": [0, 0.1j, 0.1j, 0.1],
}
# z = b t + c t^2 + d t^3 with z' = (t - 0.3) (p + q t).
p, q = 0.3 + 0.2j, -0.1 + 0.2j
b, c, d = -0.3 * p, (p - 0.3 * q) / 2, q / 3
CURVES["cusp at 0.3"] = [0, b / 3, (2 * b + c) / 3, b + c + d]


@pytest.mark.every(4)
@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("within", [1e-5, 1e-8])
def test_beziers_are_kept_within(name, within):
    control = np.array(CURVES[name], complex)
    path = Path(tuple(fitted([Bezier(control)], within)[0]))
    fine = bezier(control, np.linspace(0, 1, 30_001))
    ours = dense(path, 25)
    # A polyline of so many chords is itself within their sagittas of the curve.
    sagitta = np.abs(np.diff(fine, 2)).max() / 8
    assert to_polyline(ours[:: len(ours) // 60], fine).max() <= within + sagitta
    assert len(path.stops) == 2 + name.startswith("cusp")
    # Parted at a cusp it takes no more pieces than curves without.
    assert len(path.pieces) <= (10 if within == 1e-5 else 34)
    check_goes_on(path)
    assert path.length == pytest.approx(np.abs(np.diff(fine)).sum(), rel=1e-5)


def test_the_order_of_the_fit_is_six():
    """Halving the pieces of a smooth curve divides what it is off by about 2^6."""
    ellipse = Ellipse(0j, 0.1, 0.06j, 0.0, 1.2)
    counts = [len(fitted([ellipse], within)[0]) for within in (1e-6, 1e-12)]
    assert 4 <= counts[1] / counts[0] <= 16  # (1e6)^(1/6) = 10, in powers of two


def test_an_ellipse_has_its_length():
    from scipy.special import ellipe

    (pieces,) = fitted([Ellipse(0.01j, 0.1, 0.02j, 0.0, 2 * np.pi)], 1e-9)
    assert Path(tuple(pieces)).length == pytest.approx(4 * 0.1 * ellipe(1 - 0.04), rel=1e-8)


def test_a_thousand_corners_take_no_second():
    points = np.random.default_rng(0).random((1001, 2))
    fb.path(points[:20], deviation=1e-4)
    began = time.process_time()
    path = fb.path(points, deviation=1e-4)
    assert time.process_time() - began < 1.5 and len(path.pieces) > 1900
    began = time.process_time()
    path(np.linspace(0, path.length, 100_000))
    assert time.process_time() - began < 1.0


@pytest.mark.parametrize("t", [0.0, 0.3, 1.0])
def test_direction_and_bend_of_a_curve_are_the_derivatives_by_its_length(t):
    """By de Casteljau's points at 50 digits: xi_ss = (z'' - (z''.u) u) / |z'|^2."""
    rng = np.random.default_rng(8)
    controls = rng.normal(size=(3, 4)) + 1j * rng.normal(size=(3, 4))
    _, tangent, bend = _Beziers([Bezier(p) for p in controls]).end(np.arange(3), np.full(3, t), 1)
    for k, control in enumerate(controls):

        def at(x, control=control):
            points = [mpmath.mpmathify(complex(p)) for p in control]
            while len(points) > 1:
                points = [a + x * (b - a) for a, b in zip(points, points[1:])]
            return points[0]

        with mpmath.workdps(50):
            first, second = mpmath.diff(at, mpmath.mpf(t)), mpmath.diff(at, mpmath.mpf(t), 2)
            u = first / abs(first)
            across = (second - mpmath.re(second * mpmath.conj(u)) * u) / abs(first) ** 2
        assert [tangent[k], bend[k]] == pytest.approx([complex(u), complex(across)], rel=1e-12)


def random_curves(kind, rng):
    if kind is _Beziers:
        return _Beziers([Bezier(rng.normal(size=4) + 1j * rng.normal(size=4)) for _ in range(100)])
    axes = rng.normal(size=(100, 2)) + 1j * rng.normal(size=(100, 2))
    return _Ellipses([Ellipse(0j, *ab, 0.3, 0.3 + rng.uniform(0.1, 7)) for ab in axes])


@pytest.mark.parametrize("kind", [_Beziers, _Ellipses])
def test_how_far_quintics_are_off_their_curves(kind):
    """By samples of the curve about each place, three times closer together."""
    curve = random_curves(kind, np.random.default_rng(1))
    rows, start, end = curve.parts()
    middle = (start + end) / 2
    rows = np.tile(rows, 2)
    start, end = np.concatenate([start, middle]), np.concatenate([middle, end])
    coefficients, length = _quintics(curve, rows, start, end)
    off = _off(curve, rows, start, end, coefficients, length)
    places = coefficients @ (np.arange(1, 12) / 12) ** np.arange(6)[:, None]
    low, high = np.tile(start, (11, 1)).T, np.tile(end, (11, 1)).T
    for _ in range(3):
        step = (high - low) / 200
        t = low[..., None] + step[..., None] * np.arange(201)
        distance = np.abs(curve(rows[:, None, None], t)[0] - places[..., None])
        nearest = low + step * distance.argmin(axis=-1)
        low = np.maximum(nearest - step, start[:, None])
        high = np.minimum(nearest + step, end[:, None])
    known = np.isfinite(off) & (off > 1e-5)
    assert known.sum() > 60
    exact = distance.min(axis=-1).max(axis=-1)
    np.testing.assert_allclose(off[known], exact[known], rtol=1e-3)


def arc_rows(n, tremor=0.0):
    angle = np.linspace(0, 6, n)
    z = 0.1j + 0.03 * np.exp(1j * angle)
    noise = np.random.default_rng(3).normal(size=(n, 2)) @ (1, 1j)
    return z + tremor * noise


def evenly(path, count):
    return path(np.linspace(0, path.length, count))[0] @ (1, 1j)


def near(points, line):
    """As to_polyline, of a long polyline in parts that follow each other."""
    parts = len(points) // 500 + 1
    found = []
    for part in np.array_split(np.arange(len(points)), parts):
        middle = part.mean() / len(points) * len(line)
        half = 0.6 * len(line) / parts + 50
        own = line[max(int(middle - half), 0) : int(middle + half) + 1]
        found.append(to_polyline(points[part], own).max())
    return max(found)


@pytest.mark.parametrize("n, tremor", [(100, 0), (600, 0), (600, 5e-6), (7561, 0)])
def test_dense_rows_of_an_arc_are_timed_as_the_arc(n, tremor):
    """With blends row by row it took 1.55 s of 100 rows, and 3.7 s of 1200."""
    rows = arc_rows(n, tremor)
    path = fb.path(rows.view(float).reshape(-1, 2), deviation=2e-5)
    assert len(path.pieces) < 20 and len(path.stops) == 2
    assert f"follow a curve: {n - 1}" in path.notes[-1]
    curve = evenly(path, 3 * n)
    assert near(curve, rows) <= 2e-5 and near(rows, curve) <= 2e-5
    check_goes_on(path)
    limits = fb.Constraints(speed=0.2, acceleration=3.0, jerk=200.0)
    arc = fb.path(Arc((0, 0.1), 0.03, 0, 6))
    least = fb.time_path(fb.FiveBar(), arc, constraints=limits).duration
    assert fb.time_path(fb.FiveBar(), path, constraints=limits).duration < 1.005 * least


def test_sharp_corners_among_dense_rows_stay_sharp():
    half = 0.1j + 0.02 * np.exp(1j * np.linspace(0, np.pi, 300))
    tip = half[-1] + 0.02 - 0.03j
    ways = [half, np.linspace(half[-1], tip, 150)[1:], np.linspace(tip, half[0], 150)[1:]]
    rows = np.concatenate(ways)
    path = fb.path(rows.view(float).reshape(-1, 2), deviation=2e-5)
    curve = evenly(path, 6000)
    assert near(curve, rows) <= 2e-5 and near(rows, curve) <= 2e-5
    assert len(path.stops) == 2 and len(path.pieces) < 12
    for corner in (half[-1], tip):  # all that the deviation leaves is used
        assert 1e-5 < np.abs(curve - corner).min() <= 2e-5


def test_rows_that_follow_no_curve_are_blended_one_by_one():
    rows = np.cumsum(np.random.default_rng(0).normal(size=(400, 2)), axis=0) * 1e-3
    path = fb.path(rows, deviation=2e-5)
    turned = len(path.stops) - 2
    assert len(path.pieces) >= 2 * 399 - 1 - 2 * turned
    assert not any("short lines" in note for note in path.notes)


def test_pen_speeds_dwells_and_lines_of_dense_rows_stay():
    points = arc_rows(301)
    lines = [
        Line(*each)
        for each in zip(*([(z.real, z.imag) for z in p] for p in (points[:-1], points[1:])))
    ]
    dwelt = math.fsum(line.length for line in lines[:200])
    rough = Path(
        tuple(lines),
        feed=(0.1,) * 100 + (0.2,) * 200,
        lines=tuple(range(2, 302)),
        dwells={dwelt: 0.5},
    )
    path = blended(rough, 2e-5)
    assert len(path.pieces) < 30
    assert set(path.feed) == {0.1, 0.2} and [stop.seconds for stop in path.stops] == [0, 0.5, 0]
    rest = path.stops[1].s
    np.testing.assert_allclose(path(rest)[0] @ (1, 1j), points[200], atol=1e-12)
    assert path.line_of(0.0) == 2 and path.line_of(rest) == 202
    change = path.knots[np.flatnonzero(np.diff(path.feed))[0] + 1]
    slow = np.angle((path(change)[0] @ (1, 1j) - 0.1j) / (points[100] - 0.1j))
    assert 0 < slow < 0.8  # the lower speed holds on all of the blend between both
    assert blended(rough, 0.0) is rough
