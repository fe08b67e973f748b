"""What the search of placements is made of: distances, paths along borders, pages, rooms of strokes."""

import importlib
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import fivebar as fb
from fivebar.paths.pieces import Arc, Line, Polynomial
from fivebar.paths.placing.clearance import SAMPLES, Clearance, _steepest
from fivebar.paths.placing.fitting_in import _legs_cross, bounds
from fivebar.paths.placing.search import THIN, Found, Search, _samples
from fivebar.paths.placing.tool_regions import _share

ROBOT = fb.FiveBar()


@pytest.fixture(scope="module")
def room():
    return Clearance(max(fb.aspects(ROBOT), key=lambda part: part.area))


@pytest.fixture(scope="module")
def points(room):
    rng = np.random.default_rng(6)
    size = room.high - room.low
    return (
        room.low
        + size.real * rng.uniform(-0.1, 1.1, 300)
        + 1j * size.imag * rng.uniform(-0.1, 1.1, 300)
    )


def test_distances_from_an_aspect_and_their_bounds(room, points):
    exact = np.where(room.within(points), 1.0, -1.0) * room.exact(points)
    locus = fb.locus_distance(
        ROBOT, np.stack([points.real, points.imag], axis=-1), room.part.working
    )
    inside = exact > 0
    assert 50 < inside.sum() < 250
    np.testing.assert_allclose(exact[inside], locus[0][inside], atol=1e-9)
    rough, gradient = room.rough(points)
    np.testing.assert_allclose(rough, exact, atol=room.spacing)
    np.testing.assert_allclose(np.abs(gradient), 1.0, rtol=1e-9)
    h = 1e-7
    for way in (1.0, 1j):
        slope = (room.rough(points + h * way)[0] - room.rough(points - h * way)[0]) / (2 * h)
        expected = (gradient * np.conj(way)).real
        assert (np.abs(slope - expected) < 1e-4).mean() > 0.98  # but for kinks
    assert (room._least(points) <= np.abs(exact) + 1e-12).all()
    # In the grid's box, to half of its cells.
    held = (room.low.real < points.real) & (points.real < room.high.real)
    held &= (room.low.imag < points.imag) & (points.imag < room.high.imag)
    known = held & (np.abs(exact) > np.hypot(*room.steps))
    assert known.sum() > 100
    half = np.hypot(*room.steps) / 2 + room.spacing
    assert np.abs(room.coarse(points) - exact)[known].max() < half


def test_distances_beyond_corners_of_the_border(room):
    """There the nearest place is the corner itself."""
    loop = room.part.boundary[0]
    corners = np.array([arc.z[0] for arc in loop])
    ways = np.exp(2j * np.pi * np.arange(48) / 48)
    z = (corners[:, None] + 0.02 * ways).ravel()
    nearest = np.min(
        [
            np.abs(z[:, None] - room.border[k : k + 500]).min(axis=1)
            for k in range(0, len(room.border), 500)
        ],
        axis=0,
    )
    rough, _ = room.rough(z)
    assert np.abs(np.abs(rough) - nearest).max() < room.spacing


@pytest.mark.parametrize(
    "piece",
    [
        Line((0, 0), (0.01, 0.02)),
        Arc((0.01, 0), 0.02, 0.5, -1.0),
        Polynomial([(0, 0), (0.03, 0), (0, 0.02), (-0.01, 0.01)], 0.025),
    ],
)
def test_a_path_keeps_the_clearance_of_its_points(room, piece):
    speed, bend = _steepest(piece)
    _, xi_s, xi_ss, _ = piece(np.linspace(0, piece.length, 2001))
    seen = np.linalg.norm(xi_s, axis=1).max(), np.linalg.norm(xi_ss, axis=1).max()
    assert seen[0] <= speed * (1 + 1e-12) and seen[1] <= bend * (1 + 1e-12) + 1e-15
    assert speed < 1.5 * seen[0] and bend <= 2.5 * seen[1] + 1e-15
    disc = fb.largest_disc(room.part)
    path = fb.Placement(tuple(disc.center))(fb.path([piece]))
    z = path(np.linspace(0, path.length, 4001))[0] @ (1, 1j)
    dense = room.exact(z)
    clearance, at = room.along(path)
    assert clearance == pytest.approx(dense.min(), abs=2e-7)
    assert room.exact(np.array([at]))[0] == pytest.approx(clearance, abs=1e-12)
    assert room.along(path, most=0.5 * clearance) == (0.5 * clearance, None)
    outside = fb.Placement((0.0, 5.0))(path)
    assert room.along(outside)[0] < -4


