"""A machine without a browser, bubblewrap and compiler: tests are skipped and named; in CI they fail."""

import os
import subprocess
import sys
from types import SimpleNamespace
from unittest.mock import Mock

import pytest

from .conftest import pytest_collection_modifyitems
from .helpers import ROOT, needs

TESTS = (
    "tests/visualization/test_page_maps.py::test_the_map_of_a_biglide",
    "tests/grading/test_student.py::test_time_on_the_processor_is_limited_too[bwrap]",
    "tests/models/test_compiled.py::test_machine_code_is_kept_and_a_damaged_library_is_built_again",
    "tests/test_needs.py::test_what_is_here_is_used",
)


@pytest.mark.deep
@pytest.mark.parametrize(
    "ci, status, kind, distributed",
    [("", 0, "skipped", ("-n", "2", "--dist", "loadfile")), ("true", 1, "error", ())],
)
def test_what_is_missing_is_said_once(ci, status, kind, distributed, tmp_path):
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-p",
        "no:cacheprovider",
        "-m",
        "",
        *distributed,
        *TESTS,
    ]
    inherited = {
        name: value
        for name, value in os.environ.items()
        if name != "CC" and not name.startswith("PYTEST_")
    }
    environment = inherited | {"PATH": str(tmp_path), "CI": ci}
    run = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert run.returncode == status, run.stdout
    assert f"1 passed, 3 {kind}" in run.stdout
    notes = [line for line in run.stdout.splitlines() if "did not run" in line]
    assert notes == [
        f"{thing}: 1 test did not run; {needs.NEEDED[thing][1]}"
        for thing in ("chromium", "bubblewrap", "a C compiler")
    ]


def test_what_is_here_is_used(monkeypatch):
    monkeypatch.setitem(needs.NEEDED, "nothing", (lambda: True, ""))
    needs.need("nothing")


def test_parts_of_the_deep_tests_make_up_all_of_them():
    marks = [{"deep"} if k % 3 else set() for k in range(300)]
    every = [
        SimpleNamespace(nodeid=f"test.py::{k}", get_closest_marker=lambda name, m=m: name in m)
        for k, m in enumerate(marks)
    ]

    def kept(part):
        config, items = Mock(), [*every]
        config.getoption.return_value = part
        pytest_collection_modifyitems(config, items)
        gone = config.hook.pytest_deselected.call_args.kwargs["items"]
        assert {*map(id, items + gone)} == {*map(id, every)}
        return [item.nodeid for item in items if item.get_closest_marker("deep")]

    parts = [kept(f"{k}/3") for k in (1, 2, 3)]
    assert sorted(sum(parts, [])) == sorted(kept("1/1")) and len(kept("1/1")) == 200
    assert min(map(len, parts)) > 40
