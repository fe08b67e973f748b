"""Lab 3, second-order kinematics: fill in the three functions. README.md says what they shall do.

Check your work with: fivebar check lab3 student.py
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


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    """Acceleration xDD, yDD (m/s^2) of the end-effector from the active accelerations (rad/s^2)."""
    raise NotImplementedError("lab3 task 1: the direct model of second order")


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    """Active accelerations q11DD, q21DD (rad/s^2) from that of the end-effector (m/s^2)."""
    raise NotImplementedError("lab3 task 2: the inverse model of second order")


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    """Passive accelerations q12DD, q22DD (rad/s^2)."""
    raise NotImplementedError("lab3 task 3: the passive accelerations")
