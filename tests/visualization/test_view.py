"""The page of a scene, as a browser without a network sees and uses it."""

import html
import io
import itertools
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

import fivebar as fb
from fivebar import linkages
from fivebar.visualization import view
from fivebar.visualization.skeleton import Skeleton
from fivebar.visualization.view.frames import choose
from fivebar.visualization.view.machine import Machine
from tests.helpers import DATA

from ..helpers.browsing import chromium, offline, settle, until

ROBOT = fb.FiveBar()
HOSTILE = (
    '</title></script><script>window.hacked = 1</script><img src="http://example.com/x.png" onerror="hacked = 1"> $half'
    " ${x} & é \\u003c 'q'"
)
SIZE = {"width": 640, "height": 480}
# Pixels in the pane: 40 % along each bar.
ON_BARS = """[0, 1].map(bar => {
    const length = [0.09, 0.06][bar], body = find(`m0/moving/bars/${bar}`), pane = byId("pane");
    const place = body.localToWorld(viewer.camera.position.clone().set(0.4 * length, 0, 0)).project(viewer.camera);
    return [(1 + place.x) / 2 * pane.clientWidth, (1 - place.y) / 2 * pane.clientHeight];
})"""


@pytest.fixture(scope="module")
def browser():
    # SwiftShader is WebGL without a graphics card
    with chromium("--use-angle=swiftshader", "--enable-unsafe-swiftshader") as browser:
        yield browser


@pytest.fixture
def opened(browser, tmp_path):
    """Opens a scene, or the text of a page."""
    count = itertools.count()
    with offline(browser, faults=("error",)) as open_file:  # WebGL in software warns of being slow

        def open_page(scene, paused=True, **options):
            path = tmp_path / f"page{next(count)}.html"
            path.write_text(scene if isinstance(scene, str) else scene.html, encoding="utf-8")
            page = open_file(path, **{"viewport": SIZE, **options})
            if not isinstance(scene, str):
                until(page, "!!window.viewer && player.time > 0")
                if paused:
                    page.evaluate("player.pause()")
            return page

        yield open_page


@pytest.fixture(scope="module")
def run(crossing_run):
    return crossing_run


def picture(page):
    """(height, width, 3) of the page's pane, 0 to 1, after what is asked for has been drawn."""
    settle(page)
    png = page.locator("main").screenshot()
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), dtype=float) / 255


def differ(first, second):
    """Share of the pixels that differ."""
    return float((np.abs(first - second).max(axis=2) > 0.08).mean())


def seek(page, seconds):
    """As by dragging the slider."""
    page.locator("#time").evaluate(
        "(slider, seconds) => { slider.value = seconds; slider.dispatchEvent(new Event('input')); }",
        seconds,
    )


def bars(page, root="m0"):
    """(b, 3): where the bars in the scene begin, m, and their angles, rad."""
    return np.array(
        page.evaluate(f"""() => Object.values(viewer.scene_tree.find(["{root}", "moving", "bars"]).children)
        .map(bar => [bar.object.position.x, bar.object.position.y, bar.object.rotation.z])""")
    )


def ends(page, lengths, root="m0"):
    """(b, 2, 2): both ends of each bar in the scene, m."""
    found = bars(page, root)
    tips = found[:, :2] + np.array(lengths)[:, None] * np.stack(
        [np.cos(found[:, 2]), np.sin(found[:, 2])], axis=1
    )
    return np.stack([found[:, :2], tips], axis=1)


def visible(page, path):
    """Whether a node and all above it are shown."""
    return page.evaluate(f"""() => {{
        for (let object = find("{path}"); object; object = object.parent) if (!object.visible) return false;
        return true;
    }}""")


