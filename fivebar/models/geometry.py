"""Positions: the direct and inverse geometric models, which give a Pose."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..base.backend import check_modes, is_symbolic, unpack
from ..base.robot_uses import robot_for
from .dyads import RRR
from .pose import DrivenLeg, Pose, ReachedLeg
from .robots import KINDS
from .unreachable import raise_or_nan, refuse_open

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .robots import Robot

BLOCK = 8192  # poses


def dgm(robot: Robot, q: ArrayLike, assembly: ArrayLike = -1, unreachable: str = "raise") -> Pose:
    """Return the pose in which the active joints are at q: the direct geometric model.

    AMORO eq. 1-3, for any lengths.

    Parameters
    ----------
    robot : FiveBar or Biglide
    q : (*batch, 2), or a CasADi 2 x 1 vector
        Active joint coordinates, rad (biglide: m).
    assembly : int or (*batch,)
        Assembly mode, +1 or -1: which of the two points at the right distances is meant.
    unreachable : "raise" or "nan"
        What is done where the distal bars do not meet.

    Returns
    -------
    Pose

    Raises
    ------
    UnreachableError
        The distal bars do not meet; its `gap` says by how many metres.
    SingularityError
        Both elbows (feet) are in one point, and equal distal bars are free to turn about it.

    References
    ----------
    AMORO lab handout, Ecole Centrale de Nantes, 2021, eq. 1-3.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.dgm(fb.FiveBar(), (0.0, 0.0)).xi.round(6).tolist()
    [0.09, 0.067963]
    """
    if type(robot) not in KINDS:
        robot = robot_for("fb.dgm")(robot, "robot")
    q = unpack(q, "q")
    q, (branch,) = _with_modes(q, assembly, "assembly", count=1)
    pose = joint_pose(robot, q, branch)
    _refuse_open(unreachable, pose.point[0], pose)
    return pose


def joint_pose(robot: Robot, q: tuple, assembly) -> Pose:
    """`dgm` on components, unchecked: nan where it does not close."""
    if isinstance(q[0], np.ndarray) and q[0].size > BLOCK:
        xi = _joint_xi_in_blocks(robot, q, assembly)
        return Pose(robot, xi, lambda: _close_on_elbows(robot, q, assembly)[1:], True)
    xi, *parts = _close_on_elbows(robot, q, assembly)
    return Pose(robot, xi, lambda: parts, True)


def _close_on_elbows(robot, q, assembly):
    """End-effector, legs and the dyad on the two elbows."""
    left, right = robot.drives
    directions = left.direction(q[0]), right.direction(q[1])
    p1 = left.pivot(directions[0])
    p2 = right.pivot(directions[1])
    l12, l22 = robot.distal
    extent = left.extent(directions[0]) + right.extent(directions[1])
    dyad = RRR((p2[0] - p1[0], p2[1] - p1[1]), l12, l22, -assembly, extent)
    xi = p1[0] + l12 * dyad.first[0], p1[1] + l12 * dyad.first[1]
    first = DrivenLeg(left, q[0], directions[0], lambda: dyad.first)
    legs = first, DrivenLeg(right, q[1], directions[1], lambda: dyad.second)
    return xi, legs, (dyad,)


def _joint_xi_in_blocks(robot, q, assembly):
    """Return the end-effector alone, a stretch of the batch at a time that stays in the processor's
    cache.
    """
    flat = [np.ravel(component) for component in q]
    modes = np.asarray(assembly)
    if modes.ndim:
        modes = np.broadcast_to(modes, q[0].shape).ravel()
    xi = np.empty((2, flat[0].size))
    for start in range(0, flat[0].size, BLOCK):
        part = slice(start, start + BLOCK)
        xi[:, part] = _close_on_elbows(
            robot, [component[part] for component in flat], modes[part] if modes.ndim else assembly
        )[0]
    return xi[0].reshape(q[0].shape), xi[1].reshape(q[0].shape)


def igm(
    robot: Robot, xi: ArrayLike, working: ArrayLike = (-1, -1), unreachable: str = "raise"
) -> Pose:
    """Return the pose in which the end-effector is at xi: the inverse geometric model.

    AMORO eq. 7-9, for any lengths. Active angles lie in (-pi, pi].

    Parameters
    ----------
    robot : FiveBar or Biglide
    xi : (*batch, 2), or a CasADi 2 x 1 vector
        Position of the end-effector, m.
    working : (2,) or (*batch, 2)
        Working modes of the left and the right leg, +1 or -1.
    unreachable : "raise" or "nan"
        What is done where a leg does not reach xi.

    Returns
    -------
    Pose

    Raises
    ------
    UnreachableError
        A leg does not reach xi; its `gap` says by how many metres.
    SingularityError
        A leg of equal bars is folded on its base joint, and free to turn about it.

    References
    ----------
    AMORO lab handout, eq. 7-9.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.igm(fb.FiveBar(), (0.05, 0.09), working=(-1, -1)).q.round(6).tolist()
    [0.022595, 0.626149]
    """
    if type(robot) not in KINDS:
        robot = robot_for("fb.igm")(robot, "robot")
    xi = unpack(xi, "xi")
    xi, branches = _with_modes(xi, working, "working", count=2)
    pose = task_pose(robot, xi, branches)
    _refuse_open(unreachable, pose._dyads[0].first[0] + pose._dyads[1].first[0], pose)
    return pose


def task_pose(robot: Robot, xi: tuple, working: tuple) -> Pose:
    """`igm` on components, unchecked: nan where it does not close."""
    legs = tuple(
        reach(drive, xi, bar, mode) for drive, bar, mode in zip(robot.drives, robot.distal, working)
    )
    return Pose(robot, xi, lambda: (legs, tuple(leg.dyad for leg in legs)))


def reach(drive, xi: tuple, bar: float, working) -> ReachedLeg:
    """Return the leg of this drive and distal bar that ends in xi."""
    return ReachedLeg(drive, drive.close(xi, bar, working))


def _with_modes(v, modes, name, count):
    """Return components of v and `count` components of its modes; floats become arrays where the
    modes are a batch.
    """
    plain = (modes,) if count == 1 else modes
    if (
        isinstance(plain, tuple)
        and len(plain) == count
        and all(type(mode) is int and mode * mode == 1 for mode in plain)
    ):
        return v, plain  # the usual call, without the cost of arrays
    modes = check_modes(modes, name)
    if count == 2 and (modes.ndim == 0 or modes.shape[-1] != 2):
        got = f"{modes}" if modes.ndim == 0 else f"shape {modes.shape}"
        raise ValueError(f"{name} must be two modes in one argument, as (-1, -1), not {got}")
    if modes.ndim == count - 1:
        return v, tuple(int(m) for m in np.atleast_1d(modes))
    if is_symbolic(v[0]):
        raise ValueError(f"{name} must be plain ints for CasADi symbols, not a batch")
    if count == 1:
        split = (modes,)
    else:
        split = (np.ascontiguousarray(modes[..., 0]), np.ascontiguousarray(modes[..., 1]))
    try:
        *v, _ = np.broadcast_arrays(*v, split[0])
    except ValueError:
        raise ValueError(
            f"{name} of shape {modes.shape} does not fit a batch of shape {np.shape(v[0])}"
        ) from None
    return tuple(v), split


def _refuse_open(unreachable, found, pose):
    """Raise for the first pose in which a dyad does not close (`found` is nan there)."""
    if raise_or_nan(unreachable) == "nan" or is_symbolic(found) or not np.any(found != found):
        return
    refuse_open(np.isnan(found), pose)
