"""`fivebar check amoro`: the lab's own file, its constants, its threshold, and controllers by `fivebar run --mark`."""

import json
import re

import pytest

from fivebar.grading.grade import grade
from fivebar.grading.labs import find_lab
from fivebar.grading.program import Job
from fivebar.grading.report.text import told
from tests.amoro.test_run import run
from tests.helpers import LABS
from tests.helpers.hand_ins import FOLDER

HELPERS = (FOLDER / "helpers.py").read_text("utf-8")


def report(folder, source, lab="amoro"):
    path = folder / "five_bar_models.py"
    path.write_text(source, encoding="utf-8")
    return grade(find_lab(lab), Job(path, seed="test"))


@pytest.mark.parametrize("inertia", ["0.002", "1.0 * 0.045 * 0.045", "2.0e-3 + 0"])
def test_both_inertias_of_the_labs_papers_are_right(tmp_path, inertia):
    assert report(tmp_path, HELPERS.replace("1.0 * 0.045 * 0.045", inertia)).points == 20


@pytest.mark.deep
def test_another_robots_length_is_said(tmp_path):
    found = report(tmp_path, HELPERS.replace("d = 0.118", "d = 0.18"))
    assert found.points < 20 and "d = 0.18, the lab's robot 0.118: graded for that" in " ".join(
        found.notes
    )


def test_the_labs_own_threshold_stands_beside_ours(tmp_path):
    """An error of 1e-5 is OK for the lab's mean of 1e-3, and none for us."""
    found = report(
        tmp_path, HELPERS.replace("return OA13[0], OA13[1]", "return OA13[0] + 1e-5, OA13[1]")
    )
    check = next(check for check in found.checks if check.name == "test_dgm_oscillating")
    assert check.outcome == "wrong" and re.match(
        r"mean errors 1e-05 and .*: OK \(threshold 0\.001\)", check.beside
    )
    coarse = report(
        tmp_path, HELPERS.replace("return OA13[0], OA13[1]", "return OA13[0] + 1e-2, OA13[1]")
    )
    assert "error in model" in coarse.checks[0].beside


def test_what_follows_rightly_from_a_wrong_dgm_keeps_its_points(tmp_path):
    wrong = HELPERS.replace("return OA13[0], OA13[1]", "return OA13[0] + d/2, OA13[1]")
    checks = report(tmp_path, wrong).checks
    assert {c.misconception for c in checks if c.function == "dgm"} == {
        "origin in the left base joint"
    }
    passive = [c for c in checks if c.function == "dgm_passive"]
    assert [c.share for c in passive] == [1.0, 1.0]
    notes = (
        "judged with the right dgm in place of your own, which is wrong (origin in the left base"
        " joint)"
    )
    assert all(notes in c.remarks for c in passive)


def test_numpy_by_way_of_the_labs_star_import(tmp_path):
    assert report(tmp_path, HELPERS.replace("import numpy as np\n", "")).points == 20


def test_what_may_be_told_of_hidden_inputs_holds_no_number_of_the_programs(tmp_path):
    checks = report(
        tmp_path, HELPERS.replace("return OA13[0], OA13[1]", "return OA13[0] + 0.0123, OA13[1]")
    ).checks
    assert checks[0].misconception == "x is off by 0.0123 in every row"
    assert ("looks like", "x is off by # in every row") in list(told(checks[0]))


def test_what_an_older_numpy_took_is_graded_and_said(tmp_path):
    found = report(tmp_path, (FOLDER / "columns.py").read_text("utf-8"))
    assert found.points == 20
    assert any("graded as it ran before" in note and "A11A12[1]" in note for note in found.notes)


def tracked(folder, task, gains, *arguments, code=0):
    script = (
        (LABS / "amoro/control.py")
        .read_text("utf-8")
        .replace("KP, KD = 100.0, 20.0", f"KP, KD = {gains}")
    )
    (folder / "chosen_models.py").write_text(
        (LABS / "amoro/chosen_models.py").read_text("utf-8"), encoding="utf-8"
    )
    return run(folder, script, "--mark", task, "--json", *arguments, code=code)


@pytest.mark.deep
@pytest.mark.parametrize(
    "gains, task, low, high", [("100.0, 20.0", "1", 20, 20), ("100.0, 20.0", "2", 0, 0)]
)
def test_the_tracking_error_is_the_mark(tmp_path, gains, task, low, high):
    """Computed torque follows task 1 and is lost at the singularity of task 2."""
    found = json.loads(tracked(tmp_path, task, gains).stdout)["tracking"]
    assert low <= found["points"] <= high and found["of"] == 20
    assert (found["largest_error_m"] < 1e-4) == (task == "1")


@pytest.mark.deep
def test_a_mark_is_for_the_five_bar_and_for_the_whole_task(tmp_path):
    assert "it needs a five-bar" in tracked(tmp_path, "1", "100.0, 20.0", "biglide", code=1).stderr
    assert (
        "the task at 2 s (--until)"
        in tracked(tmp_path, "1", "100.0, 20.0", "--until", "1", code=1).stderr
    )
