"""Linked pages of runs and linkages as a browser without a network sees them, and what `page` refuses."""

import csv
import io
import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.linkages import GRAVITY, PRESSES, FiveBarLinkage, FourBar, study
from fivebar.visualization import document
from fivebar.visualization.pages import runs, studies
from fivebar.visualization.pages.linked import story
from fivebar.visualization.style import readable

from ..conftest import UNEQUAL
from ..helpers.browsing import settle, until
from ..helpers.pages import (  # noqa: F401  fixtures
    bars,
    browser,
    chain,
    contrast,
    download,
    hover,
    opened,
    seen,
)

HOSTILE = '</script></title><script>window.hacked = 1</script><img src=x onerror="hacked = 1">$$x$$ ${1} <!-- "é", \n&amp;'
LINE = fb.line((0.09, 0.06796322), (0.0, 0.1), 2.0)


def simulated(robot=fb.FiveBar(), kp=100.0, reference=LINE, **options):  # noqa: B008  frozen
    controller = fb.ComputedTorque(robot, kp, 2 * kp**0.5)
    return fb.simulate(robot, controller, reference, control_period=0.01, step=0.001, **options)


@pytest.fixture(scope="module")
def run():
    return simulated(torque_limit=0.006)


@pytest.fixture(scope="module")
def crossing():
    """The free motion of the shared reference numbers, which crosses Type 2."""
    start = fb.ikm(fb.igm(fb.FiveBar(), (0.01, 0.12), (1, -1)), (0.02, -0.30))
    return fb.simulate(fb.FiveBar(), duration=1.0, start=start, step=1e-3)


def written(subject, tmp_path, **options):
    path = tmp_path / "page.html"
    fb.page(subject, path, **options)
    return path


def sample(page):
    return page.evaluate("at")


def cursors(page):
    """Where the cursors are in their frames, px."""
    return page.evaluate(
        "[...document.querySelectorAll('.cursor')].map(c => new DOMMatrix(getComputedStyle(c).transform).e + 1)"
    )


def resize(page, width, height):
    """Another window, in which all has been laid out anew."""
    page.set_viewport_size({"width": width, "height": height})
    until(page, f"innerWidth === {width} && innerHeight === {height}")
    until(
        page,
        """pictures.map(({svg, width, height}) => [svg.getBoundingClientRect(), width, height])
            .every(([box, width, height]) => !box.width || !box.height || box.width === width && box.height === height)
        """,
    )
    wide = "Math.floor(element.getBoundingClientRect().width)"
    until(page, f"plots.every(({{element, view}}) => view.bbox.width === {wide})")
    settle(page)


def strokes(page):
    """The bars' colours."""
    return page.evaluate(
        "[...document.querySelectorAll('.bar')].map(bar => bar.getAttribute('stroke'))"
    )


@pytest.mark.deep
def test_pointing_at_any_plot_puts_the_robot_where_dgm_says(opened, tmp_path, run):  # noqa: F811
    page = opened(written(run, tmp_path))
    assert strokes(page) == ["#0072B2", "#5393D8", "#C7443C", "#B65818"]  # as in plots and scenes
    assert set(strokes(page)) <= {line.get_color() for line in run.plot().axes[0].lines}
    assert strokes(page) == fb.view.scene(run.robot, run).machines[0].body.colours
    assert (
        page.locator(".glass").count() == 4
        and page.locator("h2").first.text_content() == "tracking error (mm)"
    )
    for plot, across, drag in [
        (0, 0.25, False),
        (1, 0.7, True),
        (2, 0.001, False),
        (3, 0.999, False),
    ]:
        hover(page, plot, across, drag=drag)
        k = sample(page)
        assert k == pytest.approx(2000 * across, abs=3)
        np.testing.assert_allclose(bars(page), chain(fb.dgm(run.robot, run.q[k])), atol=1e-9)
        width = page.locator(".glass").first.bounding_box()["width"]
        np.testing.assert_allclose(cursors(page), k / 2000 * width, atol=0.6)
        assert page.locator("#clock").text_content() == f"{run.t[k]:g} s"
        shown = page.locator("figure").nth(1).locator("output").first.text_content()
        assert float(shown.replace("−", "-")) == pytest.approx(1e3 * run.tau[k, 0], rel=1e-4)