def test_the_least_clearance_lies_within_a_piece(room):
    """On two arcs, the second one nearest to the border between samples: by minimizing the distance itself."""
    disc = fb.largest_disc(room.part)
    radius = 0.4 * disc.radius
    for turn in (0.1, 2.1, 4.1):
        arcs = [Arc(tuple(disc.center), radius, turn - 4.0, turn - 2.0)]
        arcs.append(Arc(tuple(disc.center), radius, turn - 2.0, turn + 2.1))
        path = fb.path(arcs)
        clearance, at = room.along(path)

        def distance(s, path=path):
            return room.exact(path(np.atleast_1d(s))[0] @ (1, 1j))

        samples = np.linspace(0, path.length, 1001)
        near = samples[distance(samples).argmin()]
        step = samples[1]
        exact = minimize_scalar(
            lambda s: distance(s)[0],
            bounds=(max(near - step, 0), min(near + step, path.length)),
            options={"xatol": 1e-9},
        )
        assert clearance == pytest.approx(exact.fun, abs=1e-8)
        assert abs(abs(at - disc.center @ (1, 1j)) - radius) < 1e-9


def test_a_small_path_is_moved_to_the_middle_of_the_largest_disc(room):
    disc = fb.largest_disc(room.part)
    search = search_of([fb.path([(0, 0), (1e-4, 0)])], [room])
    search.clearances, search.turn = [room], None
    start = Found(0.0, (0,), disc.center @ (1, 1j) + 0.02 - 0.03j, 0.4, 1.0)
    found = search.improved(start)
    assert found.clearance == pytest.approx(disc.radius, abs=3 * room.spacing)
    assert found.which == (0,) and found.scale == 1.0
    search.margin = 0.4 * disc.radius
    grown = search.grown(search.best([start._replace(scale=100.0)]))
    assert grown.scale > 300 and grown.clearance >= search.margin


def search_of(paths, clearances=(), page=None):
    fake = [SimpleNamespace(most=1.0, holes=np.array([])) for _ in clearances] or [None]
    return Search(paths, fake, 0.0, 0.0, page)


def test_how_deep_points_are_in_pages():
    search = search_of([fb.path([(0, 0), (0.3, 0), (0.3, 0.2), (0, 0.2), (0, 0)])], page=(0.3, 0.2))
    rng = np.random.default_rng(2)
    z = rng.uniform(-0.6, 0.6, 200) + 1j * rng.uniform(-0.6, 0.6, 200)
    shifts, turns, scales = (
        np.array([0.1 + 0.2j, -0.1j]),
        np.array([0.7, -2.0]),
        np.array([1.5, 2.5]),
    )
    room = SimpleNamespace(holes=z)
    for scale in scales:
        for k in range(2):
            local = (z - shifts[k]) * np.exp(-1j * turns[k])
            inner = np.minimum(0.15 * scale - np.abs(local.real), 0.1 * scale - np.abs(local.imag))
            assert 10 < (inner > 0).sum() < 190
            expected = -inner.max()
            assert search.depth(room, shifts[k], turns[k], scale) == pytest.approx(expected)
        both = search.depth(room, shifts[:, None], turns, scale)
        assert both.shape == (2, 2)
        assert both[1, 1] == pytest.approx(expected)
    empty = SimpleNamespace(holes=np.array([9.0, 9j]))
    assert search.depth(empty, 0j, 0.3, 1.0) == np.inf
    assert search.middle == pytest.approx(0.15 + 0.1j)
    assert search.size == pytest.approx(np.hypot(0.15, 0.1))


