"""Slips that the textbooks and the labs' papers warn of, each as another step of a derivation.

Only such are here as change a derivation in more than one place of a usual program, or are best
called by a name of their own: what one change undoes is found, and called by what it changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from .derivation import Step, dot, inverse, product, right, solved, turned

BOTH, FIVE_BAR, BIGLIDE = "both", "five-bar", "biglide"
ORIGIN = "Write down the x of both {base}s. Where is the origin of the frame?"
LENGTH = "This robot has bars of several lengths. Which of them is it here?"
UNITS = "Write the unit of each term beside it: all terms of a sum have the same."
SIDES = "Which lengths does your function read when it computes the other leg?"
MODE = "Does your answer change with the assembly mode?"
GAMMA = "gamma1 belongs to the left leg, gamma2 to the right one. Change one alone: what changes?"
ATAN = "Some of your angles are off by half a turn. What does y / x forget?"
TURN = "The distal bar's direction is q11 + q12. Solve that for q12."
ROW = "Each scalar product with xi' is one row of A xi' = B q'."
SOLVE = "Solve A xi' = B q' for what you look for: which matrix is on the other side?"
SOLVE_2 = "A xi'' = B q'' + d: solve it for what you look for."
SPEED = "Let the motors run at constant speed: is the end-effector's acceleration 0?"
RATE = "How fast does the distal bar turn against the fixed frame?"
AWAY = "The end moves with the {pivots} and turns about it. Did you take that share away?"
ROOT = "Can the bars really meet there? Measure them in the pose that you return."
ENERGY = "xi' = J q'. Write the kinetic energy with q'."
POWER = "m (A^-1 d) is a force. Which efforts is it worth?"


@dataclass(frozen=True)
class Slip:
    """A wrong step with its name and hint; legs: whether it may be made in one leg alone; robots:
    of which it is known.
    """

    name: str
    hint: str
    steps: Mapping[str, Step]
    legs: bool = False
    robots: str = BOTH

    def variants(self) -> list[tuple[str, Mapping[str, Step]]]:
        """Return the names and the steps of the slip: in both legs, and in either one."""
        found = [(self.name, self.steps)]
        for leg, side in enumerate(("left", "right") if self.legs else ()):
            steps = {name: _in_leg(name, step, leg) for name, step in self.steps.items()}
            found.append((f"{self.name}, in the {side} leg", steps))
        return found


def _in_leg(name, step, leg):
    """Return a step that is wrong in one leg alone."""

    def of_one(s):
        wrong, good = step(s), right(name, s)
        if callable(wrong):
            return lambda z: _joined(wrong(z), good(z), leg)
        return _joined(wrong, good, leg)

    return of_one


def _joined(wrong, good, leg):
    wrong, good = np.broadcast_arrays(wrong, good)
    own = np.arange(2) == leg
    return np.where(own if good.ndim < 3 else own[:, None], wrong, good)


def _c_with_J(s):
    return s.robot.m * product(s.J, solved(s.A, s.d))


def _inertia(s):
    return np.trace(right("Z", s))


def _leg_bar(s):
    return s.proximal if s.turns else s.distal


def _lengths(**names):
    """Return the step that takes some of the robot's numbers for others."""

    def robot(s):
        return replace(s.robot, **{new: getattr(s.robot, old) for new, old in names.items()})

    return {"robot": robot}


def _height_by_x(s):
    along_x = np.abs((s.a * s.line).real / np.abs(s.line))
    return np.sqrt(s.distal[1] ** 2 - along_x**2) * s.a / along_x


def _as_one_body(s):
    bars = s.proximal[0] * s.v1[:, 0] + s.distal[0] * s.v2[:, 0]
    return s.rates[:, :1] * bars


def _arctan(z):
    return np.arctan(z.imag / z.real)


def _base(factor):
    return {"base": lambda s: factor * right("base", s)}


