"""What axe finds on every kind of page that the package writes, in light and dark, wide and on a phone: nothing."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.linkages import FourBar, study
from fivebar.study.speed_accuracy import making

from ..helpers.browsing import chromium, until
from ..helpers.needs import need
from ..helpers.pages import contrast

ROBOT = fb.FiveBar()


@pytest.fixture(scope="module")
def run():
    reference = fb.circle((0.0, 0.11), 0.02, 1.0)
    controller = fb.ComputedTorque(ROBOT, 400, 40)
    return fb.simulate(ROBOT, controller, reference, control_period=0.01)


def write_run(path, run):
    fb.page(run, path)


def write_comparison(path, run):
    fb.page({"one": run, "two": run}, path)


def write_map(path, run):
    fb.page(fb.singularity_map(ROBOT, shape=(41, 41)), path)


def write_linkage(path, run):
    locking = FourBar(0.2, 0.12, 0.16, 0.14, point=(0.08, 0.05))
    fb.page(study(locking, drive="until-lock"), path)


def write_animation(path, run):
    run.animate(path)


def write_designs(path, run):
    bounds = {"l1": (0.1, 0.15), "l2": (0.1, 0.15), "d": 0.1}
    front = fb.design(["workspace_area", "bars"], bounds, points=3, effort=0.02)
    front.page(path)


def write_charts(path, run):
    making.make(["toy"], path.parent, charts={"toy": ("tests.helpers.toy_chart", "a toy")})


def write_cohort(path, run):
    answers = path.parent / "answers"
    answers.mkdir()
    for name, result in (("anna", "0.0, 0.0"), ("ben", "q11, q21")):
        text = f"def dgm(q11, q21, assembly_mode):\n    return {result}\n"
        (answers / f"{name}.py").write_text(text, encoding="utf-8")
    folder = path.parent / "graded"
    main(["grade", "lab1", str(answers), "--isolate", "process", "--out", str(folder)])
    (folder / "summary.html").rename(path)


PAGES = {
    "run": write_run,
    "comparison": write_comparison,
    "map": write_map,
    "linkage": write_linkage,
    "animation": write_animation,
    "designs": write_designs,
    "charts": write_charts,
    "cohort": write_cohort,
}


@pytest.fixture(scope="module")
def browser():
    with chromium("--disable-gpu") as browser:
        yield browser


def violations(page):
    need("axe")
    from axe_playwright_python.sync_playwright import Axe

    # Accessible names that contain the visible words are an experimental rule, off by default.
    options = {"rules": {"label-content-name-mismatch": {"enabled": True}}}
    found = Axe().run(page, options=options).response["violations"]
    return {each["id"]: [node["html"] for node in each["nodes"]] for each in found}


SCHEMES = {"light": 1280, "dark": 390}


# Eight kinds: the first in light, and the fifth, an animation, in dark.
@pytest.mark.every(9)
@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("kind", PAGES)
def test_axe_finds_nothing(browser, tmp_path, run, kind, scheme):
    path = tmp_path / "index.html"
    PAGES[kind](path, run)
    size = {"width": SCHEMES[scheme], "height": 844}
    context = browser.new_context(color_scheme=scheme, viewport=size, reduced_motion="reduce")
    page = context.new_page()
    page.goto(path.as_uri())
    if page.locator("script").count():
        until(page, "document.body.dataset.ready")
    assert violations(page) == {}
    context.close()


def test_bars_are_seen_on_every_ground():
    from fivebar.visualization.style import LEGS, LINKS, PATH

    colours = {*LINKS, *np.ravel(LEGS), PATH}
    assert len(colours) == 7
    for ground in ("#ffffff", "#f7f9fa", "#14171b", "#1a1e22"):
        for colour in colours:
            assert contrast(ground, colour) >= 3.0, (ground, colour)
