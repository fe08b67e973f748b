"""What goes wrong in the steps of the passive joints' rates and accelerations."""

from __future__ import annotations

from ..exercise import Slip
from .geometry_steps import each_leg
from .motion_slips import angle_slips
from .motion_steps import dot, elbow_centripetal, elbow_velocity
from .right import Kind


def passive_slips(kind: Kind, accelerations: bool) -> tuple[Slip, ...]:
    """Of dkm_passive, or of dkm2_passive."""
    word, unit_ = ("acceleration", "m/s²") if accelerations else ("rate", "m/s")
    pivot = kind.words.pivots
    away = (
        f"The end moves with the {pivot} and turns about it. Did you take the share of the {pivot}"
        " away?"
    )
    length = f"{unit_} is no unit of a passive {word}. Which length lies between?"
    slips = [
        *angle_slips(kind),
        *each_leg(
            "u instead of v for the distal bar",
            "Which way does the end of the distal bar move when only the passive joint turns?",
            v=lambda j: j.u2,
        ),
        *each_leg(
            "+90 degrees turned the other way",
            "Turn (1, 0) by +90 degrees. Is it (0, 1) or (0, -1)?",
            v=lambda j: -j.v2,
        ),
        *each_leg(
            f"share of the {pivot} forgotten", away, drag=lambda j, v: 0 * elbow_velocity(j, v)
        ),
        *each_leg(
            f"share of the {pivot} not projected",
            "Which part of it lies along v12?",
            drag=lambda j, v: j.proximal + 0 * elbow_velocity(j, v),
        ),
        Slip(
            f"share of the {pivot} added instead of subtracted",
            away,
            {"take": lambda end, drag, j: end + drag},
        ),
        Slip(
            f"share of the {pivot} not divided by the length",
            length,
            {"take": lambda end, drag, j: end - drag * j.distal},
        ),
        *each_leg("length of the bar forgotten", length, per=lambda value, j: value + 0 * j.distal),
    ]
    if kind.turns:
        turn = "Turn (1, 0) and (0, 1) by +90 degrees: where do they go?"
        solve = "The distal bar turns at q11' + q12'. Solve that for q12'."
        slips += [
            Slip(
                "+90 degrees turned the other way for both bars",
                turn,
                {"v": lambda j: -j.v2, "drag": lambda j, v: j.proximal * dot(v, -j.v1)},
            ),
            *each_leg(f"absolute {word} instead of relative", solve, own=lambda q, j: 0 * q),
            *each_leg(
                f"active {word} divided by the length, too", solve, own=lambda q, j: q / j.distal
            ),
            *each_leg(f"active {word} added instead of subtracted", solve, own=lambda q, j: -q),
        ]
    else:
        slips += each_leg(
            "foot's speed subtracted as in the five-bar",
            "A foot does not turn.",
            own=lambda q, j: q,
        )
    return (*slips, *(_pulls(kind) if accelerations else ()))


def _pulls(kind):
    """Return what becomes of the centripetal term of the proximal bar."""

    def with_own(j, v, own, passive):
        rate = own + passive if j.turns else passive
        return elbow_centripetal(j, v, own, passive) + j.distal * rate**2

    kept = Slip(
        "centripetal term of the distal bar kept",
        "You multiply by v12. What is left there of a vector along u12?",
        {"pull": with_own},
    )
    if not kind.turns:
        return (kept,)
    term = "The elbow's centripetal acceleration is -l11 q11'^2 u11. What does v12 . u11 give?"
    return (
        *each_leg("centripetal term missing", term, pull=lambda j, v, own, q: 0 * own),
        *each_leg(
            "centripetal term of the wrong sign",
            term,
            pull=lambda j, v, own, q: -elbow_centripetal(j, v, own, q),
        ),
        kept,
    )
