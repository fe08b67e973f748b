"""The page of an animation, as a browser without a network sees it, and what `write_animation` refuses."""

import html
import io
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from fivebar import view

ORIGIN, LENGTHS = np.array([0.3, -0.2]), (0.09, 0.06)
BARS = [(0, 1), (1, 2)]
HOSTILE = (
    '</title><script>window.hacked = 1</script><img src="http://example.com/x.png" onerror="hacked = 1"> $half & é'
)


def two_bar(t):
    """Two bars in series: the first turns once a second, past +-180 degrees, the second half as fast the other way."""
    points = [np.broadcast_to(ORIGIN, (len(t), 2))]
    for length, angle in zip(LENGTHS, (2 * np.pi * t + 1, -np.pi * t + 2), strict=True):
        points.append(points[-1] + length * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    return np.stack(points, axis=1)


def write(path, t, **changes):
    points = two_bar(t)
    arguments = {
        "points": points,
        "bars": BARS,
        "title": "Two bars",
        "grounded": (0,),
        "actuated": (0, 1),
        "traced": 2,
        "reference": points[:, 2] + 0.005,
    }
    view.write_animation(path, t, **arguments | changes)
    return path


@pytest.fixture(scope="module")
def browser():
    give_up = pytest.fail if os.environ.get("CI") == "true" else pytest.skip
    names = ("chromium", "chromium-browser", "google-chrome")
    program = next(filter(None, map(shutil.which, names)), None)
    if program is None:
        give_up(f"no browser: none of {', '.join(names)} is installed")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError as error:
        give_up(f"no playwright: {error}")
    with sync_playwright() as playwright:
        # Root, as in a container, has no sandbox; SwiftShader is WebGL without a graphics card.
        browser = playwright.chromium.launch(
            executable_path=program, args=["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        )
        yield browser
        browser.close()


@pytest.fixture
def opened(browser):
    """Opens a file without a network; at the end nothing but the file was asked for and nothing went wrong."""
    context = browser.new_context(viewport={"width": 640, "height": 480})
    requests, errors, files = [], [], []

    def open_page(path):
        files.append(path.as_uri())
        page = context.new_page()
        page.on("request", lambda request: requests.append(request.url))
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
        page.goto(path.as_uri())
        until(page, "viewer.animator.mixer.time > 0.1")
        return page

    context.set_offline(True)
    yield open_page
    context.close()
    assert [url for url in requests if not url.startswith(("data:", "blob:"))] == files
    assert errors == []


def until(page, condition):
    # Playwright's own wait_for_function calls eval, which the page's policy forbids.
    end = time.monotonic() + 20
    while not page.evaluate(condition):
        assert time.monotonic() < end, f"never {condition}"
        page.wait_for_timeout(20)


def picture(page):
    """(height, width, 3) of the page between title and controls, 0 to 1."""
    from matplotlib.image import imread

    return imread(io.BytesIO(page.screenshot(clip={"x": 0, "y": 70, "width": 640, "height": 360})))[..., :3]


def bars_at(page, seconds):
    """(b, 2, 2): the ends of the bars in the scene, stopped at a time."""
    page.evaluate("viewer.animator.pause()")
    page.get_by_role("slider").evaluate(
        "(slider, seconds) => { slider.value = seconds; slider.dispatchEvent(new Event('input')); }", seconds
    )
    places = page.evaluate("""() => Object.values(viewer.scene_tree.find(["mechanism", "bars"]).children)
        .map(bar => [bar.object.position.x, bar.object.position.y, bar.object.rotation.z])""")
    return np.array(
        [
            [(x, y), (x + length * np.cos(angle), y + length * np.sin(angle))]
            for (x, y, angle), length in zip(places, LENGTHS, strict=True)
        ]
    )


def test_machine_is_seen_and_moves(opened, tmp_path):
    page = opened(write(tmp_path / "page.html", np.linspace(0, 2, 121)))
    first = picture(page)
    coloured = np.ptp(first, axis=2) > 0.3
    assert 0.005 < coloured.mean() < 0.5
    rows, columns = np.nonzero(coloured)
    assert rows.min() > 0 and rows.max() < 359 and columns.min() > 0 and columns.max() < 639, "not all is in view"

    page.wait_for_timeout(200)
    second = picture(page)
    assert (np.abs(second - first).max(axis=2) > 0.1).mean() > 0.005

    page.get_by_role("button", name="pause").click()
    page.wait_for_timeout(200)
    third = picture(page)
    page.wait_for_timeout(200)
    assert np.array_equal(picture(page), third)


@pytest.mark.parametrize("start", [0.0, 7.0])
def test_motion_plays_in_real_time_and_over_again(opened, tmp_path, start):
    t = np.linspace(0, 2, 301)
    page = opened(write(tmp_path / "page.html", t + start, points=two_bar(t)))
    assert page.evaluate("viewer.animator.duration") == pytest.approx(2)
    assert page.get_by_role("slider").get_attribute("max") == "2"

    clocks = "viewer.animator.update(), [performance.now() / 1000, viewer.animator.mixer.time]"
    before = np.array(page.evaluate(clocks))
    page.wait_for_timeout(500)
    real, played = np.array(page.evaluate(clocks)) - before
    assert played == pytest.approx(real, abs=0.02)

    page.get_by_label("speed").select_option("4")
    until(page, "viewer.animator.mixer.time > 2.5")
    assert page.evaluate("viewer.animator.playing && viewer.animator.time < 2")


@pytest.mark.parametrize("samples", [121, 2001])
def test_bars_are_where_the_points_are(opened, tmp_path, samples):
    page = opened(write(tmp_path / "page.html", np.linspace(0, 2, samples)))
    for seconds, tolerance in [(0, 1e-7), (0.3, 1e-7), (0.35, 1e-7), (0.841, 2e-4), (1.333, 2e-4), (2, 1e-7)]:
        expected = two_bar(np.array([seconds]))[0][BARS]
        np.testing.assert_allclose(bars_at(page, seconds), expected, atol=tolerance)


def test_bars_do_not_turn_back_at_180_degrees(opened, tmp_path):
    # one bar, from 170 to 190 degrees between two samples: halfway at 180 degrees and not at 0
    angle = np.radians([170, 190])
    points = np.stack([np.zeros((2, 2)), 0.1 * np.stack([np.cos(angle), np.sin(angle)], axis=1)], axis=1)
    path = tmp_path / "page.html"
    view.write_animation(path, [0, 1], points, [(0, 1)], title="")
    page = opened(path)
    page.evaluate("viewer.animator.pause(); viewer.animator.seek(0.5)")
    half = page.evaluate("viewer.scene_tree.find(['mechanism', 'bars', '0']).object.rotation.z")
    assert abs(half) == pytest.approx(np.pi, abs=1e-6)


def test_nothing_moves_or_is_joined(opened, tmp_path):
    path = tmp_path / "page.html"
    view.write_animation(path, [0, 1], np.zeros((2, 1, 2)), [], title="A point", traced=0, reference=[[0, 0]])
    assert opened(path).evaluate("viewer.animator.playing")


def test_title_is_text_only(opened, tmp_path):
    page = opened(write(tmp_path / "page.html", np.linspace(0, 2, 121), title=HOSTILE))
    assert page.title() == HOSTILE
    assert page.locator("h1").text_content() == HOSTILE
    assert page.locator("img").count() == 0
    assert page.evaluate("window.hacked") is None


def test_title_is_escaped_in_the_file(tmp_path):
    text = write(tmp_path / "page.html", np.linspace(0, 2, 121), title=HOSTILE).read_text("utf-8")
    assert text.count(html.escape(HOSTILE)) == 2 and HOSTILE not in text


def test_ten_seconds_are_small_and_quick(tmp_path):
    t = np.linspace(0, 10, 601)
    points = np.concatenate([two_bar(t), two_bar(t) + 0.1], axis=1)
    bars = [(0, 1), (1, 2), (3, 4), (4, 5)]
    start = time.perf_counter()
    path = write(tmp_path / "page.html", t, points=points, bars=bars, grounded=(0, 3))
    assert time.perf_counter() - start < 0.5
    assert path.stat().st_size < 2_000_000
    # samples that are not shown are not in the file
    t = np.linspace(0, 10, 10_001)
    assert write(tmp_path / "dense.html", t).stat().st_size < 1.1 * path.stat().st_size


def test_no_server_is_started_or_loaded(tmp_path):
    script = f"""
import socket, sys, threading
def refuse(*arguments): raise AssertionError("a server was started")
socket.socket.bind = socket.socket.listen = refuse
from fivebar import view
assert not {{"meshcat", "umsgpack"}} & sys.modules.keys(), "loaded before it is needed"
view.write_animation({str(tmp_path / "page.html")!r}, [0, 1], [[[0, 0], [1, 0]], [[0, 0], [0, 1]]], [(0, 1)], title="")
assert not {{"meshcat", "zmq", "tornado"}} & sys.modules.keys()
assert threading.active_count() == 1
"""
    subprocess.run([sys.executable, "-W", "error", "-c", script], check=True, cwd=Path(view.__file__).parents[1])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"t": [0.0]}, r"t has 1 samples and points 4"),
        ({"t": [0.0], "points": np.zeros((1, 3, 2))}, r"at least 2 samples, not 1"),
        ({"t": [0, 1, np.nan, 3]}, r"t\[2\] is nan, not finite"),
        ({"t": [0, 1, 1, 3]}, r"t\[2\] = 1.0 is not after t\[1\] = 1.0"),
        ({"t": [[0, 1, 2, 3]]}, r"t has shape \(1, 4\), not \(n\)"),
        ({"points": np.zeros((4, 3, 3))}, r"points has shape \(4, 3, 3\), not \(n, k, 2\)"),
        (
            {"points": np.where(np.arange(24).reshape(4, 3, 2) == 9, np.inf, 0.0)},
            r"points\[1, 1, 1\] is inf, not finite",
        ),
        ({"reference": [[0, 0], [0, np.nan]]}, r"reference\[1, 1\] is nan, not finite"),
        ({"reference": [0, 1]}, r"reference has shape \(2,\), not \(m, 2\)"),
        ({"bars": [(0, 1), (1, 3)]}, r"bars\[1\] names joint 3, but points has joints 0 to 2"),
        ({"grounded": (-1,)}, r"grounded names joint -1"),
        ({"actuated": (5,)}, r"actuated names joint 5"),
        ({"traced": 3}, r"traced names joint 3"),
    ],
)
def test_what_cannot_be_drawn_is_refused(tmp_path, changes, message):
    arguments = {"t": np.arange(4.0), "points": np.zeros((4, 3, 2)), "bars": BARS, "title": ""} | changes
    with pytest.raises(ValueError, match=message):
        view.write_animation(tmp_path / "page.html", **arguments)
    assert not (tmp_path / "page.html").exists()


def test_a_place_that_cannot_be_written_to_is_told(tmp_path):
    with pytest.raises(FileNotFoundError, match="nowhere"):
        write(tmp_path / "nowhere" / "page.html", np.linspace(0, 2, 121))


def test_missing_viewer_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(view, "find_spec", lambda name: None)
    with pytest.raises(ImportError, match="pip install meshcat"):
        write(tmp_path / "page.html", np.linspace(0, 2, 121))
