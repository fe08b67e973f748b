"""Lab 1, geometry: fill in the three functions. README.md says what they shall do.

Check your work with: fivebar check lab1 student.py
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


def dgm(q11, q21, assembly_mode):
    """End-effector x, y (m) from the active angles (rad) and the assembly mode (+1 or -1)."""
    raise NotImplementedError("lab1 task 1: the direct geometric model")


def igm(x, y, gamma1, gamma2):
    """Active angles q11, q21 (rad) from the end-effector (m) and the working modes of both legs (+1 or -1)."""
    raise NotImplementedError("lab1 task 2: the inverse geometric model")


def dgm_passive(q11, q21, assembly_mode):
    """Passive angles q12, q22 (rad) from the active angles (rad) and the assembly mode (+1 or -1)."""
    raise NotImplementedError("lab1 task 3: the passive joints")
