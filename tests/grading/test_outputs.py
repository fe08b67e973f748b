"""Reports as text, page, CSV, JSON and for Gradescope: complete, harmless, and without the right answers."""

import csv
import io
import json
import math
import os
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from fivebar.grading.course.cohort_page import write_summary
from fivebar.grading.course.items import items, misconceptions, summary_text
from fivebar.grading.course.marks import Table
from fivebar.grading.grade import grade
from fivebar.grading.intake.cohort_folder import Entry
from fivebar.grading.intake.hand_in import Left
from fivebar.grading.intake.program import Job
from fivebar.grading.judging.results import Check, Report
from fivebar.grading.labs import find_lab
from fivebar.grading.report import outputs
from fivebar.grading.report.outputs import file_name
from fivebar.grading.report.page import POLICY, fragment, report_page
from fivebar.grading.report.text import check_lines, report_text
from tests.helpers import DATA

from ..helpers.grading_lab import CRASHES, HALF, RIGHT, SHIFTED, UNTOUCHED, write_lab, written

HOSTILE = '=1+2<script>alert("x")</script>\r\n\x1b[31m\u202e@SUM'


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """source -> Report, each graded once."""
    folder = tmp_path_factory.mktemp("outputs")
    lab, known = find_lab("elbow", write_lab(folder / "mylabs")), {}

    def graded(source):
        if source not in known:
            known[source] = grade(lab, Job(written(folder / "my.py", source), "anna"), home=True)
        return known[source]

    return graded


def check(title="a check", points=1.0, max_points=1.0, **rest):
    share = points / max_points
    outcome = "right" if share == 1 else "partly" if share else "wrong"
    return Check("test_a", title, max_points, points, share, outcome, **rest)


def hostile_report():
    wrong = check(
        HOSTILE,
        0.0,
        function=HOSTILE,
        reason="value",
        text=HOSTILE,
        asked=HOSTILE,
        came=HOSTILE,
        line=1,
        source=HOSTILE,
        place="line 1",
        misconception=HOSTILE,
        hint=HOSTILE,
        remarks=(HOSTILE,),
    )
    return Report(
        "lab",
        HOSTILE,
        (wrong, replace(wrong, name="test_b")),
        HOSTILE,
        trouble=HOSTILE,
        notes=(HOSTILE,),
        output=HOSTILE,
    )


