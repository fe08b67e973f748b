import math
import numpy as np

l = 0.09
d = 0.118
ZZ1R = 0.002025
ZZ2R = 0.002025
mR = 0.5


class Leg:
    """One leg of the robot, at a given state."""

    def __init__(self, base, q1=0.0, q2=0.0, q1D=0.0, q2D=0.0):
        self.base = np.array([base, 0.0])
        self.q1 = q1
        self.q2 = q2
        self.q1D = q1D
        self.q2D = q2D
        self.phi = q1 + q2  # absolute angle of the distal link
        self.phiD = q1D + q2D

    # unit vectors
    def e1(self):
        return np.array([math.cos(self.q1), math.sin(self.q1)])

    def n1(self):
        return np.array([-math.sin(self.q1), math.cos(self.q1)])

    def e2(self):
        return np.array([math.cos(self.phi), math.sin(self.phi)])

    def n2(self):
        return np.array([-math.sin(self.phi), math.cos(self.phi)])

    # points
    def elbow(self):
        return self.base + l * self.e1()

    def inverse(self, point, gamma):
        rel = np.asarray(point) - self.base
        dist = math.hypot(*rel)
        bend = math.acos(dist / 2 / l)
        self.q1 = math.atan2(rel[1], rel[0]) + gamma * bend
        return self.q1

    def passive(self, point):
        link = np.asarray(point) - self.elbow()
        return math.atan2(link[1], link[0]) - self.q1

    # rates
    def b(self):
        return l * self.e2() @ self.n1()

    def passive_rate(self, speed):
        relative = speed - l * self.q1D * self.n1()
        return relative @ self.n2() / l - self.q1D

    def centripetal(self):
        return -l * self.q1D**2 * self.e1() - l * self.phiD**2 * self.e2()

    def passive_acceleration(self, acceleration, q1DD):
        rest = acceleration - l * q1DD * self.n1() + l * self.q1D**2 * self.e1()
        return rest @ self.n2() / l - q1DD


class FiveBar:
    def __init__(self, *q):
        # q = q11, q12, q21, q22 and maybe the four rates
        q = list(q) + [0.0] * (8 - len(q))
        self.left = Leg(-d / 2, q[0], q[1], q[4], q[5])
        self.right = Leg(d / 2, q[2], q[3], q[6], q[7])
        self.legs = [self.left, self.right]

    def A(self):
        return np.array([leg.e2() for leg in self.legs])

    def B(self):
        return np.diag([leg.b() for leg in self.legs])

    def drift(self):
        return np.array([leg.e2() @ leg.centripetal() for leg in self.legs])

    def J(self):
        return np.linalg.solve(self.A(), self.B())


def dgm(q11, q21, assembly_mode):
    robot = FiveBar(q11, 0, q21, 0)
    P, Q = robot.left.elbow(), robot.right.elbow()
    w = P - Q
    s = math.sqrt(w @ w)
    h = math.sqrt(l * l - s * s / 4)
    up = np.array([-w[1], w[0]]) / s
    end = (P + Q) / 2 + assembly_mode * h * up
    return end[0], end[1]


def igm(x, y, gamma1, gamma2):
    robot = FiveBar()
    return tuple(leg.inverse((x, y), g) for leg, g in zip(robot.legs, (gamma1, gamma2)))


def dgm_passive(q11, q21, assembly_mode):
    end = dgm(q11, q21, assembly_mode)
    robot = FiveBar(q11, 0, q21, 0)
    return tuple(leg.passive(end) for leg in robot.legs)


def dkm(q11, q12, q21, q22, q11D, q21D):
    robot = FiveBar(q11, q12, q21, q22)
    xD, yD = robot.J() @ [q11D, q21D]
    return xD, yD


def ikm(q11, q12, q21, q22, xD, yD):
    robot = FiveBar(q11, q12, q21, q22)
    speed = np.array([xD, yD])
    return tuple(speed @ leg.e2() / leg.b() for leg in robot.legs)


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    robot = FiveBar(q11, q12, q21, q22, q11D, 0, q21D, 0)
    return tuple(leg.passive_rate(np.array([xD, yD])) for leg in robot.legs)


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    robot = FiveBar(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    rhs = robot.B() @ [q11DD, q21DD] + robot.drift()
    xDD, yDD = np.linalg.solve(robot.A(), rhs)
    return xDD, yDD


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    robot = FiveBar(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    lhs = robot.A() @ [xDD, yDD] - robot.drift()
    q11DD, q21DD = np.linalg.solve(robot.B(), lhs)
    return q11DD, q21DD


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    robot = FiveBar(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    acc = np.array([xDD, yDD])
    return (
        robot.left.passive_acceleration(acc, q11DD),
        robot.right.passive_acceleration(acc, q21DD),
    )


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    robot = FiveBar(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    J = robot.J()
    Z = np.array([[ZZ1R, 0], [0, ZZ2R]])
    M = Z + mR * J.T @ J
    c = mR * J.T @ np.linalg.solve(robot.A(), robot.drift())
    return M, c
