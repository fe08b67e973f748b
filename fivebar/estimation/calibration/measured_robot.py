"""A five-bar as it is measured: lengths, how its angles are read, where the measuring frame lies;
exact derivatives.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...base.checks import LONGEST, SHORTEST
from ...models.dyads import RRR, cross, dot
from ...models.robots import FiveBar

LENGTHS = ("l11", "l12", "l21", "l22", "d")
READING = ("offset1", "offset2", "ratio1", "ratio2")
FRAME = ("x0", "y0", "turn", "scale")
UNKNOWNS = (*LENGTHS, *READING, *FRAME)
PLACE = {name: k for k, name in enumerate(UNKNOWNS)}
UNITS = dict.fromkeys((*LENGTHS, "x0", "y0"), "m") | dict.fromkeys(
    ("offset1", "offset2", "turn"), "rad"
)
NEUTRAL = dict.fromkeys(READING[:2], 0.0) | dict.fromkeys(READING[2:], 1.0)
NEUTRAL |= dict(x0=0.0, y0=0.0, turn=0.0, scale=1.0)


def values_of(robot: FiveBar, more: Mapping[str, float] | None = None) -> np.ndarray:
    """All of UNKNOWNS, (13,): the robot's lengths, angles read as they are, its own frame; `more`
    goes over these.
    """
    return np.array(
        [
            {**{n: getattr(robot, n) for n in LENGTHS}, **NEUTRAL, **(more or {})}[n]
            for n in UNKNOWNS
        ]
    )


def robot_with(robot: FiveBar, values: np.ndarray) -> FiveBar:
    """The robot with the lengths among the values; what it weighs stays."""
    return replace(robot, **{name: float(values[PLACE[name]]) for name in LENGTHS})


def sizes(robot: FiveBar, q: np.ndarray, names: Sequence[str] = UNKNOWNS) -> np.ndarray:
    """By how much each unknown changes a picture of the robot as much as the others: its mean bar,
    1 rad, all of q.
    """
    bar = (robot.l11 + robot.l12 + robot.l21 + robot.l22) / 4
    largest = [float(np.max(np.abs(column), initial=0.0)) or 1.0 for column in np.nan_to_num(q).T]
    known = dict(ratio1=1 / largest[0], ratio2=1 / largest[1]) | dict.fromkeys(
        (*LENGTHS, "x0", "y0"), bar
    )
    return np.array([known.get(name, 1.0) for name in names])


def length_ok(p: np.ndarray) -> bool:
    """Whether a robot can have these lengths."""
    bars = p[[*range(4), PLACE["scale"]]]  # a scale is no length, but as far from 0
    return bool((bars >= SHORTEST).all() and (bars <= LONGEST).all() and 0 <= p[4] <= LONGEST)


class Placed(NamedTuple):
    """Poses of a machine: points in the robot's frame, unit vectors."""

    xi: tuple
    cranks: tuple  # u_i1
    bars: tuple  # u_i2
    det: np.ndarray  # det A

    @property
    def sines(self) -> list[np.ndarray]:
        """Of both legs' Type 1."""
        return [cross(crank, bar) for crank, bar in zip(self.cranks, self.bars)]


def _cranks(p, q):
    """Unit vectors u_i1 and the elbows, in the robot's frame."""
    angles = (p[7 + i] * q[:, i] + p[5 + i] for i in (0, 1))
    cranks = tuple((np.cos(angle), np.sin(angle)) for angle in angles)
    pivots = tuple(
        (sign * p[4] / 2 + p[2 * i] * u[0], p[2 * i] * u[1])
        for i, sign, u in zip((0, 1), (-1, 1), cranks)
    )
    return cranks, pivots


def place(p: np.ndarray, q: np.ndarray, assembly: np.ndarray) -> Placed:
    """The machine with the values p (13,) at the readings q (n, 2), in its own frame; nan where it
    does not close, and in a Type-2 singularity.
    """
    cranks, (left, right) = _cranks(p, q)
    with np.errstate(invalid="ignore", divide="ignore"):
        dyad = RRR(
            (right[0] - left[0], right[1] - left[1]),
            p[1],
            p[3],
            -assembly,
            abs(p[4]) + abs(p[0]) + abs(p[2]),
        )
        det = np.where(dyad.sine, dyad.sine, np.nan)  # in a singularity there are no slopes
        xi = left[0] + p[1] * dyad.first[0] + 0 * det, left[1] + p[1] * dyad.first[1] + 0 * det
        return Placed(xi, cranks, (dyad.first, dyad.second), det)


