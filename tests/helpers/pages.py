"""What the tests of linked pages share: pages opened in a browser, and what is read from them."""

import re

import numpy as np
import pytest

import fivebar as fb

from .browsing import chromium, offline, settle, until
from .playing import STILL


@pytest.fixture(scope="module")
def browser():
    with chromium("--disable-gpu") as browser:
        yield browser


@pytest.fixture
def opened(browser):
    """Opens a linked page's file."""
    with offline(browser) as open_file:

        def open_page(path, width=1280, height=900, **options):
            page = open_file(path, viewport={"width": width, "height": height}, **options)
            until(page, "document.body.dataset.ready")
            return page

        yield open_page


@pytest.fixture(scope="module")
def computing(browser, tmp_path_factory):
    """A live page that is asked for what its functions compute and nothing else: opened once for all such tests."""
    path = tmp_path_factory.mktemp("play") / "play.html"
    fb.play().save(path)
    with offline(browser) as open_file:
        page = open_file(path, viewport={"width": 1280, "height": 900}, **STILL)
        until(page, "document.body.dataset.ready")
        yield page


def bars(page, number=-1):
    """(b, 2, 2): the ends of a mechanism's bars as drawn, m; the last mechanism unless a number is given."""
    ends = page.evaluate(
        """number => [...[...document.querySelectorAll(".mechanism")].at(number).querySelectorAll(".bar")]
            .map(bar => ["x1", "y1", "x2", "y2"].map(name => +bar.getAttribute(name)))
            .flatMap(([x1, y1, x2, y2]) => [[x1, y1], [x2, y2]])
            .map(([x, y]) => [(x - scene.origin[0]) / scene.scale, (scene.origin[1] - y) / scene.scale])""",
        number,
    )
    return np.array(ends).reshape(-1, 2, 2)


def seen(page, number=-1):
    """Whether a mechanism is visible."""
    return page.evaluate(
        "number => [...document.querySelectorAll('.mechanism')].at(number).getAttribute('visibility') === 'visible'",
        number,
    )


def hover(page, plot, across, up=0.5, drag=False):
    """Point into a plot's frame, at those shares of it from its left and bottom."""
    glass = page.locator(".glass").nth(plot)
    glass.scroll_into_view_if_needed()
    box = glass.bounding_box()
    place = box["x"] + across * box["width"], box["y"] + (1 - up) * box["height"]
    if drag:
        page.mouse.move(box["x"] + 0.5 * box["width"], place[1])
        page.mouse.down()
    page.mouse.move(*place, steps=3 if drag else 1)
    if drag:
        page.mouse.up()
    settle(page)


def download(page, name):
    """The file that a button gives: (its name, its content)."""
    with page.expect_download() as waiting:
        page.get_by_role("button", name=name).click()
    got = waiting.value
    with open(got.path(), "rb") as file:
        return got.suggested_filename, file.read()


def chain(pose):
    """The bars of a robot's picture, (b, 2, 2) m, from its pose."""
    left, right = pose.elbows
    if not pose.robot.turns:
        return np.array([[left, pose.xi], [right, pose.xi]])
    base1, base2 = ((drive.x, drive.y) for drive in pose.robot.drives)
    return np.array([[base1, left], [left, pose.xi], [base2, right], [right, pose.xi]])


def contrast(first, second):
    """WCAG contrast of two colours as a browser gives them."""
    light = []
    for colour in (first, second):
        if colour.startswith("#"):
            rgb = [int(colour[k : k + 2], 16) for k in (1, 3, 5)]
        else:
            rgb = [float(x) for x in re.findall(r"[\d.]+", colour)[:3]]
        linear = [
            x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in np.divide(rgb, 255)
        ]
        light.append(np.dot([0.2126, 0.7152, 0.0722], linear) + 0.05)
    return max(light) / min(light)
