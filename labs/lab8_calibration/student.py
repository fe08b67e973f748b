"""Lab 8, calibration: fill in the five functions. README.md says what they shall do.

All lengths and offsets come as arguments: no numbers of a robot are needed here. The drawing says 0.09 m for all four
bars, 0.118 m for d, and offsets 0.

Check your work with: fivebar check lab8 student.py
"""


def misses(l11, l12, l21, l22, d, offset1, offset2, q1, q2, x, y):
    """e1, e2 (m): by how much each leg's distal bar is too short for the measured point (x, y)."""
    raise NotImplementedError("lab8 task 1: the residual")


def derivatives(l11, l12, l21, l22, d, offset1, offset2, q1, q2, x, y):
    """The matrix J (2 x 7) of the derivatives of e1, e2 by l11, l12, l21, l22, d, offset1, offset2."""
    raise NotImplementedError("lab8 task 2: the Jacobian")


def unseen(l11, l12, l21, l22, d, offset1, offset2, scale):
    """The direction v (8 numbers, of length 1, the last < 0) that points in units of an unknown scale do not show."""
    raise NotImplementedError("lab8 task 3: what cannot be identified")


def calibrate(q, xi):
    """l11, l12, l21, l22, d, offset1, offset2 from lists of pairs: q of (q1, q2), rad, xi of (x, y), m."""
    raise NotImplementedError("lab8 task 4: the calibration")


def own_robot(q, xi):
    """l11, l12, l21, l22, d (m) from such lists, of which one point is wrong by about a centimetre."""
    raise NotImplementedError("lab8 task 5: one wrong point")
