"""The live page: what a hand does to it, what it says and gives away, and what it refuses."""

import json
import re
from importlib.resources import files
from threading import Thread
from urllib.error import HTTPError
from urllib.request import urlopen

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.visualization.play import LivePage
from fivebar.visualization.play.site import PREVIEW, server

from ..conftest import UNEQUAL
from ..helpers.browsing import settle, until, visit
from ..helpers.pages import browser, contrast, download, opened  # noqa: F401  fixtures
from ..helpers.playing import LENGTHS, PHONE, STILL, drag, on_screen, pose_of

ROBOT = fb.FiveBar()


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("play") / "play.html"
    fb.play().save(path)
    return path


@pytest.fixture
def page(opened, path):  # noqa: F811
    return opened(path, **STILL)


def test_one_small_file_that_lets_only_its_own_script_run(path):
    text = path.read_text("utf-8")
    assert len(text.encode()) <= 400_000
    policy = re.search(r'Content-Security-Policy"\s+content="(.*?)"', text)[1]
    scripts = (
        r"'sha256-[A-Za-z0-9+/]{43}=' 'sha256-[A-Za-z0-9+/]{43}='; worker-src blob:; style-src"
    )
    assert re.search(rf"default-src 'none'; script-src {scripts}", policy)
    assert "//" not in re.sub(
        r"http://www\.w3\.org/2000/svg|(?m:(^|\s)//\s.*$)", "", text
    )  # but comments


@pytest.mark.deep
def test_the_end_effector_slides_along_the_border_and_says_why(page):
    drag(page, pose_of(page)["xi"], (0.05, 0.15), (0.19, 0.16))
    now = pose_of(page)
    pose = fb.igm(ROBOT, now["xi"], now["modes"])
    assert 0 <= pose.reach_margin < 1e-6 and np.hypot(*np.subtract(now["xi"], (0.19, 0.16))) < 0.15
    assert (
        page.locator("#said").text_content()
        == "Stopped at the border (Type 1): the left leg is stretched."
    )
    np.testing.assert_allclose(now["q"], pose.q, atol=1e-9)
    said = page.evaluate("moveTo([0, 0.1], 0.002); moveTo([0, 0.175], 0.002); said")
    assert said.endswith("both legs are stretched.")
    now = pose_of(page)
    # towards Type 2 it is stopped too, and passes only when told to
    drag(page, now["xi"], (0.0, 0.12), (0.0, -0.1))
    now = pose_of(page)
    pose = fb.igm(ROBOT, now["xi"], now["modes"])
    assert (
        "Stopped at Type 2" in page.locator("#said").text_content()
        and 0 < pose.det_A * -now["assembly"] < 1e-4
    )
    page.get_by_label("pass Type 2").check()
    page.evaluate(
        "(now => { performance.now = () => now; })(performance.now())"
    )  # it is said for 5 s
    drag(page, now["xi"], (0.0, -0.1))
    assert "Passed Type 2" in page.locator("#said").text_content()
    np.testing.assert_allclose(pose_of(page)["xi"], (0, -0.1), atol=2e-3)
    assert pose_of(page)["assembly"] == -now["assembly"]


@pytest.mark.deep
def test_the_aspect_under_the_pointer_is_shaded(page):
    own = page.evaluate("aspect.sign")
    page.mouse.move(*on_screen(page, (0.0, -0.1)))
    settle(page)
    assert page.evaluate("[aspect.sign, disc.y < 0]") == [-own, True]
    page.mouse.move(5, 5)
    settle(page)
    assert page.evaluate("[aspect.sign, disc.y > 0]") == [own, True]


@pytest.mark.deep
def test_in_a_notebooks_frame(browser):  # noqa: F811
    page = browser.new_page()
    page.set_content(fb.play(UNEQUAL)._repr_html_())
    frame = page.frames[1]
    until(frame, "document.body.dataset.ready")
    assert frame.evaluate("p") == [getattr(UNEQUAL, name) for name in LENGTHS]
    page.close()


