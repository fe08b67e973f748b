"""Designs, figures and the rules of a search against the same things computed by hand."""

import json
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

import fivebar as fb
from fivebar.base.errors import SingularityError
from fivebar.optimal_design import one_by_one
from fivebar.optimal_design.batch import (
    known_variables,
    place_of_design,
    robot_of_design,
    robots_of_designs,
    valid_rows,
)
from fivebar.optimal_design.closed_forms import _lens
from fivebar.optimal_design.evolution import best, dominates, evolve, thinned
from fivebar.optimal_design.figures import figures_of
from fivebar.optimal_design.one_by_one import _first_root, _of_parts
from fivebar.optimal_design.optimum import DesignProblem
from fivebar.optimal_design.results import Front
from fivebar.optimal_design.task import task_of
from fivebar.paths.timing.time_path import TimingError

D = fb.optimal_design
PLASTIC = 1.3247179572447460  # g^3 = g + 1
GOLDEN = 1.6180339887498949  # g^2 = g + 1


# Designs


def rows_of(designs):
    return np.concatenate(list(designs.chunks(7)))


@pytest.mark.parametrize(
    "bounds,ratios",
    [({"d": (1.0, 3.0)}, [1 / GOLDEN]), ({"l1": (2, 6), "d": (0, 1)}, [1 / PLASTIC, PLASTIC**-2])],
)
def test_a_sample_is_roberts_sequence(bounds, ratios):
    low, high = np.array(list(bounds.values()), dtype=float).T
    places = (rows_of(D.sample(bounds, 40, seed=3)) - low) / (high - low)
    expected = (places[0] + np.outer(np.arange(40), ratios)) % 1
    np.testing.assert_allclose(places, expected, rtol=0, atol=1e-13)
    other = (rows_of(D.sample(bounds, 1, seed=4)) - low) / (high - low)
    assert np.abs(other - places[0]).min() > 1e-6


def test_a_late_design_is_as_exact_as_the_first():
    late = D.sample({"d": (0, 1)}, 10**12, seed=1)
    first = Fraction(float(late._rows(0, 1)[0, 0]))
    step = Fraction(int(2.0**64 / GOLDEN), 2**64)
    exact = (first + (10**12 - 1) * step) % 1
    assert float(late._rows(10**12 - 1, 10**12)[0, 0]) == pytest.approx(float(exact), abs=1e-12)


@pytest.mark.parametrize("count", [2, 5, 6])
def test_the_triangle_has_all_points_of_its_grid(count):
    expected = {
        (3 * i / count, 3 * j / count, 3 * (count - i - j) / count)
        for i in range(1, count + 1)
        for j in range(1, count + 1)
        if 0 <= count - i - j <= i + j
    }
    rows = rows_of(D.triangle(count))
    assert {tuple(row) for row in rows} == expected and len(rows) == len(expected)


@pytest.mark.parametrize(
    "asked,words",
    [
        (lambda: D.grid({"l1": np.zeros((2, 2))}), "l1 must be a row of numbers"),
        (lambda: D.grid({"l1": []}), "l1 must be"),
        (lambda: D.grid({"l1": (0.05, 0.2)}), r"l1 must be \(low, high, count\), or a list"),
        (lambda: D.grid({"l1": (0.05, 0.2, 2.5)}), "l1's count must be a whole number"),
        (lambda: D.grid({"l1": (0.2, 0.05, 3)}), "l1 = .* is the wrong way round"),
        (lambda: D.grid({"q": [1]}), "grid: no parameter 'q' of a design; the known ones are l1,"),
        (lambda: D.sample({"q": (0, 1)}, 3), "sample: no parameter 'q' of a design"),
        (
            lambda: D.grid({"l1": np.ones(10**5), "l2": np.ones(10**4), "d": np.ones(10**4)}),
            r"grid: 1e\+13 designs are more than 1e\+12",
        ),
        (
            lambda: fb.sweep("bars", {"l1": np.zeros((2, 2))}),
            r"designs\[l1\] must be a number or a column, not of",
        ),
        (lambda: fb.sweep("bars", {"l1": []}), "designs: the columns are empty"),
        (
            lambda: fb.sweep("bars", [fb.FiveBar(gravity=(0, -9.81))]),
            r"designs: gravity \(0.*-9.81\) is not that of",
        ),
        (lambda: D.triangle(1), "count must be a whole number >= 2"),
        (lambda: D.sample({"l1": (0, 1)}, 0), "count must be a whole number >= 1"),
        (lambda: D.sample({"l1": (0, 1)}, 5, seed=-1), "seed must be a whole number >= 0"),
    ],
)
def test_designs_that_do_not_go(asked, words):
    with pytest.raises(ValueError, match=words):
        asked()


def test_designs_are_no_array_and_no_letters():
    for source in (np.zeros(3), b"l1", 3.0):
        with pytest.raises(TypeError, match="designs must be columns by name, a file, or robots"):
            fb.sweep("bars", source)


def test_a_number_is_in_every_design():
    done = fb.sweep("bars", {"l1": [0.1, 0.2, 0.3], "l2": 0.15, "d": np.array(0.1)})
    np.testing.assert_allclose(done["bars"], [0.5, 0.7, 0.9], rtol=1e-15)
    assert len(done) == 3 and done["d"].tolist() == [0.1] * 3
    assert len(fb.sweep("bars", {"l1": 0.1})) == 1


# Robots of designs


def test_names_of_a_design_set_what_they_say():
    names = ("r1", "r2", "r3", "zz", "task_x", "task_y")
    row = np.array([0.1, 0.2, 0.05, 0.001, 0.03, 0.15])
    robot = robot_of_design(names, row, fb.FiveBar(m=0.4))
    assert robot == fb.FiveBar(0.1, 0.2, 0.1, 0.2, 0.1, 0.001, 0.001, 0.4)
    assert place_of_design(names, row[None]).tolist() == [[0.03, 0.15]]
    assert place_of_design(("l1", "task_y"), np.array([[0.1, 0.2]])).tolist() == [[0.0, 0.2]]
    columns = robots_of_designs(names, row[None], fb.FiveBar(m=0.4))
    assert float(columns.d[0, 0]) == 0.1 and columns.l21.shape == (1, 1)


