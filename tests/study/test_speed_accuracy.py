"""The charts of speed against accuracy: their references, orders of convergence, runner, files; a bit of each chart."""

import io
import json
import platform
import re
import sys
import tempfile
from types import SimpleNamespace

import mpmath
import numpy as np
import pytest
from PIL import Image

from fivebar.cli import main
from fivebar.study.chart_names import PEERS
from fivebar.study.pitfalls.sampled import exact_noise_gain, noise_gain
from fivebar.study.speed_accuracy import chart as declared
from fivebar.study.speed_accuracy import machine, making, runner
from fivebar.study.speed_accuracy.charts import chip, contours, derivatives, geometry, integrators, motions, simulators
from fivebar.study.speed_accuracy.charts.exact import DIGITS, cos_sin, distance, exact_motion
from fivebar.study.speed_accuracy.findings import caption, failures, observed_order, orders, table, words_of
from fivebar.study.speed_accuracy.picture import figure
from fivebar.study.speed_accuracy.runner import Worker, measure, row_of, run
from fivebar.study.speed_accuracy.store import BASE, Partial, Result, from_csv
from tests.helpers import needs, toy_chart
from tests.helpers.needs import need

# References.


def position(robot, q, assembly):
    """Where circles about both elbows meet, by complex numbers."""
    e1, e2 = (side * mpmath.mpf(robot.d) / 2 + length * mpmath.expj(angle)
              for side, length, angle in ((-1, robot.l11, q[0]), (1, robot.l21, q[1])))  # fmt: skip
    span = e2 - e1
    cosine = (abs(span) ** 2 + mpmath.mpf(robot.l12) ** 2 - mpmath.mpf(robot.l22) ** 2) / (2 * robot.l12 * abs(span))
    return e1 + robot.l12 * span / abs(span) * mpmath.expj(-assembly * mpmath.acos(cosine))


@pytest.mark.parametrize("assembly", [-1, 1])
def test_exact_motion_has_50_digits(robot, assembly):
    rng = np.random.default_rng(3)
    with mpmath.workdps(2 * DIGITS):
        for _ in range(3):
            q, rate, acceleration = rng.uniform(0.2, 0.6, 2), rng.normal(size=2), rng.normal(size=2)
            angles = [[mpmath.mpf(float(x)) for x in v] for v in (q, rate, acceleration)]

            def path(t, angles=angles):
                return position(robot, [a + b * t + c * t * t / 2 for a, b, c in zip(*angles)], assembly)

            found = exact_motion(robot, q, rate, acceleration, assembly)
            for order, vector in enumerate(found):
                true = mpmath.diff(path, 0, order)
                off = abs(mpmath.mpc(*(mpmath.mpf(str(x)) for x in vector)) - true) / abs(true)
                assert off < mpmath.mpf(10) ** -DIGITS * 10


def test_decimal_sine_and_cosine():
    from decimal import Decimal, localcontext

    with localcontext(prec=DIGITS + 15), mpmath.workdps(DIGITS + 20):
        for angle in (0.0, 1e-30, -3.0, 2.5, 6.2):
            found = [mpmath.mpf(str(x)) for x in cos_sin(Decimal(angle))]
            assert all(abs(a - b) < mpmath.mpf(10) ** -(DIGITS + 5) for a, b in zip(found, mpmath.cos_sin(angle)))
    assert distance((1.0, 2.0), (Decimal(1), Decimal(2) + Decimal("1e-30"))) == pytest.approx(1e-30)