@pytest.mark.deep
def test_type_1_changes_the_mode_where_that_is_wanted(page):
    start = pose_of(page)["xi"]
    page.get_by_label("pass Type 1").check()
    drag(page, start, (0.19, 0.16), (0.04, 0.12))
    now = pose_of(page)
    assert now["modes"] == [1, -1]
    np.testing.assert_allclose(now["xi"], (0.04, 0.12), atol=2e-3)
    page.get_by_role("button", name="Undo (Ctrl Z)").click()
    settle(page)
    assert pose_of(page)["modes"] == [-1, -1] and pose_of(page)["xi"] == pytest.approx(
        start, abs=1e-12
    )


@pytest.mark.deep
def test_elbows_and_joint_space_turn_the_motors(page):
    elbow = page.evaluate("pose.elbows[1]")
    before = pose_of(page)
    drag(page, elbow, (0.059 + 0.09 * np.cos(0.5), 0.09 * np.sin(0.5)))
    now = pose_of(page)
    assert now["q"][0] == pytest.approx(before["q"][0], abs=1e-9) and now["q"][1] == pytest.approx(
        0.5, abs=0.02
    )
    np.testing.assert_allclose(now["xi"], fb.dgm(ROBOT, now["q"], now["assembly"]).xi, atol=1e-9)
    box = page.locator("#joints").bounding_box()
    x, y = page.evaluate("joints.at([0.3, 0.8])")
    page.mouse.click(box["x"] + x, box["y"] + y)
    settle(page)
    np.testing.assert_allclose(pose_of(page)["q"], (0.3, 0.8), atol=0.03)


# To the top, once a swipe's own momentum has ended.
SCROLLED_BACK = """new Promise(done => {
    let still = 0;
    const wait = () => {
        still = scrollY === 0 ? still + 1 : 0;
        scrollTo(0, 0);
        if (still > 20) done(1); else requestAnimationFrame(wait);
    };
    wait();
})"""


def swipe(page, places):
    """Move a finger over these places of the screen."""
    session = page.context.new_cdp_session(page)
    for kind, points in [
        ("touchStart", places[:1]),
        *(("touchMove", [at]) for at in places[1:]),
        ("touchEnd", []),
    ]:
        touches = [{"x": float(x), "y": float(y)} for x, y in points]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": touches})
    settle(page)


@pytest.mark.deep
def test_touch_on_a_phone(opened, path):  # noqa: F811
    page = opened(path, **PHONE, **STILL)
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    go = page.get_by_role("button", name="Let go: the robot moves by itself").bounding_box()
    assert go["y"] + go["height"] < 844
    # in a minute: a wanted disc that does not fit, then bars for which it does
    page.get_by_label("check whether a disc fits").check()
    settle(page)
    assert page.locator("#verdict").text_content().startswith("✗")
    for name, place in (
        ("l11, left proximal bar, mm", "600"),
        ("l12, left distal bar, mm", "750"),
    ):  # of 200 mm
        page.get_by_role("slider", name=name).fill(place)
    until(page, "disc.fine")  # at rest it fits the view, and searches finely
    settle(page)
    assert pose_of(page)["p"] == [0.12, 0.15, 0.12, 0.15, 0.118]
    assert (
        page.locator("#verdict")
        .text_content()
        .startswith("✓ A disc of radius 100 mm fits in this aspect")
    )
    before = pose_of(page)["xi"]
    # a finger beside the robot scrolls the page, and moves nothing
    page.evaluate("scrollTo(0, 0)")
    swipe(page, [on_screen(page, (0.0, -0.15 + 0.1 * share)) for share in np.linspace(0, 1, 8)])
    until(page, "scrollY > 20")
    assert pose_of(page)["xi"] == before
    page.evaluate(SCROLLED_BACK)
    # a finger on the robot drags it, and does not scroll the page
    way = np.linspace(before, (0.04, 0.19), 8)
    swipe(page, [on_screen(page, point) for point in way])
    assert np.hypot(*np.subtract(pose_of(page)["xi"], (0.04, 0.19))) < 5e-3
    assert page.evaluate("scrollY") == 0


@pytest.mark.deep
def test_lengths_that_cannot_close_are_said_and_not_taken(page):
    number = page.get_by_role("spinbutton", name="d, base, mm")
    number.fill("361")
    number.press("Tab")
    settle(page)
    assert "can never close" in page.locator("#said").text_content()
    assert number.input_value() == "118" and pose_of(page)["p"][4] == 0.118
    for wrong in ("", "-3", "1e9"):
        number.fill(wrong)
        number.press("Tab")
        settle(page)
        assert (
            "must be between" in page.locator("#said").text_content()
            and pose_of(page)["p"][4] == 0.118
        )


