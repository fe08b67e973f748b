"""The biglide of the AMORO lab: its ten functions."""

from fivebar import Biglide
from fivebar.grading import ten_models

FILE = "biglide_models.py"
PART_OF = "amoro"
ROBOT = Biglide()
CONSTANTS = {"l": ("l1", "l2"), "d": ("d",), "mf": ("mf1", "mf2"), "mp": ("m",)}
EXERCISES = ten_models.exercises(Biglide)
USES = ten_models.USES