def test_biglides_one_by_one():
    robots = [fb.Biglide(0.3, 0.35, 0.4), fb.Biglide(0.35, 0.35, 0.4)]
    done = fb.sweep(lambda robot: robot.l1, robots, robot=fb.Biglide(), workers=1)
    assert done["<lambda>"].tolist() == [0.3, 0.35] and done.robot_at(1) == robots[1]
    with pytest.raises(TypeError, match="designs must be robots as Biglide, or tables by name"):
        fb.sweep(lambda robot: robot.l1, [fb.FiveBar()], robot=fb.Biglide())


def test_a_biglide_has_no_shared_names():
    known = known_variables(fb.Biglide())
    assert {"l1", "l2", "d", "task_x", "task_y"} <= set(known)
    assert not {"r1", "r3", "l11"} & set(known) and known["l1"] == {"l1": 1.0}


@pytest.mark.parametrize("scale", [1.0, 1e-4, 1e5])
def test_designs_that_close_are_valid_at_any_size(scale):
    """A base may be 0; one bar longer than all others together never closes."""
    names = ("l1", "l2", "d")
    rows = np.array([[0.1, 0.1, 0.0], [0.1, 0.1, 0.39], [0.1, 0.1, 0.41], [0.1, np.nan, 0.1]])
    valid, errors = valid_rows(names, rows * scale, fb.FiveBar())
    assert valid.tolist() == [True, True, False, False]
    assert [k for k, _ in errors] == [2, 3]
    assert "can never close" in errors[0][1] and errors[1][1].startswith("l2 must be")


# Figures one by one


def test_the_largest_over_the_parts(monkeypatch):
    """A part may have more than is found, or no room for the margin; the rest is not asked."""
    asked = []

    def measure(part, margin):
        asked.append(part.area)
        if part.room <= margin:
            raise ValueError("no room")
        return part.gives - margin

    parts = [
        SimpleNamespace(area=area, room=room, gives=gives)
        for area, room, gives in (
            (1.0, 0.5, 0.95),
            (4.0, 0.5, 1.5),
            (9.0, 0.1, 8.0),
            (3.0, 0.5, 2.5),
        )
    ]
    monkeypatch.setattr(one_by_one, "_regions", lambda robot, task: parts)
    largest = _of_parts(measure, lambda area: area)
    assert largest(None, SimpleNamespace(margin=0.1), None) == pytest.approx(2.4)
    assert asked == [9.0, 4.0, 3.0]
    assert largest(None, SimpleNamespace(margin=0.5), None) == 0.0


def test_regions_of_the_working_mode(monkeypatch):
    """Aspects where nothing is to be kept; dexterous regions with what is."""
    robot = fb.FiveBar(0.12, 0.14, 0.12, 0.14, 0.1)
    called = []

    def parts(name):
        def found(of, **kept):
            assert of is robot
            called.append((name, kept))
            return [SimpleNamespace(working=modes, area=area) for modes, area in areas]

        return found

    areas = [((1, -1), 0.2), ((1, 1), 0.9), ((1, -1), 0.3)]
    for name in ("aspects", "dexterous"):
        monkeypatch.setattr(one_by_one, name, parts(name))
    area = D.FIGURES["dexterous_area"]
    assert area.of(robot, task_of({}), np.zeros(2)) == 0.3
    assert area.of(robot, task_of({"sin": 0.2}), np.zeros(2)) == 0.3
    assert area.of(robot, task_of({"det_A": 0.3}), np.zeros(2)) == 0.3
    assert called == [
        ("aspects", {}),
        ("dexterous", {"det_A": 0.0, "sin": 0.2}),
        ("dexterous", {"det_A": 0.3, "sin": 0.0}),
    ]
    areas = []
    assert area.of(robot, task_of({"sin": 0.2}), np.zeros(2)) == 0.0


@pytest.mark.parametrize(
    "figure, function, size",
    [("largest_disc", "largest_disc", 2.0), ("largest_rectangle",) * 2 + (3.0,)],
)
def test_discs_and_rectangles_keep_the_margin(figure, function, size, monkeypatch):
    """A part of an area has no disc larger than its own, and no rectangle larger than itself."""
    asked = []

    def largest(part, constraints):
        asked.append((part.area, constraints))
        return SimpleNamespace(radius=2.0, area=3.0)

    parts = [SimpleNamespace(area=area, clearance=1.0) for area in (13.0, 12.5, 2.9)]
    monkeypatch.setattr(one_by_one, "_regions", lambda robot, task: parts)
    monkeypatch.setattr(one_by_one, function, largest)
    assert D.FIGURES[figure].of(None, task_of({"margin": 0.25}), None) == size
    kept = fb.Constraints(clearance=0.25)
    areas = [13.0] if figure == "largest_disc" else [13.0, 12.5]
    assert asked == [(area, kept) for area in areas]


def test_the_inscribed_circle_is_of_symmetric_robots():
    for lengths in ((0.1, 0.2, 0.11, 0.2, 0.1), (0.1, 0.2, 0.1, 0.21, 0.1)):
        done = fb.sweep("inscribed_circle", [fb.FiveBar(*lengths)])
        assert "is of symmetric robots: l11 = l21 and l12 = l22" in done.errors[0][1]
        assert np.isnan(done["inscribed_circle"][0])


