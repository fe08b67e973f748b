"""What goes wrong in A, B and d."""

from __future__ import annotations

import numpy as np

from ..exercise import Slip
from .geometry_steps import each_leg, in_step
from .motion_steps import crank_projection, distal_term, dot, proximal_term, turned
from .right import Kind


def angle_slips(kind: Kind) -> tuple[Slip, ...]:
    if not kind.turns:
        hint = "q11 is in metres, q12 in radians. Which angle does the bar make with the x axis?"
        wrong = lambda q: (q[0], q[0] + q[1], q[2], q[2] + q[3])  # noqa: E731
        return (Slip("passive angles taken as relative", hint, {"angles": wrong}),)
    hint = (
        "Which angle does the distal bar make with the x axis? q12 alone is measured from the"
        " proximal bar."
    )
    return in_step(
        "angles",
        (
            "passive angles taken as absolute",
            hint,
            lambda q: (q[0], q[1] - q[0], q[2], q[3] - q[2]),
        ),
        (
            "passive angles taken as absolute, in the left leg",
            hint,
            lambda q: (q[0], q[1] - q[0], q[2], q[3]),
        ),
        (
            "passive angles taken as absolute, in the right leg",
            hint,
            lambda q: (q[0], q[1], q[2], q[3] - q[2]),
        ),
    )


def A_slips(kind: Kind) -> tuple[Slip, ...]:
    row = "Each scalar product with xi' is one row of A xi'."
    u1 = "Which bar's direction makes the passive rate disappear from its leg's equation?"
    slips = [
        *each_leg(
            "v instead of u in A",
            "Multiply with what is perpendicular to what shall disappear.",
            A=lambda j: j.v2,
        ),
        *each_leg(
            "sign of the row of A",
            "Which sign does u have on either side of its leg's equation?",
            A=lambda j: -j.u2,
        )[1:],
        *each_leg(
            "sine and cosine exchanged in A",
            "A bar at angle 0 points along x: what does your row say?",
            A=lambda j: j.u2[..., ::-1],
        ),
        Slip(
            "legs exchanged in A",
            "The first row belongs to the left leg.",
            {"A": lambda j: j.u2[:, ::-1]},
        ),
        Slip(
            "rows of A as long as the distal bars",
            "Which length do the rows of A have when B is l u . v?",
            {"A": lambda j: j.u2 * j.distal[:, None]},
        ),
        Slip("A transposed", row, {"of_A": turned}),
    ]
    if kind.turns:
        slips += each_leg("proximal bars instead of distal bars in A", u1, A=lambda j: j.u1)
    return tuple(slips)


def B_slips(kind: Kind) -> tuple[Slip, ...]:
    length = "A has no unit and xi' is in m/s. Which unit must B have?"
    v1 = "In which direction does the end of the proximal bar move when only its motor turns?"
    move = "In which direction does a foot move?"
    full = "B full instead of diagonal"
    motor = "Does the left leg's equation hold the right motor's rate?"
    slips = [
        *each_leg("sign of B", v1 if kind.turns else move, b=lambda j: -crank_projection(j)),
        Slip(
            "legs exchanged in B",
            "The first row belongs to the left leg.",
            {"b": lambda j: crank_projection(j)[:, ::-1]},
        ),
        *in_step(
            "B",
            (full, motor, lambda b, j: b[..., None] * np.ones((2, 2))),
            (full, motor, lambda b, j: b[..., None, :] * np.ones((2, 2))),
        ),
        Slip(
            "B multiplied by the distal bar",
            "Which length did the vectors have that you multiplied with?",
            {"b": lambda j: crank_projection(j) * j.distal},
        ),
    ]
    if kind.turns:
        slips += [
            *each_leg("lengths forgotten in B", length, b=lambda j: dot(j.u2, j.v1)),
            *each_leg(
                "u instead of v for the proximal bar in B",
                v1,
                b=lambda j: j.proximal * dot(j.u2, j.u1),
            ),
            Slip(
                "length of the distal bar in B",
                "Which bar carries the elbow?",
                {"b": lambda j: j.distal * dot(j.u2, j.v1)},
            ),
            *each_leg(
                "direction of the distal bar in place of the angle between the bars in B",
                "u12 . v11 depends on the angle between two bars only.",
                b=lambda j: j.proximal * np.sin(j.phi),
            ),
        ]
    else:
        slips += each_leg(
            "sine and cosine exchanged in B",
            "A foot moves along y. Which component of u is it?",
            b=lambda j: j.u2[..., 0],
        )
    return (*slips, *angle_slips(kind))


def d_slips(kind: Kind) -> tuple[Slip, ...]:
    squared = "Which unit has a length times a rate? An acceleration is asked."
    sign = "The derivative of v is minus the rate times u. Which signs do the two terms get?"
    bar = "distal bar" if kind.turns else "bar"
    of_bar = f"centripetal term of the {bar}"
    slips = [
        Slip(
            "d forgotten",
            "Let the motors run at constant speed: is the end-effector's acceleration 0?",
            {"of_d": lambda near, far: 0 * far},
        ),
        Slip("d of the wrong sign", sign, {"of_d": lambda near, far: near + far}),
        *each_leg(
            f"rate of the {bar} not squared in d", squared, square=lambda rate, own, passive: rate
        ),
        *each_leg(
            f"length of the {bar} forgotten in d",
            "Which unit has rate^2?",
            far=lambda j, square: square + 0 * j.distal,
        ),
        *each_leg(
            f"{of_bar} missing", "What does u12 . u12 give?", far=lambda j, square: 0 * square
        ),
        *each_leg(
            f"{of_bar} of the wrong sign", sign, far=lambda j, square: -distal_term(j, square)
        ),
    ]
    if not kind.turns:
        one = "q11' is in m/s, q12' in rad/s. How fast does the bar turn against the fixed frame?"
        turning = in_step(
            "turning",
            (
                "sum of both rates as in the five-bar",
                one,
                lambda own, passive, turns: own + passive,
            ),
            ("foot's speed in place of the bar's rate", one, lambda own, passive, turns: own),
        )
        return (*slips, *turning)
    fixed = "How fast does the distal bar turn against the fixed frame?"
    of_elbow = "centripetal term of the proximal bar"
    slips += [
        Slip(
            "rates not squared in d",
            squared,
            {
                "near": lambda j, rate: j.proximal * rate * dot(j.u2, j.u1),
                "square": lambda rate, own, passive: rate,
            },
        ),
        *each_leg(
            f"{of_elbow} missing",
            "Differentiate l11 q11' v11 once more.",
            near=lambda j, rate: 0 * rate,
        ),
        *each_leg(
            f"{of_elbow} of the wrong sign", sign, near=lambda j, rate: -proximal_term(j, rate)
        ),
        *each_leg(
            "proximal centripetal term not projected",
            "Which part of it lies along u12?",
            near=lambda j, rate: j.proximal * rate**2,
        ),
        *each_leg(
            "v in place of u in the proximal centripetal term",
            "Which way does the elbow's acceleration point when q11' is constant?",
            near=lambda j, rate: j.proximal * rate**2 * dot(j.u2, j.v1),
        ),
        *each_leg(
            "q12' where q11' + q12' belongs", fixed, turning=lambda own, passive, turns: passive
        ),
        *each_leg("q11' where q11' + q12' belongs", fixed, turning=lambda own, passive, turns: own),
        *each_leg(
            "sum of squares instead of square of the sum",
            "(a + b)^2 has a third term.",
            square=lambda rate, own, passive: own**2 + passive**2,
        ),
    ]
    return tuple(slips)
