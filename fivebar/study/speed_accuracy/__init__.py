"""Speed against accuracy, charted: `fivebar chart NAME|all`. (Coordinate charts are in `fivebar.models.charts`.)

table       what a chart is: problems, methods with their knob, panels; the names of all charts
runner      makes the attempts, in a process that may hang or crash; times and judges them
machine     timing, and what it was timed on
store       the measurements as they are made, and as a CSV file
findings    orders of convergence and captions, from the measurements
picture     the picture
page        the HTML page
charts/     the charts themselves
rivals/     other simulators on the same motions
"""

from .study import chart_names, make, redraw

__all__ = ["chart_names", "make", "redraw"]