def test_bounds_of_figures_one_by_one():
    lengths = np.array([[3.0, 4, 5, 1], [2, 2, 9, 9]])
    robots = robots_of_designs(("l11", "l12", "l21", "l22"), lengths, fb.FiveBar())
    bounds = {
        "dexterous_area": np.pi * np.array([36.0, 16]),
        "largest_disc": [1.0, 2],
        "largest_rectangle": [72.0, 32],
        "inscribed_circle": [1.0, 2],
        "workspace_area": np.pi * np.array([36.0, 16]),
        "bars": [13.0, 22],
    }
    for name, bound in bounds.items():
        np.testing.assert_allclose(D.FIGURES[name].bound(robots, task_of({})), bound, rtol=1e-14)


def test_the_first_positive_root_of_any_row():
    a, v, c = (np.array(column, dtype=float) for column in ([1, 1, 0], [-5, 1, 2], [6, 1, -3]))
    assert _first_root(a, v, c) == 1.5  # 2 and 3, none, 1.5
    assert _first_root(a[:1], v[:1], c[:1]) == 2.0
    assert _first_root(a[1:2], v[1:2], c[1:2]) == np.inf
    assert _first_root(np.ones(1), np.full(1, 5.0), np.full(1, 6.0)) == np.inf  # both negative


def test_a_robot_too_heavy_for_its_motors_takes_for_ever():
    base = fb.FiveBar(0.1, 0.14, 0.1, 0.14, 0.1, m=2.0, gravity=(0.0, -9.81))
    choice = {"motion": fb.line((-0.01, 0), (0.01, 0), 1.0)}
    held = fb.igm(base, (0.0, 0.15), (1, -1))
    torque = np.abs(fb.inverse_dynamics(fb.ikm2(fb.ikm(held, (0, 0)), (0, 0)))).max()
    for share, finite in ((1.5, True), (0.7, False)):
        done = fb.sweep(
            "time", {"task_y": [0.15]}, robot=base, motor=(share * torque, 50.0), **choice
        )
        assert np.isfinite(done["time"][0]) == finite and not done.errors


def test_a_motion_through_type_2_is_none():
    robot = fb.FiveBar(0.1, 0.14, 0.1, 0.14, 0.1)
    y = np.linspace(-0.2, 0.2, 4001)
    pose = fb.igm(robot, np.stack([0 * y, y], axis=-1), (1, -1), unreachable="nan")
    crossing = y[:-1][pose.det_A[:-1] * pose.det_A[1:] < 0][0]
    done = fb.sweep(
        ["worst_torque", "worst_speed", "time"],
        {"task_y": [crossing, 0.15]},
        robot=robot,
        motion=fb.line((0, -0.01), (0, 0.01), 1.0),
        motor=(1.0, 50.0),
    )
    for name in done.figures:
        assert np.isfinite(done[name]).tolist() == [False, True]
        assert np.isnan(done[name][0])
        assert (0, f"{name}: SingularityError: the motion goes through Type 2") in done.errors


@pytest.mark.parametrize("proved", [True, False])
def test_a_path_that_was_not_timed_is_an_error_unless_it_is_proved(proved, monkeypatch):
    """What is proved infeasible takes for ever; what was not found in time is no figure."""

    def time_path(*args, **options):
        raise TimingError("not timed", 0.0, proved)

    monkeypatch.setattr(one_by_one, "time_path", time_path)
    done = fb.sweep(
        "path_time", {"task_y": [0.1]}, path=[(0, 0), (0.01, 0)], motor=(1, 1), workers=1
    )
    if proved:
        assert done["path_time"][0] == np.inf and not done.errors
    else:
        assert np.isnan(done["path_time"][0]) and "TimingError: not timed" in done.errors[0][1]


def test_motors_that_cannot_leave_the_start_take_for_ever():
    """They hold the robot at some places of the path, and at others no torque moves it on."""
    physics = dict(gravity=(0.0, -9.81), fv1=2e-3, fv2=2e-3, mx11=0.005, mx21=0.005)
    base = fb.FiveBar(d=0.07, m=0.4, **physics)
    square = [(-0.03, -0.03), (0.03, -0.03), (0.03, 0.03), (-0.03, 0.03), (-0.03, -0.03)]
    designs = {"l1": [0.152, 0.156, 0.158, 0.16], "l2": 0.16, "task_y": 0.15, "zz": 1e-3}
    task = dict(robot=base, path=fb.path(square), motor="xl430-w250", workers=1)
    done = fb.sweep("path_time", designs, **task)
    assert np.isfinite(done["path_time"]).tolist() == [True, False, False, False]
    assert not done.errors and np.isinf(done["path_time"][1:]).all()


def test_a_path_through_a_singularity_has_no_time(monkeypatch):
    def time_path(*args, **options):
        raise SingularityError("Type 2", 0.0)

    monkeypatch.setattr(one_by_one, "time_path", time_path)
    done = fb.sweep(
        "path_time", {"task_y": [0.1]}, path=[(0, 0), (0.01, 0)], motor=(1, 1), workers=1
    )
    assert np.isnan(done["path_time"][0])
    assert done.errors == ((0, "path_time: SingularityError: Type 2"),)


@pytest.mark.parametrize("value", [[0.1], np.zeros(2), b"1", None])
def test_a_figure_is_one_number(value):
    done = fb.sweep({"odd": lambda robot: value}, {"l1": [0.1]})
    assert "odd: TypeError: it must give one number" in done.errors[0][1]


