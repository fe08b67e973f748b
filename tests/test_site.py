"""The site that README's last command builds: complete, without a broken link, whole on a telephone."""

import re
import subprocess
import sys
from html.parser import HTMLParser
from urllib.parse import unquote, urlsplit

import pytest

import fivebar as fb
from tests.helpers import ROOT
from tests.helpers.browsing import chromium
from tests.helpers.needs import need

pytestmark = pytest.mark.deep
ATTRIBUTES = {"a": "href", "link": "href", "img": "src", "script": "src", "iframe": "src"}


class Names(HTMLParser):
    """A page's anchors, and what it links to and loads."""

    def __init__(self, path):
        super().__init__()
        self.anchors, self.links = set(), []
        self.feed(path.read_text("utf-8"))

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.anchors |= {given[key] for key in ("id", "name") if given.get(key)}
        if link := given.get(ATTRIBUTES.get(tag, "")):
            self.links.append((tag, urlsplit(link)))


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The folder of the site, built with warnings as errors."""
    need("Sphinx")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, ".site/build.py", folder]
    made = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600)
    assert made.returncode == 0, made.stdout + made.stderr
    return folder


def test_each_link_leads_somewhere_and_nothing_is_loaded_from_elsewhere(site):
    pages = {path: Names(path) for path in site.rglob("*.html")}
    assert len(pages) >= 60
    for path, page in pages.items():
        for tag, link in page.links:
            if link.scheme or link.netloc:
                assert tag == "a" or link.scheme == "data", (path, link)
                continue
            target = (path.parent / unquote(link.path)).resolve() if link.path else path
            assert target.exists(), (path, link)
            if link.fragment and target in pages and target.name != "play.html":
                assert unquote(link.fragment) in pages[target].anchors, (path, link)


def test_the_start_page_says_how_to_cite_the_version(site):
    text = re.sub("<.*?>", "", (site / "index.html").read_text("utf-8"))
    assert "The fivebar authors: fivebar: exact models" in text
    assert "@software{fivebar,\n  author = {{The fivebar authors}},\n" in text
    assert f"version = {{{fb.__version__}}}" in text


def test_each_public_name_says_what_it_is(site):
    text = "".join(path.read_text("utf-8") for path in site.glob("reference/*.html"))
    told = dict(re.findall(r'<dt [^>]*id="fivebar\.(\w+)">.*?</dt>\s*<dd>(.{20})', text, re.DOTALL))
    assert {name for name in fb.__all__ if name not in fb._PARTS} <= set(told)


@pytest.mark.parametrize("width, scheme", [(1280, "light"), (390, "dark")])
def test_pages_fit_and_the_robot_can_be_dragged_on_the_first(site, width, scheme):
    with chromium("--disable-gpu") as browser:
        page = browser.new_page(viewport={"width": width, "height": 844}, color_scheme=scheme)
        page.context.set_offline(True)
        asked, faults = [], []
        page.on("request", lambda request: asked.append(request.url))
        page.on("pageerror", lambda error: faults.append(str(error)))
        for name in (
            "index",
            "fivebar/guide/models",
            "notebooks/03_second_order",
            "reference/models",
        ):
            page.goto((site / f"{name}.html").as_uri())
            assert page.evaluate("document.documentElement.scrollWidth") == width, name
        assert page.locator("text=/working/i").count()
        page.goto((site / "index.html").as_uri())
        live = page.frame_locator("iframe.live")
        live.locator("text=/let go/i").first.wait_for()
        assert not faults and all(url.startswith(("file:", "data:", "blob:")) for url in asked)
