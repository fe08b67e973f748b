"""What a teacher does with a course's results: marks by hand, late days, weights, attempts, feedback to send back."""

import csv
import datetime
import io
import json
import zipfile

import pytest

from fivebar.base.errors import UsageError
from fivebar.cli import main
from fivebar.grading.course.copies import equal_programs
from fivebar.grading.course.feedback import page_for
from fivebar.grading.course.gradebook import moodle_time
from fivebar.grading.course.marks import Mark
from fivebar.grading.course.settings import offer_settings, read_settings
from fivebar.grading.course.sheet import read_sheet
from fivebar.grading.judging.results import Check, Report
from fivebar.grading.labs import find_lab

from ..helpers.grading_lab import HALF, RIGHT, SHIFTED, UNTOUCHED, write_lab, written


@pytest.fixture
def course(tmp_path, capsys):
    """Grades folders of hand-ins; (exit code, what is printed on stderr)."""
    labs = write_lab(tmp_path / "mylabs")
    written(labs / "elbow" / "student.py", UNTOUCHED)

    def run(*folders, options=()):
        common = ["--labs", labs, "--out", tmp_path / "out", "--isolate", "process"]
        folders = [tmp_path / folder for folder in folders or ("hand-ins",)]
        code = main(list(map(str, ["grade", "elbow", *folders, *common, *options])))
        return code, capsys.readouterr().err

    return run


def hand_in(tmp_path, folder="hand-ins", **sources):
    for student, source in sources.items():
        written(tmp_path / folder / f"{student}.py", source)


def rows(path):
    """Student -> row of a table of marks, in either dialect."""
    text = path.read_text("utf-8-sig")
    sign = ";" if ";" in text.splitlines()[0] else ","
    return {row["student"]: row for row in csv.DictReader(io.StringIO(text), delimiter=sign)}


def edited(path, sign=",", encoding="utf-8-sig", **columns):
    """Save the table as a spreadsheet does, with these columns: title -> {student: cell}."""
    found = rows(path)
    for title, cells in columns.items():
        for student, row in found.items():
            row[title] = cells.get(student, row.get(title, ""))
    file = io.StringIO(newline="")
    writer = csv.DictWriter(file, list(next(iter(found.values()))), delimiter=sign)
    writer.writeheader()
    writer.writerows(found.values())
    path.write_bytes(file.getvalue().encode(encoding))


def test_a_pattern_means_no_check_that_does_not_count(tmp_path):
    checks = [Check(f"test_dgm_{k}", "", most, most, 1.0, "right") for k, most in enumerate((1, 0))]
    report = Report("elbow", "a.py", tuple(checks))
    for pattern, most in (("test_dgm_*", [3, 0]), ("test_dgm_1", [1, 3])):
        written(tmp_path / "course.toml", f"[points.elbow]\n'{pattern}' = 3\n")
        weighted = read_settings(tmp_path).weighted(report)
        assert [check.max_points for check in weighted.checks] == most


def test_how_a_mark_is_told_on_the_page():
    report = Report("elbow", "a.py", (), no_program=True)
    cells = {"report /10": "7,50", "room": "B12", "comment": "Good.\nSee me."}
    mark = Mark("anna", "", {"elbow": (None, report)}, cells, 7.5, 14, 0.0, "no program")
    page = page_for(report, mark)
    assert "Mark: 7.5 of 14 (elbow no program, report 7.5 of 10)." in page
    assert ">Comment: Good.<" in page and ">See me.<" in page


