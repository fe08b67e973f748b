"""Forward dynamics under the loads of `loads`: by the bar forces while the distal bars carry forces
along them alone, else by the masses and the closure of all four coordinates, which divides by no
inertia that may vanish or be negative.

In (e1, e2, x, y), e_i = |P_i'| q_i a length, the loop is closed while Phi y'' = d with

    Phi = [-s_1  0  u_1^T; 0  -s_2  u_2^T]          s_i = u_i . P_i' / |P_i'|

The motions that it leaves free are the columns of the antisymmetric W whose entries are the
complementary minors of Phi (det A, s_1 s_2 and s_i u_j): nothing has to be chosen, and W is 0 only
where all four bars are parallel. With M the masses in these coordinates (indefinite as it may be
off the free motions) and y_p any solution of Phi y_p = d,

    y'' = y_p + W^T M W (f - M y_p) / Delta          Delta = tr(W^T M W M) / 2

as N (N^T M N)^-1 N^T = W^T M W / det(N^T M N) for the 4 x 2 basis N of the free motions with W = N
[0 1; -1 0] N^T.
A drive that sticks is left out of both: its column of Phi is 0 and its mass alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..base.backend import is_symbolic
from .dyads import dot
from .kinematics import Accelerations, Rates
from .loads import at_rest, forces_and_torques
from .physics import loads_of, named

FREE = 1.0, 1.0


def loaded_accelerations(
    rates: Rates, tau: tuple, slip: tuple | None, refuse_corner: Callable
) -> Accelerations:
    """Return the accelerations under torques tau, on components.

    slip: as in `forces_and_torques`; a drive with slip 0 stays at rest.

    refuse_corner(pose, determinant): raises where all bars are parallel.
    """
    robot = rates.pose.robot
    free = _free(slip)
    force, torques = forces_and_torques(at_rest(rates), slip)
    push = tuple(t - asked for t, asked in zip(tau, torques))
    if loads_of(robot).heavy:
        return _by_closure(rates, push, force, free, refuse_corner)
    if named(robot.m):
        fall = tuple(f * (1 / robot.m) for f in force)
    else:
        fall = None
    return by_bar_forces(rates, push, refuse_corner, free, fall)[0]


def _free(slip):
    """Return per drive 1, or 0 where it sticks."""
    if slip is None:
        return FREE
    return tuple(each * each for each in slip)


def by_bar_forces(
    rates: Rates,
    push: tuple,
    refuse_corner: Callable,
    free: tuple = FREE,
    fall: tuple | None = None,
) -> tuple[Accelerations, tuple]:
    """Return (Accelerations, mu: the bar forces over m) of `dynamics.forward_dynamics`, with xi'' =
    A^T mu - fall.
    """
    pose, m, (z1, z2) = rates.pose, rates.pose.robot.m, rates.pose.robot.inertias
    (b1, b2), (u1, u2), g, square = pose.b, pose.u2, dot(*pose.u2), pose.det_A * pose.det_A
    d1, d2 = (
        rates._bias if fall is None else (d + dot(u, fall) for d, u in zip(rates._bias, pose.u2))
    )
    y1 = free[0] * (1 / z1)
    y2 = free[1] * (1 / z2)
    k1 = free[0] * (m / z1) * b1 * b1
    k2 = free[1] * (m / z2) * b2 * b2
    r1 = d1 + b1 * push[0] * y1
    r2 = d2 + b2 * push[1] * y2
    (mu1, mu2), inverse = _two_forces(pose, (k1, k2), (r1, r2), refuse_corner)
    # Z^-1 (tau - m B^T mu) with the shares of the leg's own torque taken together, which cancel
    # where k is large.
    q_ddot = (
        ((k2 + square) * push[0] - m * b1 * ((1 + k2) * d1 - g * r2)) * (inverse * y1),
        ((k1 + square) * push[1] - m * b2 * ((1 + k1) * d2 - g * r1)) * (inverse * y2),
    )
    xi_ddot = u1[0] * mu1 + u2[0] * mu2, u1[1] * mu1 + u2[1] * mu2
    if fall is not None:
        xi_ddot = xi_ddot[0] - fall[0], xi_ddot[1] - fall[1]
    return Accelerations(rates, q_ddot, xi_ddot), (mu1, mu2)


def _two_forces(pose, k, right, refuse_corner=lambda pose, determinant: None):
    """Return (mu with (A A^T + diag(k)) mu = right, 1 over the determinant)."""
    (k1, k2), (r1, r2), g = k, right, dot(*pose.u2)
    # (1 + k1)(1 + k2) - g^2, written without cancellation: 1 - g^2 = (det A)^2.
    determinant = pose.det_A * pose.det_A + (k1 + k2) + k1 * k2
    refuse_corner(pose, determinant)
    inverse = 1.0 / determinant
    return (((1 + k2) * r1 - g * r2) * inverse, ((1 + k1) * r2 - g * r1) * inverse), inverse


def _by_closure(rates, push, force, free, refuse_corner):
    pose, robot = rates.pose, rates.pose.robot
    lengths = [drive.length for drive in robot.drives]
    s1, s2 = (sine * f for sine, f in zip(pose.sines, free))
    (x1, y1), (x2, y2) = pose.u2
    # A solution of Phi y = d, the least.
    (n1, n2), _ = _two_forces(pose, (s1 * s1, s2 * s2), rates._bias, refuse_corner)
    least = -s1 * n1, -s2 * n2, x1 * n1 + x2 * n2, y1 * n1 + y2 * n2
    M = masses(rates, free)
    forces = (
        push[0] * free[0] * (1 / lengths[0]),
        push[1] * free[1] * (1 / lengths[1]),
        -force[0],
        -force[1],
    )
    W = _antisymmetric(pose.det_A, -s2 * y1, s2 * x1, -s1 * y2, s1 * x2, s1 * s2)
    rest = [f - along for f, along in zip(forces, multiply(M, least))]
    MW = _product(M, W)
    # tr(W^T M W M) = -tr(M W M W)
    delta = -0.5 * sum(MW[i][j] * MW[j][i] for i in range(4) for j in range(4))
    _refuse_negative(delta)
    moved = multiply(W, multiply(M, multiply(W, rest)))  # of W^T the negative
    scale = -1.0 / delta
    e1, e2, x, y = (part + scale * step for part, step in zip(least, moved))
    return Accelerations(
        rates, (e1 * free[0] * (1 / lengths[0]), e2 * free[1] * (1 / lengths[1])), (x, y)
    )


def masses(rates: Rates, free: tuple = FREE) -> list[list]:
    """M (4 x 4, on components) in kg of (e1, e2, x, y): kinetic energy is half of y'^T M y'."""
    pose, robot = rates.pose, rates.pose.robot
    physics = loads_of(robot)
    xx = yy = robot.m
    xy = 0.0
    own = []
    coupled = []
    for i, (drive, leg, bar) in enumerate(zip(robot.drives, pose.legs, robot.distal)):
        turn = physics.turning[i] * (1 / (bar * bar))
        side = physics.across[i] * (1 / bar)
        s, c, (ux, uy) = leg.sine, leg.cosine, leg.distal
        own.append(
            robot.inertias[i] * (1 / (drive.length * drive.length)) + c * (turn * c + 2 * side * s)
        )
        share = -(turn * c + side * s) * free[i]
        coupled.append((-share * uy, share * ux))
        xx = xx + turn * uy * uy
        xy = xy - turn * ux * uy
        yy = yy + turn * ux * ux
    e1, e2 = (f * f * each + (1 - f) for f, each in zip(free, own))
    (ax, ay), (bx, by) = coupled
    return [[e1, 0.0, ax, ay], [0.0, e2, bx, by], [ax, bx, xx, xy], [ay, by, xy, yy]]


def bar_forces_under(acc: Accelerations, tau: tuple, slip: tuple | None) -> tuple:
    """Return the forces along the distal bars in a motion under tau, on components, regular as the
    motion: least squares of all that speaks of them, which agrees.
    """
    free = _free(slip)
    pose = acc.rates.pose
    force, torques = forces_and_torques(acc, slip)
    s1, s2 = (sine * f for sine, f in zip(pose.sines, free))
    lengths = (drive.length for drive in pose.robot.drives)
    own = (
        f * (t - asked) * (1 / length) for f, t, asked, length in zip(free, tau, torques, lengths)
    )
    right = tuple(dot(u, force) + s * each for u, s, each in zip(pose.u2, (s1, s2), own))
    return _two_forces(pose, (s1 * s1, s2 * s2), right)[0]


def _antisymmetric(a, b, c, d, e, f):
    """Return rows of W from its entries 12, 13, 14, 23, 24, 34."""
    return [[0.0, a, b, c], [-a, 0.0, d, e], [-b, -d, 0.0, f], [-c, -e, -f, 0.0]]


def multiply(rows: Sequence, v: Sequence) -> list:
    """Return the products of rows with a vector, on components."""
    products = []
    for row in rows:
        products.append(sum(a * b for a, b in zip(row, v)))
    return products


def _product(rows, others):
    columns = list(zip(*others))
    return [multiply(columns, row) for row in rows]


def _refuse_negative(delta):
    if not is_symbolic(delta) and np.any(delta <= 0):
        raise ValueError(
            "forward_dynamics: these inertias make the kinetic energy of a motion 0 or negative,"
            " which no bodies do: see FiveBar.from_links"
        )