def test_figures_have_names_and_units():
    figures = figures_of(["bars", "det_A"], task_of({"table": (1, 1)}), fb.FiveBar())
    assert [figure.label for figure in figures] == ["bars (m)", "det_A"]
    assert figures[0].about == {"name": "bars", "kind": "closed"}

    def size(robot):
        return robot.l11

    def other(robot):
        return robot.l12

    of = partial(figures_of, task=task_of({}), robot=fb.FiveBar())
    one, two = of({"size": size, "other": other})
    assert (one.name, one.kind, one.better, one.label) == ("size", "own", "large", "size")
    assert one.about["code"] != two.about["code"] and one.about["code"] == of(size)[0].about["code"]
    assert of(one) == of([one]) == of({"any": one}) == (one,)
    for request, words in (
        ({"": size}, "figure: a name must be a string, not ''"),
        ({"size": 3}, "figure must be a name, a function of a robot or a list of these, not 3"),
        (fb.FiveBar, "figure must be a name, a function of a robot or a list of these"),
    ):
        with pytest.raises(TypeError, match=words):
            of(request)
    with pytest.raises(ValueError, match="figure: size is asked for twice"):
        of(["bars", size, size])
    with pytest.raises(ValueError, match="needs path=.*: the least in which the motors can follow"):
        of("path_time")


def test_chunks_and_workers_of_a_sweep(monkeypatch):
    """What takes long is computed a few designs at a time; what is short by this process alone."""
    asked = []
    monkeypatch.setattr(D.Sweep, "compute", lambda *given: asked.append(given))

    def own(robot):
        return robot.l11

    for figures, count, options in (
        ("bars", 4000, {}),
        ("bars", 4001, {}),
        (["bars", own], 10, {}),
        (["bars", own], 11, {}),
        ("bars", 30, {"workers": 3}),
        ("bars", 4001, {"chunk": 7, "workers": 2}),
    ):
        fb.sweep(figures, D.sample({"l1": (0.1, 0.2)}, count), **options)
    assert [given[5] for given in asked] == [1, None, 1, None, 3, 2]
    assert [given[3]["chunk"] for given in asked] == [1000, 1000, 10, 10, 1000, 7]
    assert [given[2] for given in asked] == [4000, 4001, 10, 11, 30, 4001]
    assert asked[0][3]["variables"] == ["l1"] and asked[0][3]["robot"]["kind"] == "FiveBar"


def test_a_file_of_designs_has_units_and_columns_of_figures(tmp_path):
    text = "design;l1 (mm);task_y (cm);zz1;bars;det_A\n0;100;12;0.001;0.4;0.5\n1;120;13;0.002;1;1\n"
    (tmp_path / "designs.csv").write_text(text, "utf-8")
    done = fb.sweep("bars", tmp_path / "designs.csv")
    assert done.design(1) == pytest.approx({"l1": 0.12, "task_y": 0.13, "zz1": 0.002})
    (tmp_path / "designs.csv").write_text("design,bars\n0,0.4\n", "utf-8")
    with pytest.raises(ValueError, match="no column is known; the parameters of a design are l1"):
        fb.sweep("bars", tmp_path / "designs.csv")


def test_errors_are_in_the_order_of_the_designs():
    """Those of robots that do not close and those of figures are one list."""

    def odd(robot):
        return 1 / (robot.d - 0.1)

    done = fb.sweep(odd, {"d": [0.1, 9.0, 0.1, 8.0, 0.2]}, workers=1)
    assert [k for k, _ in done.errors] == [0, 1, 2, 3]
    assert np.isfinite(done["odd"]).tolist() == [False] * 4 + [True]


# Poses of a task


def test_nodes_of_a_table_and_of_a_disc():
    table = task_of({"table": (-1, 2, 3, 5), "poses": (4, 3)})
    points, weights, polar = table.nodes
    assert points.tolist() == [[x, y] for y in (3, 4, 5) for x in (-1, 0, 1, 2)]
    expected = np.outer([1, 2, 1], [1, 2, 2, 1]).ravel() / 24
    np.testing.assert_allclose(weights, expected, rtol=1e-15)
    assert np.isnan(polar).all()
    disc = task_of({"disc": (1, 2, 3), "poses": (3, 4)})
    points, weights, polar = disc.nodes
    x, y = points.T
    np.testing.assert_allclose(np.hypot(x - 1, y - 2), [0, 1.5, 3] * 4, atol=1e-15)
    angles = np.arctan2(y - 2, x - 1).reshape(4, 3)[:, 2]
    np.testing.assert_allclose(angles % (2 * np.pi), np.arange(4) * np.pi / 2, atol=1e-15)
    np.testing.assert_allclose(weights, [0, 0.125, 0.125] * 4, rtol=1e-15)
    np.testing.assert_allclose(polar, [0.0625, 0.125, 0.0625] * 4, rtol=1e-15)


def test_the_worst_tip_error_is_at_a_corner_of_the_tolerances():
    """By the derivatives of the direct model, with each tolerance as the largest in turn."""
    rng = np.random.default_rng(8)
    corners = np.array(np.meshgrid(*[(-1, 1)] * 7)).reshape(7, -1)
    step = 1e-6
    for size in ({"l": 0.001}, {"d": 0.001}, {"q": 0.01, "l": 0.001, "d": 0.004}):
        lengths = rng.uniform(0.09, 0.15, (3, 5))
        lengths[:, 4] /= 2
        robots = [fb.FiveBar(*row) for row in lengths]
        choices = {"table": (0.02, 0.02), "poses": 2, "tolerances": size}
        found = fb.sweep(
            "worst_tip_error",
            {name: column for name, column in zip(("l11", "l12", "l21", "l22", "d"), lengths.T)}
            | {"task_y": 0.14},
            **choices,
        )["worst_tip_error"]
        t = {"q": 0.0, "l": 0.0, "d": 0.0} | size
        tolerances = np.array([t["l"]] * 4 + [t["d"]] + [t["q"]] * 2)
        points = np.array([(x, y) for x in (-0.01, 0.01) for y in (0.13, 0.15)])
        for row, robot, worst in zip(lengths, robots, found):
            pose = fb.igm(robot, points, (1, -1))
            moved = []
            for k in range(7):
                change = step * np.eye(7)[k]
                ends = [
                    fb.dgm(fb.FiveBar(*(row + e[:5])), pose.q + e[5:], pose.assembly).xi
                    for e in (change, -change)
                ]
                moved.append((ends[0] - ends[1]) / (2 * step) * tolerances[k])
            errors = np.einsum("kpx,kc->pcx", np.array(moved), corners)
            assert worst == pytest.approx(np.linalg.norm(errors, axis=2).max(), rel=1e-6)


