# TP AMORO - modele du robot 5 barres
# Groupe 4
import numpy
import math as mt

# donnees
L = 90e-3
D = 118e-3
masse = 0.5
inertie = [2.025e-3, 2.025e-3]
BASES = (-D / 2, D / 2)


def intersection(xa, ya, xb, yb, signe):
    """ intersection de deux cercles de rayon L """
    dist = mt.hypot(xb - xa, yb - ya)
    angle = mt.atan2(yb - ya, xb - xa)
    ecart = mt.acos(dist / (2 * L))
    return xa + L * mt.cos(angle + signe * ecart), ya + L * mt.sin(angle + signe * ecart)


def coude(i, q):
    return BASES[i] + L * mt.cos(q), L * mt.sin(q)


def dgm(q11, q21, assembly_mode):
    xg, yg = coude(0, q11)
    xd, yd = coude(1, q21)
    return intersection(xg, yg, xd, yd, -assembly_mode)


def igm(x, y, gamma1, gamma2):
    resultat = []
    for base, gamma in zip(BASES, (gamma1, gamma2)):
        xe, ye = intersection(base, 0, x, y, gamma)
        resultat.append(mt.atan2(ye, xe - base))
    return tuple(resultat)


def dgm_passive(q11, q21, assembly_mode):
    x, y = dgm(q11, q21, assembly_mode)
    passifs = []
    for i, q in enumerate([q11, q21]):
        xc, yc = coude(i, q)
        passifs.append(mt.atan2(y - yc, x - xc) - q)
    return passifs


def jacobienne(q11, q12, q21, q22):
    phi1, phi2 = q11 + q12, q21 + q22
    delta = mt.sin(phi2 - phi1)
    b = [L * mt.sin(q12), L * mt.sin(q22)]
    J = numpy.empty((2, 2))
    J[0, 0] = b[0] * mt.sin(phi2) / delta
    J[1, 0] = -b[0] * mt.cos(phi2) / delta
    J[0, 1] = -b[1] * mt.sin(phi1) / delta
    J[1, 1] = b[1] * mt.cos(phi1) / delta
    return J


def derive(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    """ acceleration a vitesse moteur constante """
    phi1, phi2 = q11 + q12, q21 + q22
    w1, w2 = q11D + q12D, q21D + q22D
    s = [-L * mt.cos(q12) * q11D ** 2 - L * w1 ** 2, -L * mt.cos(q22) * q21D ** 2 - L * w2 ** 2]
    delta = mt.sin(phi2 - phi1)
    return numpy.array([s[0] * mt.sin(phi2) - s[1] * mt.sin(phi1), s[1] * mt.cos(phi1) - s[0] * mt.cos(phi2)]) / delta


def dkm(q11, q12, q21, q22, q11D, q21D):
    v = jacobienne(q11, q12, q21, q22) @ [q11D, q21D]
    return v[0], v[1]


def ikm(q11, q12, q21, q22, xD, yD):
    return numpy.linalg.solve(jacobienne(q11, q12, q21, q22), [xD, yD])


def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    out = []
    for q1, q2, qp in ((q11, q12, q11D), (q21, q22, q21D)):
        phi = q1 + q2
        vx = xD + L * mt.sin(q1) * qp
        vy = yD - L * mt.cos(q1) * qp
        out.append((vy * mt.cos(phi) - vx * mt.sin(phi)) / L - qp)
    return out


def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    a = jacobienne(q11, q12, q21, q22) @ numpy.array([q11DD, q21DD])
    a = a + derive(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    return a[0], a[1]


def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    reste = numpy.array([xDD, yDD]) - derive(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
    return numpy.linalg.solve(jacobienne(q11, q12, q21, q22), reste)


def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    out = []
    for q1, q2, qp, qpp in ((q11, q12, q11D, q11DD), (q21, q22, q21D, q21DD)):
        phi = q1 + q2
        ax = xDD + L * mt.sin(q1) * qpp + L * mt.cos(q1) * qp ** 2
        ay = yDD - L * mt.cos(q1) * qpp + L * mt.sin(q1) * qp ** 2
        out.append((ay * mt.cos(phi) - ax * mt.sin(phi)) / L - qpp)
    return out


def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    J = jacobienne(q11, q12, q21, q22)
    M = numpy.diag(inertie) + masse * J.T.dot(J)
    c = masse * J.T.dot(derive(q11, q12, q21, q22, q11D, q12D, q21D, q22D))
    return M, c