def redundant_slope(robot, torque=None):
    """state (x, y, q1, q2, rates, t) -> slope by Lagrange multipliers, in mpmath; regular at Type 2."""
    legs = [(side * mpmath.mpf(robot.d) / 2, mpmath.mpf(length)) for side, length in ((-1, robot.l11), (1, robot.l21))]
    z1, z2, m = mpmath.mpf(robot.zz1), mpmath.mpf(robot.zz2), mpmath.mpf(robot.m)

    def leg(base, length, x, y, xd, yd, angle, rate):
        cos, sin = mpmath.cos_sin(angle)
        ex, ey = length * cos, length * sin
        rx, ry, vx, vy = x - base - ex, y - ey, xd + ey * rate, yd - ex * rate
        return rx, ry, ry * ex - rx * ey, -(rx * ex + ry * ey) * rate * rate - vx * vx - vy * vy

    def slope(state):
        x, y, q1, q2, xd, yd, w1, w2, t = state
        tau1, tau2 = torque(t) if torque else (0, 0)
        (r1x, r1y, b1, g1), (r2x, r2y, b2, g2) = (
            leg(*own, x, y, xd, yd, q, w) for own, q, w in zip(legs, (q1, q2), (w1, w2))
        )
        a11, a22 = (r1x * r1x + r1y * r1y) / m + b1 * b1 / z1, (r2x * r2x + r2y * r2y) / m + b2 * b2 / z2
        a12 = (r1x * r2x + r1y * r2y) / m
        det = a11 * a22 - a12 * a12
        g1, g2 = g1 + b1 * tau1 / z1, g2 + b2 * tau2 / z2
        mu1, mu2 = (a22 * g1 - a12 * g2) / det, (a11 * g2 - a12 * g1) / det
        force = (mu1 * r1x + mu2 * r2x) / m, (mu1 * r1y + mu2 * r2y) / m
        return [xd, yd, w1, w2, *force, (tau1 - b1 * mu1) / z1, (tau2 - b2 * mu2) / z2, 1]

    return slope


def extrapolated(slope, y, step, levels):
    """One step of Gragg, Bulirsch and Stoer: midpoint rules of 2, 4, ... substeps, extrapolated to none."""
    rows = []
    for k in range(1, levels + 1):
        h = step / (2 * k)
        a, b = y, [u + h * v for u, v in zip(y, slope(y))]
        for _ in range(2 * k - 1):
            a, b = b, [u + 2 * h * v for u, v in zip(a, slope(b))]
        row = [[(u + v + h * w) / 2 for u, v, w in zip(a, b, slope(b))]]
        for j in range(1, k):
            ratio = (mpmath.mpf(k) / (k - j)) ** 2 - 1
            row.append([u + (u - v) / ratio for u, v in zip(row[-1], rows[-1][j - 1])])
        rows.append(row)
    return rows[-1][-1]


@pytest.mark.parametrize(
    "name, steps, levels", [("regular", 25, 10), ("grazing", 32, 11), ("through", 60, 11), ("forced", 25, 11)]
)
def test_ends_of_the_motions(name, steps, levels):
    known = [table[name] for table in (motions.MOTIONS, motions.DRIVEN) if name in table]
    robot = motions.ROBOT

    def torque(t):
        wave = mpmath.cos(2 * mpmath.pi * t)
        return mpmath.mpf(0.02) * wave, -mpmath.mpf(0.016) * wave

    with mpmath.workdps(26):
        state = start_of(name, known[0], robot)
        slope = redundant_slope(robot, torque if name == "forced" else None)
        for _ in range(steps):
            state = extrapolated(slope, state, mpmath.mpf(motions.DURATION) / steps, levels)
        for motion in known:
            free = isinstance(motion, motions.FreeMotion)
            off = [float(a - b) for a, b in zip(state[:2] if free else state[2:4], motion.end)]
            assert max(abs(x) for x in off) < (1e-16 if free else 4e-16), off


def start_of(name, motion, robot):
    """Positions and rates that close the loop to all digits; the given half is the same floats."""
    rates = motion.begin()
    if name == "through":
        (x, y), (xd, yd) = map(mpmath.mpf, rates.pose.xi), map(mpmath.mpf, rates.xi_dot)
        q, w = [], []
        for side, sign, length, bar in ((-1, 1, robot.l11, robot.l12), (1, -1, robot.l21, robot.l22)):
            span = mpmath.mpc(x - side * mpmath.mpf(robot.d) / 2, y)
            cosine = (abs(span) ** 2 + mpmath.mpf(length) ** 2 - mpmath.mpf(bar) ** 2) / (2 * length * abs(span))
            u = span / abs(span) * mpmath.expj(sign * mpmath.acos(cosine))
            r = span - length * u
            q.append(mpmath.arg(u))
            w.append((r.real * xd + r.imag * yd) / (length * (r.imag * u.real - r.real * u.imag)))
        return [x, y, *q, xd, yd, *w, mpmath.mpf(0)]
    q, w = ([mpmath.mpf(float(v)) for v in vector] for vector in (rates.pose.q, rates.q_dot))
    with mpmath.workdps(60):
        z, v = (mpmath.diff(lambda t: position(robot, [a + b * t for a, b in zip(q, w)], -1), 0, k) for k in (0, 1))
    return [z.real, z.imag, *q, v.real, v.imag, *w, mpmath.mpf(0)]


