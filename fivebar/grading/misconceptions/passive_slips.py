"""What goes wrong in the steps of the passive joints' rates and accelerations."""

from __future__ import annotations

from ..columns import QUARTER
from ..exercise import Slip
from .motion_slips import angle_slips
from .motion_steps import dot, in_legs, passive_motion, per_leg, unit, usual
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
            (
                "sine and cosine exchanged in v",
                "v12 is u12 turned by +90 degrees.",
                "v",
                lambda j: j.v2[..., ::-1],
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
        Slip("the other sign of both", away, {"take": lambda end, drag, j: drag - end}),
        Slip(
            f"share of the {pivot} not divided by the length",
            length,
            {"take": lambda end, drag, j: end - drag * j.distal},
        ),
        Slip(
            "velocity of the end-effector not divided by the length",
            length,
            {"take": lambda end, drag, j: end * j.distal - drag},
        ),
        *in_legs(
            passive_motion,
            ("length of the bar forgotten", length, "per", lambda value, j: value + 0 * j.distal),
            (
                "multiplied by the length instead of divided",
                length,
                "per",
                lambda value, j: value * j.distal,
            ),
        ),
    ]
    if kind.turns:
        turn = "Turn (1, 0) and (0, 1) by +90 degrees: where do they go?"
        slips += [
            Slip(
                "minus sign of both v forgotten",
                turn,
                {
                    "v": lambda j: j.v2 * [-1, 1],
                    "drag": lambda j, v: j.proximal * dot(v, j.v1 * [-1, 1]),
                },
            ),
            Slip(
                "+90 degrees turned the other way for both bars",
                turn,
                {"v": lambda j: -j.v2, "drag": lambda j, v: j.proximal * dot(v, -j.v1)},
            ),
        ]
        solve = "The distal bar turns at q11' + q12'. Solve that for q12'."
        slips += [
            *per_leg(
                "passive angle taken as absolute in v alone",
                "The distal bar's direction is q11 + q12, in v12 as well.",
                "v",
                lambda j: unit(j.passive) @ QUARTER.T,
                usual(passive_motion, "v"),
                drag=lambda j, v: drag(j, j.v2),
            ),
            *in_legs(
                passive_motion,
                (
                    "v of the proximal bar in place of the distal one's",
                    "With which vector do you multiply?",
                    "v",
                    lambda j: j.v1,
                ),
                ("length of the proximal bar forgotten", length, "drag", lambda j, v: dot(v, j.v1)),
                (
                    "u instead of v for the proximal bar",
                    "Which way does the elbow move?",
                    "drag",
                    lambda j, v: j.proximal * dot(v, j.u1),
                ),
                (
                    "divided by the length of the proximal bar",
                    "Which bar turns at the rate that you look for?",
                    "per",
                    lambda value, j: value / j.proximal,
                ),
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
        (
            "rate not squared in the centripetal term",
            lambda j, v, own, q: j.proximal * own * dot(v, j.u1),
        ),
        ("length forgotten in the centripetal term", lambda j, v, own, q: own**2 * dot(v, j.u1)),
        ("centripetal term not projected", lambda j, v, own, q: j.proximal * own**2),
    )
    each = [s for name, pull in wrong for s in per_leg(name, term, "pull", pull, usual_pull)]
    return *each, own_kept
