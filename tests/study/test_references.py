"""References of the charts of speed against accuracy: 50 digits, and the ends of their motions."""

import mpmath
import numpy as np
import pytest

from fivebar.study.speed_accuracy.charts import motions
from fivebar.study.speed_accuracy.charts.exact import DIGITS, cos_sin, distance, exact_motion
from tests.benchmarks.simulators.motions import DRIVEN, DrivenMotion


def position(robot, q, assembly):
    """Where circles about both elbows meet, by complex numbers."""
    e1, e2 = (
        side * mpmath.mpf(robot.d) / 2 + length * mpmath.expj(angle)
        for side, length, angle in ((-1, robot.l11, q[0]), (1, robot.l21, q[1]))
    )
    span = e2 - e1
    cosine = (abs(span) ** 2 + mpmath.mpf(robot.l12) ** 2 - mpmath.mpf(robot.l22) ** 2) / (
        2 * robot.l12 * abs(span)
    )
    return e1 + robot.l12 * span / abs(span) * mpmath.expj(-assembly * mpmath.acos(cosine))


@pytest.mark.parametrize("assembly", [-1, 1])
def test_exact_motion_has_50_digits(robot, assembly):
    rng = np.random.default_rng(3)
    with mpmath.workdps(2 * DIGITS):
        for _ in range(3):
            q, rate, acceleration = rng.uniform(0.2, 0.6, 2), rng.normal(size=2), rng.normal(size=2)
            angles = [[mpmath.mpf(float(x)) for x in v] for v in (q, rate, acceleration)]

            def path(t, angles=angles):
                return position(
                    robot, [a + b * t + c * t * t / 2 for a, b, c in zip(*angles)], assembly
                )

            found = exact_motion(robot, q, rate, acceleration, assembly)
            for order, vector in enumerate(found):
                true = mpmath.diff(path, 0, order)
                off = abs(mpmath.mpc(*(mpmath.mpf(str(x)) for x in vector)) - true) / abs(true)
                assert off < mpmath.mpf(10) ** -DIGITS * 10


def test_decimal_sine_and_cosine():
    from decimal import Decimal, localcontext

    with localcontext(prec=DIGITS + 15), mpmath.workdps(DIGITS + 20):
        for angle in (0.0, 1e-30, -3.0, 2.5, 6.2):
            found = [mpmath.mpf(str(x)) for x in cos_sin(Decimal(angle))]
            assert all(
                abs(a - b) < mpmath.mpf(10) ** -(DIGITS + 5)
                for a, b in zip(found, mpmath.cos_sin(angle))
            )
    assert distance((1.0, 2.0), (Decimal(1), Decimal(2) + Decimal("1e-30"))) == pytest.approx(1e-30)


def redundant_slope(robot, torque=None):
    """state (x, y, q1, q2, rates, t) -> slope by Lagrange multipliers, in mpmath; regular at Type 2."""
    legs = [
        (side * mpmath.mpf(robot.d) / 2, mpmath.mpf(length))
        for side, length in ((-1, robot.l11), (1, robot.l21))
    ]
    z1, z2, m = mpmath.mpf(robot.zz1), mpmath.mpf(robot.zz2), mpmath.mpf(robot.m)

    def leg(base, length, x, y, xd, yd, angle, rate):
        cos, sin = mpmath.cos_sin(angle)
        ex, ey = length * cos, length * sin
        rx, ry, vx, vy = x - base - ex, y - ey, xd + ey * rate, yd - ex * rate
        return rx, ry, ry * ex - rx * ey, -(rx * ex + ry * ey) * rate * rate - vx * vx - vy * vy

    def slope(state):
        x, y, q1, q2, xd, yd, w1, w2, t = state
        tau1, tau2 = torque(t) if torque else (0, 0)
        (r1x, r1y, b1, g1), (r2x, r2y, b2, g2) = (
            leg(*own, x, y, xd, yd, q, w) for own, q, w in zip(legs, (q1, q2), (w1, w2))
        )
        a11, a22 = (
            (r1x * r1x + r1y * r1y) / m + b1 * b1 / z1,
            (r2x * r2x + r2y * r2y) / m + b2 * b2 / z2,
        )
        a12 = (r1x * r2x + r1y * r2y) / m
        det = a11 * a22 - a12 * a12
        g1, g2 = g1 + b1 * tau1 / z1, g2 + b2 * tau2 / z2
        mu1, mu2 = (a22 * g1 - a12 * g2) / det, (a11 * g2 - a12 * g1) / det
        force = (mu1 * r1x + mu2 * r2x) / m, (mu1 * r1y + mu2 * r2y) / m
        return [xd, yd, w1, w2, *force, (tau1 - b1 * mu1) / z1, (tau2 - b2 * mu2) / z2, 1]

    return slope


