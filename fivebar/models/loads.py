"""Gravity, friction and the distal bars' own inertia in a motion: the loads beyond Z q'' and m
xi''.

With u, v along and across a distal bar, P(q) its elbow, j and my its grouped inertia and first
moment (`links`), the bar needs about its elbow the moment

    N = j phi'' - my u . (P'' q'^2 + P' q'' - g) + fv2 (phi' - q')

which is a force N / l v on the end-effector and its reaction N / l v . P' on the drive. The drive
also needs my v'' . P' = -my (b phi'' + v . P' phi'^2), and what its own weight and friction ask
for: T_i in all. With lambda the forces along the distal bars,

    m (xi'' - g) + sum N / l v = A^T lambda                tau = Z q'' + T + B lambda
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..base.backend import is_symbolic, pack, sign, sqrt
from .dyads import cross, dot
from .kinematics import Accelerations, Rates, a_pose, some_rates
from .physics import loads_of, named, physics_of
from .pose import Pose

if TYPE_CHECKING:
    from .robots import Robot


def refuse_weightless(robot: Robot, model: str) -> None:
    """Raise where there is gravity and nothing that it pulls."""
    physics = loads_of(robot)
    if physics.has_gravity and not any(
        map(named, (robot.m, *physics.levers, *physics.sides, *physics.across))
    ):
        names = ", ".join(
            name
            for name in ("m", "mx11", "my11", "mx21", "my21", "mf1", "mf2")
            if hasattr(robot, name)
        )
        raise ValueError(
            f"{model}: gravity = {physics.gravity} m/s² pulls at nothing: {names} are 0"
        )


def has_moving_mass(robot: Robot) -> bool:
    """Return whether the distal bars push at all."""
    return named(robot.m) or loads_of(robot).heavy or any(map(named, loads_of(robot).elbows))


def forces_and_torques(acc: Accelerations, slip: tuple | None = None) -> tuple[tuple, tuple]:
    """Return the force on the end-effector and the torques of the drives that a motion needs,
    without the terms of the forces lambda along the bars.

    On components. slip: per drive the direction in which it slips, 0 where it sticks; None: that of
    its rate.
    """
    rates, robot = acc.rates, acc.rates.pose.robot
    pose = rates.pose
    physics = physics_of(robot)
    if physics is None:
        x, y = acc._xi_ddot
        return (robot.m * x, robot.m * y), tuple(z * a for z, a in zip(robot.inertias, acc._q_ddot))
    gx, gy = physics.gravity
    force = [robot.m * (acc._xi_ddot[0] - gx), robot.m * (acc._xi_ddot[1] - gy)]
    torques = []
    for i, (drive, leg, bar) in enumerate(zip(robot.drives, pose.legs, robot.distal)):
        q_dot = rates._q_dot[i]
        q_ddot = acc._q_ddot[i]
        torque = (
            robot.inertias[i] * q_ddot
            + _weight(physics, drive, leg, i)
            + _friction(physics, i, q_dot, slip)
        )
        j = physics.turning[i]
        my = physics.across[i]
        rub = physics.elbows[i]
        if named(j) or named(my) or named(rub):
            b, across = pose._velocity_coefficients[i]
            phi_dot = rates.phi_dot[i]
            phi_ddot = acc.phi_ddot[i]
            pull = b * q_ddot + rates._centripetal[i][0] - (gx * leg.distal[0] + gy * leg.distal[1])
            resists = rub * drive.relative(phi_dot, q_dot)
            share = (j * phi_ddot - my * pull + resists) * (1 / bar)
            force[0], force[1] = force[0] - share * leg.distal[1], force[1] + share * leg.distal[0]
            torque = (
                torque - my * (b * phi_ddot + across * phi_dot * phi_dot) - share * across - resists
            )
        torques.append(torque)
    return tuple(force), tuple(torques)


def at_rest(rates: Rates) -> Accelerations:
    """Return the motion's Accelerations with q'' = 0 and xi'' = 0 (which need not close the loop):
    what is left is bias.
    """
    zero = 0.0 * rates._xi_dot[0]
    return Accelerations(rates, (zero, zero), (zero, zero))


def _weight(physics, drive, leg, i):
    """Return the torque that a drive needs against the weight of the bodies that it moves."""
    (gx, gy), mx, my = physics.gravity, physics.levers[i], physics.sides[i]
    x, y = (part * (1 / drive.length) for part in drive.tangent(leg.direction))
    return my * (gx * y - gy * x) - mx * (gx * x + gy * y)


def _friction(physics, i, q_dot, slip):
    """Return the torque that a drive needs against its viscous and Coulomb friction."""
    dry = physics.coulomb[i]
    if not named(dry):
        return physics.viscous[i] * q_dot
    if slip is not None:
        return physics.viscous[i] * q_dot + dry * slip[i]
    if named(physics.smoothing):
        return physics.viscous[i] * q_dot + dry * q_dot / sqrt(
            q_dot * q_dot + physics.smoothing * physics.smoothing
        )
    return physics.viscous[i] * q_dot + dry * (
        sign(q_dot, 0.0) if is_symbolic(q_dot) else np.sign(q_dot)
    )


def potential(pose: Pose) -> np.ndarray:
    """Return the potential energy, 0 without gravity.

    V = -m g . xi - sum_i (mx_i1 u_i1 + my_i1 v_i1 + my_i2 v_i2) . g; of a biglide's foot -mf_i g_y
    q_i.

    Parameters
    ----------
    pose : Pose

    Returns
    -------
    (*batch,), J

    Examples
    --------
    >>> import fivebar as fb
    >>> robot = fb.FiveBar(gravity=(0.0, -9.81))
    >>> round(float(fb.potential(fb.igm(robot, (0.05, 0.1)))), 4)  # m g y
    0.4905
    """
    a_pose(pose, "pose")
    robot, physics = pose.robot, loads_of(pose.robot)
    value = 0.0 * pose.point[0]
    if not physics.has_gravity:
        return value
    refuse_weightless(robot, "potential")
    g = physics.gravity
    value = value - robot.m * dot(g, pose.point)
    for i, (drive, leg) in enumerate(zip(robot.drives, pose.legs)):
        x, y = drive.pivot(leg.direction)
        arm = (x - drive.x) * (1 / drive.length), (y - drive.y) * (1 / drive.length)
        value = value - physics.levers[i] * dot(g, arm) - physics.sides[i] * cross(arm, g)
        if named(physics.across[i]):
            value = value - physics.across[i] * cross(leg.distal, g)
    return value


def friction_torques(rates: Rates) -> np.ndarray:
    """Return the torques that the motors need against their friction: fv q' + fs sign(q').

    Parameters
    ----------
    rates : Rates

    Returns
    -------
    (*batch, 2), N m (biglide: N)
        0 where a motor stands.

    Examples
    --------
    >>> import fivebar as fb
    >>> robot = fb.FiveBar(fv1=0.1, fs2=0.5)
    >>> rates = fb.dkm(fb.dgm(robot, (0.0, 0.0)), (2.0, -1.0))
    >>> fb.friction_torques(rates).tolist()
    [0.2, -0.5]
    """
    some_rates(rates, "rates")
    physics = loads_of(rates.pose.robot)
    return pack(*(_friction(physics, i, q_dot, None) for i, q_dot in enumerate(rates._q_dot)))


def dry_friction(robot: Robot, q_dot: np.ndarray) -> np.ndarray:
    """Coulomb friction of the drives at rates (*batch, 2), N m, 0 where they are 0; of symbols
    too.
    """
    signs = sign(q_dot, 0.0) if is_symbolic(q_dot) else np.sign(q_dot)
    dry = loads_of(robot).coulomb
    if is_symbolic(signs):
        return pack(dry[0] * signs[0], dry[1] * signs[1])
    return signs * np.array(dry)


def lost_power(rates: Rates) -> np.ndarray:
    """Return the power that friction takes, (*batch,) W."""
    robot, physics = rates.pose.robot, loads_of(rates.pose.robot)
    power = 0.0 * rates._q_dot[0]
    for i, (drive, q_dot) in enumerate(zip(robot.drives, rates._q_dot)):
        power = power + _friction(physics, i, q_dot, None) * q_dot
        if named(physics.elbows[i]):
            opens = drive.relative(rates.phi_dot[i], q_dot)
            power = power + physics.elbows[i] * opens * opens
    return power
