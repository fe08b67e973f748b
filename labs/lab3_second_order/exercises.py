"""Lab 3: A xi'' = B q'' + d and the passive accelerations."""

from fivebar import FiveBar
from fivebar.grading.models import exercises_on

EXERCISES = exercises_on(FiveBar, "dkm2", "ikm2", "dkm2_passive")