def extrapolated(slope, y, step, levels):
    """One step of Gragg, Bulirsch and Stoer: midpoint rules of 2, 4, ... substeps, extrapolated to none."""
    rows = []
    for k in range(1, levels + 1):
        h = step / (2 * k)
        a, b = y, [u + h * v for u, v in zip(y, slope(y))]
        for _ in range(2 * k - 1):
            a, b = b, [u + 2 * h * v for u, v in zip(a, slope(b))]
        row = [[(u + v + h * w) / 2 for u, v, w in zip(a, b, slope(b))]]
        for j in range(1, k):
            ratio = (mpmath.mpf(k) / (k - j)) ** 2 - 1
            row.append([u + (u - v) / ratio for u, v in zip(row[-1], rows[-1][j - 1])])
        rows.append(row)
    return rows[-1][-1]


@pytest.mark.every(3)
@pytest.mark.parametrize(
    "name, steps, levels",
    [
        ("regular", 25, 10),
        ("grazing", 32, 11),
        pytest.param("through", 60, 11, marks=pytest.mark.deep),
        pytest.param("forced", 25, 11, marks=pytest.mark.deep),
    ],
)
def test_ends_of_the_motions(name, steps, levels):
    known = [table[name] for table in (motions.MOTIONS, DRIVEN) if name in table]
    robot = motions.ROBOT

    def torque(t):
        wave = mpmath.cos(2 * mpmath.pi * t)
        return mpmath.mpf(0.02) * wave, -mpmath.mpf(0.016) * wave

    with mpmath.workdps(26):
        state = start_of(name, known[0], robot)
        slope = redundant_slope(robot, torque if name == "forced" else None)
        for _ in range(steps):
            state = extrapolated(slope, state, mpmath.mpf(motions.DURATION) / steps, levels)
        for motion in known:
            free = not isinstance(motion, DrivenMotion)
            off = [float(a - b) for a, b in zip(state[:2] if free else state[2:4], motion.end)]
            assert max(abs(x) for x in off) < (1e-16 if free else 4e-16), off


def start_of(name, motion, robot):
    """Positions and rates that close the loop to all digits; the given half is the same floats."""
    rates = motion.begin()
    if name == "through":
        (x, y), (xd, yd) = map(mpmath.mpf, rates.pose.xi), map(mpmath.mpf, rates.xi_dot)
        q, w = [], []
        for side, sign, length, bar in (
            (-1, 1, robot.l11, robot.l12),
            (1, -1, robot.l21, robot.l22),
        ):
            span = mpmath.mpc(x - side * mpmath.mpf(robot.d) / 2, y)
            cosine = (abs(span) ** 2 + mpmath.mpf(length) ** 2 - mpmath.mpf(bar) ** 2) / (
                2 * length * abs(span)
            )
            u = span / abs(span) * mpmath.expj(sign * mpmath.acos(cosine))
            r = span - length * u
            q.append(mpmath.arg(u))
            w.append((r.real * xd + r.imag * yd) / (length * (r.imag * u.real - r.real * u.imag)))
        return [x, y, *q, xd, yd, *w, mpmath.mpf(0)]
    q, w = ([mpmath.mpf(float(v)) for v in vector] for vector in (rates.pose.q, rates.q_dot))
    with mpmath.workdps(60):
        z, v = (
            mpmath.diff(lambda t: position(robot, [a + b * t for a, b in zip(q, w)], -1), 0, k)
            for k in (0, 1)
        )
    return [z.real, z.imag, *q, v.real, v.imag, *w, mpmath.mpf(0)]
