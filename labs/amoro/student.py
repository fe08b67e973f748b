"""The models of the AMORO lab's five-bar: fill in the ten functions.

D is a first derivative, DD a second one. Left leg 1, right leg 2, base joints at (-d/2, 0) and (d/2, 0), m and rad.
Check your work with: fivebar check amoro five_bar_models.py
"""

l = 0.09  # m, each bar
d = 0.118  # m, between the base joints
ZZ1R = 1.0 * 0.045 * 0.045  # kg m^2, left proximal bar about its base joint
ZZ2R = 1.0 * 0.045 * 0.045  # kg m^2, right
mR = 0.5  # kg, end-effector


def dgm(q11, q21, assembly_mode):
    """x, y: The end-effector's position (m) for the active joints q11, q21; assembly_mode is -1 or 1."""
    raise NotImplementedError("amoro: the direct geometric model")


def igm(x, y, gamma1, gamma2):
    """q11, q21: The active joints for the end-effector's position; gamma1, gamma2: the legs' working modes, -1 or 1."""
    raise NotImplementedError("amoro: the inverse geometric model")


def dgm_passive(q11, q21, assembly_mode):
    """q12, q22: The passive joints: each leg's distal bar relative to its proximal bar."""
    raise NotImplementedError("amoro: the passive joints")


def dkm(q11, q12, q21, q22, q11D, q21D):
    """xD, yD: The end-effector's velocity for the active joints' velocities q11D, q21D."""
    raise NotImplementedError("amoro: the direct kinematic model")


def ikm(q11, q12, q21, q22, xD, yD):
    """q11D, q21D: The active joints' velocities for the end-effector's velocity."""
    raise NotImplementedError("amoro: the inverse kinematic model")


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    """q12D, q22D: The passive joints' velocities."""
    raise NotImplementedError("amoro: the passive joints' velocities")


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    """xDD, yDD: The end-effector's acceleration for the active joints' accelerations q11DD, q21DD."""
    raise NotImplementedError("amoro: the direct second-order model")


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    """q11DD, q21DD: The active joints' accelerations for the end-effector's acceleration."""
    raise NotImplementedError("amoro: the inverse second-order model")


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    """q12DD, q22DD: The passive joints' accelerations."""
    raise NotImplementedError("amoro: the passive joints' accelerations")


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    """M, c: M (2 x 2) and c (2) of torques = M @ (q11DD, q21DD) + c."""
    raise NotImplementedError("amoro: the dynamic model")


# ruff: noqa: E741  l is the lab's own name for the length of the bars
