"""A smoke run of the benchmarks: they work; their timings are not asserted here."""

import numpy as np
import pytest

import fivebar as fb
from tests.benchmarks import arrays, drawings, engine, live_page, plans, singularities, speed
from tests.helpers.needs import need


@pytest.mark.every(2)
@pytest.mark.parametrize(
    "benchmark, figures",
    [
        (singularities, 4),
        (speed, 8),
        pytest.param(engine, 5, marks=pytest.mark.deep),
        pytest.param(live_page, 9, marks=pytest.mark.deep),
    ],
)
def test_a_benchmark_runs(benchmark, figures, capsys, compiler):
    benchmark.main(quick=True)
    assert capsys.readouterr().out.count("bound") == figures


@pytest.mark.deep
@pytest.mark.filterwarnings("ignore:.*torch.jit:DeprecationWarning")  # of PyTorch's own files
def test_array_libraries_agree(capsys, compiler):
    need("JAX")
    need("PyTorch")
    arrays.main(quick=True)
    words = capsys.readouterr().out
    assert words.count("of JAX's") == 8
    assert float(words.split("the same to ")[1].split()[0]) < 1e-12
    assert float(words.split("at the end ")[1].split()[0]) < 1e-4


def test_timed_paths_are_no_slower_than_toppras_and_keep_their_limits(capsys):
    need("toppra")
    for number in (14, 15, 19):  # of three pieces, of eleven, and of three
        _, _, *given = next(case for case in drawings.cases(number + 1) if case[0] == number)
        robot, working, path, limits = given
        motion, _ = drawings.by_fivebar(*given)
        assert motion.gap <= 1e-3
        k, gone, rate, push = motion.along(np.linspace(0, motion.duration, 4001))
        s = path.knots[motion.piece[k]] + motion.first[k] + gone
        if set(limits) <= drawings.BY_JOINTS:
            assert drawings.shares(robot, working, path, limits, s, rate, push) <= 1
            duration, _, most = drawings.by_toppra(*given, 100)
            assert motion.duration <= 1.001 * duration and most < 1.1
            assert duration > (1 - (most - 1)) * motion.lower_bound


def test_drawings_of_the_benchmark_are_timed(capsys, monkeypatch):
    need("toppra")
    short = next(case for case in drawings.cases(15) if case[0] == 14)  # of three pieces
    monkeypatch.setattr(drawings, "cases", lambda count: [short])
    assert [row[1] <= 1e-3 for row in drawings.main(1)] == [True]
    assert "for 30 pieces: median" in capsys.readouterr().out
    chart = drawings.chart()
    assert [method.name for method in chart.methods] == ["fivebar.time_path", "toppra, Seidel"]


@pytest.mark.deep
def test_plans_of_the_benchmark_are_compared_with_a_long_search(capsys):
    ((name, over, seconds),) = plans.main(1, 1, names=("AMORO flat",))
    assert name == "AMORO flat" and 1.0 <= over < 1.02 and seconds > 0
    assert "within 2 %: 100% of 1 pairs" in capsys.readouterr().out
    chart = plans.chart()
    assert [method.name for method in chart.methods] == [*plans.METHODS]
    given = next(plans.random_pairs("AMORO flat", 1))
    by_hand = plans.by_opti(*given, 1)
    assert by_hand > 0.95 * fb.plan(*given[:4]).objective
