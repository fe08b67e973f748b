"""Steps of the search of placements: borders to rounding, regions of strokes, holes in pages, growth."""

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
    assert search.grown(start, 1.001 * found.scale) is None
    assert search.at_scale(found, 1.001 * found.scale) is None
    smaller = search.at_scale(found, 0.5 * found.scale)
    assert smaller.scale == 0.5 * found.scale and smaller.clearance > margin


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
    assert repr(region).endswith("working (-1, -1), region 5, 0.25 m from its boundary, 0.26 m at most>")  # fmt: skip
    both = Placed(
        path, fb.Placement(), part, 0.25, np.zeros(2), None, 2.0, 2.5,
        ((path, part), (path, other), (path, part)),
    )  # fmt: skip
    words = "working (+1, -1), (-1, -1), aspects 3, 5, 0.25 m from its boundary"
    assert repr(both).endswith(f"{words}, scale 2.5 at most>")
