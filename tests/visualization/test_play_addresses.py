"""Addresses of the live page that nobody would write: never an exception, never nan, and the page goes on."""

import os
import random
from dataclasses import replace
from urllib.parse import quote

import numpy as np
import pytest

import fivebar as fb
from fivebar import linkages

from ..conftest import UNEQUAL
from ..helpers.pages import browser, opened  # noqa: F401  fixtures
from ..helpers.playing import LENGTHS

READ, SHOWN = (100_000, 1_000) if os.environ.get("FIVEBAR_NIGHTLY") else (4_000, 20)
RIGHT = [
    fb.play(UNEQUAL).fragment,
    fb.play(fb.ROBOTS["iri-vertical"].robot).fragment,
    fb.play(linkages.PRINTED).fragment,
    "#linkage=four&values=0.2,0.06,0.16,0.14,0.1,0.02&branch=+&crank=0.5",
    "#linkage=slider_rod&values=0.05,0.15,-0.01&branch=+&crank=0.5",
]
SHORT = "#linkage=press&values=0.202,0.54,0.25,0.001,0.434&branch=--&crank=-2.9"  # its bar 5 reaches the guide rarely
PIECES = [
    *"0123456789.-+e=&#%,<>\"'l",
    "working=",
    "l11=",
    "&d=",
    "x=0&",
    "\0",
    "é",
    "\ud800",
    "NaN",
    "Infinity",
    "1e-99",
    "1e99",
    "0.001",
    "1000000",
    "-0",
    "&branch=-",
    "press",
    "slider_crank",
    "__proto__",
    "%3Cimg%20src=x%20onerror=alert(1)%3E",
    "&gx=1000",
    "&fv1=1000000",
    "&disc=0.001",
    "&zz1=-1000000",
    "&m=0",
    "&mx11=1000000",
    "&crank=99",
]


def address(rng):
    """A right one with some letters, numbers or signs replaced; of half of them only numbers, by numbers."""
    text = rng.choice(RIGHT)
    if rng.randrange(2):
        pairs = [pair.split("=") for pair in text[1:].split("&")]
        for _ in range(rng.choice([1, 1, 2, 4])):
            pair = rng.choice(pairs)
            numbers = pair[1].split(",")
            numbers[rng.randrange(len(numbers))] = rng.choice(
                [
                    "0.001",
                    "10",
                    "1e-9",
                    "0",
                    "-0.001",
                    f"{rng.uniform(-1, 1):.12f}",
                    f"{10 ** rng.uniform(-4, 2):.6f}",
                ]
            )
            pair[1] = ",".join(numbers)
        return "#" + "&".join("=".join(pair) for pair in pairs)
    letters = list(text)
    for _ in range(rng.randrange(1, 6)):
        at = rng.randrange(len(letters))
        letters[at : at + rng.choice([0, 1, 1, 3])] = [rng.choice(PIECES)]
    return "".join(letters)


# What the page does with an address, and what it then shows, drawn at once.
SHOW = """text => {
    history.replaceState(null, "", "#" + text.replace(/^#/, ""));
    takeFragment(); showSliders(); survey(true); resized(); moved();
    return new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(document.body.innerText))));
}"""


@pytest.mark.deep
def test_any_address_is_taken_or_refused(opened, tmp_path):  # noqa: F811
    fb.play().save(tmp_path / "play.html")
    page, rng = opened(tmp_path / "play.html"), random.Random(1)
    texts = [address(rng) for _ in range(READ)]
    robots, benches, refused = page.evaluate(
        """texts => {
            const robots = [], benches = [], refused = [];
            for (const text of texts) {
                const {state, words} = readLinkage(text) ?? readFragment(text);
                if (words) refused.push(words);
                else if (state.kind) benches.push([...state.values, state.q]);
                else robots.push([...LENGTHS.map(name => state[name]), state.x, state.y, ...state.working]);
            }
            return [robots, benches, refused];
        }""",
        texts,
    )
    assert (
        len(robots) > READ / 100
        and len(benches) > READ / 50
        and len(robots) + len(benches) + len(refused) == READ
    )
    assert all(
        isinstance(words, str) and words and not set(words) & set("<>%") for words in refused
    )
    for *lengths, x, y, left, right in robots:
        assert np.isfinite(
            fb.igm(fb.FiveBar(*lengths), (x, y), (left, right), unreachable="nan").det_A
        )
    assert np.isfinite([value for row in benches for value in row]).all()
    for text in (SHORT, *texts[:SHOWN]):
        shown = page.evaluate(SHOW, text)
        assert not any(word in shown for word in ("NaN", "undefined", "Infinity")), (text, shown)
        assert page.evaluate("document.querySelectorAll('img, script').length") == 3, text
    page.evaluate(SHOW, SHORT)
    locks = np.array(page.evaluate("lab.sweep.edges"))
    held = replace(linkages.PRINTED, l5=0.001)
    np.testing.assert_allclose(
        locks, np.ravel(linkages.crank_range(held, (-1, -1)).intervals), atol=1e-9
    )
    page.evaluate(SHOW, RIGHT[0])  # and it goes on
    assert page.evaluate("p") == [getattr(UNEQUAL, name) for name in LENGTHS]


def test_an_address_that_a_mail_program_escaped_is_taken(opened, tmp_path):  # noqa: F811
    fb.play().save(tmp_path / "play.html")
    page = opened(tmp_path / "play.html")
    page.evaluate(SHOW, quote(fb.play(UNEQUAL, fb.igm(UNEQUAL, (0.05, 0.1), (1, -1))).fragment[1:]))
    assert page.evaluate("p") == [getattr(UNEQUAL, name) for name in LENGTHS]
    assert page.evaluate("modes") == [1, -1]
    page.evaluate(SHOW, quote(RIGHT[3][1:], safe="=&"))
    assert page.evaluate("lab.values") == [0.2, 0.06, 0.16, 0.14, 0.1, 0.02]
    page.evaluate(SHOW, "working=%ff%e9%")
    assert "is not taken" in page.evaluate("said")
