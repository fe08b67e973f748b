"""Places of paths: closed forms, symmetric robots, exact rooms, and what does not fit."""

import re

import numpy as np
import pytest

import fivebar as fb
from fivebar.paths.placing.clearance import Clearance
from fivebar.paths.placing.search import STARTS, THIN, Search, _lattice

ROBOT = fb.FiveBar()
RECTANGLE = fb.path([(0, 0), (0.06, 0), (0.06, 0.04), (0, 0.04), (0, 0)])


def room_of(placed):
    """From the distances to the loci, at points along the path."""
    xi = placed.path(np.linspace(0, placed.path.length, 4001))[0]
    assert placed.aspect.contains(xi).all()
    return fb.locus_distance(ROBOT, xi, placed.working)[0].min()


def test_room_is_exact_and_a_shift_aside_has_less():
    placed = fb.place(ROBOT, RECTANGLE, working=(-1, -1))
    assert placed.clearance == pytest.approx(room_of(placed), abs=1e-9) and placed.clearance > 0.05
    assert placed.scale == 1 and placed.working == (-1, -1)
    rng = np.random.default_rng(4)
    for shift in 1e-3 * rng.normal(size=(12, 2)):
        moved = fb.Placement(tuple(shift))(placed.path)
        xi = moved(np.linspace(0, moved.length, 800))[0]
        assert fb.locus_distance(ROBOT, xi, placed.working)[0].min() < placed.clearance + 1e-6


@pytest.mark.parametrize("mixed", [False, True])
def test_the_search_begins_where_there_is_most_clearance(mixed):
    """No random placement has more than the first start, but for the steps of both grids."""
    parts = sorted(fb.aspects(ROBOT), key=lambda part: -part.area)
    rooms = [Clearance(parts[0]), Clearance(parts[1])]
    paths = [fb.path([(0, 0), (0.03, 0), (0.03, 0.02)]), fb.path([(0.01, 0.04), (0.05, 0.04)])]
    search = Search(paths, rooms, None, 0.0)
    scale = 0.8
    starts = search.starts(scale, mixed)
    clearances = [start.clearance for start in starts]
    assert len(starts) == STARTS and clearances == sorted(clearances, reverse=True)
    few = search.z[::THIN]
    owner = search.owner[::THIN]

    def best_at(shift, turn):
        """The clearance, each path in one of the rooms, or both in the same one."""
        z = shift + scale * np.exp(1j * turn) * few
        away = [room.rough(z)[0] for room in rooms]
        table = np.array([[own[owner == k].min() for k in (0, 1)] for own in away])
        return table.max(axis=0).min() if mixed else table.min(axis=1).max()

    step = max(np.hypot(*room.steps) for room in rooms)
    for start in starts:
        assert start.scale == scale and (mixed or start.which[0] == start.which[1])
        assert best_at(start.shift, start.turn) == pytest.approx(start.clearance, abs=step)
    rng = np.random.default_rng(3)
    size = max(abs(room.high - room.low) for room in rooms)
    places = rng.uniform(-0.5, 0.5, (300, 2)) @ (1, 1j) * size
    seen = max(best_at(z, turn) for z, turn in zip(places, rng.uniform(0, 7, 300)))
    assert 0 < seen < clearances[0] + step + size / 20 + search.size * np.pi / 16


def test_points_of_a_page_are_in_the_middles_of_its_even_parts():
    points = _lattice((0.3, 0.2), 4)
    parts = np.floor(points.real / 0.075) + 4 * np.floor(points.imag / 0.05)
    assert sorted(parts) == list(range(16)) and points.mean() == pytest.approx(0.15 + 0.1j)


def test_a_grid_of_clearances_holds_the_whole_border():
    for part in fb.aspects(ROBOT)[:3]:
        room = Clearance(part)
        for low, high, along in (
            (room.low.real, room.high.real, room.border.real),
            (room.low.imag, room.high.imag, room.border.imag),
        ):
            assert low < along.min() < along.max() < high


@pytest.mark.deep
def test_a_point_like_path_lies_where_the_largest_disc_does():
    tiny = fb.path([(0, 0), (1e-6, 0)])
    placed = fb.place(ROBOT, tiny)
    assert placed.clearance == pytest.approx(
        max(fb.largest_disc(part).radius for part in fb.aspects(ROBOT)), abs=2e-4
    )


