"""Hand-ins of the AMORO lab as its repositories have them: both robots' files are found by the lab's own names."""

import csv
import io
import zipfile

import pytest

from fivebar.cli import main
from fivebar.grading.intake.cohort_folder import entries_of, find_hand_ins, not_graded
from fivebar.grading.intake.hand_in import choose, look_into
from fivebar.grading.labs import find_lab
from fivebar.grading.worker.submission import SubmissionError
from tests.helpers.hand_ins import FOLDER

from ..helpers.grading_lab import written

FIVE, SLIDES = (
    (FOLDER / "scalars.py").read_text("utf-8"),
    (FOLDER / "biglide_loops.py").read_text("utf-8"),
)
CONTROL = "from lab_amoro.parallel_robot import *\nfrom five_bar_models import *\ndef main():\n    return 0\n"
BOTH = {"five_bar_models.py": FIVE, "biglide_models.py": SLIDES, "control.py": CONTROL}
DRAFT = FIVE.replace("sin(q12)", "cos(q12)")
EMPTY = '{"cells": [], "nbformat": 4, "nbformat_minor": 5, "metadata": {}}'


def beneath(folder, files):
    return {f"{folder}/{name}": text for name, text in files.items()}


LAYOUTS = {
    "flat": BOTH,
    "a workspace": beneath("AMORO-lab/src/lab_amoro/student_scripts", BOTH)
    | {
        "AMORO-lab/README.md": "",
        "AMORO-lab/src/lab_amoro/setup.py": "from setuptools import setup\nsetup()\n",
        "AMORO-lab/src/lab_amoro/lab_amoro/parallel_robot.py": "class Robot:\n    pass\n",
    },
    "two folders": beneath("student_scripts", BOTH)
    | beneath("student_scripts 2", BOTH | {"five_bar_models.py": DRAFT}),
    "two equal folders": beneath("student_scripts", BOTH) | beneath("student_scripts 2", BOTH),
    "drafts": BOTH
    | {
        "five_bar_models_old.py": DRAFT,
        "five_bar_models (1).py": DRAFT,
        "five_bar_models - Copie.py": DRAFT,
        "biglide_models_v2.py": SLIDES + "#\n",
        "old/essai.py": DRAFT,
    },
    "notebooks": BOTH
    | {"five_bar_models.ipynb": EMPTY, "rapport final.pdf": "", "Untitled.ipynb": EMPTY},
    "accents and spaces": beneath("Modèles (étape 2)/à rendre", BOTH),
    "other letters": {"Five_Bar_Models.py": FIVE, "BIGLIDE_MODELS.PY": SLIDES},
    "names with more": {
        "five_bar_models_final.py": FIVE,
        "group3_biglide_models.py": SLIDES,
        "control.py": CONTROL,
    },
    "spaces for underscores": {"five bar models.py": FIVE, "biglide-models.py": SLIDES},
    "system files": BOTH
    | {
        "__MACOSX/._five_bar_models.py": "junk",
        ".DS_Store": "",
        "__pycache__/five_bar_models.py": "#",
        ".git/five_bar_models.py": "#",
    },
    "template beside": beneath("mine", BOTH)
    | {"student.py": (find_lab("amoro").folder / "student.py").read_text("utf-8")},
}
LABS = find_lab("amoro"), find_lab("amoro-biglide")


def zipped(path, files):
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w") as archive:
        for name, text in files.items():
            archive.writestr(name, text)


def packed(tmp_path, how, files):
    """The hand-in of one student in a course's folder."""
    folder = tmp_path / "hand-ins"
    if how == "folder":
        for name, text in files.items():
            written(folder / "anna" / name, text)
    elif how == "zip":
        zipped(folder / "anna.zip", files)
    elif how == "zip in a folder":
        zipped(folder / "anna" / "AMORO Léa.zip", files)
    else:
        zipped(folder / "Léa Gérard_4711_assignsubmission_file" / "lab.zip", files)
    return folder


@pytest.mark.parametrize("how", ["folder", "zip", "zip in a folder", "Moodle"])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_files_of_both_robots_are_found(tmp_path, layout, how):
    hand_ins, left = find_hand_ins(packed(tmp_path, how, LAYOUTS[layout]))
    entries = [entries_of(hand_ins, lab, named=True) for lab in LABS]
    assert (
        len(hand_ins) == 1 and not left and not any(e.trouble for found in entries for e in found)
    )
    names = [[entry.name.casefold() for entry in found] for found in entries]
    assert all("five" in name for name in names[0]) and all("biglide" in name for name in names[1])
    assert [len(found) for found in names] == ([2, 1] if layout == "two folders" else [1, 1])
    rest = {
        item.name.rsplit("/", 1)[1] for item in not_graded(hand_ins[0], [*entries[0], *entries[1]])
    }
    assert ("control.py" in rest) == ("control.py" in str(LAYOUTS[layout]))


