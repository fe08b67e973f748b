"""The best robot and fronts: against problems with a known answer, and what holds each result."""

import html
import json
import re
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
from matplotlib.figure import Figure as Picture

import fivebar as fb
from fivebar.optimal_design.evolution import best, dominates, evolve, refine, thinned
from fivebar.visualization.pages.fronts import live_page

D = fb.optimal_design
LENGTHS = {"l1": (0.05, 0.3), "l2": (0.05, 0.3), "d": (0.0, 0.2)}
TABLE = dict(table=(0.2, 0.15), motor="xh430-w350", poses=(9, 7))
ON_TABLE = {"l1": (0.05, 0.4), "l2": (0.05, 0.5), "d": (0.06, 0.2), "task_y": (0.05, 0.5)}


@pytest.mark.deep
def test_the_largest_workspace_of_bars_of_a_length():
    """Coaxial motors and equal bars: a disc of the radius of two of them."""
    found = fb.design("workspace_area", LENGTHS, limits={"bars": 0.6})
    assert found.values["workspace_area"] == pytest.approx(np.pi * 0.3**2, rel=1e-6)
    assert found.parameters == pytest.approx({"l1": 0.15, "l2": 0.15, "d": 0.0}, abs=1e-6)
    assert found.binding == (
        "d = 0 is at its lower bound 0",
        "bars = 0.6 is at its limit, at most 0.6",
    )
    free = fb.design("workspace_area", LENGTHS)
    assert (
        free.unreached_bounds["workspace_area"] == pytest.approx(np.pi * 0.6**2)
        and free.gaps["workspace_area"] < 1e-6
    )
    assert (
        "no robot within the bounds passes workspace_area = 1.13097; this one is 0 % off"
        in free.report
    )


@pytest.mark.deep
def test_a_front_whose_answer_is_known():
    """Of bars B together at most a disc of the radius B / 2: area = pi B^2 / 4."""
    front = fb.design(["workspace_area", "bars"], LENGTHS, points=12)
    area, bars = front["workspace_area"], front["bars"]
    np.testing.assert_allclose(area, np.pi * bars**2 / 4, rtol=1e-3)
    assert (bars[0], bars[-1]) == pytest.approx((0.2, 1.2), rel=1e-6) and np.diff(bars).max() < 0.25
    assert len(front) == 12 and (np.diff(area) > 0).all()
    assert front.designs[0].gaps["bars"] < 1e-6 and front.designs[-1].gaps["workspace_area"] < 1e-6


@pytest.mark.every(2)
@pytest.mark.parametrize("power", [0.5, 2.0])
def test_fronts_of_zitzler_deb_and_thiele(power):
    """ZDT1 and ZDT2 in six parameters: f2 = 1 - f1^power where all but the first are 0; one bends in, one out."""

    def problem(x):
        g = 1 + 9 * x[:, 1:].mean(axis=1)
        return np.stack([x[:, 0], g * (1 - (x[:, 0] / g) ** power)], axis=1), np.zeros(len(x))

    rng, low, high = np.random.default_rng(1), np.zeros(6), np.ones(6)
    x, f, _ = evolve(problem, low, high, 80, 100, rng)
    chosen = thinned(f, np.arange(len(f)), 15)
    _, f, _ = refine(problem, low, high, x, f, chosen, 20, 120, rng)
    assert np.abs(f[:, 1] - (1 - f[:, 0] ** power)).max() < 1e-3
    assert f[:, 0].min() < 1e-3 and f[:, 0].max() > 0.999


def test_three_goals_on_the_simplex():
    """Nearest to three corners at once: the front is their triangle."""
    corners = np.array([(0.2, 0.2), (0.8, 0.2), (0.5, 0.8)])

    def problem(x):
        return np.linalg.norm(x[:, None, :2] - corners, axis=2) + 3 * x[:, 2:], np.zeros(len(x))

    rng, low, high = np.random.default_rng(2), np.zeros(3), np.ones(3)
    x, f, _ = evolve(problem, low, high, 80, 80, rng)
    chosen = thinned(f, np.arange(len(f)), 15)
    x, f, _ = refine(problem, low, high, x, f, chosen, 20, 80, rng)
    inside = np.linalg.solve(
        np.vstack([corners.T, np.ones(3)]), np.vstack([x[:, :2].T, np.ones(len(x))])
    )
    assert inside.min() > -1e-3 and x[:, 2].max() < 1e-3