@pytest.mark.deep
def test_what_a_teacher_writes_by_hand_counts_and_stays(course, tmp_path):
    hand_in(tmp_path, anna=RIGHT, ben=SHIFTED, carl="no program at all(")
    written(tmp_path / "hand-ins" / "dora.zip", "no zip")
    assert course()[0] == 0
    table, marks = tmp_path / "out" / "marks.csv", rows(tmp_path / "out" / "marks.csv")
    assert [marks[name]["mark"] for name in ("anna", "ben", "carl", "dora")] == ["4", "1", "0", ""]
    assert marks["dora"]["state"] == "no program"
    edited(
        table,
        adjust={"ben": "0.5", "dora": "0"},
        comment={"ben": "=voilà, mieux"},
        **{
            "report /6": {"anna": "5", "ben": "3.5", "carl": "2", "dora": "6"},
            "room": {"anna": "B12"},
        },
    )
    stamp = (tmp_path / "out" / "students" / "ben.json").stat().st_mtime_ns
    code, err = course()
    marks = rows(table)
    assert code == 0 and "4 of 4 are graded already" in err
    assert (tmp_path / "out" / "students" / "ben.json").stat().st_mtime_ns == stamp
    assert {name: (row["mark"], row["of"]) for name, row in marks.items()} == {
        "anna": ("9", "10"),
        "ben": ("5", "10"),
        "carl": ("2", "10"),
        "dora": ("6", "10"),
    }
    assert marks["anna"]["room"] == "B12" and marks["ben"]["comment"] == "=voilà, mieux"
    page = (tmp_path / "out" / "students" / "ben.html").read_text("utf-8")
    assert "Comment: =voilà, mieux" in page
    assert "Mark: 5 of 10 (elbow 1 of 4, report 3.5 of 6, +0.5 by hand)." in page
    with zipfile.ZipFile(tmp_path / "out" / "feedback.zip") as archive:
        assert sorted(archive.namelist()) == [
            f"{name}/elbow.html" for name in ("anna", "ben", "carl", "dora")
        ]
        assert archive.read("ben/elbow.html").decode() == page
    before = table.read_bytes()
    assert course()[0] == 0 and table.read_bytes() == before


@pytest.mark.every(3)
@pytest.mark.parametrize("encoding", ["cp1252", "utf-8-sig", "utf-16"])
def test_a_table_that_a_french_excel_saved(course, tmp_path, encoding):
    hand_in(tmp_path, anna=RIGHT, ben=SHIFTED)
    course()
    table = tmp_path / "out" / "marks.csv"
    edited(table, ";", encoding, comment={"ben": 'à revoir ; puis "bien"'}, adjust={"ben": "0,25"})
    assert course()[0] == 0
    ben = rows(table)["ben"]
    assert ben["mark"] == "1,25" and ben["comment"] == 'à revoir ; puis "bien"'
    assert table.read_bytes().startswith(b"\xef\xbb\xbfstudent;")  # so that Excel opens it again


@pytest.mark.deep
def test_a_mark_waits_for_what_is_not_yet_marked_by_hand(course, tmp_path):
    hand_in(tmp_path, anna=RIGHT, ben=RIGHT)
    course()
    edited(tmp_path / "out" / "marks.csv", **{"plots /2": {"anna": "2"}})
    _, err = course()
    marks = rows(tmp_path / "out" / "marks.csv")
    assert marks["anna"]["mark"] == "6" and marks["ben"]["mark"] == ""
    assert "no mark yet (waits for plots /2): ben" in err


@pytest.mark.every(2)
@pytest.mark.parametrize(
    "columns, message",
    [
        ({"adjust": {"anna": "two"}}, "anna: adjust is 'two', which is no number"),
        ({"report /5": {"anna": "5/5"}}, "anna: report /5 is '5/5'"),
        ({"extra days": {"anna": "-1"}}, "anna: extra days is -1, and must be at least 0"),
    ],
)
def test_a_cell_that_is_no_number_is_told(course, tmp_path, columns, message):
    hand_in(tmp_path, anna=RIGHT)
    course()
    before = edited(tmp_path / "out" / "marks.csv", **columns)
    kept = (tmp_path / "out" / "marks.csv").read_bytes()
    code, err = course()
    assert before is None and code == 2 and message in err
    assert (tmp_path / "out" / "marks.csv").read_bytes() == kept


