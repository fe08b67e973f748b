"""A path with its timing: a reference for every controller."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..described import one_line
from ..models.dynamics import inverse_dynamics
from ..models.geometry import igm
from ..models.kinematics import Accelerations, ikm, ikm2
from .curve import Path
from .timing_lower import duration
from .timing_rows import Limits

if TYPE_CHECKING:
    from ..models.robots import Robot

BESIDE = 1e-7  # of the path's length: nearer to Type 2, torques are read beside it, as there they are 0 / 0
NEVER = 1e-12  # s


@dataclass(frozen=True, eq=False)
class TimedPath:
    """A motion along a path: called with t, s, a number or (n,), it gives (xi, xi_dot, xi_ddot), each (2,) or (n, 2),
    and rests at its first and last point before and after.

    robot, path, working, limits: what was asked. On each of n stretches s'' = u0 + bent (s - s0): piece (n,) of the path
    and first (n,), where on that piece it begins, m; x (n + 1,) m^2/s^2: s'^2 at the nodes; bent (n,) 1/s^2.
    lower_bound: s, less than which no motion along the path under these limits takes. crossing (n + 1,): the nodes on
    Type 2. cap (n + 1,): x at the nodes by the maximum velocity curve; ceiling (n + 1,): x that no motion passes.
    """

    robot: Robot
    path: Path
    working: tuple[int, int]
    limits: Limits
    piece: np.ndarray
    first: np.ndarray
    x: np.ndarray
    bent: np.ndarray
    lower_bound: float
    crossing: np.ndarray
    cap: np.ndarray
    ceiling: np.ndarray
    start = 0.0

    def __repr__(self) -> str:
        bounds = f"{self.duration:.6g} s", f"proved: no less than {self.lower_bound:.6g} s"
        crossed = int(self.crossing.sum())
        ways = f"{crossed} crossing{'s' * (crossed > 1)} of Type 2" if crossed else ""
        return one_line("TimedPath", f"{self.path.length:.6g} m", *bounds, f"working {self.working}", ways)

    @cached_property
    def s(self) -> np.ndarray:
        """Of the nodes (n + 1,), m."""
        return np.append(self.path.knots[self.piece] + self.first, self.path.length)

    @cached_property
    def _lengths(self):
        ends = np.append(self.first[1:], self.path.pieces[-1].length)
        whole = np.array([piece.length for piece in self.path.pieces])
        return np.where(np.append(np.diff(self.piece), 1) == 0, ends, whole[self.piece]) - self.first

    @cached_property
    def _clock(self):
        """When each stretch begins, and how long it takes, s; the rests before them."""
        taken = np.array([duration(*each) for each in zip(self._lengths, self.x[:-1], self.x[1:], self.bent)])
        waits = np.zeros(len(taken) + 1)
        for stop in self.path.stops:
            waits[np.abs(self.s - stop.s).argmin()] += stop.seconds
        begins = np.cumsum(np.insert(taken, 0, 0.0)) + np.cumsum(waits)
        return begins[:-1], taken, begins[-1]

    @property
    def duration(self) -> float:
        return float(self._clock[2])

    @property
    def gap(self) -> float:
        """By what share of the lower bound it takes longer."""
        return self.duration / self.lower_bound - 1

    @property
    def times(self) -> np.ndarray:
        """At which it passes its nodes (n + 1,), s."""
        begins, taken, _ = self._clock
        return np.append(begins, begins[-1] + taken[-1])

    def along(self, t: ArrayLike) -> tuple[np.ndarray, ...]:
        """(stretch, s from the stretch's begin, s', s'') at times t (*batch)."""
        t = np.asarray(t, dtype=float)
        if np.isnan(t).any():
            raise ValueError("t must be a number of seconds, but one is nan")
        begins, taken, end = self._clock
        k = np.clip(np.searchsorted(begins, t, side="right") - 1, 0, len(begins) - 1)
        dt = np.clip(t - begins[k], 0.0, taken[k])
        h, bent, v0 = self._lengths[k], self.bent[k], np.sqrt(self.x[k])
        u0 = (self.x[k + 1] - self.x[k]) / (2 * h) - bent * h / 2
        c0, c1, c2 = _stumpff(bent * dt * dt)
        gone = np.clip(v0 * dt * c1 + u0 * dt * dt * c2, 0.0, h)
        speed, push = v0 * c0 + u0 * dt * c1, u0 + bent * gone
        still = (t < 0) | (t > end) | (t > begins[k] + taken[k] + NEVER)
        return k, gone, np.where(still, 0.0, np.maximum(speed, 0.0)), np.where(still, 0.0, push)

    def __call__(self, t: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return self._motion(*self.along(t))

    def _motion(self, k, gone, speed, push):
        xi, xi_s, xi_ss, _ = self.path.on(self.piece[k], self.first[k] + gone)
        speed, push = speed[..., None], push[..., None]
        return xi, xi_s * speed, xi_ss * speed * speed + xi_s * push

    def accelerations(self, t: ArrayLike) -> Accelerations:
        """The motion as `Accelerations`, with pose and rates."""
        xi, xi_dot, xi_ddot = self(t)
        return ikm2(ikm(igm(self.robot, xi, self.working), xi_dot), xi_ddot)

    def joints(self, t: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Active joints' coordinates and rates (*batch, 2): rad, rad/s."""
        rates = self.accelerations(t).rates
        return rates.pose.q, rates.q_dot

    def tau(self, t: ArrayLike) -> np.ndarray:
        """Torques (*batch, 2) of the motion, N m, finite on Type 2; before and after, those that hold the robot."""
        k, gone, speed, push = self.along(t)
        if self.crossing.any():
            # Beside the node, on the same stretch: the quotient by det A goes on from there.
            h, least = self._lengths[k], BESIDE * self.path.length
            low = np.where(self.crossing[k], np.minimum(least, h / 2), 0.0)
            high = h - np.where(self.crossing[k + 1], np.minimum(least, h / 2), 0.0)
            moved = np.clip(gone, low, high)
            u0 = push - self.bent[k] * gone
            speed = np.where(moved == gone, speed, np.sqrt(self.x[k] + moved * (2 * u0 + self.bent[k] * moved)))
            push, gone = u0 + self.bent[k] * moved, moved
        xi, xi_dot, xi_ddot = self._motion(k, gone, speed, push)
        return inverse_dynamics(ikm2(ikm(igm(self.robot, xi, self.working), xi_dot), xi_ddot))


def _stumpff(z):
    """c0, c1, c2 of Stumpff at -z: cosh(r), sinh(r) / r, (cosh(r) - 1) / r^2 with r = sqrt(z), cosines for z < 0."""
    root = np.sqrt(np.abs(z))
    small, root = root < 1e-2, np.where(root < 1e-2, 1.0, root)
    c0 = np.where(z > 0, np.cosh(np.where(z > 0, root, 0.0)), np.cos(root))
    c1 = np.where(z > 0, np.sinh(np.where(z > 0, root, 0.0)), np.sin(root)) / root
    c2 = 2 * (np.where(z > 0, np.sinh(np.where(z > 0, root, 0.0) / 2), np.sin(root / 2)) / root) ** 2
    series = 1 + z / 2 * (1 + z / 12 * (1 + z / 30)), 1 + z / 6 * (1 + z / 20 * (1 + z / 42)), 0.5 * (1 + z / 12 * (1 + z / 30 * (1 + z / 56)))
    return tuple(np.where(small, near, far) for near, far in zip(series, (c0, c1, c2)))
