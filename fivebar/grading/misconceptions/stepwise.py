"""The labs' exercises on the models: the right one, its derivation and the slips in it."""

from __future__ import annotations

from ..exercise import Exercise, Misconception
from . import right
from .end_slips import DKM2_ENDS, DKM_ENDS, IKM2_ENDS, IKM_ENDS, LOCKED, MISUSED, dynamic_slips
from .geometry_steps import dgm_slips, dgm_steps, lengths_changed
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
    passive_motion,
)
from .passive_slips import passive_slips
from .right import Kind

FOUR, RATES = "q11, q12, q21, q22", "q11D, q12D, q21D, q22D"
SIGNATURES = {
    "dgm": "q11, q21, assembly_mode) -> x, y",
    "igm": "x, y, gamma1, gamma2) -> q11, q21",
    "dgm_passive": "q11, q21, assembly_mode) -> q12, q22",
    "A": f"{FOUR}) -> A",
    "B": f"{FOUR}) -> B",
    "compute_A_B": f"{FOUR}) -> A, B",
    "B_A": f"{FOUR}) -> B, A",
    "jacobian": f"{FOUR}) -> J",
    "velocity_terms": f"{FOUR}, {RATES}) -> d",
    "elbows": "q11, q21) -> x1, y1, x2, y2",
    "left_elbow": "q11) -> x1, y1",
    "right_elbow": "q21) -> x2, y2",
    "dkm": f"{FOUR}, q11D, q21D) -> xD, yD",
    "ikm": f"{FOUR}, xD, yD) -> q11D, q21D",
    "dkm_passive": f"{FOUR}, q11D, q21D, xD, yD) -> q12D, q22D",
    "dkm2": f"{FOUR}, {RATES}, q11DD, q21DD) -> xDD, yDD",
    "ikm2": f"{FOUR}, {RATES}, xDD, yDD) -> q11DD, q21DD",
    "dkm2_passive": f"{FOUR}, {RATES}, q11DD, q21DD, xDD, yDD) -> q12DD, q22DD",
    "dynamic_model": f"{FOUR}, {RATES}) -> M, c",
    "inverse_dynamics": f"{FOUR}, {RATES}, q11DD, q21DD) -> tau1, tau2",
    "forward_dynamics": f"{FOUR}, {RATES}, tau1, tau2) -> q11DD, q21DD",
}
SHAPES: dict[str, tuple[int, ...]] = {
    "c": (2,),
    "d": (2,),
    "A": (2, 2),
    "B": (2, 2),
    "J": (2, 2),
    "M": (2, 2),
}
HELPERS = (
    "A",
    "B",
    "compute_A_B",
    "B_A",
    "jacobian",
    "velocity_terms",
    "elbows",
    "left_elbow",
    "right_elbow",
)


def _table(kind: Kind) -> dict[str, tuple]:
    """Return of each function its derivation, and the slips in it."""
    AB, d = (*B_slips(kind), *A_slips(kind)), d_slips(kind)
    second = (*d, *AB, *(() if kind.turns else lengths_changed(kind)))
    return {
        "dgm": (dgm_steps, dgm_slips(kind)),
        "igm": (igm_steps, igm_slips(kind)),
        "dgm_passive": (passive_steps, angle_slips(kind)),
        "A": (A_steps, AB),
        "B": (B_steps, AB),
        "dkm": (dkm_steps, (*DKM_ENDS, *AB)),
        "ikm": (ikm_steps, (*IKM_ENDS, *AB)),
        "dkm_passive": (passive_motion, passive_slips(kind, False)),
        "dkm2": (dkm2_steps, (*DKM2_ENDS, *second)),
        "ikm2": (ikm2_steps, (*IKM2_ENDS, *second)),
        "dkm2_passive": (passive_motion, passive_slips(kind, True)),
        "dynamic_model": (dynamic_steps, (*dynamic_slips(kind), *d, *AB)),
    }


def exercises_on(kind: Kind, *names: str, **wrong: tuple[Misconception, ...]) -> list[Exercise]:
    """Return the exercises on these models of a robot.

    Parameters
    ----------
    kind
        The class of the robot: `FiveBar` or `Biglide`.
    *names
        Functions, such as "dgm" or "dkm2".
    **wrong
        By a function's name: misconceptions beside the slips in its derivation.

    Examples
    --------
    >>> import fivebar as fb
    >>> from fivebar.grading.misconceptions.stepwise import exercises_on
    >>> exercises_on(fb.FiveBar, "dgm")[0].arguments
    ('q11', 'q21', 'assembly_mode')
    """
    table, exercises = _table(kind), []
    known = MISUSED | {"dkm": (LOCKED,)} if kind.turns else {}
    for name in names:
        derivation, slips = table.get(name, (None, ()))
        returns = SIGNATURES[name].split(" -> ")[1].split(", ")
        turning = name == "dgm_passive" or name == "igm" and kind.turns
        exercises.append(
            Exercise(
                f"{name}({SIGNATURES[name]}",
                getattr(right, name),
                wrong.get(name, known.get(name, ())),
                angles=tuple(returns) if turning else (),
                shapes={key: SHAPES[key] for key in returns if key in SHAPES},
                derivation=derivation,
                slips=slips,
            )
        )
    return exercises