@pytest.mark.deep
def test_a_biglide_and_its_guides(opened, tmp_path):  # noqa: F811
    robot = fb.Biglide()
    home = fb.dgm(robot, (0.0, 0.0)).xi
    run = simulated(robot, reference=fb.line(home, home + (0.05, 0.05), 1.0), duration=1.0)
    page = opened(written(run, tmp_path, show=list(runs.QUANTITIES)))
    heads = page.locator("h2").all_text_contents()
    assert (
        page.title() == "biglide robot, all bars 282.8 mm, base 400 mm"
        and "motor forces (N)" in heads
        and "active joints (mm)" in heads
    )
    for plot, across in ((0, 0.4), (6, 0.9)):
        hover(page, plot, across)
        k = sample(page)
        pose = fb.dgm(robot, run.q[k])
        np.testing.assert_allclose(bars(page), chain(pose), atol=1e-9)
        shown = page.locator("figure").nth(6).locator("output").all_text_contents()
        expected = [*fb.singularity_margins(pose).serial, pose.det_A]
        np.testing.assert_allclose([float(text) for text in shown], expected, rtol=1e-4)
    rails = page.evaluate(
        """[...document.querySelectorAll('.rail')].map(
            rail => ['x1', 'x2'].map(name => (+rail.getAttribute(name) - scene.origin[0]) / scene.scale))"""
    )
    np.testing.assert_allclose(rails, [[-0.2, -0.2], [0.2, 0.2]], atol=1e-12)
    with pytest.raises(ValueError, match="of cranks and of sliders cannot be compared"):
        written({"biglide": run, "five-bar": simulated(duration=0.1)}, tmp_path)


def test_pointing_at_the_path_finds_its_sample(opened, tmp_path, run):  # noqa: F811
    page = opened(written(run, tmp_path))
    for k in (300, 1000, 1500):
        x, y = page.evaluate("xi => scene.onScreen(xi)", run.xi[k].tolist())
        box = page.locator("svg.scene").bounding_box()
        page.mouse.move(box["x"] + x, box["y"] + y)
        settle(page)
        assert np.linalg.norm(run.xi[sample(page)] - run.xi[k]) < 1e-3


@pytest.mark.deep
def test_keys_move_the_time_and_play(opened, tmp_path, run):  # noqa: F811
    page = opened(written(run, tmp_path, show="q"))
    slider = page.get_by_role("slider", name="time")
    for keys, at in [
        (["End"], 2000),
        (["Shift+ArrowLeft"], 1999),
        (["Home"], 0),
        (["ArrowRight"] * 3, 15),
        (["PageUp"], 215),
        (["Shift+ArrowRight"] * 2, 217),
        (["PageDown", "PageDown"], 0),
    ]:
        for key in keys:
            page.keyboard.press(key)
        settle(page)
        assert sample(page) == at and float(slider.input_value()) == pytest.approx(run.t[at])
    slider.focus()
    page.keyboard.press("PageUp")
    page.keyboard.press("ArrowUp")
    settle(page)
    assert sample(page) == 205 and slider.get_attribute("aria-valuetext") == "time 0.205 s"
    np.testing.assert_allclose(bars(page), chain(fb.dgm(run.robot, run.q[205])), atol=1e-9)
    until(
        page,
        "document.getElementById('status').textContent.startsWith('time 0.205 s. active joints: left')",
    )
    page.keyboard.press(" ")
    until(page, "at > 300")
    assert page.get_by_role("button", name="pause").count() == 1
    page.keyboard.press(" ")
    settle(page)
    stopped = sample(page)
    settle(page)
    assert sample(page) == stopped
    assert page.get_by_role("button", name="play", exact=True).count() == 1


@pytest.mark.deep
def test_everything_is_reached_by_tab_and_named(opened, tmp_path, run):  # noqa: F811
    page = opened(written(run, tmp_path))
    names = []
    focused = (
        "document.activeElement.getAttribute('aria-label') ?? document.activeElement.textContent"
    )
    for _ in range(26):
        page.keyboard.press("Tab")
        names.append(page.evaluate(focused))
    wanted = [
        "picture: zoom out",
        "distance",
        "play",
        "time",
        "speed",
        "zoom in",
        "show all",
        "More",
    ]
    assert [name for name in names if name in wanted][: len(wanted)] == wanted
    assert (
        all(names)
        and page.get_by_role("img", name="tracking error (mm) over time: x from").count() == 1
    )
    unnamed = page.evaluate(
        """[...document.querySelectorAll("button, input, select, svg.scene, .plot, section")]
            .filter(e => !e.getAttribute("aria-label") && !e.textContent.trim()).length"""
    )
    assert unnamed == 0


