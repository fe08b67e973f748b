"""Curves traced and cut into pieces, of closed forms of their own; circles of the legs; curves of one det A."""

import numpy as np
import pytest

from fivebar.singularities.locus import (
    Locus,
    Vertex,
    divided,
    modes_of,
    pairs,
    pieces_of,
    trace,
    type_of,
    values_of,
)
from fivebar.singularities.margins import Singularity

QUARTERS = np.linspace(0, 2 * np.pi, 5)


def circle(t):
    return np.exp(1j * t), 1j * np.exp(1j * t)


def astroid(t):
    """With a cusp at each quarter."""
    c, s = np.cos(t), np.sin(t)
    return c**3 + 1j * s**3, 3 * c * s * (1j * s - c)


def looped(t):
    """A straight line but for a loop that is narrower than 1 / 192 of what is run through."""
    width, fine = 2e-4, np.linspace(-40, 40, 40001)
    x = np.clip((t - 1.0052) / width, -40, 40)
    along = np.exp(2j * np.pi / (1 + np.exp(-fine)))
    run = np.append(0, np.cumsum(along[1:] + along[:-1]) * (fine[1] - fine[0]) / 2)
    return t - width * x + width * np.interp(x, fine, run), np.exp(2j * np.pi / (1 + np.exp(-x)))


def turns(z, t, cusps=()):
    """By how much the direction changes from chord to chord, but at the cusps."""
    turn = np.abs(np.angle(np.diff(z)[1:] / np.diff(z)[:-1]))
    return turn[~np.isin(t[1:-1], cusps)]


def step(t):
    """A straight line but for a step between two of 193 points, of which both have its direction."""
    x = np.clip((t - 0.5) * 192, 0, 1)
    return t + 0.026j / 192 * x**3 * (10 - x * (15 - 6 * x)), 1 + 0.78j * (x * (1 - x)) ** 2


def wave(t):
    return t + 1j * np.sin(40 * t) / 40, 1 + 1j * np.cos(40 * t)


@pytest.mark.parametrize(
    "curve, edges, turning, number, shortest",
    [
        (circle, QUARTERS[[0, -1]], 2 * np.pi, 577, 0.0109),
        (circle, np.array([0.3, 0.30001, 2.0]), 1.7, 197, 2.4e-6),
        (circle, QUARTERS[[0, -1]] + 0.7, 2 * np.pi, 577, 0.0109),
        (astroid, QUARTERS, 6.15, 569, 4e-4),
        (astroid, np.array([0.4, np.pi / 2, 1.7]), 1.29, 194, 6e-5),
        (looped, np.array([0.0, 2.0]), 2 * np.pi, 918, 9e-7),
        (step, np.array([0.0, 1.0]), 0.0934, 206, 3.2e-4),
        (wave, np.array([0.0, 1.0]), 20.2, 1879, 1.8e-4),
    ],
)
def test_a_traced_curve_turns_by_less_than_a_degree_from_point_to_point(
    curve, edges, turning, number, shortest
):
    """turning: of all of it; number of points, and the shortest way between two, are no worse than they have been."""
    t, z = trace(curve, edges, 1.0)
    assert (
        np.isin(edges, t).all()
        and (np.diff(t) > 0).all()
        and (t[0], t[-1]) == (edges[0], edges[-1])
    )
    np.testing.assert_array_equal(z, curve(t)[0])
    turn = turns(z, t, QUARTERS)
    assert turn.max() < np.radians(1) and turn.sum() == pytest.approx(turning, rel=0.01)
    assert len(t) <= number and np.abs(np.diff(z)).min() > shortest
    # Of another unit of length, or of the parameter, the same points.
    for unit, clock in ((2.0**30, 1.0), (2.0**-30, 1.0), (1.0, 2.0**30), (1.0, 2.0**-30)):
        by = unit, unit * clock
        again, scaled = trace(
            lambda s, by=by, clock=clock: [k * w for k, w in zip(by, curve(s * clock))],
            edges / clock,
            unit,
        )
        np.testing.assert_array_equal(again * clock, t)
        np.testing.assert_array_equal(scaled, unit * z)


