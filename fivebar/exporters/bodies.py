"""Rigid bodies that move exactly as a robot's base parameters say: what simulators ask for."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..base.backend import is_symbolic
from ..base.errors import SingularityError, UnreachableError
from ..models.geometry import Pose, dgm
from ..models.parameters import parameters_of
from ..models.physics import loads_of

if TYPE_CHECKING:
    from ..models.robots import Biglide, FiveBar

SIDES = 36  # of the grid on which a pose that closes is looked for


class RigidBody(NamedTuple):
    """A rigid body: kg, its centre of mass along and across the bar from its first joint, m,
    inertia about it, kg m^2.

    The inertia is taken about all three axes: those out of the plane do no work, and so no triangle
        of them is broken.
    """

    mass: float
    x: float
    y: float
    inertia: float


@dataclass(frozen=True)
class Leg:
    """A leg of the opened tree: its drive's body, which turns or slides at (base, 0), and its
    distal bar's.

    proximal: length, m, None for a slider. viscous, coulomb: of the drive's joint and of the
        passive one.
    """

    number: int
    base: float
    proximal: float | None
    distal: float
    drive: RigidBody
    bar: RigidBody
    viscous: tuple[float, float]
    coulomb: float
    names: tuple[str, str, str, str]  # drive's body, bar's body, drive's joint, passive joint

    @property
    def crank(self) -> float:
        """Length of the proximal bar, m; 0 for a slider."""
        return self.proximal or 0.0

    @property
    def thin(self) -> float:
        """Of the distal bar where it is drawn as a box, m."""
        return self.distal / 20

    @property
    def box(self) -> str:
        """Sides, m, of the drive's body where that is drawn as a box: a bar, or a foot."""
        if self.proximal is None:
            return f"{2 * self.thin!r} {3 * self.thin!r} {self.thin!r}"
        return f"{self.proximal!r} {1.5 * self.thin!r} {self.thin!r}"


class _Moments(NamedTuple):
    """What a leg has beside the drive's inertia: first moments of the drive, kg m; inertia, kg m^2,
    and first moment across of the distal bar.
    """

    mx: float
    my: float
    zz: float
    across: float


def _moments(robot):
    if not robot.turns:
        return _Moments(0.0, 0.0, robot.zz1, robot.my1), _Moments(0.0, 0.0, robot.zz2, robot.my2)
    left = _Moments(robot.mx11, robot.my11, robot.zz12, robot.my12)
    return left, _Moments(robot.mx21, robot.my21, robot.zz22, robot.my22)


def legs_of(robot: FiveBar | Biglide) -> tuple[Leg, Leg]:
    """Return both legs of bodies with positive masses and inertias that together are the robot,
    exactly; ValueError if none.

    A bar of mass m2 with its centre at (x, y) and inertia J about its pivot is a mass m2 - s at the
    pivot, s = m2 x / l at the end-effector, J - s l^2 that turns with it and m2 y across it. So s_1
    + s_2 = m, and in each leg with k = zz / l_1^2 (of a slider its mass) what is left for the
    drive's body, (k + s - m2) l_1^2, and the bar's inertia about its centre, zz_2 + s l^2 - (s^2
    l^2 + my^2) / m2, have to be > 0. Such an m2 exists where s (zz_2 + k l^2) > my^2 - k zz_2: the
    masses s are put in the middle of what that allows, and m2 so too. Mass at a drive's own axis
    changes nothing: there is as much of it as its first moment needs.
    """
    if any(map(is_symbolic, parameters_of(robot))):
        raise ValueError(
            "bodies are made of a robot's numbers: this one has CasADi symbols as parameters"
        )
    if not any((robot.m, *robot.inertias)):
        names = ", ".join((*robot.words.inertias, "m"))
        raise ValueError(f"a simulator asks for masses, and this robot has none: give it {names}")
    least, moments = [], _moments(robot)
    for k, (own, bar) in enumerate(zip(moments, robot.distal)):
        carried = robot.inertias[k] / robot.drives[k].length ** 2
        inertia = own.zz + carried * bar**2
        if not inertia > 0:
            raise ValueError(
                f"no bodies of positive mass move as leg {k + 1} of this robot: the inertia of its"
                f" distal bar and {robot.words.inertias[k]}, scaled by the squared ratio of the"
                f" lengths, are together {inertia:g} kg m^2, but must be above 0"
            )
        least.append((own.across**2 - carried * own.zz) / inertia)
    if not robot.m > sum(least):
        raise ValueError(
            f"no bodies of positive mass move as this robot: m = {robot.m:g} kg must be above"
            f" {sum(least):.6g} kg, as only a share of it gives the distal bars an inertia; a small"
            " mass dm more than that is the smallest addition, and costs the drives dm J^T xi''"
        )
    spare = (robot.m - sum(least)) / 2
    return tuple(_leg(robot, k, share + spare, moments[k]) for k, share in enumerate(least))


