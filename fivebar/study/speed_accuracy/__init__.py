"""Speed against accuracy, charted: `fivebar chart NAME|all`. (Coordinate charts are in
`fivebar.models.charts`.)

chart       what a chart is: problems, methods with their knob, panels; the names of all charts
making      charts measured, written and drawn
runner      makes the attempts, in a process that may hang or crash; times and judges them
machine     what was measured on, and what it lacks
store       the measurements as they are made, and as a CSV file
findings    orders of convergence and captions, from the measurements
picture     the picture
page        the HTML page
charts/     the charts themselves
rivals/     other simulators on the same motions
"""

from .making import chart_names, make, redraw

__all__ = ["chart_names", "make", "redraw"]
