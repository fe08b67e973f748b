"""What a returned value is read as, and why one that cannot be read is refused."""

import numpy as np
import pytest

from fivebar.grading import Exercise, Reply, judge
from fivebar.grading.values import Unfit, read

DGM = Exercise("dgm(q11, q21, assembly_mode) -> x, y", None)
PAIRS = {"~": "dict", "pairs": [["y", 2.0], ["x", 1]]}
KIND = Exercise("kind(a) -> n", None)
WIDE = Exercise("f(a) -> J", None, shapes={"J": (2, 3)})
MODEL = Exercise("f(a) -> M, c", None, shapes={"M": (2, 2), "c": (2,)})


AS_DICT = "returned as a dict, which counts like the values alone"


@pytest.mark.parametrize(
    ("exercise", "value", "numbers", "remarks"),
    [
        (DGM, [1, True], [1, 1], []),
        (DGM, PAIRS, [1, 2], [AS_DICT]),
        (
            DGM,
            np.array([[1], [2]]),
            [1, 2],
            ["returned one array of shape (2, 1) for the 2 values x, y, which counts like these"],
        ),
        (
            DGM,
            [np.array([[1.0]]), 2],
            [1, 2],
            ["x was returned with shape (1, 1) where a number is asked, which counts as well"],
        ),
        (DGM, [1 + 1e-13j, np.array(-2 + 0j)], [1, -2], []),
        (KIND, 3, [3], []),
        (
            KIND,
            [3],
            [3],
            ["n was returned with shape (1,) where a number is asked, which counts as well"],
        ),
        (KIND, {"~": "dict", "pairs": [["n", 4]]}, [4], [AS_DICT]),
        (
            MODEL,
            [[[1, 2], [3, 4]], [[5], [6]]],
            [1, 2, 3, 4, 5, 6],
            [
                "c was returned with shape (2, 1) where an array of shape (2,) is asked, which counts as well"
            ],
        ),
    ],
)
def test_what_is_read_in_which_order_and_what_is_remarked(exercise, value, numbers, remarks):
    found, notes = read(exercise, value)
    assert (found.tolist(), notes) == (numbers, remarks) and found.dtype == float


@pytest.mark.parametrize(
    ("exercise", "value", "reason", "text"),
    [
        (DGM, None, "type", "returned None: is a return missing?"),
        (
            DGM,
            PAIRS | {"pairs": [["y", 2.0], ["z", 1]]},
            "shape",
            "returned a dict of y, z where 2 (x, y) are asked",
        ),
        (
            DGM,
            PAIRS | {"pairs": [["y", 2], ["x", 1], [3, 4]]},
            "shape",
            "returned a dict of y, x where 2 (x, y) are asked",
        ),
        (
            DGM,
            PAIRS | {"pairs": [[1, 2.0]]},
            "shape",
            "returned a dict of no names where 2 (x, y) are asked",
        ),
        (
            DGM,
            {"~": "other", "type": "Error"},
            "shape",
            "returned an object of type Error where 2 (x, y) are asked",
        ),
        (DGM, np.array(1.0), "shape", "returned one number where 2 (x, y) are asked"),
        (DGM, np.ones((3, 2)), "shape", "returned 3 values where 2 (x, y) are asked"),
        (
            DGM,
            np.ones((2, 2)),
            "shape",
            "x has shape (2,), asked is a number: print the shapes of what you add and multiply",
        ),
        (DGM, [1.0, {"~": "dict", "pairs": []}], "type", "y is a dict, not a number"),
        (
            DGM,
            [{"~": "other", "type": "Pose"}, 1.0],
            "type",
            "x is an object of type Pose, not a number",
        ),
        (DGM, ["1", 1.0], "type", "x is a string, not a number"),
        (DGM, [1.0, None], "type", "y is None, not a number"),
        (DGM, [[1.0, [2.0]], 1.0], "shape", "x is a list of lists of different lengths"),
        (DGM, [1.0, 2 + 1e-11j], "type", "y is complex: the square root of a negative number?"),
        (DGM, [1.0, ["a"]], "type", "y holds something that is not a number"),
        (MODEL, [[1, 2], [3, 4]], "shape", "returned M alone where 2 (M, c) are asked"),
        (WIDE, np.ones((3, 2)), "shape", "J has shape (3, 2), asked is (2, 3): its transpose?"),
        (MODEL, [np.eye(3), [1, 2]], "shape", "M has shape (3, 3), asked is shape (2, 2)"),
    ],
)
def test_what_cannot_be_read_says_why(exercise, value, reason, text):
    with pytest.raises(Unfit) as unfit:
        read(exercise, value)
    assert (unfit.value.reason, str(unfit.value)) == (reason, text)


def test_an_axis_has_no_sense_of_direction():
    """An angle that is half a turn off is another one; an axis is the same."""
    right = np.linspace(-1, 1, 5)
    replies = [Reply("value", [q + np.pi, q + np.pi]) for q in right]
    for axes, share in (((), 0.0), (("phi",), 0.0), (("phi", "psi"), 1.0)):
        angles = tuple({"phi", "psi"} - {*axes})
        model = Exercise("f(q) -> phi, psi", lambda robot, q: (q, q), angles=angles, axes=axes)
        assert judge(model, None, (right,), replies).share == share
    with pytest.raises(ValueError, match="does not return theta"):
        Exercise("f(q) -> phi", None, axes=("theta",))
