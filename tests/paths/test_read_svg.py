"""SVG: shapes, units and transforms as the standard has them; what is not drawn is listed, what is wrong refused."""

import io
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fivebar as fb
from fivebar.paths.pieces import Arc, Line

MM = '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="50mm" viewBox="0 0 100 50">'

XLINK = (
    'xmlns:xlink="http://www.w3.org/1999/xlink" xlink:href'  # which counts where there is no href
)


def read(body, head=MM, **options):
    return fb.path(io.StringIO(f"{head}\n{body}\n</svg>"), kind="svg", **options)


def box(path):
    points = path(np.linspace(0, path.length, 4001))[0]
    return [*points.min(axis=0), *points.max(axis=0)]


def test_millimetres_y_up_and_the_origin_below():
    (line,) = read('<path d="M10 50 L 30 40"/>').pieces
    np.testing.assert_allclose([line.start, line.end], [(0.01, 0), (0.03, 0.01)], atol=1e-15)


@pytest.mark.parametrize(
    "head, end",
    [
        (
            '<svg xmlns="http://www.w3.org/2000/svg" width="4in" height="2in" viewBox="0 0 96 48">',
            (0.1016, 0.0508),
        ),
        ('<svg xmlns="http://www.w3.org/2000/svg" width="96" height="48">', (0.0254, 0.0127)),
        ('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 96 48">', (0.0254, 0.0127)),
        # The middle of a viewport that is too wide for its box.
        (
            '<svg xmlns="http://www.w3.org/2000/svg" width="296mm" height="48mm" viewBox="0 0 96 48">',
            (0.196, 0.048),
        ),
        (
            '<svg xmlns="http://www.w3.org/2000/svg" width="192mm" height="48mm" viewBox="0 0 96 48" '
            'preserveAspectRatio="none">',
            (0.192, 0.048),
        ),
    ],
)
def test_units_and_viewports(head, end):
    np.testing.assert_allclose(read('<path d="M1 1 L 96 0"/>', head).pieces[0].end, end, atol=1e-15)


def test_units_given_for_a_file_without():
    head = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 96 48">'
    np.testing.assert_allclose(read('<path d="M0 0H96"/>', head, units="mm").length, 0.096)
    assert "pixels of 1/96 inch" in " ".join(read('<path d="M0 0H96"/>', head).notes)
    with pytest.raises(ValueError, match="units are given as px, but its width is 100mm"):
        read('<path d="M0 0H96"/>', units="px")
    with pytest.raises(ValueError, match="units of an SVG.*furlong"):
        read('<path d="M0 0H96"/>', head, units="furlong")


def test_shapes_are_exact():
    circle = read('<circle cx="50" cy="25" r="10"/>')
    assert all(isinstance(p, Arc) and p.radius == pytest.approx(0.01) for p in circle.pieces)
    assert circle.length == pytest.approx(0.02 * math.pi) and len(circle.stops) == 2
    rounded = read('<rect x="10" y="10" width="40" height="20" rx="5"/>')
    assert (
        rounded.length == pytest.approx(2 * 0.03 + 2 * 0.01 + 0.01 * math.pi)
        and len(rounded.stops) == 2
    )
    for body, length in (
        ('<polyline points="0,0 3,4 6,0"/>', 0.01),
        ('<polygon points="0,0 3,0 3,4"/>', 0.012),
        ('<line x1="1" y1="1" x2="4" y2="5"/>', 0.005),
        ('<rect width="3" height="4"/>', 0.014),
    ):
        path = read(body)
        assert all(
            isinstance(piece, Line) for piece in path.pieces
        ) and path.length == pytest.approx(length)


def test_transforms_are_honoured():
    """Nested ones, a mirror among them; a circle turned stays an arc, a sheared one becomes an ellipse."""
    (line,) = read(
        '<g transform="translate(10,10)"><path transform="rotate(90) scale(2 1)" d="M0 0H5"/></g>'
    ).pieces
    np.testing.assert_allclose([line.start, line.end], [(0.01, 0.04), (0.01, 0.03)], atol=1e-15)
    turned = read('<circle transform="rotate(30) scale(-2 2)" r="5" cx="-20" cy="5"/>')
    assert all(
        isinstance(piece, Arc) and piece.radius == pytest.approx(0.01) for piece in turned.pieces
    )
    mirrored = read('<path transform="scale(1 -1)" d="M10 0 A 10 10 0 0 1 20 -10"/>')
    plain = read('<path d="M10 0 A 10 10 0 0 0 20 10"/>')
    np.testing.assert_allclose(
        mirrored(mirrored.length / 3)[0], plain(plain.length / 3)[0], atol=1e-15
    )
    squashed = read('<circle transform="scale(1 .5)" cx="50" cy="50" r="20"/>', deviation=1e-6)
    np.testing.assert_allclose(box(squashed), (0.03, 0.015, 0.07, 0.035), atol=2e-6)
    twice = read('<defs><path id="p" d="M0 0H5"/></defs><use href="#p"/><use href="#p" x="10"/>')
    symbol = read(
        f'<symbol id="s"><path d="M0 0H5"/></symbol><g id="g"><use href="#s" {XLINK}="#g" x="20"/></g>'
    )
    assert len(symbol.pieces) == 1 and symbol.pieces[0].start == pytest.approx((0.02, 0.05))
    assert twice.pen == (True, False, True) and twice.length == pytest.approx(0.015)


