"""A bit of each chart of speed against accuracy, and the orders that its methods show."""

import numpy as np
import pytest

from fivebar.study.speed_accuracy import findings, making
from fivebar.study.speed_accuracy.chart import OURS, load
from fivebar.study.speed_accuracy.charts import contours, derivatives, integrators, motions
from fivebar.study.speed_accuracy.findings import observed_order, orders
from fivebar.study.speed_accuracy.runner import measure, row_of
from fivebar.study.speed_accuracy.store import COLUMNS, Result
from tests.benchmarks import chip, routes
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
    succeeded = {row["method"] for row in rows if row["status"] == "ok"}
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
    found = chip.chart()
    rows = {
        (size, hardware): measure(
            found, chip.ARM, f"{size}, ARM with {hardware} precision", chip.DIRECT, 0.0
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