@pytest.mark.deep
def test_zoom_keeps_the_link(opened, tmp_path, run):  # noqa: F811
    page = opened(written(run, tmp_path, show=("tau", "q")))
    window = lambda: page.evaluate("[time.start, time.end]")  # noqa: E731
    hover(page, 0, 0.5)
    page.keyboard.press("+")
    page.keyboard.press("+")
    settle(page)
    assert window() == pytest.approx([0.75, 1.25], abs=0.01)
    hover(page, 1, 0.2)
    low, high = window()
    k = sample(page)
    assert run.t[k] == pytest.approx(low + 0.2 * (high - low), abs=2e-3)
    np.testing.assert_allclose(bars(page), chain(fb.dgm(run.robot, run.q[k])), atol=1e-9)
    np.testing.assert_allclose(cursors(page)[0], cursors(page)[1])

    page.get_by_role("button", name="show all", exact=True).click()
    assert window() == [0, 2]
    box = page.locator(".glass").first.bounding_box()
    page.keyboard.down("Shift")
    page.mouse.move(box["x"] + 0.25 * box["width"], box["y"] + 20)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + 60, steps=3)
    page.mouse.up()
    page.keyboard.up("Shift")
    settle(page)
    assert window() == pytest.approx([0.5, 1.5], abs=0.01)
    page.keyboard.down("Control")
    page.mouse.wheel(0, -100)
    until(page, "time.end - time.start < 0.9")
    page.keyboard.up("Control")
    assert np.diff(window()) == pytest.approx(0.8, abs=0.01)
    page.keyboard.press("0")
    page.keyboard.press("-")
    settle(page)
    assert window() == [0, 2]
    # The picture is zoomed into about the end-effector, which then stays in its middle above the rule, 16 px.
    for _ in range(6):
        page.get_by_role("button", name="picture: zoom in").click()
    hover(page, 0, 0.6)
    box = page.locator("svg.scene").bounding_box()
    on_screen = page.evaluate("xi => scene.onScreen(xi)", run.xi[sample(page)].tolist())
    np.testing.assert_allclose(on_screen, [box["width"] / 2, box["height"] / 2 - 8], atol=2)


@pytest.mark.deep
def test_resized_and_turned_over(opened, tmp_path):  # noqa: F811
    result = study(FourBar(0.2, 0.06, 0.16, 0.14))
    page = opened(written(result, tmp_path, show="rocker.angle"))
    for width, height in ((844, 390), (390, 844), (1500, 700)):
        resize(page, width, height)
        hover(page, 0, 0.5)
        assert sample(page) == pytest.approx(180, abs=1)
        x, y = page.evaluate(
            "point => scene.onScreen(point)", result.motion.position("B")[sample(page)].tolist()
        )
        letter = page.evaluate(
            "[...scene.letters.children].find(e => e.textContent === 'B').getAttribute('x')"
        )
        assert (
            float(letter) == pytest.approx(x + 11)
            and 0 < y < page.locator("svg.scene").bounding_box()["height"]
        )
        assert page.evaluate("document.documentElement.scrollWidth") <= width


@pytest.mark.deep
def test_the_scale_is_right_in_any_window(opened, tmp_path, run):  # noqa: F811
    page = opened(written(run, tmp_path, show="tau"))
    for width, height in ((1280, 900), (700, 200), (1280, 60), (240, 240)):
        resize(page, width, height)
        drawn = re.fullmatch(r"M12 \S+v6h(\S+)v-6", page.evaluate("scene.rule.getAttribute('d')"))
        number, unit = page.evaluate("scene.length.textContent").split()
        metres = float(number) * {"mm": 1e-3, "m": 1.0}[unit]
        assert (
            float(drawn[1]) == pytest.approx(page.evaluate("scene.scale") * metres)
            and float(drawn[1]) > 0
        )


@pytest.mark.deep
def test_csv_and_png_from_the_page(opened, tmp_path, run):  # noqa: F811
    page = opened(written(run, tmp_path, show=list(runs.QUANTITIES), title="a, run/2"))
    name, data = download(page, "CSV")
    assert name == "a-run-2.csv"
    first, *lines = data.decode().split("\n")
    assert "Run.to_csv writes all" in first and first.startswith(
        "# fivebar page: a, run/2; SI units"
    )
    table = list(csv.reader(io.StringIO("\n".join(lines))))
    columns = dict(zip(table[0], np.array(table[1:], dtype=float).T, strict=True))
    size = np.linalg.norm(run.error, axis=1)
    pose = fb.igm(run.robot, run.xi)
    for title, values in {
        "t (s)": run.t,
        "q left (rad)": run.q[:, 0],
        "q_dot right (rad/s)": run.q_dot[:, 1],
        "xi y (m)": run.xi[:, 1],
        "error distance (m)": size,
        "q_error left (rad)": run.q_error[:, 0],
        "tau right (N m)": run.tau[:, 1],
        "energy energy (J)": run.energy,
        "potential energy (J)": run.potential,
    }.items():
        np.testing.assert_array_equal(columns[title], values)
    for title, sines in zip(
        ["left leg", "right leg", "distal bars"], [*pose.sines, pose.det_A], strict=True
    ):
        np.testing.assert_allclose(columns[f"margins {title}"], sines, atol=1e-9)
    assert len(columns) == 19

    from matplotlib.image import imread

    name, data = download(page, "PNG")
    picture = imread(io.BytesIO(data))[..., :3]
    assert name == "a-run-2.png" and picture.shape[1] == 2200 and picture.shape[0] > 2000
    assert np.ptp(picture, axis=2).max() > 0.3 and (picture == 1).all(axis=2).mean() > 0.5
    left, right = (
        picture[:, :980],
        picture[:, 980:],
    )  # the mechanism, and the plots under one another
    blue = [
        (np.abs(part - np.array([0, 0x72, 0xB2]) / 255) < 0.02).all(axis=2)
        for part in (left, right)
    ]
    assert blue[0].sum() > 2000 and (blue[1].sum(axis=1) > 5).sum() > 100