ONE = '<path stroke="black" fill="none" d="M1 1L9 9"/>'


@pytest.mark.parametrize(
    "body, ends",  # by hand, in mm from the upper left
    [
        (
            f'<svg x="10" y="20" width="50" height="40" viewBox="0 0 10 10">{ONE}</svg>',
            [(19, 24, 51, 56)],
        ),
        ('<line x1="10%" y1="10%" x2="90%" y2="90%"/>', [(10, 5, 90, 45)]),
        # Only a curve of the same kind before is mirrored: the first handle is where the curve begins.
        ('<path d="M0 0c0 0 4 0 4 0t0 8"/>', [(0, 0, 4, 0), (4, 0, 4, 8)]),
        ('<path d="M0 0Q2 0 4 0S4 8 4 8"/>', [(0, 0, 4, 0), (4, 0, 4, 8)]),
        (f'<path/><path d=""/>{ONE}<path stroke="red"/>', [(1, 1, 9, 9)]),
        (
            f'<g visibility="hidden">{ONE}<path style="visibility:visible" d="M1 2H5"/></g>',
            [(1, 2, 5, 2)],
        ),
    ],
)
def test_what_is_seen_where(body, ends):
    path = read(body)
    drawn = [piece for piece, pen in zip(path.pieces, path.pen) if pen]
    lines = [
        1e3 * np.array([*piece.start, *piece.end]) for piece in drawn if isinstance(piece, Line)
    ]
    np.testing.assert_allclose(lines, [(x, 50 - y, u, 50 - v) for x, y, u, v in ends], atol=1e-9)


BOX = '<rect stroke="black" fill="none" width="10" height="5"/>'


@pytest.mark.parametrize(
    "body, corners",  # by hand, in mm from the upper left
    [
        (f'<svg x="20" y="20" width="10" height="10" viewBox="0 0 20 20">{BOX}</svg>', (20, 25)),
        (
            '<svg x="2" y="3" width="40" height="40" viewBox="0 0 20 20">'
            f'<svg width="5" height="5" viewBox="0 0 10 10">{BOX}</svg></svg>',
            (2, 12),
        ),
        (f'{BOX}<rect height="40"/>', (0, 10)),  # without a width, of which its svg has one
        (f'<defs><g id="g">{BOX}</g></defs><svg x="9"><use href="#g"/></svg>', (0, 10)),
    ],
)
def test_no_place_or_size_is_taken_from_around(body, corners):
    x0, _, x1, _ = np.multiply(1e3, box(read(body)))
    np.testing.assert_allclose((x0, x1), corners, atol=1e-9)


DISC = '<circle cx="50" cy="25" r="20"/>'


@pytest.mark.parametrize(
    "hidden, note",
    [
        *((f'<{tag} id="a">{DISC}</{tag}>', "") for tag in ("marker", "mask", "symbol")),
        *((f'<{tag} id="a">{DISC}</{tag}>', "") for tag in ("clipPath", "pattern")),
        (f'<g display="none">{DISC}</g>', ""),
        (f'<g visibility="hidden">{DISC}</g>', "invisible shapes are not drawn (line 2)"),
        (f'<g opacity="0"><g opacity="1">{DISC}</g></g>', "invisible shapes are not drawn"),
        (f"<style>circle{{opacity:0.0%}}</style>{DISC}", "invisible shapes are not drawn"),
        (f'<g fill-opacity="0">{DISC}</g>', "invisible shapes are not drawn (line 2)"),
        (f'<g fill="transparent">{DISC}</g>', "invisible shapes are not drawn (line 2)"),
        ('<use href="#missing"/>', "<use> finds nothing to draw (line 2)"),
        (f"<switch><path/>{DISC}</switch>", "of <switch> one branch is drawn (line 2)"),
        (
            f'<switch><g requiredExtensions="x">{DISC}</g><foreignObject>{DISC}</foreignObject>'
            f'<g systemLanguage="de">{DISC}</g><g systemLanguage="fr, en-GB"/>{DISC}</switch>',
            "of <switch> one branch is drawn (line 2)",
        ),
    ],
)
def test_what_nobody_sees_is_not_drawn(hidden, note):
    path = read(hidden + ONE)
    assert path.length == pytest.approx(8e-3 * math.sqrt(2)) and note in " ".join(path.notes)


