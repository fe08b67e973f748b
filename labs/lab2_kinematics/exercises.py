"""Lab 2: A xi' = B q' and the passive rates, right and with the slips that are expected."""

from fivebar import FiveBar
from fivebar.grading.derivation import dot, inverse, turned
from fivebar.grading.models import exercises_on

SOLVE = "Solve A xi' = B q' for what you look for: which matrix is on the other side?"


def as_one_body(s):
    """Return the velocity of the end of a left leg that does not bend."""
    bars = s.proximal[0] * s.v1[:, 0] + s.distal[0] * s.v2[:, 0]
    return s.rates[:, :1] * bars


SLIPS = {
    "passive joints taken as locked": (
        "Let one motor turn alone: does the leg move as one body?",
        {"xi_dot_found": as_one_body},
    ),
    "share of the elbows forgotten": (
        "Lock the passive joint: does the distal bar turn? How does its elbow move?",
        {"of_pivot": lambda s: 0 * s.rates},
    ),
    "matrices in the wrong order": (
        SOLVE,
        {"J": lambda s: s.B @ inverse(s.A), "J_inverse": lambda s: s.A @ inverse(s.B)},
    ),
    "B forgotten": (
        "A has no unit and xi' is in m/s. What makes rad/s of it?",
        {"J": lambda s: inverse(s.A), "J_inverse": lambda s: s.A + 0 * s.B},
    ),
    "A transposed": (
        "Each scalar product with xi' is one row of A xi' = B q'.",
        {"A": lambda s: turned(s.u2)},
    ),
    "lengths forgotten in B": (
        "A has no unit and xi' is in m/s. Which unit must B have?",
        {"b_ii": lambda s: dot(s.u2, s.v1)},
    ),
}
EXERCISES = exercises_on(FiveBar, "A", "B", "dkm", "ikm", "dkm_passive", slips=SLIPS)
USES = dict.fromkeys(("dkm", "ikm"), ("A", "B"))