def test_what_is_better():
    f, off = np.array([[0.0, 1], [1, 0], [1, 1], [0, 0]]), np.array([0, 0, 0, 2.0])
    assert dominates(f[0], off[0], f[2], off[2]) and not dominates(f[0], off[0], f[1], off[1])
    assert dominates(f[2], off[2], f[3], off[3])  # what keeps the limits
    assert sorted(best(f, off, 3)) == [0, 1, 2] and sorted(best(f, off, 2)) == [0, 1]
    line = np.stack([np.arange(11.0), -np.arange(11.0)], axis=1)
    assert thinned(line, np.arange(11), 3)[0] == 0 and thinned(line, np.arange(11), 3)[-1] == 10


@pytest.fixture(scope="module")
def front():
    return fb.design(
        ["footprint", "tip_speed"],
        ON_TABLE,
        limits={"det_A": 0.4, "tip_force": (12.0, None)},
        step=0.001,
        points=8,
        effort=0.6,
        **TABLE,
    )


def test_a_front_for_a_table_and_a_motor(front):
    """Each design by itself: its figures, limits, whole millimetres, and that none of the others is better."""
    for each in front.designs:
        lengths = np.array([each.robot.l11, each.robot.l12, each.robot.d])
        np.testing.assert_allclose(lengths, np.round(lengths, 3), rtol=0, atol=1e-12)
        done = fb.sweep(
            list(each.values), {name: [value] for name, value in each.parameters.items()}, **TABLE
        )
        assert {name: done[name][0] for name in each.values} == dict(each.values)
        assert (
            each.values["det_A"] >= 0.4
            and each.values["tip_force"] >= 12.0
            and each.values["reach"] > 0
        )
        assert each.robot.l11 == each.robot.l21 and each.robot.l12 == each.robot.l22
    f = np.stack([front["footprint"], -front["tip_speed"]], axis=1)
    assert (np.diff(f[:, 0]) > 0).all() and (np.diff(f[:, 1]) < 0).all()
    assert len(front) >= 6 and front.knee in front.designs
    # None of 4000 designs of a sweep that keep the limits is better than the front by more than its steps.
    names = ["footprint", "tip_speed", "det_A", "tip_force", "reach"]
    swept = fb.sweep(names, D.sample(ON_TABLE, 4000), **TABLE)
    kept = (swept["det_A"] >= 0.4) & (swept["tip_force"] >= 12) & (swept["reach"] > 0)
    assert kept.sum() > 20
    speed = np.interp(swept["footprint"][kept], front["footprint"], front["tip_speed"], left=0.0)
    inside = swept["footprint"][kept] >= front["footprint"].min()
    assert (swept["tip_speed"][kept][inside] <= speed[inside] + 0.03).all()


