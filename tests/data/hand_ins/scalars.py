from math import cos, sin, sqrt, atan2, pi

# five bar robot
L = 0.09
dist = 0.118
m = 0.5
Izz = 0.002

def elbows(q11, q21):
    return -dist / 2 + L * cos(q11), L * sin(q11), dist / 2 + L * cos(q21), L * sin(q21)

def dgm(q11, q21, assembly_mode):
    x1, y1, x2, y2 = elbows(q11, q21)
    hx = (x1 - x2) / 2
    hy = (y1 - y2) / 2
    a = sqrt(hx * hx + hy * hy)
    h = sqrt(L * L - a * a)
    x = x2 + hx - assembly_mode * h / a * hy
    y = y2 + hy + assembly_mode * h / a * hx
    return [x, y]

def igm(x, y, gamma1, gamma2):
    angles = []
    for side, g in ((-1, gamma1), (1, gamma2)):
        X = x - side * dist / 2
        r = sqrt(X**2 + y**2)
        beta = atan2(y, X)
        alpha = atan2(sqrt(L**2 - (r / 2) ** 2), r / 2)
        angles.append(beta + g * alpha)
    return angles

def dgm_passive(q11, q21, assembly_mode):
    x1, y1, x2, y2 = elbows(q11, q21)
    x, y = dgm(q11, q21, assembly_mode)
    q12 = atan2(y - y1, x - x1) - q11
    q22 = atan2(y - y2, x - x2) - q21
    return q12, q22

def dkm(q11, q12, q21, q22, q11D, q21D):
    t1 = q11 + q12
    t2 = q21 + q22
    r1 = L * sin(q12) * q11D
    r2 = L * sin(q22) * q21D
    det = cos(t1) * sin(t2) - sin(t1) * cos(t2)
    xD = (r1 * sin(t2) - r2 * sin(t1)) / det
    yD = (r2 * cos(t1) - r1 * cos(t2)) / det
    return xD, yD

def ikm(q11, q12, q21, q22, xD, yD):
    q11D = (cos(q11 + q12) * xD + sin(q11 + q12) * yD) / (L * sin(q12))
    q21D = (cos(q21 + q22) * xD + sin(q21 + q22) * yD) / (L * sin(q22))
    return q11D, q21D

def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
    q12D = (-sin(q11 + q12) * xD + cos(q11 + q12) * yD) / L - q11D * (1 + cos(q12))
    q22D = (-sin(q21 + q22) * xD + cos(q21 + q22) * yD) / L - q21D * (1 + cos(q22))
    return q12D, q22D

def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
    t1 = q11 + q12
    t2 = q21 + q22
    r1 = L * sin(q12) * q11DD - L * cos(q12) * q11D**2 - L * (q11D + q12D) ** 2
    r2 = L * sin(q22) * q21DD - L * cos(q22) * q21D**2 - L * (q21D + q22D) ** 2
    det = sin(t2 - t1)
    return (r1 * sin(t2) - r2 * sin(t1)) / det, (r2 * cos(t1) - r1 * cos(t2)) / det

def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
    d1 = -L * cos(q12) * q11D**2 - L * (q11D + q12D) ** 2
    d2 = -L * cos(q22) * q21D**2 - L * (q21D + q22D) ** 2
    q11DD = (cos(q11 + q12) * xDD + sin(q11 + q12) * yDD - d1) / (L * sin(q12))
    q21DD = (cos(q21 + q22) * xDD + sin(q21 + q22) * yDD - d2) / (L * sin(q22))
    return q11DD, q21DD

def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
    a1 = -sin(q11 + q12) * xDD + cos(q11 + q12) * yDD
    a2 = -sin(q21 + q22) * xDD + cos(q21 + q22) * yDD
    q12DD = a1 / L - q11DD * (1 + cos(q12)) - q11D**2 * sin(q12)
    q22DD = a2 / L - q21DD * (1 + cos(q22)) - q21D**2 * sin(q22)
    return q12DD, q22DD

def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
    t1 = q11 + q12
    t2 = q21 + q22
    det = sin(t2 - t1)
    b1 = L * sin(q12)
    b2 = L * sin(q22)
    J = [[b1 * sin(t2) / det, -b2 * sin(t1) / det], [-b1 * cos(t2) / det, b2 * cos(t1) / det]]
    d1 = -L * cos(q12) * q11D**2 - L * (q11D + q12D) ** 2
    d2 = -L * cos(q22) * q21D**2 - L * (q21D + q22D) ** 2
    ax = (d1 * sin(t2) - d2 * sin(t1)) / det
    ay = (d2 * cos(t1) - d1 * cos(t2)) / det
    M = [[Izz + m * (J[0][0] ** 2 + J[1][0] ** 2), m * (J[0][0] * J[0][1] + J[1][0] * J[1][1])],
         [m * (J[0][0] * J[0][1] + J[1][0] * J[1][1]), Izz + m * (J[0][1] ** 2 + J[1][1] ** 2)]]
    c = [m * (J[0][0] * ax + J[1][0] * ay), m * (J[0][1] * ax + J[1][1] * ay)]
    return M, c

if __name__ == "__main__":
    print(dgm(0, 0, -1))