@pytest.mark.deep
def test_what_is_kept_and_what_does_not_fit():
    constraints = fb.Constraints(
        half_planes=[(0, 1, 0.01)],
        det_A=0.2,
        collisions=fb.LinkCollisions(0.005, layers=(1, 2, 1, 3)),
    )
    placed = fb.place(ROBOT, RECTANGLE, turn=0.0, constraints=constraints)
    xi = placed.path(np.linspace(0, placed.path.length, 2001))[0]
    assert (
        constraints.satisfied(fb.igm(ROBOT, xi, placed.working)).all()
        and placed.placement.turn == 0
    )
    with pytest.raises(
        ValueError, match="does not fit at scale 9 .* largest scale found to fit is"
    ) as refused:
        fb.place(
            ROBOT,
            RECTANGLE,
            scale=9.0,
            turn=0.0,
            working=(1, 1),
            constraints=fb.Constraints(clearance=0.01),
        )
    largest = float(re.search(r"found to fit is ([0-9.]+[0-9])", str(refused.value))[1])
    grown = fb.place(
        ROBOT,
        RECTANGLE,
        scale=None,
        turn=0.0,
        working=(1, 1),
        constraints=fb.Constraints(clearance=0.01),
    )
    assert grown.largest == grown.scale == pytest.approx(largest, rel=1e-5)
    assert room_of(grown) == pytest.approx(0.01, abs=2e-4) and grown.clearance >= 0.01
    # The largest upright rectangle that keeps the margin holds one of this shape that is not larger.
    inner = max(
        min((r.x_max - r.x_min) / 0.06, (r.y_max - r.y_min) / 0.04)
        for r in (
            fb.largest_rectangle(part, fb.Constraints(clearance=0.01))
            for part in fb.aspects(ROBOT)[:2]
        )
    )
    assert grown.scale >= inner


@pytest.mark.deep
def test_strokes_with_modes_of_their_own_as_few_as_need_be():
    # One stroke above the motors, two below: in the lab's modes Type 2 is between them.
    ends = [[(0, 0.12), (0.01, 0.12)], [(0, -0.12), (0.01, -0.12)], [(0, -0.13), (0.01, -0.13)]]
    path = fb.path(ends)
    with pytest.raises(ValueError, match=r"strokes=True gives each stroke modes of its own"):
        fb.place(ROBOT, path, turn=0.0, working=(-1, -1))
    placed = fb.place(ROBOT, path, turn=0.0, working=(-1, -1), strokes=True)
    clearances = []
    for (stroke, part), points in zip(placed.strokes, ends):
        xi = stroke(np.linspace(0, stroke.length, 2001))[0]
        np.testing.assert_allclose(xi[[0, -1]], placed.placement(points), atol=1e-12)
        assert part.contains(xi).all()
        clearances.append(fb.locus_distance(ROBOT, xi, part.working)[0].min())
    assert min(clearances) == pytest.approx(placed.clearance, abs=1e-8) and placed.clearance > 0.02
    numbers = [part.number for _, part in placed.strokes]
    assert numbers[0] != numbers[1] == numbers[2] and "aspects" in repr(placed)
    together = fb.place(ROBOT, fb.path(ends[1:]), turn=0.0, working=(-1, -1), strokes=True)
    assert len({part for _, part in together.strokes}) == 1


def random_problem(seed):
    """A robot, a path, a half-plane and working modes."""
    rng = np.random.default_rng(seed)
    size = rng.uniform(0.05, 0.2)
    lengths = (
        size * rng.uniform(0.7, 1.4, 4)
        if seed % 2
        else size * np.repeat(rng.uniform(0.8, 1.4, 2), 2)[[0, 2, 1, 3]]
    )
    robot = fb.FiveBar(*lengths, size * rng.uniform(0.3, 1.3))
    path = fb.path(size * rng.uniform(0.2, 1.2) * rng.uniform(-0.5, 0.5, (rng.integers(2, 7), 2)))
    angle = rng.uniform(0, 2 * np.pi)
    half_plane = np.cos(angle), np.sin(angle), size * rng.uniform(-0.3, 0.5)
    return rng, robot, path, half_plane, tuple(rng.choice([-1, 1], 2).tolist())


def clearance_or_none(robot, path, **options):
    try:
        placed = fb.place(robot, path, **options)
    except ValueError as error:
        assert "the largest scale found to fit is" in str(error)
        return 0.0
    assert placed.clearance > 0
    return placed.clearance


@pytest.mark.deep
@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(k, marks=pytest.mark.deep) for k in range(1, 24))]
)
def test_a_constraint_more_never_gives_more_clearance(seed):
    _, robot, path, half_plane, working = random_problem(seed)
    kept = fb.Constraints(half_planes=[half_plane])
    free = clearance_or_none(robot, path)
    half = clearance_or_none(robot, path, constraints=kept)
    in_modes = clearance_or_none(robot, path, working=working)
    both = clearance_or_none(robot, path, constraints=kept, working=working)
    narrower = fb.Constraints(half_planes=[half_plane], sin=0.2)
    least = clearance_or_none(robot, path, constraints=narrower, working=working, turn=0.5)
    slack = 2e-3 * np.ptp(path(path.knots)[0], axis=0).max()
    for tighter, looser in [
        (half, free),
        (in_modes, free),
        (both, half),
        (both, in_modes),
        (least, both),
    ]:
        assert tighter <= 1.0101 * looser + slack


