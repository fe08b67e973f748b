"""The model of a five-bar as it is measured, with exact derivatives.

    true angle = ratio q + offset        measured point = (x0, y0) + scale R(turn) xi

What is measured is joint C, or a tool on a distal bar: xi = C + along u_i2 + across v_i2. The 16
values p of this model are the 15 UNKNOWNS, in this order, and the number of the tool's leg.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy import ndarray

from ...base.backend import EPS, pairs
from ...base.checks import LONGEST, SHORTEST
from ...models.dyads import RRR
from ...models.robots import FiveBar
from ...paths.machine import Machine

LENGTHS = ("l11", "l12", "l21", "l22", "d")
READING = ("offset1", "offset2", "ratio1", "ratio2")
FRAME = ("x0", "y0", "turn", "scale")
TOOL = ("along", "across")
UNKNOWNS = (*LENGTHS, *READING, *FRAME, *TOOL)
PLACE = {name: k for k, name in enumerate((*UNKNOWNS, "tool_leg"))}
METRES = (*LENGTHS, "x0", "y0", *TOOL)
UNITS = dict.fromkeys(METRES, "m") | dict.fromkeys(("offset1", "offset2", "turn"), "rad")
SHOWN = {"m": (1e3, "mm"), "rad": (180 / np.pi, "deg")}
SIDES = np.array([-1.0, 1.0])  # of the legs; also the assembly modes
NEUTRAL = np.array(
    [
        0.0,  # offset1
        0.0,  # offset2
        1.0,  # ratio1
        1.0,  # ratio2
        0.0,  # x0
        0.0,  # y0
        0.0,  # turn
        1.0,  # scale
        0.0,  # along
        0.0,  # across
        1.0,  # tool_leg
    ]
)
# Places of both legs' values in UNKNOWNS.
CRANKS = slice(0, 4, 2)
DISTAL_BARS = slice(1, 4, 2)
OFFSETS = slice(5, 7)
RATIOS = slice(7, 9)
FRAMES = slice(9, 13)
BY_BARS = np.zeros((2, len(UNKNOWNS)))  # derivatives of the distal bars
BY_BARS[[0, 1], [1, 3]] = 1.0
BY_TOOL = np.zeros(len(UNKNOWNS), complex)  # derivatives of the tool's place on its bar
BY_TOOL[-2:] = 1.0, 1j


def shown_in(name: str) -> tuple[float, str]:
    """Return the factor and the unit in which an unknown is shown."""
    return SHOWN.get(UNITS.get(name, ""), (1.0, ""))


def values_of(robot: FiveBar, more: Mapping[str, float] | None = None) -> ndarray:
    """Return the values (16,) of a robot in its own frame, with `more` over them."""
    lengths = [getattr(robot, name) for name in LENGTHS]
    p = np.concatenate([lengths, NEUTRAL])
    for name, value in (more or {}).items():
        p[PLACE[name]] = value
    return p


def mounting_of(machine: Machine) -> dict[str, float]:
    """Return the values of READING and FRAME of a machine, those that are not NEUTRAL."""
    frame = machine.frame
    values = (*machine.offset, *machine.ratio, *frame.shift, frame.turn, frame.scale)
    changed = {}
    for name, value, neutral in zip(READING + FRAME, values, NEUTRAL.tolist()):
        if value != neutral:
            changed[name] = value
    return changed


def tool_in(p: ndarray) -> tuple[Any, int]:
    """Return the tool's place on its bar, along + i across, and the place of its leg, 0 or 1."""
    return p[13] + 1j * p[14], int(np.ravel(p[15])[0]) - 1


def robot_with(robot: FiveBar, p: ndarray) -> FiveBar:
    """Return the robot with the lengths among the values; its masses stay."""
    lengths: dict[str, Any] = {name: float(p[PLACE[name]]) for name in LENGTHS}
    return replace(robot, **lengths)


