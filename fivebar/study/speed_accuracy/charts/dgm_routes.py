"""Routes of the direct geometric model in assembly mode -1: (q11, q21) -> (x, y).

Angles are floats, arrays or CasADi symbols.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ....base.backend import cos, sin, sqrt
from ....models.geometry import dgm
from ....models.robots import FiveBar

ROBOT = FiveBar()
ASSEMBLY = -1

C_LOOP = """
#include <math.h>
void dgm(long n, const double *q, double *xi) {
    const double l = 0.09, d = 0.118, total = 4 * l * l;
    for (long i = 0; i < n; i++) {
        double x1 = -d / 2 + l * cos(q[2 * i]), y1 = l * sin(q[2 * i]);
        double dx = d / 2 + l * cos(q[2 * i + 1]) - x1, dy = l * sin(q[2 * i + 1]) - y1;
        double square = dx * dx + dy * dy, scale = 1 / square;
        double moment = 0.5 * sqrt((total - square) * square);
        xi[2 * i] = x1 + (0.5 * square * dx - moment * dy) * scale;
        xi[2 * i + 1] = y1 + (0.5 * square * dy + moment * dx) * scale;
    }
}
"""
Angle = float | np.ndarray


def ours(q1: Angle, q2: Angle) -> tuple:
    """fivebar.dgm: the RRR dyad."""
    pair: Any = (q1, q2) if isinstance(q1, float) else np.stack([q1, q2], axis=-1)
    return dgm(ROBOT, pair, ASSEMBLY).point


def elbows(q1: Angle, q2: Angle) -> tuple:
    """Return the left elbow, and the vector from it to the right one."""
    half = ROBOT.d / 2
    x1 = ROBOT.l11 * cos(q1) - half
    y1 = ROBOT.l11 * sin(q1)
    return x1, y1, ROBOT.l21 * cos(q2) + half - x1, ROBOT.l21 * sin(q2) - y1


def printed(q1: Angle, q2: Angle) -> tuple:
    """AMORO eq. 1-3 as printed: h = sqrt(l^2 - a^2) with a half the span."""
    x1, y1, dx, dy = elbows(q1, q2)
    span = sqrt(dx * dx + dy * dy)
    a = span / 2
    h = sqrt(ROBOT.l12 * ROBOT.l12 - a * a)
    return x1 + (a * dx - h * dy) / span, y1 + (a * dy + h * dx) / span
