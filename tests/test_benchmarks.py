"""A smoke run of the benchmarks: they work; their timings are not asserted here."""

import pytest

from tests.benchmarks import arrays, engine, live_page, singularities, speed, time_paths
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
    for ours, theirs, bound in time_paths.main(quick=True).values():
        duration, _, torque, speed = ours
        assert (
            duration <= 1.001 * theirs[0]
            and torque <= 1
            and speed <= 1
            and duration <= 1.001 * bound
        )
    assert capsys.readouterr().out.count("toppra") == 2
