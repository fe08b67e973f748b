"""A test drawing in numbers: its crosses, strokes, tables, and the distances that tell most."""

import io

import numpy as np
import pytest

import fivebar as fb
from fivebar.estimation.calibration.measured_robot import seen, values_of
from fivebar.estimation.calibration.sheet import sheet

ROBOT = fb.FiveBar(l11=0.2, l12=0.28, l21=0.21, l22=0.27, d=0.15)
MACHINE = fb.Machine(
    ROBOT, offset=(0.1, -0.05), ratio=(2.0, 1.0), frame=fb.Placement((0.2, 0.05), 0.3)
)


@pytest.fixture(scope="module")
def drawn():
    return sheet(MACHINE, "A5", (-1, -1))


def strokes_of(drawn):
    """The strokes with the pen down, lists of points; straight on while the pen stays down."""
    strokes = []
    for piece, down in zip(drawn.path.pieces, drawn.path.pen):
        if not down:
            continue
        if strokes and np.allclose(strokes[-1][-1], piece.start, atol=0) and len(strokes[-1]) < 5:
            strokes[-1].append(piece.end)
        else:
            strokes.append([piece.start, piece.end])
    return [np.array(stroke) for stroke in strokes]


def test_crosses_and_strokes_on_paper_that_fits(drawn):
    """12 mm stay free; the outer crosses are 11 mm inside, the first in a square of 11 mm."""
    width, height = 0.21 - 0.024, 0.148 - 0.024
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    in_robot = (drawn.crosses - (0.2, 0.05)) @ turn
    grid = in_robot.reshape(3, 4, 2)
    assert np.diff(grid[..., 0], axis=1) == pytest.approx((width - 0.022) / 3)
    assert np.diff(grid[..., 1], axis=0) == pytest.approx((height - 0.022) / 2)
    assert np.ptp(grid[..., 1], axis=1).max() < 1e-12
    border, mark, *arms = strokes_of(drawn)
    middle = drawn.crosses.mean(axis=0)
    corners = (border - middle) @ turn
    half = np.array([width, height]) / 2
    signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)])
    assert corners == pytest.approx(half * signs, abs=1e-12)
    assert (mark - drawn.crosses[0]) @ turn == pytest.approx(0.0055 * signs, abs=1e-12)
    assert len(arms) == 24
    for k, cross in enumerate(drawn.crosses):
        assert arms[2 * k] == pytest.approx(cross + np.array([(-0.003, 0), (0.003, 0)]))
        assert arms[2 * k + 1] == pytest.approx(cross + np.array([(0, -0.003), (0, 0.003)]))
    assert not drawn.path.pen[4] and all(drawn.path.pen[:4])
    pose = fb.igm(ROBOT, in_robot, drawn.working)
    assert (pose.q - (0.1, -0.05)) / (2.0, 1.0) == pytest.approx(drawn.readings, abs=1e-12)
    assert drawn.names == [f"{row}{column}" for row in "ABC" for column in (1, 2, 3, 4)]
    assert repr(drawn) == "<Sheet: 12 crosses, 24 distances, working (-1, -1)>"


def test_tables_of_a_drawing(drawn):
    points = drawn.crosses + 0.001
    points[5] = np.nan
    file = io.StringIO()
    drawn.points_to_csv(file, points)
    head, *rows = file.getvalue().splitlines()
    assert head == "q1,q2,working1,working2,x,y" and len(rows) == 11
    numbers = np.array([[float(cell) for cell in row.split(",")] for row in rows])
    kept = np.arange(12) != 5
    expected = np.hstack([drawn.readings, np.full((12, 2), -1.0), points])[kept]
    assert np.array_equal(numbers, expected)
    file = io.StringIO()
    drawn.drawing_to_csv(file)
    head, *rows = file.getvalue().splitlines()
    numbers = np.array([[float(cell) for cell in row.split(",")] for row in rows])
    assert head == "x (mm),y (mm),pen" and len(numbers) == len(drawn.path.pieces) + 1
    assert numbers[0, :2] == pytest.approx(1e3 * np.array(drawn.path.pieces[0].start), abs=1e-6)
    ends = np.array([piece.end for piece in drawn.path.pieces])
    assert numbers[1:, :2] == pytest.approx(1e3 * ends, abs=1e-6)
    assert numbers[0, 2] == 0 and np.array_equal(numbers[1:, 2], drawn.path.pen)
    file = io.StringIO()
    drawn.distances_to_csv(file)
    head, *rows = file.getvalue().splitlines()
    assert head == "cross,to_cross,q1,q2,working1,working2,to,distance (mm)"
    for row, (one, other) in zip(rows, drawn.pairs.tolist(), strict=True):
        first, second, q1, q2, *modes, to, distance = row.split(",")
        assert (first, second) == (drawn.names[one], drawn.names[other])
        assert [float(q1), float(q2)] == drawn.readings[one].tolist()
        assert modes == ["-1", "-1"] and int(to) == other + 1 and distance == ""


def test_distances_tell_more_than_others_would(drawn):
    """By the mean covariance of the crosses, lengths known to 0.5 mm and offsets to half a degree."""
    pose = fb.igm(ROBOT, MACHINE.frame.inverse(drawn.crosses), (-1, -1))
    points, slopes = seen(values_of(ROBOT), pose.q, pose.assembly)
    slopes = slopes[:, :, :7] * ([5e-4] * 5 + [9e-3] * 2)

    def off(pairs):
        one, other = np.transpose(pairs)
        gap = points[one] - points[other]
        along = gap / np.linalg.norm(gap, axis=1)[:, None]
        rows = np.einsum("ni,nik->nk", along, slopes[one] - slopes[other]) / 2e-4
        covariance = np.linalg.inv(rows.T @ rows + np.eye(7))
        return np.sqrt(np.einsum("nik,kl,nil->", slopes, covariance, slopes) / len(points))

    rng = np.random.default_rng(0)
    every = [(one, other) for one in range(12) for other in range(one)]
    others = [off(rng.permutation(every)[:24]) for _ in range(200)]
    assert len({tuple(sorted(pair)) for pair in drawn.pairs.tolist()}) == 24
    assert off(drawn.pairs) < min(others)
    assert off(drawn.pairs) < 1.25 * off(every)
