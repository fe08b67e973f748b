"""A tool on a distal bar: a pen, a hotend or a laser that is not in the robot's last joint.

The robot is modelled up to the joint C of its two distal bars. A tool rigid on one of them is led
along a path by leading C along another one, which this module computes.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass, replace
from functools import partial
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from ..base.backend import EPS, finite_numbers, first_index, pairs
from ..base.checks import instance, modes, number, shown, whole
from ..base.errors import UnreachableError
from ..base.representation import one_line
from ..models.geometry import igm
from ..models.kinematics import Accelerations, Rates
from ..models.pose import Pose
from ..models.robots import FiveBar
from ..models.unreachable import raise_or_nan
from ..planning.trajectory import Trajectory
from .curve import Path
from .placement import Placement
from .timing.enclosures import Series, dyad_series, place_series

FACTORIALS = np.array([1.0, 1.0, 2.0, 6.0])[:, None]
FINEST = 1e-9  # of a path's length: a shorter stretch is not divided any more
CHECKED = 2001  # times of a trajectory at which the tool must reach it
SHORTEST = 1e-9  # of a distal bar: the least distance of the tool from its elbow


@dataclass(frozen=True)
class Tool:
    """A tool that is rigid on a distal bar, beside the joint C of both.

    With u_i the unit vector of the bar from its elbow to C, and v_i to its left, the tool is at

        T = C + along u_i + across v_i

    Parameters
    ----------
    leg : 1 or 2
        The leg whose distal bar carries it: left or right.
    along, across : float
        Place of the tool from C, m: along the bar, away from the elbow, and to the bar's left.

    Examples
    --------
    >>> import fivebar as fb
    >>> robot, tool = fb.FiveBar(), fb.Tool(leg=1, along=0.02)
    >>> path = tool.path(robot, fb.path([(0.04, 0.10), (0.06, 0.10)]))
    >>> tool.point(fb.igm(robot, path(0.0)[0])).round(12).tolist()
    [0.04, 0.1]
    """

    leg: int
    along: float = 0.0
    across: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "leg", whole(1, 2)(self.leg, "Tool: leg"))
        for name in ("along", "across"):
            object.__setattr__(self, name, number(getattr(self, name), f"Tool: {name}"))

    def __repr__(self) -> str:
        where = f"{self.along:.6g} m along it, {self.across:.6g} m to its left"
        return one_line("Tool", f"on the distal bar of leg {self.leg}", where)

    @overload
    def path(self, robot: FiveBar, path: Path, working: ArrayLike = ...) -> Path: ...

    @overload
    def path(self, robot: FiveBar, path: Trajectory, working: ArrayLike = ...) -> LedTrajectory: ...

    def path(self, robot: FiveBar, path: Any, working: ArrayLike = (-1, -1)) -> Any:
        """Return the path of joint C that leads the tool along a path.

        Its derivatives are exact to the third order. Its s, knots, feeds and pen, or its times,
        are those of the tool, and `drawn` is the tool's path again.

        Parameters
        ----------
        robot : FiveBar
        path : Path or Trajectory
            Of the tool. A Trajectory is checked at 2001 times.
        working : (2,)
            Working modes, of the robot at C.

        Returns
        -------
        Path or LedTrajectory

        Raises
        ------
        UnreachableError
            The tool does not reach the path in these modes, or folds over its bar; the message
            says where.
        """
        return MountedTool(self, robot, working).led(path)

    def pose(
        self,
        robot: FiveBar,
        point: ArrayLike,
        working: ArrayLike = (-1, -1),
        unreachable: str = "raise",
    ) -> Pose:
        """Return the pose in which the tool is at a point (*batch, 2), m: `igm` of the tool.

        Raises
        ------
        UnreachableError, SingularityError
            The tool or the robot does not reach it.
        """
        return MountedTool(self, robot, working).pose(point, unreachable)

    def point(self, pose: Pose) -> np.ndarray:
        """Return where the tool is (*batch, 2), m, in a pose of its robot."""
        ux, uy = pose.u2[self.leg - 1]
        x, y = pose.point
        return np.stack(
            [x + self.along * ux - self.across * uy, y + self.along * uy + self.across * ux],
            axis=-1,
        )

    def motion(self, accelerations: Accelerations) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the tool's position, m, velocity, m/s, and acceleration, m/s^2, each (*batch, 2).

        With phi the angle of its bar and r = along u + across v the tool from joint C, both are
        those of C and phi' (i r), phi'' (i r) - phi'^2 r, i r being r turned by a quarter turn.
        """
        rates = accelerations.rates
        place = self.point(rates.pose)
        velocity, turn, arm = self._velocity(rates)
        angular = accelerations.q_ddot + accelerations.q_passive_ddot
        turn_dot = angular[..., self.leg - 1, None]
        acceleration = accelerations.xi_ddot + turn_dot * _turned(arm) - turn**2 * arm
        return place, velocity, acceleration

    def _velocity(self, rates):
        """Return the tool's velocity, the rate of its bar's angle, and its way from joint C."""
        turn = (rates.q_dot + rates.q_passive_dot)[..., self.leg - 1, None]
        arm = self.point(rates.pose) - rates.pose.xi
        return rates.xi_dot + turn * _turned(arm), turn, arm

    def jacobian(self, pose: Pose) -> np.ndarray:
        """Return the tool's Jacobian (*batch, 2, 2): its velocity is J q'."""
        columns = []
        for q_dot, xi_dot in zip(np.eye(2), np.moveaxis(pose.J, -1, 0)):
            one = np.broadcast_to(q_dot, xi_dot.shape)
            rates = Rates(pose, (one[..., 0], one[..., 1]), (xi_dot[..., 0], xi_dot[..., 1]))
            columns.append(self._velocity(rates)[0])
        return np.stack(columns, axis=-1)