@pytest.mark.parametrize(
    "body", [f'<g clip-path="url(#a)">{ONE}</g>', f'<a style="clip-path:url(#a)">{ONE}</a>']
)
def test_a_clipped_group_is_noted(body):
    assert "clip-path is not applied (line 2)" in read(body).notes


@pytest.mark.parametrize(
    "smooth, plain",
    [
        ("M0 0C1 2 3 2 4 0S7 2 8 0", "M0 0C1 2 3 2 4 0C5 -2 7 2 8 0"),
        ("M0 0Q2 4 4 0T8 0T12 0", "M0 0Q2 4 4 0Q6 -4 8 0Q10 4 12 0"),
    ],
)
def test_curves_that_go_on_smoothly(smooth, plain):
    """Their first handle is the last one of the curve before, mirrored."""
    one, other = (read(f'<path d="{d}"/>') for d in (smooth, plain))
    assert one.length == pytest.approx(other.length, rel=1e-12) and len(one.stops) == 2
    s = np.linspace(0, one.length, 50)
    np.testing.assert_allclose(one(s)[0], other(s)[0], atol=1e-12)


def test_curves_are_kept_within_the_deviation():
    q = read('<path d="M0 50 Q 50 0 100 50"/>', deviation=1e-6)
    t = np.linspace(0, 1, 20001)
    exact = 0.1 * t + 1j * 0.1 * t * (1 - t)
    ours = q(np.linspace(0, q.length, 101))[0] @ (1, 1j)
    assert (
        np.abs(ours[:, None] - exact).min(axis=1).max() < 1e-6 + 3e-6
    )  # half a step of the samples
    assert box(q)[3] == pytest.approx(0.025, abs=1e-6) and len(q.stops) == 2
    assert all(isinstance(piece, Line) for piece in read('<path d="M0 0 C 1 0 2 0 3 0"/>').pieces)


def test_an_arc_too_small_is_scaled_up_as_the_standard_says():
    path = read('<path d="M0 0 A 1 1 0 0 1 10 0"/>')
    assert path.length == pytest.approx(0.005 * math.pi)
    assert read('<path d="M0 0 A 0 1 0 0 1 10 0"/>').pieces[0].length == pytest.approx(0.01)


def test_what_is_passed_over_is_listed():
    path = read(
        '<title>t</title><script>alert(1)</script>\n<text x="1">hello</text><image href="a.png"/>\n'
        '<path d="M0 0H5" stroke-dasharray="1 2" stroke="black"/>\n<path d="M0 0H9" visibility="hidden"/>\n'
        '<path d="M1 1L1 1"/><circle r="0"/>\n<path d="M0 0H9" style="display:none"/>'
    )
    notes = " | ".join(path.notes)
    assert path.length == pytest.approx(0.005)
    for words in (
        "<text> is not drawn (line 3)",
        "<image> is not drawn (line 3)",
        "stroke-dasharray is not applied (line 4)",
        "invisible shapes are not drawn (lines 5, 7)",
        "moves of no length passed over (line 6)|move of no length passed over (line 6)",
    ):
        assert any(part in notes for part in words.split("|")), words


@pytest.mark.parametrize(
    "element, filled",
    [
        ('<line x1="0" y1="0" x2="5" y2="3" stroke="black"/>', False),
        ('<path d="M0 0L5 3 1 .6"/>', False),
        ('<path d="M0 0H5M0 1H5"/>', False),
        ('<path d="M0 0C1 1 2 2 5 5z"/>', False),
        ('<g transform="rotate(30)"><polyline points="0,0 7,7 3,3"/></g>', False),
        ('<path d="M0 0L5 3 1 .7"/>', True),
        ('<path d="M0 0H5M0 1H5V2"/>', True),
        ('<path d="M0 0A2 2 0 0 1 4 0"/>', True),
        ('<path d="M0 0C0 1 3 1 3 0"/>', True),
        ('<path d="M0 0C1 0 2 1 3 0" fill="none" stroke="black"/>', False),
        ('<circle r="2"/>', True),
        ('<rect width="3" height="2" style="fill:none;stroke:red"/>', False),
    ],
)
def test_only_what_encloses_an_area_is_said_not_to_be_filled(element, filled):
    """SVG fills open paths, too, but lines have nothing to be filled."""
    assert ("areas are not filled" in " ".join(read(element).notes)) == filled


