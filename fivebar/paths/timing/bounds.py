"""Coefficients of the torques and accelerations of a motion along a path, enclosed on stretches.

With x = s'^2 and u = s'', the legs closed in one working mode and sigma_i the sign of q_i's
derivative by s,

    det A tau_i = a_i(s) u + b_i(s) x + v_i(s) sqrt(x) + c_i(s) + f_i(s) sigma_i

(v: viscous, f: Coulomb friction, c: gravity; all of them regular at Type 2, where det A is 0),
q_i'' = q_i,s u + q_i,ss x and xi'' = xi_s u + xi_ss x.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...models.dyads import Slider, cross, dot
from ...models.dynamics import bar_force_dynamics
from ...models.geometry import DrivenLeg, Pose
from ...models.kinematics import Accelerations, Rates
from ...models.loads import has_moving_mass
from ...models.physics import any_named, loads_of, named
from .enclosures import TERMS, Series, dyad_series, place_series

if TYPE_CHECKING:
    from ...models.robots import Robot
    from ..curve import Path

RUBS = "fv1", "fv2", "fs1", "fs2", "fv12", "fv22"


@dataclass(frozen=True, eq=False)
class Stretches:
    """Consecutive parts [first, last] (n,) of pieces (n,), s, m, from each piece's beginning."""

    piece: np.ndarray
    first: np.ndarray
    last: np.ndarray

    def __len__(self) -> int:
        return len(self.piece)

    @property
    def length(self) -> np.ndarray:
        return self.last - self.first

    def taken(self, at: np.ndarray) -> Stretches:
        return Stretches(self.piece[at], self.first[at], self.last[at])

    def parted(self, parts: np.ndarray) -> Stretches:
        """Return each stretch in so many equal parts (n,), 1 or more."""
        cuts = parts - 1
        index = np.repeat(np.arange(len(parts)), cuts)
        before = np.repeat(np.cumsum(cuts) - cuts, cuts)
        k = np.arange(len(index)) - before + 1
        return self.cut(index, self.first[index] + self.length[index] * k / parts[index])

    def cut(self, index: np.ndarray, places: np.ndarray) -> Stretches:
        """Return the stretches, cut at places inside the stretches `index`."""
        order = np.lexsort((places, index))
        index = index[order]
        places = places[order]
        piece = np.insert(self.piece, index + 1, self.piece[index])
        first = np.insert(self.first, index + 1, places)
        # The last stretch of a piece ends where it did.
        last = np.append(first[1:], np.nan)
        ends = np.append(piece[1:] != piece[:-1], True)
        last[ends] = self.last[np.append(np.diff(self.piece), 1) != 0]
        return Stretches(piece, first, last)


class Bernstein(NamedTuple):
    """A function on n stretches, t from 0 to 1, to within slack + bend t (1 - t); all (n,).

    f = first (1 - t)^2 + 2 middle t (1 - t) + last t^2
    """

    first: np.ndarray
    middle: np.ndarray
    last: np.ndarray
    bend: np.ndarray
    slack: np.ndarray

    def taken(self, at: np.ndarray) -> Bernstein:
        return Bernstein(*(value[at] for value in self))

    def least(self) -> np.ndarray:
        """Return a lower bound (n,)."""
        ends = np.minimum(self.first, self.last)
        return np.minimum(ends, self.middle - self.bend / 2) - self.slack

    def largest(self) -> np.ndarray:
        """Return an upper bound (n,)."""
        ends = np.maximum(self.first, self.last)
        return np.maximum(ends, self.middle + self.bend / 2) + self.slack

    def size(self) -> np.ndarray:
        return np.maximum(self.largest(), -self.least())