@pytest.mark.deep
def test_contrast(opened, tmp_path, run):  # noqa: F811
    page = opened(written({"a": run, "b": run}, tmp_path))

    def colour(selector, which="color"):
        return page.evaluate(f"getComputedStyle(document.querySelector({selector!r})).{which}")

    for scheme in ("light", "dark"):  # the theme may change while the page is open
        page.emulate_media(color_scheme=scheme)
        settle(page)
        paper = colour("body", "backgroundColor")
        assert (contrast(paper, "#ffffff") > 15) == (scheme == "dark")
        assert contrast(colour("h1"), paper) > 12
        for quiet in ("h2 small", ".legend output", ".state", "summary"):
            assert contrast(colour(quiet), paper) > 4.5
        assert contrast(colour("button"), colour("button", "backgroundColor")) > 7
        strokes = page.evaluate(
            "plots.flatMap(plot => plot.curves.map(curve => curve.glyph.line_color.value))"
        )
        assert len(set(strokes)) == 2
        for stroke in [*strokes, *(page.evaluate(f"theme('--c{k}')") for k in range(6))]:
            assert contrast(stroke, paper) > 3
        axis = page.evaluate("plots[0].figure.yaxes[0].major_label_text_color")
        assert contrast(axis if isinstance(axis, str) else axis["value"], paper) > 7
    # On paper the dark is light, plots are still pictures, and controls are gone.
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    page.emulate_media(color_scheme="dark", media="print")
    assert (
        contrast(colour("body", "backgroundColor"), "#ffffff") < 1.01
        and contrast(colour("h1"), "#ffffff") > 12
    )
    assert (
        not page.locator("#controls").is_visible()
        and page.locator(".still").count() == len(strokes) // 2
    )
    inks = """[...document.querySelectorAll(".still")].map(canvas => {
        const found = new Set(), {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        for (let k = 0; k < data.length; k += 4) found.add(data.slice(k, k + 3).join());
        return ["29,33,38", "0,114,178", "255,255,255"].every(ink => found.has(ink)); })"""
    assert all(page.evaluate(inks)), "numbers and curves as in the light, on paper"
    assert not page.locator(".bk-Figure").first.is_visible()
    page.emulate_media(color_scheme="dark", media="screen")
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert (
        page.locator(".still").count() == 0
        and contrast(colour("body", "backgroundColor"), "#ffffff") > 15
    )


@pytest.mark.deep
def test_curves_differ_by_more_than_colour(opened, tmp_path, run):  # noqa: F811
    page = opened(written({name: run for name in "abcd"}, tmp_path, show="tau"))
    dashes = page.evaluate("plots[0].curves.map(curve => String(curve.glyph.line_dash.value))")
    assert len(set(dashes)) == 4


@pytest.mark.deep
def test_phone(opened, tmp_path, run):  # noqa: F811
    page = opened(written(run, tmp_path), width=390, height=844, has_touch=True, is_mobile=True)
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    picture, plot = (
        page.locator(selector).first.bounding_box() for selector in ("svg.scene", ".plot")
    )
    assert (
        plot["y"] >= picture["y"] + picture["height"]
        and picture["width"] > 340
        and plot["width"] > 340
    )
    boxes = "[...document.querySelectorAll('button, select, input')].map(e => e.getBoundingClientRect())"
    folded = page.evaluate("document.getElementById('controls').offsetHeight")
    page.get_by_text("More").click()  # what is used less
    for box in page.evaluate(boxes):
        assert box["x"] >= 0 and box["x"] + box["width"] <= 390 and box["height"] >= 14
    page.get_by_text("More").click()
    assert page.evaluate("document.getElementById('controls').offsetHeight") == folded < 110
    page.evaluate("scrollTo(0, document.body.scrollHeight)")
    assert 0 <= page.locator("svg.scene").bounding_box()["y"] < 10, (
        "the picture stays beside what it explains"
    )
    page.evaluate("scrollTo(0, 0)")
    box = page.locator(".glass").first.bounding_box()
    page.touchscreen.tap(box["x"] + box["width"] * 0.75, box["y"] + 30)
    settle(page)
    assert sample(page) == pytest.approx(0.75 * page.evaluate("clock.length"), rel=0.02)


