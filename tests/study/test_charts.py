"""A bit of each chart of speed against accuracy, and the orders that its methods show."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.study.control_cases import case
from fivebar.study.pitfalls.sampled import spectral_radius
from fivebar.study.speed_accuracy import findings, making
from fivebar.study.speed_accuracy.chart import OURS, Failed, load
from fivebar.study.speed_accuracy.charts import (
    chip,
    contours,
    derivatives,
    geometry,
    integrators,
    motions,
    stability,
    trackers,
)
from fivebar.study.speed_accuracy.findings import observed_order, orders
from fivebar.study.speed_accuracy.runner import measure, row_of
from fivebar.study.speed_accuracy.store import COLUMNS, Result
from tests.benchmarks import chip as arm_chip
from tests.benchmarks import routes
from tests.benchmarks.charts import ALL
from tests.benchmarks.gains import exact_noise_gain, noise_gain
from tests.helpers import needs


def test_observed_order():
    steps = 2.0 ** -np.arange(12)
    for order in (1, 2, 4, 8):
        errors = steps**order
        assert observed_order(steps, errors, 1e-16) == pytest.approx(order)
        assert observed_order(steps, errors + 1e-12 / steps, 1e-16) == pytest.approx(
            order, abs=0.1
        )  # rounding grows
        assert observed_order(steps[::-1], np.maximum(errors, 1e-9)[::-1], 1e-9) == pytest.approx(
            order
        )
    assert np.isnan(observed_order([1.0], [1.0], 0.0)) and np.isnan(
        observed_order(steps, 0 * steps + 1.0, 1.0)
    )


def measured_order(chart, problem, name, panel, knobs):
    rows = []
    method = chart.method(name)
    for knob in knobs or method.knobs_of(problem, quick=False):
        attempt = method.prepare(problem, knob)
        row = dict.fromkeys(COLUMNS, 0.0) | {
            "problem": problem,
            "method": name,
            "knob": knob,
            "status": "ok",
        }
        rows.append(row | attempt.judge(attempt.call()))
    return orders(Result(chart, {}, rows), panel)[name]


@pytest.mark.every(2)
@pytest.mark.parametrize(
    "name, knobs",
    [
        ("fivebar: order 8, four bars, VM", slice(None)),
        ("explicit Euler, Python", slice(6)),
        ("semi-implicit Euler, Python", slice(6)),
        ("RK4, Python", slice(6)),
        ("redundant DAE, RK4, Python", slice(6)),
        ("CasADi collocation, Radau of degree 3", slice(None)),
        pytest.param("fivebar: order 8, task chart, compiled", slice(1, 6), marks=pytest.mark.deep),
        pytest.param("fivebar: RK4, four bars, compiled", slice(4, 10, 2), marks=pytest.mark.deep),
        pytest.param("fivebar.simulate: steps of order 8", slice(None), marks=pytest.mark.deep),
        pytest.param("redundant DAE, Baumgarte 10/s", slice(4, 8), marks=pytest.mark.deep),
        pytest.param("redundant DAE, Baumgarte 1/step", slice(3, 7), marks=pytest.mark.deep),
    ],
)
def test_integrators_have_their_orders(name, knobs, compiler):
    chart = integrators.chart()
    method = chart.method(name)
    order = measured_order(
        chart, "regular", name, chart.panels[0][0], method.knobs_of("regular", False)[knobs]
    )
    assert order == pytest.approx(method.order, abs=0.1)


@pytest.mark.parametrize("row, column", [(0, 0), (0, 1)])
def test_differences_have_their_orders(row, column):
    chart = derivatives.chart()
    for method in (m for m in chart.methods if m.order):
        order = measured_order(chart, "swing", method.name, chart.panels[row][column], None)
        assert order == pytest.approx(method.order, abs=0.1), method.name


def test_contours_have_their_order():
    chart = contours.chart()
    knobs = (100, 200, 400)
    assert measured_order(
        chart, "task", "grid by NumPy, contoured", chart.panels[0][0], knobs
    ) == pytest.approx(2, abs=0.1)


def judged_at(chart, problem, name, knob):
    attempt = chart.method(name).prepare(problem, knob)
    return attempt.judge(attempt.call())


MODULES = chip, contours, derivatives, geometry, integrators, stability, trackers


@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.__name__.rpartition(".")[2])
def test_a_chart_says_what_its_axes_are(module):
    """Its panels are of its problems, with a unit on each axis, and levels from coarse to fine."""
    chart = module.chart()
    for panel in chart.all_panels:
        assert panel.problem in chart.problems and panel.title
        without_unit = "error", "instructions", "|det A|"
        for label in (panel.xlabel, panel.ylabel):
            assert "(" in label or "in parts of" in label or label.startswith(without_unit)
        assert panel.x in ("seconds", "knob", "instructions", "det_A", "inverse_sigma")
        assert ("time" in panel.xlabel.split()) == (panel.x == "seconds")
        assert list(panel.levels) == sorted(panel.levels, reverse=True)
        assert panel.floor < panel.rounding <= 1e-15
    names = [method.name for method in chart.methods]
    assert len(set(names)) == len(names) and any(each.family == OURS for each in chart.methods)
    assert {problem for problem, _, _ in chart.jobs(quick=True)} == set(chart.problems)
    for method in chart.methods:
        assert bool(method.needs) == ("compiled" in method.name or "C loop" in method.name)


def test_an_error_as_large_as_the_robots_task_is_a_failure():
    """A centimetre at the end, a millimetre of a bar; a tenth of these may count."""
    (regular, _), (_, bars) = integrators.chart().panels
    assert 1e-2 <= regular.ceiling < 0.1 and 1e-4 < bars.ceiling <= 1e-2
    assert all(panel.ceiling == 0.1 for panel in trackers.chart().all_panels)


INTEGRATED = [
    method.name
    for method in integrators.chart().methods
    if not method.needs and method.order is None or "Baumgarte" in method.name
]


@pytest.mark.parametrize("name", INTEGRATED)
def test_integrators_come_nearer_with_their_knob(name):
    method = integrators.chart().method(name)
    knobs = method.knobs_of("regular", quick=False)
    rough, fine = (judged_at(integrators.chart(), "regular", name, knobs[k]) for k in (1, 3))
    assert rough["error"] < 1e-3 and rough["energy"] < 1e-2 and rough["closure"] < 1e-5
    for name in ("error", "energy"):
        assert fine[name] < max(0.5 * rough[name], 1e-11)


def test_what_does_not_end_is_told_from_what_gives_up(monkeypatch):
    """Past Type 2 joint coordinates end: a solver gives up there, or is cut off before."""
    name = "SciPy DOP853, Python model"
    with pytest.raises(Failed, match="gives up"):
        judged_at(integrators.chart(), "through", name, 0.01)
    monkeypatch.setattr(integrators, "MOST_EVALUATIONS", 60)
    with pytest.raises(Failed, match="comes to no end"):
        judged_at(integrators.chart(), "regular", name, 0.01)


def test_loci_drawn_by_any_grid_are_alike():
    """The closed form is the reference, within a millionth of the robot; grids of one size differ by rounding."""
    chart = contours.chart()
    exact = judged_at(chart, "task", "fivebar.singularity_loci: closed form", 0)
    assert exact["rms"] < 1e-15 and exact["error"] < 1e-5 and 1e-8 < exact["missing"] < 1e-5
    names = [method.name for method in chart.methods if not method.needs and method.order == 2]
    by_numpy, by_vm = (judged_at(chart, "task", name, 25) for name in names)
    for name, value in by_numpy.items():
        assert by_vm[name] == pytest.approx(value, rel=1e-6) and value > 1e-4


def test_grids_are_compiled_where_they_say_so(monkeypatch):
    calls = []

    def noted(function, jit):
        calls.append(bool(jit))
        return function

    monkeypatch.setattr(contours, "compiled", noted)
    chart = contours.chart()
    for name in ("grid by CasADi VM, contoured", "grid by compiled C, contoured"):
        calls.clear()
        chart.method(name).prepare("task", 25)
        assert set(calls) == {"compiled C" in name}


def test_models_and_differentiated_positions_are_exact():
    chart = derivatives.chart()
    for method in (m for m in chart.methods if not m.order and not m.needs):
        found = judged_at(chart, "swing", method.name, 0)
        assert max(found.values()) < 5e-15, method.name


def test_controllers_are_as_good_as_their_panels_say():
    """The tracker comes to the finest level of its panel, within ten times; PD is worse than computed torque."""
    chart = trackers.chart()
    tracker, computed, pd = (method.name for method in chart.methods[:3])
    finest = {panel.problem: panel.levels[-1] for panel in chart.all_panels}
    errors = {
        problem: judged_at(chart, problem, tracker, 5)["error"]
        for problem in ("task-1", "torque-limit")
    }
    for problem, error in errors.items():
        assert 0.1 < error / finest[problem] < 10
    stiff, soft = (judged_at(chart, "task-1", computed, knob)["error"] for knob in (20.0, 5.0))
    assert 3 * stiff < soft < 0.1 * judged_at(chart, "task-1", pd, 5.0)["error"]


def test_a_torque_limit_is_a_share_of_what_the_motion_needs():
    limited = case("torque-limit")
    xi, xi_dot, xi_ddot = case("task-1").reference(np.linspace(0.0, 2.0, 20001))
    motion = fb.ikm2(fb.ikm(fb.igm(fb.FiveBar(), xi), xi_dot), xi_ddot)
    largest = np.abs(fb.inverse_dynamics(motion)).max()
    assert limited.torque_limit == pytest.approx(0.6 * largest, rel=1e-6)
    run = case("task-1").simulate("ctc-stiff")
    assert np.abs(run.tau).max() == pytest.approx(largest, rel=0.02)
    assert limited.reference.duration == case("task-1").reference.duration


@pytest.mark.parametrize("quick", [False, True])
def test_the_map_of_gains_has_each_run_at_its_place(quick, monkeypatch):
    monkeypatch.setattr(stability, "FINE", 21)
    chart = stability.chart()
    attempt = chart.methods[0].prepare("one sample of delay", 200)
    found = attempt.judge(attempt.call())
    assert found["growth"] == pytest.approx(found["exact"], rel=0.05) and len(attempt.times()) == 1
    assert (found["p"], found["q"]) == stability.gains("one sample of delay", 200)
    assert len(chart.methods[0].knobs) == stability.SIDE**2
    rows = []
    for problem in chart.problems:
        for knob in (0, 34, 782):
            p, q = stability.gains(problem, knob)
            own = {"problem": problem, "method": "simulated robot", "knob": knob, "status": "ok"}
            rows.append(own | {"p": p, "q": q, "growth": 0.5 + 1e-3 * knob, "exact": 0.5})
    result = Result(chart, {"quick": quick}, rows)
    figure = stability.figure(result)
    for axes, problem in zip(figure.axes, chart.problems):
        (mesh,) = (each for each in axes.collections if hasattr(each, "get_coordinates"))
        values = mesh.get_array()
        corners = mesh.get_coordinates()
        assert values.count() == 3 and axes.get_title() == problem
        assert values.size == len(chart.methods[0].knobs_of(problem, quick))
        for row in result.of(problem):
            column = np.searchsorted(corners[0, :, 0], row["p"]) - 1
            line = np.searchsorted(corners[:, 0, 1], row["q"]) - 1
            assert values[line, column] == row["growth"]
        exact = next(each for each in axes.collections if each is not mesh)
        assert exact.levels.tolist() == [0.5, 0.8, 1.0]
        delay = stability.PROBLEMS.index(problem)
        path = exact.get_paths()[-1]  # growth 1, the limit of stability
        found = [spectral_radius(p, q, delay) for p, q in path.vertices]
        assert len(found) > 20 and np.median(np.abs(np.subtract(found, 1.0))) < 0.02
    caption, ((_, head, cells),) = findings.summary(result)  # the chart's own
    assert caption.count("on 1 of 3 pairs of gains") == 2 and caption.count("differ by 6.8 %") == 2
    assert [len(head)] * 2 == [len(row) for row in cells]


def test_precisions_of_the_smallest_functions():
    """Rounding of numbers of 24 and of 53 bits, of the fewest instructions first."""
    chart = chip.chart()
    single, double = chart.methods
    places = single.knobs_of(chip.REGULAR, quick=False)
    sizes = [chip.exported(place).n_instructions() for place in places]
    assert sizes == sorted(sizes) and sorted(places) == list(range(len(chip.NAMES)))
    for place in places[:3]:
        errors = []
        for method in (single, double):
            found = judged_at(chart, chip.REGULAR, method.name, place)
            assert found["instructions"] == chip.exported(place).n_instructions()
            errors.append(found["error"])
        assert 2.0**-28 < errors[0] < 2.0**-19 and 2.0**-57 < errors[1] < 2.0**-48
    # Each output counts by its own largest value: of M and c, here M, the smaller, is off.
    exact = chip.exact(chip.REGULAR, chip.DYNAMIC, 0.0)
    off = exact.copy()
    off[:, :4] += 1e-3 * np.abs(exact[:, :4]).max()
    judge = chip.judged(chip.REGULAR, chip.DYNAMIC, 0.0, chip.exported(chip.DYNAMIC))
    assert judge(off)["error"] == pytest.approx(1e-3)
    near = [judged_at(chart, chip.NEAR, single.name, gap) for gap in chip.GAPS[:5:4]]
    assert near[1]["det_A"] < 0.2 * near[0]["det_A"] and near[1]["error"] > 10 * near[0]["error"]


def test_routes_of_the_direct_model(monkeypatch):
    """Closed forms to rounding, iterations to their tolerance, and what is lost is a failure."""
    monkeypatch.setattr(geometry, "BATCH", 200)
    chart = geometry.chart()
    for method in chart.methods:
        if method.needs:
            continue
        for problem in method.knobs:
            knob = method.knobs_of(problem, quick=False)[min(5, len(method.knobs[problem]) - 1)]
            if method.name == "Newton, cold start":
                with pytest.raises(Failed, match="wrong branch in|diverged in"):
                    judged_at(chart, problem, method.name, knob)
                continue
            found = judged_at(chart, problem, method.name, knob)
            bound = (
                1e-11 if problem == "singular" else 1e-7 if method.family == "iterations" else 1e-15
            )
            assert found["error"] < bound, (method.name, problem)
    judge = geometry.judged("one")
    exact = np.array(geometry.poses("one").exact, dtype=float)
    assert judge(exact)["error"] < 1e-16
    assert judge(exact + (3e-6, 4e-6))["error"] == pytest.approx(5e-6)
    exact[:25] = geometry.poses("one").other[:25]
    with pytest.raises(Failed, match="wrong branch in 25%"):
        judge(exact)
    exact[:50, 0] = np.nan
    with pytest.raises(Failed, match="nan in 50%"):
        judge(exact)


DEEP = "simulators", "trackers", "integrators", "chip", "stability", "geometry", "plans"
NAMES = [pytest.param(name, marks=[pytest.mark.deep] * (name in DEEP)) for name in ALL]


@pytest.mark.deep
@pytest.mark.parametrize("name", NAMES)
def test_a_bit_of_each_chart(name, compiler, tmp_path, monkeypatch):
    if name == "simulators":  # the usual cache: a loop takes half a minute to compile
        monkeypatch.undo()
    chart = load(ALL[name][0])
    assert chart.name == name
    rows, jobs = [], {}
    for problem, method, knob in chart.jobs(quick=True):
        if name == "plans" and problem != "AMORO flat":  # the others take minutes
            continue
        jobs.setdefault((problem, method.name), []).append((problem, method, knob))
    for several in jobs.values():
        problem, method, knob = several[min(1, len(several) - 1)]
        rows.append(row_of(problem, method, knob, lambda *job: measure(chart, *job, budget=0.0)))
    made = rows
    if name in ("chip", "simulators"):  # emulators and wheels that are not everywhere
        made = [row for row in rows if row["status"] != "left out"]
    for row in made:
        assert row["status"] in ("ok", "failed") and row["seconds"] > 0
        assert row["word"] or row["status"] == "ok"
        assert row["status"] == "ok" or name != "simulators" or row["problem"] != "forced"
        if row["status"] == "ok":
            wanted = {panel.y for panel in chart.all_panels if panel.problem == row["problem"]}
            assert wanted <= set(row)
            assert row["seconds_low"] <= row["seconds"] <= row["seconds_high"]
    succeeded = {row["method"] for row in rows if row["status"] == "ok" or row not in made}
    assert all(method.name in succeeded for method in chart.methods if method.family == OURS)
    result = Result(chart, {"quick": True}, rows)
    caption, tables = findings.summary(result)
    assert caption.endswith(".") and all(
        len(head) == len(row) for _, head, rows in tables for row in rows
    )
    monkeypatch.setattr("fivebar.base.tables.DPI", 50)
    making.write(result, tmp_path)
    assert (tmp_path / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / f"{name}.svg").stat().st_size > 20_000


@pytest.mark.deep
def test_geometry_knows_right_from_wrong(compiler):
    """The routes agree with the dyad but in the branch that arctg loses."""
    chart = routes.chart()
    rows = {
        m.name: measure(chart, "batch", m.name, 0, 0.0)
        for m in chart.methods
        if m.knobs_of("batch", True)
    }
    words = {name: row.get("word") for name, row in rows.items() if "error" not in row}
    assert (
        list(words) == ["arctg angles (vector method eq. 9)"]
        and "wrong branch" in words.popitem()[1]
    )
    assert all(row["error"] < 1e-15 for row in rows.values() if "error" in row)


@pytest.mark.deep
def test_single_precision_costs_a_chip_digits_and_saves_it_instructions():
    """Errors are those of ARM's own results; a chip without double precision pays for it in instructions."""
    needs.need("ARM compilers")
    found = arm_chip.chart()
    rows = {
        (size, hardware): measure(
            found, arm_chip.ARM, f"{size}, ARM with {hardware} precision", arm_chip.DIRECT, 0.0
        )
        for size in ("float", "double")
        for hardware in ("single", "double")
    }
    for (size, hardware), row in rows.items():
        assert row["error"] < (1e-6 if size == "float" else 1e-15), (size, hardware)
    assert rows["double", "single"]["executed"] > 3 * rows["float", "single"]["executed"]
    assert rows["double", "double"]["executed"] < 2 * rows["float", "double"]["executed"] < 1000


@pytest.mark.every(3)
@pytest.mark.parametrize("p, q, delay", [(1.0, 1.0, 0), (0.4, 1.6, 0), (0.1, 0.5, 1)])
def test_gain_of_noise(p, q, delay):
    """Against the sum over the response to one disturbed measurement, and against the robot."""
    x, held, total = np.zeros(2), 0.0, 0.0
    for noise in ((1.0, 0.0), (0.0, 1.0)):
        x, held = np.zeros(2), 0.0
        for k in range(400):
            command = -np.dot((p, q), x + (noise if k == 0 else 0))
            push, held = (held, command) if delay else (command, 0.0)
            x = np.array([x[0] + x[1] + push / 2, x[1] + push])
            total += x[0] ** 2
    assert exact_noise_gain(p, q, delay) == pytest.approx(np.sqrt(total), rel=1e-9)
    robot = motions.ROBOT
    assert noise_gain(robot, p, q, delay) == pytest.approx(np.sqrt(total), rel=0.25)
    assert exact_noise_gain(5.0, 1.0, delay) == np.inf
