"""What an instructor needs beside marks: no explanations before a day, marks in Moodle's and Canvas' own sheets."""

import csv
import datetime
import io
import json
import re

import pytest

from fivebar.cli import main
from fivebar.grading.grade import grade
from fivebar.grading.intake.program import Job
from fivebar.grading.labs import find_lab
from fivebar.grading.report.outputs import gradescope_text

from ..helpers.grading_lab import HALF, RIGHT, SHIFTED, UNTOUCHED, write_lab, written

TELLING = RIGHT.replace(
    "    return",
    "    if q11 > 0:\n        raise type(f'Told{q11}', (ValueError,), {})(f'asked for {q11}')\n    return",
)
SOON = str(datetime.date.today() + datetime.timedelta(days=7))  # and not by the midnight of a test


@pytest.fixture
def labs(tmp_path):
    return write_lab(tmp_path / "mylabs")


@pytest.fixture
def cohort(labs, tmp_path):
    """Grades a folder with these options; (exit code, the folder of results)."""
    folder, out = tmp_path / "submissions", tmp_path / "out"

    def run(files, *options):
        for name, source in files.items():
            written(folder / name, source)
        common = ["--labs", str(labs), "--out", str(out), "--isolate", "process"]
        return main(["grade", "elbow", str(folder), *common, *map(str, options)]), out

    return run


@pytest.mark.deep
@pytest.mark.parametrize(
    "source", [SHIFTED, HALF, TELLING, UNTOUCHED, RIGHT.replace("return", "return 0,")]
)
def test_gradescope_tells_no_input_and_nothing_that_a_program_says(labs, tmp_path, source):
    report = grade(find_lab("elbow", labs), Job(written(tmp_path / "my.py", source)))
    asked = {
        number
        for check in report.checks
        for number in re.findall(r"\d+\.\d{3}", f"{check.asked} {check.text}")
    }
    text = gradescope_text(report)
    assert asked and not any(number in text for number in asked)
    outputs = [test["output"] for test in json.loads(text)["tests"]]
    assert not any(
        word in output
        for output in outputs
        for word in ("call: ", "returned: ", "Told", "task 1", "shape (")
    )
    assert any("why: " in output or "not filled in yet" in output for output in outputs)
    if source is SHIFTED:
        assert "origin in the base joint" in outputs[0]
    if source is HALF:
        assert "why: raised an exception: ValueError" in outputs[0]


@pytest.mark.deep
def test_in_an_exam_students_see_points_and_the_instructor_all(cohort, labs, tmp_path, capsys):
    files = {"anna.py": SHIFTED, "ben.py": UNTOUCHED}
    code, out = cohort(files, "--hints-from", SOON)
    page = (out / "students" / "anna.html").read_text("utf-8")
    assert code == 0 and "1 of 4 points" in page and SOON in page
    assert not any(word in page for word in ("origin in the base", "returned", "<svg", "q11="))
    kept = json.loads((out / "students" / "anna.json").read_text("utf-8"))
    assert kept["checks"][0]["misconception"] == "origin in the base joint"
    assert "2 of 2 are graded already" not in capsys.readouterr().err
    cohort(files, "--hints-from", SOON)
    assert "2 of 2 are graded already" in capsys.readouterr().err
    cohort(files, "--hints-from", "2020-01-01")  # the day has come: the same results, explained
    assert "2 of 2 are graded already" in capsys.readouterr().err
    assert "origin in the base joint" in (out / "students" / "anna.html").read_text("utf-8")
    with open(labs / "elbow" / "exercises.py", "a", encoding="utf-8") as file:
        file.write(f'\nHINTS_FROM = "{SOON}"\n')
    my, scope = written(tmp_path / "my.py", SHIFTED), tmp_path / "r.json"
    options = ["--labs", str(labs), "--html", str(tmp_path / "r.html")]
    for command in (["check"], ["grade", "--gradescope", str(scope)]):
        assert main([command[0], "elbow", str(my), *options, *command[1:]]) == 0
        assert ("base joint" in capsys.readouterr().out) == (command[0] == "grade")
        assert "base joint" not in (tmp_path / "r.html").read_text("utf-8")
    assert "base joint" not in scope.read_text("utf-8") and SOON in scope.read_text("utf-8")
    assert main(["check", "elbow", str(my), "--labs", str(labs), "--json"]) == 0
    assert "base joint" not in capsys.readouterr().out
    assert main(["check", "elbow", str(my), "--labs", str(labs), "--hints-from", "soon"]) == 2
    assert "'soon' is no day" in capsys.readouterr().err


