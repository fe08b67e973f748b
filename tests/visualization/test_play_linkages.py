"""The live page's linkages: their motion, verdicts and dead centres against Python's, and what a hand does to them."""

import re

import numpy as np
import pytest

import fivebar as fb
from fivebar import linkages
from fivebar.cli import main
from fivebar.linkages.quantities import usual_panels

from ..helpers.browsing import settle, until, visit
from ..helpers.pages import browser, computing, opened  # noqa: F401  fixtures


@pytest.fixture
def page(opened, tmp_path_factory):  # noqa: F811
    path = tmp_path_factory.mktemp("play") / "play.html"
    fb.play().save(path)
    return opened(path)


MOVES = """([kind, branch, values, qs]) => { chooseKind(kind, values, branch); return qs.map(q => {
    const {points, velocity, acceleration, tangential, normal, output, transmission, closes} = at_(q);
    return [closes, ...points[wordsOf().traced], ...velocity, ...acceleration, tangential, normal, ...output,
        transmission];
}); }"""
CRANK_ROCKER, TURNED = (0.2, 0.06, 0.16, 0.14, 0.08, 0.06), (0.1, 0.2, 0.15, 0.13, 0.03, -0.1)
LINKAGES = [
    (
        "four",
        1,
        linkages.FourBar(*CRANK_ROCKER[:4], point=CRANK_ROCKER[4:]),
        CRANK_ROCKER,
        "rocker",
    ),
    ("four", -1, linkages.FourBar(*TURNED[:4], point=TURNED[4:]), TURNED, "rocker"),
    ("slider_guide", 1, linkages.SliderCrank(0.05, 0.15, 0.02), (0.05, 0.15, 0.02), "slide"),
    (
        "slider_crank",
        1,
        linkages.SliderCrank(0.15, 0.05, 0.01, "crank"),
        (0.15, 0.05, 0.01),
        "guide",
    ),
    ("slider_rod", 1, linkages.SliderCrank(0.05, 0.15, 0.01, "rod"), (0.05, 0.15, 0.01), "guide"),
    (
        "slider_slider",
        1,
        linkages.SliderCrank(0.2, 0.15, 0.02, "slider"),
        (0.2, 0.15, 0.02),
        "slide",
    ),
    ("press", (-1, -1), linkages.PRESSES["printed"][0], (0.202, 0.54, 0.25, 0.4, 0.434), "S6_down"),
]


def test_linkages_move_and_lock_as_in_python(computing):  # noqa: F811
    computing.evaluate("showTab('four')")
    q = np.linspace(-3, 3, 41)
    for kind, branch, linkage, values, out in LINKAGES:
        signs = [branch] if isinstance(branch, int) else list(branch)
        found = np.array(computing.evaluate(MOVES, [kind, signs, values, q.tolist()]), dtype=float)
        motion = linkages.move(linkage, q, 2 * np.pi, branch=branch, unreachable="nan")
        traced = motion.chain.traced
        output = (
            (motion.angle(out), motion.rate(out), motion.angular_acceleration(out))
            if out in ("rocker", "guide")
            else motion.coordinate(out)
        )
        expected = np.column_stack(
            [
                motion.position(traced),
                motion.velocity(traced),
                motion.acceleration(traced),
                motion.tangential(traced),
                motion.normal(traced),
                *output,
                motion.transmission_angle(),
            ]
        )
        closes = np.isfinite(motion.position(traced)).all(axis=1)
        np.testing.assert_array_equal(found[:, 0], closes)
        np.testing.assert_allclose(
            found[closes, 1:], expected[closes], rtol=1e-9, atol=1e-9, err_msg=kind
        )
        allowed = linkages.crank_range(linkage, branch)
        edges = computing.evaluate("[lab.sweep.full, lab.sweep.edges]")
        ends = (
            sorted(np.remainder(np.array(allowed.intervals).ravel() + np.pi, 2 * np.pi) - np.pi)
            if not allowed.full
            else []
        )
        assert edges[0] == allowed.full
        np.testing.assert_allclose(sorted(edges[1]), ends, atol=1e-7, err_msg=kind)
        assert (
            computing.evaluate(
                "benchWords(), document.getElementById('linkage-said').textContent.length"
            )
            > 20
        )