@pytest.mark.deep
def test_a_front_is_kept_drawn_and_opened(front, tmp_path):
    (tmp_path / "front" / "robots").mkdir(parents=True)
    (tmp_path / "front" / "robots" / f"{len(front) + 1:02d}.json").write_text(
        "of a longer front", encoding="utf-8"
    )
    front.save(tmp_path / "front")
    again = D.Front.load(tmp_path / "front")
    assert repr(again) == repr(front) and repr(front).startswith(
        f"<Front: {len(front)} designs, footprint from 0.0"
    )
    assert [each.report for each in again.designs] == [each.report for each in front.designs]
    assert again.robots == front.robots
    files = sorted((tmp_path / "front" / "robots").iterdir())
    assert [fb.FiveBar(**json.loads(file.read_text("utf-8"))) for file in files] == list(
        front.robots
    )
    assert (tmp_path / "front" / "front.png").stat().st_size > 20_000
    lines = (tmp_path / "front" / "front.csv").read_text("utf-8").splitlines()
    assert (
        lines[1].startswith("l1,l2,d,task_y,footprint,tip_speed,det_A,tip_force")
        and len(lines) == len(front) + 2
    )
    along = fb.design(
        ["bars", "worst_speed"],
        {"l1": (0.1, 0.2), "l2": (0.1, 0.2), "task_y": 0.15},
        points=2,
        effort=0.02,
        motion=fb.line((-0.02, 0), (0.02, 0), 1.0),
        path=[(-0.02, 0), (0.02, 0)],
    )
    along.save(tmp_path / "along")
    assert D.Front.load(tmp_path / "along").designs[0].values == along.designs[0].values
    assert isinstance(again.plot(robots=3), Picture) and isinstance(again.knee.plot(), Picture)
    page = (tmp_path / "front" / "index.html").read_text("utf-8")
    links = [html.unescape(text) for text in re.findall(r'href="(index_live\.html#[^"]*)"', page)]
    assert links == [f"index_live.html{live_page(each).fragment}" for each in front.designs]
    assert all(f"l11={each.robot.l11}" in text for each, text in zip(front.designs, links))
    heads = re.findall(r'<th scope="col">(.*?)</th>', page)
    assert (
        heads[1:5] == ["l1 (m)", "l2 (m)", "d (m)", "task_y (m)"]
        and heads[-1] == "active constraints"
    )
    assert "motor = (stall_torque 3.4, no_load_speed 3.14159" in page
    assert "largest_torque" not in page  # what was not given is not said
    assert "poses = (9, 7), table = (-0.1, 0.1, -0.075, 0.075)" in page
    assert (tmp_path / "front" / "index_live.html").stat().st_size > 100_000
    # A page beside what `fivebar play` wrote leaves that as it is.
    (tmp_path / "play.html").write_text("mine", encoding="utf-8")
    front.page(str(tmp_path / "two goals.html"), title="Of two goals")
    assert (tmp_path / "play.html").read_text("utf-8") == "mine"
    assert (tmp_path / "two goals_live.html").stat().st_size > 100_000
    page = (tmp_path / "two goals.html").read_text("utf-8")
    assert set(re.findall(r'href="([^"#]*)#', page)) == {"two%20goals_live.html"}
    assert "<h1>Of two goals</h1>" in page
    with pytest.raises(ValueError, match="give it a path"):
        front.page()
    with pytest.raises(ValueError, match="holds no designs"):
        D.Front.load(tmp_path)
    (tmp_path / "front" / "front.json").write_text(
        '{"what": "fivebar designs", "designs": [{}], "choices": {}}', encoding="utf-8"
    )
    with pytest.raises(ValueError, match="front.json is not what a design left there"):
        D.Front.load(tmp_path / "front")


def test_pictures_of_sweeps(tmp_path):
    atlas = fb.sweep("workspace_area", D.triangle(6)).plot(tmp_path / "atlas.png")
    assert (tmp_path / "atlas.png").stat().st_size > 10_000
    assert atlas.axes[0].get_title() == "$r_1 + r_2 + r_3 = 3$"
    for designs in (
        {"d": np.linspace(0, 0.2, 9)},
        D.grid({"l1": [0.1, 0.12], "l2": [0.1, 0.2]}),
        D.sample(LENGTHS, 20),
    ):
        assert isinstance(fb.sweep("workspace_area", designs).plot(), Picture)
    figures = ["inscribed_circle", "workspace_area", "transmission_angle"]
    plane = fb.sweep(
        figures,
        D.grid({"l1": [0.08, 0.09, 0.12], "d": [0.05, 0.08]}),
        table=(-0.02, 0.02, 0.08, 0.1),
    )
    picture = plane.plot()
    panels = picture.axes[:3]  # of a grid of two columns, whose outer ones alone have labels
    assert [axes.get_xlabel() for axes in panels] == ["", "", "$l_{1}$ (mm)"]
    assert [axes.get_ylabel() for axes in panels] == ["d (mm)", "", "d (mm)"]
    bars = [axes.get_ylabel() for axes in picture.axes[3:]]
    assert bars == ["inscribed circle (mm)", "workspace area (cm²)", "transmission angle (deg)"]
    best = plane.design(plane.best("inscribed_circle")[0])
    (mark,) = panels[0].lines
    assert mark.get_xydata().tolist() == [[1e3 * best["l1"], 1e3 * best["d"]]]
    few = D.sample({"l1": (0.1, 0.12), "d": (0.1, 0.12)}, 2)  # no triangle between them
    assert fb.sweep("workspace_area", few).plot().axes[0].get_xlabel() == "$l_{1}$ (mm)"
    three = fb.sweep(figures[:2], D.sample(LENGTHS, 8)).plot()
    assert len(three.axes) == 2 * len(LENGTHS)
    with pytest.raises(
        ValueError, match="there is nothing to draw: workspace_area is finite in none of 1 designs"
    ):
        fb.sweep("workspace_area", {"d": [9.0]}).plot()