class Tags(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.tags, self.attributes = [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.attributes += [name for name, _ in attributes]


@pytest.mark.deep
def test_a_letter_without_an_accent_keeps_its_place_in_a_file_name():
    assert file_name("Łukasz Żak").startswith("Lukasz_Zak-")


def test_the_same_wrong_numbers_are_explained_once():
    told = {"outcome": "wrong", "function": "f", "reason": "value", "text": "wrong value of x"}
    first = Check("a", "f: here", 1.0, 0.0, 0.0, asked="f(1)", **told)
    known = {}
    assert any("f(1)" in line for line in check_lines(first, 80, known))
    again = check_lines(replace(first, title="f: there"), 80, known)
    assert [line.strip() for line in again[1:]] == ['as in "f: here"']
    other = replace(first, text="wrong value of y")
    assert any("f(1)" in line for line in check_lines(other, 80, known))


def test_the_text_lists_all_checks_and_says_what_to_do(report):
    text = report_text(report(SHIFTED), 80)
    for words in (
        "2/2",
        "elbow: another robot",
        "looks like  origin in the base joint",
        "off by  0.059",
        "total 1 of 4",
    ):
        assert (words in text) == (words != "2/2")
    assert 'as in "elbow: any angle"' in text and "Grading uses hidden ones" in text
    half = report_text(report(HALF), 80)
    assert "where  line 12: raise ValueError('no')" in half and "ValueError: no" in half
    assert "line 1, `import no_such_package`" in " ".join(report_text(report(CRASHES), 80).split())
    assert report_text(report(RIGHT), 80).count("right ") == 3


def test_an_untouched_file_meets_friendly_words(report):
    text = report_text(report(UNTOUCHED), 80)
    assert (
        "Nothing is filled in yet" in text
        and "task 1: the elbow" in text
        and text.count("to do") == 3
    )
    assert "wrong" not in text and "exception" not in text and "Error" not in text
    page = report_page(report(UNTOUCHED))
    assert "task 1: the elbow" in page and '"word wrong"' not in page


def test_of_what_a_program_prints_the_first_lines_are_shown(report):
    printed = [
        report_text(replace(report(RIGHT), output="x\n" * n), 80).split("printed:\n")[1]
        for n in (20, 21)
    ]
    assert [text.count("  x\n") for text in printed] == [20, 20]
    assert ["and more" in text for text in printed] == [False, True]


@pytest.mark.parametrize("width", [60, 80, 200])
def test_the_text_keeps_to_the_terminals_width(report, width):
    for source in (SHIFTED, HALF, UNTOUCHED, CRASHES):
        assert max(map(len, report_text(report(source), width).splitlines())) <= width


def test_colours_only_where_asked(report):
    assert "\x1b" not in report_text(report(SHIFTED)) and "\x1b[31mwrong" in report_text(
        report(SHIFTED), colour=True
    )


def test_no_output_tells_the_right_answer(report):
    """The answers to the first wrong call, recomputed here, are nowhere to more than two digits."""
    found = report(SHIFTED)
    q11 = float(re.search(r"q11=(\S+)\)", found.checks[0].asked)[1])
    right = -0.059 + 0.09 * math.cos(q11)
    texts = (
        report_text(found),
        report_page(found),
        outputs.json_text(found),
        outputs.gradescope_text(found),
        outputs.csv_text(outputs.CHECK_COLUMNS, outputs.check_rows(found)),
    )
    assert not any(f"{right:.3}" in text for text in texts)
    assert "figure" not in outputs.json_text(found)


def test_json_goes_there_and_back(report):
    for source in (RIGHT, SHIFTED, HALF, UNTOUCHED, CRASHES):
        data = json.loads(outputs.json_text(report(source)))
        assert data["schema"] == 1 and Report.from_json(data).as_json() == report(source).as_json()
        assert list(data)[:5] == ["schema", "points", "max_points", "lab", "submission"]
    with pytest.raises(ValueError, match="schema 2"):
        Report.from_json(data | {"schema": 2})


def test_gradescope_reads_the_result(report):
    result = json.loads(outputs.gradescope_text(report(HALF)))
    assert set(result) <= {
        "score",
        "execution_time",
        "output",
        "output_format",
        "visibility",
        "stdout_visibility",
        "tests",
    }
    assert result["score"] == pytest.approx(sum(test["score"] for test in result["tests"]))
    for test, checked in zip(result["tests"], report(HALF).checks, strict=True):
        assert set(test) <= {
            "score",
            "max_score",
            "name",
            "name_format",
            "status",
            "output",
            "output_format",
            "visibility",
        }
        assert (
            test["name"] == checked.title
            and 0 <= test["score"] <= test["max_score"] == checked.max_points
        )
        assert (
            test["status"] == ("passed" if checked.outcome == "right" else "failed")
            and test["visibility"] == "visible"
        )
        assert {test["name_format"], test["output_format"], result["output_format"]} == {"text"}


def test_hostile_text_is_harmless_everywhere(tmp_path):
    hostile = hostile_report()
    for text in (
        report_text(hostile, 80),
        outputs.gradescope_text(hostile),
        outputs.json_text(hostile),
    ):
        assert "\x1b" not in text and "\u202e" not in text and "\r" not in text
    left = [("", Left(HOSTILE, HOSTILE)), (HOSTILE, Left("a", "b"))]
    equal = [((HOSTILE, "anna"), HOSTILE)]
    lost = replace(hostile, ungraded=HOSTILE, checks=())
    write_summary(tmp_path, "lab", [hostile, hostile, lost], left, equal)
    table = Table(tmp_path, ["lab"])
    result = {"lab": (Entry(HOSTILE, tmp_path / "a.py", name=HOSTILE), hostile)}
    mark = table.mark(HOSTILE, "", result, {"lab": 4.0}, (0.0, 0.0), (HOSTILE,))
    written = tmp_path / "marks.csv"
    written.write_text(table.text([mark]), encoding="utf-8")
    assert Table(tmp_path, ["lab"]).by_hand(HOSTILE) == dict.fromkeys(table.titles, "")
    for html in (
        report_page(hostile),
        fragment(hostile),
        (tmp_path / "summary.html").read_text(encoding="utf-8"),
    ):
        tags = Tags(html)
        assert "script" not in tags.tags and not any(
            name.startswith("on") for name in tags.attributes
        )
        assert not {"src", "data", "action", "srcset"} & set(tags.attributes)
        assert "&lt;script&gt;" in html and "\x1b" not in html and "\u202e" not in html
    assert f'content="{POLICY}"' in report_page(hostile) and POLICY.startswith("default-src 'none'")
    for name in ("checks.csv", "marks.csv", "misconceptions.csv", "items.csv"):
        rows = list(
            csv.reader(io.StringIO((tmp_path / name).read_text(encoding="utf-8"), newline=""))
        )
        assert len({len(row) for row in rows}) == 1
        assert not any(
            cell.startswith(("=", "+", "-", "@", "\t", "\r")) for row in rows for cell in row
        )


def test_no_part_of_a_cell_is_a_formula_where_a_semicolon_parts_cells():
    assert (
        outputs.cell("a;=1; -2|@b\t+c") == "a;'=1;' -2|'@b\\t'+c"
        and outputs.cell("a; b, -c") == "a; b, -c"
    )


@pytest.mark.parametrize(
    "text", ["=1", "+1", "-1", "@a", "\tx", "\rx", "\nx", "  =1", "\uff1d1", "\u3000+1"]
)
def test_no_cell_is_a_formula(text):
    assert outputs.cell(text).startswith("'")
    assert (
        outputs.cell("plain = text") == "plain = text"
        and outputs.cell(-1.5) == -1.5
        and outputs.cell(None) == ""
    )


def test_file_names_are_plain_and_differ():
    ids = [
        "anna",
        "Anna",
        "ANNA",
        "../anna",
        "..",
        "",
        "a/b",
        "a\\b",
        "a\nb",
        "a b",
        "Ålfa",
        "con:",
        "x" * 300,
        "\udcff",
    ]
    ids += [
        outputs.file_name("a b"),
        outputs.file_name("a/b"),
    ]  # who calls himself so gets no one else's file
    names = [outputs.file_name(student) for student in ids]
    assert outputs.file_name("Éva Müller").startswith("Eva_Muller-")
    assert len({name.casefold() for name in names}) == len(ids) and names[0] == "anna"
    assert all(re.fullmatch(r"[A-Za-z0-9_-]{1,80}", name) for name in names)


def test_a_file_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / "a.json"
    outputs.write_whole(path, "old")
    monkeypatch.setattr(os, "replace", lambda *names: (_ for _ in ()).throw(OSError("no room")))
    with pytest.raises(OSError, match="no room"):
        outputs.write_whole(path, "new")
    assert path.read_text("utf-8") == "old" and list(tmp_path.iterdir()) == [path]


@pytest.mark.deep
def test_figures_show_both_poses_where_the_answers_are_poses(tmp_path):
    source = (DATA / "solutions" / "lab1.py").read_text(encoding="utf-8")
    for name in ("dgm", "igm", "dgm_passive"):  # an error of 10 % in the second number
        source += f"\n\ntry:\n    right_{name} = {name}\n    def {name}(*row):\n        a, b = right_{name}(*row)\n"
        source += "        return a, 1.1 * b + 0.01\nexcept NameError:\n    pass\n"
    found = grade(find_lab("lab1"), Job(written(tmp_path / "my.py", source)))
    assert {c.function for c in found.checks if c.figure} == {"dgm", "igm", "dgm_passive"}
    for figure in (c.figure for c in found.checks if c.figure):
        numbers = [
            float(n)
            for points in re.findall(r'points="([^"]*)"', figure)
            for n in re.split("[ ,]", points)
        ]
        assert (
            len(numbers) >= 24
            and -1 <= min(numbers)
            and max(numbers) <= 301
            and all(n == int(n) for n in numbers)
        )


def cohort():
    """Five students, three checks of 1, 2, 2 points."""
    table = [(1, 2, 2), (1, 2, 0), (1, 1, 2), (0, 0, 2), (0, 0, 0)]
    reports = []
    for k, (a, b, c) in enumerate(table):
        wrong = {"function": "dgm", "misconception": "other mode", "hint": "h"} if b == 0 else {}
        checks = check("A", float(a)), check("B", float(b), 2.0, **wrong), check("C", float(c), 2.0)
        checks = tuple(replace(part, name=name) for part, name in zip(checks, "abc"))
        reports.append(Report("lab", f"s{k}.py", checks, f"s{k}"))
    return reports


def test_item_analysis_by_hand():
    """A: passed 1 1 1 0 0, rest 4 2 3 2 0: sums of squares 1.2 and 8.8, of products 2.4. B: 1 1 0 0 0 and 3 1 3 2 0."""
    a, b, c = items(cohort())
    assert (a.pass_rate, b.pass_rate, c.pass_rate) == (0.6, 0.4, 0.6)
    assert b.mean == pytest.approx(0.5)
    assert a.discrimination == pytest.approx(2.4 / math.sqrt(1.2 * 8.8), rel=1e-12)
    assert b.discrimination == pytest.approx(0.4 / math.sqrt(1.2 * 6.8), rel=1e-12)
    assert math.isnan(items(cohort()[:1])[0].discrimination)
    assert misconceptions(cohort()) == [(("dgm", "other mode"), 2)]
    text = summary_text("lab", cohort())
    assert text == "lab: 5 students, mean 56 %, median 60 %, with all points: 1"
    assert summary_text("lab", cohort()[:1]).startswith("lab: 1 student, mean")
