"""The models of the AMORO lab's biglide: fill in the ten functions.

D is a first derivative, DD a second one. The feet slide along y at x = -d/2 and x = d/2; q11, q21 are their heights, m.
Check your work with: fivebar check amoro-biglide biglide_models.py
"""

d = 0.4  # m, between the two slides
l = 0.2828427  # m, each bar
mp = 3.0  # kg, end-effector
mf = 1.0  # kg, each foot


def dgm(q11, q21, assembly_mode):
    """x, y: The end-effector's position (m) for the active joints q11, q21; assembly_mode is -1 or 1."""
    raise NotImplementedError("amoro-biglide: the direct geometric model")


def igm(x, y, gamma1, gamma2):
    """q11, q21: The active joints for the end-effector's position; gamma1, gamma2: the legs' working modes, -1 or 1."""
    raise NotImplementedError("amoro-biglide: the inverse geometric model")


def dgm_passive(q11, q21, assembly_mode):
    """q12, q22: The bars' absolute angles (rad), from the x axis."""
    raise NotImplementedError("amoro-biglide: the passive joints")


def dkm(q11, q12, q21, q22, q11D, q21D):
    """xD, yD: The end-effector's velocity for the active joints' velocities q11D, q21D."""
    raise NotImplementedError("amoro-biglide: the direct kinematic model")


def ikm(q11, q12, q21, q22, xD, yD):
    """q11D, q21D: The active joints' velocities for the end-effector's velocity."""
    raise NotImplementedError("amoro-biglide: the inverse kinematic model")


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    """q12D, q22D: The passive joints' velocities."""
    raise NotImplementedError("amoro-biglide: the passive joints' velocities")


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    """xDD, yDD: The end-effector's acceleration for the active joints' accelerations q11DD, q21DD."""
    raise NotImplementedError("amoro-biglide: the direct second-order model")


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    """q11DD, q21DD: The active joints' accelerations for the end-effector's acceleration."""
    raise NotImplementedError("amoro-biglide: the inverse second-order model")


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    """q12DD, q22DD: The passive joints' accelerations."""
    raise NotImplementedError("amoro-biglide: the passive joints' accelerations")


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    """M, c: M (2 x 2) and c (2) of forces = M @ (q11DD, q21DD) + c."""
    raise NotImplementedError("amoro-biglide: the dynamic model")


# ruff: noqa: E741  l is the lab's own name for the length of the bars
