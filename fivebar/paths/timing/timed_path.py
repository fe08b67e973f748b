"""A path with its timing: a reference for every controller."""

from __future__ import annotations

from dataclasses import asdict, astuple, dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import bounded, positive
from ...base.presentation import Plotted
from ...base.representation import one_line
from ...base.tables import TextFile, write
from ...models.dynamics import inverse_dynamics
from ...models.geometry import igm
from ...models.kinematics import Accelerations, ikm, ikm2
from ...planning.trajectory import refuse_nan
from ..curve import Path
from ..recorded_path import RecordedPath, recorded_path
from .clock import Clock
from .constraint_rows import Limits

if TYPE_CHECKING:
    from ...models.robots import Robot

COLUMNS = (
    "t",
    "x",
    "y",
    "x_dot",
    "y_dot",
    "x_ddot",
    "y_ddot",
    "q1",
    "q2",
    "q1_dot",
    "q2_dot",
    "tau1",
    "tau2",
    "s",
    "pen",
)
MOST_ROWS = 10**7
LEAST = 1e-12  # of the mean speed, at which dry friction is that of moving
# Of the path's length: nearer to Type 2, torques are read beside it, as there they are 0 / 0.
BESIDE = 1e-7


@dataclass(frozen=True, eq=False)
class TimedPath(Plotted):
    """A motion along a path.

    Call it with t, s, a number or (n,), for (xi, xi_dot, xi_ddot), each (2,) or (n, 2). It rests at
    its first and last point before and after.

    Attributes
    ----------
    robot, path, working, limits
        The problem.
    piece, first : (n,)
        Piece of the path that each of n stretches is on, and where on it that begins, m.
    x : (n + 1,)
        s'^2 at the nodes, m^2/s^2.
    bent : (n,)
        On each stretch s'' = u0 + bent (s - s0), 1/s^2.
    lower_bound : float
        Time, s: no motion along the path under these limits takes less. 0 if none is known.
    crossing : (n + 1,)
        Nodes on Type 2.
    cap, ceiling : (n + 1,)
        s'^2 at the nodes by the maximum velocity curve, and s'^2 that no motion exceeds.
    smooth, pace : float
        Time, s, over which s(t) is averaged for a limit on jerk, and by how much the motion is
        slower then.
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
    smooth: float = 0.0
    pace: float = 1.0
    start = 0.0

    def __repr__(self) -> str:
        words = [f"{self.path.length:.6g} m", f"{self.duration:.6g} s"]
        if self.lower_bound:
            words.append(f"proved: no less than {self.lower_bound:.6g} s")
        words.append(f"working {self.working}")
        if self.crossing.any():
            words.append(f"crosses Type 2 {self.crossing.sum()} x")
        return one_line("TimedPath", *words)

    @property
    def tool(self) -> tuple[int, float, float] | None:
        """Its path's tool, (leg, along, across), m; None where joint C draws."""
        return None if self.path.tool is None else astuple(self.path.tool.tool)

    @cached_property
    def s(self) -> np.ndarray:
        """Of the nodes (n + 1,), m."""
        return np.append(self.path.knots[self.piece] + self.first, self.path.length)

    @cached_property
    def _lengths(self):
        ends = np.append(self.first[1:], self.path.pieces[-1].length)
        whole = np.array([piece.length for piece in self.path.pieces])
        continues = np.append(np.diff(self.piece), 1) == 0
        return np.where(continues, ends, whole[self.piece]) - self.first

    @cached_property
    def clock(self) -> Clock:
        """s by time, at the pace of 1."""
        waits = np.zeros(len(self.x))
        for stop in self.path.stops:
            waits[np.abs(self.s - stop.s).argmin()] += stop.seconds / self.pace
        return Clock(self._lengths, self.x, self.bent, waits, self.smooth)

    @property
    def duration(self) -> float:
        return self.clock.end * self.pace

    @property
    def gap(self) -> float:
        """By what share of the lower bound it takes longer."""
        return self.duration / self.lower_bound - 1 if self.lower_bound else np.inf

    @property
    def times(self) -> np.ndarray:
        """At which it passes its nodes (n + 1,), or leaves them after a rest, s."""
        return self.clock.times * self.pace

    def along(self, t: ArrayLike) -> tuple[np.ndarray, ...]:
        """Return (stretch, s from the stretch's begin, s', s'') at times t (*batch)."""
        t = np.asarray(t, dtype=float)
        refuse_nan(t)
        k, gone, speed, push = self.clock.along(t / self.pace)
        return k, gone, speed / self.pace, push / self.pace**2

    def __call__(self, t: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return self._motion(*self.along(t))

    def _motion(self, k, gone, speed, push):
        xi, xi_s, xi_ss, _ = self.path.on(self.piece[k], self.first[k] + gone)
        speed = speed[..., None]
        push = push[..., None]
        return xi, xi_s * speed, xi_ss * speed * speed + xi_s * push

    def accelerations(self, t: ArrayLike) -> Accelerations:
        """Return the motion as `Accelerations`, with pose and rates."""
        xi, xi_dot, xi_ddot = self(t)
        return ikm2(ikm(igm(self.robot, xi, self.working), xi_dot), xi_ddot)

    def joints(self, t: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return active joints' coordinates and rates (*batch, 2): rad, rad/s."""
        rates = self.accelerations(t).rates
        return rates.pose.q, rates.q_dot

    def torques(self, t: ArrayLike) -> np.ndarray:
        """Return torques (*batch, 2) of the motion, N m, finite on Type 2; before and after, those
        that hold the robot.
        """
        k, gone, speed, push = self.along(t)
        # Where it begins or ends to move, dry friction is that of moving.
        speed = np.where(push, np.maximum(speed, LEAST * self.path.length / self.duration), speed)
        if self.crossing.any():
            # Beside the node, on the same stretch: the quotient by det A goes on from there.
            h = self._lengths[k]
            least = BESIDE * self.path.length
            low = np.where(self.crossing[k], np.minimum(least, h / 2), 0.0)
            high = h - np.where(self.crossing[k + 1], np.minimum(least, h / 2), 0.0)
            moved = np.clip(gone, low, high)
            u0 = push - self.bent[k] * gone
            # At rest it is below 0 by rounding.
            square = self.x[k] + moved * (2 * u0 + self.bent[k] * moved)
            speed = np.where(moved == gone, speed, np.sqrt(np.maximum(square, 0.0)))
            push = u0 + self.bent[k] * moved
            gone = moved
        xi, xi_dot, xi_ddot = self._motion(k, gone, speed, push)
        return inverse_dynamics(ikm2(ikm(igm(self.robot, xi, self.working), xi_dot), xi_ddot))

    @cached_property
    def pen_changes(self) -> tuple[np.ndarray, np.ndarray]:
        """Return times (n,) s, from which on the pen is down or up (n,): a rest belongs to what
        comes after it.
        """
        begins = np.flatnonzero(np.diff(self.piece, prepend=-1))
        times = self.times[begins]
        if not self.clock.smooth:  # then these are the times at which a rest ends
            times = times - self.clock.waits[begins] * self.pace
        down = np.array(self.path.pen)[self.piece[begins]]
        if self.path.stops[-1].seconds:
            times = np.append(times, self.times[-1])
            down = np.append(down, False)
        return times, down

    def pen(self, t: ArrayLike) -> np.ndarray:
        """Return whether the pen is down at times t; it goes down or up when a rest begins."""
        times, down = self.pen_changes
        k = np.searchsorted(times, np.asarray(t) + 1e-12 * self.duration, side="right") - 1
        return down[np.maximum(k, 0)]

    def to_csv(self, path: TextFile, rate: float = 1000.0) -> None:
        """Write setpoints, `rate` times a second and at the last instant, for `from_csv` and
        `fb.from_csv`.

        Units are SI; pen is 1 where it is down. The first line is a comment with the problem.
        """
        rate = positive(rate, "to_csv: rate")
        steps = int(np.floor(self.duration * rate * (1 + 1e-12)))
        what = f"to_csv: {self.duration:g} s at {rate:g} Hz are {steps:.3g} rows"
        bounded(steps, MOST_ROWS, what, 8 * len(COLUMNS))
        t = np.arange(steps + 1) / rate
        t = np.append(t[t < self.duration * (1 - 1e-12)], self.duration)
        (q, q_dot), k, gone = self.joints(t), *self.along(t)[:2]
        s = self.path.knots[self.piece[k]] + self.first[k] + gone
        table = np.column_stack([t, *self(t), self.robot.continuous(q), q_dot, self.torques(t), s])
        about = {
            "robot": self.robot.parameters,
            "working": self.working,
            "limits": asdict(self.limits),
            "lower_bound": self.lower_bound,
        }
        rows = ((*row, pen) for row, pen in zip(table.tolist(), self.pen(t).astype(int).tolist()))
        write(path, "setpoints", about, COLUMNS, rows)

    @staticmethod
    def from_csv(path: TextFile) -> RecordedPath:
        """Return the robot's motion in a file of `to_csv` or of `fivebar draw`.

        At its rows it has the file's positions, velocities, accelerations and pen; between them
        polynomials of degree 5. Its points are those of joint C in the robot's own frame, where
        the file's are a tool's, or of a calibrated robot in its measuring frame. (`fb.from_csv`
        takes them as they are.)

        Raises
        ------
        ValueError
            With file and line, for what is no such file.
        """
        return recorded_path(path)