def test_hostile_names_stay_text(opened, tmp_path, run):  # noqa: F811
    path = written({HOSTILE: run, "plain": run}, tmp_path, title=HOSTILE, show=("tau", "q"))
    page = opened(path)
    assert page.title().split() == HOSTILE.split() and page.locator("h1").text_content() == HOSTILE
    assert page.evaluate("window.hacked") is None and page.locator("img").count() == 0
    assert page.locator(".legend .name").first.text_content() == HOSTILE
    assert path.read_text("utf-8").count("window.hacked = 1</script>") == 0
    _, data = download(page, "CSV")
    table = list(csv.reader(io.StringIO(data.decode().split("\n", 1)[1], newline="")))
    assert {row[0] for row in table[1:]} == {HOSTILE, "plain"} and {len(row) for row in table} == {
        6
    }


@pytest.mark.deep
def test_runs_are_compared_each_in_its_own_time(opened, tmp_path, run):  # noqa: F811
    other = simulated(UNEQUAL, reference=fb.line((0.03, 0.12), (0.0, 0.1), 1.0), duration=1.0)
    page = opened(written({"long": run, "short": other}, tmp_path))
    notes = page.locator("#notes").text_content()
    assert "The robots differ." in notes and "The runs differ in time" in notes
    assert [h.split(" (")[0] for h in page.locator("h2").all_text_contents()][:3] == [
        "tracking error, distance",
        "motor torques, left",
        "motor torques, right",
    ]
    for across in (0.3, 0.9):
        hover(page, 1, across)
        k = round(page.evaluate("clock[at]") * 1000)
        np.testing.assert_allclose(bars(page, 0), chain(fb.dgm(run.robot, run.q[k])), atol=1e-9)
        np.testing.assert_allclose(
            bars(page, 1), chain(fb.dgm(UNEQUAL, other.q[min(k, 1000)])), atol=1e-9
        )


@pytest.mark.deep
def test_a_story_plays_once_in_two_pictures(opened, tmp_path):  # noqa: F811
    short = simulated(reference=fb.line((0.09, 0.06796322), (0.08, 0.07), 0.4), duration=0.4)
    told = {"short": short, "longer": simulated(duration=0.6)}
    shown = story(told, tmp_path / "page.html", ("error", "tau"), "A story", ["It begins."])
    assert repr(shown) == "<Page: A story>" and "A story" in shown._repr_html_()
    page = opened(tmp_path / "page.html")
    assert page.locator("#notes li").first.text_content() == "It begins."
    until(page, "!player.playing && at === clock.length - 1")
    assert page.locator("svg.scene").count() == 2 == page.locator(".mechanism").count()
    assert page.locator("#picture h2").all_text_contents() == ["short", "longer"]
    for number, run in enumerate(told.values()):
        ends = page.evaluate(
            """number => [...pictures[number].svg.querySelectorAll(".bar")].map(bar => ["x1", "y1", "x2", "y2"]
                .map(name => +bar.getAttribute(name))).map(([x1, y1, x2, y2]) => [[x1, y1], [x2, y2]].map(([x, y]) =>
                [(x - pictures[number].origin[0]) / pictures[number].scale,
                 (pictures[number].origin[1] - y) / pictures[number].scale]))""",
            number,
        )
        np.testing.assert_allclose(ends, chain(fb.dgm(run.robot, run.q[-1])), atol=1e-9)
    assert strokes(page) == 2 * ["#0072B2", "#5393D8", "#C7443C", "#B65818"]


@pytest.mark.deep
def test_singularities_crossed_are_marked(opened, tmp_path, crossing):  # noqa: F811
    page = opened(written(crossing, tmp_path))
    first = crossing.events[0]
    page.get_by_role("button", name=f"go to Type 2 at {first.t:.5g} s").click()
    settle(page)
    assert crossing.t[sample(page)] == pytest.approx(first.t, abs=6e-4)
    assert page.evaluate("plots[0].marks.length") == len(crossing.events) > 1
    # the bars are those of the motion itself through all modes
    for k in (0, 400, 900):
        page.evaluate("k => go(k)", k)
        settle(page)
        lengths = np.linalg.norm(np.diff(bars(page), axis=1), axis=-1)
        np.testing.assert_allclose(lengths, 0.09, atol=1e-8)
        np.testing.assert_allclose(bars(page)[1, 1], crossing.xi[k], atol=1e-12)


