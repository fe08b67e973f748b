"""What a check is worth, and what is told of it: the Check of what was asked and how it ended, by hand."""

import json
from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.grading import Exercise, Misconception, Verdict
from fivebar.grading.judging.ask import Asked, Wrong
from fivebar.grading.judging.results import Check, Report, checked, withheld

DGM = Exercise("dgm(q11, q21, assembly_mode) -> x, y", None)
SAMPLE = {
    "inputs": {"q11": 0.1, "q21": 0.2, "assembly_mode": -1.0},
    "expected": [0.1, 0.05],
    "came": [0.1, 0.06],
}
LOST = Verdict(
    0.25,
    "value",
    "wrong value of y",
    3,
    4,
    "dgm(q11=0.1)",
    "(0.1, 0.06)",
    0.01,
    Misconception("lost", "Where?", None),
    7,
    "return x, y",
    ("a column",),
    SAMPLE,
    "mean errors",
)
FINE = Verdict(1.0, rows=4, remarks=("a column", "a dict"), beside="OK")
ASKED = [Asked(FINE, "igm"), Asked(FINE)]


def of(record, error, points=3.0):
    return checked("test_a", "A", points, record, error)


def test_what_is_passed_earns_all_and_keeps_the_remarks():
    assert of(ASKED, None) == Check(
        "test_a", "A", 3.0, 3.0, 1.0, "right", "igm", remarks=("a column", "a dict"), beside="OK"
    )
    assert of([], None) == Check("test_a", "A", 3.0, 3.0, 1.0, "right")


@pytest.mark.parametrize(
    ("share", "points", "earned", "outcome"),
    [
        (0.25, 3.0, 0.75, "partly"),
        (1 / 3, 1.0, 0.33, "partly"),
        (2 / 3, 1.0, 0.67, "partly"),
        (0.0, 3.0, 0.0, "wrong"),
        (0.999, 1.0, 1.0, "partly"),
        (0.999, 1.004, 1.0, "partly"),
        (0.9999, 0.125, 0.12, "partly"),
        (0.9999, 0.126, 0.126, "partly"),
        (1e-9, 2.0, 0.0, "partly"),
    ],
)
def test_what_is_partly_right_earns_its_share_to_the_hundredth_and_no_more_than_all(
    share, points, earned, outcome
):
    lost = replace(LOST, share=share)
    found = of([*ASKED, Asked(lost, "dgm", DGM, fb.FiveBar())], Wrong(lost), points)
    assert (found.points, found.max_points, found.share, found.outcome) == (
        earned,
        points,
        share,
        outcome,
    )
    own = "reason text wrong rows asked came off line source beside".split()
    assert [getattr(found, name) for name in own] == [getattr(lost, name) for name in own]
    assert (found.function, found.misconception, found.hint, found.place) == (
        "dgm",
        "lost",
        "Where?",
        "line 7",
    )
    assert found.remarks == ("a column", "a dict") and found.figure.startswith("<svg")


def test_where_nothing_is_known_of_the_place_nothing_is_said():
    lost = Verdict(0.0, "shape", "returned one number", 1, 1)
    found = of([Asked(FINE, "igm"), Asked(lost)], Wrong(lost))
    assert found == Check(
        "test_a",
        "A",
        3.0,
        0.0,
        0.0,
        "wrong",
        "igm",
        "shape",
        "returned one number",
        1,
        1,
        remarks=FINE.remarks,
    )
    assert (found.misconception, found.hint, found.place, found.figure) == ("", "", "", "")


