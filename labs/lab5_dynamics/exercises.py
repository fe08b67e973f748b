"""Lab 5: tau = M q'' + c and both of its uses."""

from fivebar import FiveBar
from fivebar.grading.models import exercises_on

EXERCISES = exercises_on(FiveBar, "dynamic_model", "inverse_dynamics", "forward_dynamics")
USES = dict.fromkeys(("inverse_dynamics", "forward_dynamics"), ("dynamic_model",))