@pytest.mark.deep
def test_let_go_and_hold_by_the_button(page):
    # a clock that stands still 0.3 s later: what is then held is the same wherever this runs
    page.evaluate("(now => { performance.now = () => flying ? Math.min(now += 10, 300) : 0; })(0)")
    page.get_by_role("button", name="Let go: the robot moves by itself").click()
    until(page, "motion && Math.abs(motion.t - 0.3) < 1e-9")
    page.keyboard.press("g")
    page.evaluate("delete performance.now")
    time = page.evaluate("motion.t")
    settle(page)
    assert page.evaluate("[flying, motion.t]") == [None, time]
    now = pose_of(page)
    np.testing.assert_allclose(now["q"], fb.igm(ROBOT, now["xi"], now["modes"]).q, atol=1e-8)
    page.evaluate(
        "restore({robot: content.presets.motkin.robot, modes: [-1, -1], xi: content.presets.motkin.xi}); release()"
    )
    settle(page)
    assert "names no inertias" in page.locator("#said").text_content()


FLIGHT = "({t: motion.t, worker: Boolean(flying.worker), said: byId('said').textContent})"


@pytest.mark.deep
def test_a_worker_computes_the_motion(page):
    """It runs only while the robot moves; a page that was busy still leaves a smooth trace."""
    page.get_by_label("motor torques while it moves").select_option("constant")
    for _ in range(2):
        page.keyboard.press("g")
        until(page, "motion && motion.t > 0.1")
        assert len(page.workers) == 1 and page.evaluate(FLIGHT)["worker"]
        page.evaluate("for (const from = performance.now(); performance.now() < from + 200;) ;")
        until(page, "motion.t > 0.4")
        rows = np.array(page.evaluate("trail.map(({t, xi}) => [t, ...task.at(xi)])"))
        between = np.diff(rows, axis=0)
        # 1/120 s between two points, more where they are within two pixels
        chords = np.hypot(*between.T[1:])
        assert len(rows) > 5 and np.all((between[:, 0] < 1 / 119) | (chords < 2))
        page.keyboard.press("g")
        until(page, "!flying")
        page.wait_for_timeout(100)
        assert page.workers == []


@pytest.mark.deep
def test_the_page_computes_where_no_worker_may_be_started(browser, path, tmp_path):  # noqa: F811
    blocked = tmp_path / "blocked.html"
    text = path.read_text("utf-8").replace("worker-src blob:", "worker-src 'none'")
    blocked.write_text(text, "utf-8")
    page = browser.new_page(**STILL)
    page.goto(blocked.as_uri())
    until(page, "document.body.dataset.ready")
    page.keyboard.press("g")
    until(page, "motion && motion.t > 0.5")
    found = page.evaluate(FLIGHT)
    assert not found["worker"] and "starts no worker here" in found["said"]
    page.close()


@pytest.mark.deep
def test_in_a_notebooks_frame_a_worker_computes(browser):  # noqa: F811
    page = browser.new_page(**STILL)
    page.set_content(fb.play()._repr_html_())
    frame = page.frames[1]
    until(frame, "document.body.dataset.ready")
    frame.get_by_role("button", name="Let go: the robot moves by itself").click()
    until(frame, "motion && motion.t > 0.3")
    assert frame.evaluate(FLIGHT)["worker"] and len(page.workers) == 1
    page.close()


CLOSED = "l11=0.1&l12=0.1&l21=0.1&l22=0.1&d=0.1"
BAD = [
    "#",
    "#l11",
    "#x=1",
    "#l11=0.09&l11=0.09",
    "#<script>alert(1)</script>",
    "#__proto__=1",
    "#constructor=1&toString=2",
    "#working=%3Cimg%20src=x%20onerror=alert(1)%3E",
    "#" + "l11=0.1&" * 400,
    "#l11=1e999",
    "#l11=0x10",
    "#l11=NaN",
    f"#{CLOSED}&x=0&y=0.1".replace("l11=0.1", "l11=9") + "&working=--",
    f"#{CLOSED}&x=3&y=3&working=--",
    f"#{CLOSED}&x=0&y=0.1&working=-",
    f"#{CLOSED}&x=0&y=0.1".replace("l11=0.1", "l11=0") + "&working=--",
]