# Orders of convergence.


def test_observed_order():
    steps = 2.0 ** -np.arange(12)
    for order in (1, 2, 4, 8):
        errors = steps**order
        assert observed_order(steps, errors, 1e-16) == pytest.approx(order)
        assert observed_order(steps, errors + 1e-12 / steps, 1e-16) == pytest.approx(order, abs=0.1)  # rounding grows
        assert observed_order(steps[::-1], np.maximum(errors, 1e-9)[::-1], 1e-9) == pytest.approx(order)
    assert np.isnan(observed_order([1.0], [1.0], 0.0)) and np.isnan(observed_order(steps, 0 * steps + 1.0, 1.0))


def measured_order(chart, problem, name, panel, knobs):
    rows = []
    method = chart.method(name)
    for knob in knobs or method.knobs_of(problem, quick=False):
        attempt = method.prepare(problem, knob)
        row = dict.fromkeys(BASE, 0.0) | {"problem": problem, "method": name, "knob": knob, "status": "ok"}
        rows.append(row | attempt.judge(attempt.call()))
    return orders(Result(chart, {}, rows), panel)[name]


@pytest.mark.parametrize(
    "name, knobs",
    [
        ("fivebar: order 8, four bars, VM", slice(None)), ("fivebar: order 8, task chart, compiled", slice(1, 6)),
        ("fivebar.simulate: steps of order 8", slice(None)),
        ("fivebar: RK4, four bars, compiled", slice(4, 10, 2)),
        ("explicit Euler, Python", slice(6)), ("semi-implicit Euler, Python", slice(6)), ("RK4, Python", slice(6)),
        ("CasADi collocation, Radau of degree 3", slice(None)), ("redundant DAE, RK4, Python", slice(6)),
        ("redundant DAE, Baumgarte 10/s", slice(4, 8)), ("redundant DAE, Baumgarte 1/step", slice(3, 7)),
    ],
)  # fmt: skip
def test_integrators_have_their_orders(name, knobs, compiler):
    chart = integrators.chart()
    method = chart.method(name)
    order = measured_order(chart, "regular", name, chart.panels[0][0], method.knobs_of("regular", False)[knobs])
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
    assert measured_order(chart, "task", "grid by NumPy, contoured", chart.panels[0][0], knobs) == pytest.approx(
        2, abs=0.1
    )


# A bit of each chart.


@pytest.mark.parametrize("name", list(declared.MODULES))
def test_a_bit_of_each_chart(name, compiler, tmp_path, monkeypatch):
    if name in PEERS:  # the usual cache: the loop around Pinocchio takes half a minute to compile
        monkeypatch.undo()
    chart = declared.load(declared.module_of(name))
    assert chart.name == name
    rows, jobs = [], {}
    for problem, method, knob in chart.jobs(quick=True):
        jobs.setdefault((problem, method.name), []).append((problem, method, knob))
    for several in jobs.values():
        problem, method, knob = several[min(1, len(several) - 1)]
        rows.append(row_of(problem, method, knob, lambda *job: measure(chart, *job, budget=0.0)))
    result = Result(chart, {"quick": True}, rows)
    wanted = {panel.problem: {p.y for row in chart.panels for p in row if p.problem == panel.problem}
              for row in chart.panels for panel in row}  # fmt: skip
    made = rows
    if name == "chip" and not needs.NEEDED["ARM compilers"][0]():
        made = [row for row in rows if row["status"] != "left out"]
    if name in PEERS:  # some have no wheels on some platforms, but none fails on the regular motion
        made = [row for row in rows if row["status"] != "left out"]
        assert not [row for row in made if row["problem"] == "forced" and row["status"] == "failed"]
    for row in made:
        assert row["status"] in ("ok", "failed") and row["seconds"] > 0 and (row["word"] or row["status"] == "ok")
        if row["status"] == "ok":
            assert wanted[row["problem"]] <= set(row) and row["seconds_low"] <= row["seconds"] <= row["seconds_high"]
    succeeded = {row["method"] for row in rows if row["status"] == "ok"}
    assert all(method.name in succeeded for method in chart.methods if method.family == declared.OURS)
    result.to_csv(tmp_path / "again.csv")
    again = making.redraw(tmp_path / "again.csv", name)
    assert again.rows == rows and making.module_with(chart).caption(again) == making.module_with(chart).caption(result)
    monkeypatch.setattr(making, "DPI", 50)
    assert making.draw(again, tmp_path).startswith(b"\x89PNG")
    assert (tmp_path / f"{name}.svg").stat().st_size > 20_000


