"""The exercises on the models of a robot: the right ones, and the slips that a lab expects."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import partial

import numpy as np

from ..base.backend import pairs
from ..models import geometry
from ..models.robots import Biglide, FiveBar, Robot
from .columns import Array, Columns
from .derivation import Derivation, Step
from .exercise import Exercise, Misconception

# Each function, what it returns, and that of a derivation.
_TABLE = """
dgm(q11, q21, assembly_mode) -> x, y: tip
igm(x, y, gamma1, gamma2) -> q11, q21: active
dgm_passive(q11, q21, assembly_mode) -> q12, q22: relative
A(JOINTS) -> A: A
B(JOINTS) -> B: B
dkm(JOINTS, q11D, q21D) -> xD, yD: xi_dot_found
ikm(JOINTS, xD, yD) -> q11D, q21D: rates_found
dkm_passive(JOINTS, q11D, q21D, xD, yD) -> q12D, q22D: passive_found
dkm2(JOINTS, RATES, q11DD, q21DD) -> xDD, yDD: xi_ddot_found
ikm2(JOINTS, RATES, xDD, yDD) -> q11DD, q21DD: accelerations_found
dkm2_passive(JOINTS, RATES, q11DD, q21DD, xDD, yDD) -> q12DD, q22DD: passive_found
dynamic_model(JOINTS, RATES) -> M, c: M c
inverse_dynamics(JOINTS, RATES, q11DD, q21DD) -> tau1, tau2: tau_found
forward_dynamics(JOINTS, RATES, tau1, tau2) -> q11DD, q21DD: free_accelerations
"""
_TABLE = _TABLE.replace("JOINTS", "q11, q12, q21, q22").replace("RATES", "q11D, q12D, q21D, q22D")


def _read(line):
    signature, parts = line.split(": ")
    name, arguments, returns = re.split(r"\(|\) -> ", signature)
    return name, (signature, arguments.split(", "), returns.split(", "), parts.split())


# Name -> its signature, arguments and returns, and the quantities of a derivation that these are.
MODELS = dict(map(_read, _TABLE.strip().splitlines()))
SHAPES: dict[str, tuple[int, ...]] = {"c": (2,)} | dict.fromkeys("ABM", (2, 2))


def _dgm(robot, q11, q21, assembly_mode):
    """Return the poses of a batch of active joints, nan where there are none."""
    modes = np.asarray(assembly_mode, int)
    return geometry.dgm(robot, np.stack([q11, q21], axis=-1), modes, "nan")


def _igm(robot, x, y, *gammas):
    """Return the active joints of a batch of positions, nan where there are none."""
    modes = np.stack(gammas, axis=-1).astype(int)
    return tuple(geometry.igm(robot, np.stack([x, y], axis=-1), modes, "nan").q.T)


# What the package answers itself, up to the limits of reach.
RIGHT = {
    "dgm": lambda robot, *row: tuple(_dgm(robot, *row).xi.T),
    "dgm_passive": lambda robot, *row: tuple(_dgm(robot, *row).q_passive.T),
    "igm": _igm,
}


def derived(name: str, steps: Mapping[str, Step], robot: Robot, *row: Array) -> Columns:
    """Return what a function of the labs gives with other steps in its derivation, as columns."""
    _, arguments, returns, parts = MODELS[name]
    s = Derivation(robot, dict(zip(arguments, row)), steps)
    found = [np.asarray(getattr(s, part)) for part in parts]
    if len(found) == len(returns):
        return tuple(np.broadcast_to(part, (len(row[0]), *part.shape[1:])) for part in found)
    points = found[0].reshape(len(row[0]), -1)
    return tuple(pairs(points)[:, 0].T) if np.iscomplexobj(points) else tuple(points.T)


def exercises_on(
    kind: type[FiveBar] | type[Biglide],
    *names: str,
    slips: Mapping[str, tuple[str, Mapping[str, Step]]] = {},
) -> list[Exercise]:
    """Return the exercises on these models of a robot.

    Parameters
    ----------
    kind
        The class of the robot: `FiveBar` or `Biglide`.
    *names
        Functions, such as "dgm" or "dkm2".
    slips
        Name -> its hint, and other steps of `fivebar.grading.derivation`, as a lab's
        students may take them.

    Examples
    --------
    >>> import fivebar as fb
    >>> from fivebar.grading.models import exercises_on
    >>> exercises_on(fb.FiveBar, "dgm")[0].arguments
    ('q11', 'q21', 'assembly_mode')
    """
    exercises = []
    for name in names:
        signature, _, returns, _ = MODELS[name]
        turning = name == "dgm_passive" or (name == "igm" and kind.turns)
        exercises.append(
            Exercise(
                signature,
                RIGHT.get(name, partial(derived, name, {})),
                tuple(
                    Misconception(slip, hint, partial(derived, name, steps))
                    for slip, (hint, steps) in slips.items()
                ),
                angles=tuple(returns) if turning else (),
                shapes={key: SHAPES[key] for key in returns if key in SHAPES},
            )
        )
    return exercises
