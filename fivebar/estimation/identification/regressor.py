"""The torque of a motion as it is linear in a robot's inertial and friction parameters: tau = W(q,
q', q'') theta.
"""

from __future__ import annotations

from dataclasses import fields, replace
from functools import cache, lru_cache

import casadi
import numpy as np

from ...models.compiled import Buffered
from ...models.dynamics import inverse_dynamics
from ...models.geometry import dgm
from ...models.kinematics import dkm, dkm2
from ...models.robots import Robot

FEW, BLOCK = 200, 2000  # rows that are evaluated at once, in short motions and in long ones


def ladder(robot: Robot) -> dict[str, tuple[str, ...]]:
    """Rungs of the robot's physics with their parameters, those in which the torque is linear, from
    below.
    """
    return _ladder(type(robot))


@cache
def _ladder(kind):
    own = tuple(f.name for f in fields(kind)[: kind.lab] if not _is_a_length(f.name))
    rungs = {
        "masses": own,
        "gravity": (),
        "viscous friction": (),
        "dry friction": (),
        "turning bars": kind.turning_names,
    }
    rungs["elbows' friction"] = ()
    for f in fields(kind)[kind.lab :]:
        if f.name == "gravity" or f.name in kind.turning_names:
            continue
        rung = (
            "gravity"
            if f.name[0] == "m"
            else "dry friction"
            if f.name[:2] == "fs"
            else "viscous friction"
        )
        rungs["elbows' friction" if len(f.name) == 4 and f.name[0] == "f" else rung] += (f.name,)
    return rungs


def _is_a_length(name):
    return name[0] == "l" or name == "d"


def linear_names(robot: Robot) -> tuple[str, ...]:
    """The parameters in which the torque is linear, rung by rung."""
    return _linear_names(type(robot))


@cache
def _linear_names(kind):
    return tuple(name for own in _ladder(kind).values() for name in own)


@lru_cache(maxsize=64)
def _function(robot, assembly, block):
    """(q, q', q'') -> W (2 x p) of so many rows: the derivative of the inverse dynamic model, exact
    as it is linear.
    """
    names = linear_names(robot)
    p = casadi.SX.sym("p", len(names))
    q, q_dot, q_ddot = (casadi.SX.sym(name, 2) for name in ("q", "q_dot", "q_ddot"))
    symbolic = replace(robot, **{name: p[k] for k, name in enumerate(names)})
    tau = inverse_dynamics(dkm2(dkm(dgm(symbolic, q, assembly), q_dot), q_ddot))
    W = casadi.densify(casadi.jacobian(tau, p))
    return casadi.Function("W", [q, q_dot, q_ddot], casadi.cse([W])).map(block)


def regressor(
    robot: Robot, q: np.ndarray, q_dot: np.ndarray, q_ddot: np.ndarray, assembly: int
) -> np.ndarray:
    """W (n, 2, p) of motions q, q_dot, q_ddot (n, 2), columns as `linear_names`; nan where the
    robot does not close.

    Of the robot, only its lengths and gravity count.
    """
    plain = replace(robot, **dict.fromkeys(linear_names(robot), 0.0))
    block = FEW if len(q) <= FEW else BLOCK
    call, W = (
        Buffered(_function(plain, int(assembly), block)),
        np.empty((len(q), 2, len(linear_names(robot)))),
    )
    for first in range(0, len(q), block):
        part = slice(first, first + block)
        count = len(q[part])
        (flat,) = call(*(np.resize(each[part], (block, 2)) for each in (q, q_dot, q_ddot)))
        W[part] = flat.reshape(block, -1, 2).swapaxes(1, 2)[:count]
    return W
