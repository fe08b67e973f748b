"""Lab 6, control: fill in the six functions. README.md says what they shall do.

You need dynamic_model of lab 5 and the igm of lab 1: copy them into this file.

Check your work with: fivebar check lab6 student.py
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


def trajectory(t, x0, y0, x1, y1, duration):
    """x, y, xD, yD, xDD, yDD at time t (s) on the line from (x0, y0) to (x1, y1), at rest at both ends."""
    raise NotImplementedError("lab6 task 1: the trajectory")


def computed_torque(
    q11t, q21t, q11tD, q21tD, q11tDD, q21tDD, q11, q12, q21, q22, q11D, q12D, q21D, q22D, kp, kd
):
    """Torques tau1, tau2 (N m); t marks the target, kp is in 1/s^2 and kd in 1/s."""
    raise NotImplementedError("lab6 task 2: computed torque control")


def gains(period):
    """kp (1/s^2) and kd (1/s) for this control period (s)."""
    raise NotImplementedError("lab6 task 3: gains for a control period")


def meets(x0, y0, x1, y1, duration):
    """Time t (s) of the first singularity on the line, and its type, 1 or 2."""
    raise NotImplementedError("lab6 task 4: where task 2 fails")


def missing_force(x0, y0, x1, y1, duration):
    """The part of m xi'' (N) that no motor can supply there."""
    raise NotImplementedError("lab6 task 5: why task 2 fails")


def crossing_trajectory(t, x0, y0, x1, y1, duration):
    """x, y, xD, yD, xDD, yDD at time t (s) of a motion that crosses with finite torques."""
    raise NotImplementedError("lab6 task 6: a crossing that works")
