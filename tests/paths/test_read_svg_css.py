"""CSS in an SVG: the shapes that are drawn are those that Chromium shows."""

import io
import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.image import imread

import fivebar as fb
from fivebar.paths.reading import css
from tests.helpers.browsing import chromium

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" width="200" height="200" viewBox="0 0 200 200">'


def drawn(text):
    """Return the lines of the shapes that a path draws, and its notes."""
    try:
        path = fb.path(io.StringIO(text), kind="svg")
    except ValueError as error:
        assert "nothing is drawn" in str(error)
        return set(), (str(error),)
    return {line for line, pen in zip(path.lines, path.pen) if pen}, path.notes


SHAPE = '<path d="M5 5H20" stroke="red" fill="none" {0}/>'
ONE = SHAPE.format('class="x"')


@pytest.mark.parametrize(
    "sheet, body, is_seen",  # as Chromium shows them
    [
        (".x{display:none !important}", ONE, False),
        ("", SHAPE.format('style="display:none !important"'), False),
        (".l .x{display:none}", f'<g class="l">{ONE}</g>', False),
        (".l>path{display:none}", f'<g class="l">{ONE}</g>', False),
        (".l > path{display:none}", f'<g class="l"><g>{ONE}</g></g>', True),
        (".l g>path{display:none}", f'<g class="l"><g>{ONE}</g></g>', False),
        (".a{stroke:#000;fill:none}#z{stroke:none}", SHAPE.format('id="z" class="a"'), False),
        ("#z{stroke:none}.a{stroke:#000;fill:none}", SHAPE.format('id="z" class="a"'), False),
        ("path.a{stroke:red}.a{stroke:none}", SHAPE.format('class="a"'), True),
        (".a.b{stroke:none}.b{stroke:red}", SHAPE.format('class="b\na"'), False),
        (".a{stroke:none}.a, .b{stroke:red}", SHAPE.format('class="a"'), True),
        (".x{display:none!important}", SHAPE.format('class="x" style="display:inline"'), False),
        ("/* .x{} */.x{/* } */display:none}/*", ONE, False),
        ("<![CDATA[ @charset 'utf-8'; .x{display:none} ]]>", ONE, False),
        ("@media print{.y{fill:red}.x{display:none}}.y{}", ONE, True),
        (
            "*{visibility:hidden}",
            SHAPE.format('style="visibility:visible;text-transform:none"'),
            True,
        ),
    ],
)
def test_what_css_hides_is_not_drawn(sheet, body, is_seen):
    lines, notes = drawn(f"{HEAD}<style>{sheet}</style>\n{body}</svg>")
    assert lines == ({2} if is_seen else set())
    assert ("invisible shapes are not drawn (line 2)" in " ".join(notes)) != is_seen


@pytest.mark.parametrize(
    "sheet, words",
    [
        ("<style>path[d]{display:none}</style>", "path[d]"),
        ("<style>g .x:hover, .y{stroke:blue}</style>", ".x:hover,"),
        ("<style>@media print{.x{display:none}}</style>", "@media"),
        ('<style media="print">.x{display:none}</style>', "@media"),
        ('<style>@import "a.css"; g{}</style>', "@import"),
        ('<style>@import "a.css";</style>', "@import"),
    ],
)
def test_css_that_is_not_applied_is_noted(sheet, words):
    lines, notes = drawn(f"{HEAD}\n{sheet}\n{ONE}</svg>")
    assert lines == {3} and f"{words} of CSS is not applied (line 2)" in notes


def test_more_rules_than_can_be_applied_are_refused(monkeypatch):
    monkeypatch.setattr(css, "MOST", 10**5)
    text = f"{HEAD}<style>{'.x{}' * 300}</style>{'<g/>' * 400}</svg>"
    with pytest.raises(ValueError, match="the open file: .*too many rules of CSS for its elements"):
        fb.path(io.StringIO(text), kind="svg")


@given(st.text("ax.#>*, ;:{}@/!\"'\n", max_size=60))
def test_any_style_sheet_is_read(text):
    escaped = text.replace(">", "&gt;")
    drawn(f"{HEAD}<style>{escaped}</style>{ONE}</svg>")


VALUES = {
    "display": ("none", "inline", "block"),
    "visibility": ("hidden", "visible", "collapse"),
    "opacity": ("0", "1", ".5"),
    "stroke": ("none", "red", "transparent"),
    "fill": ("none", "blue", "transparent"),
    "stroke-opacity": ("0", "1"),
    "fill-opacity": ("0%", "1"),
}
CELLS = [(20 * x + 4, 20 * y + 4) for y in range(10) for x in range(10)]


def declarations(draw):
    keys = draw.choices(list(VALUES), k=draw.randint(1, 3))
    marks = ["", "", "", " !important"]
    return ";".join(f"{key}: {draw.choice(VALUES[key])}{draw.choice(marks)}" for key in keys)


def selector(draw):
    compounds = []
    for _ in range(draw.choice((1, 1, 1, 2, 2, 3))):
        names = draw.choices(".a .b .c .d #i1 #i2 #i3 #i4".split(), k=draw.choice((0, 1, 1, 2)))
        tag = draw.choice(("", "rect", "g", "svg", "*", "path"))
        compounds.append(tag + "".join(names) or "rect")
    return "".join(draw.choice((" ", ">", " > ")) + part for part in compounds).strip(" >")


def drawing(draw):
    """Return an SVG of one shape a line, each in a cell of its own, in nested groups."""
    rules = []
    for _ in range(draw.randint(3, 12)):
        selectors = [selector(draw) for _ in range(draw.choice((1, 1, 2)))]
        rules.append(f"{', '.join(selectors)} {{{declarations(draw)}}}")
    head = HEAD.replace(">", ' style="display:inline !important">')
    lines = [f"{head}<style>{' '.join(rules[::2])}</style>"]
    open_groups = 0
    for number, (x, y) in enumerate(CELLS):
        classes = " ".join(draw.choices("abcd", k=draw.randint(0, 2)))
        words = f'class="{classes}" id="i{number}"'
        if draw.random() < 0.2:
            words += f' style="{declarations(draw)}"'
        if draw.random() < 0.3:
            key = draw.choice(list(VALUES))
            words += f' {key}="{draw.choice(VALUES[key])}"'
        step = ""
        if draw.random() < 0.3:
            step = f'<g class="{draw.choice("abcd")}">'
            open_groups += 1
        elif open_groups and draw.random() < 0.3:
            step = "</g>"
            open_groups -= 1
        lines.append(f'{step}<rect x="{x}" y="{y}" width="12" height="12" {words}/>')
    return "\n".join(
        [*lines, "</g>" * open_groups, f"<style>{' '.join(rules[1::2])}</style></svg>"]
    )


@pytest.mark.deep
def test_a_browser_shows_the_shapes_that_are_drawn(tmp_path):
    file = tmp_path / "a.svg"
    shares = []
    with chromium() as browser:
        page = browser.new_page(viewport={"width": 200, "height": 200})
        for seed in range(60):
            text = drawing(random.Random(seed))
            file.write_text(text, "utf-8")
            page.goto(file.as_uri())
            image = imread(io.BytesIO(page.screenshot()), format="png")[..., :3].min(axis=2)
            seen = {
                k
                for k, (x, y) in enumerate(CELLS)
                if image[y - 2 : y + 14, x - 2 : x + 14].min() < 1
            }
            assert drawn(text)[0] == {k + 2 for k in seen}, f"seed {seed}"
            shares.append(len(seen) / len(CELLS))
    assert np.std(shares) > 0.1 and 0.1 < np.mean(shares) < 0.9
