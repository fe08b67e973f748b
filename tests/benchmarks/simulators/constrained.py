"""The five-bar by constrained equations in (x, y, q1, q2), for CasADi."""

from __future__ import annotations

import casadi as ca

from .motions import ROBOT


def multipliers(state: ca.SX, torque: tuple) -> ca.SX:
    """Slope of (x, y, q1, q2, rates): the KKT system of `redundant_slope`, its accelerations
    eliminated.
    """
    rows, gamma, driven = [], [], []
    for k, (drive, z) in enumerate(zip(ROBOT.drives, ROBOT.inertias)):
        cos, sin = ca.cos(state[2 + k]), ca.sin(state[2 + k])
        rx, ry = state[0] - drive.x - drive.length * cos, state[1] - drive.y - drive.length * sin
        vx, vy = (
            state[4] + drive.length * sin * state[6 + k],
            state[5] - drive.length * cos * state[6 + k],
        )
        along = drive.length * (ry * cos - rx * sin)
        rows.append((rx, ry, along))
        gamma.append(vx * vx + vy * vy + drive.length * (rx * cos + ry * sin) * state[6 + k] ** 2)
        driven.append(along * torque[k] / z - gamma[k])
    (x1, y1, b1), (x2, y2, b2) = rows
    a = (
        (x1 * x1 + y1 * y1) / ROBOT.m + b1 * b1 / ROBOT.zz1,
        (x2 * x2 + y2 * y2) / ROBOT.m + b2 * b2 / ROBOT.zz2,
    )
    c = (x1 * x2 + y1 * y2) / ROBOT.m
    det = a[0] * a[1] - c * c
    mu1, mu2 = (a[1] * driven[0] - c * driven[1]) / det, (a[0] * driven[1] - c * driven[0]) / det
    return ca.vertcat(
        state[4:],
        (mu1 * x1 + mu2 * x2) / ROBOT.m,
        (mu1 * y1 + mu2 * y2) / ROBOT.m,
        (torque[0] - b1 * mu1) / ROBOT.zz1,
        (torque[1] - b2 * mu2) / ROBOT.zz2,
    )
