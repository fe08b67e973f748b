"""Base parameters that bodies can have, the nearest to those of a regression.

Behind the grouped parameters there are bodies: each distal bar has a mass m2 >= 0 and a first
moment m2 x, so that its inertia about the elbow zz2 + m2 x l (`links`) is at least what its centre
of mass asks for; the end-effector keeps a payload >= 0; the drive has an inertia >= 0 without the
share of the bar that rides on it:

    (zz2 + m2x l) m2 >= (m2x)^2 + my2^2      m - sum m2x / l >= 0
    zz1 - (m2 - m2x / l) |P'|^2 >= 0

and friction is >= 0. In this convex set, Ipopt finds the least of (theta - theta_0)^T C^-1 (theta -
theta_0). The motors feel nothing of a proximal bar's own mass, so no first moment is refused.
"""

from __future__ import annotations

from typing import Any

import casadi
import numpy as np
from numpy import ndarray

from ...models.compiled import minimized

LEAST = 1e-7  # of all that is bounded, in its own unit: Ipopt moves bounds by 1e-8


def consistent(robot: Any, names: list[str], theta: ndarray, cov: ndarray) -> ndarray:
    """Return the parameters (p,) nearest to theta, by its covariance, that bodies can have."""
    scale = np.maximum(np.abs(theta), np.sqrt(np.diag(cov)))
    p = casadi.SX.sym("p", len(names))
    own = {name: scale[k] * p[k] for k, name in enumerate(names)}
    weight = np.linalg.pinv(cov / np.outer(scale, scale), hermitian=True)
    chol = np.linalg.cholesky(weight + 1e-12 * np.eye(len(names)))
    objective = casadi.sumsqr(casadi.DM(chol.T) @ (p - casadi.DM(theta / scale)))
    mass = max(abs(float(theta[names.index("m")])) if "m" in names else robot.m, 1e-6)
    heavy = any(name in own for name in robot.turning_names)
    extra = []
    bounds = []
    payload = own.get("m", 0.0)
    for k, (drive, bar) in enumerate(zip(robot.drives, robot.distal)):
        inertia = robot.words.inertias[k]
        size = own.get(inertia, getattr(robot, inertia))
        inertia_of_mass = mass * drive.length**2
        if not heavy:
            bounds.append(size / inertia_of_mass)
            continue
        zz, my = (own.get(robot.turning_names[k + place], 0.0) for place in (0, 2))
        shares = casadi.SX.sym(f"b{k}", 2)  # m2, m2 x / l, in units of the end-effector's mass
        extra.append(shares)
        m2 = mass * shares[0]
        at_end = mass * shares[1]
        about = zz + at_end * bar * bar
        bounds += [
            (about * m2 - (at_end * bar) ** 2 - my * my) / (mass * mass * bar * bar),
            shares[0],
            about / (mass * bar * bar),
            (size - (m2 - at_end) * drive.length**2) / inertia_of_mass,
        ]
        payload = payload - at_end
    bounds.append(payload / mass)
    bounds += [p[k] for k, name in enumerate(names) if name[0] == "f"]
    problem = {"x": casadi.vertcat(p, *extra), "f": objective, "g": casadi.vertcat(*bounds)}
    start = np.concatenate([np.maximum(theta / scale, 0.1), np.tile([0.2, 0.1], len(extra))])
    options = {"ipopt.tol": 1e-8}
    found, stats = minimized("bodies", problem, options, x0=start, lbg=LEAST, ubg=np.inf)
    if not stats["success"]:
        raise ArithmeticError(
            f"no bodies with these parameters were found: {stats['return_status']}"
        )
    return np.array(found["x"]).ravel()[: len(names)] * scale