@pytest.mark.deep
def test_samples_that_are_nan_are_gaps(opened, tmp_path, run):  # noqa: F811
    q, tau = run.q.copy(), run.tau.copy()
    q[500:600] = np.nan
    tau[700, 0] = np.inf
    page = opened(written(replace(run, q=q, tau=tau), tmp_path))
    assert (
        "Gaps where values are not finite: q in 100, tau in 1 of 2001 samples."
        in page.locator("#notes").text_content()
    )
    hover(page, 0, 0.27)
    assert not seen(page) and "no pose here" in page.locator(".state").text_content()
    assert page.locator("figure").nth(2).locator("output").first.text_content() == "none"
    hover(page, 0, 0.5)
    assert seen(page) and "no pose" not in page.locator(".state").text_content()
    drawn = page.evaluate("[...plots[2].curves[0].data_source.data.y]")
    assert drawn.count(None) + sum(y != y for y in drawn if y is not None) > 0


@pytest.mark.deep
def test_a_million_samples_are_thinned_with_a_note(opened, tmp_path, run):  # noqa: F811
    n = 1_000_000
    names = ("q", "q_dot", "xi", "tau", "energy", "xi_ref")
    index = np.linspace(0, 2000, n).round().astype(int)
    long = replace(
        run, t=np.linspace(0, 1000, n), **{name: getattr(run, name)[index] for name in names}
    )
    path = written(long, tmp_path)
    assert path.stat().st_size < 6e6
    page = opened(path)
    note = page.locator("#notes").text_content()
    held = page.evaluate("clock.length")
    assert (
        f"This page, its CSV included, holds {held} of 1000000 samples, evenly spaced; Run.to_csv has all."
        in note
    )
    assert 10_000 < held < 40_000 and page.evaluate("clock[clock.length - 1]") == 1000
    hover(page, 1, 0.4)
    k = round(page.evaluate("clock[at]") / 1000 * (n - 1))
    np.testing.assert_allclose(bars(page), chain(fb.dgm(run.robot, long.q[k])), atol=1e-9)


def test_ten_seconds_fit(tmp_path):
    long = simulated(reference=fb.line((0.09, 0.06796322), (0.0, 0.1), 10.0))
    sizes = [
        written(subject, tmp_path, show=show).stat().st_size
        for subject, show in [
            (long, None),
            (long, list(runs.QUANTITIES)),
            ({"a": long, "b": long, "c": long}, None),
        ]
    ]
    assert sizes[0] < 4e6 and max(sizes) < 6e6


@pytest.mark.deep
@pytest.mark.parametrize("speed", [-2.0])
def test_study_over_the_crank_angle(opened, tmp_path, speed):  # noqa: F811
    result = study(FourBar(0.2, 0.06, 0.16, 0.14, point=(0.08, 0.05)), speed=speed)
    page = opened(written(result, tmp_path))
    heads = [
        "angle (deg)",
        "speed of M (mm/s)",
        "tangential acceleration, normal acceleration of M (mm/s²)",
    ]  # of the point that is named
    assert page.locator("h2").all_text_contents() == heads
    # The coupler's triangle is one link, and a link has the colour that it has in plots and scenes.
    blue, orange, green = "#0072B2", "#C7443C", "#009E73"
    assert (
        strokes(page)
        == [blue, orange, green, orange, orange]
        == fb.view.scene(result.linkage, result).machines[0].body.colours
    )
    assert [
        line.get_color() for line in result.plot().axes[0].lines if line.get_linewidth() == 3
    ] == strokes(page)
    key = page.locator("[aria-label='colours of the picture'] li").all_text_contents()
    assert key == ["path", "crank", "coupler", "rocker"]
    low, high = sorted(np.degrees(result.q[[0, -1]]))
    for plot, across in ((0, 0.3), (2, 0.8)):
        hover(page, plot, across)
        k = sample(page)
        assert np.degrees(result.q[k]) == pytest.approx(low + across * (high - low), abs=1.1)
        position = {
            name: point
            for name, point in zip(result.motion.points, result.points()[k], strict=True)
        }
        expected = [[position[a], position[b]] for a, b in result.motion.chain.bars]
        np.testing.assert_allclose(bars(page), expected, rtol=0, atol=1e-15)
    before = page.evaluate("abscissa(at)")
    page.keyboard.press("ArrowRight")
    settle(page)
    assert page.evaluate("abscissa(at)") > before
    head, first, *_ = csv.reader(io.StringIO(download(page, "CSV")[1].decode().split("\n", 1)[1]))
    assert head[:3] == ["t (s)", "q (rad)", "crank.angle (rad)"]
    assert [float(x) for x in first[:3]] == [0, result.q[0], result["crank.angle"][0]]


