"""`fivebar check`, `fivebar grade` and `fivebar.grading.check` as a user meets them, also from an installed wheel."""

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.grading import check
from fivebar.grading.intake.students_robots import hidden_seed, robot_of
from fivebar.grading.labs import known_labs
from fivebar.grading.samples import beside_type_1, beside_type_2, poses
from tests.helpers import ROOT
from tests.helpers.instructors import contents, pack

from ..helpers.grading_lab import CONSTANTS, RIGHT, SHIFTED, UNTOUCHED, write_lab, written

SOLUTION = ROOT / "tests" / "data" / "solutions" / "lab1.py"


@pytest.fixture
def labs(tmp_path):
    return str(write_lab(tmp_path / "mylabs"))


@pytest.fixture
def run(tmp_path, labs, capsys):
    """(exit code, stdout, stderr) of `fivebar COMMAND elbow FILE ... --labs`, the file holding this source."""

    def call(command, source, *options, name="my.py"):
        path = written(tmp_path / name, source)
        code = main([command, "elbow", str(path), "--labs", labs, *map(str, options)])
        return code, *capsys.readouterr()

    return call


def as_json(text):
    """A result without its duration."""
    data = json.loads(text)
    del data["seconds"]
    return data


def test_check_at_home(run, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    code, out, err = run("check", SHIFTED)
    assert (
        (code, err) == (0, "")
        and "1 of 4 points" in out
        and "inputs here are public" in out
        and "\x1b" not in out
    )
    assert run("check", SHIFTED)[1] == out  # the same inputs every time
    assert "Nothing is filled in yet" in run("check", UNTOUCHED)[1]
    assert json.loads(run("check", RIGHT, "--json")[1])["points"] == 4


def test_a_lab_of_the_clone_and_a_notebook(tmp_path, capsys):
    cell = {
        "cell_type": "code",
        "source": SOLUTION.read_text(encoding="utf-8"),
        "metadata": {},
        "outputs": [],
    }
    loop = cell | {"source": "while True:\n    pass\n"}
    notebook = written(
        tmp_path / "my.ipynb",
        json.dumps({"cells": [cell, loop], "nbformat": 4, "nbformat_minor": 5}),
    )
    assert main(["check", "lab1_geometry", str(notebook)]) == 0
    assert "20 of 20 points" in capsys.readouterr().out


@pytest.mark.parametrize(
    "arguments, message",
    [
        (
            ["check", "lab99", "my.py"],
            "no lab 'lab99'; the known ones are: lab1_geometry, lab2_kinematics",
        ),
        (["check", "lab1", "none.py"], "no file 'none.py'"),
        (["check", "lab1"], "student.py is here already: fivebar check lab1_geometry student.py"),
        (["check"], "which lab, and which file of yours? The known ones are: lab1_geometry, "),
        (
            ["check", "lab1", "my.py", "--time-limit", "0"],
            "--time-limit must be finite and > 0, not 0",
        ),
        (["grade", "lab1"], "Name a file or a folder"),
        (["grade", "lab1", "none", "--out", "o"], "no file or folder 'none'"),
        (["grade", "lab1", "."], "needs --out DIR"),
        (
            ["grade", "lab1", ".", "--out", "o", "--jobs", "0"],
            "--jobs must be finite and > 0, not 0",
        ),
        (["grade", "lab1", "empty", "--out", "o"], "holds no submissions"),
        (["grade", "lab1", "my.py", "--secret-file", "none"], "--secret-file"),
        (["grade", "lab1", "my.py", "--out", "o"], "--out is for a folder of submissions"),
        (["grade", "lab1", ".", "--out", "o", "--csv", "x.csv"], "a folder's files go to --out"),
        (["grade", "lab1", "my.py", "--secret-file", "short"], "fewer than 8 bytes"),
        (
            ["grade", "lab1", "empty", "--gradescope", "r.json"],
            "empty: there is no .py, .ipynb or .zip with one",
        ),
        (
            ["grade", "lab1", "--hand-out", ".", "--out", "o"],
            "--hand-out needs --out DIR and the course's secret",
        ),
        (["check", "lab1", "my.py", "--labs", "nowhere"], "--labs: no folder 'nowhere'"),
        (["check", "lab1", "my.py", "--html", "my.py/report.html"], "my.py: File exists"),
    ],
)
def test_wrong_usage_is_told(arguments, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "my.py", UNTOUCHED)
    written(tmp_path / "student.py", UNTOUCHED)
    written(tmp_path / "short", "1234567\n")
    (tmp_path / "empty").mkdir()
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == "" and message in err and err.startswith("fivebar: ") and err.count("\n") == 1


def test_grade_and_grade_again(run, tmp_path):
    code, out, _ = run("grade", SHIFTED, "--json")
    first = as_json(out)
    assert code == 0 and first["points"] == 1 and first["student"] == "my" and not first["home"]
    assert as_json(run("grade", SHIFTED, "--json")[1])["seed"] != first["seed"]
    assert as_json(run("grade", SHIFTED, "--json", "--seed", first["seed"])[1]) == first
    assert "public" not in run("grade", SHIFTED)[1]


@pytest.mark.deep
def test_files_and_exit_codes(run, tmp_path):
    html, table, scope = tmp_path / "r.html", tmp_path / "r.csv", tmp_path / "results.json"
    code, _, err = run(
        "grade",
        SHIFTED,
        "--html",
        html,
        "--csv",
        table,
        "--gradescope",
        scope,
        "--fail-under",
        "26",
    )
    assert code == 1 and "1 of 1 below 26 %: my" in err
    assert (
        "origin in the base joint" in html.read_text("utf-8")
        and len(table.read_text("utf-8").splitlines()) == 4
    )
    assert json.loads(scope.read_text("utf-8"))["score"] == 1
    assert run("grade", SHIFTED, "--fail-under", "25")[0] == 0


def test_gradescope_hands_over_a_folder(labs, tmp_path, capsys):
    written(tmp_path / "submission" / "anything.py", RIGHT)
    command = [
        "grade",
        "elbow",
        str(tmp_path / "submission"),
        "--labs",
        labs,
        "--gradescope",
        str(tmp_path / "r.json"),
        "--csv",
        str(tmp_path / "r.csv"),
    ]
    assert main(command) == 0 and json.loads((tmp_path / "r.json").read_text("utf-8"))["score"] == 4
    assert "graded: submission/anything.py\n" in capsys.readouterr().err
    assert len((tmp_path / "r.csv").read_text("utf-8").splitlines()) > 2  # a row for each check


def test_a_fault_of_the_lab_is_a_failure(run, labs):
    with open(f"{labs}/elbow/test_lab.py", "a", encoding="utf-8") as file:
        file.write("\n\ndef test_broken(ask):\n    1 / 0\n")
    code, out, err = run("check", RIGHT)
    assert (
        code == 1
        and "the lab itself has a fault" in err
        and "ZeroDivisionError" in err
        and "4 of 5 points" in out
    )


@pytest.mark.deep
def test_a_robot_for_each_student(run, labs, tmp_path, capsys, monkeypatch):
    student = written(
        Path(labs) / "elbow" / "student.py", UNTOUCHED.replace("l11 = 0.09", "l11 = 0.09  # left")
    )
    secret, ids = (
        written(tmp_path / "secret", "a secret\n"),
        written(tmp_path / "ids.txt", "\ufeffanna\n\nBob Meier\nANNA \n"),
    )
    out = tmp_path / "handout"
    options = [
        "--labs",
        labs,
        "--hand-out",
        str(ids),
        "--secret-file",
        str(secret),
        "--out",
        str(out),
    ]
    assert main(["grade", "elbow", *options]) == 0
    files = capsys.readouterr().out.split()
    assert len(files) == 2 and files[0] == str(out / "anna" / "student.py")
    source = Path(files[0]).read_text(encoding="utf-8")
    robot = robot_of(b"a secret", "anna")
    assert f"l11 = {robot.l11!r}  # left\n" in source and f"\nm = {robot.m!r}\n" in source
    assert source.splitlines()[8:] == student.read_text(encoding="utf-8").splitlines()[8:]
    solved = source.replace(UNTOUCHED[len(CONSTANTS) :], RIGHT[RIGHT.index("def") :])
    solved = f"from math import cos, sin\n{solved}"
    variant = "--secret-file", secret, "--student", " ANNA"
    result = as_json(run("grade", solved, *variant, "--json")[1])
    assert (
        result["points"] == 4
        and result["robot"] == robot.parameters
        and result["seed"] == hidden_seed(b"a secret", "elbow")
    )
    assert result == as_json(run("grade", solved, *variant, "--json")[1])
    monkeypatch.setenv("FIVEBAR_SECRET", "a secret")
    assert (
        as_json(run("grade", solved, *variant[2:], "--json")[1]) == result
        and "FIVEBAR_SECRET" not in os.environ
    )
    assert "looks like  not your robot" in run("grade", RIGHT, *variant)[1]
    assert "4 of 4" in run("check", solved)[1]  # at home for the robot of the file
    assert "1 of 4" in run("grade", solved)[1]  # the handout's robot unless a secret is given
    student.write_text("def elbow(q11):\n    pass\n", encoding="utf-8")
    assert (
        main(["grade", "elbow", *options]) == 2 and "no line `l11 = ...`" in capsys.readouterr().err
    )


def test_variants_are_near_the_default_and_hold_every_kind_of_sample():
    robots = [robot_of(b"secret", f"student {k}") for k in range(300)]
    assert len(set(robots)) == 300 and robots == [
        robot_of(b"secret", f" STUDENT {k}") for k in range(300)
    ]
    assert robot_of(b"secreu", "student 0") != robots[0]
    for robot in robots:
        assert robot.l11 == robot.l21 and robot.l12 == robot.l22
        assert all(
            abs(length - near) <= 0.011
            for length, near in ((robot.l11, 0.09), (robot.l12, 0.09), (robot.d, 0.118))
        )
        assert round(robot.d * 1000, 9) == round(robot.d * 1000)
    draw, sines = np.random.default_rng(1), np.array([1e-2, -1e-3])
    for robot in robots[:10]:
        for modes in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            poses(robot, draw, 16, working=modes)
        poses(robot, draw, 16, assembly=1)
        (
            beside_type_1(robot, draw, sines, 0),
            beside_type_1(robot, draw, sines, 1),
            beside_type_2(robot, draw, sines),
        )


def test_functions_of_a_notebook(labs):
    scope = {}
    exec(SHIFTED, scope)
    report = check("elbow", elbow=scope["elbow"], labs=labs)
    assert (report.points, report.home) == (1, True)
    assert "origin in the base joint" in repr(report) and "<svg" not in repr(report)
    assert (
        report._repr_html_().startswith("<style>")
        and "origin in the base joint" in report._repr_html_()
    )
    scope = {}
    exec(RIGHT.replace("0.118", "0.12"), scope)
    report = check("elbow", elbow=scope["elbow"], labs=labs)
    assert report.points == 4 and report.robot["d"] == 0.12 and scope["d"] == 0.12
    with pytest.raises(TypeError, match="check a file"):
        check("elbow", labs=labs)


@pytest.mark.deep
def test_a_terminal_of_few_letters(tmp_path, labs):
    path = written(
        tmp_path / "my.py", SHIFTED.replace("return", "assert q11 > 9, 'é'  # π\n    return")
    )
    run = subprocess.run(
        [sys.executable, "-m", "fivebar", "check", "elbow", str(path), "--labs", labs],
        capture_output=True,
        cwd=ROOT,
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
        timeout=60,
    )
    assert run.returncode == 0 and b"\\xe9" in run.stdout and b"\\u03c0" in run.stdout


@pytest.mark.deep
def test_an_installed_wheel_finds_the_labs(tmp_path):
    """The build's own files only, far from the clone."""
    source = tmp_path / "source"
    for part in ("fivebar", "labs"):
        shutil.copytree(
            ROOT / part, source / part, symlinks=True, ignore=shutil.ignore_patterns("__pycache__")
        )
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    build = [sys.executable, "-c", "import setuptools.build_meta as b; print(b.build_wheel('.'))"]
    made = subprocess.run(build, cwd=source, capture_output=True, text=True, timeout=120)
    assert made.returncode == 0, made.stderr
    with zipfile.ZipFile(next(source.glob("*.whl"))) as wheel:
        wheel.extractall(tmp_path / "site")
    shutil.rmtree(source)
    run = subprocess.run(
        [sys.executable, "-P", "-m", "fivebar", "check", "lab1", str(SOLUTION), "--json"],
        cwd=tmp_path,
        text=True,
        capture_output=True,
        env=os.environ | {"PYTHONPATH": str(tmp_path / "site")},
        timeout=120,
    )
    assert run.returncode == 0, run.stderr
    assert json.loads(run.stdout)["points"] == 20
    packed = {path.read_bytes() for path in (tmp_path / "site").rglob("*") if path.is_file()}
    assert not packed & {
        path.read_bytes() for name, path in contents().items() if name != "course.md"
    }
    inside = {
        path.parent.name for path in (tmp_path / "site" / "fivebar" / "_labs").glob("*/test_lab.py")
    }
    assert inside == {lab.name for lab in known_labs()}


def test_the_instructors_package_has_every_solution_and_every_answer(tmp_path):
    assert pack(tmp_path / "i.zip") == len(contents())
    with zipfile.ZipFile(tmp_path / "i.zip") as archive:
        names = set(archive.namelist())
    assert {f"solutions/lab{k}.py" for k in range(1, 8)} | {
        f"answers/{k:02d}.md" for k in range(13)
    } <= names
    assert "course.md" in names


def test_the_default_robot_is_the_handouts():
    assert {
        name: value for name, value in (line.split(" = ") for line in CONSTANTS.splitlines())
    } == {name: repr(value) for name, value in fb.FiveBar().parameters.items()}


@pytest.mark.deep
def test_no_message_moves_the_cursor(labs, tmp_path, capsys):
    for name in ("\x1b[31mred\u202e.py", "b.py"):
        written(tmp_path / "folder" / name, f"{UNTOUCHED}# {len(name)}\n")
    out = [
        "--labs",
        str(labs),
        "--isolate",
        "process",
        "--out",
        str(tmp_path / "out"),
        "--fail-under",
        "50",
    ]
    assert main(["grade", "elbow", str(tmp_path / "folder"), *out]) == 1
    scope = ["--labs", str(labs), "--gradescope", str(tmp_path / "x.json")]
    assert (
        main(["grade", "elbow", str(tmp_path / "folder"), *scope]) == 0
    )  # the one that can be read
    text = "".join(capsys.readouterr())
    assert (
        text.count("\\x1b[31mred\\u202e") >= 3 and "\x1b[31m" not in text and "\u202e" not in text
    )
