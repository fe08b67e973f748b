"""The five-bar of the AMORO lab: its ten functions."""

from fivebar import FiveBar
from fivebar.grading import ten_models

FILE = "five_bar_models.py"
WITH = ("amoro-biglide",)  # whose file comes in the same hand-in
ROBOT = FiveBar(zz1=0.002025, zz2=0.002025)  # as the lab's files have it, 1.0 * 0.045**2
ALSO = (
    {"zz1": 0.002, "zz2": 0.002},
    {"zz1": 0.002025, "zz2": 0.002025},
)  # as its handout has it; right, too
CONSTANTS = {
    "l": ("l11", "l12", "l21", "l22"),
    "d": ("d",),
    "ZZ1R": ("zz1",),
    "ZZ2R": ("zz2",),
    "mR": ("m",),
}
EXERCISES = ten_models.exercises(FiveBar)
USES = ten_models.USES
