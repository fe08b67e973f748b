"""Lab 2: A xi' = B q' and the passive rates."""

from fivebar import FiveBar
from fivebar.grading.models import exercises_on

EXERCISES = exercises_on(FiveBar, "A", "B", "dkm", "ikm", "dkm_passive")
USES = dict.fromkeys(("dkm", "ikm"), ("A", "B"))
