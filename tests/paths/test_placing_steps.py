"""Steps of the search of placements: borders to rounding, regions of strokes, holes in pages, growth."""

import importlib
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

import fivebar as fb
from fivebar.paths.placing.branch_and_bound import BranchAndBound, Cells
from fivebar.paths.placing.clearance import Clearance
from fivebar.paths.placing.place import Placed
from fivebar.paths.placing.search import Found, Search

ROBOT = fb.FiveBar()


@pytest.fixture(scope="module")
def rooms():
    parts = sorted(fb.aspects(ROBOT), key=lambda part: -part.area)
    return [Clearance(parts[0]), Clearance(parts[-1])]


def test_points_beside_the_border_are_within_to_rounding(rooms):
    """Also between an arc of it and the chords that the search uses first."""
    for room in rooms:
        for arc in room.arcs:
            s = (arc.s[:-1] + arc.s[1:])[1:-1] / 2
            z, dz = arc.curve(s)
            aside = 1e-9j * dz / np.abs(dz)  # on the left is the region
            assert room.within(z + aside).all() and not room.within(z - aside).any()


def search_in(rooms, paths, turn=0.0, margin=0.0, page=None):
    return Search(paths, rooms, turn, margin, page)


def test_each_stroke_is_put_into_the_region_that_has_most_room_for_it(rooms):
    paths = [fb.path([(0, 0), (0.01, 0)]), fb.path([(0, 0.2), (0.01, 0.2)])]
    search = search_in(rooms, paths)
    bounds = BranchAndBound(search, 1.0, True)
    rng = np.random.default_rng(3)
    middle = np.vstack([rng.uniform(-0.15, 0.15, (2, 40)), rng.uniform(0, 6, 40), np.ones(40)])
    cells = Cells(middle, 0 * middle, np.full(40, -1))
    chosen = set()
    for at in range(40):
        x, y, turn, scale = middle[:, at]
        z = x + 1j * y + scale * np.exp(1j * turn) * search.z
        room = np.array([each.rough(z)[0] for each in rooms])
        room = np.stack([room[:, search.owner == k].min(axis=1) for k in (0, 1)])
        which = bounds._which(cells, at)
        chosen.add(which)
        for k in (0, 1):
            assert room[k, which[k]] > room[k].max() - 3 * np.hypot(*rooms[0].steps)
    assert len(chosen) > 1
    alone = BranchAndBound(search, 1.0)
    assert alone._which(Cells(middle, 0 * middle, np.ones(40, dtype=int)), 3) == (1, 1)


def test_holes_bound_the_clearance_of_pages():
    page = fb.path([(0, 0), (0.3, 0), (0.3, 0.2), (0, 0.2), (0, 0)])
    holes = np.array([0.02 + 0.05j, -0.1j, 3.0])
    search = search_in([SimpleNamespace(holes=holes)], [page], page=(0.3, 0.2))
    bounds = BranchAndBound(search, 1.0)
    rng = np.random.default_rng(5)
    middle = np.vstack([rng.uniform(-0.2, 0.2, (2, 30)), rng.uniform(0, 6, 30), np.ones(30)])
    half = np.vstack([np.full((2, 30), 0.01), np.full(30, 0.1), np.full(30, 0.05)])

    def depth(at):
        x, y, turn, scale = at
        return search.off_page(holes, x + 1j * y, turn, scale).min(axis=1)

    cells = Cells(middle, half, np.zeros(30, dtype=int))
    known, bound = bounds._around_holes(cells, 0)
    np.testing.assert_allclose(known, depth(middle))
    assert 5 < np.isfinite(known).sum() < 30
    for _ in range(30):
        inside = middle + rng.uniform(-1, 1, middle.shape) * half
        seen = depth(inside)
        both = np.isfinite(seen) & np.isfinite(known)
        assert (seen[both] <= bound[both]).all()
    moved = np.hypot(0.01, 0.01) + 0.05 * search.size
    finite = np.isfinite(known)
    assert (bound[finite] - known[finite]).max() < moved + 0.1 * 2 * search.size
    same, exact = bounds._around_holes(Cells(middle, 0 * half, cells.region), 0)
    np.testing.assert_array_equal(same, exact)


