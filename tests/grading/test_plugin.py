"""The checks as pytest runs them: both doors, the seed, and a lab's own fault told from a student's."""

import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.grading import Reply
from fivebar.grading.grade import grade, run_checks
from fivebar.grading.intake.program import Job, Program
from fivebar.grading.labs import Lab, find_lab
from tests.helpers import DATA, LABS

from ..helpers.grading_lab import HALF, HANGS, RIGHT, SHIFTED, write_lab, written

SOLUTION = DATA / "solutions" / "lab1.py"


def pytest_run(*arguments, cwd):
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *map(str, arguments)]
    run = subprocess.run(command, capture_output=True, text=True, cwd=cwd, timeout=120)
    return run.returncode, run.stdout + run.stderr


@pytest.mark.deep
def test_a_lab_of_the_clone_runs_by_plain_pytest(tmp_path):
    code, text = pytest_run(LABS / "lab1_geometry", "--submission", SOLUTION, cwd=tmp_path)
    assert code == 0 and "20 of 20 points" in text
    code, text = pytest_run(
        LABS / "lab1_geometry", LABS / "lab2_kinematics", "--submission", SOLUTION, cwd=tmp_path
    )
    assert code == 1 and "20 of 40 points" in text and "no function dkm" in text
    code, text = pytest_run(LABS / "lab1_geometry", cwd=tmp_path)
    assert code == 4 and "Give --submission FILE" in text and "Traceback" not in text
    code, text = pytest_run(LABS / "lab1_geometry", "--submission", "none.py", cwd=tmp_path)
    assert code == 4 and "no file 'none.py'" in text


@pytest.mark.deep
def test_a_lab_of_ones_own_runs_by_plain_pytest(tmp_path):
    write_lab(tmp_path / "mylabs")
    written(tmp_path / "my.py", SHIFTED)
    code, text = pytest_run(
        "-p", "fivebar.grading.plugin", "mylabs/elbow", "--submission", "my.py", cwd=tmp_path
    )
    assert code == 1 and "1 of 4 points" in text and "2 failed, 1 passed" in text
    assert "origin in the base joint" in text and "exercises.py" not in text


@pytest.fixture
def elbow(tmp_path):
    return find_lab("elbow", write_lab(tmp_path / "mylabs"))


def graded(lab, tmp_path, source, **choices):
    return grade(lab, Job(written(tmp_path / "my.py", source), **choices))


def test_what_the_readme_shows(elbow, tmp_path):
    right, shifted, half = (graded(elbow, tmp_path, source) for source in (RIGHT, SHIFTED, HALF))
    assert (right.points, right.max_points, right.faults) == (4, 4, ())
    assert [check.outcome for check in right.checks] == ["right"] * 3
    assert (
        right.checks[2].title == "elbow: half a turn leads to the other side"
        and right.checks[2].max_points == 1
    )
    assert [check.outcome for check in shifted.checks] == ["wrong", "wrong", "right"]
    assert (
        shifted.checks[0].misconception == "origin in the base joint"
        and shifted.checks[0].function == "elbow"
    )
    assert shifted.checks[0].off == pytest.approx(0.059, rel=1e-9)
    assert half.checks[0].outcome == "partly" and half.checks[0].points == round(
        2 * half.checks[0].share, 2
    )
    assert half.checks[0].reason == "exception" and half.checks[0].place == "line 12"
    assert (
        half.checks[2].outcome == "wrong" and "no" in half.checks[2].text
    )  # ask.call passes on what happened


