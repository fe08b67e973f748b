"""Routes of the direct geometric model: (q11, q21), floats or arrays, -> (x, y) in assembly mode
-1.
"""

from __future__ import annotations

import math

import numpy as np

from ....base.backend import cos, sin, sqrt
from ....models.geometry import dgm
from ....models.robots import FiveBar
from ...pitfalls.half_angle import half_angle

ROBOT, ASSEMBLY = FiveBar(), -1

C_LOOP = """
#include <math.h>
void dgm(long n, const double *q, double *xi) {
    const double l = 0.09, d = 0.118, total = 4 * l * l;
    for (long i = 0; i < n; i++) {
        double x1 = -d / 2 + l * cos(q[2 * i]), y1 = l * sin(q[2 * i]);
        double dx = d / 2 + l * cos(q[2 * i + 1]) - x1, dy = l * sin(q[2 * i + 1]) - y1;
        double square = dx * dx + dy * dy, moment = 0.5 * sqrt((total - square) * square), scale = 1 / square;
        xi[2 * i] = x1 + (0.5 * square * dx - moment * dy) * scale;
        xi[2 * i + 1] = y1 + (0.5 * square * dy + moment * dx) * scale;
    }
}
"""


def ours(q1: float | np.ndarray, q2: float | np.ndarray) -> tuple:
    pose = dgm(ROBOT, (q1, q2) if isinstance(q1, float) else np.stack([q1, q2], axis=-1), ASSEMBLY)
    return pose.point


def elbows(q1: float | np.ndarray, q2: float | np.ndarray) -> tuple:
    half = ROBOT.d / 2
    x1, y1 = ROBOT.l11 * cos(q1) - half, ROBOT.l11 * sin(q1)
    return x1, y1, ROBOT.l21 * cos(q2) + half - x1, ROBOT.l21 * sin(q2) - y1


def printed(q1: float | np.ndarray, q2: float | np.ndarray) -> tuple:
    """AMORO eq. 1-3 as printed: h = sqrt(l^2 - a^2) with a half the span."""
    x1, y1, dx, dy = elbows(q1, q2)
    span = sqrt(dx * dx + dy * dy)
    a = span / 2
    h = sqrt(ROBOT.l12 * ROBOT.l12 - a * a)
    return x1 + (a * dx - h * dy) / span, y1 + (a * dy + h * dx) / span


def tangent_half_angle(q1: float | np.ndarray, q2: float | np.ndarray) -> tuple:
    """The left distal bar's angle from dx cos + dy sin = c, by its tangent half-angle."""
    x1, y1, dx, dy = elbows(q1, q2)
    c = (dx * dx + dy * dy + ROBOT.l12**2 - ROBOT.l22**2) / (2 * ROBOT.l12)
    phi = half_angle(dy, dx, -c, 1)
    return x1 + ROBOT.l12 * np.cos(phi), y1 + ROBOT.l12 * np.sin(phi)


def arctg(q1: float | np.ndarray, q2: float | np.ndarray) -> tuple:
    """The vector method's eq. 9: the bar's angle as the arctg of its components, which does not
    know its quadrant.
    """
    x1, y1, dx, dy = elbows(q1, q2)
    square = dx * dx + dy * dy
    along = 0.5 + (ROBOT.l12**2 - ROBOT.l22**2) / (2 * square)
    across = sqrt(ROBOT.l12**2 / square - along * along)
    phi = (math if isinstance(q1, float) else np).atan(
        (along * dy + across * dx) / (along * dx - across * dy)
    )
    return x1 + ROBOT.l12 * cos(phi), y1 + ROBOT.l12 * sin(phi)


def equivalent_four_bar(q1: float | np.ndarray, q2: float | np.ndarray) -> tuple:
    """MechAnalyzer eq. 17-21: base and right crank become one imaginary ground link, the rest is
    its four-bar.

    Its coupler point by its eq. 1-11: y from a quadratic, x from the difference of the circles.
    """
    d, l4 = ROBOT.d, ROBOT.l21
    arcsine = (math if isinstance(q1, float) else np).asin
    ground = sqrt(d * d + l4 * l4 - 2 * d * l4 * cos(math.pi - q2))
    turn = arcsine(l4 * sin(2 * math.pi - q2) / ground)  # the sine rule: right as long as l21 < d
    ax, ay = ROBOT.l11 * cos(q1 + turn), ROBOT.l11 * sin(q1 + turn)
    off = ground - ax
    s = (ROBOT.l12**2 - ROBOT.l22**2 + ground**2 - ax * ax - ay * ay) / (2 * off)
    p, t = 1 + (ay / off) ** 2, s - ground
    quarter = (t * ay / off) ** 2 - p * (t * t - ROBOT.l22**2)
    side = 1 - 2 * (off < 0)  # the root on the left of the line from the elbow to the right pivot
    y = (-t * ay / off + side * sqrt(quarter)) / p
    x = s + ay * y / off
    return x * cos(turn) + y * sin(turn) - d / 2, y * cos(turn) - x * sin(turn)
