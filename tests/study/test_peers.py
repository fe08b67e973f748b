"""Peers on the charts: the same robot, their orders, and what their traps cost."""

import platform
import sys

import numpy as np
import pytest

from fivebar.study.speed_accuracy.chart import Failed
from fivebar.study.speed_accuracy.runner import measure
from tests.benchmarks.simulators import chart as simulators
from tests.benchmarks.simulators import motions, native
from tests.helpers.needs import need

from .test_charts import measured_order


@pytest.fixture
def peers():
    for thing in ("other simulators", "a C compiler", "a C++ compiler"):
        need(thing)


@pytest.mark.parametrize("problem", list(motions.DRIVEN))
@pytest.mark.deep
def test_peers_are_the_same_robot(problem, peers):
    """By their own formulas they come to the same end: the models agree, and what differs is the integration."""
    chart = simulators.chart()
    for name, knob, bound in (
        ("Pinocchio, order 8, Python", 64, 1e-9),
        ("MuJoCo tuned, RK4, torque by callback, Python", 400, 1e-3),
        ("redundant KKT, order 8, VM", 64, 1e-9),
        ("MuJoCo tuned, RK4, C loop and torque", 400, 1e-3),
        ("heyoka, Taylor series, C++ loop", 1e-12, 1e-11),
        ("Pinocchio, order 8, C++ loop", 64, 1e-9),
        ("Drake's matrices, order 8, Python", 64, 1e-9),
        ("Drake tuned, bushing, C++ loop", 1e5, 3e-3),
        ("Exudyn as it comes, C++ loop", 1000, 2e-3),
        ("Exudyn tuned, stiff springs, C++ loop", 1e6, 2e-3),
    ):
        row = measure(chart, problem, name, knob, 0.0)
        assert row["error"] < bound and row["gap"] < 3e-6, name


@pytest.mark.parametrize(
    "name, knobs",
    [
        ("Drake as it comes, C++ loop", (200, 400)),
        ("Exudyn as it comes, C++ loop", (200, 400)),
        ("Pinocchio, semi-implicit Euler, Python", (400, 800)),
    ],
)
@pytest.mark.deep
def test_peers_have_their_orders(name, knobs, peers):
    chart = simulators.chart()
    order = measured_order(chart, "forced", name, chart.panels[0][0], knobs)
    assert order == pytest.approx(chart.method(name).order, abs=0.1)


@pytest.mark.deep
def test_the_traps_cost_digits(peers):
    """At the same settings: torque held over a step, a light body in the loop, and the nearest branch."""
    chart = simulators.chart()
    tuned, held, light = (
        measure(chart, "forced", f"MuJoCo tuned, {how}", 400, 0.0)["error"]
        for how in (
            "RK4, torque by callback, Python",
            "but the torque held over a step",
            "but tied by a body of 1 mg",
        )
    )
    assert 1e5 * tuned == pytest.approx(held, rel=0.3) and light > 1e5 * tuned
    shares = [
        measure(chart, "positions", "pylinkage step", turn, 0.0)["wrong"] for turn in (5.0, 60.0)
    ]
    assert shares == [0.0, 0.5]


def test_a_diverging_peer_fails():
    judge = simulators.judged("forced")
    for q, word in ((np.full(2, np.nan), "nan"), (np.full(2, 1e20), "diverges")):
        with pytest.raises(Failed, match=word):
            judge((q, 0.0))


@pytest.mark.skipif(
    (sys.platform, platform.machine()) != ("linux", "x86_64"), reason="not all have wheels here"
)
def test_all_peers_are_installed_where_they_have_wheels():
    need("other simulators")
    assert native.lacks_headers() is None