@pytest.mark.parametrize(
    "kind, values, branch, dead",
    [
        ("slider_guide", (0.05, 0.05, 0.0), 1, [0.0]),
        ("slider_guide", (0.05, 0.05, 0.0), -1, [np.pi]),
        ("slider_slider", (0.05, 0.05, 0.0), 1, [0.0]),
        ("four", (0.2, 0.2, 0.2, 0.2, 0.1, 0.0), 1, []),
    ],
)
def test_what_stands_still_has_no_dead_centres(computing, kind, values, branch, dead):  # noqa: F811
    """A slider at a cos q + |a cos q|, or a rocker beside the ground: only its rounding changes sign."""
    computing.evaluate("showTab('four')")
    choose = "([kind, values, branch]) => { chooseKind(kind, values, [branch]); }"
    computing.evaluate(choose, [kind, values, branch])
    found = computing.evaluate("lab.sweep.ends.map(({q}) => Math.abs(q))")
    assert found == pytest.approx(dead, abs=1e-9)
    assert computing.evaluate("verdictLines()[0]").startswith("Change point: ")


@pytest.mark.deep
def test_what_a_four_bar_can_do_is_said(page):
    page.get_by_role("tab", name="Four-bar").click()
    settle(page)
    four_bar = LINKAGES[0][2]
    page.get_by_role("tab", name="Slider-crank").click()
    settle(page)
    np.testing.assert_allclose(
        np.sort(np.abs(page.evaluate("lab.sweep.ends.map(({q}) => q)"))), [0, np.pi], atol=1e-9
    )
    assert (
        "The slider goes by 100 mm, time ratio 1." in page.locator("#linkage-said").text_content()
    )
    page.get_by_role("tab", name="Four-bar").click()
    settle(page)
    dead = sorted((end.crank, end.rocker) for end in linkages.dead_centres(four_bar))
    found = page.evaluate("lab.sweep.ends.map(({q, output}) => [q, output])")
    np.testing.assert_allclose(sorted(map(tuple, found)), dead, atol=1e-9)
    words = page.locator("#linkage-said").text_content()
    assert (
        words.startswith(f"{four_bar.kind.capitalize()}: shortest + longest is 40 mm less")
        and "turns through full turns" in words
    )
    assert f"time ratio {linkages.time_ratio(four_bar):.5g}" in words
    for name in ("evans", "chebyshev", "watt", "hoeken", "roberts"):
        page.get_by_label("linkage by name").select_option(name)
        settle(page)
        ratio = 100 * linkages.straightness(linkages.straight_line(name)).ratio
        percent = re.search(
            r"a band of .* [mµ]m, (\S+) % of the stroke",
            page.locator("#linkage-said").text_content(),
        )[1]
        assert float(percent.replace("−", "-")) == pytest.approx(ratio, rel=0.02)
    page.get_by_role("spinbutton", name="ground, mm").fill("3000")
    page.keyboard.press("Tab")
    settle(page)
    assert "closes at no crank angle" in page.locator("#linkage-said").text_content()
    assert page.evaluate("lab.values[0]") == 0.2


