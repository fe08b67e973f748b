"""Lab 4's singularity_type: the report names the angle that a wrong function uses for Type 2, and no other."""

import re
from math import sin

import numpy as np
import pytest

from fivebar.base.errors import UsageError
from fivebar.grading import check
from fivebar.grading.labs import find_lab
from tests.helpers.lab_session import SOLUTIONS, results

IN_LINE = 1e-6
ANGLES = {
    "q12 - q22": (0, 1, 0, -1),
    "q11 - q21": (-1, 0, 1, 0),
    "q12 + q22": (0, 1, 0, 1),
    "q11 + q12 + q21 + q22": (1, 1, 1, 1),
    "q11 + q22 - q12 - q21": (-1, 1, 1, -1),
    "q11 + q12 - q22": (-1, -1, 0, 1),
    "q22": (0, 0, 0, 1),
}


def report(coefficients, legs=True):
    def singularity_type(*q):
        leg = legs and min(abs(sin(q[1])), abs(sin(q[3]))) <= IN_LINE
        parallel = coefficients is not None and abs(sin(np.dot(coefficients, q))) <= IN_LINE
        return leg + 2 * parallel

    return str(check("lab4", singularity_type=singularity_type))


@pytest.mark.every(7)
@pytest.mark.parametrize("angle", ANGLES)
def test_the_angle_is_named(angle):
    words = report(ANGLES[angle])
    assert f"looks like  Type 2 by the angle {angle}\n" in words


@pytest.mark.deep
def test_types_that_are_never_answered():
    assert "looks like  Types 2 and 3 never named" in report(None)
    assert "looks like  Types 1 and 3 never named" in report((-1, -1, 1, 1), legs=False)


def test_the_right_one_is_right():
    words = report((-1, -1, 1, 1))
    assert "right       3/3  singularity_type" in words
    assert "right       2/2  singularity_type" in words


def test_a_lab_is_found_by_its_number():
    assert find_lab("4").name == find_lab("lab4").name == "lab4_singularities"
    with pytest.raises(UsageError, match="no lab '9'"):
        find_lab("9")


def test_few_samples_of_a_path_miss_a_crossing():
    source = (SOLUTIONS / "lab4.py").read_text("utf-8")
    right = re.search(r"n = .*\n", source)[0]
    few = results("lab4", source.replace(right, "n = 6\n"), only="first_crossing", seed=1)
    lost = {title for title, (_, verdict) in few.items() if verdict.share < 1}
    assert lost == {"first_crossing: paths that cross and come back"}
