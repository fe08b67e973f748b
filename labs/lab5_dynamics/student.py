"""Lab 5, dynamics: fill in the three functions. README.md says what they shall do.

Check your work with: fivebar check lab5 student.py
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


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    """M (2 x 2, kg m^2) and c (2, N m) of tau = M q'' + c."""
    raise NotImplementedError("lab5 task 1: the dynamic model")


def inverse_dynamics(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    """Torques tau1, tau2 (N m) for given active accelerations (rad/s^2)."""
    raise NotImplementedError("lab5 task 2: the torques of a motion")


def forward_dynamics(q11, q12, q21, q22, q11D, q12D, q21D, q22D, tau1, tau2):
    """Active accelerations q11DD, q21DD (rad/s^2) under given torques (N m)."""
    raise NotImplementedError("lab5 task 3: the motion under torques")
