"""What the tests in a real browser share: Chromium without a network, and an account of what a page asked for."""

import time
from contextlib import contextmanager

from . import needs


@contextmanager
def chromium(*options):
    """A headless Chromium."""
    from playwright.sync_api import sync_playwright

    needs.need("chromium")
    with sync_playwright() as playwright:
        # root, as in a container, has no sandbox
        browser = playwright.chromium.launch(
            executable_path=needs.browser(), args=["--no-sandbox", *options]
        )
        yield browser
        browser.close()


@contextmanager
def offline(browser, faults=("error", "warning")):
    """(path, **options of the context) -> a page; at the end nothing but the files was asked for and no fault came."""
    contexts, requests, errors, files = [], [], [], []

    def note(message):
        if message.type in faults:
            errors.append(message.text)

    def open_file(path, **options):
        context = browser.new_context(**options)
        context.set_offline(True)
        contexts.append(context)
        files.append(path.as_uri())
        page = context.new_page()
        page.on("request", lambda request: requests.append(request.url))
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on(
            "console",
            lambda message: (
                errors.append(message.text) if message.type in ("error", "warning") else None
            ),
        )
        page.goto(path.as_uri())
        return page

    yield open_file
    for context in contexts:
        context.close()
    assert [url for url in requests if not url.startswith(("data:", "blob:", "about:"))] == files
    assert errors == []


PATIENCE = 60  # s: no measure of speed, but an end where the awaited never comes


def until(page, condition):
    # Playwright's own wait_for_function calls eval, which the pages' policy forbids.
    end = time.monotonic() + PATIENCE
    while not page.evaluate(condition):
        assert time.monotonic() < end, f"never {condition}"
        page.wait_for_timeout(10)


DRAWN = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))"


def settle(page):
    """Wait for what the last event has asked to be drawn."""
    page.evaluate(DRAWN)


def visit(page, address):
    """Give a page another hash, and wait for what it does with it."""
    page.evaluate(
        """hash => new Promise(done => {
            const before = location.hash;
            location.hash = hash;
            if (location.hash === before) done(); else addEventListener("hashchange", () => done(), {once: true});
        })""",
        address,
    )
    settle(page)
