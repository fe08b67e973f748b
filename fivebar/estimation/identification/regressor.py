"""The regressor W of a robot: tau = W(q, q', q'') theta, linear in its masses and friction."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import casadi
import numpy as np
from numpy import ndarray

from ...models.compiled import Buffered
from ...models.dynamics import inverse_dynamics
from ...models.geometry import dgm
from ...models.kinematics import dkm, dkm2
from ...models.robots import Biglide, FiveBar, Robot

FEW, BLOCK = (200, 2000)  # rows that are evaluated at once, in short motions and in long ones


LADDER = {
    FiveBar: {
        "masses": ("zz1", "zz2", "m"),
        "gravity": ("mx11", "my11", "mx21", "my21"),
        "viscous friction": ("fv1", "fv2"),
        "dry friction": ("fs1", "fs2"),
        "turning bars": FiveBar.turning_names,
        "elbows' friction": ("fv12", "fv22"),
    },
    Biglide: {
        "masses": ("mf1", "mf2", "m"),
        "viscous friction": ("fv1", "fv2"),
        "dry friction": ("fs1", "fs2"),
        "turning bars": Biglide.turning_names,
    },
}


def ladder(robot: Robot) -> dict[str, tuple[str, ...]]:
    """Return the parameters in which the torque is linear, by kind of physics."""
    return LADDER[type(robot)]


def linear_names(robot: Robot) -> tuple[str, ...]:
    """Return the parameters in which the torque is linear, in the order of the ladder."""
    return sum(ladder(robot).values(), ())


@lru_cache(maxsize=64)
def _function(robot, assembly, block):
    """Return the function (q, q', q'') -> W (2, p) of `block` rows."""
    names = linear_names(robot)
    p = casadi.SX.sym("p", len(names))
    q, q_dot, q_ddot = (casadi.SX.sym(name, 2) for name in ("q", "q_dot", "q_ddot"))
    symbolic = replace(robot, **{name: p[k] for k, name in enumerate(names)})
    tau = inverse_dynamics(dkm2(dkm(dgm(symbolic, q, assembly), q_dot), q_ddot))
    W = casadi.densify(casadi.jacobian(tau, p))
    return casadi.Function("W", [q, q_dot, q_ddot], casadi.cse([W])).map(block)


def regressor(robot: Robot, q: ndarray, q_dot: ndarray, q_ddot: ndarray, assembly: int) -> ndarray:
    """Return W (n, 2, p) of motions (n, 2), columns as `linear_names`; nan where nothing closes.

    Of the robot, only lengths and gravity count.
    """
    names = linear_names(robot)
    plain = replace(robot, **dict.fromkeys(names, 0.0))
    block = FEW if len(q) <= FEW else BLOCK
    call = Buffered(_function(plain, int(assembly), block))
    W = np.empty((len(q), 2, len(names)))
    for first in range(0, len(q), block):
        part = slice(first, first + block)
        # The last block is filled up.
        motion = [np.resize(values[part], (block, 2)) for values in (q, q_dot, q_ddot)]
        (flat,) = call(*motion)
        W[part] = flat.reshape(block, -1, 2).swapaxes(1, 2)[: len(q[part])]
    return W
