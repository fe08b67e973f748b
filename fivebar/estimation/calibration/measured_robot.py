"""The model of a five-bar as it is measured, with exact derivatives.

    true angle = ratio q + offset        measured point = (x0, y0) + scale R(turn) xi

The 13 values p of this model are the UNKNOWNS, in this order.
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
METRES = (*LENGTHS, "x0", "y0")
UNITS = dict.fromkeys(METRES, "m") | dict.fromkeys(("offset1", "offset2", "turn"), "rad")
NEUTRAL = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0])  # READING and FRAME


def values_of(robot: FiveBar, more: Mapping[str, float] | None = None) -> np.ndarray:
    """Return the values (13,) of a robot in its own frame, with `more` over them."""
    p = np.concatenate([[getattr(robot, name) for name in LENGTHS], NEUTRAL])
    for name, value in (more or {}).items():
        p[PLACE[name]] = value
    return p


def robot_with(robot: FiveBar, p: np.ndarray) -> FiveBar:
    """Return the robot with the lengths among the values; its masses stay."""
    return replace(robot, **{name: float(p[PLACE[name]]) for name in LENGTHS})


def sizes(robot: FiveBar, q: np.ndarray, names: Sequence[str] = UNKNOWNS) -> np.ndarray:
    """Return by how much each unknown moves a point about as far as the others.

    The mean bar for lengths, 1 rad for angles, 1 over the largest reading for ratios.
    """
    largest = np.max(np.abs(np.nan_to_num(q)), axis=0, initial=0.0)
    ratios = 1 / np.where(largest > 0, largest, 1.0)
    bar = (robot.l11 + robot.l12 + robot.l21 + robot.l22) / 4
    known = dict.fromkeys(METRES, bar) | {"ratio1": ratios[0], "ratio2": ratios[1]}
    return np.array([known.get(name, 1.0) for name in names])


def length_ok(p: np.ndarray) -> bool:
    """Return whether a robot can have these lengths; the scale is limited as a bar is."""
    bars = p[[0, 1, 2, 3, 12]]
    return bool((bars >= SHORTEST).all() and (bars <= LONGEST).all() and 0 <= p[4] <= LONGEST)


class Placed(NamedTuple):
    """Poses: points in the robot's frame, unit vectors along cranks and bars, and det A."""

    xi: tuple
    cranks: tuple
    bars: tuple
    det: np.ndarray

    @property
    def sines(self) -> list[np.ndarray]:
        """Sines of both legs' Type 1."""
        return [cross(crank, bar) for crank, bar in zip(self.cranks, self.bars)]


def _cranks(p, q):
    """Return the unit vectors along the cranks and the elbows, in the robot's frame."""
    cranks, elbows = [], []
    for leg, side in enumerate((-1, 1)):
        crank, offset, ratio = p[2 * leg], p[5 + leg], p[7 + leg]
        angle = ratio * q[:, leg] + offset
        c, s = np.cos(angle), np.sin(angle)
        cranks.append((c, s))
        elbows.append((side * p[4] / 2 + crank * c, crank * s))
    return cranks, elbows


def place(p: np.ndarray, q: np.ndarray, assembly: np.ndarray) -> Placed:
    """Return the poses at readings q (n, 2), in the robot's frame.

    They are nan where the robot does not close, and in a Type-2 singularity, where no derivative
    exists.
    """
    cranks, ((x1, y1), (x2, y2)) = _cranks(p, q)
    l11, l12, l21, l22, d = p[:5]
    size = abs(d) + abs(l11) + abs(l21)
    with np.errstate(invalid="ignore", divide="ignore"):
        dyad = RRR((x2 - x1, y2 - y1), l12, l22, -assembly, size)
        det = np.where(dyad.sine, dyad.sine, np.nan)
        c, s = dyad.first
        xi = x1 + l12 * c + 0 * det, y1 + l12 * s + 0 * det
        return Placed(xi, tuple(cranks), (dyad.first, dyad.second), det)


def _columns(leg):
    """Return the places of a leg's crank, bar, d, offset and ratio among UNKNOWNS."""
    return 2 * leg, 2 * leg + 1, 4, 5 + leg, 7 + leg


