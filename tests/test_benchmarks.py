"""A smoke run of the benchmarks: they work; their timings are not asserted here."""

import os
import shutil

import pytest

from tests.benchmarks import engine, singularities, speed


@pytest.mark.parametrize("benchmark, figures", [(speed, 6), (engine, 5), (singularities, 4)])
def test_a_benchmark_runs(benchmark, figures, capsys, tmp_path, monkeypatch):
    if shutil.which("cc") is None and not os.environ.get("CI"):
        pytest.skip("no C compiler")
    monkeypatch.setenv("FIVEBAR_CACHE", str(tmp_path))
    benchmark.main(quick=True)
    assert capsys.readouterr().out.count("bound") == figures
