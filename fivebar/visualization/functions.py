"""The models as functions for pages: the equations of `models`, written out in JavaScript."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca

from ..base.backend import as_numbers
from ..models.dyads import dot
from ..models.geometry import joint_pose, task_pose
from ..models.javascript import to_javascript

if TYPE_CHECKING:
    from collections.abc import Iterable

    from ..models.geometry import Pose
    from ..models.robots import Robot


def pose_outputs(pose: Pose) -> dict[str, ca.SX]:
    """What pages show of a pose, by name; closes: 1, or 0; gap: m, by which the bars do not
    meet.
    """
    parallel = pose.det_A
    across = dot(*pose.u2)
    seen = ca.vertcat(*pose.point, *pose.sines, parallel)
    return {
        "xi": pose.xi,
        "q": pose.q,
        "elbows": pose.elbows,
        "serial": ca.vertcat(*pose.sines),
        "parallel": parallel,
        "working": pose.working,
        "assembly": pose.assembly,
        "gap": -pose.reach_margin,
        "transmission": ca.atan2(ca.fabs(parallel), ca.fabs(across)),
        "closes": ca.fabs(ca.sum1(seen)) < ca.inf,
    }


def pose_functions(robot: Robot, *more: ca.SX) -> list[ca.Function]:
    """igm (xi, its modes) and dgm (q, its mode) of what `posed` gives.

    more: further inputs, the symbols of which the robot's parameters are made.
    """
    point = ca.SX.sym("point", 2)
    modes = ca.SX.sym("modes", 2)
    mode = ca.SX.sym("mode")
    with as_numbers():
        reached = task_pose(robot, (point[0], point[1]), (modes[0], modes[1]))
        driven = joint_pose(robot, (point[0], point[1]), mode)
        found = [
            named_function("igm", pose_outputs(reached), point, modes, *more),
            named_function("dgm", pose_outputs(driven), point, mode, *more),
        ]
    return found


def named_function(name: str, outputs: dict[str, ca.SX], *inputs: ca.SX) -> ca.Function:
    """A function of symbols, whose inputs are called as they are."""
    expressions = ca.cse([ca.densify(ca.SX(value)) for value in outputs.values()])
    return ca.Function(name, inputs, expressions, [_name(each) for each in inputs], list(outputs))


def _name(symbol):
    if symbol.numel() > 1:
        return str(symbol[0]).split("_")[0]
    return str(symbol)


def script(functions: Iterable[ca.Function], flat: Iterable[str] = ()) -> str:
    """JavaScript of these functions; flat: the names of those that write into an array."""
    flat = set(flat)
    return "".join(to_javascript(each, flat=each.name() in flat) for each in functions)
