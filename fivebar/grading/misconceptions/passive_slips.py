"""What goes wrong in the steps of the passive joints' rates and accelerations."""

from __future__ import annotations

from ..exercise import Slip
from .motion_slips import angle_slips
from .motion_steps import dot, in_legs, passive_motion, per_leg, usual
from .right import Kind


def passive_slips(kind: Kind, accelerations: bool) -> tuple[Slip, ...]:
    """Of dkm_passive, or of dkm2_passive."""
    drag, own = usual(passive_motion, "drag"), usual(passive_motion, "own")
    word, unit_ = ("acceleration", "m/s²") if accelerations else ("rate", "m/s")
    pivot = kind.words.pivots
    away = (
        f"The end moves with the {pivot} and turns about it. Did you take the share of the {pivot}"
        " away?"
    )
    length = f"{unit_} is no unit of a passive {word}. Which length lies between?"
    slips = [
        *angle_slips(kind),
        *in_legs(
            passive_motion,
            (
                "u instead of v for the distal bar",
                "Which way does the end of the distal bar move when only the passive joint turns?",
                "v",
                lambda j: j.u2,
            ),
            (
                "+90 degrees turned the other way",
                "Turn (1, 0) by +90 degrees. Is it (0, 1) or (0, -1)?",
                "v",
                lambda j: -j.v2,
            ),
            (f"share of the {pivot} forgotten", away, "drag", lambda j, v: 0 * drag(j, v)),
            (
                f"share of the {pivot} not projected",
                "Which part of it lies along v12?",
                "drag",
                lambda j, v: j.proximal + 0 * drag(j, v),
            ),
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
        *in_legs(
            passive_motion,
            ("length of the bar forgotten", length, "per", lambda value, j: value + 0 * j.distal),
        ),
    ]
    if kind.turns:
        turn = "Turn (1, 0) and (0, 1) by +90 degrees: where do they go?"
        slips += [
            Slip(
                "+90 degrees turned the other way for both bars",
                turn,
                {"v": lambda j: -j.v2, "drag": lambda j, v: j.proximal * dot(v, -j.v1)},
            ),
        ]
        solve = "The distal bar turns at q11' + q12'. Solve that for q12'."
        slips += [
            *in_legs(
                passive_motion,
                (f"absolute {word} instead of relative", solve, "own", lambda q, j: 0 * q),
                (
                    f"active {word} divided by the length, too",
                    solve,
                    "own",
                    lambda q, j: q / j.distal,
                ),
                (f"active {word} added instead of subtracted", solve, "own", lambda q, j: -q),
            ),
        ]
    else:
        slips += per_leg(
            "foot's speed subtracted as in the five-bar",
            "A foot does not turn.",
            "own",
            lambda q, j: q,
            own,
        )
    return (*slips, *(_pulls(kind) if accelerations else ()))


def _pulls(kind):
    """Return what becomes of the centripetal term of the proximal bar."""
    usual_pull = usual(passive_motion, "pull")
    kept = "You multiply by v12. What is left there of a vector along u12?"

    def all_of(own, passive, j):
        return own + passive if j.turns else passive

    own_kept = Slip(
        "centripetal term of the distal bar kept",
        kept,
        {"pull": lambda j, v, own, q: usual_pull(j, v, own, q) + j.distal * all_of(own, q, j) ** 2},
    )
    if not kind.turns:
        return (own_kept,)
    term = "The elbow's centripetal acceleration is -l11 q11'^2 u11. What does v12 . u11 give?"
    wrong = (
        ("centripetal term missing", lambda j, v, own, q: 0 * own),
        ("centripetal term of the wrong sign", lambda j, v, own, q: -usual_pull(j, v, own, q)),
    )
    each = [s for name, pull in wrong for s in per_leg(name, term, "pull", pull, usual_pull)]
    return *each, own_kept
