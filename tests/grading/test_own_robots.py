"""Labs on mechanisms that fivebar has no models of: a slider-crank with its own lengths."""

import csv
import json
import subprocess
import sys

import nbformat.v4
import pytest

from fivebar.base.errors import UsageError
from fivebar.cli import main
from fivebar.grading import check
from fivebar.grading.grade import grade
from fivebar.grading.intake.program import Job
from fivebar.grading.labs import find_lab

from ..helpers.grading_lab import RIGHT, write_lab, written

EXERCISES = """
import numpy as np
from fivebar.grading import Exercise, Misconception

def slider(robot, phi):
    across = robot.crank * np.sin(phi) - robot.offset
    return robot.crank * np.cos(phi) + np.sqrt(robot.rod**2 - across**2)

def without_offset(robot, phi):
    return robot.crank * np.cos(phi) + np.sqrt(robot.rod**2 - (robot.crank * np.sin(phi)) ** 2)

def speed(robot, phi, phiD):
    across = robot.crank * np.sin(phi) - robot.offset
    lever = np.sin(phi) + across * np.cos(phi) / np.sqrt(robot.rod**2 - across**2)
    return -phiD * robot.crank * lever

offset_forgotten = Misconception("offset forgotten", "Where does the guide pass?", without_offset)
EXERCISES = [
    Exercise("slider(q11) -> x", slider, wrong=(offset_forgotten,)),
    Exercise("speed(q11, q11D) -> xD", speed),
]
FILE = "crank.py"
"""
TESTS = """
def test_slider(ask, draw):
    ask("slider", draw.uniform(-3, 3, 10))

def test_slider_of_another(ask, robot, draw):
    ask("slider", draw.uniform(-3, 3, 10), robot=type(robot)(crank=0.04, rod=0.2, offset=-0.02))

def test_speed(ask, draw):
    ask("speed", draw.uniform(-3, 3, 10), draw.uniform(-5, 5, 10))
"""
FIELDS = "    crank: float = 0.05\n    rod: float = 0.15\n    offset: float = 0.01\n"
TUPLE = f"from typing import NamedTuple\nclass Crank(NamedTuple):\n{FIELDS}"
CLASS = f"from dataclasses import dataclass\n@dataclass\nclass Crank:\n{FIELDS}"
LINKAGE = "from fivebar.linkages import SliderCrank\nROBOT = SliderCrank(0.05, 0.15, 0.01)\n"
ROBOTS = {
    "a dataclass": f"from __future__ import annotations\n{CLASS}ROBOT = Crank()\n",
    "a NamedTuple": f"{TUPLE}ROBOT = Crank()\n",
    "a linkage": LINKAGE,
    "of a module beside": "from mechanism import Crank\nROBOT = Crank()\n",
}
# The stroke's formula, and its derivative by hand.
ANSWER = """
from math import cos, sin, sqrt
crank, rod, offset = 0.05, 0.15, 0.01
def slider(q11):
    return crank * cos(q11) + sqrt(rod**2 - (crank * sin(q11) - offset) ** 2)
def speed(q11, q11D):
    across = crank * sin(q11) - offset
    root = sqrt(rod**2 - across**2)
    return -crank * sin(q11) * q11D - across * crank * cos(q11) / root * q11D
"""
WRONG = ANSWER.replace("crank * sin(q11) - offset)", "crank * sin(q11))")
LETTER = ANSWER.replace("-crank * sin(q11)", "-crank * cos(q11)")


def lab_with(folder, robot):
    """Return the lab of the slider-crank on a robot."""
    written(folder / "crank" / "exercises.py", robot + EXERCISES)
    written(folder / "crank" / "test_lab.py", TESTS)
    written(folder / "crank" / "mechanism.py", CLASS)
    return find_lab("crank", folder)


@pytest.mark.every(4)
@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
def test_a_lab_on_a_mechanism_of_ones_own(robot, tmp_path):
    lab = lab_with(tmp_path / "labs", robot)
    path = written(tmp_path / "crank.py", ANSWER)
    right = grade(lab, Job(path, robot=lab.robot()))
    assert (right.points, right.faults, right.notes) == (3, (), ())
    assert right.robot == {"crank": 0.05, "rod": 0.15, "offset": 0.01}
    wrong = check("crank", written(tmp_path / "crank.py", WRONG), labs=tmp_path / "labs")
    assert [c.misconception for c in wrong.checks] == ["offset forgotten", "offset forgotten", ""]
    assert (wrong.points, wrong.faults) == (1, ())
    longer = ANSWER.replace("0.05, 0.15", "0.06, 0.15")
    own = check("crank", written(tmp_path / "crank.py", longer), labs=tmp_path / "labs")
    assert own.points == 3 and own.notes == ("Graded for the robot of this file: crank = 0.06.",)
    given = grade(lab, Job(tmp_path / "crank.py", robot=lab.robot()))
    assert given.points == 1 and "crank = 0.06 (graded for 0.05)" in given.notes[0]