def sizes(robot: FiveBar, q: ndarray, names: Sequence[str] = UNKNOWNS) -> ndarray:
    """Return by how much each unknown moves a point about as far as the others.

    The mean bar for lengths, 1 rad for angles, 1 over the largest reading for ratios.
    """
    readings = np.abs(np.nan_to_num(q))
    largest = np.max(readings, axis=0, initial=0.0)
    ratios = 1 / np.where(largest > 0, largest, 1.0)
    bar = (robot.l11 + robot.l12 + robot.l21 + robot.l22) / 4
    known = dict.fromkeys(METRES, bar) | {"ratio1": ratios[0], "ratio2": ratios[1]}
    return np.array([known.get(name, 1.0) for name in names])


def length_ok(p: ndarray) -> bool:
    """Return whether a robot can have these lengths; the scale is limited as a bar is."""
    bars = p[[0, 1, 2, 3, 12]]
    long_enough = (bars >= SHORTEST).all()
    short_enough = (bars <= LONGEST).all()
    base_ok = 0 <= p[4] <= LONGEST
    return bool(long_enough and short_enough and base_ok)


class PlacedPoses(NamedTuple):
    """Poses, in complex numbers x + i y of the robot's frame.

    xi (n,): points; cranks, bars (n, 2): unit vectors of both legs; det (n,): det A.
    """

    xi: ndarray
    cranks: ndarray
    bars: ndarray
    det: ndarray

    @property
    def sines(self) -> ndarray:
        """Sines (n, 2) of both legs' Type 1."""
        return cross(self.cranks, self.bars)


def dot(a, b):
    return (a.conj() * b).real


def cross(a, b):
    return (a.conj() * b).imag


def as_complex(points: ndarray) -> ndarray:
    """Return x + i y of points (..., 2)."""
    return points[..., 0] + 1j * points[..., 1]


def _cranks(p, q):
    """Return the unit vectors along the cranks and the elbows, complex (n, 2)."""
    angles = p[RATIOS].T * q + p[OFFSETS].T
    cranks = np.exp(1j * angles)
    half_base = p[4:5].T / 2
    bases = half_base * SIDES
    elbows = bases + p[CRANKS].T * cranks
    return cranks, elbows


def place(p: ndarray, q: ndarray, assembly: ndarray) -> PlacedPoses:
    """Return the poses at readings q (n, 2), in the robot's frame.

    They are nan where the robot does not close, and in a Type-2 singularity, where no derivative
    exists.
    """
    cranks, elbows = _cranks(p, q)
    l11, l12, l21, l22, d = p[:5]
    span = elbows[:, 1] - elbows[:, 0]
    size = abs(d) + abs(l11) + abs(l21)
    with np.errstate(invalid="ignore", divide="ignore"):
        dyad = RRR((span.real, span.imag), l12, l22, -assembly, size)
        det = np.where(dyad.sine, dyad.sine, np.nan)
        x, y = dyad.first
        left = x + 1j * y
        x, y = dyad.second
        right = x + 1j * y
        bars = np.stack([left, right], axis=1)
        on_bar = elbows[:, 0] + l12 * bars[:, 0]
        return PlacedPoses(
            on_bar + 0 * det,  # nan at Type 2
            cranks,
            bars,
            det,
        )


def _elbow_slopes(p, q, cranks):
    """Return d P / d UNKNOWNS (n, 2, 15) of both elbows, complex, in the robot's frame."""
    result = np.zeros((*q.shape, len(UNKNOWNS)), complex)
    leg = np.arange(2)
    by_angle = 1j * p[CRANKS].T * cranks
    result[:, leg, 2 * leg] = cranks
    result[:, :, 4] = SIDES / 2
    result[:, leg, 5 + leg] = by_angle
    result[:, leg, 7 + leg] = by_angle * q
    return result