def test_a_corner_on_type_2_is_not_worked_in():
    """Legs of 3-4-5 triangles whose distal bars are in line to the last bit in one corner."""
    lengths = {"l1": [4.0], "l2": [3.0], "d": [6.0], "task_y": [4.0]}
    names = ["footprint", "det_A", "tip_force", "reach", "worst_tip_error"]
    task = dict(poses=2, motor=(1.0, 1.0), tolerances={"q": 1e-3})
    done = fb.sweep(names, lengths, table=(0, 0.1, 0, 0.1), **task)
    assert (
        done["reach"][0] > 0
        and np.isnan([done[name][0] for name in names if name != "reach"]).all()
    )
    done = fb.sweep(names, lengths, table=(0, 0.1, 1e-6, 0.1), **task)
    assert np.isfinite(done["footprint"][0]) and 0 < done["det_A"][0] < 1e-6


@pytest.mark.parametrize(
    "choice,words",
    [
        ({"poses": (3,)}, "poses must be 2 numbers"),
        ({"disc": (0, 1)}, "disc must be 3 numbers"),
        ({"table": 0.2}, "table must be 2 or 4 numbers"),
        ({"table": (1, 1), "poses": (2000, 501)}, r"poses: at most 10\^6 nodes, not 2000 x 501"),
        ({"motion": lambda t: t}, "motion must be a trajectory with a start and a duration"),
        ({"tolerances": {}}, "tolerances must be a table"),
        ({"tolerances": {"q": -1}}, r"tolerances\[q\] must be"),
        ({"path": [(0, 0)]}, "path: "),
    ],
)
def test_tasks_that_do_not_go(choice, words):
    with pytest.raises((ValueError, TypeError), match=f"^{words}"):
        task_of(choice)


def motion_of(parts):
    def motion(t):
        return parts(t)

    motion.start, motion.duration = 1.0, 2.0
    return motion


@pytest.mark.parametrize(
    "parts,words",
    [
        (lambda t: 1 / 0 if t is None else [np.zeros((len(t), 2))] * 2, "finite and"),
        (lambda t: [np.full((len(t), 2), np.nan)] * 3, "finite and"),
        (lambda t: [["x"]] * 3, "for times"),
    ],
)
def test_motions_that_do_not_go(parts, words):
    with pytest.raises(ValueError, match=f"motion.t. must give xi, xi', xi'',? {words}"):
        task_of({"motion": motion_of(parts)})


def test_a_motion_is_sampled_from_its_start():
    task = task_of(
        {"motion": motion_of(lambda t: [np.stack([t, k * t], axis=1) for k in (0, 1, 2)])}
    )
    duration, xi, _, xi_ddot = task.motion
    assert duration == 2.0 and len(xi) == 201
    np.testing.assert_allclose(xi[:, 0], np.linspace(1, 3, 201))
    np.testing.assert_allclose(xi_ddot[:, 1], 2 * xi[:, 0])
    assert task_of({"motion": task.motion}).motion is task.motion
    assert task.about["motion"]["duration"] == 2.0
    other = task_of({"motion": motion_of(lambda t: [np.stack([t, t], axis=1)] * 3)})
    assert other.about["motion"]["sha256"] != task.about["motion"]["sha256"]


def test_a_task_says_what_it_was_given():
    task = task_of({"table": (0.2, 0.1), "poses": 5, "tolerances": {"q": 0.001, "l": 0}})
    assert repr(task) == (
        "<Task: poses = (5, 5), table = (-0.1, 0.1, -0.05, 0.05), tolerances = (q 0.001)>"
    )
    path = task_of({"path": [(0, 0), (0.03, 0.04)]})
    assert path.about["path"]["length"] == pytest.approx(0.05)


# The rules of a search


def problem_of(goals, bounds, limits=None, step=None, **choices):
    return DesignProblem(goals, bounds, limits or {}, fb.FiveBar(), step, task_of(choices), None)


BOUNDS = {"l1": (0.1, 0.3), "l2": (0.1, 0.3), "d": (0.0, 0.2)}


def test_goals_are_to_be_small_and_violations_are_shares_of_their_limits():
    limits = {"workspace_area": (0.5, None), "bars": (None, 0.4)}
    problem = problem_of(["workspace_area", "bars"], BOUNDS, limits)
    x = np.array([[0.1, 0.1, 0.0], [0.1, 0.25, 0.0], [0.3, 0.3, 0.0]])
    goals, violation = problem(x)
    area = np.pi * np.array([0.2**2, 0.35**2 - 0.15**2, 0.6**2])
    np.testing.assert_allclose(goals, np.stack([-area, [0.4, 0.7, 1.2]], axis=1), rtol=1e-12)
    expected = np.maximum(0.5 - area, 0) / 0.5 + np.array([0, 0.3, 0.8]) / 0.4
    np.testing.assert_allclose(violation, expected, rtol=1e-12, atol=1e-15)


def test_a_limit_of_0_counts_by_metres():
    goals, violation = problem_of("bars", BOUNDS, {"bars": (None, 0.0)})(np.array([[0.1, 0.2, 0]]))
    assert violation[0] == pytest.approx(0.6) and goals[0, 0] == pytest.approx(0.6)


def test_what_is_no_robot_is_worse_than_any_violation():
    problem = problem_of("bars", {"l1": (0.1, 0.2), "d": (0.0, 9.0)}, {"bars": (5.0, None)})
    goals, violation = problem(np.array([[0.1, 0.1], [0.1, 8.0]]))
    assert 0 < violation[0] < 1 and violation[1] == 10.0
    assert goals[1].tolist() == [0.0]


