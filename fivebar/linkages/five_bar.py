"""The five-bar with its two motors at any two of its five joints (MechAnalyzer, section II-E).

The three joints without a motor divide the loop into three bodies, rigid once the motors stand
still: one holds the ground, the other two are the bars of an RRR dyad, whose lengths change where a
    motor is inside of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.backend import EPS, is_symbolic, reciprocal_or_nan, sqrt, unpack
from ..base.checks import instance, shown, whole
from ..models.dyads import RRR, cross, dot
from ..models.geometry import dgm
from ..models.robots import FiveBar
from .chain import Closure, Fixed, Reach, Still, Turned, minus
from .motion import Chain, Motion, MovingLink

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .chain import Number, Point

# Links 1 to 4 are the bars l11, l12, l22, l21, as headed from the bases outwards: 3 and 4 against
# the way around.
FORWARD = {1: 1, 2: 1, 3: -1, 4: -1}
TURNS = {
    2: 1,
    3: 1,
    4: -1,
}  # heading of link k = heading of link k - 1 + this times the angle of joint k


@dataclass(frozen=True)
class FiveBarLinkage:
    """A five-bar with motors at two of its joints.

    The joints are 1 (left base), 2 (left elbow), 3 (end-effector), 4 (right elbow) and 5 (right
    base). Their angles: 1 and 5 those of the proximal bars from +x; 2 and 4 of a distal bar from
    its proximal one (the robot's q12, q22); 3 of the right distal bar from the left one. branch +1:
    of the three joints without motor, in their order from 1 to 5, the middle one is on the left of
    the line from the first to the third.

    Parameters
    ----------
    robot : FiveBar
    motors : (2,) of int
        Numbers of the joints with motors.

    Examples
    --------
    >>> from fivebar import linkages
    >>> linkages.FiveBarLinkage(motors=(1, 2)).motors
    (1, 2)
    """

    robot: FiveBar = FiveBar()
    motors: tuple = (1, 5)

    def __post_init__(self) -> None:
        instance(FiveBar)(self.robot, "robot")
        try:
            motors = tuple(whole(1, 5)(k, "each of motors") for k in self.motors)
        except (TypeError, ValueError):
            motors = ()
        if len(motors) != 2 or len(set(motors)) != 2:
            raise ValueError(f"motors must be two of the joints 1 to 5, not {shown(self.motors)}")
        object.__setattr__(self, "motors", tuple(sorted(motors)))

    @property
    def title(self) -> str:
        return "five-bar, motors at joints {} and {}".format(*self.motors)

    @property
    def lengths(self) -> dict[int, float]:
        """Of links 1 to 4, m."""
        robot = self.robot
        return {1: robot.l11, 2: robot.l12, 3: robot.l22, 4: robot.l21}

    def start(self, q: ArrayLike, q_dot: ArrayLike, q_ddot: ArrayLike, branch: Any) -> Motion:
        given = [_pair(x, name) for x, name in ((q, "q"), (q_dot, "q_dot"), (q_ddot, "q_ddot"))]
        if not any(is_symbolic(x) for pair in given for x in pair) and any(
            np.ndim(x) for pair in given for x in pair
        ):
            flat = np.broadcast_arrays(*(x for pair in given for x in pair))
            given = [(flat[k], flat[k + 1]) for k in (0, 2, 4)]
        q, q_dot, q_ddot = given
        drives = {k: (q[i], q_dot[i], q_ddot[i]) for i, k in enumerate(self.motors)}
        return Motion(
            self, q, q_dot, q_ddot, branch, lambda: self._chain(drives, branch), (1.0, 0.0)
        )

    def _chain(self, drives, branch):
        half = self.robot.d / 2
        points = {}
        headings = {}
        points[1], points[5] = Fixed((-half, 0.0)), Fixed((half, 0.0))
        left, right = 1, 5
        while left in drives:  # the body of the ground, from its left end outwards ...
            turn = drives[left] if left == 1 else _times(TURNS[left], drives[left])
            headings[left] = Turned(headings.get(left - 1, Still()), *turn)
            points[left + 1] = Reach(
                points[left], headings[left], FORWARD[left] * self.lengths[left]
            )
            left += 1
        while right in drives:  # ... and from its right end
            if right == 5:
                turn = drives[right]
            else:
                turn = _times(-TURNS[right], drives[right])
            headings[right - 1] = Turned(headings.get(right, Still()), *turn)
            points[right - 1] = Reach(
                points[right], headings[right - 1], -FORWARD[right - 1] * self.lengths[right - 1]
            )
            right -= 1
        middle = next(k for k in range(left + 1, right) if k not in drives)
        bodies = [self._body(drives, left, middle, 1), self._body(drives, right, middle, -1)]
        shapes = [body[-1][2] for body in bodies]
        ends = points[left], points[right]
        dyad = StretchingRRR(
            minus(ends[1].p, ends[0].p), *(sqrt(dot(w.p, w.p)) for w in shapes), branch
        )
        points[middle] = StretchingClosure(
            ends, dyad, shapes, "the bodies on the middle joint are in line"
        )
        for body, unit, end in zip(bodies, (dyad.first, dyad.second), ends):
            frame = Carried(end, points[middle], unit, body[-1][2])
            for link, heading, _, joint, reach in body:
                headings[link] = Turned(frame, *heading) if heading else frame
                if joint != middle:
                    points[joint] = Reach(
                        points[joint - (1 if end is ends[0] else -1)], headings[link], reach
                    )
        names = {k: f"joint {k}" for k in range(1, 6)}
        starts = {1: 1, 2: 2, 3: 4, 4: 5}
        links = {
            f"link {k}": MovingLink(points[starts[k]], headings[k], self.lengths[k])
            for k in range(1, 5)
        }
        bars = tuple((names[a], names[b]) for a, b in ((1, 2), (2, 3), (5, 4), (4, 3)))
        points = {names[k]: points[k] for k in range(1, 6)}
        actuated = tuple(names[k] for k in self.motors)
        return Chain(points, links, {}, (dyad,), bars, (names[1], names[5]), actuated, names[3])

    def _body(self, drives, first, last, step):
        """Links from joint `first` to `last`: (link, turn from the first one, end in its frame,
        joint there, reach).
        """
        body = []
        joint = first
        heading = Still()
        turn = None
        end = Fixed((0.0, 0.0))
        while joint != last:
            link = joint if step > 0 else joint - 1
            if joint != first:
                own = _times(step * TURNS[joint], drives[joint])
                if turn is None:
                    turn = own
                else:
                    turn = tuple(a + b for a, b in zip(turn, own))
                heading = Turned(Still(), *turn)
            reach = step * FORWARD[link] * self.lengths[link]
            end = Reach(end, heading, reach)
            joint = joint + step
            body.append((link, turn, end, joint, reach))
        return body

    @property
    def passive(self) -> tuple[int, ...]:
        """The three joints without a motor: the corners of the triangle that closes the loop."""
        return tuple(k for k in range(1, 6) if k not in self.motors)

    @cached_property
    def home(self) -> dict[int, float]:
        """All five joint angles, rad, in a pose of assembly mode -1 far from where the passive
        joints are in line.
        """
        q = np.stack(
            np.meshgrid(*[np.radians(np.arange(-180, 180, 15.0))] * 2, indexing="ij"), axis=-1
        ).reshape(-1, 2)
        pose = dgm(self.robot, q, unreachable="nan")
        best = dgm(self.robot, q[np.nanargmax(np.abs(self._flatness(pose)))])
        (q11, q21), (q12, q22) = best.q.tolist(), best.q_passive.tolist()
        return {
            1: q11,
            2: q12,
            3: math.remainder(q21 + q22 - q11 - q12, 2 * math.pi),
            4: q22,
            5: q21,
        }

    @cached_property
    def usual_branch(self) -> int:
        """The branch of the home pose."""
        pose = dgm(self.robot, (self.home[1], self.home[5]))
        return 1 if self._flatness(pose) > 0 else -1

    def _flatness(self, pose):
        """Return signed area of the passive joints' triangle over the sum of its squared sides: > 0
        on branch +1.
        """
        half = self.robot.d / 2
        left, right = (
            pose.elbows[..., k, :] + 0 * pose.xi for k in (0, 1)
        )  # nan where the end-effector is
        joints = dict(
            enumerate(
                ((-half, 0.0) + 0 * left, left, pose.xi, right, (half, 0.0) + 0 * left), start=1
            )
        )
        a, b, c = (joints[k] for k in self.passive)
        first = np.moveaxis(b - a, -1, 0)
        across = np.moveaxis(c - a, -1, 0)
        return cross(across, first) / ((b - a) ** 2 + (c - a) ** 2 + (c - b) ** 2).sum(axis=-1)


@dataclass(frozen=True, eq=False)
class StretchingRRR(RRR):
    """RRR whose lengths may be arrays or symbols."""

    def _floor(self):
        total = self.r1 + self.r2
        return -8 * EPS * total * total * self.span_squared

    @cached_property
    def _inverse(self):
        return reciprocal_or_nan(self.span_squared, 0.0)


@dataclass(frozen=True, eq=False)
class StretchingClosure(Closure):
    """Closure with bars of changing length: `bends` are the bars as vectors w in their own frames,
    that move.

    |C - P|^2 = |w|^2, differentiated once and twice.
    """

    @cached_property
    def v(self) -> tuple:
        return self._solve(*(dot(u, p.v) + dot(w.p, w.v) / r for u, p, w, r in self._bars))

    @cached_property
    def a(self) -> tuple:
        along = []
        for u, pivot, w, r in self._bars:
            relative = minus(self.v, pivot.v)
            along.append(
                dot(u, pivot.a) + (dot(w.v, w.v) + dot(w.p, w.a) - dot(relative, relative)) / r
            )
        return self._solve(*along)

    @property
    def _bars(self):
        dyad = self.dyad
        return tuple(zip((dyad.first, dyad.second), self.pivots, self.bends, (dyad.r1, dyad.r2)))


@dataclass(frozen=True, eq=False)
class Carried:
    """The heading of a body's frame: `unit` points from start to end, w is the same vector in that
    frame.
    """

    start: Point
    end: Point
    unit: tuple
    w: Point

    @cached_property
    def _inverse(self):
        return 1 / dot(self.w.p, self.w.p)

    @cached_property
    def u(self) -> tuple:
        (x, y), (wx, wy) = self.unit, self.w.p
        scale = sqrt(self._inverse)
        return (x * wx + y * wy) * scale, (y * wx - x * wy) * scale

    @cached_property
    def _span(self):
        return tuple(minus(getattr(self.end, k), getattr(self.start, k)) for k in "pva")

    @cached_property
    def rate(self) -> Number:
        z, z1, _ = self._span
        return (cross(z, z1) - cross(self.w.p, self.w.v)) * self._inverse

    @cached_property
    def acceleration(self) -> Number:
        z, _, z2 = self._span
        # |z| = |w| at all times, so that both angles share the term of the changing length.
        stretch = 2.0 * dot(self.w.p, self.w.v) * self.rate
        return (cross(z, z2) - cross(self.w.p, self.w.a) - stretch) * self._inverse


def _pair(x, name):
    """Return two components of what two motors are given, one number for both included."""
    if isinstance(x, float):
        return x, x
    return unpack(x, name)


def _times(sign, angle):
    return tuple(sign * x for x in angle)
