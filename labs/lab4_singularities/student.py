"""Lab 4, singularities: fill in the four functions. README.md says what they shall do.

Check your work with: fivebar check lab4 student.py
"""

# The robot. The checks also set these names to other values: use them, not numbers, inside the functions.
l11 = 0.09  # m, left leg, proximal bar
l12 = 0.09  # m, left leg, distal bar
l21 = 0.09  # m, right leg, proximal bar
l22 = 0.09  # m, right leg, distal bar
d = 0.118  # m, distance of the two base joints
zz1 = 0.002  # kg m^2, grouped inertia of the left proximal bar (from lab 5 on)
zz2 = 0.002  # kg m^2, of the right one
m = 0.5  # kg, grouped mass of the end-effector


def singularity_type(q11, q12, q21, q22):
    """0 regular, 1 serial, 2 parallel, 3 both; a sine of at most 1e-6 counts as 0."""
    raise NotImplementedError("lab4 task 1: the type of a singularity")


def margins(q11, q12, q21, q22):
    """Serial margins s1, s2 of both legs and parallel margin p: three signed sines."""
    raise NotImplementedError("lab4 task 2: the margins")


def type2_point(q11, branch):
    """End-effector x, y (m) with the distal bars stretched in one line; no answer where they cannot be."""
    raise NotImplementedError("lab4 task 3: a point of the Type-2 locus")


def first_crossing(x0, y0, x1, y1, gamma1, gamma2):
    """Part s of the straight path at which it first crosses Type 2, None where it does not."""
    raise NotImplementedError("lab4 task 4: the first crossing on a path")