def slopes(p: np.ndarray, q: np.ndarray, at: Placed) -> np.ndarray:
    """Return d xi / d UNKNOWNS (n, 2, 13) in the robot's frame.

    A d xi = u_i2 . dP_i + d l_i2, AMORO eq. 13 with the lengths of the bars derived, too.
    """
    result = np.zeros((len(q), 2, len(UNKNOWNS)))
    (c1, s1), (c2, s2) = at.bars
    with np.errstate(invalid="ignore", divide="ignore"):
        columns_of_inverse = np.array([[s2, -c2], [-s1, c1]]) / at.det
    for leg, side in enumerate((-1, 1)):
        u, crank = at.bars[leg], at.cranks[leg]
        by_angle = p[2 * leg] * cross(crank, u)  # the entry of B
        by_ratio = by_angle * q[:, leg]
        entries = dot(u, crank), 1.0, side / 2 * u[0], by_angle, by_ratio
        for column, entry in zip(_columns(leg), entries):
            result[:, :, column] += (columns_of_inverse[leg] * entry).T
    return result


def frame(p: np.ndarray, xi: tuple) -> np.ndarray:
    """Return points of the robot's frame in the measuring one, (x0, y0) + scale R(turn) xi."""
    x0, y0, turn, scale = p[9:]
    x, y = xi
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    return np.stack([x0 + c * x - s * y, y0 + s * x + c * y], axis=-1)


def unframe(p: np.ndarray, points: np.ndarray) -> tuple:
    """Return the components of measured points in the robot's frame."""
    x0, y0, turn, scale = p[9:]
    x, y = points[..., 0] - x0, points[..., 1] - y0
    c, s = np.cos(turn) / scale, np.sin(turn) / scale
    return c * x + s * y, c * y - s * x


def seen(p: np.ndarray, q: np.ndarray, assembly: np.ndarray, derive: bool = True) -> tuple:
    """Return points in the measuring frame (n, 2) and their derivatives by UNKNOWNS (n, 2, 13).

    Without `derive` the derivatives are None.
    """
    at = place(p, q, assembly)
    points = frame(p, at.xi)
    if not derive:
        return points, None
    turn, scale = p[11:]
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    x, y = np.moveaxis(slopes(p, q, at), 1, 0)
    outer = np.stack([c * x - s * y, s * x + c * y], axis=1)
    from_origin = points - p[9:11]
    outer[:, 0, 9] = outer[:, 1, 10] = 1.0
    outer[:, 0, 11] = -from_origin[:, 1]
    outer[:, 1, 11] = from_origin[:, 0]
    outer[:, :, 12] = from_origin / scale
    return points, outer


def bars_off(p: np.ndarray, q: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return by how much each distal bar misses the measured points, and its derivatives.

    scale (|xi - P_i| - l_i2), (n, 2), measured m, and (n, 2, 13). It needs no mode, and no point is
    out of reach: so a calibration begins with it, and looks for mistakes with it. The scale keeps a
    robot that shrinks as its picture grows from missing by less.
    """
    cranks, elbows = _cranks(p, q)
    x, y = unframe(p, points)
    off, derived = np.empty(q.shape), np.zeros((*q.shape, len(UNKNOWNS)))
    turn, scale = p[11:]
    c, s = np.cos(turn) / scale, np.sin(turn) / scale
    for leg, side in enumerate((-1, 1)):
        elbow, crank = elbows[leg], cranks[leg]
        (ux, uy), length = _unit(x - elbow[0], y - elbow[1])
        off[:, leg] = length - p[2 * leg + 1]
        by_angle = -p[2 * leg] * cross(crank, (ux, uy))
        by_ratio = by_angle * q[:, leg]
        entries = -dot((ux, uy), crank), -1.0, -side / 2 * ux, by_angle, by_ratio
        for column, entry in zip(_columns(leg), entries):
            derived[:, leg, column] = entry
        derived[:, leg, 9] = -(c * ux - s * uy)
        derived[:, leg, 10] = -(s * ux + c * uy)
        derived[:, leg, 11] = ux * y - uy * x
        derived[:, leg, 12] = -dot((ux, uy), (x, y)) / scale
    derived *= scale
    derived[:, :, 12] += off
    return scale * off, derived


def _unit(x, y):
    """Return the unit vector along (x, y), and its length."""
    length = np.hypot(x, y)
    divisor = np.where(length, length, 1.0)
    return (x / divisor, y / divisor), length


def sines_at(p: np.ndarray, q: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the sines (n, 3) of both legs' Type 1 and of Type 2, bars drawn to measured points.

    Minus their signs are the working modes and the assembly mode.
    """
    cranks, elbows = _cranks(p, q)
    x, y = unframe(p, points)
    units = [_unit(x - elbow_x, y - elbow_y)[0] for elbow_x, elbow_y in elbows]
    legs = [cross(crank, unit) for crank, unit in zip(cranks, units)]
    return np.stack([*legs, cross(*units)], axis=-1)