def two_bar(t):
    """Two bars in series: the first turns once a second, past +-180 degrees, the second half as fast the other way."""
    points = [np.broadcast_to((0.3, -0.2), (len(t), 2))]
    for length, angle in zip((0.09, 0.06), (2 * np.pi * t + 1, -np.pi * t + 2), strict=True):
        points.append(points[-1] + length * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    return np.stack(points, axis=1)


def two_bar_scene(t, title="Two bars"):
    t = np.asarray(t, dtype=float)
    frames = choose(t, two_bar(t))
    words = dict(bars=((0, 1), (1, 2)), grounded=(0,), actuated=(0, 1), traced=2)
    return view.Scene((Machine(frames, Skeleton(two_bar(t - t[0])[frames.index], **words)),), title)


# Seeing.


def test_machine_is_seen_and_moves(opened):
    page = opened(two_bar_scene(np.linspace(0, 2, 121)), paused=False)
    page.evaluate("player.pause(); player.seek(0.1)")
    first = picture(page)
    coloured = np.ptp(first, axis=2) > 0.3
    assert 0.005 < coloured.mean() < 0.5
    rows, columns = np.nonzero(coloured)
    height, width = coloured.shape
    assert (
        0 < rows.min()
        and rows.max() < height - 1
        and 0 < columns.min()
        and columns.max() < width - 1
    ), "not all seen"
    page.get_by_role("button", name="play", exact=True).click()
    until(page, "player.time > 0.4")
    page.get_by_role("button", name="pause", exact=True).click()
    stopped = page.evaluate("player.time")
    settle(page)
    assert page.evaluate("[player.time, player.playing]") == [stopped, False]
    page.evaluate("player.seek(0.6)")  # when it stopped was up to the clock
    second = picture(page)
    assert differ(first, second) > 0.005
    page.evaluate(
        "dispatchEvent(new Event('beforeprint'))"
    )  # what WebGL drew last is put where a printer finds it
    printed = page.evaluate(
        """(canvas => [...canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data]
            .filter((value, k, all) => k % 4 === 0 && Math.abs(value - all[k + 2]) > 76).length)
        (document.querySelector("#pane canvas"))"""
    )
    seen = (
        np.abs(second[..., 0] - second[..., 2]) > 76 / 255
    ).sum()  # few where one bar covers the other
    assert seen > 500 and abs(printed - seen) < 0.05 * seen
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert np.array_equal(picture(page), second)


@pytest.mark.deep
def test_the_robot_looks_as_it_did(opened, run):
    """Against a kept picture, a quarter as wide: bars, motors, base and what is shown are where they were."""
    page = opened(view.scene(ROBOT, run, ["loci", "trace", "velocity", "torques"]))
    seek(page, 1.5)
    kept = np.asarray(Image.open(DATA / "viewer.png").convert("RGB"), dtype=float) / 255
    shape = kept.shape[1::-1]
    now = Image.fromarray((255 * picture(page)).astype(np.uint8)).resize(
        shape, Image.Resampling.BOX
    )
    difference = np.abs(np.asarray(now, dtype=float) / 255 - kept)
    assert difference.mean() < 0.01 and difference.max() < 0.5


@pytest.mark.deep
@pytest.mark.parametrize(("width", "height", "scheme"), [(390, 844, "dark")])
def test_page_fits_phones_and_dark_rooms(opened, run, width, height, scheme):
    scene = view.scene(
        ROBOT, run, view.SHOWS, title="a title that takes more than one line on a phone"
    )
    page = opened(scene, viewport={"width": width, "height": height}, color_scheme=scheme)
    assert page.evaluate(
        "[document.body.scrollWidth <= innerWidth, document.body.scrollHeight <= innerHeight]"
    ) == [1, 1]
    for role, name in [
        ("button", "play"),
        ("slider", "time"),
        ("combobox", "speed"),
        ("button", "fit the view (F)"),
    ]:
        box = page.get_by_role(role, name=name, exact=True).bounding_box()
        assert (
            box["x"] >= 0
            and box["x"] + box["width"] <= width
            and box["y"] + box["height"] <= height
        )
    assert page.locator("#key").is_visible() == (width > 560), (
        "its many lines are folded on a phone"
    )
    shown = picture(page)
    assert (shown[-1, :5].max() < 0.2) if scheme == "dark" else (shown[-1, :5].min() > 0.9)
    assert shown.shape[0] > height / 2 and (np.ptp(shown, axis=2) > 0.3).mean() > 0.003


# Moving.


@pytest.mark.deep
@pytest.mark.parametrize("start", [7.0])
def test_motion_plays_in_real_time_and_over_again(opened, start):
    page = opened(two_bar_scene(np.linspace(0, 2, 301) + start))
    assert page.evaluate("[content.duration, content.start]") == pytest.approx([2, start])
    assert page.get_by_role("slider").get_attribute("max") == "2"

    def after(milliseconds, time, loop="true"):
        """The player's time so long after a time, by the browser's clock as the page is told it."""
        return page.evaluate(f"""() => {{
            player.loop = {loop}; player.seek({time}); player.play(); player.last = 1000;
            for (let now = 1000 + 20; now <= 1000 + {milliseconds}; now += 20) player.frame(now);
            const found = [player.time, player.playing, find('m0/moving/bars/0').rotation.z];
            player.pause();
            return found;
        }}""")

    time, playing, angle = after(300, 0.2)
    assert time == pytest.approx(0.5) and playing and angle == pytest.approx(np.pi + 1, abs=1e-6)
    assert page.locator("#clock").text_content() == f"{start + 0.5:.2f} s"
    page.get_by_label("speed").select_option("4")
    assert after(300, 0.2)[0] == pytest.approx(1.4)
    assert after(300, 1.2)[:2] == pytest.approx([0.4, True])
    assert after(300, 1.2, "false")[:2] == [2, False]
    assert after(100, 2, "false")[:2] == pytest.approx([0.4, True]), (
        "at the end it plays from the start"
    )


@pytest.mark.deep
def test_player_plays_without_help(opened):
    page = opened(two_bar_scene(np.linspace(0, 2, 121)), paused=False)
    page.evaluate(
        "player.seek(1.9)"
    )  # however slow a picture is, it goes on by half a second at most
    until(page, "player.time < 1 && player.playing")
    page.get_by_role("button", name="over and over").click()
    page.evaluate("player.seek(1.9)")
    until(page, "!player.playing && player.time == 2")
    page.get_by_label("speed").select_option("0.1")
    page.get_by_role("button", name="play", exact=True).click()
    until(page, "player.playing && player.time > 0 && player.time < 1.9")


@pytest.mark.deep
def test_bars_are_where_the_model_says(opened, run):
    page = opened(view.scene(ROBOT, run))
    frames = view.scene(ROBOT, run).machines[0].frames
    for k in (0, 17, 60, 119, 121, 180, -1):
        seek(page, float(frames.t[k]))
        q = run.q[frames.index[k]]
        pose = fb.dgm(ROBOT, q, assembly=-1 if frames.t[k] < run.events[0].t else 1)
        bases = np.array([(-0.059, 0.0), (0.059, 0.0)])
        expected = np.stack(
            [
                np.stack([bases, pose.elbows], axis=1),
                np.stack([pose.elbows, [pose.xi] * 2], axis=1),
            ],
            1,
        )
        np.testing.assert_allclose(ends(page, [0.09] * 4), expected.reshape(4, 2, 2), atol=2e-7)


@pytest.mark.deep
@pytest.mark.parametrize("samples", [121])
def test_bars_are_between_their_samples(opened, samples):
    page = opened(two_bar_scene(np.linspace(0, 2, samples)))
    for seconds in (0, 0.3, 0.841, 1.333, 2):
        expected = two_bar(np.array([seconds]))[0][[(0, 1), (1, 2)]]
        seek(page, seconds)
        np.testing.assert_allclose(
            ends(page, (0.09, 0.06)), expected, atol=2e-4 if seconds % 0.1 else 2e-7
        )


@pytest.mark.deep
def test_bars_do_not_turn_back_at_180_degrees(opened):
    # one bar, from 170 to 190 degrees between two samples: halfway at 180 degrees and not at 0
    angle = np.radians([170, 190])
    points = np.stack(
        [np.zeros((2, 2)), 0.1 * np.stack([np.cos(angle), np.sin(angle)], axis=1)], axis=1
    )
    page = opened(view.Scene((Machine(choose([0, 1], points), Skeleton(points, ((0, 1),))),), ""))
    seek(page, 0.5)
    assert abs(bars(page)[0, 2]) == pytest.approx(np.pi, abs=1e-6)


@pytest.mark.deep
def test_nothing_moves_or_is_joined(opened):
    points = np.zeros((2, 1, 2))
    opened(
        view.Scene((Machine(choose([0, 1], points), Skeleton(points, (), traced=0)),), "A point")
    )


@pytest.mark.deep
def test_a_gap_shows_no_bars_and_says_so(opened):
    t = np.linspace(0, 2, 201)
    q = 0.2 * np.stack([np.sin(t), np.cos(t)], axis=1)
    xi = fb.dgm(ROBOT, q).xi
    q[80:120] = np.nan
    zero = np.zeros_like(q)
    page = opened(view.scene(ROBOT, fb.Run(ROBOT, t, q, zero, xi, zero, t)))
    for seconds, shown in [
        (0.79, True),
        (0.8, False),
        (1.19, False),
        (1.2, True),
        (2, True),
        (1, False),
        (0, True),
    ]:
        seek(page, seconds)
        assert visible(page, "m0/moving/bars/0") == shown, seconds
        assert visible(page, "m0/still/base")
    assert "40 of 201 samples are not numbers" in page.locator("#notes").text_content()
    assert page.locator("#marks div").count() == 1


# What is shown.


@pytest.mark.deep
def test_each_item_appears_and_can_be_hidden(opened, run):
    ghostly = replace(run, xi_ref=run.xi_ref + (0.02, 0.01))
    page = opened(view.scene(ROBOT, ghostly, view.SHOWS), viewport={"width": 640, "height": 560})
    seek(page, 2.6)
    everything = picture(page)
    for item in view.SHOWS:
        words = {
            "elbow-circles": "circles of the elbows",
            "bar-forces": "forces of the distal bars",
            "trace": "path",
        }.get(item, item)
        button = page.get_by_role("button", name=words).first
        assert button.get_attribute("aria-pressed") == "true"
        button.click()
        assert button.get_attribute("aria-pressed") == "false"
        assert differ(picture(page), everything) > 1e-4, item
        button.click()
        assert differ(picture(page), everything) == 0, item
    tip = page.evaluate("""() => {
        const arrow = Object.values(viewer.scene_tree.find(["m0", "moving", "velocity"]).children)[0].object;
        return [arrow.position.x, arrow.position.y, arrow.rotation.z]; }""")
    k = round(2.6 / run.t[1])
    along = run.xi[k + 1] - run.xi[k - 1]
    assert tip == pytest.approx([*run.xi[k], np.arctan2(along[1], along[0])], abs=1e-3)
    drawn = page.evaluate(
        "content.bands.map(path => find(path + '/band/<object>').geometry.drawRange.count / 6 / content.pieces)"
    )
    sweeps = np.abs(run.tau[k]) / np.abs(run.tau).max() * np.radians(300)
    np.testing.assert_allclose(drawn, sweeps, atol=np.radians(2.6))


@pytest.mark.deep
def test_what_is_not_named_is_not_there(opened, run):
    page = opened(view.scene(ROBOT, run, "velocity"))
    assert page.locator("#key button").all_text_contents()[0].startswith("v: velocity (longest")
    assert page.locator("#key button").count() == 1
    assert page.evaluate("Object.keys(viewer.scene_tree.find(['m0', 'still']).children)") == [
        "base"
    ]


@pytest.mark.deep
def test_singularities_flash_and_are_marked(opened, run):
    page = opened(view.scene(ROBOT, run))
    (event,) = run.events
    mark = page.get_by_role("button", name="go to: Type 2 singularity (det A = 0)")
    line, box = page.locator("#time").bounding_box(), mark.bounding_box()
    share = (box["x"] + box["width"] / 2 - line["x"] - 8) / (line["width"] - 16)
    assert share == pytest.approx(event.t / run.t[-1], abs=0.01)
    banner = page.get_by_role("status").and_(page.locator("#banner"))
    for seconds, flashes in [
        (event.t - 1, False),
        (event.t - 0.1, True),
        (event.t + 0.1, True),
        (event.t + 1, False),
    ]:
        seek(page, seconds)
        assert visible(page, "m0/flash") == banner.is_visible() == flashes
    mark.click()
    assert page.evaluate("player.time") == pytest.approx(event.t)
    assert banner.text_content() == "Type 2 singularity (det A = 0) at 2 s"
    place = page.evaluate("find('m0/flash').position.toArray()")
    assert place[:2] == pytest.approx(
        np.array([np.interp(event.t, run.t, x) for x in run.xi.T]), abs=1e-5
    )


@pytest.mark.deep
def test_two_runs_side_by_side(opened, run):
    short = fb.simulate(
        ROBOT, fb.PD(ROBOT, 1.0, 0.1), fb.line((0.09, 0.06796322535018479), (0.0, 0.1), 0.5)
    )
    page = opened(view.scene(ROBOT, run, second=short, names=["left <b>", "right"]))
    assert page.evaluate("content.duration") == pytest.approx(4)
    for seconds in (0.25, 0.5, 3.0):  # the shorter one stays where it ends
        seek(page, seconds)
        for root, motion in (("m0", run), ("m1", short)):
            k = min(round(seconds / motion.t[1]), len(motion.t) - 1)
            np.testing.assert_allclose(ends(page, [0.09] * 4, root)[1, 1], motion.xi[k], atol=3e-5)
    labels = page.locator("#labels span")
    assert labels.all_text_contents() == ["left <b>", "right"]
    settle(page)
    first, second = (labels.nth(k).bounding_box() for k in (0, 1))
    assert first["x"] + first["width"] < second["x"] and first["y"] == pytest.approx(
        second["y"], abs=1
    )
    coloured = np.ptp(picture(page), axis=2) > 0.3
    assert coloured[:, :300].any() and coloured[:, 340:].any()


@pytest.mark.deep
@pytest.mark.parametrize("held", ["guide", "rod"])
def test_sliders_slide(opened, held):
    study = linkages.study(linkages.SliderCrank(0.1, 0.3, held=held))
    page = opened(view.scene(study.linkage, study, ["trace", "velocity", "acceleration"]))
    for k in (0, 40, 111):
        t = float(study.t[view.scene(study.linkage, study).machines[0].frames.index[k % 60]])
        seek(page, t)
        found = page.evaluate("find('m0/moving/blocks/0').position.toArray()")
        at = int(np.argmin(np.abs(study.t - t)))
        np.testing.assert_allclose(found[:2], study.motion.position("B")[at], atol=1e-7)


# Using.


@pytest.mark.deep
def test_everything_goes_by_keyboard(opened):
    page = opened(two_bar_scene(np.linspace(0, 2, 121)))
    page.evaluate("player.seek(1)")
    press, at = page.keyboard.press, lambda: page.evaluate("player.time")
    press("ArrowRight")
    assert at() == pytest.approx(1 + 1 / 60)
    press("ArrowLeft")
    assert at() == pytest.approx(1)
    press("Shift+ArrowLeft")
    assert at() == 0
    press("End")
    assert at() == 2
    press("Home")
    assert at() == 0 and not page.evaluate("player.playing")
    for _ in range(2):  # the second time with the button in focus, which takes the space bar too
        press(" ")
        until(page, "player.playing && player.time > 0.05")
        press("k")
        assert not page.evaluate("player.playing")
        page.get_by_role("button", name="play", exact=True).focus()
        page.evaluate("player.seek(0)")
    press("l")
    assert page.get_by_role("button", name="over and over").get_attribute("aria-pressed") == "false"
    for key, speed in [("+", 2), ("+", 4), ("+", 4), ("-", 2), ("-", 1), ("-", 0.5)]:
        press(key)
        assert page.evaluate("[player.speed, +byId('speed').value]") == [speed, speed]
    page.locator("#time").focus()
    press("ArrowRight")
    assert at() == pytest.approx(1 / 60)
    for next_one in ("moment", "speed"):
        press("Tab")
        assert page.evaluate("document.activeElement.id") == next_one


@pytest.mark.deep
def test_view_turns_and_fits_again(opened):
    page = opened(two_bar_scene(np.linspace(0, 2, 121)))
    page.evaluate("player.seek(0.3)")
    first = picture(page)
    page.mouse.move(320, 240)
    page.mouse.down()
    page.mouse.move(400, 120, steps=4)
    page.mouse.up()
    away = page.evaluate("viewer.camera.position.length()")
    page.mouse.wheel(0, 300)
    until(page, f"viewer.camera.position.length() > {1.01 * away}")
    assert differ(picture(page), first) > 0.01
    page.keyboard.press("f")
    assert differ(picture(page), first) < 1e-3


@pytest.mark.deep
def test_roles_and_labels_say_what_is_there(opened, run):
    page = opened(view.scene(ROBOT, run, title="a run"))
    assert page.get_by_role("img", name="Animation: a run").count() == 1
    seek(page, 1.234)
    assert page.get_by_role("slider", name="time").get_attribute("aria-valuetext") == "1.23 s"
    assert page.evaluate("document.documentElement.lang") == "en"
    unnamed = page.evaluate(
        "[...document.querySelectorAll('button')].filter(b => !(b.ariaLabel || b.textContent.trim())).length"
    )
    assert unnamed == 0
    assert page.locator(".dg.main").is_visible() is False


@pytest.mark.deep
def test_who_wants_little_motion_is_not_played_to(opened):
    scene = two_bar_scene(np.linspace(0, 2, 121))
    page = opened(scene.html, reduced_motion="reduce")
    until(page, "!!window.viewer")
    settle(page)
    assert page.evaluate("[player.playing, player.time]") == [False, 0]


@pytest.mark.deep
def test_texts_are_only_texts(opened, run):
    page = opened(view.scene(ROBOT, run, title=HOSTILE, second=run, names=[HOSTILE, "b"]))
    assert page.title() == HOSTILE and page.locator("h1").text_content() == HOSTILE
    assert page.locator("#labels span").first.text_content() == HOSTILE
    assert page.locator("img").count() == 0 and page.evaluate("window.hacked") is None


@pytest.mark.deep
def test_frame_in_a_notebook_plays(opened, run):
    page = opened(
        f"<!DOCTYPE html><body>{view.scene(ROBOT, run, title='in a frame')._repr_html_()}</body>"
    )
    box = page.locator("img").bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    assert (
        page.evaluate("([x, y]) => document.elementFromPoint(x, y).tagName", middle) == "IFRAME"
    ), "not covered"
    frame = page.frames[1]
    until(frame, "!!window.viewer && player.time > 0.02")
    assert frame.title() == "in a frame"
    assert page.locator("iframe").bounding_box()["height"] == 480


@pytest.fixture
def lacking(browser, tmp_path):
    """Opens two bars in a browser that lacks something, by a script that takes it away."""
    context = browser.new_context(viewport=SIZE)

    def open_page(script):
        path = tmp_path / "page.html"
        path.write_text(two_bar_scene(np.linspace(0, 2, 61)).html, encoding="utf-8")
        page = context.new_page()
        page.add_init_script(script)
        page.goto(path.as_uri())
        return page

    yield open_page
    context.close()


def test_a_browser_too_old_is_told(lacking):
    page = lacking("delete window.DecompressionStream")
    until(page, "byId('banner').textContent != ''")
    assert (
        page.locator("#banner")
        .text_content()
        .startswith("This page needs a browser with DecompressionStream")
    )
    assert page.locator("#banner").is_visible() and not page.locator("#controls").is_visible()


@pytest.mark.deep
def test_without_webgl_the_same_is_drawn_flat(lacking):
    page = lacking(
        """(prototype => { const own = prototype.getContext; prototype.getContext = function (kind, ...more) {
            return /webgl/.test(kind) ? null : own.call(this, kind, ...more); }; })(HTMLCanvasElement.prototype)"""
    )
    until(page, "!!window.viewer && player.time > 0")
    page.evaluate("player.pause()")
    assert page.locator("#notes").text_content().startswith("This browser has no WebGL")
    for seconds in (0.3, 1.7):
        seek(page, seconds)
        seen, where = picture(page), page.evaluate(ON_BARS)
        for (x, y), colour in zip(
            where, ("#005d92", "#a23731"), strict=True
        ):  # of the bars' grooves
            expected = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
            np.testing.assert_allclose(seen[round(y), round(x)], expected, atol=0.02)


def test_title_is_escaped_in_the_file():
    text = two_bar_scene([0, 1, 2], HOSTILE).html
    assert text.count(html.escape(HOSTILE)) == 3 and HOSTILE not in text