@pytest.mark.deep
def test_the_address_restores_the_state_and_hostile_ones_change_nothing(opened, path):  # noqa: F811
    live = fb.play(UNEQUAL)
    page = opened(path, **STILL)
    before = pose_of(page)
    for bad in BAD:
        visit(page, bad)
        assert pose_of(page) == before, bad
        if len(bad) > 1:
            assert "The link's address is not taken" in page.locator("#said").text_content(), bad
            assert page.evaluate("document.querySelectorAll('img, script').length") == 3
    page.evaluate(
        """hash => new Promise(done => {
            addEventListener("hashchange", () => done(), {once: true});
            location.hash = hash;
            history.replaceState(null, "", writeFragment());  // as its own timer may, before it hears of the other
        })""",
        live.fragment,
    )
    settle(page)
    now = pose_of(page)
    assert now["p"] == [getattr(UNEQUAL, name) for name in LENGTHS]
    np.testing.assert_allclose(now["xi"], live.pose.xi, atol=1e-15)
    until(page, f"location.hash === {json.dumps(live.fragment)}")
    upright = fb.play(fb.ROBOTS["iri-vertical"].robot)  # gravity, heavy bars, friction
    visit(page, upright.fragment)
    page.evaluate("pythonBox.open = true")
    settle(page)
    names = {}
    exec(
        compile(
            page.locator("#five pre[aria-label='as Python']").text_content(), "as Python", "exec"
        ),
        names,
    )
    assert names["robot"] == upright.subject
    until(page, f"location.hash === {json.dumps(upright.fragment)}")


@pytest.mark.deep
def test_by_the_keyboard_alone(page):
    for _ in range(8):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.id") == "plane":
            break
    assert page.evaluate("document.activeElement.id") == "plane"
    before = pose_of(page)["xi"]
    for key in ("ArrowRight", "ArrowUp", "Shift+ArrowUp"):
        page.keyboard.press(key)
    step = 4 / page.evaluate("task.scale")
    np.testing.assert_allclose(
        np.subtract(pose_of(page)["xi"], before), [step, 1.2 * step], atol=1e-9
    )
    page.keyboard.press("3")
    assert pose_of(page)["modes"] == [-1, 1]
    page.keyboard.press("4")
    q = pose_of(page)["q"]
    page.keyboard.press("q")
    assert pose_of(page)["q"] == pytest.approx([q[0] + 0.02, q[1]], abs=1e-9)
    page.keyboard.press("0")
    assert pose_of(page)["assembly"] == 1
    for _ in range(4):
        page.keyboard.press("Control+z")
    settle(page)
    until(page, "document.getElementById('status').textContent.includes('disc')")
    assert pose_of(page)["modes"] == [-1, -1]


@pytest.mark.deep
def test_what_it_gives_away(page, tmp_path):
    page.get_by_text("as Python").first.click()
    settle(page)
    lines = page.locator("pre[aria-label='as Python']").first.text_content()
    names = {}
    exec(compile(lines, "as Python", "exec"), names)
    now = pose_of(page)
    assert names["robot"] == ROBOT and names["pose"].xi.tolist() == now["xi"]
    name, svg = download(page, "save the picture as SVG")
    assert name == "Five-bar-live.svg" and svg.startswith(b"<svg xmlns") and svg.count(b"<path") > 8
    name, png = download(page, "save the picture as PNG")
    assert name.endswith(".png") and png[:8] == b"\x89PNG\r\n\x1a\n" and len(png) > 10_000


