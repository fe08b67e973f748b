"""A machine without a browser, bubblewrap and compiler: tests are skipped and named; in CI they fail."""

import os
import subprocess
import sys

import pytest

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
    def collected(*options):
        command = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-p", "no:cacheprovider"]
        file = "tests/models/test_compiled.py"
        run = subprocess.run(
            [*command, *options, file], cwd=ROOT, capture_output=True, text=True, check=True
        )
        return [line for line in run.stdout.splitlines() if line.startswith(file)]

    every = collected("-m", "deep")
    parts = [collected("-m", "deep", "--deep-part", f"{k}/3") for k in (1, 2, 3)]
    assert sorted(sum(parts, [])) == sorted(every) and all(parts)
    assert collected("--deep-part", "2/3") == collected()