SLIPS = (
    # M and c
    Slip("c forgotten", SPEED, {"c": lambda s: 0 * s.d}),
    Slip("c of the wrong sign", "tau = M q'' + c.", {"c": lambda s: -right("c", s)}),
    Slip("only the diagonal of M", ENERGY, {"M": lambda s: right("M", s) * np.eye(2)}),
    Slip("only the inertias in M", ENERGY, {"M": lambda s: s.Z + 0 * s.J}),
    Slip("c without J^T A^-1", POWER, {"c": lambda s: s.robot.m * s.d}),
    Slip("c without J^T", POWER, {"c": lambda s: s.robot.m * solved(s.A, s.d)}),
    Slip("c with J instead of its transpose", POWER, {"c": _c_with_J}),
    Slip(
        "J J^T instead of J^T J in M", ENERGY, {"M": lambda s: s.Z + s.robot.m * s.J @ turned(s.J)}
    ),
    Slip(
        "J instead of its transpose",
        ENERGY,
        {"M": lambda s: s.Z + s.robot.m * s.J @ s.J, "c": _c_with_J},
    ),
    Slip("c without A^-1", POWER, {"c": lambda s: s.robot.m * product(turned(s.J), s.d)}),
    Slip("mass forgotten in M", ENERGY, {"M": lambda s: s.Z + turned(s.J) @ s.J}),
    Slip("mass forgotten in c", POWER, {"c": lambda s: right("c", s) / s.robot.m}),
    Slip("{inertias} forgotten in M", ENERGY, {"Z": lambda s: 0 * right("Z", s)}),
    Slip("both inertias on each drive", ENERGY, {"Z": lambda s: _inertia(s) * np.eye(2)}),
    Slip("both inertias added in all of M", ENERGY, {"Z": lambda s: _inertia(s) * np.ones((2, 2))}),
    Slip(
        "feet's masses moved with the end-effector",
        "Which of these masses move along x, too?",
        {
            "robot": lambda s: replace(s.robot, m=s.robot.m + _inertia(s)),
            "Z": lambda s: 0 * right("Z", s),
        },
        robots=BIGLIDE,
    ),
    # passive rates and accelerations
    Slip(
        "absolute {rate} instead of relative",
        RATE,
        {"own_turning": lambda s: 0 * s.turning},
        legs=True,
        robots=FIVE_BAR,
    ),
    Slip(
        "share of the {pivots} and rate of the proximal bar forgotten",
        AWAY,
        {"own_turning": lambda s: 0 * s.turning, "of_pivot": lambda s: 0 * s.of_tip},
        legs=True,
        robots=FIVE_BAR,
    ),
    Slip("share of the {pivots} forgotten", AWAY, {"of_pivot": lambda s: 0 * s.of_tip}, legs=True),
    Slip(
        "u instead of v for the distal bar",
        "Multiply with what is perpendicular to what shall disappear.",
        {"v2": lambda s: s.u2},
        legs=True,
    ),
    Slip(
        "passive joints taken as locked",
        "Let one motor turn alone: does the leg move as one body?",
        {"xi_dot_found": _as_one_body},
        robots=FIVE_BAR,
    ),
    Slip(
        "centripetal term missing",
        "The {pivots} turn about their {base}s. What do they do at constant speed?",
        {"pull": lambda s: 0 * right("pull", s)},
        robots=FIVE_BAR,
    ),
    Slip(
        "d not multiplied by the inverse of A",
        SOLVE_2,
        {"xi_ddot_found": lambda s: product(s.J, s.accelerations) + s.d},
    ),
    # geometry
    Slip(
        "root of an absolute value",
        ROOT,
        {
            "h": lambda s: np.sqrt(np.abs(s.distal[1] ** 2 - s.a**2)),
            "rise": lambda s: np.sqrt(np.abs(_leg_bar(s) ** 2 - s.b**2)),
        },
    ),
    Slip(
        "height 0 where the bars do not meet",
        ROOT,
        {
            "h": lambda s: np.sqrt(np.maximum(s.distal[1] ** 2 - s.a**2, 0)),
            "rise": lambda s: np.sqrt(np.maximum(_leg_bar(s) ** 2 - s.b**2, 0)),
        },
    ),
    Slip("other assembly mode", MODE, {"mode": lambda s: -right("mode", s)}),
    Slip("assembly mode never used", MODE, {"mode": lambda s: -1}),
    Slip(
        "stops at H", "How far is your point from either of the {pivots}?", {"h": lambda s: 0 * s.a}
    ),
    Slip(
        "distance of H along x only",
        "How long is a vector that has an x and a y?",
        {"h": _height_by_x},
    ),
    Slip(
        "H taken in the middle, as with equal bars",
        "Which triangle has H in the middle?",
        {"a": lambda s: np.abs(s.line) / 2},
    ),
    Slip("origin in the left {base}", ORIGIN, {"base": lambda s: right("base", s) + s.robot.d / 2}),
    Slip("{base} forgotten", ORIGIN, _base(0), legs=True),
    Slip("sign of the {base}'s x", ORIGIN, _base(-1), legs=True),
    Slip("d instead of d/2", "How far is one {base} from the middle?", _base(2), legs=True),
    Slip(
        "the left leg's mode, gamma1, used for both legs",
        GAMMA,
        {"gamma": lambda s: right("gamma", s)[:, [0, 0]]},
    ),
    Slip(
        "other working mode",
        "On which side of the line is the elbow when gamma = -1?",
        {"gamma": lambda s: -right("gamma", s)},
        legs=True,
    ),
    Slip(
        "direction of the end-effector instead of the elbow",
        "Your angle points from the {base} to the end-effector. Which bar does the motor turn?",
        {"elbow": lambda s: s.reach},
        robots=FIVE_BAR,
    ),
    Slip(
        "atan for atan2",
        ATAN,
        {"read_active": lambda s: _arctan, "read_bar": lambda s: _arctan},
        legs=True,
    ),
    Slip(
        "atan2 with x before y",
        "atan2 of a point on the x axis is 0. Try yours on (1, 0).",
        {
            "read_active": lambda s: lambda z: np.pi / 2 - np.angle(z),
            "read_bar": lambda s: lambda z: np.pi / 2 - np.angle(z),
        },
        legs=True,
    ),
    Slip(
        "passive angle absolute instead of relative",
        TURN,
        {"relative": lambda s: s.absolute},
        legs=True,
        robots=FIVE_BAR,
    ),
    Slip(
        "passive angle relative instead of absolute",
        "A foot slides and does not turn. From where is its bar's angle measured?",
        {"relative": lambda s: s.absolute - s.q},
        legs=True,
        robots=BIGLIDE,
    ),
    Slip(
        "active angle added instead of subtracted",
        TURN,
        {"relative": lambda s: s.absolute + s.q},
        legs=True,
        robots=FIVE_BAR,
    ),
    Slip(
        "atan for atan2 on the line to the end-effector",
        ATAN,
        {"reach": lambda s: (np.abs(right("reach", s)) * np.exp(1j * _arctan(right("reach", s))))},
        robots=FIVE_BAR,
    ),
    Slip(
        "length of the proximal bar forgotten",
        UNITS,
        {"crank": lambda s: np.exp(1j * s.q)},
        robots=FIVE_BAR,
    ),
    # A, B and J
    Slip(
        "A and B exchanged",
        SOLVE,
        {"J": lambda s: right("J_inverse", s), "J_inverse": lambda s: right("J", s)},
    ),
    Slip(
        "matrices in the wrong order",
        SOLVE,
        {"J": lambda s: s.B @ inverse(s.A), "J_inverse": lambda s: s.A @ inverse(s.B)},
    ),
    Slip(
        "passive angles taken as absolute",
        "Which angle does the distal bar make with the x axis? q12 is measured from the other bar.",
        {"phi": lambda s: s.passive},
        legs=True,
        robots=FIVE_BAR,
    ),
    Slip(
        "passive angles taken as relative",
        "q11 is in metres, q12 in radians. Which angle does the bar make with the x axis?",
        {"phi": lambda s: s.q + s.passive},
        robots=BIGLIDE,
    ),
    Slip(
        "v instead of u in A",
        "Multiply with what is perpendicular to what shall disappear.",
        {"A": lambda s: s.v2},
        legs=True,
    ),
    Slip(
        "sine and cosine exchanged in A",
        "A bar at angle 0 points along x: what does your row say?",
        {"A": lambda s: s.u2[..., ::-1]},
        legs=True,
    ),
    Slip("A transposed", ROW, {"A": lambda s: turned(s.u2)}),
    Slip(
        "lengths forgotten in B",
        "A has no unit and xi' is in m/s. Which unit must B have?",
        {"b_ii": lambda s: dot(s.u2, s.v1)},
        legs=True,
        robots=FIVE_BAR,
    ),
    Slip(
        "length of the distal bar in B",
        "Which bar carries the elbow?",
        {"b_ii": lambda s: s.distal * dot(s.u2, s.v1)},
        robots=FIVE_BAR,
    ),
    Slip(
        "u instead of v for the proximal bar in B",
        "In which direction does the {pivot} move when only its motor moves?",
        {"b_ii": lambda s: s.proximal * dot(s.u2, s.u1)},
        legs=True,
    ),
    Slip(
        "direction of the distal bar in place of the angle between the bars in B",
        "u12 . v11 depends on the angle between two bars only.",
        {"b_ii": lambda s: s.proximal * np.sin(s.phi)},
        legs=True,
        robots=FIVE_BAR,
    ),
    Slip(
        "legs exchanged in B",
        "The first row belongs to the left leg.",
        {"b_ii": lambda s: right("b_ii", s)[:, ::-1]},
    ),
    # d
    Slip("d forgotten", SPEED, {"d": lambda s: 0 * s.far}),
    Slip("q11' where q11' + q12' belongs", RATE, {"rate": lambda s: s.rates}, legs=True),
    Slip(
        "q12' where q11' + q12' belongs",
        RATE,
        {"rate": lambda s: s.passive_rates},
        legs=True,
        robots=FIVE_BAR,
    ),
    Slip(
        "sum of squares instead of square of the sum",
        "(a + b)^2 has a third term.",
        {"square": lambda s: s.rates**2 + s.passive_rates**2},
        legs=True,
        robots=FIVE_BAR,
    ),
    Slip(
        "v in place of u in the proximal centripetal term",
        "Which way does the elbow's acceleration point when q11' is constant?",
        {"near": lambda s: s.proximal * s.rates**2 * dot(s.u2, s.v1)},
        legs=True,
        robots=FIVE_BAR,
    ),
    Slip(
        "centripetal term of the distal bar kept",
        "You multiply by v12. What is left there of a vector along u12?",
        {"pull": lambda s: right("pull", s) + s.distal * s.rate**2},
    ),
    # lengths
    Slip(
        "the left leg's lengths used for both legs",
        SIDES,
        _lengths(l21="l11", l22="l12"),
        robots=FIVE_BAR,
    ),
    Slip(
        "one length for all bars",
        LENGTH,
        _lengths(l12="l11", l21="l11", l22="l11"),
        robots=FIVE_BAR,
    ),
    Slip("l12 for l22", LENGTH, _lengths(l22="l12"), robots=FIVE_BAR),
    Slip("l11 for l12 and l21 for l22", LENGTH, _lengths(l12="l11", l22="l21"), robots=FIVE_BAR),
    Slip(
        "masses of feet and end-effector exchanged",
        ENERGY,
        _lengths(mf1="m", mf2="m", m="mf1"),
        robots=BIGLIDE,
    ),
    Slip("l1 for both bars", LENGTH, _lengths(l2="l1"), robots=BIGLIDE),
)
