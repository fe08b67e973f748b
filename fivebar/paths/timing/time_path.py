"""`time_path`: how fast a given path can be followed, with a proof of how much faster it cannot
be.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import instance, modes, number, optional, seconds, takes
from ...base.checks import robot as must_be_robot
from ...constraints.constraints import Keep
from ...constraints.path_check import SAMPLES
from ...constraints.violations import broken
from ...models.dynamics import gravity_torques
from ...models.geometry import igm
from ...models.physics import physics_of
from ..curve import Path
from .constraint_rows import Limits
from .jerk import refuse_kinks, smoothed
from .mesh import mesh_of
from .refusals import where
from .slower import slowed
from .solve import TimingError, refined
from .timed_path import TimedPath

if TYPE_CHECKING:
    from ...models.robots import Robot

AMPLE = 4.0  # times the torques that hold the robot, where none are given


@takes(
    robot=must_be_robot,
    path=instance(Path, what="a Path, as fivebar.path gives"),
    duration=optional(seconds),
    working=modes(2),
    keep=optional(instance(Keep)),
)
def time_path(
    robot: Robot,
    path: Path,
    duration: float | None = None,
    *,
    torque_limit: ArrayLike | None = None,
    joint_speed_limit: ArrayLike | None = None,
    joint_acceleration_limit: ArrayLike | None = None,
    speed_limit: float | None = None,
    acceleration_limit: float | None = None,
    jerk_limit: float | None = None,
    working: tuple[int, int] = (-1, -1),
    keep: Keep | None = None,
    gap: float = 1e-3,
    max_time: float = 60.0,
) -> TimedPath:
    """Follow a given path in the least time under limits, through Type 2 where it leads there:
    TimedPath.

    The limits hold throughout, not at samples: `timing_upper` says how. No motion along the path
    under them takes less than `lower_bound`: `timing_lower` says why. Both hold with gravity and
    friction, viscous and dry, up to rounding, for which limits are shifted by 1e-9 of them. A
    jerk_limit is kept too, at places as close as one likes but not by proof, and near the fastest
    motion without a promise (`timing_jerk`); the lower bound is then that without it.

    path: a Path. It rests at both ends, where its direction or the pen changes, and where a dwell
        is asked for.
    duration: s, asked for; None: the least. A longer one is reached by smaller torques and
        accelerations: all their limits are lowered by one factor, as far as the duration allows.
            Without such limits: the least peak torque.
    torque_limit, joint_speed_limit, joint_acceleration_limit: N m, rad/s and rad/s^2, one number or
    one per joint. speed_limit, acceleration_limit, jerk_limit: of the end-effector, m/s, m/s^2 and
    m/s^3; the path's own feeds count
        too.
    working: the modes that are kept; the assembly mode changes where the path crosses Type 2.
    keep: what the path must keep, in whatever time: looked at first, as `check_path` does.
    gap: to which both bounds are brought together, upper / lower - 1, unless too much work is done
        before. That is counted (`timing_solve.LOOKS`): the same is found on every machine, however
        busy.
    max_time: s of the processor, after which it takes what it has; the count is mostly full before.
    UnreachableError or SingularityError where the path leaves the workspace, touches Type 1, or
    Type 2 without crossing it; TimingError where no motion keeps the limits; all with s and place.
    ValueError for what cannot be asked, and for a path that does not keep what it must, with the
    places.
    """
    asked = Limits.checked(
        torque=torque_limit,
        joint_speed=joint_speed_limit,
        joint_acceleration=joint_acceleration_limit,
        speed=speed_limit,
        acceleration=acceleration_limit,
        jerk=jerk_limit,
    )
    gap, max_time = (
        number(gap, "gap", 1e-7, 1.0),
        number(max_time, "max_time", 0.0, math.inf, above=True),
    )
    if duration is None and not asked.forces:
        raise ValueError(
            "time_path: a least time needs a torque_limit, acceleration_limit or"
            " joint_acceleration_limit: without, it is that of infinite forces"
        )
    if asked.jerk is not None:
        refuse_kinks(path)
    until = time.thread_time() + max_time
    if keep is not None:
        samples = np.linspace(0.0, path.length, SAMPLES)
        for each in broken(robot, path.at_unit_speed, working, keep, samples)[:1]:
            what = f"{each.what} is not kept from s = {each.time:.9g} m, by at most {each.by:.6g}"
            raise ValueError(f"time_path: {what} at {where(path, each.worst)}")
    mesh = mesh_of(robot, path, working)
    _refuse_falling(mesh, asked)
    if asked.jerk is not None:
        if not asked.forces:
            raise ValueError(
                "time_path: jerk_limit needs a torque_limit or acceleration_limit beside it"
            )
        return smoothed(_timed(asked, *refined(mesh, asked, gap, until)), duration)
    if duration is None:
        return _timed(asked, *refined(mesh, asked, gap, until))
    rest = math.fsum(stop.seconds for stop in path.stops)
    if not duration > rest:
        raise ValueError(
            f"time_path: the path rests for {rest:g} s, which leaves no time to move in"
            f" {duration:g} s"
        )
    limits = asked if asked.forces else _ample(mesh, asked, duration - rest)
    mesh, found = refined(mesh, limits, gap, until)
    least, lower = found.time.sum() + rest, found.above.time.sum() + rest
    if duration < least:
        short = f"{lower - duration:.4g} s below what is proved to be the least, {lower:.6g} s"
        if duration >= lower or not asked.forces:
            short = (
                f"less than {least:.6g} s, the least that was found (proved: none below"
                f" {lower:.6g} s)"
            )
        raise TimingError(
            f"time_path: duration = {duration:g} s is {short}, under these limits",
            0.0,
            duration < lower,
        )
    mesh, slow = slowed(mesh, limits, duration - rest, gap, until)
    return _timed(
        asked,
        mesh,
        slow._replace(above=found.above if asked.forces else slow.above),
        lower * asked.forces,
    )


def _ample(mesh, limits, wanted):
    """Torques in which the motion takes about half of the time that is wanted."""
    hold = 1.0
    if (physics := physics_of(mesh.robot)) is not None and physics.has_gravity:
        ends = [
            gravity_torques(igm(mesh.robot, mesh.path(stop.s)[0], mesh.working))
            for stop in mesh.path.stops
        ]
        hold += AMPLE * float(np.abs(ends).max())
    before = math.inf
    while True:
        limits = replace(limits, torque=(hold, hold))
        needs = refined(mesh, limits, 0.5, math.inf)[1].time.sum()
        if needs < wanted / 2 or needs > 0.99 * before:  # speeds may limit it, too
            return limits
        hold, before = hold * max(2.0, 4 * (needs / wanted) ** 2), needs


def _timed(limits, mesh, solved, lower=None):
    if lower is None:
        lower = float(solved.above.time.sum()) + math.fsum(stop.seconds for stop in mesh.path.stops)
    return TimedPath(
        mesh.robot,
        mesh.path,
        mesh.working,
        limits,
        mesh.stretches.piece,
        mesh.stretches.first,
        solved.x,
        solved.bent,
        lower,
        mesh.crossing,
        solved.top,
        solved.above.x,
    )


def _refuse_falling(mesh, limits):
    """Where it must rest, the robot must be held."""
    physics = physics_of(mesh.robot)
    if limits.torque is None or physics is None or not physics.has_gravity:
        return
    for stop in mesh.path.stops:
        tau = gravity_torques(igm(mesh.robot, mesh.path(stop.s)[0], mesh.working))
        missing = np.abs(tau) - np.array(physics.coulomb) - limits.torque
        if (missing > 0).any():
            k, words = int(np.argmax(missing)), mesh.robot.words
            raise TimingError(
                "time_path: the limits cannot hold the robot at rest at"
                f" {where(mesh.path, stop.s)}: {words.joints[k]} needs {abs(tau[k]):.4g}"
                f" {words.effort_unit}, its torque_limit is {limits.torque[k]:.4g}",
                stop.s,
                True,
            )
