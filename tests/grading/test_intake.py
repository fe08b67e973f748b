"""Hand-ins as they come: folders, zips, links, loops, packed by Moodle or Canvas; all that is not graded is listed."""

import codecs
import csv
import io
import os
import zipfile

import pytest

from fivebar.cli import main
from fivebar.grading.intake.cohort_folder import entries_of, find_hand_ins, not_graded
from fivebar.grading.intake.hand_in import choose, look_into
from fivebar.grading.intake.students_robots import robot_of
from fivebar.grading.labs import find_lab
from fivebar.grading.worker.submission import SubmissionError, read_submission

from ..helpers.grading_lab import CONSTANTS, RIGHT, SHIFTED, UNTOUCHED, write_lab, written

CONTROL = "from five_bar_models import *\ndef main():\n    return 0\n"


@pytest.fixture
def labs(tmp_path):
    folder = write_lab(tmp_path / "mylabs")
    written(folder / "elbow" / "student.py", UNTOUCHED)
    return folder


@pytest.fixture
def lab(labs):
    return find_lab("elbow", labs)


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "submissions"


def find_submissions(folder, lab, wanted=None):
    """(entries, what is nobody's)."""
    hand_ins, left = find_hand_ins(folder)
    return entries_of(hand_ins, lab, wanted), left


def left_of(folder, lab):
    """Student -> what of his is not graded, with the reason."""
    hand_ins = find_hand_ins(folder)[0]
    entries = entries_of(hand_ins, lab)
    return {hand_in.student: not_graded(hand_in, entries) for hand_in in hand_ins}


def zipped(path, files):
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return path


def test_a_file_that_a_program_imports_is_not_left_over(folder, lab):
    written(folder / "anna" / "lab.py", f"from helpers import *\n{RIGHT}")
    written(folder / "anna" / "helpers.py", "import deeper\n")
    written(folder / "anna" / "deeper.py", "x = 1\n")
    written(folder / "anna" / "older.py", "x = 2\n")
    (item,) = left_of(folder, lab)["anna"]
    assert (item.name, item.word) == ("anna/older.py", "another program")


def test_who_handed_in_what(folder, lab):
    for name in (
        "anna.py",
        "ben/my_lab.py",
        "carl.ipynb",
        "Ada Lovelace_4711_assignsubmission_file_/lab.py",
        "hans.PY",
        "turingalan_LATE_123_4567_lab1.py",
        "Twin_1_assignsubmission_file_/a.py",
        "Twin_2_assignsubmission_file_/a.py",
        "two/a.py",
        "two/b.ipynb",
        "dora/__MACOSX/._a.py",
        "dora/.ipynb_checkpoints/a-checkpoint.ipynb",
        "dora/a.ipynb",
        "none/readme.txt",
        "readme.txt",
        ".hidden.py",
        "=1+1\n.py",
        "eve.py",
        "eve/x.py",
    ):
        written(folder / name, "")
    written(
        folder / "eve.py_1_2_x.py", ""
    )  # as Canvas packs the file of one who calls himself like another's file
    assert "eve.py_1_2_x.py" in {entry.student for entry in find_submissions(folder, lab)[0]}
    (folder / "eve.py_1_2_x.py").unlink()
    (folder / "linked.py").symlink_to(folder / "anna.py")
    (folder / "linked").symlink_to(folder / "ben")
    (folder / "loop.py").symlink_to("loop.py")
    (folder / "ben" / "up").symlink_to("..")
    os.mkfifo(folder / "ben" / "pipe.py")
    entries, left = find_submissions(folder, lab)
    found = {entry.student: entry for entry in entries}
    assert {name: entry.path.name for name, entry in found.items() if not entry.trouble} == {
        "anna": "anna.py",
        "ben": "my_lab.py",
        "carl": "carl.ipynb",
        "Ada Lovelace": "lab.py",
        "hans": "hans.PY",
        "turingalan": "turingalan_LATE_123_4567_lab1.py",
        "Twin_1_assignsubmission_file_": "a.py",
        "Twin_2_assignsubmission_file_": "a.py",
        "dora": "a.ipynb",
        "=1+1\n": "=1+1\n.py",
        "eve.py": "eve.py",
        "eve": "x.py",
    }
    assert found["two"].trouble.startswith(
        "none of 2 programs (a.py, b.ipynb) defines a function of this lab"
    )
    assert found["none"].trouble == "there is no .py, .ipynb or .zip with one, only readme.txt"
    assert {name for name, entry in found.items() if "symbolic link" in entry.trouble} == {
        "linked",
        "linked.py",
        "loop",
    }
    assert {(item.name, item.word) for item in left} == {
        (".hidden.py", "hidden"),
        ("readme.txt", "no program"),
    }
    assert {(item.name, item.word) for item in left_of(folder, lab)["ben"]} == {
        ("ben/up", "a symbolic link"),
        ("ben/pipe.py", "no regular file"),
    }
    assert {item.name for item in left_of(folder, lab)["dora"]} == {
        "dora/__MACOSX",
        "dora/.ipynb_checkpoints",
    }
    assert (found["turingalan"].number, found["Ada Lovelace"].number, found["anna"].number) == (
        "123",
        "4711",
        "",
    )