def test_a_picture_is_redrawn_from_its_csv(toy_result, toy, tmp_path):
    drawn = making.draw(toy_result, tmp_path)
    toy_result.to_csv(tmp_path / "toy.csv")
    assert making.draw(making.redraw(tmp_path / "toy.csv", "toy"), tmp_path) == drawn


def test_geometry_knows_right_from_wrong(compiler):
    """The routes agree with the dyad but in the branch that arctg loses."""
    chart = geometry.chart()
    rows = {m.name: measure(chart, "batch", m.name, 0, 0.0) for m in chart.methods if m.knobs_of("batch", True)}
    words = {name: row.get("word") for name, row in rows.items() if "error" not in row}
    assert list(words) == ["arctg angles (vector method eq. 9)"] and "wrong branch" in words.popitem()[1]
    assert all(row["error"] < 1e-15 for row in rows.values() if "error" in row)


def test_single_precision_costs_a_chip_digits_and_saves_it_instructions():
    """Errors are those of ARM's own results; a chip without double precision pays for it in instructions."""
    needs.need("ARM compilers")
    found = chip.chart()
    rows = {
        (size, hardware): measure(found, chip.ARM, f"{size}, ARM with {hardware} precision", chip.DIRECT, 0.0)
        for size in ("float", "double") for hardware in ("single", "double")
    }  # fmt: skip
    for (size, hardware), row in rows.items():
        assert row["error"] < (1e-6 if size == "float" else 1e-15), (size, hardware)
    assert rows["double", "single"]["executed"] > 3 * rows["float", "single"]["executed"]
    assert rows["double", "double"]["executed"] < 2 * rows["float", "double"]["executed"] < 1000


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


@pytest.fixture
def peers():
    need("other simulators")


@pytest.mark.parametrize("problem", list(motions.DRIVEN))
def test_peers_are_the_same_robot(problem, peers):
    """By their own formulas they come to the same end: the models agree, and what differs is the integration."""
    chart = simulators.chart()
    for name, knob, bound in (
        ("Pinocchio, order 8, Python", 64, 1e-9), ("MuJoCo tuned, RK4, torque by callback, Python", 400, 1e-3),
        ("redundant KKT, order 8, VM", 64, 1e-9), ("MuJoCo tuned, RK4, C loop and torque", 400, 1e-3),
        ("heyoka, Taylor series, C++ loop", 1e-12, 1e-11), ("Pinocchio, order 8, C++ loop", 64, 1e-9),
        ("Drake's matrices, order 8, Python", 64, 1e-9), ("Drake tuned, bushing, C++ loop", 1e5, 3e-3),
        ("Exudyn as it comes, C++ loop", 1000, 2e-3),
        ("Exudyn tuned, stiff springs, C++ loop", 1e6, 2e-3),
    ):  # fmt: skip
        row = measure(chart, problem, name, knob, 0.0)
        assert row["error"] < bound and row["gap"] < 3e-6, name


@pytest.mark.parametrize(
    "name, knobs",
    [("Drake as it comes, C++ loop", (200, 400)),
     ("Exudyn as it comes, C++ loop", (200, 400)),
     ("Pinocchio, semi-implicit Euler, Python", (400, 800))],
)  # fmt: skip
def test_peers_have_their_orders(name, knobs, peers):
    chart = simulators.chart()
    order = measured_order(chart, "forced", name, chart.panels[0][0], knobs)
    assert order == pytest.approx(chart.method(name).order, abs=0.1)