def asked(
    robot: Robot, xi: tuple[Series, Series], working: tuple[int, int], tip: tuple[Series, Series]
) -> dict[str, Series]:
    """Return {name: Series}, of two terms less than the place; tip: the place of what is led.

    D (det A), a1, a2, b1, ..., f2 of the equation above (v, f and c where the robot has them); q1,
    q2, p1, p2 (first and second derivative of q); d1, d2 (det A times q1, q2); w0, w1, w2 (squares
    of |tip_s|, q1 and q2); g, m, k (|tip_s| and the parts of tip_ss along and across tip_s).
    """
    left, q1_s = _leg(robot.drives[0], robot.distal[0], working[0], xi)
    right, q2_s = _leg(robot.drives[1], robot.distal[1], working[1], xi)
    legs = left, right
    terms = len(xi[0].m) - 2
    x_s = xi[0].slope()
    y_s = xi[1].slope()
    xi_ss = (x_s.slope(), y_s.slope())
    q_ss = (q1_s.slope(), q2_s.slope())
    xi_s = (x_s.cut(terms), y_s.cut(terms))
    q_s = (q1_s.cut(terms), q2_s.cut(terms))
    pose = Pose(robot, xi, lambda: (legs, ()))
    zero = (0.0 * xi_ss[0],) * 2
    physics = loads_of(robot)
    bare = _without(robot, "gravity", *RUBS)
    pushes = has_moving_mass(robot)

    def torques(robot_, rates, accelerations):
        at = Pose(robot_, xi, lambda: (legs, ()))
        return bar_force_dynamics(Accelerations(Rates(at, *rates), *accelerations), (0.0, 0.0))

    det_A = pose.det_A if pushes else 1.0 + zero[0]
    parts = {
        "a": torques(bare, (zero, zero), (q_s, xi_s)),
        "b": torques(bare, (q_s, xi_s), (q_ss, xi_ss)),
    }
    if physics.has_gravity:
        parts["c"] = torques(_without(robot, *RUBS), (zero, zero), (zero, zero))
    if any_named(physics.viscous, physics.elbows):
        parts["v"] = torques(_without_bars(robot), (q_s, xi_s), (zero, zero))
    found = {"D": det_A}
    (x1, y1), (x2, y2) = pose.u2
    for name, ((fx, fy), (tau1, tau2)) in parts.items():
        if pushes:
            tau1 = det_A * tau1 + pose.b[0] * (fx * y2 - fy * x2)
            tau2 = det_A * tau2 + pose.b[1] * (fy * x1 - fx * y1)
        found |= {f"{name}1": tau1, f"{name}2": tau2}
    for k in (0, 1):
        if named(physics.coulomb[k]):
            found[f"f{k + 1}"] = det_A * physics.coulomb[k]
    found |= {"q1": q_s[0], "q2": q_s[1], "p1": q_ss[0], "p2": q_ss[1]}
    found |= {"d1": det_A * q_s[0], "d2": det_A * q_s[1]}
    found |= {"w1": q_s[0] * q_s[0], "w2": q_s[1] * q_s[1]}
    slopes = tip[0].slope(), tip[1].slope()
    tip_ss = slopes[0].slope(), slopes[1].slope()
    tip_s = slopes[0].cut(terms), slopes[1].cut(terms)
    found["w0"] = dot(tip_s, tip_s)
    size = found["w0"].sqrt()
    scale = size.inverse()
    return found | {"g": size, "m": dot(tip_s, tip_ss) * scale, "k": cross(tip_s, tip_ss) * scale}


def asked_on(
    robot: Robot,
    path: Path,
    working: tuple[int, int],
    piece: np.ndarray,
    first: np.ndarray,
    last: np.ndarray,
    terms: int,
) -> dict[str, Series]:
    """Return all that `asked` names, on stretches of a path, from so many terms of its place."""
    tip = place_series(path, piece, first, last, terms)
    xi = tip if path.tool is None else path.tool.series(*tip)[:2]
    return asked(robot, xi, working, tip)


def _leg(drive, bar, mode, xi):
    """Return the leg closed on the place, and q's derivative by s (one term less)."""
    terms = len(xi[0].m) - 2
    x = xi[0] - drive.x
    y = xi[1] - drive.y
    if isinstance(drive, Slider):
        ux = x / bar
        uy = (1.0 - ux * ux).sqrt() * -mode
        q = y - uy * bar
        slope = q.slope()
        direction = q.cut(terms)
    else:
        (dx, dy), _, _ = dyad_series(x, y, drive.length, bar, mode)
        ux = (x - dx) / bar
        uy = (y - dy) / bar
        direction = dx / drive.length, dy / drive.length
        slope = cross(direction, (direction[0].slope(), direction[1].slope()))
        direction = direction[0].cut(terms), direction[1].cut(terms)
    distal = ux.cut(terms), uy.cut(terms)
    return DrivenLeg(drive, None, direction, lambda: distal), slope


def _without(robot, *names):
    own = {f.name: f.default for f in fields(robot) if f.name in names}
    return replace(robot, **own)


def _without_bars(robot):
    """Return the robot without what makes torques from rates, but viscous friction: the masses
    beside its drives' own, whose names begin with m and z.
    """
    names = {f.name for f in fields(robot) if f.name[0] in "mz"} - {*robot.words.inertias}
    return replace(_without(robot, "gravity", "fs1", "fs2"), **dict.fromkeys(names, 0.0))


def enclosed(
    robot: Robot, path: Path, stretches: Stretches, working: tuple[int, int]
) -> dict[str, Bernstein]:
    """Return all that `asked` names, on stretches; nan where a leg may be in line or out of reach.

    It follows from the values at both ends and from bounds of the second derivative between them: a
    function less its chord is f''(zeta) / 2 (s - s0) (s - s1).
    """
    n = len(stretches)
    s = np.concatenate([stretches.first, stretches.last])
    ends = np.tile(stretches.piece, 2), s, s, TERMS - 2
    at_ends = asked_on(robot, path, working, *ends)
    whole = stretches.piece, stretches.first, stretches.last, TERMS
    over = asked_on(robot, path, working, *whole)
    square = stretches.length**2
    found = {}
    for name, value in at_ends.items():
        m = value.m[0]
        r = value.r[0]
        second = over[name]
        first = m[:n]
        last = m[n:]
        middle = (first + last - second.m[2] * square) / 2
        found[name] = Bernstein(first, middle, last, second.r[2] * square, np.maximum(r[:n], r[n:]))
    return found