def test_a_goal_that_is_infinite_is_lost_too():
    """10 is above the violations of ordinary limits; what else is violated counts beside it, here
    det_A.
    """
    choices = {"table": (0.02, 0.02), "poses": 3}
    problem = problem_of("footprint", {"l1": 0.1, "task_y": (0.1, 9.0)}, **choices)
    x = np.array([[0.1, 0.12], [0.1, 5.0]])
    goals, violation = problem(x)
    reach = problem.values(x)["reach"]
    assert violation[0] == 0 and np.isfinite(goals).all()
    assert reach[1] < -4 and violation[1] == pytest.approx(20 - reach[1] / 0.02)


def test_designs_are_put_on_steps_and_bounds():
    problem = problem_of("bars", {"l1": (0.1003, 0.2008), "zz1": (0.0, 0.01)}, step=0.001)
    assert (problem.low[0], problem.high[0]) == pytest.approx((0.101, 0.2))
    rows = problem.rows(np.array([[0.10149, 0.00333], [0.15051, 1e-12]]))
    np.testing.assert_allclose(rows, [[0.101, 0.00333], [0.151, 0.0]], rtol=0, atol=1e-15)
    free = problem_of("bars", {"l1": (0.1, 0.3)})
    near = np.array([[0.1 + 1e-10], [0.3 - 1e-10], [0.1 + 3e-10], [0.3 - 3e-10]])
    assert free.rows(near).ravel().tolist() == [0.1, 0.3, 0.1 + 3e-10, 0.3 - 3e-10]
    exact = problem_of("bars", {"l1": (0.1, 0.3)}, step=0.1)  # 0.3 / 0.1 < 3
    assert (exact.low[0], exact.high[0]) == pytest.approx((0.1, 0.3))


def test_what_binds_a_design():
    """Bounds at, or a step from, which it is; limits at which it is or that a step violates."""
    limits = {"bars": (0.5, 1.0)}
    on_steps = problem_of("workspace_area", BOUNDS, limits, step=0.01)
    found = on_steps.design_of(np.array([0.29, 0.2, 0.0]))
    assert found.binding == (
        "l1 = 0.29 is a step from its upper bound 0.3",
        "d = 0 is at its lower bound 0",
        "bars = 0.98 is less than a step from its limit, at most 1",
    )
    assert on_steps.design_of(np.array([0.15, 0.11, 0.1])).binding == (
        "l2 = 0.11 is a step from its lower bound 0.1",
        "bars = 0.52 is less than a step from its limit, at least 0.5",
    )
    free = problem_of("workspace_area", BOUNDS, limits)
    assert free.design_of(np.array([0.2999, 0.2001, 0.1])).binding == (
        "l1 = 0.2999 is at its upper bound 0.3",
        "bars = 1 is at its limit, at most 1",
    )
    assert free.design_of(np.array([0.25, 0.2, 0.1])).binding == ()
    fixed = problem_of("workspace_area", {"l1": 0.1, "l2": (0.1, 0.3)})
    assert fixed.design_of(np.array([0.1, 0.2])).binding == ()


def test_a_design_at_the_edge_of_its_reach_says_so():
    bounds = {"l1": (0.05, 0.3), "l2": (0.05, 0.3), "task_y": (0.0, 0.3)}
    choices = {"table": (0.1, 0.06), "poses": 3}
    problem = problem_of("bars", bounds, **choices)
    far = np.hypot(0.05 + problem.robot.d / 2, 0.13)  # an upper corner from the other base joint
    near_edge = problem.design_of(np.array([far / 2, far / 2 + 1e-5, 0.1]))
    assert near_edge.binding[0].startswith("reach = ") and len(near_edge.binding) == 1
    assert near_edge.binding[0].endswith(" is near its limit, at least 0")
    assert problem.design_of(np.array([far / 2, far / 2 + 1e-2, 0.1])).binding == ()
    on_steps = problem_of("bars", bounds, step=0.01, **choices)
    at_step = on_steps.design_of(np.array([0.1, np.ceil(100 * far) / 100 - 0.1, 0.1]))
    assert any(line.startswith("reach = ") for line in at_step.binding)


def test_what_no_robot_within_the_bounds_passes():
    found = problem_of({"workspace_area": "max", "bars": "min"}, BOUNDS)
    one = found.design_of(np.array([0.2, 0.2, 0.0]))
    assert one.unreached_bounds == pytest.approx({"workspace_area": np.pi * 0.36, "bars": 0.4})
    assert one.gaps == pytest.approx({"workspace_area": 1 - 0.16 / 0.36, "bars": 1.0})
    other = problem_of({"workspace_area": "min"}, BOUNDS).design_of(np.array([0.2, 0.2, 0.0]))
    assert other.unreached_bounds == {}
    assert "of workspace_area no bound is known" in other.report
    assert "no bound and no limit binds" not in other.report
    assert repr(other) == "<Design: workspace_area = 0.502655 m², l1 = 0.2, l2 = 0.2, d = 0>"


@pytest.mark.parametrize("goals", ["workspace_area", ["workspace_area", "bars"]])
def test_a_search_is_the_same_with_the_same_seed_alone(goals):
    """Few generations are far from done, so that another seed is seen."""

    def found(seed):
        done = fb.design(
            goals,
            {"l1": (0.1, 0.2), "l2": (0.1, 0.2), "d": (0.01, 0.1)},
            limits={"bars": 0.55},
            points=4,
            effort=0.01,
            seed=seed,
        )
        return [one.parameters for one in getattr(done, "designs", [done])]

    assert found(3) == found(3) != found(4)


