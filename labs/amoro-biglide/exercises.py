"""The biglide of the AMORO lab: its ten functions, with the misconceptions of lab 7."""

from fivebar import Biglide
from fivebar.grading.labs import find_lab
from fivebar.grading.ten_models import exercises

ROBOT = Biglide()
CONSTANTS = {"l": ("l1", "l2"), "d": ("d",), "mf": ("mf1", "mf2"), "mp": ("m",)}
EXERCISES = exercises(Biglide, find_lab("lab7").exercises())
