"""A mistake in a helper that has no name and no formula is paid for by one function."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fivebar.grading.grade import grade
from fivebar.grading.labs import find_lab
from fivebar.grading.needed import Need, Place, spot_of
from fivebar.grading.program import Job
from fivebar.grading.questions import AskedRows
from fivebar.grading.shared_mistakes import SharedMistakes
from fivebar.grading.worker.wire import Change
from tests.helpers.hand_ins import FOLDER

HELPERS = (FOLDER / "helpers.py").read_text("utf-8")
SIGNATURE = "def compute_d(q11, q12, q21, q22, q11D, q12D, q21D, q22D):"
FOUR = "q11, q12, q21, q22"


def graded(folder, source):
    """The functions that lose points, and what is remarked of those that do not."""
    path = folder / "five_bar_models.py"
    path.write_text(source, encoding="utf-8")
    checks = grade(find_lab("amoro"), Job(path, seed="test")).checks
    wrong = {check.function for check in checks if check.share < 1}
    return wrong, {remark for check in checks if check.share == 1 for remark in check.remarks}


def with_helper(angle, rate):
    """The file with a helper that the grader does not know, and factors of two of its values."""
    source = HELPERS.replace(
        SIGNATURE, f"def bias({FOUR}, rates):\n    q11D, q12D, q21D, q22D = rates"
    )
    source = source.replace(
        f"compute_d({FOUR}, q11D, q12D, q21D, q22D)", f"bias({FOUR}, [q11D, q12D, q21D, q22D])"
    )
    for leg in "12":
        source = source.replace(f"u{leg}2.dot(u{leg}1)", f"np.cos({angle}*q{leg}2)")
        source = source.replace(f"(q{leg}1D + q{leg}2D)**2", f"({rate}*q{leg}1D + q{leg}2D)**2")
    return source


def test_rows_that_have_no_answer_are_no_wrong_ones():
    refuse = np.array([True, True, False, False])
    rows = AskedRows(None, None, (), np.zeros(4), refuse, {}, np.array([True, False, True, False]))
    assert rows.wrong.tolist() == [3]
    assert replace(rows, refuse=~rows.good).wrong.tolist() == []


def test_a_helper_without_a_mistake_costs_nothing(tmp_path):
    assert graded(tmp_path, with_helper(1, 1))[0] == set()


@pytest.mark.deep
def test_one_function_pays_for_what_is_wrong_in_a_helper(tmp_path):
    wrong, remarks = graded(tmp_path, with_helper(0.9, 0.8))
    [payer] = wrong
    assert payer in ("dkm2", "ikm2")
    assert f"wrong by the same values of your bias as {payer}, which pays for them" in remarks


@pytest.mark.deep
def test_each_function_pays_for_what_is_wrong_in_itself(tmp_path):
    source = with_helper(0.9, 0.8).replace("return qDD[0],", "return 1.3*qDD[0] + 0.9*xDD*q11D,")
    wrong, _ = graded(tmp_path, source)
    assert "ikm2" in wrong and len(wrong) == 2


@pytest.mark.deep
def test_a_term_that_a_helper_of_vectors_forgets_is_paid_for_once(tmp_path):
    frames = (FOLDER / "fresh/amoro_frames.py").read_text("utf-8")
    source = frames.replace("return -c1 * qaD**2 - c2", "return -c2")
    wrong, _ = graded(tmp_path, source)
    assert wrong == {"ikm2"}


@pytest.mark.parametrize("first, second", [(True, True), (True, False), (False, True)])
def test_what_is_no_model_is_shared_where_both_functions_make_a_known_mistake(
    first, second, monkeypatch
):
    draw = np.random.default_rng(4)
    outline = {name: ((), ("bias",)) for name in ("dkm2", "ikm2")} | {"bias": ((), ())}
    program = SimpleNamespace(student=SimpleNamespace(outline=outline), robot_in=lambda lab: None)
    shared = SharedMistakes(program, find_lab("amoro"), {"dkm2", "ikm2"})
    place = Place(3, Change(7, "", "bias", "a", ""), np.ones(2, bool), False)
    needed = {(spot_of(place.told), 2): Need(place, *draw.normal(size=(2, 16, 2)))}
    monkeypatch.setattr(shared, "_along", lambda asked: asked)
    monkeypatch.setattr(shared, "_needed", lambda name, rows, where: [needed for _ in rows])
    shared.let_pay("dkm2", [None], first)
    expected = ("dkm2", "bias") if first and second else ("", "")
    assert shared.payer("ikm2", [None], second) == expected