def test_of_several_files_the_one_with_the_labs_functions_is_meant(folder, lab):
    tree = folder / "anna" / "src" / "student_scripts"
    for name, text in {
        "five_bar_models.py": RIGHT,
        "control.py": CONTROL,
        "plots.py": "x = 1\n",
        "student.py": UNTOUCHED,
        "notes.txt": "",
        "../../copy/student_scripts/five_bar_models.py": RIGHT,
    }.items():
        written(tree / name, text)
    (entry,), _ = find_submissions(folder, lab)
    assert entry.path.name == "five_bar_models.py" and not entry.trouble
    assert {item.name.rsplit("/", 1)[1] for item in left_of(folder, lab)["anna"]} == {
        "control.py",
        "plots.py",
        "student.py",
        "notes.txt",
        "five_bar_models.py",
    }
    written(tree / "older.py", SHIFTED)
    (entry,), _ = find_submissions(folder, lab)
    assert (
        "2 programs could be meant (copy/student_scripts/five_bar_models.py, src/" in entry.trouble
    )
    for wanted in ("older.py", "OLD*.py", "student_scripts/older.py"):
        (entry,), _ = find_submissions(folder, lab, wanted)
        assert entry.path.name == "older.py"
    (entry,), _ = find_submissions(folder, lab, "nothing.py")
    assert "is called nothing.py" in entry.trouble


def test_a_zip_is_read_and_not_unpacked(folder, lab, tmp_path):
    rest = {"../../escape.py": RIGHT, "plots.py": "x = 1\n", "__MACOSX/._lab.py": "", "a.zip": ""}
    zipped(folder / "anna.zip", {"hand in/lab.py": RIGHT, **rest})
    zipped(folder / "ben" / "lab.ZIP", {"lab.PY": RIGHT})
    zipped(folder / "bomb.zip", {"lab.py": "#" * 30_000_000})
    written(folder / "carl.zip", "PK\x03\x04 no zip")
    zipped(
        folder / "all.zip",
        {f"{name}_assignsubmission_file_/a.py": RIGHT for name in ("Ada_1", "Ben_2")},
    )
    before = sorted(tmp_path.rglob("*"))
    entries, _ = find_submissions(folder, lab)
    found = {entry.student: entry for entry in entries}
    assert (found["anna"].member, found["ben"].member) == ("hand in/lab.py", "lab.PY")
    assert read_submission(found["anna"].path, found["anna"].member).source == RIGHT
    assert {item.word for item in left_of(folder, lab)["anna"]} == {
        "another program",
        "hidden",
        "a zip in a zip that cannot be read",
    }
    assert found["carl"].trouble.startswith("carl.zip is no zip that can be read")
    assert "the hand-ins of several people" in found["all"].trouble
    with pytest.raises(SubmissionError, match="larger than 1 MB"):
        read_submission(found["bomb"].path, found["bomb"].member)
    assert sorted(tmp_path.rglob("*")) == before


def test_zips_in_zips_and_backslashes(folder, lab, tmp_path, capsys):
    helped = "from geometry import point\ndef elbow(q):\n    return point(q)\n"
    files = {"lab.py": helped, "geometry.py": RIGHT.replace("elbow", "point")}
    inner = zipped(tmp_path / "inner.zip", {f"code 2/{k}": v for k, v in files.items()})
    zipped(folder / "anna.zip", {"rapport/Code.ZIP": inner.read_bytes(), "rapport.pdf": ""})
    zipped(folder / "ben.zip", {f"a\\b\\{name}": text for name, text in files.items()})
    deep = zipped(tmp_path / "deep.zip", {"b.zip": inner.read_bytes()})
    zipped(folder / "carl.zip", {"a.zip": deep.read_bytes()})
    entries = {entry.student: entry for entry in find_submissions(folder, lab)[0]}
    assert entries["anna"].name == "rapport/Code.ZIP/code 2/lab.py"
    assert entries["ben"].name == "a/b/lab.py"
    assert entries["carl"].trouble.endswith("only b.zip (a zip in a zip that cannot be read)")
    for name in "anna", "ben":
        arguments = str(folder / f"{name}.zip"), "--labs", str(lab.folder.parent)
        assert main(["check", "elbow", *arguments]) == 0
        assert "4 of 4 points" in capsys.readouterr().out