def slopes(p: np.ndarray, q: np.ndarray, at: Placed) -> np.ndarray:
    """d xi / d UNKNOWNS (n, 2, 13) in the robot's frame: A d xi = u_i2 . dP_i + d l_i2, the bars'
    lengths derived.
    """
    found = np.zeros((len(q), 2, len(UNKNOWNS)))
    (u12, u22), cranks = at.bars, at.cranks
    # Columns of A^-1, A = [u_12'; u_22'].
    with np.errstate(invalid="ignore", divide="ignore"):
        inverse = np.array([[u22[1], -u22[0]], [-u12[1], u12[0]]]) / at.det
    for i, (u, crank, sign) in enumerate(zip((u12, u22), cranks, (-1, 1))):
        across = p[2 * i] * cross(crank, u)  # u_i2 . dP_i / d theta_i, B's entry
        own = {
            2 * i: dot(u, crank),
            2 * i + 1: 1.0,
            4: sign / 2 * u[0],
            5 + i: across,
            7 + i: across * q[:, i],
        }
        for column, along in own.items():
            found[:, :, column] += (inverse[i] * along).T
    return found


def frame(p: np.ndarray, xi: tuple) -> np.ndarray:
    """Where points of the robot's frame appear in the measuring one (n, 2): (x0, y0) + scale
    R(turn) xi.
    """
    c, s = p[12] * np.cos(p[11]), p[12] * np.sin(p[11])
    return np.stack([p[9] + c * xi[0] - s * xi[1], p[10] + s * xi[0] + c * xi[1]], axis=-1)


def unframe(p: np.ndarray, points: np.ndarray) -> tuple:
    """The inverse of `frame`, on components."""
    x, y = points[..., 0] - p[9], points[..., 1] - p[10]
    c, s = np.cos(p[11]) / p[12], np.sin(p[11]) / p[12]
    return c * x + s * y, c * y - s * x


def seen(p: np.ndarray, q: np.ndarray, assembly: np.ndarray, derive: bool = True) -> tuple:
    """Points in the measuring frame (n, 2), and their derivatives by all UNKNOWNS (n, 2, 13), None
    if not asked for.
    """
    at = place(p, q, assembly)
    points = frame(p, at.xi)
    if not derive:
        return points, None
    inner = slopes(p, q, at)
    c, s = p[12] * np.cos(p[11]), p[12] * np.sin(p[11])
    outer = np.stack([c * inner[:, 0] - s * inner[:, 1], s * inner[:, 0] + c * inner[:, 1]], axis=1)
    outer[:, 0, 9] = outer[:, 1, 10] = 1.0
    away = points - p[9:11]
    outer[:, 0, 11], outer[:, 1, 11] = -away[:, 1], away[:, 0]
    outer[:, :, 12] = away / p[12]
    return points, outer


def bars_off(p: np.ndarray, q: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """By how much each leg misses the measured points, scale (|xi - P_i| - l_i2) (n, 2), and its
    slopes (n, 2, 13).

    In the metres that were measured: a robot which shrinks as its picture grows misses by as much.

    It needs no mode, and there is nothing that it cannot reach: where a calibration begins, and
    where mistakes are looked for.
    """
    cranks, pivots = _cranks(p, q)
    x, y = unframe(p, points)
    off, derived = np.empty(q.shape), np.zeros((*q.shape, len(UNKNOWNS)))
    c, s = np.cos(p[11]) / p[12], np.sin(p[11]) / p[12]
    for i, (crank, pivot, sign) in enumerate(zip(cranks, pivots, (-1, 1))):
        bar = x - pivot[0], y - pivot[1]
        length = np.hypot(*bar)
        off[:, i] = length - p[2 * i + 1]
        u = bar[0] / np.where(length, length, 1.0), bar[1] / np.where(length, length, 1.0)
        own = derived[:, i]
        across = p[2 * i] * cross(crank, u)
        own[:, 2 * i], own[:, 2 * i + 1], own[:, 4] = -dot(u, crank), -1.0, -sign / 2 * u[0]
        own[:, 5 + i], own[:, 7 + i] = -across, -across * q[:, i]
        own[:, 9], own[:, 10] = -(c * u[0] - s * u[1]), -(s * u[0] + c * u[1])
        own[:, 11], own[:, 12] = u[0] * y - u[1] * x, -dot(u, (x, y)) / p[12]
    derived *= p[12]
    derived[:, :, 12] += off
    return p[12] * off, derived


def sines_at(p: np.ndarray, q: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Sines (n, 3) of both legs' Type 1 and of Type 2 with the bars drawn to measured points: minus
    their signs are the working modes and the assembly mode.
    """
    cranks, pivots = _cranks(p, q)
    x, y = unframe(p, points)
    bars = [(x - pivot[0], y - pivot[1]) for pivot in pivots]
    units = [(b[0] / np.hypot(*b), b[1] / np.hypot(*b)) for b in bars]
    return np.stack([*(cross(c, u) for c, u in zip(cranks, units)), cross(*units)], axis=-1)
