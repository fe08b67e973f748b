"""`fivebar check amoro`: the lab's own file, its constants, its threshold, and controllers by `fivebar run --mark`."""

import csv
import io
import json
import re
from pathlib import Path

import pytest

from fivebar.cli import main
from fivebar.grading.grade import grade
from fivebar.grading.intake.program import Job
from fivebar.grading.labs import find_lab
from fivebar.grading.report.text import told
from tests.helpers import LABS
from tests.helpers.hand_ins import FOLDER

from ..helpers.grading_lab import written

HELPERS = (FOLDER / "helpers.py").read_text("utf-8")


def report(folder, source, lab="amoro"):
    path = folder / "five_bar_models.py"
    path.write_text(source, encoding="utf-8")
    return grade(find_lab(lab), Job(path, seed="test"))


@pytest.mark.every(3)
@pytest.mark.parametrize("inertia", ["0.002", "1.0 * 0.045 * 0.045", "2.0e-3 + 0"])
def test_both_inertias_of_the_labs_papers_are_right(tmp_path, inertia):
    assert report(tmp_path, HELPERS.replace("1.0 * 0.045 * 0.045", inertia)).points == 20


@pytest.mark.deep
def test_another_robots_length_is_said(tmp_path):
    found = report(tmp_path, HELPERS.replace("d = 0.118", "d = 0.18"))
    assert found.points < 20 and "d = 0.18, but the lab's robot has 0.118" in " ".join(found.notes)


@pytest.mark.deep
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


@pytest.mark.deep
def test_what_follows_rightly_from_a_wrong_dgm_keeps_its_points(tmp_path):
    wrong = HELPERS.replace("return OA13[0], OA13[1]", "return OA13[0] + d/2, OA13[1]")
    checks = report(tmp_path, wrong).checks
    assert {c.misconception for c in checks if c.function == "dgm"} == {
        "origin in the left base joint"
    }
    passive = [c for c in checks if c.function == "dgm_passive"]
    assert [c.share for c in passive] == [1.0, 1.0]
    notes = "judged with the right dgm in place of your own, which is wrong"
    assert all(notes in c.remarks for c in passive)


@pytest.mark.deep
def test_a_wrong_dkm_costs_nothing_in_a_dynamic_model_that_calls_it(tmp_path):
    right = (FOLDER / "biglide_loops.py").read_text("utf-8")
    wrong = right.replace(
        "def dkm(q11, q12, q21, q22, q11D, q21D):",
        """
def dkm(q11, q12, q21, q22, q11D, q21D):
    return [rate + 0.1 * q11D for rate in other_dkm(q11, q12, q21, q22, q11D, q21D)]


def other_dkm(q11, q12, q21, q22, q11D, q21D):""",
    )
    checks = report(tmp_path, wrong, "amoro-biglide").checks
    assert {check.function for check in checks if check.share < 1} == {"dkm"}
    remarks = {remark for check in checks for remark in check.remarks}
    assert "judged with the right dkm in place of your own, which is wrong" in remarks


def test_numpy_by_way_of_the_labs_star_import(tmp_path):
    assert report(tmp_path, HELPERS.replace("import numpy as np\n", "")).points == 20


@pytest.mark.deep
def test_what_may_be_told_of_hidden_inputs_holds_no_number_of_the_programs(tmp_path):
    checks = report(
        tmp_path, HELPERS.replace("return OA13[0], OA13[1]", "return OA13[0] + 0.0123, OA13[1]")
    ).checks
    answers = [*told(checks[0])]
    assert ("looks like", "a wrong number") in answers
    assert not any("0.0" in text for label, text in answers if label != "in detail")


@pytest.mark.deep
def test_what_an_older_numpy_took_is_graded_and_said(tmp_path):
    found = report(tmp_path, (FOLDER / "columns.py").read_text("utf-8"))
    assert found.points == 20
    assert any("graded as it ran before" in note and "A11A12[1]" in note for note in found.notes)


GOOD = "100.0, 20.0"
LIGHTER = (
    "def dynamic_model(*row):\n    M, c = _right(*row)\n    return 0.5 * np.array(M), np.ravel(c)\n"
)


def with_script(folder, gains=GOOD):
    """The lab's controller with the models of both robots beside it."""
    for name in ("control.py", "chosen_models.py"):
        text = (LABS / "amoro" / name).read_text("utf-8")
        written(folder / name, text.replace("KP, KD = 100.0, 20.0", f"KP, KD = {gains}"))
    written(folder / "five_bar_models.py", (FOLDER / "scalars.py").read_text("utf-8"))
    written(folder / "biglide_models.py", (FOLDER / "biglide_loops.py").read_text("utf-8"))
    return str(folder / "control.py")


