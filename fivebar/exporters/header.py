"""The robot's models and a controller as one C99 header, for a microcontroller."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Any

import casadi as ca

from ..base.backend import is_symbolic
from ..control.laws import computed_torque
from ..models.compiled import compile
from ..models.geometry import joint_pose
from ..models.instructions import WIDTH
from ..models.kinematics import dkm
from ..models.parameters import parameters_of
from ..models.physics import loads_of
from .c import PRELUDE, to_c

if TYPE_CHECKING:
    from collections.abc import Iterable

    from ..models.robots import Biglide, FiveBar

# Name -> (inputs, outputs of `compile`, what it is, whether it is about masses).
MODELS = {
    "dgm": (["q", "assembly"], ["xi"], "Direct geometric model.", False),
    "passive": (["q", "assembly"], ["q_passive"], "Coordinates of the passive joints.", False),
    "igm": (["xi", "working"], ["q"], "Inverse geometric model.", False),
    "dkm": (
        ["q", "q_dot", "assembly"],
        ["xi", "xi_dot"],
        "Direct models of position and velocity.",
        False,
    ),
    "ikm": (
        ["xi", "xi_dot", "working"],
        ["q", "q_dot"],
        "Inverse models of position and velocity.",
        False,
    ),
    "ikm2": (
        ["xi", "xi_dot", "xi_ddot", "working"],
        ["q", "q_dot", "q_ddot"],
        (
            "Inverse models to accelerations: what a controller follows, of a motion of the"
            " end-effector."
        ),
        False,
    ),
    "dynamic_model": (["q", "q_dot", "assembly"], ["M", "c"], "tau = M q_ddot + c.", True),
    "inverse_dynamics": (
        ["q", "q_dot", "q_ddot", "assembly"],
        ["tau"],
        "Efforts of the drives for a motion.",
        True,
    ),
    "forward_dynamics": (
        ["q", "q_dot", "tau", "assembly"],
        ["q_ddot"],
        "Accelerations under the drives' efforts.",
        True,
    ),
}
CONTROLLER = "computed_torque"
NAMES = *MODELS, CONTROLLER
LAW = "tau = M (q_ref_ddot + kd (q_ref_dot - q_dot) + kp (q_ref - q)) + c, kp in 1/s^2, kd in 1/s."
ABOUT = """\
/*
 * {title}
 *
 * Units: m, kg, s, {units}. All vectors are left, right or x, y:
 *   q, q_dot, q_ddot    drives' coordinates ({joints}), {unit}, {unit}/s, {unit}/s^2
 *   q_passive           {passive}, rad in (-pi, pi]
 *   xi, xi_dot, xi_ddot end-effector's position, velocity, acceleration
 *   tau                 drives' {effort}s, {effort_unit}
 *   assembly            +1 or -1: which of the two places of the end-effector; -1 has det A > 0
 *   working[2]          +1 or -1: which of the two places of each leg's {pivots}
 *
 * Every function returns 0, or 1 where there is no such pose or it is singular to rounding error:
 * results are then not numbers, but 0 of {prefix}_{controller}, which a motor might get.
 * Near a singularity they are as large as the models say: limit them. A leg stretched to the last
 * digit may count as out of reach. Results must not overlap inputs. C99; no memory is taken.
{friction} * A compiler that contracts a * b + c (not gcc -std=c99; -ffp-contract=off) changes
 * last digits.
 */
"""
COULOMB = """\
 * Coulomb friction is fs sign(q_dot), 0 of a drive that stands; of
 * {prefix}_{controller} it is fs sign(q_ref_dot).
"""


def header(robot: FiveBar | Biglide, name: str, functions: Iterable[str] | None = None) -> str:
    """Return the robot's models as C; functions: which of NAMES (None: all that a robot of its
    masses has).

    name: what the names of all begin with.
    """
    prefix, words, physics = name, robot.words, loads_of(robot)
    if any(map(is_symbolic, parameters_of(robot))):
        raise ValueError(
            "C is made of a robot's numbers: this one has CasADi symbols as parameters"
        )
    wanted = (
        [n for n in NAMES if _is_of(robot, physics, n)] if functions is None else list(functions)
    )
    if unknown := [name for name in wanted if name not in NAMES]:
        raise ValueError(f"no function {unknown[0]!r}; the known ones are {', '.join(NAMES)}")
    if not wanted:
        raise ValueError(f"functions must name at least one of {', '.join(NAMES)}")
    parameters = ", ".join(f"{key}={value!r}" for key, value in robot.parameters.items())
    title = textwrap.wrap(f"{words.title.capitalize()}, by fivebar: {parameters}.", WIDTH - 3)
    about = ABOUT.format(
        title="\n * ".join(title),
        units="rad" if words.unit == "rad" else "N, rad",
        unit=words.unit,
        joints=", ".join(words.joints),
        passive=", ".join(words.passive),
        effort=words.effort,
        effort_unit=words.effort_unit,
        pivots=words.pivots,
        prefix=prefix,
        controller=CONTROLLER,
        friction=COULOMB.format(prefix=prefix, controller=CONTROLLER) if physics.sticks else "",
    )
    guard = f"{prefix.upper()}_H"
    parts = [_function(robot, name, prefix) for name in dict.fromkeys(wanted)]
    return "\n".join(
        [
            about + f"#ifndef {guard}\n#define {guard}\n\n{PRELUDE}",
            *parts,
            f"#endif /* {guard} */\n",
        ]
    )


def _is_of(robot, physics, name):
    """Return whether there is anything in this function for a robot of these masses."""
    if name == "forward_dynamics":
        return physics.heavy or all(robot.inertias)
    dynamic = name == CONTROLLER or MODELS[name][3]
    return not dynamic or physics.heavy or any((robot.m, *robot.inertias))


def _function(robot, name, prefix):
    if name == CONTROLLER:
        return to_c(controller(robot), f"{prefix}_{name}", f"Computed torque: {LAW}", safe=True)
    inputs, outputs, about, _ = MODELS[name]
    return to_c(compile(robot, inputs, outputs), f"{prefix}_{name}", about)


def controller(robot: FiveBar | Biglide) -> ca.Function:
    """`ComputedTorque.law` of (q, q_dot, q_ref, q_ref_dot, q_ref_ddot, kp, kd, assembly), gains one
    per joint.
    """
    names = "q", "q_dot", "q_ref", "q_ref_dot", "q_ref_ddot", "kp", "kd"
    q, q_dot, *others = [ca.SX.sym(name, 2) for name in names]
    assembly = ca.SX.sym("assembly")
    rates = dkm(joint_pose(robot, (q[0], q[1]), assembly), q_dot)
    tau: Any = ca.cse([computed_torque(rates, *others)])
    return ca.Function(
        CONTROLLER, [q, q_dot, *others, assembly], tau, [*names, "assembly"], ["tau"]
    )