def test_a_part_of_a_curve_is_traced_as_densely_as_all_of_it():
    whole, _ = trace(circle, QUARTERS[[0, -1]], 1.0)
    part, _ = trace(circle, QUARTERS[:2], 1.0, period=2 * np.pi)
    np.testing.assert_allclose(part, whole[whole <= part[-1] + 1e-9], rtol=0, atol=1e-15)
    assert len(trace(circle, np.array([0.0, 1e-3]), 1.0, period=2 * np.pi)[0]) == 5


def test_a_curve_of_one_point():
    for edges, curve in (
        (np.zeros(2), circle),
        (QUARTERS, lambda t: (1 + 1e-14 * circle(t)[0], 1e-14 * circle(t)[1])),
    ):
        t, z = trace(curve, edges, 1.0)
        assert t.tolist() == [0.0] and z == pytest.approx([1.0], abs=2e-14)
    assert len(trace(lambda t: (1e-12 * circle(t)[0], 1e-12 * circle(t)[1]), QUARTERS, 1.0)[0]) > 1


def test_a_curve_with_a_jump_ends():
    t, z = trace(
        lambda t: (t + np.where(t > 0.3, 1j, 0), np.ones(len(t))), np.array([0.0, 1.0]), 1.0
    )
    assert np.diff(t).min() > 1e-15 and len(t) < 1000 and z[-1] == 1 + 1j


def around(t):
    """Angles 3 t and -2 t modulo full turns."""
    return np.angle(np.exp(3j * t)) + 1j * np.angle(np.exp(-2j * t)), np.full(len(t), 3 - 2j)


def test_angles_are_continuous():
    t, z = trace(around, np.array([-1.0, 4.0]), 2 * np.pi, angles=True)
    np.testing.assert_allclose(z - z[0], (3 - 2j) * (t + 1), rtol=0, atol=1e-14)
    assert z[0] == around(t[:1])[0] and len(t) == 193
    t, z = trace(
        lambda t: (around(100 * t)[0], 100 * around(t)[1]),
        np.array([0.1, 6.0]),
        2 * np.pi,
        angles=True,
    )
    np.testing.assert_allclose(z - z[0], (300 - 200j) * (t - 0.1), rtol=0, atol=1e-12)
    assert len(t) <= 194  # the rate tells how often it has gone round
    (whole,) = pieces_of(around, np.array([0.2, 0.2 + 2 * np.pi]), [LABEL], 2 * np.pi, angles=True)
    assert whole.closed and (whole.points[-1] - whole.points[0] == (6 * np.pi, -4 * np.pi)).all()
    s = np.array([[0.3, 2.0], [3.0, 6.0]])
    np.testing.assert_allclose(
        whole.at(s), whole.points[0] + (s[..., None] - 0.2) * (3, -2), rtol=0, atol=1e-14
    )
    (half,) = pieces_of(around, np.array([0.2, 0.2 + np.pi]), [LABEL], 2 * np.pi, angles=True)
    assert not half.closed and half.points[-1] - half.points[0] == pytest.approx(
        (3 * np.pi, -2 * np.pi)
    )


LABEL = (Singularity.PARALLEL, "folded", ((1, 1),), (1,))


def test_pieces_share_their_ends():
    labels = [(*LABEL[:1], str(k), *LABEL[2:]) for k in range(4)]
    vertices = [Vertex(complex(z)) for z in astroid(QUARTERS[:-1])[0]]
    pieces = pieces_of(
        astroid,
        QUARTERS,
        labels,
        1.0,
        astroid(QUARTERS)[0] + 1e-9,
        vertices=[*vertices, vertices[0]],
        circle=(1, -1),
    )
    for k, piece in enumerate(pieces):
        assert (piece.type, piece.kind, piece.working, piece.assembly) == labels[k]
        assert (
            piece.interval == (QUARTERS[k], QUARTERS[k + 1])
            and not piece.closed
            and piece.circle == (1, -1)
        )
        assert piece.vertices == (vertices[k], vertices[(k + 1) % 4])
        assert (piece.points[-1] == pieces[(k + 1) % 4].points[0]).all()
        np.testing.assert_array_equal(
            piece.points[0], pairs(astroid(QUARTERS[k : k + 1])[0] + 1e-9)[0]
        )
        np.testing.assert_array_equal(piece.points[1:-1], piece.at(piece.parameters[1:-1]))
        s = np.array([[0.1, 0.2, 0.7]]) * np.pi / 2 + QUARTERS[k]
        assert (
            piece.at(s).shape == piece.tangent(s).shape == (1, 3, 2)
            and piece.drawn(9, 99) is piece.points
        )
        np.testing.assert_array_equal(piece.tangent(s)[0] @ (1, 1j), astroid(s[0])[1])
        assert (
            piece.at(0).shape == piece.tangent(0).shape == (2,)
            and (piece.at([0]) == piece.at(0.0)).all()
        )


