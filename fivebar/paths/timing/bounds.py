"""What a motion along a path asks for, enclosed on stretches of it.

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
from .enclosures import TERMS, Series, place_series

if TYPE_CHECKING:
    from ...models.robots import Robot
    from ..curve import Path

RUBS = "fv1", "fv2", "fs1", "fs2", "fv12", "fv22"


@dataclass(frozen=True, eq=False)
class Stretches:
    """Parts [first, last] (n,) of pieces (n,), s from each piece's own beginning, m, one after the
    other.
    """

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
        """Each in so many equal parts (n,), 1 or more."""
        index = np.repeat(np.arange(len(parts)), parts - 1)
        k = np.arange(len(index)) - np.repeat(np.cumsum(parts - 1) - (parts - 1), parts - 1) + 1
        return self.cut(index, self.first[index] + self.length[index] * k / parts[index])

    def cut(self, index: np.ndarray, places: np.ndarray) -> Stretches:
        """With cuts at places inside the stretches `index`."""
        order = np.lexsort((places, index))
        index, places = index[order], places[order]
        piece = np.insert(self.piece, index + 1, self.piece[index])
        first = np.insert(self.first, index + 1, places)
        last = np.append(np.where(piece[1:] == piece[:-1], first[1:], np.nan), np.nan)
        last[np.isnan(last)] = self.last[np.append(np.diff(self.piece), 1) != 0]
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

    def least(self) -> np.ndarray:
        """Lower bound."""
        return (
            np.minimum(np.minimum(self.first, self.last), self.middle - self.bend / 2) - self.slack
        )

    def largest(self) -> np.ndarray:
        return (
            np.maximum(np.maximum(self.first, self.last), self.middle + self.bend / 2) + self.slack
        )

    def size(self) -> np.ndarray:
        return np.maximum(self.largest(), -self.least())


def asked(robot: Robot, xi: tuple[Series, Series], working: tuple[int, int]) -> dict[str, Series]:
    """{name: Series}, of two terms less than the place.

    D (det A), a1, a2, b1, ..., f2 of the equation above (v, f and c where the robot has them); q1,
    q2, p1, p2 (first and second derivative of q); w0, w1, w2 (squares of |xi_s|, q1 and q2); g, m,
    k (|xi_s| and the parts of xi_ss along and across xi_s).
    """
    legs, slopes = [], []
    for drive, bar, mode in zip(robot.drives, robot.distal, working):
        leg, slope = _leg(drive, bar, mode, xi)
        legs.append(leg)
        slopes.append(slope)
    terms = len(xi[0].m) - 2
    xi_s, q_s = tuple(each.slope() for each in xi), tuple(slopes)
    xi_ss, q_ss = (tuple(each.slope() for each in pair) for pair in (xi_s, q_s))
    xi_s, q_s = (tuple(each.cut(terms) for each in pair) for pair in (xi_s, q_s))
    pose = Pose(robot, tuple(each.cut(terms) for each in xi), lambda: (tuple(legs), ()))
    zero = (0.0 * xi_ss[0], 0.0 * xi_ss[0])
    physics = loads_of(robot)
    bare = _without(robot, "gravity", *RUBS)
    pushes = has_moving_mass(robot)

    def torques(robot_, rates, accelerations):
        at = Pose(robot_, pose.point, lambda: (tuple(legs), ()))
        return bar_force_dynamics(Accelerations(Rates(at, *rates), *accelerations), (0.0, 0.0))

    det_A = pose.det_A if pushes else 1.0 + zero[0]
    found = {"D": det_A}
    parts = {
        "a": torques(bare, (zero, zero), (q_s, xi_s)),
        "b": torques(bare, (q_s, xi_s), (q_ss, xi_ss)),
    }
    if physics.has_gravity:
        parts["c"] = torques(_without(robot, *RUBS), (zero, zero), (zero, zero))
    if any_named(physics.viscous, physics.elbows):
        parts["v"] = _viscous(physics, Rates(pose, q_s, xi_s), zero)
    (x1, y1), (x2, y2) = pose.u2
    for name, ((fx, fy), own) in parts.items():
        bars = (fx * y2 - fy * x2, fy * x1 - fx * y1) if pushes else (0.0, 0.0)
        for k in (0, 1):
            found[f"{name}{k + 1}"] = det_A * own[k] + pose.b[k] * bars[k] if pushes else own[k]
    for k in (0, 1):
        if named(physics.coulomb[k]):
            found[f"f{k + 1}"] = det_A * physics.coulomb[k]
    kinematic = {"q": q_s, "p": q_ss}
    found |= {f"{name}{k + 1}": pair[k] for name, pair in kinematic.items() for k in (0, 1)}
    found |= {f"w{k + 1}": q_s[k] * q_s[k] for k in (0, 1)}
    found["w0"] = dot(xi_s, xi_s)
    size = found["w0"].sqrt()
    scale = size.inverse()
    return found | {"g": size, "m": dot(xi_s, xi_ss) * scale, "k": cross(xi_s, xi_ss) * scale}


def _leg(drive, bar, mode, xi):
    """The leg closed on the place, and q's derivative by s (one term less than the place)."""
    terms = len(xi[0].m) - 2
    x, y = xi[0] - drive.x, xi[1] - drive.y
    if isinstance(drive, Slider):
        ux = x / bar
        uy = (1.0 - ux * ux).sqrt() * -mode
        q = y - uy * bar
        slope, direction = q.slope(), q.cut(terms)
    else:
        length, square = drive.length, x * x + y * y
        lead = (square + (length + bar) * (length - bar)) * 0.5
        across = (((length + bar) ** 2 - square) * (square - (length - bar) ** 2)).sqrt() * (
            0.5 * mode
        )
        scale = square.inverse()
        dx, dy = (
            (lead * x - across * y) * scale,
            (lead * y + across * x) * scale,
        )  # length times the direction
        ux, uy = (x - dx) / bar, (y - dy) / bar
        direction = dx / length, dy / length
        slope = cross(direction, (direction[0].slope(), direction[1].slope()))
        direction = tuple(each.cut(terms) for each in direction)
    distal = ux.cut(terms), uy.cut(terms)
    return DrivenLeg(drive, None, direction, lambda: distal), slope


