"""Which physics is worth its cost: the same task with each rung of it added to what the controller
knows.

rungs     the robots, their rungs and tasks, and what each rung costs and brings
picture   the chart of them
"""

from .picture import figure
from .rungs import CASES, RUNGS, Case, Rung, climb, table

__all__ = ["CASES", "RUNGS", "Case", "Rung", "climb", "figure", "table"]