@pytest.mark.deep
def test_a_path_grows_until_its_margin_is_left(rooms):
    disc = fb.largest_disc(rooms[0].part)
    path = fb.path([(0, 0), (0.01, 0), (0.01, 0.01)])
    margin = 0.3 * disc.radius
    search = search_in(rooms, [path], None, margin)
    start = Found(0.0, (0,), disc.center @ (1, 1j), 0.4, 1.0)
    found = search.grown(start)
    clearance, _ = search.exactly(found)
    assert margin < clearance < margin + 1e-5 and found.scale > 5
    assert search.keeps(found) and not search.keeps(found._replace(scale=1.001 * found.scale))
    assert search.at_scale(found, 1.001 * found.scale) is None
    search.improved = lambda start, growing=False: found if growing else start
    search.keeps = lambda found: True
    start = start._replace(clearance=2 * margin)
    assert search.grown(start, 1.001 * found.scale) is None
    assert search.grown(start, 0.999 * found.scale) == found
    assert search.grown(start._replace(clearance=0.999 * margin)) is None
    assert search.at_scale(found, 0.5 * found.scale).scale == 0.5 * found.scale


class Region(NamedTuple):
    working: tuple
    number: int
    det_A: float = 0.0


def test_a_placement_in_words():
    part, other = Region((1, -1), 3), Region((-1, -1), 5, 0.1)
    path = fb.path([(0, 0), (1, 0)])
    placed = Placed(path, fb.Placement(), part, 0.25, np.zeros(2))
    assert placed.working == (1, -1) and placed.scale == 1.0
    words = "working (+1, -1), aspect 3, 0.25 m from its boundary"
    assert repr(placed) == f"<Placed: {fb.Placement()!r}, {words}>"
    region = Placed(path, fb.Placement(), other, 0.25, np.zeros(2), 0.26)
    assert repr(region).endswith(
        "working (-1, -1), region 5, 0.25 m from its boundary, 0.26 m at most>"
    )
    both = Placed(
        path,
        fb.Placement(),
        part,
        0.25,
        np.zeros(2),
        None,
        2.0,
        2.5,
        ((path, part), (path, other), (path, part)),
    )
    words = "working (+1, -1), (-1, -1), aspects 3, 5, 0.25 m from its boundary"
    assert repr(both).endswith(f"{words}, scale 2.5 at most>")


@pytest.mark.parametrize("scale, page", [(1.5, None), (None, (0.02, 0.01))])
def test_what_is_found_is_handed_on(rooms, monkeypatch, scale, page):
    """The path in its place, how near it comes to the border and where, and what was proved."""
    module = importlib.import_module("fivebar.paths.placing.place")
    room = rooms[0]
    centre = fb.largest_disc(room.part).center
    found = Found(0.1, (0,), centre @ (1, 1j), 7.0, 1.5)
    asked = []

    def best(search, scale):
        asked.append((search.margin, search.turn, scale, search.page, len(search.clearances)))
        return found, 2.5

    monkeypatch.setattr(module, "_best", best)
    monkeypatch.setattr(module, "_regions", lambda *given: [room.part])
    monkeypatch.setattr(module, "Clearance", lambda part: room)
    path = fb.path([(0, 0), (0.03, 0), (0.03, 0.02)])
    options = {"path": path} if page is None else {"page": page}
    kept = fb.Constraints(clearance=0.01)
    placed = fb.place(ROBOT, turn=0.4, scale=scale, constraints=kept, **options)
    assert asked == [(0.01, 0.4, scale, page, 1)]
    assert (
        placed.aspect is room.part and placed.scale == 1.5 and placed.working == room.part.working
    )
    assert placed.placement.turn == pytest.approx(7 - 2 * np.pi)
    width, height = (0.03, 0.02) if page is None else page
    np.testing.assert_allclose(placed.placement((width / 2, height / 2)), centre, atol=1e-15)
    start = placed.path(0.0)[0]
    np.testing.assert_allclose(start, placed.placement((0.0, 0.0)), atol=1e-15)
    assert placed.clearance == pytest.approx(room.along(placed.path)[0], abs=1e-9)
    assert room.exact(np.array([placed.nearest @ (1, 1j)]))[0] == pytest.approx(placed.clearance)
    bounds = (2.5, None, None) if scale else (None, 1.5, 2.5)
    assert (placed.clearance_bound, placed.largest, placed.largest_bound) == bounds
    ((stroke, part),) = placed.strokes
    assert part is room.part and stroke.length == placed.path.length