def test_a_hole_in_a_page_counts():
    """Its clearance is then how deep the hole is in the page, below 0."""
    page = fb.path([(0, 0), (0.3, 0), (0.3, 0.2), (0, 0.2), (0, 0)])
    search = search_of([page], page=(0.3, 0.2))
    search.clearances = [
        SimpleNamespace(
            holes=np.array([0.1 + 0.02j, 5.0]),
            rough=lambda z: (np.ones(len(z)), np.ones(len(z))),
            along=lambda placed, most: (0.4, 3j),
        )
    ]
    for shift, expected in ((0.1, -0.08), (0.18, -0.07), (0.5, 0.4)):
        clearance, at = search.exactly(Found(0.0, (0,), complex(shift), 0.0, 1.0))
        assert clearance == pytest.approx(expected) and at == 3j


def test_regions_keep_the_constraints_on_poses():
    module = importlib.import_module("fivebar.paths.placing.place")
    kept = fb.Constraints(det_A=0.5, sin=0.3, half_planes=[(0, 1, 0.0)], clearance=0.1)
    found = module._regions(ROBOT, None, (-1, -1), kept)
    exact = [part for part in fb.dexterous(ROBOT, 0.5, 0.3) if part.working == (-1, -1)]
    assert [part.area for part in found] == [part.area for part in exact] and found
    assert all(part.working == (-1, -1) for part in found)
    below = np.array([-0.05j, 0.1j])
    for part in found:
        assert not part.allowed(below)[0] and part.walls is not None
    assert len(module._regions(ROBOT, None, None, kept)) == len(fb.dexterous(ROBOT, 0.5, 0.3))


@pytest.mark.parametrize("page", [None, (0.1, 0.05)])
@pytest.mark.parametrize("count", [1, 2])
def test_what_does_not_fit_is_told_its_largest_scale(page, count, room, monkeypatch):
    module = importlib.import_module("fivebar.paths.placing.place")
    grown = Found(0.1, (0,), 0j, 0.0, 1.5)
    monkeypatch.setattr(Search, "starts", lambda search, scale, mixed: [])
    monkeypatch.setattr(Search, "largest", lambda search, mixed: grown)
    monkeypatch.setattr(module, "_regions", lambda *given: [room.part])
    strokes = [[(0, 0), (0.1, 0)], [(0, 0.1), (0.1, 0.1)]][:count]
    what = "path" if page is None else "page"
    words = f"place: the {what} does not fit at scale 9 with a clearance of 0.01 m: the largest"
    words += " scale found to fit is 1.5"
    if page is None and count == 2:
        words += ", in one aspect; strokes=True gives each stroke modes of its own"
    asked = {"path": fb.path(strokes)} if page is None else {"page": page}
    with pytest.raises(ValueError) as refused:
        fb.place(ROBOT, scale=9.0, constraints=fb.Constraints(clearance=0.01), **asked)
    assert str(refused.value) == words


@pytest.mark.parametrize("share, rooms", [(0.9, (1, 0)), (-0.1, (0, 0))])
def test_strokes_change_rooms_only_where_the_clearance_asks_for_it(room, share, rooms):
    """The first stroke is nearest to the border between the samples of it, by the dip there."""
    disc = fb.largest_disc(room.part)
    path = fb.path([Arc(tuple(disc.center), 0.4 * disc.radius, 0.0, 4.0)])
    samples = path(np.linspace(0, path.length, SAMPLES))[0] @ (1, 1j)
    least, _ = room.along(path)
    dip = room.exact(samples).min() - least
    assert dip > 1e-8
    search = search_of([path, path], [1, 2])
    elsewhere = SimpleNamespace(along=lambda placed, most=0.0: (-1.0, 0j))
    search.clearances = [room, elsewhere]
    search.exactly = lambda found: (least + share * dip, 0j)
    found = Found(1.0, (1, 0), search.middle, 0.0, 1.0)
    assert search.settled(found).which == rooms


