"""A smoke run of the benchmarks: they work; their timings are not asserted here."""

import os
import shutil

import pytest

from tests.benchmarks import speed


def test_speed_runs(capsys):
    if shutil.which("cc") is None and shutil.which("gcc") is None and not os.environ.get("CI"):
        pytest.skip("no C compiler")
    speed.main(quick=True)
    assert capsys.readouterr().out.count("bound") == 5