def test_the_traps_cost_digits(peers):
    """At the same settings: torque held over a step, a light body in the loop, and the nearest branch."""
    chart = simulators.chart()
    tuned, held, light = (
        measure(chart, "forced", f"MuJoCo tuned, {how}", 400, 0.0)["error"]
        for how in ("RK4, torque by callback, Python", "but the torque held over a step", "but tied by a body of 1 mg")
    )
    assert 1e5 * tuned == pytest.approx(held, rel=0.3) and light > 1e5 * tuned
    shares = [measure(chart, "positions", "pylinkage step", turn, 0.0)["wrong"] for turn in (5.0, 60.0)]
    assert shares == [0.0, 0.5]


def test_a_diverging_peer_fails():
    judge = simulators.judged("forced")
    for q, word in ((np.full(2, np.nan), "nan"), (np.full(2, 1e20), "diverges")):
        with pytest.raises(declared.Failed, match=word):
            judge((q, 0.0))


def test_all_peers_are_installed_where_they_have_wheels():
    linux = (sys.platform, platform.machine()) == ("linux", "x86_64")
    wanted = (*machine.PEERS, "C++ compiler", "Pinocchio's headers") if linux else ()
    assert [machine.missing((name,)) for name in wanted] == [None] * len(wanted)


def test_simulators_only_when_asked_for():
    assert set(making.chart_names(peers=True)) - set(making.chart_names()) == {"simulators"}


# The runner.


@pytest.fixture
def toy(monkeypatch):
    monkeypatch.setitem(declared.MODULES, "toy", "tests.helpers.toy_chart")
    monkeypatch.setitem(machine.NEEDED, "C compiler", lambda: "no C compiler (cc, gcc, clang)")