@pytest.mark.deep
@pytest.mark.parametrize(
    "result",
    [
        lambda: study(PRESSES["repaired"][0], turns=2, speed=2.0, gravity=GRAVITY),
        lambda: study(FiveBarLinkage(fb.FiveBar(), (1, 2)), drive="swing"),
        lambda: study(
            PRESSES["printed"][0], drive="until-lock", speed=2.0, start=np.radians(160.24)
        ),
        lambda: study(
            FourBar(0.2, 0.06, 0.16, 0.14, point=(0.08, 0.05)), quantities=["M.curvature_radius"]
        ),
    ],
)
def test_other_linkages(opened, tmp_path, result):  # noqa: F811
    result = result()
    page = opened(
        written(
            result, tmp_path, show=None if "torque" in result.columns else list(result.columns)[:3]
        )
    )
    k = len(result.t) // 3
    page.evaluate("k => go(k)", k)
    settle(page)
    assert seen(page)
    ends = bars(page).reshape(-1, 2)
    gaps = np.linalg.norm(ends[:, None] - result.points()[k], axis=-1).min(axis=1)
    assert gaps.max() < 1e-14 * np.abs(ends).max()  # drawn in pixels
    if result.lock:
        assert "ends before the mechanism locks, at" in page.locator("#notes").text_content()


def test_only_what_is_shown_is_computed(tmp_path, run, monkeypatch):
    def refuse(*arguments):
        raise AssertionError("computed, but not shown")

    monkeypatch.setattr(runs, "singularity_margins", refuse)
    monkeypatch.setattr(fb.Run, "q_error", property(refuse))
    monkeypatch.setattr(fb.Run, "error", property(refuse))
    written(run, tmp_path, show=("q", "tau"))
    with pytest.raises(AssertionError, match="not shown"):
        written(run, tmp_path, show="margins")


def test_nothing_heavy_is_loaded(tmp_path):
    script = f"""
import sys
import fivebar as fb
run = fb.simulate(fb.FiveBar(), duration=0.1, step=1e-3)
heavy = {{"bokeh", "matplotlib", "tornado", "pandas"}}
run.page({str(tmp_path / "page.html")!r})
assert not heavy & sys.modules.keys(), heavy & sys.modules.keys()
"""
    subprocess.run(
        [sys.executable, "-W", "error", "-c", script], check=True, cwd=Path(fb.__file__).parents[1]
    )


def _changed(run, **changes):
    return replace(run, **changes)


@pytest.mark.parametrize(
    ("subject", "options", "message"),
    [
        (lambda run: {}, {}, "at least one run"),
        (
            lambda run: _changed(run, t=run.t[:0]),
            {},
            "the run has 0 samples: a motion needs at least 2",
        ),
        (lambda run: {"a": run, "b": _changed(run, t=run.t[:1])}, {}, "the run 'b' has 1 samples"),
        (
            lambda run: _changed(run, t=np.where(run.t == 1, np.nan, run.t)),
            {},
            r"t\[1000\] is nan, not finite",
        ),
        (lambda run: _changed(run, t=run.t[::-1]), {}, r"t\[1\] = 1.999 is not after t\[0\] = 2"),
        (lambda run: _changed(run, q=run.q[:9]), {}, "2001 samples of t, but 9 of q"),
        (
            lambda run: _changed(run, q=run.q * np.nan),
            {},
            "no sample has a pose that could be drawn",
        ),
        (
            lambda run: run,
            {"show": "speed"},
            "no quantity 'speed'; the known ones are q, q_dot, xi, error",
        ),
        (lambda run: run, {"show": ()}, "show is empty"),
        (
            lambda run: _changed(run, xi_ref=None),
            {"show": ("q", "error")},
            "error cannot be shown: .* without a ref",
        ),
        (
            lambda run: study(FourBar(0.2, 0.06, 0.16, 0.14)),
            {"show": ["torque", "B.z"]},
            "no quantity 'B.z'",
        ),
        (
            lambda run: study(FourBar(0.2, 0.06, 0.16, 0.14)),
            {"show": [["B.x", "B.vx"]]},
            "B.x, B.vx have m, m/s",
        ),
        (lambda run: study(FourBar(0.2, 0.06, 0.16, 0.14)), {"show": []}, "show is empty"),
        (
            lambda run: study(FourBar(0.2, 0.06, 0.16, 0.14)),
            {"show": "speed"},
            "no quantity .speed.; the known",
        ),
    ],
)
def test_what_cannot_be_shown_is_refused(tmp_path, run, subject, options, message):
    with pytest.raises(ValueError, match=message):
        written(subject(run), tmp_path, **options)
    assert not (tmp_path / "page.html").exists()