def test_a_closed_piece_ends_in_its_first_point_and_one_that_does_not_close_does_not():
    (whole,) = pieces_of(circle, QUARTERS[[0, -1]], [LABEL], 1.0)
    assert (
        whole.closed is True
        and (whole.points[0] == whole.points[-1]).all()
        and whole.vertices == ()
    )
    for gap in (1e-11, -1e-11):
        (piece,) = pieces_of(circle, np.array([0.0, 2 * np.pi + gap]), [LABEL], 1.0)
        assert piece.closed is False and (piece.points[0] != piece.points[-1]).any()
    (piece,) = pieces_of(circle, np.array([0.0, 2 * np.pi + 1e-11]), [LABEL], 100.0)
    assert piece.closed
    large = pieces_of(
        lambda t: (100 * circle(t)[0], 100 * circle(t)[1]), QUARTERS[:2], [LABEL], 100.0
    )[0]
    assert np.abs(large.points @ (1, 1j)) == pytest.approx(100) and large.points[
        -1
    ] == pytest.approx([0, 100])
    along = pieces_of(lambda t: (t + 0j, 1 + 0j * t), QUARTERS[[0, -1]], [LABEL], 1.0)[0]
    assert not along.closed and along.points[-1].tolist() == [
        2 * np.pi,
        0,
    ]  # lengths have no full turns
    short = np.array([0.0, 1e-3])
    (sparse,), (dense,) = (
        pieces_of(circle, short, [LABEL], 1.0, **given) for given in ({"period": 2 * np.pi}, {})
    )
    assert len(sparse.points) == 5 and len(dense.points) == 193
    two = pieces_of(circle, QUARTERS[[0, 1, -1]], [LABEL] * 2, 1.0)
    assert [piece.closed for piece in two] == [False] * 2 and (
        two[0].points[0] == two[1].points[-1]
    ).all()
    (point,) = pieces_of(circle, np.zeros(2), [LABEL], 1.0, corners=np.zeros(2), circle=(0, 1))
    assert (
        point.points.tolist() == [[1, 0]]
        and point.parameters.tolist() == [0]
        and point.closed is False
    )
    assert (
        point.circle == (0, 1) and (point.type, point.kind, point.working, point.assembly) == LABEL
    )
    (point,) = pieces_of(circle, np.zeros(2), [LABEL], 1.0, angles=True)
    assert point.at(0.0).tolist() == [1, 0] and point.interval == (0, 0)


def test_an_unbounded_line_is_drawn_between_any_two_parameters():
    line = Locus(
        *LABEL,
        np.zeros((2, 2)),
        np.zeros(2),
        False,
        lambda t: (t + 2j * t, 1 + 2j + 0 * t),
        unbounded=True,
    )
    assert line.drawn(1.0, 3.0).tolist() == [[1, 2], [3, 6]] and line.interval == (-np.inf, np.inf)


def test_signs_stand_for_modes():
    assert [values_of(np.int8(mode)) for mode in (1, -1, 0)] == [(1,), (-1,), (1, -1)]
    assert modes_of((0, -1)) == ((1, -1), (-1, -1)) and modes_of([1, 1]) == ((1, 1),)
    assert (
        type_of((1, -1), Singularity.SERIAL) == Singularity.SERIAL
        and type_of((0, 1), Singularity.SERIAL) == 3
    )


def test_intervals_are_divided_evenly_and_keep_their_ends():
    t = np.array([0.1, 0.3, 1.7, 1.9])
    found = divided(t, np.array([1, 4, 3]))
    np.testing.assert_allclose(
        found, [0.1, 0.3, 0.65, 1.0, 1.35, 1.7, 1.7 + 0.2 / 3, 1.7 + 0.4 / 3, 1.9], rtol=1e-15
    )
    assert np.isin(t, found).all() and divided(t, np.ones(3, dtype=int)).tolist() == t.tolist()