def settings(tmp_path, text):
    written(tmp_path / "out" / "course.toml", text)


@pytest.mark.deep
def test_late_days_cost_a_share_and_extensions_give_it_back(course, tmp_path):
    hand_in(tmp_path, anna=RIGHT, ben=RIGHT, carl=RIGHT, dora=RIGHT)
    settings(tmp_path, "late_percent = 20\n")
    course()
    edited(
        tmp_path / "out" / "marks.csv",
        **{"days late": {"anna": "0,2", "ben": "3", "carl": "9"}, "extra days": {"ben": "2"}},
    )
    course()
    marks = rows(tmp_path / "out" / "marks.csv")
    got = {name: (row["lost for late days"], row["mark"]) for name, row in marks.items()}
    assert got == {
        "anna": ("0.8", "3.2"),
        "ben": ("0.8", "3.2"),
        "carl": ("4", "0"),
        "dora": ("", "4"),
    }
    assert "-0.8 for late days" in (tmp_path / "out" / "students" / "ben.html").read_text("utf-8")


WORKSHEET = (
    '\ufeffIdentifier,"Full name",Grade,"Maximum Grade","Last modified (submission)",'
    '"Last modified (grade)","Feedback comments"\r\n'
    '"Participant 11","Ada Ü",,10.00,"Tuesday, 1 December 2026, 11:30 PM","Friday, 1 January 2027, 1:00 AM","so ""so"""\r\n'
    '"Participant 12","Ben",3.00,10.00,"Monday, 30 November 2026, 9:05 AM",-,\r\n'
)


@pytest.mark.deep
def test_moodles_own_times_and_a_sheet_of_which_only_the_marks_change(course, tmp_path):
    for name in ("Ada Ü_11_assignsubmission_file", "Ben_12_assignsubmission_file_"):
        written(tmp_path / "hand-ins" / name / "my.py", RIGHT)
    settings(tmp_path, "due = 2026-11-30 23:59:00\nlate_percent = 10\n")
    sheet = tmp_path / "sheet.csv"
    sheet.write_bytes(WORKSHEET.encode())
    assert course(options=["--gradebook", sheet])[0] == 0
    filled = (tmp_path / "out" / "gradebook.csv").read_bytes().decode()
    assert filled == WORKSHEET.replace('Ü",,', 'Ü",9,').replace("3.00", "10")
    marks = rows(tmp_path / "out" / "marks.csv")
    code, err = course()
    assert code == 2 and "give it again, --gradebook FILE" in err
    assert rows(tmp_path / "out" / "marks.csv") == marks
    with zipfile.ZipFile(tmp_path / "out" / "feedback.zip") as archive:
        assert archive.namelist() == [
            "Ada Ü_11_assignsubmission_file_/elbow.html",
            "Ben_12_assignsubmission_file_/elbow.html",
        ]


@pytest.mark.parametrize(
    "text",
    [
        "Wednesday, 25 November 2026, 3:31 PM",
        "mercredi 25 novembre 2026, 15:31",
        "Mittwoch, 25. November 2026, 15:31",
        "miércoles, 25 de noviembre de 2026, 15:31",
        "mercoledì, 25 novembre 2026, 15:31",
    ],
)
def test_moodles_times_in_five_languages(text):
    assert moodle_time(text) == datetime.datetime(2026, 11, 25, 15, 31)


def test_months_that_begin_alike_and_what_is_no_time():
    found = [
        moodle_time(f"1 {m} 2026, 8:00").month
        for m in ("juin", "juillet", "mars", "mai", "märz", "déc.")
    ]
    assert found == [6, 7, 3, 5, 3, 12]
    assert moodle_time("1 January 2026, 12:05 AM").hour == 0 and moodle_time("-") is None
    assert moodle_time("31 février 2026, 8:00") is None