def test_a_margin_is_kept_up_to_the_clearance(room):
    path = fb.path([(0, 0), (0.01, 0)])
    search = search_of([path], [1])
    search.clearances = [room]
    found = Found(0.0, (0,), fb.largest_disc(room.part).center @ (1, 1j), 0.3, 1.0)
    clearance, _ = search.exactly(found)
    assert clearance == pytest.approx(room.along(found.placement(search.middle)(path))[0])
    for share in (1 - 1e-6, 1 + 1e-6):
        search.margin = share * clearance
        search.improved = lambda start: start
        assert bool(search.best([found._replace(clearance=1.0)])) == (share < 1)


def test_a_placement_is_about_the_middle_of_the_paths():
    found = Found(0.0, (0,), 0.3 + 0.1j, 7.0, 2.0)
    placement = found.placement(0.05 - 0.02j)
    z = np.array([0.05 - 0.02j, 0.1 + 0.3j])
    expected = found.shift + 2.0 * np.exp(7j) * (z - (0.05 - 0.02j))
    there = placement(np.stack([z.real, z.imag], axis=-1)) @ (1, 1j)
    np.testing.assert_allclose(there, expected, atol=1e-14)
    assert placement.turn == pytest.approx(7.0 - 2 * np.pi) and placement.scale == 2.0


def test_samples_of_paths_have_their_corners_and_ends():
    path = fb.path([(0, 0), (0.1, 0), (0.1, 0.031), (0.02, 0.031)])
    seen = _samples(path, 12)
    for corner in (0, 0.1, 0.1 + 0.031j, 0.02 + 0.031j):
        assert np.abs(seen - corner).min() < 1e-15
    assert len(seen) == 14
    zigzag = fb.path([(k / 1000, k % 2 / 1000) for k in range(1000)])
    assert 200 < len(_samples(zigzag, 12)) <= 240 + 12
    two = search_of([path, fb.Placement((0.5, 0.0))(path)])
    assert set(two.owner) == {0, 1} and (np.diff(two.owner) >= 0).all()
    assert two.first.tolist() == [0, (two.owner[::THIN] == 0).sum()]
    assert two.middle == pytest.approx(0.3 + 0.0155j)


@pytest.mark.parametrize("low, high", [(True, True), (True, False), (False, True), (False, False)])
def test_shares_of_an_arc_and_their_rates(low, high):
    x = np.linspace(0.01, 0.99, 50)
    share, rate = _share(x, low, high)
    h = 1e-6
    change = (_share(x + h, low, high)[0] - _share(x - h, low, high)[0]) / (2 * h)
    np.testing.assert_allclose(rate, change, atol=1e-9)
    ends, slopes = _share(np.array([0.0, 1.0]), low, high)
    assert ends.tolist() == [0, 1] and slopes.tolist() == [
        0 if low else (2 if high else 1),
        0 if high else (2 if low else 1),
    ]


def test_boxes_of_pieces():
    rng = np.random.default_rng(9)
    for _ in range(30):
        angles = rng.uniform(-7, 7, 2)
        pieces = [Arc(tuple(rng.normal(size=2)), rng.uniform(0.1, 2), *angles)]
        pieces.append(Line(tuple(pieces[0].end), tuple(rng.normal(size=2))))
        path = fb.path(pieces)
        seen = path(np.union1d(np.linspace(0, path.length, 2001), path.knots))[0]
        found = bounds(path)
        np.testing.assert_allclose(found, [seen.min(axis=0), seen.max(axis=0)], atol=1e-5)
        assert (found[0] <= seen.min(axis=0) + 1e-12).all()
        assert (found[1] >= seen.max(axis=0) - 1e-12).all()


def test_whether_legs_cross():
    def pose(elbows, tip):
        return SimpleNamespace(elbows=np.array(elbows), xi=np.array(tip))

    robot = SimpleNamespace(d=2.0)
    assert not _legs_cross(robot, pose([(-2, 1), (2, 1)], (0, 2)))
    assert _legs_cross(robot, pose([(1.5, 1), (-1.5, 1)], (0, 2)))  # both proximal bars
    assert _legs_cross(robot, pose([(-2, 1), (-1.5, 0.5)], (0, 3))) is False
    assert _legs_cross(robot, pose([(-2, 1), (-3, 1.2)], (0, 3)))  # one of each