@pytest.mark.deep
def test_a_linkage_by_hand_and_by_its_address(page):
    page.get_by_role("tab", name="Four-bar").click()
    settle(page)
    before = page.evaluate("lab.values")
    box = page.locator("#bench").bounding_box()
    x, y = page.evaluate("bench.at(at_(lab.q).points[4])")
    page.mouse.move(box["x"] + x, box["y"] + y)
    page.mouse.down()
    page.mouse.move(box["x"] + x + 40, box["y"] + y - 30, steps=3)
    page.mouse.up()
    settle(page)
    after = page.evaluate("lab.values")
    assert after[:4] == before[:4] and np.hypot(*np.subtract(after[4:], before[4:])) > 0.01
    page.locator("#bench").focus()
    q = page.evaluate("lab.q")
    page.keyboard.press("ArrowLeft")
    assert page.evaluate("lab.q") == pytest.approx(q + np.pi / 180)
    page.keyboard.press("Space")
    until(page, "lab.trail.length > 20")
    page.keyboard.press("Space")
    page.get_by_role("button", name="fix the next link").click()
    settle(page)
    assert page.evaluate("lab.values.slice(0, 4)") == [*after[1:4], after[0]]
    address = "#linkage=slider_rod&values=0.05,0.15,-0.01&branch=+&crank=0.5"
    visit(page, address)
    assert page.evaluate("[lab.kind, lab.values, lab.q]") == [
        "slider_rod",
        [0.05, 0.15, -0.01],
        0.5,
    ]
    for bad in (
        "values=1",
        address + "&x=1",
        address.replace("rod", "bar"),
        address.replace("0.15", "1e99"),
        address.replace("0.15", "5"),
    ):
        visit(page, "#linkage=four&" * (bad == "values=1") + bad)
        assert "not taken" in page.locator("#said").text_content(), bad


