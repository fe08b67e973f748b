"""`time_path`: how fast a given path can be followed, with a proof of how much faster it cannot
be.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...base.checks import instance, modes, number, optional, seconds
from ...base.errors import warn
from ...base.robot_uses import takes_robot
from ...constraints.constraints import ON_POSES, Constraints, kept_by
from ...constraints.path_check import SAMPLES
from ...constraints.violations import broken
from ...models.dynamics import gravity_torques
from ...models.geometry import igm
from ..curve import Path
from .constraint_rows import Limits
from .jerk import enough, in_time, refuse_kinks, smoothed
from .mesh import mesh_of
from .refusals import where
from .slower import slowed
from .solve import TimingError, refined
from .timed_path import TimedPath

if TYPE_CHECKING:
    from ...models.robots import Robot

SLOW = 0.01  # of its lower bound: a motion that takes so much longer is warned of
ROUGH = 0.01  # gap of motions that are averaged for a limit on jerk
JERKY = 2.0  # times its lower bound more, where the jerk is limited
AMPLE = 4.0  # times the torques that hold the robot, where none are given


@takes_robot(
    path=instance(Path, what="a Path, as fivebar.path gives"),
    duration=optional(seconds),
    working=modes(2),
    constraints=kept_by("fb.time_path"),
)
def time_path(
    robot: Robot,
    path: Path,
    duration: float | None = None,
    *,
    constraints: Constraints | None = None,
    working: tuple[int, int] = (-1, -1),
    gap: float = 1e-3,
    max_time: float = 60.0,
) -> TimedPath:
    """Return the fastest motion along a path, with a proof of how much faster none can be.

    The limits hold everywhere, not only at samples. No motion along the path within them takes less
    than `lower_bound`. Both hold with gravity and with viscous and dry friction, up to rounding:
    the limits are shifted by 1e-9 of themselves. A limit on jerk is kept at places as close as one
    likes, but without a proof; the lower bound is then that without it, or 0 of a jerk alone.

    Parameters
    ----------
    robot : FiveBar, Biglide or Machine
        Of a Machine, or of the name or file of one, the path is that of its tool in its measuring
        frame, and its constraints hold where the call names no others. The motion is that of joint
        C in the robot's own frame.
    path : Path
        It may cross Type 2. Of a tool's path, speed, acceleration and jerk are those of the tool.
        The motion rests at both ends, where the direction or the pen changes,
        and where the path asks for a dwell.
    duration : float, optional
        Wanted duration, s; the least by default. A longer duration lowers all limits on torques and
        accelerations by one factor; without such limits the peak torque is least.
    constraints : Constraints, optional
        torque, joint_speed, joint_acceleration, speed, acceleration and jerk limit the motion; the
        feeds of the path do, too. Constraints on poses are checked on the path first.
    working : (2,)
        Working modes that are kept. The assembly mode changes where the path crosses Type 2.
    gap : float
        Wanted duration / lower_bound - 1. The search ends before at a fixed count of work, the same
        on every machine.
    max_time : float
        Processor time, s, after which the best result so far is returned; TimingError if no motion
        was found by then.

    Returns
    -------
    TimedPath
        Call it with t (n,) s for (xi, xi_dot, xi_ddot), each (n, 2).

    Raises
    ------
    ValueError
        The problem makes no sense, or the path violates a constraint on poses.
    UnreachableError, SingularityError
        The path leaves the workspace, touches Type 1, or touches Type 2 without crossing it.
    TimingError
        No motion keeps the limits, or the duration is too short.

    Warns
    -----
    RuntimeWarning
        The search ended with a motion that takes over 1 % longer than the lower bound, and longer
        than `gap` asks for; or a limit on jerk makes it take three times as long.

    Examples
    --------
    >>> import fivebar as fb
    >>> path = fb.path([(0.09, 0.068), (0.05, 0.09)])
    >>> timed = fb.time_path(fb.FiveBar(), path, constraints=fb.Constraints(torque=0.05))
    >>> 1 - timed.lower_bound / timed.duration < 1e-3
    True
    """
    if path.tool is not None:
        path.tool.refuse_other(robot, working, "time_path")
    constraints = Constraints() if constraints is None else constraints
    asked = Limits.of(constraints)
    gap = number(gap, "gap", 1e-7, 1.0)
    max_time = number(max_time, "max_time", 0.0, math.inf, above=True)
    if duration is None and not (asked.forces or asked.jerk):
        raise ValueError(
            "time_path: a least time needs a torque, an acceleration, a joint_acceleration or a"
            " jerk among the constraints: without, it is that of infinite forces"
        )
    if asked == Limits(torque=asked.torque) and not any((*robot.inertias, robot.m)):
        raise ValueError(
            "time_path: this robot has no masses, so a torque limits nothing: give its masses, or a"
            " limit on the speed or acceleration"
        )
    if asked.jerk is not None:
        refuse_kinks(path)
    until = time.thread_time() + max_time
    if set(constraints.named) & set(ON_POSES):
        samples = np.linspace(0.0, path.length, SAMPLES)
        for each in broken(robot, path.at_unit_speed, working, constraints, samples)[:1]:
            what = f"{each.what} is not kept from s = {each.time:.9g} m, by at most {each.by:.6g}"
            raise ValueError(f"time_path: {what} at {where(path, each.worst)}")
    mesh = mesh_of(robot, path, working)
    if asked.jerk is not None:
        found = []
        lower = 0.0
        # Where the jerk rules, slower motions are often faster as means, but not always.
        for limits, feed in dict.fromkeys([(asked, path.feed), enough(path, asked, asked.jerk)]):
            if not limits.forces:
                continue
            own = replace(path, feed=feed)

            def with_feeds(feeds, limits=limits, own=own):
                slower = replace(mesh, path=replace(path, feed=tuple(feeds.tolist())))
                slow = _timed(asked, *refined(slower, limits, max(gap, ROUGH), until))
                return replace(slow, path=own)

            motion = _timed(asked, *refined(replace(mesh, path=own), limits, gap, until))
            if limits is asked:
                lower = motion.lower_bound
            found.append(smoothed(motion, with_feeds, until))
        best = min(found, key=lambda each: each.duration)
        best = replace(in_time(best, duration), path=path, lower_bound=lower)
        if duration is None and lower and best.gap > JERKY:
            warn(f"time_path: {slowness(best)}", RuntimeWarning)
        return best
    if duration is None:
        motion = _timed(asked, *refined(mesh, asked, gap, until))
        if motion.gap > max(gap, SLOW):
            warn(f"time_path: {slowness(motion)}", RuntimeWarning)
        return motion
    rest = math.fsum(stop.seconds for stop in path.stops)
    if not duration > rest:
        raise ValueError(
            f"time_path: the path rests for {rest:g} s, which leaves no time to move in"
            f" {duration:g} s"
        )
    limits = asked if asked.forces else _ample(mesh, asked, duration - rest)
    mesh, found = refined(mesh, limits, gap, until)
    least = found.time.sum() + rest
    lower = found.above.time.sum() + rest
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
    slow = slowed(mesh, limits, found, duration - rest)
    return _timed(asked, mesh, slow, lower * asked.forces)


def slowness(motion: TimedPath) -> str:
    """Say how much longer a motion may take than it has to."""
    least = f"{motion.lower_bound:.4g} s"
    words = f"it is proved only that none takes less than {least}"
    help_ = "A larger deviation at the corners may help"
    if motion.limits.jerk:
        words = f"that of {least} leaves the limit on jerk out"
        help_ += ", or none, with which it rests there"
    return (
        f"the motion takes {motion.duration:.4g} s, {100 * motion.gap:.3g} % over the bound:"
        f" {words}. {help_}"
    )


def _ample(mesh, limits, wanted):
    """Return torques in which the motion takes about half of the time that is wanted."""
    rests = mesh.path(np.array([stop.s for stop in mesh.path.stops]))[0]
    carry = gravity_torques(igm(mesh.robot, rests, mesh.working))
    hold = 1.0 + AMPLE * float(np.abs(carry).max())
    before = math.inf
    while True:
        limits = replace(limits, torque=(hold, hold))
        needs = refined(mesh, limits, 0.5, math.inf)[1].time.sum()
        if needs < wanted / 2 or needs > 0.99 * before:  # speeds may limit it, too
            return limits
        hold = hold * max(2.0, 4 * (needs / wanted) ** 2)
        before = needs


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