@pytest.mark.deep
@pytest.mark.parametrize("seed", [4, 5])
def test_no_random_placement_has_more_clearance(seed):
    rng, robot, path, _, working = random_problem(seed)
    placed = fb.place(robot, path, working=working)
    xi = path(np.linspace(0, path.length, 60))[0]
    centre = placed.path(np.linspace(0, placed.path.length, 60))[0].mean(axis=0)
    parts = [part for part in fb.aspects(robot) if part.working == working]
    best = 0.0
    for k in range(400):
        near = k % 2  # around the placement found, and all over the workspace
        turn = placed.placement.turn + 0.1 * rng.normal() if near else rng.uniform(0, 2 * np.pi)
        turned = fb.Placement(turn=turn)(xi)
        at = (
            centre + 0.02 * rng.normal(size=2)
            if near
            else rng.uniform(-1, 1, 2) * (robot.l11 + robot.l12)
        )
        points = turned - turned.mean(axis=0) + at
        if any(part.contains(points).all() for part in parts):
            best = max(best, fb.locus_distance(robot, points, working)[0].min())
    assert 0 < best <= 1.01 * placed.clearance  # of a few points of the path it is more


@pytest.mark.deep
def test_a_page_keeps_the_clearance_all_over():
    # There is a hole in this robot's aspect, and the outline lies best around it.
    robot = fb.FiveBar(0.09, 0.11, 0.09, 0.11, 0.03)
    width, height = 0.16, 0.12
    corners = [(0, 0), (width, 0), (width, height), (0, height), (0, 0)]
    outline = fb.place(robot, fb.path(corners), working=(1, -1))
    page = fb.place(robot, page=(width, height), working=(1, -1))
    x, y = np.meshgrid(np.linspace(0, width, 60), np.linspace(0, height, 45))
    inner = np.stack([x, y], axis=-1)

    def clearance(placed):
        points = placed.placement(inner)
        inside = placed.aspect.contains(points)
        return fb.locus_distance(robot, points[inside], (1, -1))[0].min() if inside.all() else 0.0

    assert clearance(outline) < 0.004 < 0.02 < outline.clearance
    assert page.clearance == pytest.approx(clearance(page), abs=1e-4)
    assert page.clearance < outline.clearance
    np.testing.assert_allclose(page.path(page.path.knots)[0], page.placement(corners), atol=1e-12)


@pytest.mark.deep
def test_a_page_as_large_as_it_fits_is_the_largest_rectangle_of_its_ratio():
    kept = fb.Constraints(clearance=0.01)
    page = fb.place(
        ROBOT, page=(0.021, 0.0148), turn=0.0, scale=None, working=(-1, -1), constraints=kept
    )
    parts = [part for part in fb.aspects(ROBOT) if part.working == (-1, -1)]
    boxes = [
        fb.largest_rectangle(part, kept, ratio=0.021 / 0.0148) for part in parts[:1] + parts[-1:]
    ]
    height = max(box.y_max - box.y_min for box in boxes) / 0.0148
    assert page.largest == page.scale >= 0.999 * height


@pytest.mark.deep
def test_a_page_that_does_not_fit():
    with pytest.raises(ValueError, match="the page does not fit at scale 1"):
        fb.place(ROBOT, page=(0.21, 0.148), constraints=fb.Constraints(clearance=0.002), turn=0.0)


def test_bad_input():
    with pytest.raises(ValueError, match=r"give either a path or a page=\(width, height\)"):
        fb.place(ROBOT)
    with pytest.raises(ValueError, match="either a path or a page"):
        fb.place(ROBOT, RECTANGLE, page=(0.1, 0.1))
    with pytest.raises(ValueError, match="page's width"):
        fb.place(ROBOT, page=(-0.1, 0.1))
    with pytest.raises(ValueError, match="strips without ends"):
        fb.place(fb.Biglide(), RECTANGLE)
    with pytest.raises(TypeError, match="path must be a Path"):
        fb.place(ROBOT, [(0, 0), (1, 1)])
    with pytest.raises(ValueError, match="place: the constraint torque is not kept here"):
        fb.place(ROBOT, RECTANGLE, constraints=fb.Constraints(torque=0.1))
    with pytest.raises(ValueError, match="nothing of the workspace"):
        fb.place(ROBOT, RECTANGLE, constraints=fb.Constraints(clearance=1.0))


@pytest.mark.deep
def test_as_large_as_it_fits_whatever_else_is_free():
    """A sheet that may turn is as large upright as lying, and no smaller than in modes or a turn that are given."""
    sheet = (0.21, 0.148)
    free = fb.place(ROBOT, page=sheet, scale=None).scale
    assert fb.place(ROBOT, page=sheet[::-1], scale=None).scale == pytest.approx(free, rel=2e-3)
    for given in (dict(working=(-1, -1)), dict(turn=0.0)):
        assert fb.place(ROBOT, page=sheet, scale=None, **given).scale < 1.002 * free