def _leg(robot, k, share, own):
    """Leg k with this share of the end-effector's mass."""
    drive, bar, z = robot.drives[k], robot.distal[k], robot.inertias[k]
    along, turning, carried = share * bar, own.zz + share * bar**2, z / drive.length**2
    lightest, heaviest = (along**2 + own.across**2) / turning, share + carried
    mass = (lightest + heaviest) / 2
    second = RigidBody(
        mass, along / mass, own.across / mass, turning - (along**2 + own.across**2) / mass
    )
    left = carried - (mass - share)
    if robot.turns:
        l1 = drive.length
        x, y, inertia = own.mx - (mass - share) * l1, own.my, left * l1**2
        weight = left + 2 * (x * x + y * y) / inertia
        first = RigidBody(weight, x / weight, y / weight, inertia - (x * x + y * y) / weight)
    else:
        first = RigidBody(left, 0.0, 0.0, left * (bar / 10) ** 2)  # it does not turn
    words = robot.words
    parts = ("proximal", "distal") if robot.turns else ("foot", "bar")
    names = *(f"{part}{k + 1}" for part in parts), words.joints[k], words.passive[k]
    loads = loads_of(robot)
    viscous = loads.viscous[k], loads.elbows[k]
    length = drive.length if robot.turns else None
    return Leg(k + 1, drive.x, length, bar, first, second, viscous, loads.coulomb[k], names)


def start_of(robot: FiveBar | Biglide, start: Pose | None) -> Pose:
    """Return the pose in which a file shows the robot: the given one, else q = (0, 0), else the
    most regular of a grid.
    """
    if start is not None:
        if start.robot != robot:
            raise ValueError("start is a pose of another robot")
        if np.shape(start.q) != (2,) or not np.isfinite(start.q).all():
            raise ValueError(f"start must be one pose that closes, not q = {start.q!r}")
        return start
    try:
        return dgm(robot, (0.0, 0.0))
    except (UnreachableError, SingularityError):
        pass
    span = math.pi if robot.turns else sum(robot.distal)
    axis = np.linspace(-span, span, SIDES)
    poses = dgm(robot, np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1), unreachable="nan")
    margins = np.min(np.abs([poses.det_A, *poses.sines]), axis=0)
    if np.isnan(margins).all():
        raise ValueError(
            f"no pose of {SIDES}^2 closes in which to show the robot: give one as start"
        )
    return dgm(robot, poses.q[np.unravel_index(np.nanargmax(margins), margins.shape)])


def angles_of(pose: Pose) -> tuple[tuple[float, float], ...]:
    """Return per leg the coordinates of the drive's joint and of the passive one."""
    return tuple(zip(pose.q.tolist(), pose.q_passive.tolist()))


def angles_told(legs: tuple[Leg, Leg], pose: Pose) -> str:
    """Return all joints' coordinates by their names."""
    pairs = []
    for leg, values in zip(legs, angles_of(pose)):
        pairs += [f"{name} = {value!r}" for name, value in zip(leg.names[2:], values)]
    return ", ".join(pairs)
