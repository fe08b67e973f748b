"""Lab 2, first-order kinematics: fill in the five functions. README.md says what they shall do.

Check your work with: fivebar check lab2 student.py
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


def A(q11, q12, q21, q22):
    """The 2 x 2 matrix A of A xi' = B q', as [[.., ..], [.., ..]] or a NumPy array."""
    raise NotImplementedError("lab2 task 1: the matrix A")


def B(q11, q12, q21, q22):
    """The 2 x 2 matrix B (m) of A xi' = B q'."""
    raise NotImplementedError("lab2 task 2: the matrix B")


def dkm(q11, q12, q21, q22, q11D, q21D):
    """Velocity xD, yD (m/s) of the end-effector from the active rates (rad/s)."""
    raise NotImplementedError("lab2 task 3: the direct kinematic model")


def ikm(q11, q12, q21, q22, xD, yD):
    """Active rates q11D, q21D (rad/s) from the velocity of the end-effector (m/s)."""
    raise NotImplementedError("lab2 task 4: the inverse kinematic model")


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    """Passive rates q12D, q22D (rad/s) from the active rates and the velocity of the end-effector."""
    raise NotImplementedError("lab2 task 5: the passive rates")