@pytest.mark.deep
def test_weights_are_changed_without_running_programs_again(course, tmp_path):
    hand_in(tmp_path, anna=RIGHT, ben=SHIFTED)
    course()
    settings(tmp_path, '[points.elbow]\n"test_elbow*" = 1\ntest_elbow_turns = 8\n')
    _, err = course()
    marks = rows(tmp_path / "out" / "marks.csv")
    assert "2 of 2 are graded already" in err
    assert {name: (row["mark"], row["of"]) for name, row in marks.items()} == {
        "anna": ("10", "10"),
        "ben": ("8", "10"),
    }
    page = (tmp_path / "out" / "students" / "ben.html").read_text("utf-8")
    assert "8 of 10 points" in page and "origin in the base joint" in page
    settings(tmp_path, "[points.elbow]\ntest_wrist = 1\n")
    code, err = course()
    assert code == 2 and "no check of elbow is called 'test_wrist'" in err


@pytest.mark.deep
def test_of_several_attempts_the_best_counts(course, tmp_path):
    hand_in(tmp_path, "first", anna=SHIFTED, ben=RIGHT, carl=SHIFTED)
    hand_in(tmp_path, "second", anna=RIGHT, ben=HALF)
    written(tmp_path / "second" / "carl" / "report.txt", "")
    assert course("first", "second")[0] == 0
    marks = rows(tmp_path / "out" / "marks.csv")
    assert [marks[name]["mark"] for name in ("anna", "ben", "carl")] == ["4", "4", "1"]
    assert len(list((tmp_path / "out" / "students").glob("anna*.json"))) == 2
    with zipfile.ZipFile(tmp_path / "out" / "feedback.zip") as archive:
        assert "4 of 4 points" in archive.read("anna/elbow.html").decode()
    _, err = course("first", "second")
    assert "5 of 6 are graded already" in err


ORIGINAL = """import math as m
def direction(q):
    return m.cos(q), m.sin(q)
def elbow(q11):
    x, y = direction(q11)
    size = m.sqrt(x**2 + y**2)
    return -d/2 + l11*x/size, l11*y/size
def tip(q11, q12):
    x, y = elbow(q11)
    c, s = direction(q11 + q12)
    x, y = x**2 + y**2, x*y
    return x**2 + y + l12*c, y**2 + x + l12*s
"""
RENAMED = """import math as mt


def tip(first, second):
    '''The end.'''
    a, b = elbow(first)
    e, f = unit(first + second)
    a, b = a**2 + b**2, a * b
    return (a**2 + b + l12 * e, b**2 + a + l12 * f)


def unit(angle):
    # my own
    return (mt.cos(angle),
            mt.sin(angle))


def elbow(theta):
    '''The elbow.'''
    c, s = unit(theta)
    w = mt.sqrt(c**2 + s**2)
    return (-d / 2 + l11 * c / w, l11 * s / w)
""".replace("mt.", "m.").replace("as mt", "as m")
ASKED = frozenset({"elbow", "tip"})
BOTH = "elbow, tip, but for names and formatting"


@pytest.mark.parametrize(
    "other, equal",
    [
        (RENAMED, BOTH),
        (ORIGINAL.replace("\n", "\r\n\r\n") + "print(1)\n", BOTH),
        (RENAMED + "\nx = tip?\n", BOTH),
        (RENAMED.replace("(-d / 2", "((-d / 2"), ""),
        (ORIGINAL.replace("l11*y", "l11*x").replace("l12*s", "l12*c"), ""),
        (ORIGINAL.replace("- d/2", "+ d/2").replace("-d/2", "d/2"), ""),  # tip alone is short
    ],
)
def test_programs_are_equal_but_for_names_and_formatting(other, equal):
    found = equal_programs({"anna": ORIGINAL, "ben": other}, UNTOUCHED, ASKED)
    assert found == ([(("anna", "ben"), equal)] if equal else [])


