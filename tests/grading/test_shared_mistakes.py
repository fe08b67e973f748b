"""A mistake in a helper that has no name and no formula is paid for by one function."""

from dataclasses import replace

import numpy as np
import pytest

from fivebar.grading.grade import grade
from fivebar.grading.labs import find_lab
from fivebar.grading.program import Job
from fivebar.grading.questions import AskedRows
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