def test_grading_is_alone_in_its_process(elbow, tmp_path, monkeypatch):
    """No option, plugin or conftest.py of the surroundings is read; no file is left; a changed lab is read anew."""
    for folder in (tmp_path, elbow.folder, elbow.folder.parent):
        written(folder / "conftest.py", "raise SystemExit('read')")
        written(folder / "pytest.ini", "[pytest]\naddopts = --nonsense\n")
    monkeypatch.setenv("PYTEST_ADDOPTS", "--nonsense")
    monkeypatch.chdir(tmp_path)
    before = {path for path in tmp_path.rglob("*")} | {tmp_path / "my.py"}
    environment = dict(os.environ)
    assert graded(elbow, tmp_path, RIGHT).points == 4
    assert set(tmp_path.rglob("*")) == before
    assert {key: os.environ.get(key) for key in environment if key != "PYTEST_CURRENT_TEST"} == {
        key: value for key, value in environment.items() if key != "PYTEST_CURRENT_TEST"
    }
    tests = elbow.tests.read_text("utf-8")
    elbow.tests.write_text(tests.replace("points(2)", "points(5)"), encoding="utf-8")
    assert graded(elbow, tmp_path, RIGHT).points == 7


@pytest.mark.parametrize(
    "fault, text",
    [
        (
            "ask('shoulder', [0.0])",
            "LookupError: exercises.py has no exercise 'shoulder'; it has elbow",
        ),
        ("1 / 0", "ZeroDivisionError: division by zero"),
        ("ask.verdict(2.0)", "ValueError: a verdict's share must lie in 0..1"),
        ("pytest.skip('not today')", "not today"),
        ("ask('elbow', [float('nan')])", "the right elbow has no answer in row 0"),
    ],
)
def test_a_fault_of_the_check_is_not_the_students(elbow, tmp_path, fault, text):
    with elbow.tests.open("a") as file:
        file.write(f"\n\ndef test_broken(ask):\n    ask('elbow', [0.5])\n    {fault}\n")
    report = graded(elbow, tmp_path, RIGHT)
    assert [check.outcome for check in report.checks] == ["right"] * 3 + ["broken"]
    assert text in report.checks[-1].text and text in report.faults[0]
    words = " ".join(repr(report).split())
    assert "This is a fault of the lab, not yours" in words and "does not count" in words


def test_a_lab_that_cannot_be_read_is_a_fault(elbow, tmp_path):
    elbow.tests.write_text("import nothing_of_this_name\n", encoding="utf-8")
    assert "nothing_of_this_name" in graded(elbow, tmp_path, RIGHT).faults[0]
    elbow.tests.write_text("x = 1\n", encoding="utf-8")
    assert "are there tests" in graded(elbow, tmp_path, RIGHT).faults[0]


def test_verdicts_of_a_checks_own(elbow, tmp_path):
    with elbow.tests.open("a") as file:
        file.write(
            "\n\n@pytest.mark.points(4)\ndef test_own(ask):\n"
            "    ask.verdict(0.25, 'too slow', asked='a rise', came='2 s', off=0.5)\n\n"
            "def test_call(ask):\n    ask.call('shoulder', 1.0)\n"
        )
    *_, own, call = graded(elbow, tmp_path, RIGHT).checks
    assert (own.points, own.outcome, own.text, own.asked, own.came, own.off) == (
        1.0,
        "partly",
        "too slow",
        "a rise",
        "2 s",
        0.5,
    )
    assert (call.points, call.reason, call.asked) == (0.0, "missing", "shoulder(1)")


def inputs(lab, program, seed):
    """What the checks ask a recording student."""
    student = Recorder()
    run_checks(lab, replace(program, student=student), seed)
    return student.asked


class Recorder:
    trouble, output, notes = None, "", ()

    def __init__(self, kind="exception", constants=None):
        self.asked, self.kind, self.constants = [], kind, constants or {}

    def ask(self, function, rows, constants=None, limit=None):
        self.asked.append((function, rows, constants))
        return [Reply(self.kind, text="ValueError: no")] * len(rows)


def test_the_seed_decides_the_inputs(elbow):
    program = Program(None, fb.FiveBar())
    one, same, other = (inputs(elbow, program, seed) for seed in ("a", "a", "b"))
    assert one == same and one[0][1] != other[0][1]
    assert one[0][1] != one[1][1]  # each check has its own