@pytest.mark.deep
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_is_found_by_axe(opened, path, scheme):  # noqa: F811
    page = opened(
        path, **(PHONE if scheme == "dark" else {}), color_scheme=scheme, reduced_motion="reduce"
    )
    page.get_by_text("as Python").first.click()
    # its script is no page's own: past the policy, by the browser's back door
    session = page.context.new_cdp_session(page)
    axe = files("axe_playwright_python").joinpath("axe.min.js").read_text("utf-8")
    session.send("Runtime.evaluate", {"expression": axe})
    for tab in ("five", "four", "slider", "press"):
        page.evaluate("showTab", tab)
        found = page.evaluate("() => axe.run()")["violations"]
        assert [(each["id"], each["nodes"][0]["html"]) for each in found] == [], tab
    ink = page.evaluate("['ink', 'quiet', 'c0', 'c1', 'c3', 'c4'].map(name => inks[name])")
    paper = page.evaluate("inks.paper")
    assert all(contrast(each, paper) > 3 for each in ink)


@pytest.mark.deep
def test_without_scripts_it_says_so(browser, path):  # noqa: F811
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(path.as_uri())
    assert "computes the robot with JavaScript" in page.locator("body").inner_text()
    context.close()


def test_python_says_the_same(tmp_path, capsys):
    live = fb.play(UNEQUAL)
    assert isinstance(live, LivePage) and repr(live).startswith("<Live page: five-bar robot, #l11=")
    assert live._repr_html_().count("<iframe") == 1
    with pytest.raises(ValueError, match="another robot"):
        fb.play(ROBOT, live.pose)
    with pytest.raises(ValueError, match="single one"):
        fb.play(ROBOT, fb.igm(ROBOT, [(0.09, 0.068)] * 2))
    with pytest.raises(ValueError, match="play refuses a robot with kind = .biglide."):
        fb.play(fb.Biglide())
    out = tmp_path / "live.html"
    assert (
        main(["play", "--robot", "motkin", "--out", str(out), "--xi", "0.01", "0.12", "--link"])
        == 0
    )
    assert capsys.readouterr().out.splitlines() == [str(out), fb.play(*_motkin()).fragment]
    assert main(["play", "--robot", "biglide"]) == 2
    assert main(["play", "--out", "live.pdf"]) == 2
    assert "must end in .html" in capsys.readouterr().err


def _motkin():
    robot = fb.ROBOTS["motkin"].robot
    return robot, fb.igm(robot, (0.01, 0.12))