def slopes(p: ndarray, q: ndarray, at: PlacedPoses) -> ndarray:
    """Return d xi / d UNKNOWNS (n, 15), complex, of what is measured, in the robot's frame.

    A d C = u_i2 . dP_i + d l_i2, AMORO eq. 13 with the lengths of the bars derived, too.
    """
    elbows = _elbow_slopes(p, q, at.cranks)
    place_on_bar, leg = tool_in(p)
    with np.errstate(invalid="ignore"):
        adjugate = at.bars[:, ::-1] * (-1j, 1j)
        columns = adjugate / at.det[:, None]  # of the inverse of A
        along_bars = dot(at.bars[:, :, None], elbows) + BY_BARS
        joint = np.einsum("nl,nlk->nk", columns, along_bars)
        bar = at.bars[:, leg, None]
        turns = cross(bar, joint - elbows[:, leg]) / p[1 + 2 * leg]
        return joint + bar * (BY_TOOL + 1j * place_on_bar * turns)


def frame(p: ndarray, xi: ndarray) -> ndarray:
    """Return points of the robot's frame in the measuring one, complex."""
    x0, y0, turn, scale = p[FRAMES]
    origin = x0 + 1j * y0
    rotation = np.exp(1j * turn)
    return origin + scale * rotation * xi


def unframe(p: ndarray, z: ndarray) -> ndarray:
    """Return points of the measuring frame in the robot's, complex."""
    x0, y0, turn, scale = p[FRAMES]
    origin = x0 + 1j * y0
    rotation_back = np.exp(-1j * turn)
    return (z - origin) * rotation_back / scale


def tip(p: ndarray, at: PlacedPoses) -> ndarray:
    """Return what is measured in the robot's frame (n,), complex: joint C, or the tool."""
    place_on_bar, leg = tool_in(p)
    return at.xi + place_on_bar * at.bars[:, leg]


def seen(p: ndarray, q: ndarray, assembly: ndarray, derive: bool = True) -> tuple:
    """Return points in the measuring frame (n, 2) and their derivatives by UNKNOWNS (n, 2, 15).

    Without `derive` the derivatives are None.
    """
    at = place(p, q, assembly)
    points = frame(p, tip(p, at))
    if not derive:
        return pairs(points), None
    x0, y0, turn, scale = p[FRAMES]
    origin = x0 + 1j * y0
    rotation = np.exp(1j * turn)
    from_origin = points - origin
    derived = scale * rotation * slopes(p, q, at)
    derived[:, 9] = 1.0
    derived[:, 10] = 1j
    derived[:, 11] = 1j * from_origin
    derived[:, 12] = from_origin / scale
    by_unknowns = np.stack([derived.real, derived.imag], axis=1)
    return pairs(points), by_unknowns


class DrawnBars(NamedTuple):
    """Distal bars as drawn to measured points, complex, in the robot's frame.

    off, bars, cranks (n, 2): by how much they are too long, and unit vectors; z (n, 1): points.
    arm (n, 1), reach (n, 1): from the tool's elbow to the point, and the same by the bar.
    """

    off: ndarray
    bars: ndarray
    cranks: ndarray
    z: ndarray
    arm: ndarray
    reach: Any


def _size(z):
    """Return |z|, or 1 for 0."""
    return np.where(z, np.abs(z), 1.0)


def _unit(z):
    with np.errstate(invalid="ignore"):  # where nothing is measured
        return z / _size(z)


def _bars_to(p, q, points):
    """Return the DrawnBars to measured points.

    A tool's point gives the angle of its bar, and with it joint C.
    """
    cranks, elbows = _cranks(p, q)
    z = unframe(p, as_complex(points))[:, None]
    place_on_bar, leg = tool_in(p)
    own = [leg]
    reach = np.reshape(p[1 + 2 * leg] + place_on_bar, (-1, 1))
    arm = z - elbows[:, own]
    joint = z - np.reshape(place_on_bar, (-1, 1)) * _unit(arm) * _unit(reach).conj()
    bars = joint - elbows
    off = np.abs(bars) - p[DISTAL_BARS].T
    off[:, own] = np.abs(arm) - np.abs(reach)
    return DrawnBars(off, _unit(bars), cranks, z, arm, reach)


