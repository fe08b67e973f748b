"""Lab 7, the biglide: fill in the functions. README.md says what they shall do.

Check your work with: fivebar check lab7 student.py
"""

# The robot. The checks also set these names to other values: use them, not numbers, inside the functions.
l1 = 0.2828427  # left bar, m
l2 = 0.2828427  # right bar, m
d = 0.4  # distance of the two guides, m
mf1 = 1.0  # left foot, kg
mf2 = 1.0  # right foot, kg
m = 3.0  # end-effector, kg


def dgm(q11, q21, assembly_mode):
    """End-effector x, y (m) from the feet's coordinates (m) and the assembly mode (+1 or -1)."""
    raise NotImplementedError("lab7 task 1: the direct geometric model")


def igm(x, y, gamma1, gamma2):
    """Feet's coordinates q11, q21 (m) from the end-effector (m) and the working modes of both legs (+1 or -1)."""
    raise NotImplementedError("lab7 task 1: the inverse geometric model")


def dgm_passive(q11, q21, assembly_mode):
    """Angles q12, q22 (rad) of the bars against the x axis, from the feet's coordinates (m) and the assembly mode."""
    raise NotImplementedError("lab7 task 1: the passive joints")


def dkm(q11, q12, q21, q22, q11D, q21D):
    """Velocity xD, yD of the end-effector (m/s) from that of the feet."""
    raise NotImplementedError("lab7 task 2: the direct first-order model")


def ikm(q11, q12, q21, q22, xD, yD):
    """Velocities q11D, q21D of the feet (m/s) from that of the end-effector."""
    raise NotImplementedError("lab7 task 2: the inverse first-order model")


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    """Rates q12D, q22D of the bars (rad/s)."""
    raise NotImplementedError("lab7 task 2: the bars' rates")


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    """Acceleration xDD, yDD of the end-effector (m/s^2) from that of the feet."""
    raise NotImplementedError("lab7 task 3: the direct second-order model")


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    """Accelerations q11DD, q21DD of the feet (m/s^2) from that of the end-effector."""
    raise NotImplementedError("lab7 task 3: the inverse second-order model")


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    """Accelerations q12DD, q22DD of the bars (rad/s^2)."""
    raise NotImplementedError("lab7 task 3: the bars' accelerations")


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    """M (2 x 2) in kg and c (2) in N of tau = M q'' + c."""
    raise NotImplementedError("lab7 task 4: the dynamic model")


def efforts(x, y, xD, yD, xDD, yDD, gamma1, gamma2):
    """Efforts tau1, tau2 of the drives (N) for this motion of the end-effector (m, m/s, m/s^2)."""
    raise NotImplementedError("lab7 task 5: the efforts of a motion (bonus)")


def compliant_crossing(x0, y0, x1, y1, T):
    """Coefficients a, b of x(t) = a[0] + a[1] t + a[2] t^2 + ..., likewise y(t), 0 <= t <= T: with finite efforts."""
    raise NotImplementedError("lab7 task 5: a crossing of Type 2 with finite efforts (bonus)")


def non_compliant_crossing(x0, y0, x1, y1, T):
    """Coefficients a, b likewise: a crossing at which the efforts grow without bound."""
    raise NotImplementedError(
        "lab7 task 5: a crossing of Type 2 with efforts that grow without bound (bonus)"
    )