def test_where_there_is_no_program_a_page_says_so_and_lists_no_checks(folder, lab, tmp_path):
    written(folder / "anna" / "report.pdf", "")
    out = tmp_path / "out"
    arguments = "--labs", str(lab.folder.parent), "--out", str(out)
    assert main(["grade", "elbow", str(folder), *arguments]) == 0
    with zipfile.ZipFile(out / "feedback.zip") as archive:
        page = archive.read("anna/elbow.html").decode()
    assert "one, only report.pdf" in page and "no points, as there is no program" in page
    assert "wrong" not in page.partition("<main")[2] and "0 of 4" not in page


def test_nobody_answers_an_input(folder, lab, capsys):
    path = written(folder / "a.py", RIGHT.replace("0.118", "float(input('d? '))"))
    assert main(["check", "elbow", str(path), "--labs", str(lab.folder.parent)]) == 0
    assert "nobody answers an input() here" in " ".join(capsys.readouterr().out.split())


def test_a_folder_with_helpers_may_be_a_package(folder, lab, capsys):
    folder = folder / "anna" / "lab_amoro"
    written(folder / "geometry.py", f"from .robot import *\n{RIGHT.replace('elbow', 'point')}")
    written(folder / "robot.py", CONSTANTS)
    for start in (
        "from .geometry import point",
        "from lab_amoro.geometry import point",
        "from . import geometry as g\npoint = g.point",
    ):
        written(folder / "lab.py", f"{start}\ndef elbow(q):\n    return point(q)\n")
        arguments = str(folder / "lab.py"), "--labs", str(lab.folder.parent)
        assert main(["check", "elbow", *arguments]) == 0
        assert "4 of 4 points" in capsys.readouterr().out


def test_a_locked_zip_and_a_broken_member(tmp_path, lab):
    data = bytearray(zipped(tmp_path / "a.zip", {"lab.py": RIGHT}).read_bytes())
    locked = data.replace(
        b"PK\x01\x02\x14\x03\x14\x00\x00\x00", b"PK\x01\x02\x14\x03\x14\x00\x01\x00"
    )
    assert locked != data
    (tmp_path / "a.zip").write_bytes(locked)
    assert [item.word for item in look_into(tmp_path / "a.zip")[1]] == ["locked by a password"]
    data[60:70] = b"\xff" * 10
    (tmp_path / "b.zip").write_bytes(data)
    (program,) = choose(lab, look_into(tmp_path / "b.zip")[0])
    with pytest.raises(SubmissionError, match="no zip that can be read"):
        read_submission(program.path, program.member)


@pytest.mark.deep
def test_a_program_may_import_what_lies_beside_it(labs, folder, tmp_path, capsys):
    geometry = (
        "from math import cos, sin\nfrom robot import *\nhalf = d / 2\n"
        "def point(q):\n    return l11 * cos(q), l11 * sin(q)\n"
    )
    first = "import geometry as g\nfrom geometry import point\n"
    main_file = f"{first}def elbow(q):\n    x, y = point(q)\n    return x - g.half, y\n"
    files = {"lab.py": main_file, "geometry.py": geometry, "robot.py": CONSTANTS}
    for name, text in files.items():
        written(folder / "anna" / name, text)
    zipped(folder / "ben.zip", {f"ben/{name}": text for name, text in files.items()})
    written(folder / "eve.py", "from anna.lab import elbow\n")
    written(folder / "fred.py", "from eve import *\n" + RIGHT)
    out = tmp_path / "out"
    command = [
        "grade",
        "elbow",
        str(folder),
        "--labs",
        str(labs),
        "--out",
        str(out),
        "--isolate",
        "process",
    ]
    assert main(command) == 0
    rows = list(csv.DictReader(io.StringIO((out / "marks.csv").read_text("utf-8-sig"))))
    assert {row["student"]: float(row["mark"]) for row in rows} == {
        "anna": 4,
        "ben": 4,
        "eve": 0,
        "fred": 4,
    }
    assert "ModuleNotFoundError: eve is not available" in (
        out / "students" / "fred.html"
    ).read_text("utf-8")
    capsys.readouterr()
    assert main(["check", "elbow", str(folder / "anna" / "lab.py"), "--labs", str(labs)]) == 0
    assert "4 of 4 points" in capsys.readouterr().out
    written(folder / "anna" / "geometry.py", geometry.replace("d / 2", "d"))
    assert main(command) == 0 and "3 of 4 are graded already" in capsys.readouterr().err