def test_a_folder_for_any_web_host(tmp_path, capsys):
    folder = tmp_path / "site"
    assert main(["play", "--site", str(folder), "--address", "https://example.org/live"]) == 0
    page = (folder / "index.html").read_text("utf-8")
    assert '<meta property="og:image" content="https://example.org/live/preview.png">' in page
    assert (folder / "preview.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert capsys.readouterr().out.split() == [str(folder / n) for n in ("index.html", PREVIEW)]
    assert main(["play", "--address", "https://example.org"]) == 2
    assert "give --site DIR" in capsys.readouterr().err


def test_a_page_served_here():
    live = fb.play()
    with server(live) as served:
        Thread(target=served.serve_forever).start()
        root = f"http://127.0.0.1:{served.server_port}/"
        with urlopen(root) as answer:
            assert answer.read() == live.html.encode()
        with pytest.raises(HTTPError, match="404"):
            urlopen(root + "other")
        served.shutdown()


def test_what_it_says_of_a_stop_is_what_stopped_it(page):
    """Wherever a pointer leads: the model of the pose, computed here, has the singularity that is named."""
    targets = np.random.default_rng(3).uniform(-0.2, 0.2, (60, 2)).tolist()
    stops = page.evaluate(
        """targets => targets.map(target => {
            modes = [-1, -1]; pose = igm([-0.01, 0.089], modes, p); moveTo(target, 0.002);
            return [said, pose.xi]; })""",
        [[-0.13, 0.03], *targets],
    )
    assert (
        sum("Type 2" in said for said, _ in stops) > 5 < sum("leg is" in said for said, _ in stops)
    )
    for said, xi in stops:
        pose = fb.igm(ROBOT, xi, (-1, -1))
        if "Type 2" in said:
            assert abs(pose.det_A) < 1e-2, (said, xi)
        elif "leg is" in said:
            leg = int("right" in said)
            assert abs(np.sin(pose.q_passive[leg])) < 0.02, (said, xi)
            assert (np.cos(pose.q_passive[leg]) > 0) == ("stretched" in said)


@pytest.mark.deep
def test_it_moves_until_touched_then_guides(opened, path):  # noqa: F811
    page = opened(path)
    before = pose_of(page)["xi"]
    until(page, f"Math.hypot(pose.xi[0] - {before[0]}, pose.xi[1] - {before[1]}) > 1e-3")
    drag(page, pose_of(page)["xi"], (0.0, 0.12), (0.0, -0.1))
    assert page.evaluate("idle") is None
    guide = page.locator("#guide")
    assert "Press another working mode" in guide.text_content()  # it has met Type 2
    page.keyboard.press("2")
    settle(page)
    assert "Press Let go" in guide.text_content()
    page.get_by_role("button", name="Let go: the robot moves by itself").click()
    until(page, "document.getElementById('guide').hidden")


def test_who_wants_little_motion_is_guided_too(page):
    assert page.evaluate("idle") is None
    assert page.locator("#guide").text_content().startswith("1 of 3. Drag the large point")
    page.evaluate("showGuide(GUIDE.length)")
    assert not page.locator("#guide").is_visible()


@pytest.mark.deep
def test_the_place_is_said_once(opened, path):  # noqa: F811
    """While the robot moves its place in the sentence and in the numbers are of one moment."""
    page = opened(path)
    until(page, "performance.now() - idle.began > 300")
    for _ in range(20):
        said, numbers = page.evaluate(
            "[byId('said').textContent, document.querySelector('#numbers dd').textContent]"
        )
        assert f"({numbers.removesuffix(' mm')}) mm" in said
        page.wait_for_timeout(30)


@pytest.mark.deep
def test_two_radii_that_differ_are_shown_apart(page):
    page.get_by_label("robot by name").select_option("reprapfirmware")  # its largest has 127.5 mm
    page.evaluate("wantsDisc = true")
    for wanted, words in [
        (0.1275, "✓ A disc of radius 127.5 mm fits in this aspect: .* has 127.5 mm"),
        (0.12751, "✗ A disc of radius 127.51 mm does not fit in this aspect: .* has 127.5 mm"),
        (0.12, "✓ A disc of radius 120 mm fits in this aspect: .* has 127.5 mm"),
    ]:
        page.evaluate("value => { wanted = value; ask(); }", wanted)
        settle(page)
        assert re.fullmatch(words + r"\.", page.locator("#verdict").text_content())


@pytest.mark.every(2)
@pytest.mark.parametrize("width, height", [(390, 844), (1440, 900)])
def test_the_radius_is_not_behind_a_bar(opened, path, width, height):  # noqa: F811
    """Its middle is 10 px and more from all bars, wherever the robot is in its aspect."""
    page = opened(path, width, height, **STILL)
    far = page.evaluate(
        """() => { const own = CanvasPen.prototype.words; let at = null;
            CanvasPen.prototype.words = function (text, place, look) { if (look.ink === "c3") at = place; };
            const all = [];
            for (let k = 0; k < 60; k++) {
                moveTo([0.08 * Math.cos(k / 3), 0.09 + 0.06 * Math.sin(k / 3)], 0.002); moved(); drawTaskFront();
                const [left, right] = [-p[4] / 2, p[4] / 2].map(x => [x, 0]), [e1, e2] = pose.elbows;
                all.push(Math.min(...[[left, e1], [e1, pose.xi], [right, e2], [e2, pose.xi]].map(bar =>
                    distanceToBar([at[0], at[1] - 4], bar.map(end => task.at(end))))));
            }
            CanvasPen.prototype.words = own;
            return Math.min(...all); }"""
    )
    assert far > 10


@pytest.mark.deep
def test_let_go_keeps_up_and_its_energy_stays_bounded(page):
    """At its own torques and friction, 60 s: computed in less time, energy as after 10 s."""
    found = page.evaluate(
        """() => { release(); halt(); const tau = torqueInputs.map(input => +input.value), energies = [];
            letGo([0, 0], {tau, wave: true}, addedFriction());
            const begun = performance.now();
            for (let k = 0; k < 3600; k++) { if (!flow(1 / 60)) return null; energies.push(totalEnergy().kinetic); }
            return [energies, (performance.now() - begun) / 1000]; }"""
    )
    energies, seconds = found
    assert max(energies) < 0.05 and max(energies[600:]) < 2 * max(energies[:600])
    assert seconds < 30


@pytest.mark.deep
def test_the_scale_bar_is_a_round_length(page):
    """1, 2 or 5 times a power of ten, the largest that fits, and its text says it."""
    sizes = {"m": 1, "mm": 1e-3, "µm": 1e-6, "nm": 1e-9}
    for most in [*np.geomspace(2e-8, 90, 61), 1e-3, 0.02, 0.1, 0.5, 1.0, 20.0]:
        bar = page.evaluate("scaleBar", float(most))
        digits, unit = bar["text"].split()
        assert float(digits) * sizes[unit] == pytest.approx(bar["length"], rel=1e-12)
        assert f"{bar['length']:.0e}"[0] in "125" and float(digits) >= 1
        assert bar["length"] <= most * (1 + 1e-8) < 2.5001 * bar["length"]


@pytest.mark.deep
def test_names_follow_the_robot(page):
    names = page.get_by_label("robot by name")
    names.select_option("iri-vertical")
    assert page.get_by_label("gravity, 9.81").is_checked()
    assert "mx11 = " in page.locator("#more").text_content()
    assert "IRI five-bar" in page.locator("#panel .source").first.text_content()
    page.get_by_role("slider", name="l11, left proximal bar, mm").fill("400")
    assert names.input_value() == ""
    assert page.locator("#panel .source").first.text_content() == ""
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Undo").click()
    assert names.input_value() == "iri-vertical"
    page.locator("#plane").focus()
    page.keyboard.press("2")
    pressed = page.locator("#panel button[aria-pressed=true]")
    assert pressed.text_content() == "+−"


@pytest.mark.deep
def test_equations_and_trace(page):
    drag(page, pose_of(page)["xi"], (0.02, 0.12))
    page.get_by_text("Equations of this pose").click()
    settle(page)
    text = page.locator("pre[aria-label='equations of this pose']").text_content()
    now = pose_of(page)
    pose = fb.igm(ROBOT, now["xi"], now["modes"])
    numbers = [float(x.replace("−", "-")) for x in re.findall(r"−?\d+\.\d{4}", text)]
    exact = [*pose.A.ravel(), *pose.B.ravel(), pose.det_A]
    np.testing.assert_allclose(numbers[:9], exact, atol=6e-5)
    name, csv = download(page, "save the trace as CSV")
    lines = csv.decode().splitlines()
    assert name.endswith(".csv") and lines[1] == "t,q1,q2,x,y"
    rows = np.array([[float(x) for x in line.split(",")] for line in lines[2:]])
    np.testing.assert_allclose(fb.igm(ROBOT, rows[:, 3:], (-1, -1)).q, rows[:, 1:3], atol=1e-9)


@pytest.mark.deep
def test_a_tool_is_rigid_on_its_bar_and_leaves_the_trace(opened, tmp_path):  # noqa: F811
    tool = fb.Tool(2, 0.03, -0.02)
    fb.play(UNEQUAL, tool=tool).save(tmp_path / "tool.html")
    page = opened(tmp_path / "tool.html", **STILL)
    drag(page, pose_of(page)["xi"], np.add(pose_of(page)["xi"], 0.005))
    now = pose_of(page)
    pose = fb.igm(UNEQUAL, now["xi"], now["modes"])
    tip, trace, address = page.evaluate(
        "() => [tipOf(pose), trail[trail.length - 1].tip, writeFragment()]"
    )
    np.testing.assert_allclose(tip, tool.point(pose), atol=1e-12)
    assert np.linalg.norm(np.subtract(trace, tip)) < 1e-3
    assert "&leg=2&along=0.03&across=-0.02&" in address
    take = "text => { applyState(readFragment(text).state); return robot.leg; }"
    again = page.evaluate(take, address)
    assert again == 2
    wrong = page.evaluate("text => readFragment(text).words", address.replace("leg=2", "leg=1.5"))
    assert wrong == "of a tool it needs leg, which is 1 or 2, along and across"
    assert "tool=fb.Tool(2, 0.03, -0.02)" in page.evaluate("asPython()")


def test_a_linkage_has_no_tool():
    with pytest.raises(ValueError, match="tool is a robot's"):
        fb.play(fb.linkages.PRINTED, tool=fb.Tool(1, 0.01))
