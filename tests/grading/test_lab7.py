"""What only lab 7 has: another robot than the five-bar, and crossings judged by what they do."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.grading import Student, read_submission
from fivebar.grading.grade import grade
from fivebar.grading.intake.program import Job
from fivebar.grading.intake.students_robots import biglide_of, robot_from, with_constants
from fivebar.grading.labs import find_lab
from fivebar.grading.samples import beside_type_1, beside_type_2, poses, unequal_biglide
from tests.helpers.lab_session import FOLDERS, SOLUTIONS, load, results

RIGHT = (SOLUTIONS / "lab7.py").read_text("utf-8")
HANDOUT = fb.Biglide()


CROSSING = {
    "quintics between the ends": (
        "return a, b\n",
        "return non_compliant_crossing(x0, y0, x1, y1, T)\n",
        0.25,
        "t_s . (m xi'') = ",
    ),
    "acceleration along t_s": (
        "(ts, 1, vy), (ts, 2, 0.0)",
        "(ts, 1, vy), (ts, 2, 0.1)",
        0.25,
        "ten microseconds before",
    ),
    "acceleration across the bars' line": (
        "vx), (ts, 2, 0.0)])\n    b",
        "vx), (ts, 2, 0.2)])\n    b",
        0.25,
        "ten microseconds before",
    ),
    "no condition at rest": (
        "ends(y0, y1, T) + [(ts, 0, ys)",
        "ends(y0, y1, T)[:5] + [(ts, 0, ys)",
        0.0,
        "it accelerates",
    ),
    "another goal": (
        "ends(y0, y1, T) + [(ts",
        "ends(y0, y1 + 0.01, T) + [(ts",
        0.0,
        "is not at the point: 0.01 m",
    ),
    "too late": (
        "ends(x0, x1, T) + [(ts",
        "ends(x0, x1, 1.1 * T) + [(ts",
        0.0,
        "it is not at the point",
    ),
    "only touched": ("(ts, 1, vx)", "(ts, 1, 0.0)", 0.0, "it must pass through"),
    "there, back and there again": ("(ts, 1, vx)", "(ts, 1, -vx)", 0.0, "it meets Type 2 3 times"),
    "out of reach": ("(ts, 1, vx)", "(ts, 1, 9 * vx)", 0.0, "leaves the space"),
    "one list": ("return a, b\n", "return a\n", 0.0, "two lists are asked"),
    "no list": (
        "return a, b\n",
        "import numpy as np; return np.array(1.0)\n",
        0.0,
        "two lists are asked",
    ),
    "complex": (
        "return a, b\n",
        "import numpy as np; return np.array(a) + 1j, b\n",
        0.0,
        "must be numbers",
    ),
    "at once": (
        "return a, b\n",
        "return [x0, 0, 0, -1e5 * x0, 1e8 * x0], b\n",
        0.0,
        "it is not at the point",
    ),
    "words": ("return a, b\n", "return ['a'], b\n", 0.0, "must be numbers"),
    "no number": ("return a, b\n", "return a, [float('nan')]\n", 0.0, "20 numbers below 1e9"),
    "huge": ("return a, b\n", "return a + [1e308] * 5, b\n", 0.0, "20 numbers below 1e9"),
    "long": ("return a, b\n", "return a + [0.0] * 50, b\n", 0.0, "20 numbers below 1e9"),
    "an integer without end": ("return a, b\n", "return [10**400], b\n", 0.0, "must be numbers"),
    "nested": ("return a, b\n", "return [a, [b]], b\n", 0.0, "must be numbers"),
}


@pytest.mark.parametrize("text, instead, share, words", CROSSING.values(), ids=CROSSING)
def test_crossings_that_are_none(text, instead, share, words):
    assert RIGHT.count(text) == 1
    ((_, verdict),) = results(
        "lab7", RIGHT.replace(text, instead), only="compliant_crossing"
    ).values()
    assert verdict.share == share and words in verdict.text, verdict
    assert verdict.asked.startswith("compliant_crossing(")


def test_a_compliant_crossing_is_no_non_compliant_one():
    mistaken = RIGHT + "\n\nnon_compliant_crossing = compliant_crossing\n"
    ((_, verdict),) = results("lab7", mistaken, only="non_compliant_crossing").values()
    assert verdict.share == 0.25 and "t_s . (m xi'') = " in verdict.text


@pytest.mark.parametrize("seed", range(12))
def test_tasks_of_the_bonus_never_comply_by_luck(seed):
    checks, draw = load("lab7", "test_lab"), np.random.default_rng(seed)
    robot = biglide_of(b"secret", str(seed))
    for x0, y0, x1, y1, T in checks.tasks(robot, draw):
        rest = {1: (0.0, 0.0), 2: (0.0, 0.0)}
        motion = fb.polynomial([(0.0, {0: (x0, y0), **rest}), (T, {0: (x1, y1), **rest})])
        found = fb.check_path(robot, motion, working=(1, -1))
        assert found.type == fb.Singularity.PARALLEL and abs(found.time / T - 0.5) > 0.02
        u = found.pose.A[0]
        assert abs(np.dot((-u[1], u[0]), motion(found.time)[2])) > 0.1 * np.linalg.norm(
            motion(found.time)[2]
        )


@pytest.mark.parametrize("seed", range(4))
def test_samples_are_what_they_say(seed):
    draw, sines = np.random.default_rng(seed), np.array([1, -1] * 4) * np.logspace(-1.2, -6, 8)
    for robot in (HANDOUT, unequal_biglide(draw), biglide_of(b"secret", str(seed))):
        some = poses(robot, draw, 16, assembly=1)
        assert (some.assembly == 1).all() and len(some.q) == 16
        margins = fb.singularity_margins(beside_type_2(robot, draw, sines))
        np.testing.assert_allclose(margins.parallel, sines, rtol=0, atol=1e-14)
        for leg in (0, 1):
            margins = fb.singularity_margins(beside_type_1(robot, draw, sines, leg))
            off = np.abs(margins.serial[:, leg]) - np.abs(sines)
            assert np.all(np.abs(off) < 1e-15 / np.abs(sines))
            assert np.abs(margins.serial[:, 1 - leg]).min() > 0.2
    with pytest.raises(ValueError, match="hardly has"):
        poses(fb.Biglide(l1=0.201, l2=0.201), draw, 16, margin=0.9)


@pytest.mark.deep
def test_graded_for_a_students_own_robot_by_every_door(tmp_path, capsys):
    secret, ids, folder = tmp_path / "secret", tmp_path / "ids.txt", tmp_path / "handed in"
    secret.write_text("a secret", encoding="utf-8")
    ids.write_text("ann\n", encoding="utf-8")
    options = ["--secret-file", str(secret), "--out"]
    assert main(["grade", "lab7", "--hand-out", str(ids), *options, str(folder)]) == 0
    file, robot = Path(capsys.readouterr().out.strip()), biglide_of(b"a secret", "ann")
    with Student(read_submission(file)) as program:
        assert robot_from(HANDOUT, program.constants) == robot != biglide_of(b"a secret", "bob")
    file.write_text(with_constants(RIGHT, robot), encoding="utf-8")
    assert (
        main(
            ["grade", "lab7", str(folder), "--json", "--jobs", "1", *options, str(tmp_path / "out")]
        )
        == 0
    )
    (ann,) = json.loads(capsys.readouterr().out)
    assert ann["points"] == 24 and ann["robot"] == robot.parameters and not ann["faults"]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(FOLDERS["lab7"])]
    command += ["--submission", str(file)]
    assert "24 of 24" in subprocess.run(command, capture_output=True, text=True, timeout=120).stdout


@pytest.mark.deep
def test_a_report_shows_the_bars_and_speaks_of_the_files_numbers(tmp_path):
    file = tmp_path / "student.py"
    file.write_text(RIGHT.replace("h = sqrt(", "h = -sqrt("), encoding="utf-8")
    wrong = next(
        check
        for check in grade(find_lab("lab7"), Job(file), home=True).checks
        if check.outcome != "right"
    )
    assert wrong.figure.startswith("<svg") and wrong.figure.count("<polyline") == 4
    file.write_text(RIGHT.replace("l1 = 0.2828427", "l1 = 0.3"), encoding="utf-8")
    other = grade(find_lab("lab7"), Job(file, robot=HANDOUT))
    assert "l1 = 0.3 (graded for 0.282843)" in other.notes[0] and not other.faults