MOODLE = (
    "\ufeffIdentifiant,Nom complet,Adresse de courriel,Statut,Note,Note maximale,Dernière modification (note)\r\n"
    'Participant 4711,Ada Lovelace,ada@x.fr,Remis,,"20,00",-\r\n'
    'Participant 4712,"Turing, Alan",alan@x.fr,Remis,3,"20,00",-\r\n'
    'Participant 99,Nobody,n@x.fr,Non remis,,"20,00",-\r\n'
    'Participant 7,Two Versions,t@x.fr,Remis,3,"20,00",-\r\n'
    'Participant 8,Grace,g@x.fr,Remis,,"18,30",-\r\n'
)
CANVAS = (
    "Student,ID,SIS Login ID,Section,Lab 1 (77),elbow (78)\n    Points Possible,,,,20,10\n"
    '"Lovelace, Ada",12,ada,A,5,\n"Turing, Alan",13,alan,A,,\n"Student, Test",14,x,A,,7\n'
)


@pytest.mark.deep
def test_marks_in_moodles_own_sheet(cohort, tmp_path, capsys):
    sheet = tmp_path / "sheet.csv"
    sheet.write_bytes(MOODLE.encode())
    files = {
        "Ada Lovelace_4711_assignsubmission_file_/lab.py": RIGHT,
        "Turing_4712_assignsubmission_file_/a.py": SHIFTED,
        "eve.py": RIGHT,
        "Grace_8_assignsubmission_file_/a.py": HALF,
        "Two_7_assignsubmission_file_/a.py": HALF,
        "Two_7_assignsubmission_file_/a_old.py": RIGHT,
    }
    code, out = cohort(files, "--gradebook", sheet)
    err = capsys.readouterr().err
    assert (
        code == 0
        and "marks: 3; rows without a hand-in: 1" in err
        and "no row, or several, for eve" in err
    )
    assert "marks.csv: no mark yet (no program): Two" in err
    before, after = (
        list(csv.reader(io.StringIO(t)))
        for t in (MOODLE, (out / "gradebook.csv").read_bytes().decode())
    )
    half = (
        json.loads(next((out / "students").glob("Grace*.json")).read_text("utf-8"))["points"]
        * 18.3
        / 4
    )
    assert [row[4] for row in after] == [
        "Note",
        "20",
        "5",
        "",
        "3",
        f"{half:.2f}".replace(".", ","),
    ]
    assert [row[:4] + row[5:] for row in after] == [row[:4] + row[5:] for row in before]


@pytest.mark.deep
def test_marks_in_canvas_gradebook_by_number_and_by_login(cohort, tmp_path, capsys):
    sheet = written(tmp_path / "sheet.csv", CANVAS)
    code, out = cohort({"lovelaceada_12_345_lab.py": HALF, "alan.py": RIGHT}, "--gradebook", sheet)
    rows = list(csv.reader(io.StringIO((out / "gradebook.csv").read_text("utf-8"))))
    points = json.loads((out / "students" / "lovelaceada.json").read_text("utf-8"))["points"]
    assert code == 0 and [row[5] for row in rows] == [
        "elbow (78)",
        "10",
        f"{points / 4 * 10:g}",
        "10",
        "7",
    ]
    assert "no row" not in capsys.readouterr().err
    assert cohort({}, "--gradebook", sheet, "--column", "Lab 1 (77)")[0] == 0
    assert [row[4] for row in csv.reader(io.StringIO((out / "gradebook.csv").read_text("utf-8")))][
        3
    ] == "20"


@pytest.mark.parametrize(
    "text, options, message",
    [
        (CANVAS, ["--column", "Lab 9"], "0 columns 'Lab 9': give --column one of Student, ID"),
        (CANVAS.replace("elbow", "Other"), [], "0 columns for elbow"),
        ("just text", [], "no sheet of marks"),
    ],
)
def test_a_sheet_that_cannot_be_filled_is_told_before_grading(
    cohort, tmp_path, capsys, text, options, message
):
    sheet = written(tmp_path / "sheet.csv", text)
    code, out = cohort({"anna.py": RIGHT}, "--gradebook", sheet, *options)
    assert code == 2 and message in capsys.readouterr().err and not out.exists()