@pytest.fixture(scope="module")
def toy_result(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(declared.MODULES, "toy", "tests.helpers.toy_chart")
        patch.setitem(machine.NEEDED, "C compiler", lambda: "no C compiler (cc, gcc, clang)")
        return run("toy", tmp_path_factory.mktemp("toy"), quick=True)[0]


def test_every_failure_is_a_row_with_a_word(toy_result):
    words = {row["method"]: (row["status"], row["word"]) for row in toy_result.rows}
    assert words == {
        "<ours> & mine": ("ok", ""), "cruder": ("ok", ""), "astray": ("ok", ""), "nan": ("failed", "nan"),
        "singular": ("failed", "refused: singular"), "wrong": ("failed", "wrong branch in 23%"),
        "hangs": ("failed", "timeout, 1.5 s"), "crashes": ("failed", "crashed"), "after the crash": ("ok", ""),
        "needs more": ("left out", "no C compiler (cc, gcc, clang)"),
    }  # fmt: skip
    assert len(toy_result.rows) == 2 * 6 + 4 and {"cpu", "numpy", "compiler", "quick"} <= set(toy_result.about)
    assert all(row["seconds"] > 0 for row in toy_result.rows if row["status"] != "left out")


def test_failures_are_on_the_chart(toy_result):
    made = figure(toy_result)
    panel = toy_result.chart.panels[0][0]
    strip = made.axes[1]
    said = [text.get_text() for text in strip.texts]
    assert len(said) == len(failures(toy_result, panel)) == 7
    for words in (
        "astray: error above 1 (2 times)",
        "hangs: timeout, 1.5 s",
        "needs more: left out: no C compiler (cc",
    ):
        assert any(words in text for text in said)
    assert sum(len(line.get_xdata()) for line in strip.lines) == 10


def test_caption_is_made_of_the_measurements(toy_result):
    def timed(seconds):
        rows = [
            row | {"seconds": seconds[row["method"]]} if row["method"] in seconds else row for row in toy_result.rows
        ]
        return caption(Result(toy_result.chart, {}, rows))

    ahead = timed({"<ours> & mine": 1e-3, "cruder": 1.0, "after the crash": 4e-3})
    assert ahead == "Of 2 errors asked for, fivebar gets to all first, 4 times as fast as the next, to 1 of them alone."
    behind = timed({"<ours> & mine": 1e-3, "cruder": 1.0, "after the crash": 5e-4})
    assert "gets to 1 first" in behind and "loses to after the crash once, which is 2 times as fast." in behind
    assert (
        words_of([(None, f"wrong in {n}%") for n in (7, 30, 12)] + [(None, "nan")]) == "wrong in 7-30% (3 times), nan"
    )


def test_the_table_has_each_method_and_its_failures(toy_result):
    (title, head, rows), cells = table(toy_result)[0], {}
    for name, *found in rows:
        cells[name] = dict(zip(head[1:], found))
    names = [method.name for method in toy_result.chart.methods if method.name != "cruder"]  # never at 1e-2, nor failed
    assert title == "one panel" and list(cells) == names
    failed = "2 of 2: error above 1 (2 times)"
    assert cells["astray"] == {"s, to 1e-2": "-", "s, to 1e-4": "-", "s, to 1e-9": "-", "failed": failed}
    assert float(cells["after the crash"]["s, to 1e-2"]) > 0 and cells["after the crash"]["s, to 1e-4"] == "-"
    assert cells["needs more"]["failed"] == "left out: no C compiler (cc, gcc, clang)"


def test_the_page_has_the_pictures_words_as_text(toy_result, tmp_path, monkeypatch):
    """Its picture is the PNG without title and verdict, whose pixels are none of a panel's."""
    monkeypatch.setattr(making, "DPI", 80)
    bare = Image.open(io.BytesIO(making.draw(toy_result, tmp_path))).convert("L")
    whole = Image.open(tmp_path / "toy.png").convert("L")
    lines = [
        k for k in range(whole.height) if whole.crop((0, k, whole.width, k + bare.height)).tobytes() == bare.tobytes()
    ]
    assert len(lines) == 1 and 0.3 * making.DPI < lines[0] < 0.5 * making.DPI
    assert min(whole.crop((0, 0, whole.width, lines[0])).tobytes()) < 100 > min(bare.tobytes())
    assert whole.height - lines[0] - bare.height > 0.1 * making.DPI


def test_an_error_of_ours_ends_the_run_and_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with Worker("tests.helpers.toy_chart", 20.0, 0.0) as worker, pytest.raises(StopIteration):
        assert worker.measure("p", "singular", 1)["word"] == "refused: singular"
        assert [len(list(room.iterdir())) for room in tmp_path.iterdir()] == [1]
        worker.process.kill()  # as where memory is short: not what the next attempt did
        worker.process.join(10)
        assert worker.measure("p", "cruder", 1)["error"] == 0.1
        worker.measure("p", "no such method", 1)
    assert not list(tmp_path.iterdir())


def test_an_interrupted_run_goes_on(toy, tmp_path, monkeypatch):
    calls = []

    def interrupted(self, problem, method, knob):
        calls.append((method, knob))
        if len(calls) == 4:
            raise KeyboardInterrupt
        return {"seconds": 1e-3, "error": 0.5}

    monkeypatch.setattr(Worker, "measure", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run("toy", tmp_path, quick=True)
    path = tmp_path / "toy.partial.jsonl"
    assert len(path.read_text().splitlines()) == 1 + 3
    path.write_text(path.read_text() + '{"problem": "p", "meth')  # cut off in the middle
    result, _ = run("toy", tmp_path, quick=True)
    assert len(result.rows) == 16 and calls.count(("<ours> & mine", 1)) == 1 and calls.count(calls[3]) == 2
    assert len(calls) == 4 + 12  # 15 that can run, 3 of them known


def test_an_interrupted_command_keeps_the_charts_that_were_done(toy, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(declared.MODULES, "other", "tests.helpers.toy_chart")
    monkeypatch.setattr(
        Worker, "measure", lambda *_: dict.fromkeys(("seconds", "seconds_low", "seconds_high", "error"), 0.5)
    )
    original, seen = runner.run, []

    def run_one(name, *rest):
        seen.append(name)
        if seen == ["toy", "other"]:
            raise KeyboardInterrupt
        return original(name, *rest)

    monkeypatch.setattr(runner, "run", run_one)
    monkeypatch.setattr("fivebar.study.speed_accuracy.chart_names", lambda peers: ("toy", "other"))
    assert main(["chart", "all", "--quick", "--out", str(tmp_path)]) == 1
    assert "the same command goes on there" in capsys.readouterr().err
    assert (tmp_path / "toy.csv").exists() and (tmp_path / "toy.partial.jsonl").exists()
    monkeypatch.setattr(Worker, "measure", lambda *_: pytest.fail("measured again"))
    monkeypatch.setattr("fivebar.study.speed_accuracy.chart_names", lambda peers: ("toy",))
    assert main(["chart", "all", "--quick", "--out", str(tmp_path)]) == 0
    assert not (tmp_path / "toy.partial.jsonl").exists()


def test_another_kind_of_run_is_begun_anew(tmp_path):
    path = tmp_path / "x.partial.jsonl"
    first = Partial(path, {"quick": True})
    row = {"problem": "p", "method": "m", "knob": 0.1}
    first.add(row)
    assert Partial(path, {"quick": True}).rows == [row] and Partial(path, {"quick": True}).has("p", "m", 0.1)
    assert Partial(path, {"quick": False}).rows == [] and len(path.read_text().splitlines()) == 1


# The command.


def test_command(toy, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(toy_chart, "METHODS", toy_chart.METHODS[:4])
    assert main(["chart", "toy", "--quick", "--out", str(tmp_path)]) == 0
    names = ["toy.csv", "toy.png", "toy.svg", "index.html"]
    said = capsys.readouterr()
    assert said.out.split() == [str(tmp_path / name) for name in names] and not said.err
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "A &lt;toy&gt; &amp; its failures" in page and "<toy>" not in page and "&lt;ours&gt; &amp; mine" in page
    assert not re.search(r'(src|href)="(?!data:|#|toy\.)', page) and "http" not in page.replace("http-equiv", "")
    about = json.loads((tmp_path / "toy.csv").read_text().splitlines()[0].split(": ", 1)[1])
    assert about["quick"] is True and about["cpu"]
    assert len(from_csv(tmp_path / "toy.csv", toy_chart.chart()).rows) == 8


def test_unknown_chart(tmp_path, capsys):
    assert main(["chart", "geometrie", "--out", str(tmp_path / "none")]) == 2
    said = capsys.readouterr().err
    assert all(name in said for name in (*declared.MODULES, "all", "geometrie")) and not (tmp_path / "none").exists()


def test_a_csv_that_is_none(tmp_path):
    chart, path = toy_chart.chart(), tmp_path / "x.csv"
    path.write_text("a,b\n1,2\n")
    with pytest.raises(ValueError, match="line 1: not a CSV file of the chart toy"):
        from_csv(path, chart)
    path.write_text("# fivebar chart toy, SI units: {}\nproblem,method,knob\np,m,x\n")
    with pytest.raises(ValueError, match="line 3: not numbers"):
        from_csv(path, chart)
    path.write_text("# fivebar chart toy, SI units: {}\nproblem,method,knob\np,of old,1\n")
    with pytest.raises(ValueError, match="line 3: the chart toy has no method 'of old' on a problem 'p'"):
        from_csv(path, chart)


def test_a_csv_of_another_version_is_refused_before_anything_is_measured(toy, tmp_path, monkeypatch, capsys):
    (tmp_path / "geometry.csv").write_text("# fivebar chart geometry, SI units: {}\nproblem,method,knob\none,old,1\n")
    monkeypatch.setattr(Worker, "measure", lambda *_: pytest.fail("measured"))
    assert main(["chart", "toy", "--quick", "--out", str(tmp_path)]) == 1
    assert "geometry.csv" in capsys.readouterr().err


@pytest.mark.parametrize("call, together, count", [(2.0**-20, 105, 99), (0.00048828125, 1, 20), (0.5, 1, 3)])
def test_times_are_those_of_repeats_within_a_budget(call, together, count, monkeypatch):
    """A clock that only calls move: short calls are timed `together`, `count` samples of at most 0.01 s, at least 3."""
    now = [0.0]
    monkeypatch.setattr(runner, "time", SimpleNamespace(perf_counter=lambda: now[0]))

    def work():
        now[0] += call

    samples = runner.times_of(work, 1e-6, 0.01)
    assert samples.tolist() == [call] * count and now[0] == call * (1 + together * count)
    before = now[0]
    assert runner.times_of(work, 9.0, 1.0).tolist() == [9.0] and now[0] == before
