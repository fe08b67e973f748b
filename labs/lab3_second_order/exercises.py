"""Lab 3: A xi'' = B q'' + d and the passive accelerations, right and with the slips that are
expected.
"""

from fivebar import FiveBar
from fivebar.grading.derivation import product
from fivebar.grading.models import exercises_on

SLIPS = {
    "d forgotten": (
        "Let the motors run at constant speed: is the end-effector's acceleration 0?",
        {"d": lambda s: 0 * s.far},
    ),
    "centripetal term of the proximal bar missing": (
        "The elbows turn about their base joints. What do they do at constant speed?",
        {"near": lambda s: 0 * s.rates},
    ),
    "centripetal term of the distal bar missing": (
        "The end-effector turns about the elbow. At which rate?",
        {"far": lambda s: 0 * s.rates},
    ),
    "d not multiplied by the inverse of A": (
        "A xi'' = B q'' + d: solve it for what you look for.",
        {"xi_ddot_found": lambda s: product(s.J, s.accelerations) + s.d},
    ),
    "passive angles taken as absolute": (
        "Which angle does the distal bar make with the x axis? q12 is measured from the other bar.",
        {"phi": lambda s: s.passive},
    ),
    "centripetal term missing": (
        "The elbows turn about their base joints. What do they do at constant speed?",
        {"pull": lambda s: 0 * s.rates},
    ),
}
EXERCISES = exercises_on(FiveBar, "dkm2", "ikm2", "dkm2_passive", slips=SLIPS)