def test_discs_that_almost_touch():
    """Rounding leaves no area without a number, from within or from outside."""
    r1, r2 = np.random.default_rng(0).uniform(0.1, 1.0, (2, 4000))
    within = _lens(r1, r2, np.nextafter(np.abs(r1 - r2), 2))
    np.testing.assert_allclose(within, np.pi * np.minimum(r1, r2) ** 2, rtol=1e-6)
    np.testing.assert_allclose(_lens(r1, r2, np.nextafter(r1 + r2, 0)), 0.0, atol=1e-9)


def test_a_design_has_the_place_of_its_task():
    placed = problem_of("bars", {"l1": (0.1, 0.2), "task_y": (0.1, 0.3)})
    assert placed.design_of(np.array([0.15, 0.2])).place.tolist() == [0.0, 0.2]


def test_an_executor_gets_pieces_of_five_designs():
    """Closed forms are computed here, whatever executor there is."""
    calls = []

    class Counted(ThreadPoolExecutor):
        def submit(self, function, *args, **options):
            calls.append(function)
            return super().submit(function, *args, **options)

    x = np.full((17, 1), 0.1)
    with Counted(1) as executor:
        for goal, pieces in (("bars", 0), (lambda robot: robot.l11, 3)):
            calls.clear()
            task = task_of({})
            problem = DesignProblem(
                goal, {"l1": (0.1, 0.2)}, {}, fb.FiveBar(), None, task, executor
            )
            assert len(problem(x)[0]) == 17 and len(calls) == pieces
        calls.clear()
        fb.design(lambda robot: robot.l11, {"l1": (0.1, 0.2)}, executor=executor, effort=0.01)
        assert len(calls) >= 4 * 4  # four generations of twenty, the first one among them


def test_the_nearest_design_and_what_it_violates_are_told():
    cases = [
        (dict(limits={"bars": (9.0, 10.0)}), "bars = 0.8, not from 9 to 10"),
        (dict(limits={"bars": (None, 0.1)}), "bars = 0.8, not from -inf to 0.1"),
        (dict(table=(0.9, 0.9), poses=5), "the table is out of reach by 0.[0-9]+ m"),
        (dict(table=(0.1, 0.1), poses=5), "a Type-2 singularity crosses the table"),
    ]
    for choices, words in cases:
        with pytest.raises(ValueError, match=f"the nearest, l1 = 0.2, l2 = 0.2.*: {words}"):
            fb.design("bars", {"l1": 0.2, "l2": 0.2}, **choices)


# Evolution


def test_limits_come_before_goals():
    better, worse = np.array([1.0, 1.0]), np.array([2.0, 2.0])
    for violations, expected in (((0, 0), True), ((1, 0), False), ((0, 1), True), ((2, 1), False)):
        assert dominates(better, violations[0], worse, violations[1]) == expected
    assert not dominates(better, 0.0, better, 0.0)
    assert dominates(worse, 1.0, better, 2.0) and not dominates(worse, 1.0, better, 1.0)


def test_the_best_are_front_by_front():
    rng = np.random.default_rng(5)
    f = rng.uniform(size=(40, 2))
    none = np.zeros(40)
    rank = np.zeros(40, dtype=int)
    left = set(range(40))
    level = 0
    while left:
        front = {
            i for i in left if not any((f[j] <= f[i]).all() and (f[j] < f[i]).any() for j in left)
        }
        rank[list(front)] = level
        left -= front
        level += 1
    for count in (1, 7, 20, 39, 40):
        chosen = best(f, none, count)
        assert len(set(chosen)) == count == len(chosen)
        rest = np.setdiff1d(np.arange(40), chosen)
        assert rank[chosen].max() <= rank[rest].min(initial=99)


@pytest.mark.parametrize("goals", [2, 3])
def test_a_front_is_thinned_where_it_is_crowded(goals):
    """Of points on a grid and of twins beside some of them, the twins go."""
    if goals == 2:
        s = np.linspace(0, 1, 9)
        grid = np.stack([s, 1 - s], axis=1)
    else:
        steps = [(i, j, 4 - i - j) for i in range(5) for j in range(5 - i)]
        grid = np.array(steps) / 4
    twins = grid[[3, 5]] + 1e-3 * np.eye(goals)[[0, 0]] - 1e-3 * np.eye(goals)[[1, 1]]
    front = np.vstack([grid, twins]) * 7.0 + 100.0
    chosen = thinned(front, np.arange(len(front)), len(grid))
    kept = np.array(chosen)
    distances = np.linalg.norm(front[kept][:, None] - front[kept], axis=2) + 9 * np.eye(len(kept))
    assert len(set(chosen)) == len(grid) and distances.min() > 0.5
    assert set(front.argmin(axis=0)) <= set(chosen)


def test_a_population_stays_within_bounds_and_keeps_limits():
    """The optimum lies in a corner and on a limit; after few generations it is found."""
    low, high = np.array([-1.0, 2.0]), np.array([3.0, 2.5])
    seen = []

    def evaluate(x):
        seen.append(x.copy())
        f = np.stack([(x[:, 0] + 1) ** 2 + (x[:, 1] - 2.5) ** 2, (x[:, 0] - 3) ** 2], axis=1)
        return f, np.maximum(1.0 - x[:, 0], 0)

    generations = []
    x, f, violation = evolve(
        evaluate, low, high, 30, 25, np.random.default_rng(0), lambda: generations.append(1)
    )
    everything = np.concatenate(seen)
    # What is beyond a bound is reflected and not put on it.
    assert ((everything > low) & (everything < high)).all() and len(everything) == 26 * 30
    assert len(generations) == 25 and x.shape == (30, 2) and (violation == 0).all()
    assert x[:, 0].min() == pytest.approx(1.0, abs=0.05) and x[:, 0].max() > 2.9
    assert np.median(np.abs(x[:, 1] - 2.5)) < 0.1
    cells = np.floor((seen[0] - low) / (high - low) * 30)
    assert (np.sort(cells, axis=0) == np.arange(30)[:, None]).all()  # a Latin hypercube


