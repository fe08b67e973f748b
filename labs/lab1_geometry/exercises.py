"""Lab 1: the geometric models of the five-bar."""

from fivebar import FiveBar
from fivebar.grading.models import exercises_on

EXERCISES = exercises_on(FiveBar, "dgm", "igm", "dgm_passive")
USES = {"dgm_passive": ("dgm",)}