def bars_off(p: ndarray, q: ndarray, points: ndarray) -> tuple[ndarray, ndarray]:
    """Return by how much each distal bar misses the measured points, and its derivatives.

    scale (|C - P_i| - l_i2), (n, 2), measured m, and (n, 2, 15); for the leg of a tool, the same
    of the tool. It needs no mode, and no point is out of reach: so a calibration begins with it,
    and looks for mistakes with it. The scale keeps a robot that shrinks as its picture grows from
    missing by less.
    """
    drawn = _bars_to(p, q, points)
    place_on_bar, leg = tool_in(p)
    turn, scale = p[11:13]
    shift = np.exp(-1j * turn) / scale
    by_points = np.zeros((len(q), len(UNKNOWNS)), complex)
    by_points[:, 9] = -shift
    by_points[:, 10] = -1j * shift
    by_points[:, 11] = -1j * drawn.z[:, 0]
    by_points[:, 12] = -drawn.z[:, 0] / scale
    elbows = _elbow_slopes(p, q, drawn.cranks)
    by_arm = by_points - elbows[:, leg]
    by_reach = BY_BARS[leg] + BY_TOOL
    along_arm, along_reach = _unit(drawn.arm), _unit(drawn.reach)
    turns = cross(along_arm, by_arm) / _size(drawn.arm)
    turns -= cross(along_reach, by_reach) / _size(drawn.reach)
    bar = along_arm * along_reach.conj()
    r = np.reshape(place_on_bar, (-1, 1))
    joint = by_points - bar * (BY_TOOL + 1j * r * turns)
    derived = dot(drawn.bars[:, :, None], joint[:, None] - elbows) - BY_BARS
    derived[:, leg] = dot(along_arm, by_arm) - dot(along_reach, by_reach)
    scale = np.reshape(scale, (-1, 1))
    scaled = scale[..., None] * derived
    scaled[:, :, 12] += drawn.off
    return scale * drawn.off, scaled


def whitening(p: ndarray, q: ndarray, sigma: ndarray) -> ndarray:
    """Return W (n, 2, 3) that makes independent residuals of sd sigma (n,) of the legs' errors.

    The residuals are W[:, :2] `bars_off` - W[:, 2]. A measured point that is off by delta, normal,
    changes the bars' errors by u_i . delta + (t_i . delta)^2 / (2 l_i2), t_i across the bar. Their
    mean and covariance to second order stay regular at Type 2, where u_1 and u_2 are parallel.
    """
    _, elbows = _cranks(p, q)
    bars = p[DISTAL_BARS]
    scale = p[12]
    left, right = elbows.T
    span = np.abs(right - left)
    # Of the angle between the bars; +1 or -1 where they are too short or too long to meet.
    law_of_cosines = (bars @ bars - span**2) / (2 * bars.prod())
    cosine = np.clip(law_of_cosines, -1.0, 1.0)
    first_order = np.ones((len(q), 2, 2))
    first_order[:, 0, 1] = cosine
    first_order[:, 1, 0] = cosine
    sd = sigma[:, None]
    curvature = np.minimum(sd / (scale * bars), 1.0)
    products = curvature[:, :, None] * curvature[:, None, :]
    second_order = products * first_order**2 / 2
    perimeter = bars.sum() + span
    rounding = 4 * EPS * perimeter * scale / sigma
    least_variance = 4 * EPS + rounding[:, None, None] ** 2
    covariance = first_order + second_order
    covariance += least_variance * np.eye(2)
    root = np.linalg.cholesky(covariance)
    whiten = np.linalg.inv(root)
    mean = sd * curvature / 2
    whitened_mean = whiten @ mean[:, :, None]
    return np.concatenate([whiten, whitened_mean], axis=2)


def sines_at(p: ndarray, q: ndarray, points: ndarray) -> ndarray:
    """Return the sines (n, 3) of both legs' Type 1 and of Type 2, bars drawn to measured points.

    Minus their signs are the working modes and the assembly mode.
    """
    drawn = _bars_to(p, q, points)
    left, right = drawn.bars.T
    type_1 = cross(drawn.cranks, drawn.bars)
    type_2 = cross(left, right)
    return np.column_stack([type_1, type_2])