def marked(capsys, *arguments):
    """(exit code, what is printed on stdout, on stderr)."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(Path(arguments[0]).parent)
        code = main(["run", *arguments])
    return code, *capsys.readouterr()


@pytest.mark.every(2)
@pytest.mark.parametrize(
    "robot, task, gains, low, high",
    [
        ("five_bar", "1", GOOD, 20, 20),
        ("biglide", "1", GOOD, 20, 20),
        ("five_bar", "2", GOOD, 0, 0),
        ("biglide", "1", "10.0, 2.0", 0.1, 19.9),
    ],
)
def test_the_tracking_error_is_the_mark(tmp_path, capsys, robot, task, gains, low, high):
    """Computed torque follows task 1 and is lost at the singularity of task 2."""
    script = with_script(tmp_path, gains)
    if high == 19.9:  # half the masses, and low gains
        text = (tmp_path / "biglide_models.py").read_text("utf-8")
        written(tmp_path / "biglide_models.py", text + "\n_right = dynamic_model\n" + LIGHTER)
    code, out, _ = marked(capsys, script, "--mark", task, "--json", robot, f"{robot}_models.py")
    found = json.loads(out)["tracking"]
    assert code == 0 and low <= found["points"] <= high and found["of"] == 20
    assert (found["largest_error_m"] < 1e-4) == (low == 20)


def test_a_mark_is_for_the_whole_task_and_for_a_known_one(tmp_path, capsys):
    script = with_script(tmp_path)
    code, _, err = marked(
        capsys, script, "--mark", "1", "--until", "1", "five_bar", "five_bar_models.py"
    )
    assert code == 1 and "the motion ends at 1 s, before the 2 s of the task" in err
    code, _, err = marked(capsys, script, "--mark", "2", "biglide", "biglide_models.py")
    assert code == 1 and "the biglide has no control task 2" in err


START = (
    "from lab_amoro.parallel_robot import *\nrclpy.init()\nr = Robot('five_bar')\nstart_robot(r)\n"
)
LYING = {
    "exits": ("import os\nprint('20 of 20 points')\nos._exit(0)  # apply_efforts\n", "status 0"),
    "writes": (START + "open('stolen', 'w')\nr.apply_efforts(0, 0)\n", "PermissionError"),
    "asks us": (START + "import fivebar\nr.apply_efforts(0, 0)\n", "line 5: ModuleNotFoundError"),
    "no number": (START + "r.apply_efforts(float('nan'), 0)\n", "the left effort is nan"),
    "claims": (START + "r._world.state.xi[:] = 0.0\nr.apply_efforts(0, 0)\n", "ends at 0.01 s"),
}


@pytest.mark.deep
def test_controllers_of_a_course_in_any_folder(tmp_path, capsys):
    """A package's imports, and flat files as Canvas packs them, beside another hand-in's file."""
    with_script(tmp_path)
    models = (tmp_path / "five_bar_models.py").read_text("utf-8")
    direct = (LABS / "amoro/control.py").read_text("utf-8")
    direct = direct.replace("chosen_models(args)", "'five_bar', m")
    line = "from chosen_models import chosen_models"
    folder = tmp_path / "hand-ins"
    for student, start in {
        "anna/lab_amoro/": "from . import five_bar_models as m",
        "carl/lab_amoro/": "from lab_amoro.five_bar_models import *\nimport five_bar_models as m",
        "dora_12_34_": "import five_bar_models as m",
    }.items():
        written(folder / f"{student}control.py", direct.replace(line, start))
        written(folder / f"{student}five_bar_models.py", models)
    code, out, _ = marked(capsys, str(folder), "--mark", "1")
    rows = {row["student"]: row for row in csv.DictReader(io.StringIO(out))}
    assert code == 0 and len(rows) == 3
    assert {row["points"] for row in rows.values()} == {"20.0"}, out


def test_a_folder_of_hand_ins_and_who_only_says_that_he_is_good(tmp_path, capsys):
    folder = tmp_path / "hand-ins"
    for name, (text, _) in LYING.items():
        written(folder / name / "control.py", text)
    script = (LABS / "amoro/control.py").read_text("utf-8")
    with_script(folder / "good" / "student_scripts 2")
    direct = script.replace("chosen_models(args)", "'five_bar', __import__('five_bar_models')")
    direct = direct.replace("from chosen_models import chosen_models", "import five_bar_models")
    written(folder / "good" / "student_scripts 2" / "control.py", direct)
    written(folder / "none" / "five_bar_models.py", "x = 1\n")
    code, out, _ = marked(capsys, str(folder), "--mark", "1")
    rows = {row["student"]: row for row in csv.DictReader(io.StringIO(out))}
    assert code == 0 and len(rows) == len(LYING) + 2
    assert rows["good"]["points"] == "20.0" and rows["none"]["trouble"] == "no controller"
    for name, (_, words) in LYING.items():
        assert rows[name]["points"] == "" and words in rows[name]["trouble"], rows[name]
    assert not list(tmp_path.rglob("stolen"))
    code, out, err = marked(capsys, str(folder / "exits" / "control.py"), "--mark", "1")
    assert (code, out) == (1, "") and "no mark" in err