def cost(robot):
    return 3 * robot.l11


def bars(robot):
    return 2 * robot.l11 / robot.d


def words_of(picture):
    panels = [(axes.get_xlabel(), axes.get_ylabel(), axes.get_title()) for axes in picture.axes]
    legends = [text.get_text() for legend in picture.legends for text in legend.get_texts()]
    return [*sum(panels, ()), *legends]


def test_a_function_of_ones_own_has_no_unit_in_pictures(tmp_path):
    """Also one that is called as a figure that has one: cost = 3 x 0.2 at best, bars = 0.4 / 0.1."""
    own, space = [cost, bars, "workspace_area"], {"l1": [0.05, 0.2], "d": [0.1, 0.4]}
    swept = fb.sweep(own, D.grid(space))
    words = words_of(swept.plot())
    assert {"best: cost = 0.6", "best: bars = 4", "cost", "bars"} < set(words)
    assert "workspace area (cm²)" in words
    assert swept.robot_at(swept.best("bars")[0]).l11 == 0.2  # a function is to be large
    assert {"cost", "bars"} < set(words_of(fb.sweep([cost, bars], D.triangle(6)).plot()))
    front = fb.design(own[::2], {"l1": (0.05, 0.2), "d": (0.1, 0.2)}, effort=0.02, points=2)
    assert front.plot().axes[0].get_xlabel() == "cost, max"
    front.page(tmp_path / "front.html")
    heads = re.findall("<th[^>]*>([^<]+)", (tmp_path / "front.html").read_text(encoding="utf-8"))
    assert heads[1:5] == ["l1 (m)", "d (m)", "cost", "workspace_area (m²)"]


def test_parameters_have_their_units_in_pictures():
    picture = fb.sweep("bars", D.grid({"mx11": [0, 0.001], "r1": [0.1, 0.2]})).plot()
    assert words_of(picture)[:2] == ["mx11 (kg m)", "$r_{1}$"]


def test_goals_of_ones_own_may_have_names():
    found = fb.design({"size": lambda robot: robot.l11}, {"l1": (0.05, 0.2)}, effort=0.05)
    assert found.values == pytest.approx({"size": 0.2}, rel=1e-3) and found.goals == {"size": "max"}


def ring(robot):
    return float(robot.l11 * robot.l12)


def wide(robot):
    return robot.l1 + robot.d


@pytest.mark.deep
def test_slow_figures_are_computed_by_an_executor_and_a_design_is_kept(tmp_path):
    ask = dict(
        goals=[ring, "bars"], bounds={"l1": (0.1, 0.2), "l2": (0.1, 0.2)}, points=4, effort=0.05
    )
    with ProcessPoolExecutor(2) as executor:
        there = fb.design(**ask, executor=executor)
        with pytest.raises(
            TypeError, match="executor must be a concurrent.futures.Executor, not 'dask'"
        ):
            fb.design(**ask | {"executor": "dask"})
    assert repr(there) == repr(fb.design(**ask)) and "data:image/png" in there._repr_html_()
    glide = fb.design({wide: "min"}, {"l1": (0.3, 0.4), "l2": 0.4}, robot=fb.Biglide(), effort=0.02)
    assert "<code>&lt;Design: wide = " in glide._repr_html_()
    with pytest.raises(RuntimeError, match="takes no more work.*begin it anew"):
        fb.design(**ask, executor=executor)
    there.designs[0].save(tmp_path / "one.json")
    again = D.Design.load(tmp_path / "one.json")
    assert repr(again) == repr(there.designs[0]) and again.report == there.designs[0].report