def test_a_plain_assertion_is_a_wrong_answer_and_any_other_error_a_broken_check():
    text = "a  long\nmessage " + "x" * 400
    assert of(ASKED, AssertionError(text)) == Check(
        "test_a",
        "A",
        3.0,
        0.0,
        0.0,
        "wrong",
        "igm",
        "value",
        ("a long message " + "x" * 400)[:300],
        remarks=("a column", "a dict"),
    )
    assert of([], AssertionError()).text == "the check's assertion does not hold"
    broken = of(ASKED, KeyError(text))
    assert (broken.points, broken.share, broken.outcome, broken.reason) == (
        0.0,
        0.0,
        "broken",
        "broken",
    )
    shown = " ".join(str(KeyError(text)).split())[:300]
    assert broken.text == f"the check itself failed: KeyError: {shown}" and broken.max_points == 3.0
    assert (broken.name, broken.title, broken.function) == (
        "test_a",
        "A",
        "",
    ) and broken.remarks == ()


def test_a_report_adds_up_goes_to_json_and_back_and_withholds_what_is_early():
    lost = of([*ASKED, Asked(LOST, "dgm", DGM, fb.FiveBar())], Wrong(LOST))
    report = Report(
        "lab",
        "a.py",
        (of(ASKED, None, 0.1), of(ASKED, None, 0.2), lost),
        "ann",
        "s",
        {"d": 0.1},
        "process",
        "h1",
        "h2",
        "trouble",
        ("n",),
        ("f",),
        "printed",
        1.5,
        True,
        "",
        "",
        ("of this machine",),
    )
    assert report.points == 1.05 and report.max_points == pytest.approx(3.3, rel=1e-15)
    assert report.percent == pytest.approx(100 * 1.05 / 3.3, rel=1e-15)
    assert Report("lab", "a.py", ()).percent == 0.0 and Report("lab", "a.py", ()).points == 0.0
    data = json.loads(json.dumps(report.as_json()))
    assert (data["points"], data["max_points"], data["schema"]) == (1.05, report.max_points, 1)
    again = Report.from_json(data)
    bare = replace(report, checks=(*report.checks[:2], replace(lost, figure="")), warnings=())
    assert (
        again == bare
        and "warnings" not in data
        and not any("figure" in each for each in data["checks"])
    )
    with pytest.raises(ValueError, match="a result of schema 2, not 1"):
        Report.from_json(data | {"schema": 2})
    assert withheld(report) is report
    early = withheld(replace(report, hints_from="2030-01-02"))
    assert early.output == "" and early.notes == ("n", "Explanations are given from 2030-01-02 on.")
    assert early.checks == tuple(
        Check(c.name, c.title, c.max_points, c.points, c.share, c.outcome, reason=word)
        for c, word in zip(report.checks, ("", "", "withheld"))
    )


def test_the_parts_of_an_answer_go_into_one_row_and_out_of_it():
    model = Exercise(
        "  f ( a,b ) ->  M , c, q ", None, angles=("q",), shapes={"M": (2, 2), "c": (2,)}
    )
    assert (model.name, model.arguments, model.returns) == ("f", ("a", "b"), ("M", "c", "q"))
    assert [model.shape(name) for name in model.returns] == [(2, 2), (2,), ()]
    assert model.is_angle().tolist() == [False] * 6 + [True]
    a, b = np.array([1.0, 2.0, 3.0]), np.array([5.0, 6.0, 7.0])
    m = np.array([[[x, y], [2 * x, 2 * y]] for x, y in zip(a, b)])
    flat = model.outcome(lambda robot, a, b: (m, np.stack([a, b], -1), 0.5), None, (a, b))
    assert flat.tolist() == [[x, y, 2 * x, 2 * y, x, y, 0.5] for x, y in zip(a, b)]
    for part, own in zip(
        model.parts(flat), (m, np.stack([a, b], -1), np.full(3, 0.5)), strict=True
    ):
        assert np.array_equal(part, own)
    for signature, angles, words in (
        ("f(a) -> x", ("y", "b"), "f does not return b, y"),
        ("f(a)", (), "a signature reads"),
        ("f(a) -> x!", (), "reads"),
    ):
        with pytest.raises(ValueError, match=words):
            Exercise(signature, None, angles=angles)
    with pytest.raises(ValueError, match="f does not return M"):
        Exercise("f(a) -> x", None, shapes={"M": (2, 2)})
