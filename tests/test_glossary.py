"""The glossary: its pictures are the package's own, its numbers are so, and what links to it finds its heading."""

import base64
import re
from pathlib import Path

import numpy as np
import pytest

import fivebar as fb
from tests.helpers.glossary_pictures import FOLDER, PICTURES, made
from tests.helpers.stored_outputs import PIXELS, apart
from tests.test_notebooks import headings

ROOT = Path(fb.__file__).parents[1]
PAGE = FOLDER / "glossary.md"
TEXT = PAGE.read_text(encoding="utf-8")


@pytest.mark.every(3)
@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_is_current_and_small(name):
    stored = (FOLDER / f"glossary_{name}.png").read_bytes()
    assert f"(glossary_{name}.png)" in TEXT and len(stored) < 20_000
    assert apart(base64.b64encode(stored), base64.b64encode(made(name))) < PIXELS / 4


def test_all_links_lead_to_a_heading():
    pages = [*ROOT.glob("fivebar/guide/*.md"), *ROOT.glob("labs/**/*.md")]
    linked = set()
    for page in pages:
        for link in re.findall(r"\]\(([^)\s]*glossary\.md[^)]*)\)", page.read_text("utf-8")):
            file, _, heading = link.partition("#")
            assert (page.parent / file).resolve() == PAGE.resolve(), (page, link)
            assert not heading or heading in headings(PAGE), (page, link)
            linked.add(page.parent.name)
    assert {"labs", "lab1_geometry", "lab4_singularities", "guide"} <= linked
    for heading in re.findall(r"\]\(#([^)]+)\)", TEXT):
        assert heading in headings(PAGE)


def test_what_it_says_of_modes_and_types():
    robot = fb.FiveBar()
    assert fb.igm(robot, (0.0, 0.1)).working.tolist() == [-1, -1]
    home = fb.dgm(robot, (0.0, 0.0))
    assert home.assembly == -1 and np.allclose(home.xi, (0.09, 0.06796), atol=1e-5)
    draw = np.random.default_rng(3)
    pose = fb.dgm(robot, draw.uniform(-0.6, 0.6, (50, 2)), draw.choice([-1, 1], 50))
    left, right = pose.elbows[:, 0], pose.elbows[:, 1]
    for k, (motor, elbow) in enumerate((((-0.059, 0.0), left), ((0.059, 0.0), right))):
        arrow, bar = pose.xi - motor, elbow - motor
        on_the_left = arrow[:, 0] * bar[:, 1] - arrow[:, 1] * bar[:, 0] > 0
        assert np.array_equal(on_the_left, pose.working[:, k] == 1)
    arrow, point = right - left, pose.xi - left
    on_the_left = arrow[:, 0] * point[:, 1] - arrow[:, 1] * point[:, 0] > 0
    assert np.array_equal(on_the_left, pose.assembly == -1)
    assert np.array_equal(pose.assembly, -np.sign(np.linalg.det(pose.A)))
    assert len(fb.aspects(robot)) == 10


def test_the_quintic():
    line = fb.line((0.0, 0.1), (0.05, 0.1), 1.0)
    t = np.linspace(0, 1, 11)
    xi, xi_dot, _ = line(t)
    assert np.allclose(xi[:, 0] / 0.05, 10 * t**3 - 15 * t**4 + 6 * t**5, atol=1e-12)
    assert xi_dot[:, 0].max() / 0.05 == pytest.approx(15 / 8)
