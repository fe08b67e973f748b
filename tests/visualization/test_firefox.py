"""The pages in Firefox: nothing fails there, joints are round, and what is seen is what Chromium shows."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from scipy import ndimage

import fivebar as fb
from tests.helpers.browsing import DRAWN, chromium, offline, settle, until
from tests.helpers.firefox import opened

ROBOT = fb.FiveBar()
SIZE = {"width": 1200, "height": 900}
WORDS = "[document.title, ...[...document.querySelectorAll('h2')].map(head => head.textContent)]"
LINES = """[...document.querySelectorAll("svg.scene line:is(.joint, .motor, .bar)")].map(line =>
    [line.getAttribute("class"), ...["x1", "y1", "x2", "y2"].map(name => +line.getAttribute(name))])"""


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """{what it shows: its file}."""
    folder = tmp_path_factory.mktemp("pages")
    run = fb.simulate(
        ROBOT, fb.ComputedTorque(ROBOT, 100, 20), fb.line((0.09, 0.068), (0.0, 0.1), 2.0)
    )
    subjects = {
        "run": run,
        "biglide": fb.simulate(fb.Biglide(), duration=0.2),
        "map": fb.singularity_map(ROBOT, shape=(61, 61)),
    }
    for name, subject in subjects.items():
        fb.page(subject, folder / f"{name}.html")
    run.animate(folder / "scene.html")
    return {name: folder / f"{name}.html" for name in (*subjects, "scene")}


@pytest.fixture(scope="module")
def firefox(tmp_path_factory):
    profile = tmp_path_factory.mktemp("profile")
    (profile / "user.js").write_text(
        'user_pref("webgl.disabled", true);\n', encoding="utf-8"
    )  # which only scenes would use
    with opened(profile) as page:
        yield page


@pytest.mark.deep
@pytest.mark.parametrize("name", ["run", "map"])
def test_the_same_is_seen_as_in_chromium(firefox, pages, name):
    firefox.open(pages[name], **SIZE)
    assert firefox.errors == []
    words, mine = firefox.evaluate(WORDS), firefox.evaluate(LINES)
    with chromium("--disable-gpu") as browser, offline(browser) as open_file:
        page = open_file(pages[name], viewport=SIZE)
        until(page, "document.body.dataset.ready")
        settle(page)
        assert words == page.evaluate(WORDS)
        theirs = page.evaluate(LINES)
    assert [part[0] for part in mine] == [part[0] for part in theirs] and len(mine) > 5
    # Fonts differ, and with them the room for the picture: its bars lie alike, up to its scale.
    vectors = [
        np.array([part[3:] for part in parts]) - [part[1:3] for part in parts]
        for parts in (mine, theirs)
    ]
    one, other = (each / np.abs(each).max() for each in vectors)
    np.testing.assert_allclose(one, other, atol=1e-6)


@pytest.mark.deep
def test_joints_are_round(firefox, pages):
    """Ink of their colour that is no bar: as wide as high, and filled as a disc is."""
    firefox.open(pages["run"], **SIZE)
    box = firefox.evaluate(
        "(({x, y, width, height}) => [x, y, width, height])(scene.svg.getBoundingClientRect())"
    )
    x, y, width, height = map(int, box)
    picture = firefox.picture()[y : y + height, x : x + width]
    places = firefox.evaluate("scene.mechanisms[0].points.map(point => scene.onScreen(point))")
    ink = np.abs(picture - to_rgb(firefox.evaluate("theme('--ink')"))).max(axis=-1) < 0.25
    labels, _ = ndimage.label(ink)
    seen = 0
    for column, row in np.round(places).astype(int):
        around = labels[row - 12 : row + 13, column - 12 : column + 13]
        for label in set(around[around > 0].tolist()):
            rows, columns = np.nonzero(labels == label)
            spans = np.ptp(rows) + 1, np.ptp(columns) + 1
            if max(spans) > 4:  # the rest is the edge of something else
                assert abs(spans[0] - spans[1]) <= 2 and max(spans) <= 20, spans
                seen += 1
    assert seen >= 5


def test_a_scene_is_drawn_without_webgl(firefox, pages):
    """Between its motor and its elbow each proximal bar has its own colour, where the model says that it is."""
    firefox.open(pages["scene"], **SIZE)
    assert "no WebGL" in firefox.evaluate("byId('notes').textContent") and firefox.errors == []
    for seconds in (0, 1.5):
        firefox.evaluate(f"(player.pause(), player.seek({seconds}), {DRAWN})")
        picture = firefox.picture()
        xi = fb.line((0.09, 0.068), (0.0, 0.1), 2.0)(seconds)[0]
        for base, elbow, colour in zip(
            (-0.059, 0.059), fb.igm(ROBOT, xi).elbows, ("#005d92", "#a23731"), strict=True
        ):
            x, y = 0.5 * (np.array([base, 0.0]) + elbow)
            where = firefox.evaluate(
                f"""(() => {{ const pane = byId("pane"), place = viewer.camera.position.clone().set({x}, {y}, 0);
                    find("m0/still").localToWorld(place).project(viewer.camera);
                    return [(1 + place.x) / 2 * pane.clientWidth,
                        pane.getBoundingClientRect().top + (1 - place.y) / 2 * pane.clientHeight]; }})()"""
            )
            column, row = np.round(where).astype(int)
            np.testing.assert_allclose(picture[row, column], to_rgb(colour), atol=0.02)


@pytest.mark.deep
def test_the_first_value_is_no_rounding_error(firefox, pages):
    firefox.open(pages["run"], **SIZE)
    outputs = firefox.evaluate(
        "[...document.querySelectorAll('figure output')].map(output => output.textContent)"
    )
    assert all(float(output) == 0 and len(output) < 8 for output in outputs[:3])


@pytest.mark.deep
def test_the_live_page_computes_here_too(firefox, tmp_path):
    fb.play(ROBOT).save(tmp_path / "play.html")
    firefox.open(tmp_path / "play.html", **SIZE)
    firefox.evaluate("(wake(), 1)")
    now = firefox.evaluate("({xi: pose.xi, q: pose.q})")
    np.testing.assert_allclose(now["q"], fb.igm(ROBOT, now["xi"]).q, atol=1e-14)
    assert "radius of 78.72 mm" in firefox.evaluate(
        "document.getElementById('verdict').textContent"
    )
    found = firefox.evaluate(
        """(() => { modes = [1, -1]; take(igm([0.01, 0.12], modes, p)); letGo([0.02, -0.3], {tau: [0, 0]});
            return [flow(2), ...motion.seen.xi]; })()"""
    )
    np.testing.assert_allclose(found[1:], (0.0087618923917, 0.1480740333255), atol=2e-9)
    moving = """(async () => {
        release();
        for (let k = 0; k < 600 && motion.t < 0.3; k++) await new Promise(done => setTimeout(done, 50));
        const found = [motion.t, Boolean(flying.worker)];
        halt();
        return found; })()"""
    t, by_worker = firefox.evaluate(moving)
    assert t >= 0.3 and by_worker
    picture = firefox.picture()
    assert (np.ptp(picture, axis=2) > 0.1).mean() > 0.05
    assert firefox.errors == []