def test_rooms_without_the_margin_are_left_out_of_the_search(rooms, monkeypatch):
    """But the bound counts what a grid may not see of them."""
    module = importlib.import_module("fivebar.paths.placing.place")
    narrow = SimpleNamespace(part=rooms[1].part, most=0.01, least_seen=0.3)
    given = iter([narrow, rooms[0], narrow, narrow])
    centre = fb.largest_disc(rooms[0].part).center @ (1, 1j)
    found = Found(0.1, (0,), centre, 0.0, 1.0)
    monkeypatch.setattr(module, "Clearance", lambda part: next(given))
    monkeypatch.setattr(module, "_regions", lambda *given: [room.part for room in rooms])
    monkeypatch.setattr(module, "_best", lambda search, scale: (found, 0.2))
    kept = fb.Constraints(clearance=0.01)
    path = fb.path([(0, 0), (0.01, 0)])
    placed = fb.place(ROBOT, path, constraints=kept)
    assert placed.clearance_bound == 0.3 and placed.aspect is rooms[0].part
    for working, words in ((None, "workspace keeps"), ((1, 1), "workspace in these modes keeps")):
        given = iter([narrow, narrow])
        with pytest.raises(ValueError, match=f"nothing of the {words} the clearance"):
            fb.place(ROBOT, path, constraints=kept, working=working)


def test_what_cannot_be_placed():
    path = fb.path([(0, 0), (0.01, 0)])
    with pytest.raises(
        ValueError, match="place refuses a robot with kind = .biglide.: .* strips without ends"
    ):
        fb.place(fb.Biglide(), path)
    for options in ({}, {"path": path, "page": (1, 1)}):
        with pytest.raises(ValueError, match="give either a path or a page"):
            fb.place(ROBOT, **options)


@pytest.mark.parametrize("scale", [1.0, None])
def test_strokes_go_apart_only_where_one_region_does_not_hold_them(monkeypatch, scale):
    module = importlib.import_module("fivebar.paths.placing.place")
    answers = {}

    class Fake:
        def __init__(self, search, scale, mixed=False):
            self.key = mixed

        def run(self, most=None):
            return answers[self.key]

    monkeypatch.setattr(module, "BranchAndBound", Fake)
    one, apart = Found(0.1, (0, 0), 0j, 0.0, 1.0), Found(0.2, (0, 1), 0j, 0.0, 2.0)
    both, single = (SimpleNamespace(paths=paths, grown=lambda *_: None) for paths in ([1, 2], [1]))
    answers = {False: (one, 0.5), True: (apart, 0.7)}
    assert module._best(single, scale) == (one, 0.5)
    assert module._best(both, scale) == ((one, 0.5) if scale else (apart, 0.7))
    answers = {False: (None, 0.5), True: (apart, 0.3)}
    assert module._best(both, scale) == ((apart, 0.3) if scale else (apart, 0.5))
    assert module._best(single, scale) == (None, 0.5)
    answers = {False: (None, 0.5), True: (None, 0.3)}
    assert module._best(both, None) == (None, 0.5)
