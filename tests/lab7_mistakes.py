"""Lab 7's misconceptions as changes of tests/data/solutions/lab7.py, in the form of tests/lab_mistakes.py."""

FOUR = "(q11, q12, q21, q22, "
DKM = "return solved(A, product(B, (q11D, q21D)))"
IKM = "return solved(B, product(A, (xD, yD)))"
FIRST_ORDER = "    A, B = matrices(q12, q22)\n    "
BIAS = "return -l1 * q12D**2, -l2 * q22D**2"
DKM2 = "def dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):\n"
IKM2 = "def ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):\n"
PASSIVE = "def dgm_passive(q11, q21, assembly_mode):\n"
ANGLES = "q12 = atan2(y - q11, x + d / 2)\n    q22 = atan2(y - q21, x - d / 2)\n    return q12, q22"
DKM_PASSIVE = "def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):\n"
RATES = "return q12D, q22D\n"
DKM2_PASSIVE = "def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):\n"
MODEL = "def dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):\n"
M = "M = [[mf1 + m * JJ[0][0], m * JJ[0][1]], [m * JJ[1][0], mf2 + m * JJ[1][1]]]"
C = "c = [m * f[0], m * f[1]]"


def first(definition, line):
    """(text, its mend): a line put first in a function."""
    return definition, f"{definition}    {line}\n"


RELATIVE = "q12, q22 = q11 + q12, q21 + q22"

