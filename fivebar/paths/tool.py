"""A tool on a distal bar: a pen, a hotend or a laser that is not in the robot's last joint.

The robot is modelled up to the joint C of its two distal bars. A tool rigid on one of them is led
along a path by leading C along another one, which this module computes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..base.backend import EPS, finite_numbers, first_index
from ..base.checks import instance, modes, number, shown, whole
from ..base.errors import UnreachableError
from ..base.representation import one_line
from ..models.dyads import cross
from ..models.geometry import igm
from ..models.pose import Pose
from ..models.robots import FiveBar
from ..models.unreachable import raise_or_nan
from ..singularities.loci import singularity_loci
from ..singularities.margins import Singularity
from .curve import Path
from .timing.enclosures import Series, place_series

FACTORIALS = np.array([1.0, 1.0, 2.0, 6.0])[:, None]
FINEST = 1e-9  # of a path's length: a shorter stretch is not divided any more
FOLD = 721  # points of a circle on which the tool folds
NEAR = 1e-12  # of its radius, by which it is drawn inside
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

    def path(self, robot: FiveBar, path: Path, working: ArrayLike = (-1, -1)) -> Path:
        """Return the path of joint C that leads the tool along a path.

        Its derivatives are exact to the third order. Its s, knots, feeds and pen are those of the
        tool, and `drawn` is the tool's path again.

        Parameters
        ----------
        robot : FiveBar
        path : Path
            Of the tool.
        working : (2,)
            Working modes, of the robot at C.

        Returns
        -------
        Path

        Raises
        ------
        UnreachableError
            The tool does not reach the path in these modes, or folds over its bar; the message
            says where.
        """
        mounted = MountedTool(self, robot, modes(2)(working, "Tool: working"))
        return replace(instance(Path)(path, "Tool: path"), tool=mounted)

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
        mounted = MountedTool(self, robot, modes(2)(working, "Tool: working"))
        joint = mounted.joint(point)
        lost = np.isnan(joint[..., 0])
        if raise_or_nan(unreachable) == "raise" and lost.any():
            _, index = first_index(lost)
            lost_point = np.asarray(point, float)[index]
            reason = mounted.reason(lost_point)
            raise UnreachableError(f"Tool: {reason}", mounted.gap(lost_point), index or None)
        far = 10 * sum(drive.length + bar for drive, bar in zip(robot.drives, robot.distal))
        joint = np.where(lost[..., None], far, joint)  # out of all reach, as `igm` takes no nan
        return igm(robot, joint, mounted.working, unreachable)

    def point(self, pose: Pose) -> np.ndarray:
        """Return where the tool is (*batch, 2), m, in a pose of its robot."""
        x, y = pose.u2[self.leg - 1]
        return np.stack(
            [
                pose.point[0] + self.along * x - self.across * y,
                pose.point[1] + self.along * y + self.across * x,
            ],
            axis=-1,
        )

    def loci(self, robot: FiveBar, working: ArrayLike = (-1, -1)) -> list[ToolLocus]:
        """Return the singularity loci as the tool sees them in working modes.

        They are the images of the exact curves of joint C, and the circles on which the tool folds
        over its bar: the proximal bar is in line with the tool there, and the joint may not turn
        as fast as the tool wants.
        """
        mounted = MountedTool(self, robot, modes(2)(working, "Tool: working"))
        found = []
        for piece in singularity_loci(robot).task:
            if mounted.working in piece.working and len(piece.points) > 1:
                pose = igm(robot, piece.points, mounted.working, unreachable="nan")
                points = self.point(pose)
                arm = points - pose.elbows[:, self.leg - 1]
                sine = cross(pose.legs[self.leg - 1].direction, arm.T) / mounted.reach
                beyond = mounted.branch * sine > NEAR  # of a fold of the tool
                points = np.where(beyond[:, None], np.nan, points)
                if np.isfinite(points).any():
                    found.append(ToolLocus(piece.type, piece.kind, points))
        for inside in mounted.folds:
            pose = self.pose(robot, inside, mounted.working, unreachable="nan")
            points = np.where(np.isfinite(pose.det_A)[:, None], inside, np.nan)
            if np.isfinite(points).any():
                found.append(ToolLocus(Singularity.SERIAL, "folded tool", points))
        return found

    def jacobian(self, pose: Pose) -> np.ndarray:
        """Return the tool's Jacobian (*batch, 2, 2): its velocity is J q'."""
        u = np.stack(pose.u2[self.leg - 1], axis=-1)
        v = np.stack([-u[..., 1], u[..., 0]], axis=-1)
        bar = pose.robot.distal[self.leg - 1]
        drive = pose.robot.drives[self.leg - 1]
        turns = np.array(pose.J)
        tangent = drive.tangent(pose.legs[self.leg - 1].direction)
        turns[..., self.leg - 1] -= np.stack(np.broadcast_arrays(*tangent), axis=-1)
        # The rate of the bar's angle by each joint's rate: v . (xi' - P' q') / l.
        rate = np.einsum("...c,...cj->...j", v, turns) / bar
        beside = self.along * v - self.across * u
        return pose.J + beside[..., :, None] * rate[..., None, :]


class ToolLocus(NamedTuple):
    """A curve on which the tool is singular: its type, its kind as of a `Locus` or "folded tool",
    and points (n, 2), m, nan where the robot is not.
    """

    type: Singularity
    kind: str
    points: np.ndarray


@dataclass(frozen=True)
class MountedTool:
    """A tool on its robot, in working modes: the map from the tool's place T to that of C.

    T closes a dyad of the proximal bar l1 and of r = |l2 + along + i across| on the base joint.
    Its elbow E gives C = T + k (T - E) on complex numbers, k = l2 / (l2 + along + i across) - 1.
    """

    tool: Tool
    robot: FiveBar
    working: tuple[int, int]

    def __post_init__(self) -> None:
        instance(FiveBar)(self.robot, "Tool: robot")
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
    def _from_elbow(self):
        return complex(self._bars[1] + self.tool.along, self.tool.across)

    @property
    def _mode(self):
        return self.working[self.tool.leg - 1]

    @property
    def branch(self):
        """Of the tool's dyad: that of the leg, unless the tool is behind the elbow."""
        return self._mode if self._from_elbow.real >= 0 else -self._mode

    @property
    def reach(self) -> float:
        """Distance of the tool from its elbow, m."""
        return abs(self._from_elbow)

    @property
    def factor(self) -> complex:
        """k of the map C = T + k (T - E)."""
        return self._bars[1] / self._from_elbow - 1

    @property
    def folds(self) -> tuple[np.ndarray, np.ndarray]:
        """Points (n, 2), m, of the circles on which proximal bar and tool are in line, rounded to
        where they are reached.
        """
        l1, r = self._bars[0], self.reach
        turn = np.linspace(0.0, 2 * np.pi, FOLD)
        circle = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        base = np.array([self._drive.x, 0.0])
        return base + (l1 + r) * (1 - NEAR) * circle, base + abs(l1 - r) * (1 + NEAR) * circle

    def joint(self, point: ArrayLike) -> np.ndarray:
        """Return where C is (*batch, 2), m, with the tool at points (*batch, 2).

        nan where the tool is out of reach, and where it folds over its bar.
        """
        point = finite_numbers(point, "Tool: point")
        if point.shape[-1:] != (2,):
            raise ValueError(f"Tool: point must be (*batch, 2), not {shown(point.shape)}")
        dyad = self._drive.close((point[..., 0], point[..., 1]), self.reach, self.branch)
        along = self.reach * (dyad.last[0] + 1j * dyad.last[1])
        z = point @ (1, 1j) + self.factor * along
        bar = (1 + self.factor) * along
        crank = z - bar - self._drive.x
        folded = self._mode * (crank.conjugate() * bar).imag >= 0
        return np.where(folded[..., None], np.nan, np.stack([z.real, z.imag], axis=-1))

    def series(self, x: Series, y: Series) -> tuple[Series, Series, Series]:
        """Return the coordinates of C with all derivatives that the tool's have.

        The third is -working l1 l2 sin q_i2, which is above 0 where the leg keeps its mode.
        """
        l1, _ = self._bars
        r = self.reach
        k = self.factor
        rx = x - self._drive.x
        square = rx * rx + y * y
        lead = (square + (r - l1) * (r + l1)) * 0.5
        heron = ((l1 + r) ** 2 - square) * (square - (l1 - r) ** 2)
        across = heron.sqrt() * (0.5 * self.branch)
        scale = square.inverse()
        # T - E, whose products with T's way from the base joint are `lead` and -`across`.
        ex = (lead * rx + across * y) * scale
        ey = (lead * y - across * rx) * scale
        keeps = (across * (1 + k.real) - (lead - r * r) * k.imag) * self._mode
        return (
            x + ex * k.real - ey * k.imag,
            y + ey * k.real + ex * k.imag,
            keeps,
        )

    def carried(self, found: np.ndarray) -> np.ndarray:
        """Return C and its first three derivatives (4, n, 2) from those of the tool."""
        m = found / FACTORIALS[..., None]
        x, y = (Series(m[..., axis], EPS * np.abs(m[..., axis])) for axis in (0, 1))
        c = self.series(x, y)[:2]
        return np.stack([each.m * FACTORIALS for each in c], axis=-1)

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
            keeps = self.series(*place_series(path, piece, first, last, 1))[2]
            left = ~(keeps.m[0] > keeps.r[0])  # nan is left, too
            piece, first, last = piece[left], first[left], last[left]
            middle = (first + last) / 2
            places = path.knots[piece] + middle
            self._refuse_first(path, places)
            if (short := last - first < least).any():
                self._refuse(path, places[short].min())
            piece = np.tile(piece, 2)
            first, last = np.concatenate([first, middle]), np.concatenate([middle, last])

    def _refuse_first(self, path, s):
        s = np.sort(s)
        lost = ~np.isfinite(self.joint(path.drawn(s)[0])).all(axis=1)
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
        l1, r = self._bars[0], self.reach
        distance = float(np.hypot(point[0] - self._drive.x, point[1]))
        return max(distance - l1 - r, abs(l1 - r) - distance, 0.0)

    def reason(self, point: np.ndarray) -> str:
        """Return in words why the tool is not at a point (2,) in these modes."""
        l1, r = self._bars[0], self.reach
        distance = float(np.hypot(point[0] - self._drive.x, point[1]))
        where = f"({point[0]:.6g}, {point[1]:.6g}) m"
        if self.gap(point):
            return (
                f"the tool does not reach {where}: {distance:.6g} m from base joint"
                f" {self.tool.leg}, where from {abs(l1 - r):.6g} to {l1 + r:.6g} m can be reached"
            )
        return (
            f"the tool at {where} folds over its bar: leg {self.tool.leg} is in line with its tool"
            f" or leaves its working mode {self._mode:+d}; keep the path off this place, or take"
            f" the other mode"
        )
