"""Base parameters that bodies can have, the nearest to those of a regression.

Behind the grouped parameters there are bodies where each distal bar has a mass m2 >= 0 and a first
moment m2 x, so that its inertia about the elbow zz2 + m2 x l (`links`) is at least what its centre
of mass asks for, the end-effector keeps a payload >= 0, and the drive an inertia >= 0 without the
share of the bar that rides on it:

    (zz2 + m2x l) m2 >= (m2x)^2 + my2^2      m - sum m2x / l >= 0      zz1 - (m2 - m2x / l) |P'|^2
    >= 0

and friction >= 0.

A convex set; in it Ipopt finds the least of (theta - theta_0)^T C^-1 (theta - theta_0). Of a
proximal bar's own mass the motors feel nothing, so no first moment is refused.
"""

from __future__ import annotations

import casadi
import numpy as np

from ...models.compiled import minimized
from ...models.robots import Robot

SLACK = 1e-9  # of an inertia, by which it stays above what it must


def consistent(robot: Robot, names: list[str], theta: np.ndarray, cov: np.ndarray) -> np.ndarray:
    """The parameters (p,) nearest to theta in the norm of its covariance that bodies can have;
    others are 0.
    """
    scale = np.maximum(np.abs(theta), np.sqrt(np.diag(cov)))
    p = casadi.SX.sym("p", len(names))
    own = {name: scale[k] * p[k] for k, name in enumerate(names)}
    chol = np.linalg.cholesky(
        np.linalg.pinv(cov / np.outer(scale, scale), hermitian=True) + 1e-12 * np.eye(len(names))
    )
    objective = casadi.sumsqr(casadi.DM(chol.T) @ (p - casadi.DM(theta / scale)))
    extra, bounds, payload = [], [], own.get("m", 0.0)
    inertias = robot.words.inertias
    mass = max(abs(float(theta[names.index("m")])) if "m" in names else robot.m, 1e-6)
    heavy = any(name in own for name in robot.turning_names)
    for k, (drive, bar) in enumerate(zip(robot.drives, robot.distal)):
        zz, my = own.get(robot.turning_names[k], 0.0), own.get(robot.turning_names[k + 2], 0.0)
        size = own.get(inertias[k], getattr(robot, inertias[k]))
        if not heavy:
            bounds.append(size)
            continue
        both = casadi.SX.sym(f"b{k}", 2)  # m2, m2 x / l, in units of the end-effector's mass
        extra.append(both)
        m2, at_end = mass * both[0], mass * both[1]
        about = zz + at_end * bar * bar
        bounds += [
            (about * m2 - (at_end * bar) ** 2 - my * my) / (mass * mass * bar * bar),
            both[0],
            about / (mass * bar * bar),
            (size - (m2 - at_end) * drive.length**2) / (mass * drive.length**2),
        ]
        payload = payload - at_end
    bounds.append(payload / mass)
    bounds += [p[k] for k, name in enumerate(names) if name[0] == "f"]
    x = casadi.vertcat(p, *extra)
    g = casadi.vertcat(*bounds)
    start = np.concatenate([np.maximum(theta / scale, 0.1), np.tile([0.2, 0.1], len(extra))])
    problem = {"x": x, "f": objective, "g": g}
    found, stats = minimized(
        "bodies", problem, {"ipopt.tol": 1e-10}, x0=start, lbg=SLACK, ubg=np.inf
    )
    if not stats["success"]:
        raise ArithmeticError(
            f"no bodies with these parameters were found: {stats['return_status']}"
        )
    return np.array(found["x"]).ravel()[: len(names)] * scale
