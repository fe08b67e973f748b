"""The torque of a motion as it is linear in a robot's inertial and friction parameters: tau = W(q, q', q'') theta."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import lru_cache

import casadi
import numpy as np

from ..models.compiled import Buffered
from ..models.dynamics import inverse_dynamics
from ..models.geometry import dgm
from ..models.kinematics import dkm, dkm2
from ..models.robots import Robot

FEW, BLOCK = 200, 2000  # rows that are evaluated at once, in short motions and in long ones


def lengths_of(robot: Robot) -> tuple[str, ...]:
    """Names of what is no load: bars and base."""
    return tuple(f.name for f in fields(robot) if f.name[0] == "l" or f.name == "d")


def ladder(robot: Robot) -> dict[str, tuple[str, ...]]:
    """Rungs of the robot's physics with their parameters, those in which the torque is linear, from below."""
    names = [f.name for f in fields(robot) if f.name not in (*lengths_of(robot), "gravity")]
    own = [f.name for f in fields(robot)[: robot.lab] if f.name in names]
    turning = list(robot.turning_names)
    rungs = {"masses": own, "gravity": [], "viscous friction": [], "dry friction": [], "turning bars": turning}
    rungs["elbows' friction"] = []
    for name in names:
        if name in own or name in turning:
            continue
        if name[0] == "m":
            rungs["gravity"].append(name)
        elif name[:2] == "fs":
            rungs["dry friction"].append(name)
        else:
            rungs["elbows' friction" if len(name) == 4 else "viscous friction"].append(name)
    return {rung: tuple(own) for rung, own in rungs.items()}


def linear_names(robot: Robot) -> tuple[str, ...]:
    """The parameters in which the torque is linear, rung by rung."""
    return tuple(name for own in ladder(robot).values() for name in own)


@lru_cache(maxsize=64)
def _function(robot, assembly, block):
    """(q, q', q'') -> W (2 x p) of so many rows, exact: the derivative of the inverse dynamic model, which is linear."""
    names = linear_names(robot)
    p = casadi.SX.sym("p", len(names))
    q, q_dot, q_ddot = (casadi.SX.sym(name, 2) for name in ("q", "q_dot", "q_ddot"))
    symbolic = replace(robot, **{name: p[k] for k, name in enumerate(names)})
    tau = inverse_dynamics(dkm2(dkm(dgm(symbolic, q, assembly), q_dot), q_ddot))
    W = casadi.densify(casadi.jacobian(tau, p))
    return casadi.Function("W", [q, q_dot, q_ddot], casadi.cse([W])).map(block)


def regressor(robot: Robot, q: np.ndarray, q_dot: np.ndarray, q_ddot: np.ndarray, assembly: int) -> np.ndarray:
    """W (n, 2, p) of motions q, q_dot, q_ddot (n, 2), columns as `linear_names`; nan where the robot does not close.

    Of the robot, only its lengths and gravity count.
    """
    plain = replace(robot, **dict.fromkeys(linear_names(robot), 0.0))
    block = FEW if len(q) <= FEW else BLOCK
    call, W = Buffered(_function(plain, int(assembly), block)), np.empty((len(q), 2, len(linear_names(robot))))
    for first in range(0, len(q), block):
        part = slice(first, first + block)
        count = len(q[part])
        (flat,) = call(*(np.resize(each[part], (block, 2)) for each in (q, q_dot, q_ddot)))
        W[part] = flat.reshape(block, -1, 2).swapaxes(1, 2)[:count]
    return W