MISTAKES = [
    ("dgm", "other assembly mode", *first("def dgm(q11, q21, assembly_mode):\n", "assembly_mode = -assembly_mode")),
    ("dgm", "assembly mode never used", *first("def dgm(q11, q21, assembly_mode):\n", "assembly_mode = -1")),
    ("dgm", "legs exchanged", "def dgm(q11, q21, assembly_mode)", "def dgm(q21, q11, assembly_mode)"),
    ("dgm", "feet slide the other way", *first("def dgm(q11, q21, assembly_mode):\n", "q11, q21 = -q11, -q21")),
    (
        "dgm",
        "horizontal guides instead of vertical ones",
        "a * uy + assembly_mode * h * ux\n    return x, y",
        "a * uy + assembly_mode * h * ux\n    return y, x",
    ),
    ("dgm", "origin on the left guide", "xl, yl = -d / 2, q11\n    xr, yr = d / 2,", "xl, yl = 0, q11\n    xr, yr = d,"),
    ("dgm", "guides at -d and d", "xl, yl = -d / 2, q11\n    xr, yr = d / 2,", "xl, yl = -d, q11\n    xr, yr = d,"),
    ("dgm", "stops at H", "h = sqrt(l2**2 - a**2)", "h = 0"),
    ("dgm", "root of an absolute value", "h = sqrt(l2**2 - a**2)", "h = sqrt(abs(l2**2 - a**2))"),
    ("dgm", "height 0 where the bars do not meet", "h = sqrt(l2**2 - a**2)", "h = sqrt(max(l2**2 - a**2, 0))"),
    ("dgm", "H in the middle although the bars differ", "a = (D**2 + l2**2 - l1**2) / (2 * D)", "a = D / 2"),
    ("dgm", "one length for both bars", *first("def dgm(q11, q21, assembly_mode):\n", "l2 = l1")),
    ("igm", "other working modes", "y + gamma1 * sqrt(l1**2 - (x + d / 2) ** 2)\n    q21 = y + gamma2", "y - gamma1 * sqrt(l1**2 - (x + d / 2) ** 2)\n    q21 = y - gamma2"),
    ("igm", "working modes swapped", "def igm(x, y, gamma1, gamma2)", "def igm(x, y, gamma2, gamma1)"),
    ("igm", "working modes never used", *first("def igm(x, y, gamma1, gamma2):\n", "gamma1 = gamma2 = -1")),
    ("igm", "d instead of d/2", *first("def igm(x, y, gamma1, gamma2):\n", "d = 2 * globals()['d']")),
    ("igm", "guide's x with the wrong sign", *first("def igm(x, y, gamma1, gamma2):\n", "d = -globals()['d']")),
    ("igm", "guides forgotten", *first("def igm(x, y, gamma1, gamma2):\n", "d = 0")),
    ("igm", "height of the end-effector forgotten", "q11 = y + gamma1 * sqrt(l1**2 - (x + d / 2) ** 2)\n    q21 = y + gamma2", "q11 = gamma1 * sqrt(l1**2 - (x + d / 2) ** 2)\n    q21 = gamma2"),
    ("igm", "height of the end-effector with the wrong sign", "q11 = y + gamma1 * sqrt(l1**2 - (x + d / 2) ** 2)\n    q21 = y + gamma2", "q11 = -y + gamma1 * sqrt(l1**2 - (x + d / 2) ** 2)\n    q21 = -y + gamma2"),
    ("igm", "horizontal guides instead of vertical ones", "def igm(x, y, gamma1, gamma2)", "def igm(y, x, gamma1, gamma2)"),
    ("igm", "legs exchanged", "return q11, q21", "return q21, q11"),
    ("igm", "root of an absolute value", "sqrt(l1**2 - (x + d / 2) ** 2)\n    q21 = y + gamma2 * sqrt(l2**2 - (x - d / 2) ** 2)", "sqrt(abs(l1**2 - (x + d / 2) ** 2))\n    q21 = y + gamma2 * sqrt(abs(l2**2 - (x - d / 2) ** 2))"),
    ("igm", "bar laid across towards a guide that it cannot reach", "sqrt(l1**2 - (x + d / 2) ** 2)\n    q21 = y + gamma2 * sqrt(l2**2 - (x - d / 2) ** 2)", "sqrt(max(l1**2 - (x + d / 2) ** 2, 0))\n    q21 = y + gamma2 * sqrt(max(l2**2 - (x - d / 2) ** 2, 0))"),
    ("igm", "one length for both bars", *first("def igm(x, y, gamma1, gamma2):\n", "l2 = l1")),
    ("dgm_passive", "passive angles relative instead of absolute", ANGLES, ANGLES.replace("q12, q22", "q12 - q11, q22 - q21")),
    ("dgm_passive", "angles measured from the guide", ANGLES, ANGLES.replace("q12, q22", "q12 - 1.5707963267948966, q22 - 1.5707963267948966")),
    ("dgm_passive", "atan2 with x before y", ANGLES, "return atan2(x + d / 2, y - q11), atan2(x - d / 2, y - q21)"),
    ("dgm_passive", "atan for atan2", ANGLES, "from math import atan\n    return atan((y - q11) / (x + d / 2)), atan((y - q21) / (x - d / 2))"),
    ("dgm_passive", "right bar's angle taken inwards", ANGLES, ANGLES.replace("q21, x - d / 2)", "q21, d / 2 - x)")),
    ("dgm_passive", "bar read from end-effector to foot", ANGLES, "return atan2(q11 - y, -d / 2 - x), atan2(q21 - y, d / 2 - x)"),
    ("dgm_passive", "other assembly mode", *first(PASSIVE, "assembly_mode = -assembly_mode")),
    ("dgm_passive", "assembly mode never used", *first(PASSIVE, "assembly_mode = -1")),
    ("dgm_passive", "guides forgotten", ANGLES, "return atan2(y - q11, x), atan2(y - q21, x)"),
    ("dgm_passive", "legs exchanged", ANGLES, ANGLES.replace("q12, q22", "q22, q12")),
    ("dgm_passive", "angles returned in degrees", ANGLES, "from math import degrees\n    return degrees(atan2(y - q11, x + d / 2)), degrees(atan2(y - q21, x - d / 2))"),
    ("dkm", "passive angles taken as relative", *first(f"def dkm{FOUR}q11D, q21D):\n", RELATIVE)),
    ("dkm", "sine and cosine exchanged in B", FIRST_ORDER + DKM, f"{FIRST_ORDER}B = [[cos(q12), 0], [0, cos(q22)]]\n    {DKM}"),
    ("dkm", "sine and cosine exchanged in A", DKM, DKM.replace("solved(A,", "solved([row[::-1] for row in A],")),
    ("dkm", "length of the bars in B", DKM, DKM.replace("(q11D, q21D)", "(l1 * q11D, l2 * q21D)")),
    ("dkm", "A and B exchanged", DKM, "return solved(B, product(A, (q11D, q21D)))"),
    ("dkm", "A transposed", DKM, DKM.replace("solved(A,", "solved(turned(A),")),
    ("dkm", "A not inverted", DKM, "return product(A, product(B, (q11D, q21D)))"),
    ("dkm", "matrices in the wrong order", DKM, "return product(B, solved(A, (q11D, q21D)))"),
    ("dkm", "feet taken to move the other way", DKM, DKM.replace("(q11D, q21D)", "(-q11D, -q21D)")),
    ("dkm", "legs exchanged in B", FIRST_ORDER + DKM, f"{FIRST_ORDER}B = [[sin(q22), 0], [0, sin(q12)]]\n    {DKM}"),
    ("ikm", "passive angles taken as relative", *first(f"def ikm{FOUR}xD, yD):\n", RELATIVE)),
    ("ikm", "sine and cosine exchanged in B", FIRST_ORDER + IKM, f"{FIRST_ORDER}B = [[cos(q12), 0], [0, cos(q22)]]\n    {IKM}"),
    ("ikm", "sine and cosine exchanged in A", IKM, IKM.replace("(xD, yD)", "(yD, xD)")),
    ("ikm", "length of the bars in B", FIRST_ORDER + IKM, f"{FIRST_ORDER}B = [[l1 * sin(q12), 0], [0, l2 * sin(q22)]]\n    {IKM}"),
    ("ikm", "A and B exchanged", IKM, "return solved(A, product(B, (xD, yD)))"),
    ("ikm", "B not inverted", IKM, "return product(B, product(A, (xD, yD)))"),
    ("ikm", "A transposed", IKM, IKM.replace("product(A,", "product(turned(A),")),
    ("ikm", "feet taken to move the other way", IKM, IKM.replace("(xD, yD)", "(-xD, -yD)")),
    ("ikm", "legs exchanged", IKM, IKM + "[::-1]"),
    ("dkm_passive", "passive angles taken as relative", *first(DKM_PASSIVE, RELATIVE)),
    ("dkm_passive", "foot taken as standing still", *first(DKM_PASSIVE, "q11D = q21D = 0")),
    ("dkm_passive", "foot's velocity added instead of subtracted", "(yD - q11D)) / l1\n    q22D = (-sin(q22) * xD + cos(q22) * (yD - q21D))", "(yD + q11D)) / l1\n    q22D = (-sin(q22) * xD + cos(q22) * (yD + q21D))"),
    ("dkm_passive", "foot's velocity not projected", "cos(q12) * (yD - q11D)) / l1\n    q22D = (-sin(q22) * xD + cos(q22) * (yD - q21D))", "cos(q12) * yD - q11D) / l1\n    q22D = (-sin(q22) * xD + cos(q22) * yD - q21D)"),
    ("dkm_passive", "length of the bar forgotten", *first(DKM_PASSIVE, "l1 = l2 = 1")),
    ("dkm_passive", "one length for both bars", *first(DKM_PASSIVE, "l2 = l1")),
    ("dkm_passive", "foot's speed subtracted as in the five-bar", RATES, "return q12D - q11D, q22D - q21D\n"),
    ("dkm_passive", "+90 degrees turned the other way", RATES, "return -q12D, -q22D\n"),
    ("dkm_passive", "legs exchanged", RATES, "return q22D, q12D\n"),
    *(
        mistake
        for name, definition in (("dkm2", DKM2), ("ikm2", IKM2))
        for mistake in (
            (name, "passive angles taken as relative", *first(definition, RELATIVE)),
            (name, "centripetal term missing", *first(definition, "q12D = q22D = 0")),
            (name, "centripetal term of the wrong sign", BIAS, BIAS.replace("-l", "l")),
            (name, "rate not squared", BIAS, BIAS.replace("**2", "")),
            (name, "length forgotten in d", BIAS, BIAS.replace("l1 * ", "").replace("l2 * ", "")),
            (name, "foot's speed in place of the bar's rate", *first(definition, "q12D, q22D = q11D, q21D")),
            (name, "sum of both rates as in the five-bar", *first(definition, "q12D, q22D = q11D + q12D, q21D + q22D")),
            (name, "one length for both bars", BIAS, BIAS.replace("l2", "l1")),
            (name, "sine and cosine exchanged in B", "B = [[sin(q12), 0], [0, sin(q22)]]", "B = [[cos(q12), 0], [0, cos(q22)]]"),
        )
    ),
    ("ikm2", "legs exchanged", "return solved(B, (w[0] - b[0], w[1] - b[1]))", "return solved(B, (w[0] - b[0], w[1] - b[1]))[::-1]"),
    ("dkm2_passive", "passive angles taken as relative", *first(DKM2_PASSIVE, RELATIVE)),
    ("dkm2_passive", "centripetal term kept", "return q12DD, q22DD", "return q12DD + q12D**2, q22DD + q22D**2"),
    ("dkm2_passive", "foot's acceleration forgotten", *first(DKM2_PASSIVE, "q11DD = q21DD = 0")),
    ("dkm2_passive", "foot's acceleration added instead of subtracted", *first(DKM2_PASSIVE, "q11DD, q21DD = -q11DD, -q21DD")),
    ("dkm2_passive", "length of the bar forgotten", *first(DKM2_PASSIVE, "l1 = l2 = 1")),
    ("dkm2_passive", "one length for both bars", *first(DKM2_PASSIVE, "l2 = l1")),
    ("dkm2_passive", "foot's acceleration subtracted as in the five-bar", "return q12DD, q22DD", "return q12DD - q11DD, q22DD - q21DD"),
    ("dkm2_passive", "legs exchanged", "return q12DD, q22DD", "return q22DD, q12DD"),
    ("dynamic_model", "passive angles taken as relative", *first(MODEL, RELATIVE)),
    ("dynamic_model", "feet's masses forgotten", *first(MODEL, "mf1 = mf2 = 0")),
    ("dynamic_model", "end-effector's mass forgotten in M", M, "M = [[mf1, 0], [0, mf2]]"),
    ("dynamic_model", "masses of feet and end-effector exchanged", *first(MODEL, "mf1 = mf2 = globals()['m']; m = globals()['mf1']")),
    ("dynamic_model", "both feet added to M as a scalar", M, "M = [[mf1 + mf2 + m * JJ[i][k] for k in (0, 1)] for i in (0, 1)]"),
    ("dynamic_model", "both feet's masses on each drive", *first(MODEL, "mf1 = mf2 = globals()['mf1'] + globals()['mf2']")),
    ("dynamic_model", "feet's masses moved with the end-effector", *first(MODEL, "m = globals()['m'] + globals()['mf1'] + globals()['mf2']; mf1 = mf2 = 0")),
    ("dynamic_model", "one mass for both feet", *first(MODEL, "mf2 = mf1")),
    ("dynamic_model", "c forgotten", C, "c = [0, 0]"),
    ("dynamic_model", "c of the wrong sign", C, "c = [-m * f[0], -m * f[1]]"),
    ("dynamic_model", "c without J^T A^-1", C, "c = [m * b[0], m * b[1]]"),
    ("dynamic_model", "c without A^-1", "a = product(inverted(A), b)", "a = b"),
    ("dynamic_model", "c without J^T", C, "c = [m * a[0], m * a[1]]"),
    ("dynamic_model", "c with the feet's masses", C, "c = [(mf1 + m) * f[0], (mf2 + m) * f[1]]"),
    ("dynamic_model", "J J^T instead of J^T J", "JJ = times(turned(J), J)", "JJ = times(J, turned(J))"),
    ("dynamic_model", "J = B^-1 A", "J = times(inverted(A), B)", "J = times(inverted(B), A)"),
    ("dynamic_model", "end-effector's mass halved", *first(MODEL, "m = globals()['m'] / 2")),
    ("efforts", "c forgotten", "return tau[0] + c[0], tau[1] + c[1]", "return tau"),
    ("efforts", "bias of the second-order model forgotten", "ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD)\n    M", "ikm2(q11, q12, q21, q22, 0, 0, 0, 0, xDD, yDD)\n    M"),
    ("efforts", "accelerations of the end-effector taken for the feet's", "tau = product(M, (q11DD, q21DD))", "tau = product(M, (xDD, yDD))"),
    ("efforts", "working modes never used", "igm(x, y, gamma1, gamma2)\n    q12, q22 =", "igm(x, y, -1, -1)\n    q12, q22 ="),
    ("efforts", "only the end-effector's mass", "(q11DD, q21DD))\n    return tau", "(q11DD, q21DD))\n    tau = tau[0] - mf1 * q11DD, tau[1] - mf2 * q21DD\n    return tau"),
    ("efforts", "legs exchanged", "return tau[0] + c[0], tau[1] + c[1]", "return tau[1] + c[1], tau[0] + c[0]"),
]
