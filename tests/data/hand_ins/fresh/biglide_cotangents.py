"""Biglide by generalised coordinates.

Each leg: y = q + (x - xb) tan(phi), or with k = 1 / tan(phi) for the velocities: yD + k xD = qD.
T = 1/2 mf (q11D^2 + q21D^2) + 1/2 mp (xD^2 + yD^2)
"""
import math

d = 0.4
l = 0.2828427
mp = 3.0
mf = 1.0


class Side:
    """Left (-1) or right (+1) side of the machine."""

    def __init__(self, sign):
        self.x = sign * d / 2

    def slider(self, x, y, gamma):
        """height of the slider"""
        return y + gamma * math.sqrt(l * l - (x - self.x) ** 2)

    def angle(self, q, x, y):
        """absolute angle of the bar"""
        return math.atan2(y - q, x - self.x)

    @staticmethod
    def cot(phi):
        return math.cos(phi) / math.sin(phi)

    @staticmethod
    def cot_dot(phi, phiD):
        return -phiD / math.sin(phi) ** 2

    @staticmethod
    def x_dot(phi, phiD):
        """horizontal velocity of the tip, seen from this side"""
        return -l * math.sin(phi) * phiD

    @staticmethod
    def spin(phi, qD, xD, yD):
        return (math.cos(phi) * (yD - qD) - math.sin(phi) * xD) / l


LEFT = Side(-1)
RIGHT = Side(1)


class Jacobian:
    """xD = (q11D - q21D) / (k1 - k2),  yD = (k1 q21D - k2 q11D) / (k1 - k2)"""

    def __init__(self, phi1, phi2):
        self.k1 = LEFT.cot(phi1)
        self.k2 = RIGHT.cot(phi2)
        self.dk = self.k1 - self.k2

    def rows(self):
        return [1 / self.dk, -1 / self.dk], [-self.k2 / self.dk, self.k1 / self.dk]

    def times(self, a, b):
        return [row[0] * a + row[1] * b for row in self.rows()]

    def transposed_times(self, f, g):
        r, s = self.rows()
        return [r[0] * f + s[0] * g, r[1] * f + s[1] * g]

    def bias(self, phi1, phi2, phi1D, phi2D):
        """acceleration with sliders at constant speed: yDD + k xDD = -kD xD for each side"""
        xD = 0.5 * (LEFT.x_dot(phi1, phi1D) + RIGHT.x_dot(phi2, phi2D))
        e1 = -LEFT.cot_dot(phi1, phi1D) * xD
        e2 = -RIGHT.cot_dot(phi2, phi2D) * xD
        return self.times(e1, e2)


def dgm(q11, q21, assembly_mode):
    # the tip is on the bisector of the two feet
    dy = q21 - q11
    s = math.sqrt(d * d + dy * dy)
    h = math.sqrt(l * l - s * s / 4)
    x = assembly_mode * h * dy / s
    y = 0.5 * (q11 + q21) - assembly_mode * h * d / s
    return x, y


def igm(x, y, gamma1, gamma2):
    return LEFT.slider(x, y, gamma1), RIGHT.slider(x, y, gamma2)


def dgm_passive(q11, q21, assembly_mode):
    x, y = dgm(q11, q21, assembly_mode)
    return LEFT.angle(q11, x, y), RIGHT.angle(q21, x, y)


def dkm(q11, q12, q21, q22, q11D, q21D):
    xD, yD = Jacobian(q12, q22).times(q11D, q21D)
    return xD, yD


def ikm(q11, q12, q21, q22, xD, yD):
    return yD + LEFT.cot(q12) * xD, yD + RIGHT.cot(q22) * xD


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    return LEFT.spin(q12, q11D, xD, yD), RIGHT.spin(q22, q21D, xD, yD)


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    J = Jacobian(q12, q22)
    ax, ay = J.times(q11DD, q21DD)
    bx, by = J.bias(q12, q22, q12D, q22D)
    return ax + bx, ay + by


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    xD1 = LEFT.x_dot(q12, q12D)
    xD2 = RIGHT.x_dot(q22, q22D)
    q11DD = yDD + LEFT.cot(q12) * xDD + LEFT.cot_dot(q12, q12D) * xD1
    q21DD = yDD + RIGHT.cot(q22) * xDD + RIGHT.cot_dot(q22, q22D) * xD2
    return q11DD, q21DD


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    # derivative of l cos(phi) phiD = yD - qD and l sin(phi) phiD = -xD, combined
    q12DD = (math.cos(q12) * (yDD - q11DD) - math.sin(q12) * xDD) / l
    q22DD = (math.cos(q22) * (yDD - q21DD) - math.sin(q22) * xDD) / l
    return q12DD, q22DD


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    J = Jacobian(q12, q22)
    (jx1, jx2), (jy1, jy2) = J.rows()
    M = [[0.0, 0.0], [0.0, 0.0]]
    M[0][0] = mf + mp * (jx1**2 + jy1**2)
    M[0][1] = M[1][0] = mp * (jx1 * jx2 + jy1 * jy2)
    M[1][1] = mf + mp * (jx2**2 + jy2**2)
    bx, by = J.bias(q12, q22, q12D, q22D)
    c = J.transposed_times(mp * bx, mp * by)
    return M, c
