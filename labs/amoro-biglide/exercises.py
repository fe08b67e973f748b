"""The biglide of the AMORO lab: its ten functions, right and with the slips that are expected."""

from fivebar import Biglide
from fivebar.grading import ten_models
from fivebar.grading.models import exercises_on

FILE = "biglide_models.py"
PART_OF = "amoro"
ROBOT = Biglide()
CONSTANTS = {"l": ("l1", "l2"), "d": ("d",), "mf": ("mf1", "mf2"), "mp": ("m",)}
SPEED = "Let the feet run at constant speed: is the end-effector's acceleration 0?"
SLIPS = {
    "d forgotten": (SPEED, {"d": lambda s: 0 * s.far}),
    "c forgotten": (SPEED, {"c": lambda s: 0 * s.d}),
}
EXERCISES = exercises_on(Biglide, *ten_models.TEN, slips=SLIPS)
USES = ten_models.USES