def test_an_untouched_template_of_another_year_accuses_nobody():
    shown = ORIGINAL.replace("def elbow", "def shown").replace("def tip", "def drawn")
    todo = shown + "def elbow(q11):\n    x = 0\n    y = 0\n    return x, y\n"
    found = equal_programs(dict.fromkeys("abcdefgh", todo), UNTOUCHED, ASKED)
    assert found == []
    own = {"a": ORIGINAL, "b": ORIGINAL} | dict.fromkeys("cdefgh", todo)
    assert equal_programs(own, UNTOUCHED, ASKED) == [(("a", "b"), "all, to the letter")]


def test_the_settings_that_are_offered_are_in_the_words_of_the_lab(tmp_path):
    for name in ("lab2_kinematics", "amoro"):
        offer_settings(tmp_path, find_lab(name))
        path = tmp_path / "course.toml"
        assert f"[points.{name}]" in path.read_text("utf-8")
        shown = path.read_text("utf-8").split("\n\n", 1)[1].replace('"sympy"', '"numpy"')
        path.write_text(shown.replace("# ", "", 1).replace("\n# ", "\n"), "utf-8")
        assert {"test_*": 0.5}.items() < read_settings(tmp_path).points[name].items()
        path.unlink()


@pytest.mark.deep
def test_equal_programs_are_told_and_the_template_is_none(course, tmp_path):
    right = f"{RIGHT}\n\n{ORIGINAL.split('def elbow')[0]}def tip{ORIGINAL.split('def tip')[1]}"
    right = right.replace(
        "return x**2", "return (x - 1)**2 + (y - 1)**2 + (x + y)**2 + x**3 - x**2"
    )
    right = right.replace("    x, y = x**2", "    x, y = x*y + x - y, y*x + y - x\n    x, y = x**2")
    copy = right.replace("q11", "angle") + "\n\n# mine\n"
    hand_in(
        tmp_path,
        anna=right,
        ben=copy,
        carl=SHIFTED,
        dora=UNTOUCHED,
        emil=UNTOUCHED + "\n# no time\n",
    )
    _, err = course()
    assert "elbow: equal programs (tip, but for names and formatting): anna, ben" in err
    marks = rows(tmp_path / "out" / "marks.csv")
    assert [marks[name]["same program as"] for name in ("anna", "ben", "carl", "dora", "emil")] == [
        "ben",
        "anna",
        "",
        "",
        "",
    ]
    assert "anna, ben" in (tmp_path / "out" / "summary.html").read_text("utf-8")


@pytest.mark.parametrize(
    "source", ["x = (" + "1+" * 40_000, "-" * 50_000, "def f(:\n", "x=1;" * 20_000, "\0"]
)
def test_no_program_is_too_strange_to_be_compared(source):
    assert equal_programs({"a": source, "b": source, "c": RIGHT}, "", ASKED) == [
        (("a", "b"), "all, to the letter")
    ]


@pytest.mark.deep
def test_packages_are_allowed_by_name(course, tmp_path):
    exact = RIGHT.replace("from math import cos, sin", "from mpmath import cos, sin").replace(
        "return -d / 2 + l11 * cos(q11), l11 * sin(q11)",
        "return float(-d / 2 + l11 * cos(q11)), float(l11 * sin(q11))",
    )
    hand_in(tmp_path, anna=exact, ben=RIGHT)
    course()
    assert rows(tmp_path / "out" / "marks.csv")["anna"]["mark"] == "0"
    settings(tmp_path, 'packages = ["mpmath"]\n')
    _, err = course()
    assert rows(tmp_path / "out" / "marks.csv")["anna"]["mark"] == "4"
    assert "are graded already" not in err
    hand_in(tmp_path, anna=RIGHT.replace("from math", "import fivebar\nfrom math"))
    course()
    assert "fivebar is not available" in rows(tmp_path / "out" / "marks.csv")["anna"]["trouble"]


