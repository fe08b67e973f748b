"""Steps of the search of placements: borders to rounding, regions of strokes, holes in pages, growth."""

import importlib
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

import fivebar as fb
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


def test_holes_count_where_the_search_of_a_page_begins():
    """A place of the page around a hole has no more than what the hole's depth leaves."""
    page = fb.path([(0, 0), (0.3, 0), (0.3, 0.2), (0, 0.2), (0, 0)])
    holes = np.array([0.02 + 0.05j, -0.1j])
    room = SimpleNamespace(holes=holes, low=-1 - 1j, high=1 + 1j, coarse=lambda z: 0 * z.real + 1)
    search = search_in([room], [page], turn=None, page=(0.3, 0.2))
    starts = search.starts(1.0, False)
    assert starts and all(start.clearance == 1.0 for start in starts)
    for start in starts:
        away = (holes - start.shift) * np.exp(-1j * start.turn)
        assert ((np.abs(away.real) > 0.15) | (np.abs(away.imag) > 0.1)).all()


@pytest.mark.deep
def test_a_path_grows_until_its_margin_is_left(rooms):
    disc = fb.largest_disc(rooms[0].part)
    path = fb.path([(0, 0), (0.01, 0), (0.01, 0.01)])
    margin = 0.3 * disc.radius
    search = search_in(rooms, [path], None, margin)
    start = Found(0.0, (0,), disc.center @ (1, 1j), 0.4, 1.0)
    found = search.grown(search.best([start]))
    clearance, _ = search.exactly(found)
    assert margin < clearance < margin + 1e-5 and found.scale > 5
    assert found.clearance == clearance
    assert search.best([found]) and not search.best([found._replace(scale=1.001 * found.scale)])
    again = search.largest(False)
    assert again.scale > 0.999 * found.scale and search.exactly(again)[0] > margin


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
    region = Placed(path, fb.Placement(), other, 0.25, np.zeros(2))
    assert repr(region).endswith("working (-1, -1), region 5, 0.25 m from its boundary>")
    both = Placed(
        path,
        fb.Placement(),
        part,
        0.25,
        np.zeros(2),
        2.0,
        ((path, part), (path, other), (path, part)),
    )
    words = "working (+1, -1), (-1, -1), aspects 3, 5, 0.25 m from its boundary"
    assert repr(both).endswith(f"{words}>")


@pytest.mark.parametrize("scale, page", [(1.5, None), (None, (0.02, 0.01))])
def test_what_is_found_is_handed_on(rooms, monkeypatch, scale, page):
    """The path in its place, how near it comes to the border and where, and what was proved."""
    module = importlib.import_module("fivebar.paths.placing.place")
    room = rooms[0]
    centre = fb.largest_disc(room.part).center
    found = Found(0.1, (0,), centre @ (1, 1j), 7.0, 1.5)
    asked = []

    def best(search, starts):
        asked.append((search.margin, search.turn, starts, search.page, len(search.clearances)))
        return found

    monkeypatch.setattr(Search, "starts", lambda search, scale, mixed: scale)
    monkeypatch.setattr(Search, "best", best)
    monkeypatch.setattr(Search, "largest", lambda search, mixed: best(search, None))
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
    assert placed.largest == (None if scale else 1.5)
    ((stroke, part),) = placed.strokes
    assert part is room.part and stroke.length == placed.path.length


def test_rooms_without_the_margin_are_left_out_of_the_search(rooms, monkeypatch):
    module = importlib.import_module("fivebar.paths.placing.place")
    narrow = SimpleNamespace(part=rooms[1].part, most=0.01)
    given = iter([narrow, rooms[0], narrow, narrow])
    centre = fb.largest_disc(rooms[0].part).center @ (1, 1j)
    found = Found(0.1, (0,), centre, 0.0, 1.0)
    monkeypatch.setattr(module, "Clearance", lambda part: next(given))
    monkeypatch.setattr(module, "_regions", lambda *given: [room.part for room in rooms])
    monkeypatch.setattr(Search, "starts", lambda search, scale, mixed: search.clearances)
    monkeypatch.setattr(Search, "best", lambda search, starts: found)
    kept = fb.Constraints(clearance=0.01)
    path = fb.path([(0, 0), (0.01, 0)])
    placed = fb.place(ROBOT, path, constraints=kept)
    assert placed.aspect is rooms[0].part
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


@pytest.mark.parametrize("scale", [1.5, None])
@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("fits", [True, False])
def test_strokes_go_apart_only_where_one_region_does_not_hold_them(
    rooms, monkeypatch, scale, count, fits
):
    """Where the scale is free, also where they become larger."""
    module = importlib.import_module("fivebar.paths.placing.place")
    given = iter(rooms)
    monkeypatch.setattr(module, "Clearance", lambda part: next(given))
    monkeypatch.setattr(module, "_regions", lambda *given: [room.part for room in rooms])
    at = fb.largest_disc(rooms[0].part).center @ (1, 1j)
    together = Found(0.1, (0,) * count, at, 0.0, 1.5)
    apart = Found(0.2, (0, 1)[:count], at, 0.0, 2.0)
    asked = []

    def best(search, mixed):
        asked.append(mixed)
        return apart if mixed else together if fits else None

    monkeypatch.setattr(Search, "starts", lambda search, scale, mixed: mixed)
    monkeypatch.setattr(Search, "best", best)
    monkeypatch.setattr(Search, "largest", best)
    monkeypatch.setattr(Search, "settled", lambda search, found: found)
    path = fb.path([[(0, 0), (0.01, 0)], [(0, 0.01), (0.01, 0.01)]][:count])
    if count == 1 and not fits:
        with pytest.raises(ValueError, match="nothing larger than a point"):
            fb.place(ROBOT, path, scale=scale, strokes=True)
        return
    placed = fb.place(ROBOT, path, scale=scale, strokes=True)
    goes_apart = count == 2 and not (fits and scale)
    assert placed.scale == (2.0 if goes_apart else 1.5)
    assert len({part.number for _, part in placed.strokes}) == 1 + goes_apart
    assert asked == ([False, True] if goes_apart else [False])
