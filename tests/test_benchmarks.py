"""A smoke run of the benchmarks: they work; their timings are not asserted here."""

import pytest

from tests.benchmarks import engine, singularities, speed


@pytest.mark.parametrize("benchmark, figures", [(speed, 8), (engine, 5), (singularities, 4)])
def test_a_benchmark_runs(benchmark, figures, capsys, compiler):
    benchmark.main(quick=True)
    assert capsys.readouterr().out.count("bound") == figures