def test_goals_of_ones_own_and_fixed_parameters():
    def near(robot):
        return (robot.l11 - 0.123) ** 2 + (robot.l12 - 0.2) ** 2

    found = fb.design({near: "min"}, {"l1": (0.1, 0.2), "l2": 0.15}, effort=0.1)
    assert (
        found.parameters["l1"] == pytest.approx(0.123, abs=1e-4) and found.parameters["l2"] == 0.15
    )
    assert "of near no bound is known: it is the best that was found" in found.report
    assert fb.design("bars", {"l1": 0.1, "l2": 0.2}).values["bars"] == pytest.approx(0.6)


@pytest.mark.parametrize(
    "asked, error, notes",
    [
        (
            lambda: fb.design("area", LENGTHS),
            ValueError,
            "goals: no figure 'area'; the known ones are",
        ),
        (
            lambda: fb.design({"bars": "most"}, LENGTHS),
            ValueError,
            'bars is to be "min" or "max", not \'most\'',
        ),
        (
            lambda: fb.design(["bars", "workspace_area", "det_A", "sin"], LENGTHS, **TABLE),
            ValueError,
            "at most three",
        ),
        (
            lambda: fb.design("bars", {"l1": (0.3, 0.1)}),
            ValueError,
            "bounds: l1 = .* is the wrong way round",
        ),
        (lambda: fb.design("bars", {"l7": (0.1, 0.3)}), ValueError, "bounds: no parameter 'l7'"),
        (lambda: fb.design("bars", [0.1]), TypeError, "bounds must be a table"),
        (
            lambda: fb.design("bars", {"l1": (0.1, 0.2, 0.3)}),
            ValueError,
            "l1 must be .low, high. or a number",
        ),
        (
            lambda: fb.design("bars", {"l1": (0.1, np.inf)}),
            ValueError,
            "bounds: l1's high must be finite",
        ),
        (
            lambda: fb.design("bars", {"l1": (0.1001, 0.1004)}, step=1e-3),
            ValueError,
            "no multiple of step = 0.001",
        ),
        (
            lambda: fb.design("bars", LENGTHS, limits={"det_A": 0.5}),
            ValueError,
            "limits: det_A needs table",
        ),
        (
            lambda: fb.design("bars", LENGTHS, limits={"workspace_area": (2, 1)}),
            ValueError,
            "is the wrong way round",
        ),
        (
            lambda: fb.design("bars", LENGTHS, limits={"bars": (None, None)}),
            ValueError,
            "neither a low nor a high",
        ),
        (lambda: fb.design("bars", LENGTHS, limits=["bars"]), TypeError, "limits must be a table"),
        (
            lambda: fb.design("bars", LENGTHS, points=1),
            ValueError,
            "points must be a whole number >= 2",
        ),
        (
            lambda: fb.design("bars", LENGTHS, limits={"workspace_area": 50.0}, effort=0.1),
            ValueError,
            "nothing within the bounds was found that keeps the limits; .*: workspace_area = 1.1.*, not from 50",
        ),
        (
            lambda: fb.design("bars", LENGTHS, table=(2.0, 2.0), poses=5, effort=0.1),
            ValueError,
            "the nearest, l1 = .*: the table is out of reach by",
        ),
        (lambda: fb.design("bars", {"d": (0.5, 0.9)}, effort=0.1), ValueError, "no robot closes"),
    ],
)
def test_what_is_refused(asked, error, notes):
    with pytest.raises(error, match=notes):
        asked()
