"""A path evaluates itself and its derivatives, knows where a motion must rest, and is placed exactly."""

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fivebar as fb
from fivebar.paths.curve import Path
from fivebar.paths.pieces import Arc, Line, Polynomial
from tests.helpers.paths_to_time import bezier

CUBIC = bezier([(2, 1), (2, 1.5), (2.5, 2), (3, 2)], 1.5)
PIECES = (
    Line((0, 0), (1, 0)),
    Arc((1, 1), 1, -math.pi / 2, 0),
    Polynomial([(2, 1), (0, 1.0)], 1.0),
    Line((2, 2), (3, 2)),
)
PATH = Path(PIECES, pen=(True, True, True, False), dwells={1.0: 0.5})


def test_values_are_those_of_40_digits():
    """Against mpmath's own derivatives of the circle and of Bernstein's polynomials."""
    with mp.workdps(40):
        arc = Arc((0.3, -0.2), 0.07, 2.0, -1.5)
        control = [(0.01, 0.02), (0.03, -0.01), (0.05, 0.04), (0.02, 0.09)]
        curve = bezier(control, 0.11)

        def on_arc(s, k):
            angle = 2 - s / mp.mpf(0.07)
            return mp.mpf((0.3, -0.2)[k]) + mp.mpf(0.07) * (mp.cos, mp.sin)[k](angle)

        def on_curve(s, k):
            u = s / mp.mpf(0.11)
            return sum(
                mp.binomial(3, j) * u**j * (1 - u) ** (3 - j) * mp.mpf(p[k])
                for j, p in enumerate(control)
            )

        for piece, f in ((arc, on_arc), (curve, on_curve)):
            for s in (0.0, 0.013, 0.1):
                for order, value in enumerate(piece(s)):
                    exact = [float(mp.diff(lambda x, k=k, f=f: f(x, k), s, order)) for k in (0, 1)]
                    np.testing.assert_allclose(
                        value, exact, rtol=1e-13, atol=1e-13 * 0.07 ** (1 - order)
                    )


def test_a_path_is_its_pieces_one_after_the_other():
    assert PATH.length == pytest.approx(3 + math.pi / 2) and PATH.knots[2] == 1 + math.pi / 2
    s = np.linspace(0, PATH.length, 101)
    for k, (first, last) in enumerate(zip(PATH.knots, PATH.knots[1:])):
        here = s[(s >= first) & (s < last)]
        for ours, own in zip(PATH(here), PIECES[k](here - first)):
            np.testing.assert_allclose(ours, own, rtol=0, atol=1e-15)
        for at in (0.0, last - first):
            for ours, own in zip(PATH.on(k, at), PIECES[k](at)):
                np.testing.assert_allclose(ours, own, rtol=0, atol=1e-15)
    assert [each.shape for each in PATH(0.3)] == [(2,)] * 4 and [
        each.shape for each in PATH(s)
    ] == [(101, 2)] * 4
    np.testing.assert_array_equal(PATH(PATH.length)[0], (3, 2))


def test_a_motion_rests_where_it_must():
    corner = Path((Line((0, 0), (1, 0)), Line((1, 0), (1, 1)), Line((1, 1), (1, 2))))
    assert [stop.s for stop in corner.stops] == [0, 1, 3]  # the direction jumps, and at the ends
    assert [tuple(stop) for stop in PATH.stops] == [
        (0, 0),
        (1, 0.5),
        (2 + math.pi / 2, 0),
        (PATH.length, 0),
    ]
    assert "2 stops on the way" in repr(PATH) and "3.5708 m of it drawn" in repr(PATH)


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: Path(()), "no pieces"),
        (
            lambda: Path((Line((0, 0), (1, 0)), Line((1, 1e-6), (2, 0)))),
            r"pieces\[1\] starts 1e-06 m from where",
        ),
        (lambda: Path((1,)), r"pieces\[0\] must be a Line"),
        (lambda: Path(PIECES, pen=(True,)), "pen has 1 values for 4 pieces"),
        (lambda: Path(PIECES, feed=np.ones((4, 2))), "feed must be a number"),
        (lambda: Path(PIECES, dwells={0.4: 1.0}), "a dwell at s = 0.4 m is at no knot"),
        (lambda: PATH(-0.1), "s must be from 0 to"),
        (lambda: PATH([0.1, np.nan]), "s must be from 0 to"),
        (lambda: Line((1, 1), (1, 1)), "start and end are one point"),
        (lambda: Arc((0, 0), -1, 0, 1), "radius must be finite and > 0"),
        (lambda: Arc((0, 0), 1, 1, 1), "it has no length"),
        (lambda: Polynomial([(0, 0)], 1.0), "coefficients must be"),
        (lambda: fb.Placement(scale=0), "scale must be finite and > 0"),
    ],
)
def test_what_is_no_path_is_refused(make, message):
    with pytest.raises((ValueError, TypeError), match=message):
        make()


numbers = st.floats(-2, 2)


@settings(max_examples=25, deadline=None)
@given(
    numbers,
    numbers,
    st.floats(-7, 7),
    st.floats(0.01, 50),
    st.sampled_from([*PIECES, CUBIC]),
    st.floats(0, 1),
)
def test_placed_pieces_are_placed_points(x, y, turn, scale, piece, share):
    place = fb.Placement((x, y), turn, scale)
    moved = piece.moved(complex(x, y), place.turned)
    assert moved.length == pytest.approx(scale * piece.length, rel=1e-14)
    here = piece(share * piece.length)[0]
    far = 1 + abs(x) + abs(y) + 4 * scale
    np.testing.assert_allclose(
        moved(share * moved.length)[0], place(here), rtol=0, atol=3e-15 * far
    )
    np.testing.assert_allclose(
        place.inverse(place(here)), here, rtol=0, atol=1e-14 * far / scale + 1e-14
    )
    np.testing.assert_allclose(
        place.after(place)(here), place(place(here)), rtol=0, atol=1e-14 * far * (1 + scale)
    )
    first, last = sorted((share * piece.length, 0.7 * piece.length))
    if last - first > 1e-3:
        np.testing.assert_allclose(
            piece.part(first, last)(0.3 * (last - first))[0],
            piece(first + 0.3 * (last - first))[0],
            atol=1e-14,
        )


def test_a_picture(tmp_path):
    figure = PATH.plot(tmp_path / "path.png")
    labels = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert (
        labels == ["pen down", "pen up", "points of rest"]
        and (tmp_path / "path.png").stat().st_size > 5_000
    )
    assert "Path: 4 pieces" in PATH._repr_html_()


def test_what_is_drawn_without_a_tool_is_the_path_itself():
    assert PATH.drawn is PATH


def test_right_angles_are_exact():
    place = fb.Placement((0.1, 0.2), math.pi / 2, 2.0)
    assert place((1.0, 0.0)).tolist() == [0.1, 2.2]
    placed = place(PATH)
    assert (
        placed.pen == PATH.pen
        and placed.stops[1].seconds == 0.5
        and placed.length == pytest.approx(2 * PATH.length)
    )
