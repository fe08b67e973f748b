"""Places of paths: closed forms, symmetric robots, exact rooms, and what does not fit."""

import numpy as np
import pytest

import fivebar as fb

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
        ValueError, match="does not fit at scale 9 .* largest scale found to fit is ([0-9.]+)"
    ) as refused:
        fb.place(
            ROBOT,
            RECTANGLE,
            scale=9.0,
            turn=0.0,
            working=(1, 1),
            constraints=fb.Constraints(clearance=0.01),
        )
    largest = float(str(refused.value).split()[-1])
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


def test_bad_input():
    with pytest.raises(ValueError, match="strips without ends"):
        fb.place(fb.Biglide(), RECTANGLE)
    with pytest.raises(TypeError, match="path must be a Path"):
        fb.place(ROBOT, [(0, 0), (1, 1)])
    with pytest.raises(ValueError, match="place: the constraint torque is not kept here"):
        fb.place(ROBOT, RECTANGLE, constraints=fb.Constraints(torque=0.1))
    with pytest.raises(ValueError, match="nothing of the workspace"):
        fb.place(ROBOT, RECTANGLE, constraints=fb.Constraints(clearance=1.0))
