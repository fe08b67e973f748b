"""Files as students hand them in: right ones get full marks, mistakes are named, nothing is named that is not so."""

import re
from functools import partial

import numpy as np
import pytest

import fivebar as fb
from fivebar.grading.labs import find_lab
from fivebar.grading.models import derived
from fivebar.grading.samples import unequal_biglide, unequal_robot
from fivebar.grading.ten_models import columns_of, motions
from tests.helpers.hand_ins import graded, hand_ins, outcome
from tests.helpers.lab_session import mistakes
from tests.helpers.mutants import tried

CASES = [*hand_ins("cases.txt"), *hand_ins("others.txt")]
# Points that right functions of fresh/ lose: inv() and solve() answer at a singularity.
OF_ALL = {"lab2": 0.7, "lab7": 0.5}
# Changes that no derivation with a slip gives.
NOT_NAMED = {
    ("the mass of the feet, and a minus", "dynamic_model"),  # two changes in one product
    ("it refuses too early, and the bar is another one's", "ikm"),  # rows of * and @ mixed
    ("both coudes on the left", "dgm_passive"),  # right with the right dgm
    ("rotations added once more", "dgm_passive"),
    ("centripetal terms of the proximal bars", "dkm2_passive"),  # two lines of a leg
    ("two at once", "dkm2"),  # two slips in one function
}


def test_forty_files_and_ten_in_another_hand():
    first, others = list(hand_ins("cases.txt")), list(hand_ins("others.txt"))
    assert len(first) >= 40 and len(others) >= 10
    assert (
        sum(len(case.truths) for case in CASES) >= 90
        and sum(not case.truths for case in CASES) >= 12
    )
    assert len(NOT_NAMED) <= 0.06 * sum(len(case.truths) for case in CASES)


@pytest.mark.every(150)
@pytest.mark.parametrize(
    "case", CASES, ids=[f"{case.title.replace(' ', '_')}_{k}" for k, case in enumerate(CASES)]
)
def test_a_hand_in(case, tmp_path):
    report = graded(case, tmp_path)
    named, false, lost = outcome(case, report)
    assert not report.faults and false == set() and lost == 0
    # A function that is right but for a helper that another one pays for needs no name.
    wrong = {check.function for check in report.checks if check.share < 1}
    assert (set(case.truths) - named) & wrong <= {
        function for title, function in NOT_NAMED if title == case.title
    }
    if not case.truths:
        assert report.points == report.max_points and not any(
            check.misconception for check in report.checks
        )


FRESH = [case for n in ("first", "second", "fifth", "sixth") for case in hand_ins(f"fresh/{n}.txt")]


@pytest.mark.every(200)
@pytest.mark.parametrize("case", FRESH, ids=[case.title.replace(" ", "_") for case in FRESH])
def test_a_mistake_by_another_hand_has_no_false_name_and_costs_no_other_function(case, tmp_path):
    report = graded(case, tmp_path)
    named, false, lost = outcome(case, report)
    unwritten = {"crossing_trajectory", "efforts", "compliant_crossing", "non_compliant_crossing"}
    beside = [c for c in report.checks if c.share < 1 and c.function in unwritten]
    assert not report.faults and {name for name, _ in false} <= set(case.truths)
    assert lost <= sum(c.max_points for c in beside) + OF_ALL.get(case.lab, 0)


EIGHTH = [*hand_ins("fresh/eighth.txt")]


@pytest.mark.every(6)
@pytest.mark.parametrize("case", EIGHTH, ids=[case.title.replace(" ", "_") for case in EIGHTH])
def test_a_slip_is_named_as_a_teacher_would(case, tmp_path):
    report = graded(case, tmp_path)
    for check in report.checks:
        told = f"{check.text} {check.misconception}"
        assert check.share == 1 or re.search(case.truths[check.function], told), check


@pytest.mark.deep
@pytest.mark.parametrize("base", ["amoro scalars", "amoro helpers", "amoro-biglide biglide_loops"])
def test_what_is_named_of_mutants_holds_on_other_rows_of_another_robot(base):
    found = tried(*base.split(), 20, 7)
    named = [case for case in found if case[2]]
    assert len(found) >= 13
    assert sum(case[3] is True for case in named) >= 0.98 * len(named), [
        case for case in named if case[3] is not True
    ]


def right_ones(acc):
    """What the package's own models give for motions: function -> (n, numbers)."""
    rates, pose, n = acc.rates, acc.rates.pose, len(acc.q_ddot)
    M, c = fb.dynamic_model(rates)
    return {
        "dgm": pose.xi,
        "igm": pose.q,
        "dgm_passive": pose.q_passive,
        "dkm": rates.xi_dot,
        "ikm": rates.q_dot,
        "dkm_passive": rates.q_passive_dot,
        "dkm2": acc.xi_ddot,
        "ikm2": acc.q_ddot,
        "dkm2_passive": acc.q_passive_ddot,
        "dynamic_model": np.concatenate([M.reshape(n, -1), c], axis=1),
    }


@pytest.mark.parametrize("lab", ["amoro", "amoro-biglide"])
def test_a_derivation_is_the_right_model_and_each_slip_spoils_some_function(lab):
    draw = np.random.default_rng(6)
    robot = unequal_robot(draw) if lab == "amoro" else unequal_biglide(draw)
    acc, exercises = motions(robot, draw, 16), find_lab(lab).exercises()
    names, spoil = set(), set()
    for name, right in right_ones(acc).items():
        exercise, columns = exercises[name], columns_of(name, acc)
        limits = 1e-9 * np.max(np.abs(right), axis=0)
        for model in (exercise.answer, partial(derived, name, {})):
            came = exercise.outcome(model, robot, columns)
            assert np.all(apart(exercise, came, right) <= limits), name
        for wrong in exercise.wrong:
            came = exercise.outcome(wrong.model, robot, columns)
            names.add(wrong.name)
            if not np.all(apart(exercise, came, right) <= limits):
                spoil.add(wrong.name)
    assert names == spoil


@pytest.mark.parametrize("lab", ["lab1", "lab2", "lab3", "lab5", "lab7"])
def test_each_slip_of_a_lab_is_on_the_list_of_its_mistakes(lab):
    listed = {name for _, names, _ in mistakes(lab) for name in names.split(" | ")}
    exercises = find_lab(lab).exercises().values()
    assert {wrong.name for exercise in exercises for wrong in exercise.wrong} <= listed


def apart(exercise, a, b):
    with np.errstate(invalid="ignore"):
        return np.where(
            exercise.is_angle(), np.abs((a - b + np.pi) % (2 * np.pi) - np.pi), np.abs(a - b)
        )
