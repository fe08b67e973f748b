"""What a change is called: by what it is worth in the right model, and by what was wrong with it."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.grading.advice.names import KINDS, Quantities, named_change
from fivebar.grading.columns import QUARTER
from fivebar.grading.judging.questions import rows_of
from fivebar.grading.labs import find_lab
from fivebar.grading.samples import unequal_robot
from fivebar.grading.ten_models import columns_of, motions
from fivebar.grading.worker.wire import Change

ROBOT = unequal_robot(np.random.default_rng(3))
ACC = motions(ROBOT, np.random.default_rng(4), 6)
RATES = ACC.rates
POSE = RATES.pose
M, C = fb.dynamic_model(RATES)
N = len(POSE.q)
PHI = POSE.q + POSE.q_passive


def known(function):
    exercise = find_lab("amoro").exercises()[function]
    columns = columns_of(function, ACC)
    return Quantities(rows_of(exercise, ROBOT, columns, 1e-6, None, {}))


def flat(values):
    return np.reshape(values, (N, -1))


@pytest.mark.parametrize(
    ("function", "old", "new", "kind", "text", "name"),
    [
        ("dkm2", -RATES.d, RATES.d, "a sign", "x => -x", "the sign of d"),
        ("dkm", POSE.A.swapaxes(1, 2), POSE.A, "a transpose", "A.T => A", "A transposed"),
        (
            "dkm",
            POSE.A,
            np.linalg.inv(POSE.A),
            "an inverse",
            "A => inv(A)",
            "A in place of the inverse of A",
        ),
        (
            "dkm",
            POSE.q_passive[:, :1],
            PHI[:, :1],
            "a term",
            "q12 => q12 + q11",
            "q11 forgotten in the direction of the left distal bar",
        ),
        (
            "dkm2",
            (POSE.B @ ACC.q_ddot[..., None])[..., 0] - RATES.d,
            (POSE.B @ ACC.q_ddot[..., None])[..., 0] + RATES.d,
            "a sign",
            "B @ q - d => B @ q + d",
            "the sign of d in B q'' + d",
        ),
        ("dynamic_model", M - 0.1, M, "a bracket", "x => (x)", "a bracket in the wrong place in M"),
        ("dkm", POSE.A @ QUARTER, POSE.A, "a direction", "x => y", "a quarter turn missing in A"),
        (
            "dkm",
            PHI,
            PHI + 3,
            "a variable",
            "inv(B) @ A => inv(A) @ B",
            "the wrong matrix inverted",
        ),
        ("dgm", PHI, 0 * PHI, "a term", "x => 0", "a wrong term"),
        ("dgm", PHI, PHI + 3, "a term", "x[0] + d / 2 => x[0]", "d / 2 too much"),
        ("dgm", PHI, PHI + 3, "a term", "x[0] => x[0] - d / 2", "d / 2 forgotten"),
        (
            "dynamic_model",
            4 * POSE.J.swapaxes(1, 2),
            3 * POSE.J.swapaxes(1, 2),
            "a term",
            "m + zz1 => m",
            "zz1 too much",
        ),
        ("dynamic_model", M, 0 * M, "a term", "M => 0", "M too much"),
        ("dynamic_model", M, M + 1, "a variable", "M => M @ J", "a matrix forgotten in a product"),
        (
            "dynamic_model",
            3 * M,
            M,
            "a matrix product",
            "P * J => P @ J",
            "element by element in place of a matrix product in M",
        ),
        ("dgm", POSE.q[:, :1], POSE.q[:, :1] ** 2, "a square", "a => a ** 2", "a square forgotten"),
        ("dgm", PHI, PHI + 3, "a variable", "q21 => q11", "q21 in place of q11"),
        ("dgm", PHI, PHI + 3, "a variable", "a and b => b and a", "a and b exchanged"),
        (
            "dgm",
            PHI,
            PHI + 3,
            "a variable",
            "kp*(a - b) + kd*c => kd*(a - b) + kp*c",
            "kp and kd exchanged",
        ),
        ("dgm", PHI, PHI + 3, "a variable", "a * b => b * c", "a wrong name"),
        ("dgm", PHI, PHI + 3, "a function", "np.arctan(y/x) => np.arctan2(y, x)", "atan for atan2"),
        ("dgm", PHI, PHI + 3, "a variable", "q11 => q21", "q11 in place of q21"),
        ("dgm", PHI, PHI + 3, "a function", "sin(q) => cos(q)", "sine and cosine exchanged"),
        ("dkm2", -RATES.d, RATES.d, "a function", "abs(d) => d", "an absolute value too much in d"),
        ("dkm2", 0 * RATES.d, RATES.d, "a function", "max(d, 0) => d", "a limit too much in d"),
        ("dgm", PHI, PHI + 3, "a function", "determinant(A) => A", "another function"),
        ("dkm2", -RATES.d, RATES.d, "a mode", "-d => d * gamma1", "the mode forgotten in d"),
    ],
)
def test_a_change_is_called_by_what_it_is_worth(function, old, new, kind, text, name):
    before, after = text.split(" => ")
    change = Change(7, kind, function, before, after)
    told, hint = named_change(change, [(flat(old), flat(new))], known(function))
    assert told == name and hint.endswith((".", "?"))


def test_a_mode_that_is_forgotten_is_hinted_at_by_flipping_it():
    """+1 and -1 have no unit, which would tell other forgotten factors."""
    change = Change(7, "a factor", "dgm", "x", "mode * x")
    dgm = known("dgm")
    (mode,) = (column for name, column in dgm.plain if name == "assembly_mode")
    value = flat(POSE.xi[:, :1])
    told, hint = named_change(change, [(value, value * mode)], dgm)
    assert told == "factor assembly_mode forgotten" and hint.startswith("Flip the mode alone")


def test_each_kind_has_a_name_for_any_text():
    rows = [line.split("; ") for line in KINDS.strip().splitlines()]
    kinds = {kind for kind, *_ in rows}
    assert kinds <= {kind for kind, pattern, *_ in rows if not pattern}
