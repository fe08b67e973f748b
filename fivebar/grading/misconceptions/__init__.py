"""Wrong models of the labs' functions, written over drives: the same for a five-bar's cranks and a
biglide's sliders.

`wrong_dgm(kind)` and its like give those that both robots share, in the words for one of them: kind
is the class FiveBar or Biglide. What only one robot's students fall for stands in their lab.
"""