@pytest.mark.parametrize(
    "body, message",
    [
        ("", "nothing is drawn"),
        ('<path d="M 0 0 L 1"/>', "line 2: <path>: d is not"),
        ('\n<path d="M 0 0 X 1 1"/>', "line 3: <path>: d is not"),
        ('<path d="L 0 0"/>', "line 2: <path>: d is not"),
        ('<path d="M 0 0 L 1 1 ?"/>', "line 2: <path>: d is not"),
        ('<path d="M0 0 A 1 1 0 2 0 3 3"/>', "line 2: <path>: d is not"),
        (
            '<path d="M0 0C1e10 2 3 4 5 6"/>',
            "line 2: a curve 1e.07 m large cannot be kept within 1e-09 m",
        ),
        (
            '<path transform="scale(2)" transform-origin="5 5" d="M0 0H1"/>',
            "line 2: <path>: write its transform",
        ),
        ('<path transform="rotate(abc)" d="M0 0H1"/>', "line 2: <path>: not a valid transform"),
        (f'<svg width="9" height="5">{ONE}</svg><line x2="9%"/>', "line 2: <line>: lengths in %"),
        ('<path transform="twist(3)" d="M0 0H1"/>', "line 2: <path>: not a valid transform"),
        ('<path style="transform: scale(2)" d="M0 0H1"/>', "line 2: <path>: write its transform"),
        ("<path>", "not XML: mismatched tag: line 3"),
        ('<ellipse rx="2"/>', "line 2: <ellipse>: rx and ry are both needed"),
        (f'<symbol viewBox="0 0 1 1">{ONE}</symbol>', "line 2: <symbol>: a symbol with a viewBox"),
        ('<g id="a"><use href="#a"/></g>', "line 2: <use> repeats itself without end"),
        (
            f'{ONE}<g id="a"><use href="#a" {XLINK}="#b"/></g>',
            "line 2: <use> repeats itself without end",
        ),
    ],
)
def test_what_is_wrong_is_named_with_its_line(body, message):
    with pytest.raises(ValueError, match=message) as refused:
        read(body)
    assert str(refused.value).startswith("the open file") and "None" not in str(refused.value)


def test_what_is_no_svg(tmp_path):
    in_em = '<svg xmlns="http://www.w3.org/2000/svg" width="9em" height="9em" viewBox="0 0 9 9"/>'
    for text, message in (
        ("<html/>", "line 1: not an SVG, but <html>"),
        ("hello", "not XML"),
        (in_em, "cannot be read as SVG: its width or height is not understood: write them in mm"),
    ):
        with pytest.raises(ValueError, match=message):
            fb.path(io.StringIO(text), kind="svg")
    own = '<!DOCTYPE svg [<!ENTITY ns_ai "http://ns.adobe.com/AdobeIllustrator/10.0/">]>'
    own += '<svg xmlns:i="&ns_ai;" '
    shape = 'xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><path d="M1 1h7" stroke="red"/>'
    illustrator = fb.path(
        io.StringIO(f"{own}{shape}</svg>"), kind="svg"
    )  # the names of its namespaces are no harm
    assert illustrator.length == pytest.approx(7 / 96 * 0.0254)
    (tmp_path / "a.svg").write_bytes(b"\x89PNG\0")
    with pytest.raises(ValueError, match="a.svg: not a text file, but a binary one"):
        fb.path(tmp_path / "a.svg")


def test_uses_that_multiply_are_refused():
    levels = "".join(f'<g id="g{k}">{f"""<use href="#g{k - 1}"/>""" * 10}</g>' for k in range(1, 9))
    with pytest.raises(ValueError, match="more than 100000 elements"):
        read(f'<g id="g0"><path d="M0 0H1"/></g>{levels}')


WHOLE = MM + (
    '<g transform="translate(1 2) rotate(30)"><path d="M0 0c1 2 3 4 5 6zm1 1a2 3 10 0 1 4 4"/><circle r="2"/></g></svg>'
)


@settings(max_examples=50, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.integers(0, len(WHOLE) - 1), st.sampled_from('<>"/ 0-.eMaAzZ(),&#%'), st.booleans()
        ),
        max_size=4,
    )
)
def test_any_damage_is_read_or_refused(damage):
    text = list(WHOLE)
    for at, letter, insert in damage:
        text[at] = text[at] + letter if insert else letter
    try:
        path = fb.path(io.StringIO("".join(text)), kind="svg", deviation=1e-5)
    except ValueError as error:
        assert "the open file" in str(error)
    else:
        assert np.isfinite(path(np.linspace(0, path.length, 50))[0]).all()
