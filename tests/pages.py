"""What the tests of linked pages share: a browser without a network, pages opened in it, and what is read from them."""

import re
import shutil
import time

import numpy as np
import pytest


@pytest.fixture(scope="module")
def browser():
    names = ("chromium", "chromium-browser", "google-chrome")
    program = next(filter(None, map(shutil.which, names)), None)
    if program is None:
        pytest.fail(f"no browser: none of {', '.join(names)} is installed")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        # root, as in a container, has no sandbox
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox", "--disable-gpu"])
        yield browser
        browser.close()


@pytest.fixture
def opened(browser):
    """Opens a file without a network; at the end nothing but the file was asked for and nothing went wrong."""
    contexts, requests, errors, files = [], [], [], []

    def open_page(path, width=1280, height=900, **options):
        context = browser.new_context(viewport={"width": width, "height": height}, **options)
        context.set_offline(True)
        contexts.append(context)
        files.append(path.as_uri())
        page = context.new_page()
        page.on("request", lambda request: requests.append(request.url))
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("console", lambda message: errors.append(message.text) if message.type != "info" else None)
        page.goto(path.as_uri())
        until(page, "document.body.dataset.ready")
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert [url for url in requests if not url.startswith(("data:", "blob:"))] == files
    assert errors == []


def until(page, condition):
    # Playwright's own wait_for_function calls eval, which the page's policy forbids.
    end = time.monotonic() + 20
    while not page.evaluate(condition):
        assert time.monotonic() < end, f"never {condition}"
        page.wait_for_timeout(10)


def settle(page):
    """Wait for what the last event has asked to be drawn."""
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def bars(page, number=-1):
    """(b, 2, 2): the ends of a mechanism's bars as drawn, m; the last mechanism unless a number is given."""
    ends = page.evaluate(
        """number => [...[...document.querySelectorAll(".mechanism")].at(number).querySelectorAll(".bar")]
            .map(bar => ["x1", "y1", "x2", "y2"].map(name => +bar.getAttribute(name)))""",
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
        linear = [x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in np.divide(rgb, 255)]
        light.append(np.dot([0.2126, 0.7152, 0.0722], linear) + 0.05)
    return max(light) / min(light)