@pytest.mark.deep
def test_a_linkage_as_python(page, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # its lines write a page
    page.evaluate("showTab('four')")
    for kind, branch, _, values, _ in LINKAGES:
        signs = [branch] if isinstance(branch, int) else list(branch)
        page.evaluate(
            "([kind, values, branch]) => chooseKind(kind, values, branch)", [kind, values, signs]
        )
        names = {}
        exec(compile(page.evaluate("linkagePython()"), kind, "exec"), names)
        at = page.evaluate("at_(lab.q).points[wordsOf().traced]")
        motion = names["motion"]
        np.testing.assert_allclose(motion.position(motion.chain.traced), at, atol=1e-12)
    assert "turns" in capsys.readouterr().out  # its verdicts


def test_a_named_coupler_point_is_what_a_study_plots():
    with_point, without = (
        linkages.study(LINKAGES[0][2]),
        linkages.study(linkages.FourBar(*CRANK_ROCKER[:4])),
    )
    assert usual_panels(with_point)[1:] == [["M.speed"], ["M.tangential", "M.normal"]]
    assert usual_panels(without)[1] == ["crank.rate", "coupler.rate", "rocker.rate"]
    assert len(with_point.plot().axes) >= 3


@pytest.mark.deep
def test_a_page_for_a_linkage(opened, tmp_path, capsys):  # noqa: F811
    out = tmp_path / "live.html"
    assert (
        main(["linkage", "slider-crank", "0.05", "0.15", "--held", "rod", "--live", str(out)]) == 0
    )
    assert capsys.readouterr().out.splitlines()[-1] == str(out)
    page = opened(out)
    assert page.evaluate("[lab.kind, lab.values]") == ["slider_rod", [0.05, 0.15, 0]]
    assert fb.play(linkages.PRINTED).fragment.startswith(
        "#linkage=press&values=0.202,0.54,0.25,0.4,0.434&branch=--"
    )
    with pytest.raises(ValueError, match="leave it out"):
        fb.play(LINKAGES[0][2], fb.igm(fb.FiveBar(), (0.0, 0.1)))


@pytest.mark.deep
@pytest.mark.parametrize("number", range(len(LINKAGES)))
def test_arrows_and_title_of_a_linkage(opened, tmp_path, number):  # noqa: F811
    """At each crank angle all arrows are inside the plane; the title names the linkage."""
    fb.play(LINKAGES[number][2]).save(tmp_path / "live.html")
    page = opened(tmp_path / "live.html", 390, 844)
    assert page.evaluate(
        "document.querySelector('[aria-selected=true]').textContent + ', live'"
    ) == (page.title())
    assert page.locator("h1").text_content() == page.title()
    arrows_fit(page)
    narrow = page.evaluate("bench.width")
    page.set_viewport_size({"width": 1440, "height": 900})
    until(page, f"bench.width > {narrow} + 100")
    arrows_fit(page)


def arrows_fit(page):
    low, high, right, bottom, longest = page.evaluate(
        """() => { const tips = lab.sweep.rows.filter(Boolean).flatMap(row => arrowsAt(row).map(([, x, y]) => {
            const [x0, y0] = bench.at(row.points[wordsOf().traced]); return [x0 + x, y0 + y, Math.hypot(x, y)]; }));
            const [xs, ys, lengths] = [0, 1, 2].map(k => tips.map(tip => tip[k]));
            return [Math.min(...xs, ...ys), Math.max(...lengths) - 0.22 * Math.min(bench.width, bench.height),
                Math.max(...xs) - bench.width, Math.max(...ys) - bench.height, Math.max(...lengths)]; }"""
    )
    assert low > 10 and high < 1e-9 and right < -10 and bottom < -10 and longest > 40


@pytest.mark.deep
def test_two_studies_on_one_page(opened, tmp_path):  # noqa: F811
    slow, fast = (linkages.study(LINKAGES[0][2], speed=speed) for speed in (3.0, 6.0))
    fb.page({"slow": slow, "fast": fast}, tmp_path / "page.html")
    page = opened(tmp_path / "page.html")
    assert page.locator(".legend .name").all_text_contents()[:2] == ["slow", "fast"]
    page.evaluate("go(nearest(clock, 0.5))")
    settle(page)
    angles = [
        float(text.replace("−", "-"))
        for text in page.locator("figure").first.locator("output").all_text_contents()
    ]
    expected = [np.degrees(np.interp(0.5, own.t, own["crank.angle"])) for own in (slow, fast)]
    np.testing.assert_allclose(angles, expected, atol=1.5)
    with pytest.raises(ValueError, match="no quantity 'slide'"):
        fb.page({"a": slow, "b": fast}, tmp_path / "other.html", show="slide")


@pytest.mark.deep
@pytest.mark.parametrize(
    "address, kind, seed", [("four", "four", 1), ("slider", "slider_guide", 2)]
)
def test_the_least_transmission_angle_is_exact(computing, address, kind, seed):  # noqa: F811
    """Of random linkages that turn or lock: by the law of cosines, by the height of the crank."""
    rng = np.random.default_rng(seed)
    locks = 0
    computing.evaluate("showTab", address)
    for _ in range(25):
        if kind == "four":
            ground, crank, coupler, rocker = sides = rng.uniform(0.03, 0.3, 4).round(3)
            if 2 * sides.max() >= sides.sum():
                continue
            diagonals = np.abs(ground - crank), ground + crank
            cosines = [
                (coupler**2 + rocker**2 - each**2) / (2 * coupler * rocker) for each in diagonals
            ]
            exact = min(min(x, np.pi - x) for x in np.arccos(np.clip(cosines, -1, 1)))
            values = [*sides, 0.05, 0.02]
        else:
            crank, rod, offset = values = rng.uniform(0.03, 0.3, 3).round(3)
            if crank + rod <= offset:
                continue
            exact = np.arccos(min((crank + offset) / rod, 1.0))
            values = values.tolist()
        assert computing.evaluate(
            "([kind, values]) => chooseKind(kind, values, [1])", [kind, [float(x) for x in values]]
        )
        found, edges = computing.evaluate("[lab.sweep.least, lab.sweep.edges.length]")
        locks += edges > 0
        assert found == pytest.approx(exact, abs=1e-7), values
    assert 3 < locks < 25


@pytest.mark.deep
def test_the_curve_of_an_angle_has_no_jump(page):
    page.get_by_role("tab", name="Four-bar").click()
    page.evaluate("chooseKind('four', [0.2, 0.12, 0.16, 0.14, 0.08, 0.05], [1])")
    found = np.array(page.evaluate("lab.sweep.rows.filter(Boolean).map(row => row.output[0])"))
    shown = np.array(
        page.evaluate("lab.sweep.rows.filter(Boolean).map(row => at_(row.q).output[0])")
    )
    assert np.abs(np.diff(shown)).max() > 6 and np.abs(np.diff(found)).max() < 0.5
    turns = (found - shown) / (2 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-12)
    assert abs(found.mean()) <= np.pi