def test_a_folder_of_a_lab_on_a_mechanism_of_ones_own(tmp_path, capsys):
    lab_with(tmp_path / "labs", ROBOTS["of a module beside"])
    for name, source in {"anna": ANSWER, "bert": WRONG, "carl": LETTER}.items():
        written(tmp_path / "all" / name / "crank.py", source)
    out = tmp_path / "out"
    command = ["grade", "crank", str(tmp_path / "all"), "--labs", str(tmp_path / "labs")]
    assert main([*command, "--out", str(out)]) == 0
    rows = csv.DictReader((out / "marks.csv").read_text("utf-8-sig").splitlines())
    assert [(row["mark"], row["state"]) for row in rows] == [(m, "graded") for m in "312"]
    carl = json.loads(next((out / "students").glob("carl*.json")).read_text("utf-8"))
    assert "sine and cosine exchanged" in carl["checks"][2]["misconception"]
    capsys.readouterr()
    assert main([*command, "--out", str(out)]) == 0
    assert "3 of 3 are graded already" in capsys.readouterr().err


def test_plain_pytest_on_a_mechanism_of_ones_own(tmp_path):
    lab = lab_with(tmp_path / "labs", ROBOTS["a dataclass"])
    path = written(tmp_path / "crank.py", WRONG)
    words = [sys.executable, "-m", "pytest", "-q", "-p", "fivebar.grading.plugin", str(lab.folder)]
    ran = subprocess.run([*words, f"--submission={path}"], capture_output=True, text=True)
    assert "1 of 3 points" in ran.stdout and "offset forgotten" in ran.stdout


@pytest.mark.parametrize(
    "robot", ["class Crank:\n    crank = 0.05\nROBOT = Crank()\n", f"{CLASS}ROBOT = Crank\n"]
)
def test_an_object_without_named_numbers_is_refused_at_once(robot, tmp_path, capsys):
    with pytest.raises(UsageError, match="ROBOT must be an object of a dataclass or a NamedTuple"):
        lab_with(tmp_path / "labs", robot).robot()
    path = written(tmp_path / "crank.py", ANSWER)
    for command in ("check", "grade"):
        assert main([command, "crank", str(path), "--labs", str(tmp_path / "labs")]) == 2
        assert "ROBOT must be" in capsys.readouterr().err


def test_a_lab_with_a_fault_leads_to_no_mark(tmp_path, capsys):
    lab = lab_with(tmp_path / "labs", LINKAGE)
    written(lab.tests, f"{TESTS}\ndef test_of_a_five_bar(robot):\n    robot.drives\n")
    path = written(tmp_path / "all" / "anna" / "crank.py", ANSWER)
    options = ["--labs", str(tmp_path / "labs")]
    command = ["grade", "crank", str(tmp_path / "all"), *options, "--out", str(tmp_path / "out")]
    assert main(command) == 1
    (row,) = csv.DictReader((tmp_path / "out" / "marks.csv").read_text("utf-8-sig").splitlines())
    assert (row["crank"], row["mark"], row["state"]) == ("", "", "not graded: crank")
    scope = tmp_path / "results.json"
    assert main(["grade", "crank", str(path), *options, "--gradescope", str(scope)]) == 1
    assert "the lab itself has a fault" in capsys.readouterr().err and not scope.exists()


def test_no_robots_are_handed_out_of_a_kind_that_is_not_drawn(tmp_path, capsys):
    lab = lab_with(tmp_path / "labs", LINKAGE)
    written(lab.folder / "student.py", ANSWER)
    secret, ids = written(tmp_path / "secret", "12345678"), written(tmp_path / "ids.txt", "anna\n")
    options = {"--labs": lab.folder, "--hand-out": ids, "--secret-file": secret, "--out": tmp_path}
    words = [str(word) for pair in options.items() for word in pair]
    assert main(["grade", "crank", *words]) == 2
    assert "crank needs HAND_OUT in its exercises.py" in capsys.readouterr().err


def test_without_a_file_to_fill_in_the_lab_says_what_the_file_is_called(tmp_path, capsys):
    lab_with(tmp_path / "labs", LINKAGE)
    assert main(["check", "crank", "--labs", str(tmp_path / "labs")]) == 2
    assert "none to fill in: fivebar check crank crank.py" in capsys.readouterr().err


def test_numbers_are_asked_for_only_where_answers_depend_on_them(tmp_path):
    write_lab(tmp_path / "labs")
    text = RIGHT.replace("l11 = 0.09\n", "").replace("zz1 = 0.002\n", "").replace("l11", "0.09")
    path = written(tmp_path / "my.py", text.replace("-d / 2 + ", ""))
    (note, *_) = check("elbow", path, labs=tmp_path / "labs").notes
    assert note.startswith("Your program gives no number to l11: it is judged")


def test_a_notebook_that_is_saved_as_py_is_graded_as_one(tmp_path):
    write_lab(tmp_path / "labs")
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(RIGHT)])
    path = written(tmp_path / "my.py", nbformat.writes(book))
    found = check("elbow", path, labs=tmp_path / "labs")
    assert found.points == found.max_points
    assert found.notes[0].startswith("my.py is a notebook, and is graded as one")


def test_a_function_called_as_one_of_the_ten_models_may_have_other_arguments(tmp_path):
    write_lab(tmp_path / "labs")
    exercises = tmp_path / "labs" / "elbow" / "exercises.py"
    text = exercises.read_text("utf-8").replace('"elbow(q11)', '"dgm(q11)')
    exercises.write_text(text, encoding="utf-8")
    tests = exercises.with_name("test_lab.py")
    tests.write_text(tests.read_text("utf-8").replace('("elbow"', '("dgm"'), encoding="utf-8")
    source = RIGHT.replace("def elbow", "def dgm").replace("l11 * sin(q11)", "l11 * sin(q11) / 2")
    found = check("elbow", written(tmp_path / "my.py", source), labs=tmp_path / "labs")
    assert found.checks[0].spot == "line 11: 2: right answers come with 1"