@pytest.mark.parametrize(
    "text, message",
    [
        ("dew = 3\n", "there is no setting 'dew'; there are labs, due, late_percent"),
        ("due = \n", "Invalid value"),
        ('due = "soon"\n', "due is a time without quotes"),
        ("late_percent = 120\n", "a number from 0 to 100, not 120"),
        ('packages = "sympy"\n', "packages is a list of names"),
        ('packages = ["no_such_one"]\n', "the package no_such_one is not installed here"),
        ('packages = ["fivebar"]\n', "'fivebar' is no package that programs may import"),
        ("[points]\ntest_a = 1\n", "points reads [points.LAB]"),
        ('[points.lab1]\ntest_a = "1"\n', "points reads [points.LAB]"),
    ],
)
def test_a_setting_that_cannot_be_is_told(tmp_path, text, message):
    settings(tmp_path, text)
    with pytest.raises(UsageError) as error:
        read_settings(tmp_path / "out")
    assert message in str(error.value)


@pytest.mark.deep
def test_settings_are_offered_and_none_is_set_by_that(course, tmp_path):
    hand_in(tmp_path, anna=RIGHT)
    course()
    path = tmp_path / "out" / "course.toml"
    assert read_settings(tmp_path / "out") == read_settings(tmp_path / "nowhere")
    shown = path.read_text("utf-8").split("\n\n", 1)[1].replace("sympy", "scipy")
    written(path, f"\n{shown}".replace("\n# ", "\n").replace("Only", "# Only"))
    found = read_settings(tmp_path / "out")
    assert found.due == datetime.datetime(2027, 1, 31, 18) and found.points["elbow"]


@pytest.mark.deep
def test_no_program_is_no_zero_in_the_mean(course, tmp_path, capsys):
    hand_in(tmp_path, anna=RIGHT, ben=RIGHT)
    written(tmp_path / "hand-ins" / "carl" / "report.pdf", "")
    code, err = course(options=["--fail-under", "50", "--json"])
    assert code == 0 and "no mark yet (no program): carl" in err
    page = (tmp_path / "out" / "summary.html").read_text("utf-8")
    assert "2 students, mean 100 %" in page and "No program, and so no mark yet" in page
    kept = json.loads((tmp_path / "out" / "students" / "carl.json").read_text("utf-8"))
    items = (tmp_path / "out" / "items.csv").read_text("utf-8").splitlines()
    assert kept["no_program"] and len(items) == 4 and all(",2," in item for item in items[1:])


CANVAS = (
    "Student,ID,AMORO lab (123),Lab 1 (7),Lab 10 (8)\n    Points Possible,,20,10,10\nAda,12,,,\n"
)


@pytest.mark.parametrize(
    "name, title", [("amoro", "AMORO lab (123)"), ("lab1_geometry", "Lab 1 (7)")]
)
def test_the_column_of_a_lab_is_found_in_canvas_sheet(tmp_path, name, title):
    from fivebar.grading.course.gradebook import Gradebook
    from fivebar.grading.labs import find_lab

    book = Gradebook(written(tmp_path / "sheet.csv", CANVAS), find_lab(name))
    assert book.sheet.titles[book.mark] == title and book.limit in ("20", "10")


@pytest.mark.parametrize(
    "text",
    [
        'a;"b ""c""";d\r\n1;"2;\n3";\r\n',
        "a,b\n1,2",
        '\ufeff"a","b"\r\n\r\n"x",""\r\n',
        "a\tb\n\t\n",
    ],
)
def test_a_sheet_comes_back_to_the_letter(tmp_path, text):
    path = tmp_path / "sheet.csv"
    path.write_bytes(text.encode())
    sheet = read_sheet(path)
    assert sheet.text == text
    sign = {";": ";", "\t": "\t"}.get(sheet.sign, ",")
    read = list(csv.reader(io.StringIO(text.removeprefix("\ufeff"), newline=""), delimiter=sign))
    assert [sheet.values(k) for k in range(len(sheet.rows))] == [row or [""] for row in read]