def _without(robot, *names):
    own = {f.name: f.default for f in fields(robot) if f.name in names}
    return replace(robot, **own)


def _viscous(physics, rates, zero):
    """(force on the end-effector, torques) of viscous friction at these rates."""
    force, torques = list(zero), []
    for i, (drive, bar) in enumerate(zip(rates.pose.robot.drives, rates.pose.robot.distal)):
        q_dot = rates.components[0][i]
        torque = physics.viscous[i] * q_dot
        if named(physics.elbows[i]):
            resists = physics.elbows[i] * drive.relative(rates.phi_dot[i], q_dot)
            (x, y), share = rates.pose.u2[i], resists / bar
            leg = rates.pose.legs[i]
            _, beside = drive.velocity_coefficients(leg.sine, leg.cosine)
            force = [force[0] - share * y, force[1] + share * x]
            torque = torque - share * beside - resists
        torques.append(torque)
    return tuple(force), tuple(torques)


def enclosed(
    robot: Robot, path: Path, stretches: Stretches, working: tuple[int, int]
) -> dict[str, Bernstein]:
    """All that `asked` names, on stretches; nan where a leg may be in line (Type 1) or out of reach
    on one.

    By the values at both ends and by bounds of the second derivative between them: a function less
    its chord is f''(zeta) / 2 (s - s0) (s - s1).
    """
    n = len(stretches)
    ends = place_series(
        path,
        np.tile(stretches.piece, 2),
        *2 * [np.concatenate([stretches.first, stretches.last])],
        TERMS - 2,
    )
    at_ends = asked(robot, ends, working)
    over = asked(
        robot, place_series(path, stretches.piece, stretches.first, stretches.last, TERMS), working
    )
    square, found = stretches.length**2, {}
    for name, value in at_ends.items():
        m, r, second = value.m[0], value.r[0], over[name]
        first, last = m[:n], m[n:]
        middle = (first + last - second.m[2] * square) / 2
        found[name] = Bernstein(first, middle, last, second.r[2] * square, np.maximum(r[:n], r[n:]))
    return found