def test_other_failures(tmp_path, run, monkeypatch):
    with pytest.raises(TypeError, match="shows a Run, a Plan, a TimedPath, .* or a Map, not int"):
        fb.page(3, tmp_path / "page.html")
    with pytest.raises(TypeError, match="a page compares Runs, but 'a' is a str"):
        fb.page({"a": "run"}, tmp_path / "page.html")
    with pytest.raises(FileNotFoundError, match="nowhere"):
        run.page(tmp_path / "nowhere" / "page.html")
    monkeypatch.setattr(document, "find_spec", lambda name: None)
    with pytest.raises(ImportError, match="pip install bokeh"):
        run.page(tmp_path / "page.html")


@pytest.mark.deep
def test_two_samples_and_nothing_that_moves(opened, tmp_path, run):  # noqa: F811
    arrays = {
        name: getattr(run, name)[[0, 0]] for name in ("q", "q_dot", "xi", "tau", "energy", "xi_ref")
    }
    still = replace(run, t=np.array([5.0, 7.0]), **arrays)
    page = opened(written(still, tmp_path))
    hover(page, 0, 0.9)
    assert sample(page) == 1
    np.testing.assert_allclose(bars(page), chain(fb.dgm(run.robot, run.q[0])), atol=1e-9)


@pytest.mark.deep
def test_from_the_command_line(tmp_path, capsys):
    path = tmp_path / "page.html"
    track = ["track", "--from", "0.09", "0.06796322", "--to", "0", "0.1", "--duration", "0.5"]
    for command, content in [
        ([*track, "--page", str(path)], "five-bar robot"),
        (["linkage", "four-bar", "0.2", "0.06", "0.16", "0.14", "--page", str(path)], "four-bar"),
        (["track", "--case", "task-1", "--page", str(path)], "five-bar robot: ctc, ctc-stiff, mpc"),
    ]:
        assert main(command) == 0
        assert capsys.readouterr().out.rstrip().endswith(str(path))
        assert f"<h1>{content}" in path.read_text("utf-8")
        path.unlink()
    assert main([*track, "--json", "--page", str(path)]) == 0
    assert json.loads(capsys.readouterr().out)["files"] == [str(path)]
    assert main([*track, "--page", str(tmp_path / "new" / "page.html")]) == 0
    assert (tmp_path / "new" / "page.html").exists()


@pytest.mark.deep
def test_a_moment_has_a_link_that_the_page_follows(opened, tmp_path, run):  # noqa: F811
    page = opened(written(run, tmp_path))
    page.locator("#controls input[type=range]").evaluate(
        "slider => { slider.value = 1.23; slider.oninput(); }"
    )
    settle(page)
    link = page.get_by_role("link", name="Link to 1.23 s")
    assert link.get_attribute("href") == "#t=1.23"
    page.evaluate("go(0)")
    settle(page)
    page.evaluate("location.hash = '#t=1.23'")
    until(page, "at === 1230")
    for text in ("#t=", "#t=abc", "#other"):  # no moment: nothing moves
        page.evaluate("text => { location.hash = text; }", text)
        settle(page)
        assert sample(page) == 1230


@pytest.mark.deep
def test_a_page_opened_at_a_moment_shows_it(browser, tmp_path, run):  # noqa: F811
    for path, shown in (
        (written(run, tmp_path), "document.getElementById('clock').textContent"),
        (tmp_path / "animation.html", "document.getElementById('clock').value"),
    ):
        if not path.exists():
            run.animate(path)
        page = browser.new_page()
        page.goto(path.as_uri() + "#t=1.77")
        until(page, "document.body.dataset.ready")
        until(page, f"{shown} === '1.77 s'")
        page.close()


def test_rounding_reads_as_zero(tmp_path):
    """The slider of a slider-crank moves along y = 0, but for 1e-17 m; a small robot's 1e-10 m is seen."""
    moved = study(fb.linkages.SliderCrank(0.05, 0.15))
    assert 0 < np.abs(moved["B.y"]).max() < 1e-15
    plots = studies.studies_content({"": moved}, ["B.y", "slide.position"])["panels"]
    assert [(plot["unit"], plot["scale"]) for plot in plots] == [("m", 0.0), ("mm", 1e3)]
    assert readable(1.4e-17, "m") == (0.0, "m")
    assert readable(3e-10, "m") == (1e9, "nm") and readable(3e-10, "m", 1e-9) == (0.0, "m")
    assert readable(2.1e4, "m/s") == (1e-3, "km/s") and readable(1060.0, "m") == (1.0, "m")
    assert readable(0.0018, "kg m^2") == (1e3, "g m^2") and readable(2.0, "kg") == (1.0, "kg")
