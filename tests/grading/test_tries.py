"""Tries at home: the change that gives right answers is told with the second wrong one."""

import pytest

from fivebar.cli import main
from fivebar.grading.grade import grade
from fivebar.grading.intake.program import Job
from fivebar.grading.labs import find_lab
from fivebar.grading.report.tries import tries_file, with_try_counted
from tests.helpers.hand_ins import hand_ins


@pytest.fixture(autouse=True)
def _cache(tmp_path, monkeypatch):
    monkeypatch.setenv("FIVEBAR_CACHE", str(tmp_path / "cache"))


@pytest.fixture
def program(tmp_path):
    (case,) = (c for c in hand_ins("fresh/third.txt") if c.title == "elbow's velocity added")
    path = tmp_path / "five_bar_models.py"
    path.write_text(case.source, "utf-8")
    return path


@pytest.fixture(scope="module")
def wrong(tmp_path_factory):
    """The report on such a file."""
    (case,) = (c for c in hand_ins("fresh/third.txt") if c.title == "elbow's velocity added")
    path = tmp_path_factory.mktemp("hand_in") / "five_bar_models.py"
    path.write_text(case.source, "utf-8")
    return grade(find_lab("amoro"), Job(path))


def change(path):
    path.write_text(path.read_text("utf-8") + "\n# another try\n", "utf-8")


@pytest.mark.deep
def test_the_line_is_told_with_the_second_wrong_try(program, capsys):
    for other_file, told in ((False, False), (False, False), (True, True)):
        if other_file:
            change(program)
        main(["check", "amoro", str(program)])
        text = " ".join(capsys.readouterr().out.split())
        assert ("line 99: v + l * q11D" in text) is told
        assert "looks like " in text


@pytest.mark.every(4)
@pytest.mark.parametrize(("least", "told"), [(0, True), (1, True), (2, False), (3, False)])
def test_the_labs_setting_says_from_which_try_on(program, wrong, least, told, monkeypatch):
    lab = find_lab("amoro")
    monkeypatch.setattr(type(lab), "spots_from", lambda self: least)
    found = with_try_counted(wrong, lab, program)
    assert any("line 99" in check.spot for check in found.checks) is told


@pytest.mark.deep
def test_a_lab_may_say_that_no_line_is_ever_told(program, monkeypatch):
    lab = find_lab("amoro")
    monkeypatch.setattr(type(lab), "spots_from", lambda self: None)
    report = grade(lab, Job(program))
    assert report.points == 18 and not any(check.spot for check in report.checks)
    assert any(check.misconception for check in report.checks)


def test_a_right_try_ends_the_count_and_a_spoilt_file_begins_anew(program, wrong):
    lab = find_lab("amoro")
    good = program.with_name("good.py")
    good.write_text(program.read_text("utf-8").replace("v + l * q11D", "v - l * q11D"), "utf-8")
    right = grade(lab, Job(good))
    assert right.points == 20
    for report, told in ((wrong, False), (right, False), (wrong, False)):
        found = with_try_counted(report, lab, program)
        assert any("line 99" in check.spot for check in found.checks) is told


@pytest.mark.parametrize(
    "text",
    [
        "[no JSON",
        "[1]",
        '{"amoro: PATH": 3}',
        '{"amoro: PATH": {"file": "a", "wrong": [1]}}',
        '{"amoro: PATH": {"file": "a", "wrong": {"dkm_passive": "two"}}}',
        '{"amoro: PATH": {"file": "a", "wrong": {"dkm_passive": null}}}',
        '{"amoro: PATH": {"file": "a", "wrong": {"dkm_passive": 1.5}}}',
        '{"amoro: OTHER": {"file": "a", "wrong": {"igm": "x"}}}',
    ],
)
def test_a_damaged_file_is_told_and_counting_begins_anew(text, program, wrong):
    lab = find_lab("amoro")
    tries_file().parent.mkdir(parents=True)
    tries_file().write_text(text.replace("PATH", str(program.resolve())), "utf-8")
    found = with_try_counted(wrong, lab, program)
    assert found.points == 18 and not any("line 99" in check.spot for check in found.checks)
    assert any("damaged: wrong tries are counted from 0 again" in note for note in found.notes)
    assert not with_try_counted(wrong, lab, program).notes


def test_where_nothing_can_be_written_the_report_says_so(program, wrong, monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("FIVEBAR_CACHE", str(tmp_path / "file"))
    lab = find_lab("amoro")
    found = with_try_counted(wrong, lab, program)
    assert any("Wrong tries cannot be counted" in note for note in found.notes)
    assert not any("line 99" in check.spot for check in found.checks)