def _turned(vector):
    """Return vectors (*batch, 2) turned by a quarter turn."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


@dataclass(frozen=True, eq=False, repr=False)
class LedTrajectory(Trajectory):
    """A motion of joint C that leads a tool, from `Tool.path`.

    drawn: the motion of the tool; tool: (leg, along, across), m; working: the working modes.
    """

    drawn: Trajectory = None  # type: ignore[assignment]  # `MountedTool.reference` gives it
    tool: tuple[int, float, float] = (1, 0.0, 0.0)
    working: tuple[int, int] = (-1, -1)


@dataclass(frozen=True)
class MountedTool:
    """A tool on its robot, in working modes: the map from the tool's place T to that of C.

    frame: from the robot's own frame, in which all points are, to the one in which messages name
    them.

    T closes a dyad of the proximal bar l1 and of r = |l2 + along + i across| on the base joint.
    Its elbow E gives C = T + k (T - E) on complex numbers, k = l2 / (l2 + along + i across) - 1.
    """

    tool: Tool
    robot: FiveBar
    working: Any
    frame: Placement = Placement()

    def __post_init__(self) -> None:
        instance(FiveBar)(self.robot, "Tool: robot")
        object.__setattr__(self, "working", modes(2)(self.working, "Tool: working"))
        if self.reach < SHORTEST * self._bars[1]:
            raise ValueError(
                f"Tool: along = {self.tool.along:g} m and across = {self.tool.across:g} m put it on"
                " its elbow, where its place does not say how the bar turns"
            )

    def refuse_other(self, robot: object, working: object, name: str) -> None:
        """ValueError where a path of this tool is used with another robot, or in other modes."""
        if (robot, working) != (self.robot, self.working):
            raise ValueError(
                f"{name}: the path leads a tool of {self.robot!r} in working modes {self.working};"
                f" for {robot!r} in {working}: tool.path(robot, path.drawn, working)"
            )

    @property
    def _drive(self):
        return self.robot.drives[self.tool.leg - 1]

    @property
    def _bars(self):
        return self._drive.length, self.robot.distal[self.tool.leg - 1]

    @property
    def from_elbow(self) -> complex:
        """Way from the elbow to the tool, m, where the bar is along x."""
        return complex(self._bars[1] + self.tool.along, self.tool.across)

    @property
    def _mode(self):
        return self.working[self.tool.leg - 1]

    @property
    def branch(self):
        """Of the tool's dyad: that of the leg, unless the tool is behind the elbow."""
        return self._mode if self.from_elbow.real >= 0 else -self._mode

    @property
    def reach(self) -> float:
        """Distance of the tool from its elbow, m."""
        return abs(self.from_elbow)

    @property
    def factor(self) -> complex:
        """k of the map C = T + k (T - E)."""
        return self._bars[1] / self.from_elbow - 1

    @property
    def _radii(self):
        """The least and the largest distance, m, of the tool from the base joint."""
        l1, _ = self._bars
        r = self.reach
        return abs(l1 - r), l1 + r

    def joint(self, point: ArrayLike) -> np.ndarray:
        """Return where C is (*batch, 2), m, with the tool at points (*batch, 2).

        nan where the tool is out of reach, and where it folds over its bar.
        """
        point = finite_numbers(point, "Tool: point")
        if point.shape[-1:] != (2,):
            raise ValueError(f"Tool: point must be (*batch, 2), not {shown(point.shape)}")
        dyad = self._drive.close((point[..., 0], point[..., 1]), self.reach, self.branch)
        ux, uy = dyad.last
        along = self.reach * (ux + 1j * uy)
        z = point @ (1, 1j) + self.factor * along
        bar = (1 + self.factor) * along
        # The bar's own part of C counts for nothing in a product with the bar.
        sine = ((z - self._drive.x).conjugate() * bar).imag
        folded = self._mode * sine >= 0
        joint = pairs(z)
        return np.where(folded[..., None], np.nan, joint)

    def pose(self, point: ArrayLike, unreachable: str = "raise") -> Pose:
        """Return the pose with the tool at a point (*batch, 2): `Tool.pose`."""
        joint = self.joint(point)
        lost = np.isnan(joint[..., 0])
        refuses = raise_or_nan(unreachable) == "raise"
        if refuses and lost.any():
            _, index = first_index(lost)
            points = np.asarray(point, float)
            lost_point = points[index]
            reason = self.reason(lost_point)
            raise UnreachableError(f"Tool: {reason}", self.gap(lost_point), index or None)
        legs = zip(self.robot.drives, self.robot.distal)
        far = 10 * sum(drive.length + bar for drive, bar in legs)
        # Out of all reach, as `igm` takes no nan.
        joint = np.where(lost[..., None], far, joint)
        return igm(self.robot, joint, self.working, unreachable)

    def led(self, path: Any) -> Any:
        """Return the Path or LedTrajectory of joint C: `Tool.path`."""
        if isinstance(instance(Path, Trajectory)(path, "Tool: path"), Path):
            return replace(path, tool=self)
        return self.reference(path)

    def series(self, x: Series, y: Series) -> tuple[Series, Series, Series]:
        """Return the coordinates of C with all derivatives that the tool's have.

        The third is -working l1 l2 sin q_i2, which is above 0 where the leg keeps its mode.
        """
        l1, _ = self._bars
        r = self.reach
        k = self.factor
        rx = x - self._drive.x
        (dx, dy), along, across = dyad_series(rx, y, l1, r, self.branch)
        ex, ey = rx - dx, y - dy  # T - E
        sine = across * (1 + k.real) - (along - l1 * l1) * k.imag
        keeps = sine * self._mode
        return (x + ex * k.real - ey * k.imag, y + ey * k.real + ex * k.imag, keeps)

    def reference(self, drawn: Trajectory) -> LedTrajectory:
        """Return the motion of joint C that leads the tool as `drawn` has it."""
        t = drawn.start + drawn.duration * np.linspace(0.0, 1.0, CHECKED)
        point = drawn(t)[0]
        lost = np.isnan(self.joint(point)[:, 0])
        if lost.any():
            first = point[lost.argmax()]
            when = t[lost.argmax()]
            words = f"Tool: at t = {when:.6g} s {self.reason(first)}"
            raise UnreachableError(words, self.gap(first))
        motion = partial(self._motion_of_joint, drawn)
        own = drawn, astuple(self.tool), self.working
        return LedTrajectory(drawn.start, drawn.duration, motion, drawn.notes, *own)

    def _motion_of_joint(self, drawn, t):
        found = np.array(drawn(t))
        carried = self.carried(found.reshape(3, -1, 2)).reshape(found.shape)
        return np.concatenate(carried, axis=-1)

    def carried(self, found: np.ndarray) -> np.ndarray:
        """Return C and its derivatives (k, n, 2) from those of the tool, of orders 0 to k - 1."""
        factorials = FACTORIALS[: len(found)]
        terms = found / factorials[..., None]
        rounding = EPS * np.abs(terms)
        x = Series(terms[..., 0], rounding[..., 0])
        y = Series(terms[..., 1], rounding[..., 1])
        cx, cy, _ = self.series(x, y)
        return np.stack([cx.m * factorials, cy.m * factorials], axis=-1)

    def refuse_unreached(self, path: Path) -> None:
        """Refuse a path of the tool, unless enclosures prove that it is reached in the modes.

        UnreachableError with a place that is not.
        """
        piece = np.arange(len(path.pieces))
        first = np.zeros(len(piece))
        last = np.array([each.length for each in path.pieces])
        least = FINEST * path.length
        self._refuse_first(path, path.knots)
        while len(piece):
            x, y = place_series(path, piece, first, last, 1)
            _, _, keeps = self.series(x, y)
            left = ~(keeps.m[0] > keeps.r[0])  # nan is left, too
            piece = piece[left]
            first = first[left]
            last = last[left]
            middle = (first + last) / 2
            places = path.knots[piece] + middle
            self._refuse_first(path, places)
            short = last - first < least
            if short.any():
                self._refuse(path, places[short].min())
            piece = np.tile(piece, 2)
            first = np.concatenate([first, middle])
            last = np.concatenate([middle, last])

    def _refuse_first(self, path, s):
        s = np.sort(s)
        point = path.drawn(s)[0]
        joint = self.joint(point)
        lost = ~np.isfinite(joint).all(axis=1)
        if lost.any():
            self._refuse(path, s[np.argmax(lost)])

    def _refuse(self, path, s):
        point = path.drawn(s)[0]
        line = path.line_of(s)
        of_file = f" (line {line})" if line else ""
        raise UnreachableError(
            f"Tool: at s = {s:.6g} m of the path{of_file} {self.reason(point)}", self.gap(point)
        )

    def gap(self, point: np.ndarray) -> float:
        """Return by how much, m, a point (2,) is out of the reach of proximal bar and tool."""
        l1, _ = self._bars
        inner, _ = self._radii
        distance = self._distance(point)
        return max(distance - l1 - self.reach, inner - distance, 0.0)

    def _distance(self, point):
        """Return the distance, m, of a point (2,) from the base joint."""
        x, y = point
        return float(np.hypot(x - self._drive.x, y))

    def reason(self, point: np.ndarray) -> str:
        """Return in words why the tool is not at a point (2,) in these modes."""
        inner, outer = self._radii
        x, y = self.frame(point)
        where = f"({x:.6g}, {y:.6g}) m"
        if self.gap(point):
            return (
                f"the tool does not reach {where}: {self._distance(point):.6g} m from base joint"
                f" {self.tool.leg}, where from {inner:.6g} to {outer:.6g} m can be reached"
            )
        return (
            f"the tool at {where} folds over its bar: leg {self.tool.leg} is in line with its tool"
            f" or leaves its working mode {self._mode:+d}; keep the path off this place, or take"
            f" the other mode"
        )