def test_what_is_as_good_in_another_way_joins_the_population():
    """Of a line on which none is better than another the ends are approached."""

    def evaluate(x):
        return np.hstack([x, -x]), np.zeros(len(x))

    def to_the_ends(generations):
        rng = np.random.default_rng(3)
        x, _, _ = evolve(evaluate, np.zeros(1), np.ones(1), 20, generations, rng)
        return max(x.min(), 1 - x.max())

    assert to_the_ends(20) < 0.3 * to_the_ends(0)


# Fronts


def front_of(pairs):
    problem = problem_of({"workspace_area": "max", "bars": "min"}, BOUNDS, poses=(7, 5), sin=0.25)
    return Front(tuple(problem.design_of(np.array([l1, l2, 0.0])) for l1, l2 in pairs))


def test_a_front_says_its_ranges_and_has_its_knee(tmp_path):
    front = front_of([(0.1, 0.1), (0.14, 0.14), (0.3, 0.3)])
    area = np.pi * np.array([0.04, 0.0784, 0.36])
    bars = np.array([0.4, 0.56, 1.2])
    assert repr(front) == (
        f"<Front: 3 designs, workspace_area from {area[0]:.6g} to {area[2]:.6g} m²,"
        " bars from 0.4 to 1.2 m>"
    )
    away = np.hypot((area[2] - area) / np.ptp(area), (bars - 0.4) / 0.8)
    assert front.knee is front.designs[int(np.argmin(away))]
    front.to_csv(tmp_path / "front.csv")
    lines = (tmp_path / "front.csv").read_text("utf-8").splitlines()
    assert '"goals": {"workspace_area": "max", "bars": "min"}' in lines[0]
    assert lines[1] == "l1,l2,d,workspace_area,bars"
    cells = np.array([line.split(",") for line in lines[2:]], dtype=float)
    np.testing.assert_allclose(cells[:, 3:], np.stack([area, bars], axis=1), rtol=1e-12)
    assert front["l1"].tolist() == [0.1, 0.14, 0.3] and front.robots[1].l11 == 0.14


def test_a_front_is_kept_in_a_folder(monkeypatch, tmp_path):
    """Its robots are numbered from 01; those of a longer front that was there before are gone."""
    for name in ("plot", "page"):
        monkeypatch.setattr(Front, name, lambda front, file: file.write_text("drawn", "utf-8"))
    longer = front_of([(0.1, 0.1), (0.14, 0.14), (0.3, 0.3)])
    longer.save(str(tmp_path / "front"))
    (tmp_path / "front" / "robots" / "mine.json").write_text("{}", "utf-8")
    front = front_of([(0.1, 0.1), (0.2, 0.2)])
    front.save(tmp_path / "front")
    robots = sorted((tmp_path / "front" / "robots").iterdir())
    assert [file.name for file in robots] == ["01.json", "02.json", "mine.json"]
    assert fb.load_robot(robots[1]) == front.robots[1]
    assert {file.name for file in (tmp_path / "front").iterdir() if file.is_file()} >= {
        "front.json",
        "front.csv",
        "front.png",
        "index.html",
    }
    again = Front.load(tmp_path / "front")
    assert again.designs[1].task.about == {"poses": [7, 5], "sin": 0.25}
    assert again.robots == front.robots and repr(again) == repr(front) and len(again) == 2
    assert [one.as_json() for one in again.designs] == [one.as_json() for one in front.designs]


@pytest.mark.parametrize(
    "change,words",
    [
        ({"what": "a cake"}, "it is of 'a cake'"),
        ({"designs": []}, "it has none"),
        ({"choices": {"table": 1}}, "table must be"),
    ],
)
def test_a_file_of_designs_that_was_changed_is_refused(change, words, tmp_path):
    file = tmp_path / "one.json"
    front_of([(0.1, 0.1)]).designs[0].save(file)
    file.write_text(json.dumps(json.loads(file.read_text("utf-8")) | change), "utf-8")
    with pytest.raises(ValueError, match=f"one.json is not what a design left there .*{words}"):
        D.Design.load(file)


@pytest.mark.parametrize(
    "part,value,words",
    [
        ("goals", {"area": "max"}, "are not of the same figures"),
        ("units", {}, "are not of the same figures"),
        ("unreached_bounds", {"reach": 1.0}, "are not of the same figures"),
        ("parameters", {"l1": "long"}, "parameters"),
        ("values", 3, "values"),
        ("binding", "all", "binding"),
        ("robot", {"l11": -1}, "l11"),
    ],
)
def test_a_design_that_was_changed_is_refused(part, value, words, tmp_path):
    file = tmp_path / "one.json"
    front_of([(0.1, 0.1)]).designs[0].save(file)
    about = json.loads(file.read_text("utf-8"))
    about["designs"][0][part] = value
    file.write_text(json.dumps(about), "utf-8")
    with pytest.raises(ValueError, match=f"one.json is not what a design left there .*{words}"):
        D.Design.load(file)


def test_the_best_designs_of_a_sweep():
    done = fb.sweep(
        {"odd": lambda robot: robot.l11 if robot.l11 < 0.25 else np.nan},
        {"l1": [0.2, 0.1, 0.3, 0.2]},
    )
    assert done.best(count=9).tolist() == [0, 3, 1] and done.best().tolist() == [0]
    assert done.best("odd", 2, "min").tolist() == [1, 0]
    with pytest.raises(ValueError, match="figure: 'bars' was not swept; odd were"):
        done.best("bars")
    with pytest.raises(ValueError, match="number must be at most 3, not 4"):
        done.design(4)
    placed = fb.sweep("bars", {"l1": [0.1, 0.2], "task_y": [0.3, 0.4], "l2": [0.15, 0.2]})
    assert placed.place_at(1).tolist() == [0.0, 0.4] and placed.robot_at(0).l12 == 0.15