@pytest.mark.deep
def test_all_that_is_not_graded_is_listed_and_stops_nothing(labs, folder, tmp_path, capsys):
    written(folder / "anna" / "lab.py", RIGHT)
    written(folder / "anna" / "control.py", CONTROL)
    written(folder / "ben.py", SHIFTED)
    written(folder / "grades.xlsx", "")
    (folder / "loop").symlink_to("loop")
    out = tmp_path / "out"
    assert (
        main(
            [
                "grade",
                "elbow",
                str(folder),
                "--labs",
                str(labs),
                "--out",
                str(out),
                "--isolate",
                "process",
            ]
        )
        == 0
    )
    err = capsys.readouterr().err
    assert (
        "not graded: grades.xlsx: no program" in err
        and "anna: also there, not graded: anna/control.py" in err
    )
    assert (
        "isolation: process (" in err
        and "loop: Nothing can be graded: it is a symbolic link" in err
    )
    rows = list(csv.DictReader(io.StringIO((out / "marks.csv").read_text("utf-8-sig"))))
    assert [(row["student"], row["file"], row["mark"], row["state"]) for row in rows] == [
        ("anna", "lab.py", "4", "graded"),
        ("ben", "ben.py", "1", "graded"),
        ("loop", "", "", "no program"),
    ]
    page = (out / "summary.html").read_text("utf-8")
    assert "anna/control.py" in page and "grades.xlsx" in page
    inside = [
        "grade",
        "elbow",
        str(folder),
        "--labs",
        str(labs),
        "--out",
        str(folder / "deep" / "out"),
    ]
    assert main(inside) == 2 and "lies within the submissions" in capsys.readouterr().err
    assert not (folder / "deep").exists()


@pytest.mark.deep
def test_two_with_one_id_stop_a_course_in_which_an_id_is_a_robot(labs, folder, tmp_path, capsys):
    secret = written(tmp_path / "secret", "a secret\n")
    options = ["--labs", str(labs), "--out", str(tmp_path / "out"), "--isolate", "process"]
    for pair in (
        ("Anna.py", "anna.py"),
        ("turing_12_1_lab.py", "turing.py"),
        ("turing_1_1_a.py", "turing_2_2_a.py"),
    ):
        for path in folder.glob("*"):
            path.unlink()
        for name in pair:
            written(folder / name, RIGHT)
        assert main(["grade", "elbow", str(folder), *options, "--secret-file", str(secret)]) == 2
        err = capsys.readouterr().err
        assert all(name in err for name in pair) and "which robot is whose?" in err
        assert main(["grade", "elbow", str(folder), *options]) == 0  # all have one robot
        assert "2 students" in capsys.readouterr().out


def test_canvas_gives_each_file_of_one_student_a_name_of_its_own(folder, lab):
    written(folder / "turingalan_123_4567_five_bar_models.py", RIGHT)
    written(folder / "turingalan_123_4568_control-1.py", CONTROL)
    written(folder / "turingalan_124_4569_lab-1.py", SHIFTED)
    entries, _ = find_submissions(folder, lab)
    assert [(entry.path.name, entry.number) for entry in entries] == [
        ("turingalan_123_4567_five_bar_models.py", "123"),
        ("turingalan_124_4569_lab-1.py", "124"),
    ]
    left = left_of(folder, lab)["turingalan_123_4567_five_bar_models.py"]
    assert [item.name for item in left] == ["turingalan_123_4568_control-1.py"]


@pytest.mark.parametrize(
    "data",
    ["\ufeffanna\r\nBen\r\n".encode(), codecs.BOM_UTF16_LE + "anna\nBen".encode("utf-16-le")],
)
def test_a_list_of_ids_as_windows_saves_it(labs, tmp_path, data, capsys):
    secret, ids, out = (
        written(tmp_path / "secret", "a secret"),
        tmp_path / "ids.txt",
        tmp_path / "out",
    )
    ids.write_bytes(data)
    options = ["--labs", str(labs), "--secret-file", str(secret), "--out", str(out)]
    assert main(["grade", "elbow", "--hand-out", str(ids), *options]) == 0
    assert (
        f"\nd = {robot_of(b'a secret', 'anna').d!r}"
        in f"\n{(out / 'anna' / 'student.py').read_text('utf-8')}"
    )
    assert len(list(out.iterdir())) == 2


def test_latin_1_and_utf_16_are_read_and_remarked(labs, tmp_path, capsys):
    french = RIGHT + "# l'angle opposé\n"
    for encoding in ("latin-1", "utf-16", "utf-8-sig"):
        (tmp_path / "my.py").write_bytes(french.encode(encoding))
        assert main(["check", "elbow", str(tmp_path / "my.py"), "--labs", str(labs)]) == 0
        out = " ".join(capsys.readouterr().out.split())
        assert "4 of 4 points" in out and ("save it as UTF-8" in out) == (encoding != "utf-8-sig")
