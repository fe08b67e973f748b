"""Charts of accuracy against computing time: `fivebar chart NAME|all`.

catalogue   names of the charts and what each is about
making      measure charts, write and draw them: `make`
chart       what a chart is: problems, methods with a knob, panels
runner      time and judge attempts in a separate process
machine     what was measured on, and what it lacks
store       measurements while they are made, and as a CSV file
findings    orders of convergence and captions, from the measurements
picture     the figure of a chart
page        the HTML page
charts/     the charts themselves
"""
