"""Gives the exercises of the lab's functions their derivations, the slips in them, and what they
build on.
"""

from __future__ import annotations

from dataclasses import replace

from ...models.robots import Robot
from ..columns import Array, Columns, inverse, times
from ..exercise import Exercise, Follow, Slip
from .common import Kind
from .dynamics import dynamic_model
from .end_slips import DKM2_ENDS, DKM_ENDS, IKM2_ENDS, IKM_ENDS, dynamic_slips
from .geometry_steps import dgm_slips, dgm_steps
from .leg_steps import igm_slips, igm_steps, passive_steps
from .leg_steps import passive_slips as angle_slips
from .motion_slips import A_slips, B_slips, d_slips
from .motion_steps import (
    A_steps,
    B_steps,
    dkm2_steps,
    dkm_steps,
    dynamic_steps,
    ikm2_steps,
    ikm_steps,
    parts_of,
    passive_accelerations,
    passive_rates,
)
from .passive_slips import passive_slips

MATRICES = (
    Follow("compute_A_B", 4, "AB"),
    Follow("A", 4, "own_A", counts=True),
    Follow("B", 4, "own_B", counts=True),
)
MODEL = (Follow("dynamic_model", 8, "model", counts=True),)


def A_B_steps(robot: Robot, *q: Array, **steps) -> Columns:
    return parts_of(robot, *q, **steps)[:2]


def inverse_steps(robot: Robot, *row: Array, model: Columns | None = None) -> Columns:
    M, c = model or dynamic_model(robot, *row[:8])
    return tuple(times(M, *row[8:]) + c.T)


def forward_steps(robot: Robot, *row: Array, model: Columns | None = None) -> Columns:
    M, c = model or dynamic_model(robot, *row[:8])
    return times(inverse(M), *(row[8:] - c.T))


def _table(kind: Kind) -> dict[str, tuple]:
    """A function's name -> derivation, slips, what it builds on."""
    AB, d = (*A_slips(kind), *B_slips(kind)), d_slips(kind)
    often = (  # in a dynamic model it is a factor of c
        "How often does the term come out of the derivative?"
    )
    d_times = (
        Slip("d twice", often, {"of_d": lambda near, far: -2 * (near + far)}),
        Slip("half of d", often, {"of_d": lambda near, far: -(near + far) / 2}),
    )
    return {
        "dgm": (dgm_steps, dgm_slips(kind), ()),
        "igm": (igm_steps, igm_slips(kind), ()),
        "dgm_passive": (passive_steps, angle_slips(kind), (Follow("dgm", 3, "end", counts=True),)),
        "A": (A_steps, AB, ()),
        "B": (B_steps, AB, ()),
        "compute_A_B": (A_B_steps, AB, ()),
        "dkm": (dkm_steps, (*DKM_ENDS, *AB), MATRICES),
        "ikm": (ikm_steps, (*IKM_ENDS, *AB), MATRICES),
        "dkm_passive": (passive_rates, passive_slips(kind, False), ()),
        "dkm2": (dkm2_steps, (*DKM2_ENDS, *d, *d_times, *AB), MATRICES),
        "ikm2": (ikm2_steps, (*IKM2_ENDS, *d, *d_times, *AB), MATRICES),
        "dkm2_passive": (passive_accelerations, passive_slips(kind, True), ()),
        "dynamic_model": (dynamic_steps, (*dynamic_slips(kind), *d, *AB), MATRICES),
        "inverse_dynamics": (inverse_steps, (), MODEL),
        "forward_dynamics": (forward_steps, (), MODEL),
    }


def stepwise(kind: Kind, *exercises: Exercise) -> list[Exercise]:
    """The exercises with the derivations of those of the lab's functions that are among them."""
    table = _table(kind)
    found = []
    for exercise in exercises:
        derivation, slips, follows = table.get(exercise.name, (None, (), ()))
        found.append(replace(exercise, derivation=derivation, slips=slips, follows=follows))
    return found