def test_flat_files_as_canvas_packs_them(tmp_path):
    for name, text in (
        ("five_bar_models", FIVE),
        ("biglide_models-1", SLIDES),
        ("control-2", CONTROL),
    ):
        written(tmp_path / f"turingalan_LATE_123_45{len(name)}_{name}.py", text)
    hand_ins, _ = find_hand_ins(tmp_path, labs=LABS)
    found = [entries_of(hand_ins, lab, named=True)[0].path.name for lab in LABS]
    assert found == [
        "turingalan_LATE_123_4515_five_bar_models.py",
        "turingalan_LATE_123_4516_biglide_models-1.py",
    ]


def test_what_cannot_be_meant(tmp_path):
    written(tmp_path / "a" / "biglide_models.py", SLIDES)
    with pytest.raises(
        SubmissionError,
        match="no five_bar_models.py: biglide_models.py is the file of the lab amoro-bigl",
    ):
        choose(LABS[0], look_into(tmp_path / "a")[0])
    for k in range(4):
        written(tmp_path / "b" / str(k) / "five_bar_models.py", FIVE + f"# {k}\n")
    with pytest.raises(SubmissionError, match="4 programs could be meant"):
        choose(LABS[0], look_into(tmp_path / "b")[0])
    written(tmp_path / "c" / "my_robot.py", FIVE)  # by what it defines
    written(tmp_path / "c" / "biglide_models.py", SLIDES)
    assert choose(LABS[0], look_into(tmp_path / "c")[0])[0].name == "c/my_robot.py"
    for k in (1, 2, 7):  # lab 7 asks for functions of the same names
        written(tmp_path / "d" / f"lab{k}.py", find_lab(str(k)).template())
    assert choose(find_lab("1"), look_into(tmp_path / "d")[0])[0].name == "d/lab1.py"
    written(tmp_path / "d" / "lab1.py", FIVE)
    assert choose(find_lab("1"), look_into(tmp_path / "d")[0])[0].name == "d/lab1.py"


@pytest.mark.deep
def test_the_other_robots_file_is_no_program_for_this_lab(tmp_path, capsys):
    path = written(tmp_path / "five_bar_models.py", SLIDES)
    assert main(["check", "amoro", str(path)]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "This is the file of amoro-biglide, not of amoro" in out and "wrong" not in out
    assert "no points, as there is no program" in out


@pytest.mark.deep
def test_one_command_marks_both_robots(tmp_path, capsys):
    folder, out = tmp_path / "hand-ins", tmp_path / "out"
    for student, layout in (("anna", "a workspace"), ("ben", "two folders"), ("carl", "flat")):
        for name, text in LAYOUTS[layout].items():
            written(folder / student / name, text)
    (folder / "carl" / "biglide_models.py").unlink()
    assert main(["grade", "amoro", str(folder), "--out", str(out)]) == 0
    text = (out / "marks.csv").read_text("utf-8-sig")
    rows = {row["student"]: row for row in csv.DictReader(io.StringIO(text))}
    assert {
        name: (row["amoro"], row["amoro-biglide"], row["mark"]) for name, row in rows.items()
    } == {"anna": ("20", "20", "40"), "ben": ("20", "20", "40"), "carl": ("20", "", "")}
    assert rows["carl"]["state"] == "no program: amoro-biglide"
    with zipfile.ZipFile(out / "feedback.zip") as archive:
        assert "anna/amoro-biglide.html" in archive.namelist() and len(archive.namelist()) == 5
    written(out / "course.toml", 'labs = ["amoro"]\n')
    assert main(["grade", "amoro", str(folder), "--out", str(out)]) == 0
    assert "carl,20,,20,20,graded," in (out / "marks.csv").read_text("utf-8-sig")
    capsys.readouterr()
    assert main(["grade", "amoro", str(folder / "anna")]) == 0
    assert "total 40 of 40 points" in capsys.readouterr().out
    assert (
        main(["grade", "amoro", str(folder)]) == 2 and "needs --out DIR" in capsys.readouterr().err
    )


@pytest.mark.every(2)
@pytest.mark.parametrize("lab", LABS)
def test_the_template_is_handed_out_and_is_not_filled_in(tmp_path, monkeypatch, capsys, lab):
    monkeypatch.chdir(tmp_path)
    assert main(["check", lab.name]) == 0
    out = capsys.readouterr().out
    assert out.count("\n") == 1 and f"fivebar check {lab.name} {lab.file()}" in out
    source = (tmp_path / lab.file()).read_text("utf-8")
    assert source.count("def ") == 10 and source.count('    """') == 10
    assert main(["check", lab.name]) == 2 and "is here already" in capsys.readouterr().err
    assert main(["check", lab.name, lab.file()]) == 0
    assert "Nothing is filled in yet" in capsys.readouterr().out