def test_a_robot_is_set_where_the_file_names_it(elbow):
    student = Recorder(constants={"l11": 0.09, "m": 0.5, "q": 1.0})
    run_checks(elbow, Program(student, fb.FiveBar()), "a")
    constants = [asked[2] for asked in student.asked]
    assert constants[0] is None and {"l11": 0.1, "m": 0.5} in constants


def test_a_function_that_always_hangs_is_not_asked_again(elbow):
    student = Recorder("timeout")
    found = run_checks(elbow, Program(student, fb.FiveBar()), "a").found
    assert len(student.asked) == 1 and [check.reason for check in found] == [
        "timeout",
        "unasked",
        "unasked",
    ]
    assert "every call of an earlier check ran past its time limit" in found[1].text


def test_a_hang_and_the_lines_after_a_crash(elbow, tmp_path):
    report = graded(elbow, tmp_path, HANGS, limit=0.3)
    assert [check.reason for check in report.checks] == ["timeout", "unasked", "unasked"]
    assert [check.source for check in report.checks] == ["sleep(1)"] * 3
    report = graded(elbow, tmp_path, f"import no_such_package\n{RIGHT}")
    assert report.points == 4 and "line 1, `import no_such_package`" in report.trouble


@pytest.mark.deep
def test_the_answers_for_another_robot_are_named(elbow, tmp_path):
    own = fb.FiveBar(l11=0.085, l12=0.085, l21=0.085, l22=0.085, d=0.12)
    report = graded(elbow, tmp_path, RIGHT, robot=own)
    assert (
        report.checks[0].misconception == "not your robot" and report.checks[1].outcome == "right"
    )
    assert "l11 = 0.09 (graded for 0.085)" in report.notes[-1]
    report = graded(
        elbow, tmp_path, RIGHT.replace("0.09", "0.085").replace("0.118", "0.12"), robot=own
    )
    assert report.points == report.max_points


def test_every_lab_shipped_is_found_by_both_names():
    assert find_lab("lab1").name == find_lab("lab1_geometry").name == "lab1_geometry"
    exercises = Lab(LABS / "lab1_geometry").exercises()
    assert np.isfinite(
        exercises["dgm"].outcome(
            exercises["dgm"].answer, fb.FiveBar(), [np.zeros(1)] * 2 + [-np.ones(1)]
        )
    ).all()


@pytest.mark.deep
def test_a_lab_on_the_biglide(tmp_path):
    folder = tmp_path / "mylabs" / "slide"
    written(
        folder / "exercises.py",
        "import fivebar as fb\nfrom fivebar.grading import Exercise\nROBOT = fb.Biglide()\n"
        "EXERCISES = [Exercise('base(side) -> x', lambda robot, side: side * robot.d / 2)]\n",
    )
    written(
        folder / "test_lab.py",
        "import fivebar as fb\n\ndef test_own(ask, robot):\n    ask('base', [1.0, -1.0])\n    assert robot.d == 0.5\n\n"
        "def test_other(ask):\n    ask('base', [1.0, -1.0], robot=fb.Biglide(d=0.3))\n",
    )
    lab = find_lab("slide", folder.parent)
    source = "d = 0.5\nm = 3.0\ndef base(side):\n    return side * d / 2\n"
    home = graded(lab, tmp_path, source)
    assert home.points == 2 and home.notes == ("Graded for the robot of this file: d = 0.5.",)
    away = graded(lab, tmp_path, source, robot=fb.Biglide())
    assert away.points == 1 and away.notes == (
        "The constants of your file are another robot's: d = 0.5 (graded for 0.4).",
    )
    own = graded(lab, tmp_path, source.replace("0.5", "0.4"), robot=fb.Biglide(d=0.5)).checks[0]
    assert own.misconception == "not your robot"
