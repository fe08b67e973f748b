"""Dynamic models on base parameters: tau = M q'' + c, its inverse, and the bar-force form of
forward dynamics.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..base.backend import first_index, is_symbolic, pack, pack_matrix, unpack_for
from ..base.checks import instance
from ..base.errors import SingularityError
from .dyads import SINGULAR, dot
from .heavy_bars import bar_forces_under, by_bar_forces, loaded_accelerations, masses, multiply
from .kinematics import Accelerations, Rates, a_pose, dkm2, place_of, refuse_parallel, some_rates
from .loads import at_rest, forces_and_torques, has_moving_mass, refuse_weightless
from .physics import any_named, loads_of, named, physics_of
from .pose import Pose
from .sticking import slip_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


some_accelerations = instance(
    Accelerations, what="Accelerations, as dkm2, ikm2 and forward_dynamics give"
)


def dynamic_model(rates: Rates) -> tuple[np.ndarray, np.ndarray]:
    """Return M and c of the dynamic model tau = M q'' + c.

    M = Z + m J^T J and c = m J^T A^-1 d, with J = A^-1 B. c has the robot's gravity and friction
    too.

    Parameters
    ----------
    rates : Rates

    Returns
    -------
    M : (*batch, 2, 2), kg m^2 (biglide: kg)
    c : (*batch, 2), N m (biglide: N)

    Raises
    ------
    SingularityError
        A is singular (Type 2).

    References
    ----------
    AMORO lab handout, eq. 26.

    Examples
    --------
    >>> import fivebar as fb
    >>> rates = fb.dkm(fb.dgm(fb.FiveBar(), (0.0, 0.0)), (1.0, -1.0))
    >>> M, c = fb.dynamic_model(rates)
    >>> M.shape, c.shape
    ((2, 2), (2,))
    """
    if not isinstance(rates, Rates):
        some_rates(rates, "rates")
    pose, robot = rates.pose, rates.pose.robot
    z1, z2 = robot.inertias
    refuse_weightless(robot, "dynamic_model")
    if not has_moving_mass(robot):
        zero = 0.0 * rates._q_dot[0]
        return pack_matrix(z1 + zero, zero, zero, z2 + zero), pack(
            *forces_and_torques(at_rest(rates))[1]
        )
    if physics_of(robot) is not None:
        return _loaded_model(rates)
    refuse_parallel(pose, "dynamic_model")
    # AMORO eq. 26: M = Z + m J^T J, c = m J^T A^-1 d, with J^T J = B (A A^T)^-1 B and
    # (A A^T)^-1 = [[1, -g], [-g, 1]] / det A^2, g = u_12 . u_22.
    b1, b2 = pose.b
    d1, d2 = rates._bias
    g = dot(*pose.u2)
    weight = robot.m / (pose.det_A * pose.det_A)
    coupling = -weight * g * b1 * b2
    M = pack_matrix(z1 + weight * b1 * b1, coupling, coupling, z2 + weight * b2 * b2)
    return M, pack(weight * b1 * (d1 - g * d2), weight * b2 * (d2 - g * d1))


def _loaded_model(rates):
    """Return M and c with all loads; c is the torque at zero acceleration.

    M = T^T M_y T, with M_y the masses of y = (e1, e2, x, y) of `heavy_bars` and y' = T q'.
    """
    pose, robot = rates.pose, rates.pose.robot
    zero = 0.0 * rates._q_dot[0]
    c = inverse_dynamics(dkm2(rates, pack(zero, zero)))
    (x1, y1), (x2, y2) = pose.u2
    s1, s2 = (b * (1 / pose.det_A) for b in pose.b)
    left, right = (drive.length for drive in robot.drives)
    # Columns of T: |P_i'|, and the end-effector's velocity for q_i' = 1.
    first = left, 0.0, y2 * s1, -x2 * s1
    second = 0.0, right, -y1 * s2, x1 * s2
    of_y = masses(rates)
    of_first = multiply(of_y, first)
    of_second = multiply(of_y, second)
    (m11, m12), (_, m22) = multiply((first, second), of_first), multiply((first, second), of_second)
    return pack_matrix(m11, m12, m12, m22), c


def gravity_torques(pose: Pose) -> np.ndarray:
    """Return the torques that hold the robot at rest against gravity.

    Parameters
    ----------
    pose : Pose

    Returns
    -------
    (*batch, 2), N m (biglide: N)

    Raises
    ------
    SingularityError
        At Type 2, where no torque holds the end-effector.
    ValueError
        The robot has gravity, and nothing that it pulls at.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.gravity_torques(fb.igm(fb.FiveBar(), (0.05, 0.09))).tolist()
    [0.0, 0.0]
    """
    a_pose(pose, "pose")
    zero = 0.0 * pose.point[0]
    return inverse_dynamics(at_rest(Rates(pose, (zero, zero), (zero, zero))))


def inverse_dynamics(accelerations: Accelerations) -> np.ndarray:
    """Return the torques of a motion: the inverse dynamic model, tau = Z q'' + J^T m xi''.

    With gravity, heavy bars and friction where the robot has them. The Coulomb friction of a drive
    that stands is 0.

    Parameters
    ----------
    accelerations : Accelerations

    Returns
    -------
    (*batch, 2), N m (biglide: N)

    Raises
    ------
    SingularityError
        A is singular (Type 2).
    ValueError
        The robot has gravity, and nothing that it pulls at.

    References
    ----------
    AMORO lab handout, eq. 25.

    Examples
    --------
    >>> import fivebar as fb
    >>> rates = fb.ikm(fb.igm(fb.FiveBar(), (0.05, 0.09)), (0.0, 0.0))
    >>> fb.inverse_dynamics(fb.ikm2(rates, (0.0, 1.0))).shape
    (2,)
    """
    if not isinstance(accelerations, Accelerations):
        some_accelerations(accelerations, "accelerations")
    pose = accelerations.rates.pose
    refuse_weightless(pose.robot, "inverse_dynamics")
    if has_moving_mass(pose.robot):
        refuse_parallel(pose, "inverse_dynamics")
    return pack(*torques_of(accelerations))


def torques_of(accelerations: Accelerations) -> tuple:
    """Return the torques of `inverse_dynamics`, which are not finite at Type 2."""
    pose = accelerations.rates.pose
    (fx, fy), torques = forces_and_torques(accelerations)
    if has_moving_mass(pose.robot):
        (x1, y1), (x2, y2) = pose.u2
        scale = 1 / pose.det_A
        if physics_of(pose.robot) is None:  # the mass is taken into the scale: two products less
            (fx, fy), scale = accelerations._xi_ddot, pose.robot.m / pose.det_A
        # Bar forces lambda = A^-T m xi''.
        forces = (fx * y2 - fy * x2) * scale, (fy * x1 - fx * y1) * scale
        torques = tuple(t + b * force for t, b, force in zip(torques, pose.b, forces))
    return torques


def forward_dynamics(rates: Rates, tau: ArrayLike) -> Accelerations:
    """Return the accelerations under torques: the direct dynamic model, regular at singularities.

    It is solved by the two bar forces. With mu these over m, (A A^T + m B Z^-1 B^T) mu = d + B Z^-1
    tau, xi'' = A^T mu and q'' = Z^-1 (tau - m B^T mu). A drive with Coulomb friction that stands is
    held where its friction is enough; CasADi symbols know no such drive.

    Parameters
    ----------
    rates : Rates
    tau : (*batch, 2), N m (biglide: N)

    Returns
    -------
    Accelerations

    Raises
    ------
    SingularityError
        Only where that 2 x 2 system is singular: A, and B of both legs.
    ValueError
        A drive has no inertia.

    Examples
    --------
    >>> import fivebar as fb
    >>> rates = fb.dkm(fb.dgm(fb.FiveBar(), (0.0, 0.0)), (0.0, 0.0))
    >>> accelerations = fb.forward_dynamics(rates, (0.01, -0.01))
    >>> fb.inverse_dynamics(accelerations).round(12).tolist()
    [0.01, -0.01]
    """
    if not isinstance(rates, Rates):
        some_rates(rates, "rates")
    tau = unpack_for(rates._xi_dot[0], tau, "tau")
    if physics_of(rates.pose.robot) is not None:
        return slipping_dynamics(rates, tau, _slip(rates, tau), "forward_dynamics")
    return _lab_dynamics(rates, tau, "forward_dynamics")[0]


def _lab_dynamics(rates, tau, model):
    """Return (Accelerations, bar forces over m) of a robot without loads."""
    _refuse_no_inertia(rates.pose.robot, model)
    return by_bar_forces(rates, tau, partial(_refuse_corner, model))


def slipping_dynamics(
    rates: Rates, tau: tuple, slip: tuple | None, model: str = "slipping_dynamics"
) -> Accelerations:
    """`forward_dynamics` of a robot with loads, on components, where it is known how the drives
    slip (`forces_and_torques`).
    """
    robot = rates.pose.robot
    refuse_weightless(robot, model)
    if not loads_of(robot).heavy:
        _refuse_no_inertia(robot, model)
        if not named(robot.m) and any_named(loads_of(robot).elbows):
            raise ValueError(f"{model} needs m > 0 where elbows rub (fv12, fv22)")
    return loaded_accelerations(rates, tau, slip, partial(_refuse_corner, model))


def held_by(rates: Rates, tau: tuple, slip: tuple) -> tuple[Accelerations, tuple]:
    """Return (Accelerations, friction that each drive that sticks needs to stay, N m), on
    components.
    """
    acc = slipping_dynamics(rates, tau, slip)
    forces = bar_forces_under(acc, tau, slip)
    _, torques = forces_and_torques(acc, slip)
    return acc, tuple(
        t - asked - b * f for t, asked, b, f in zip(tau, torques, rates.pose.b, forces)
    )


def _slip(rates, tau):
    """Return how the drives slip: by their rates, or what holds them where they stand; None: there
    is nothing to know.
    """
    if not loads_of(rates.pose.robot).sticks or any(
        map(is_symbolic, (*rates._q_dot, *tau, *rates.pose.point))
    ):
        return None
    return slip_of(rates, tau, held_by)


def _refuse_no_inertia(robot, model):
    for name, z in zip(robot.words.inertias, robot.inertias):
        if not named(z):
            raise ValueError(
                f"{model} needs {name} > 0, as it divides the {robot.words.effort} by it"
            )


def bar_forces(rates: Rates, tau: ArrayLike) -> np.ndarray:
    """Return forces (*batch, 2) in N of the distal bars on the end-effector, under torques tau;
    regular as `forward_dynamics`.

    A bar that pushes has a positive one: m xi'' = A^T lambda.
    """
    some_rates(rates, "rates")
    tau = unpack_for(rates._xi_dot[0], tau, "tau")
    if physics_of(rates.pose.robot) is not None:
        slip = _slip(rates, tau)
        return pack(*bar_forces_under(slipping_dynamics(rates, tau, slip, "bar_forces"), tau, slip))
    return pack(*(rates.pose.robot.m * mu for mu in _lab_dynamics(rates, tau, "bar_forces")[1]))


def bar_force_dynamics(accelerations: Accelerations, forces: tuple) -> tuple:
    """Return (m xi'' - A^T lambda, tau = Z q'' + B^T lambda) for bar forces lambda, on components.

    The first is 0 where the forces are those of the motion. Both have the robot's loads. Nothing is
    divided, so both are regular at every singularity.
    """
    pose = accelerations.rates.pose
    force, torques = forces_and_torques(accelerations)
    push = tuple(f - (u1 * forces[0] + u2 * forces[1]) for f, (u1, u2) in zip(force, zip(*pose.u2)))
    return push, tuple(t + b * f for t, b, f in zip(torques, pose.b, forces))


def drives_forces(accelerations: Accelerations, tau: tuple) -> tuple:
    """Return the bar forces by the balance of the drives, B^-1 (tau - Z q''), N, on components.

    At Type 1, where B is singular, the drives do not determine them.
    """
    drives = zip(tau, forces_and_torques(accelerations)[1], accelerations.rates.pose.b)
    return tuple((t - asked) / along for t, asked, along in drives)


def _refuse_corner(model, pose, determinant):
    if is_symbolic(determinant) or (isinstance(determinant, float) and determinant > SINGULAR**2):
        return
    singular = determinant <= SINGULAR**2
    if np.any(singular):
        count, index = first_index(singular)
        first = place_of(pose, np.shape(determinant), index)
        raise SingularityError(
            f"{model}: both distal bars are parallel and carry no {pose.robot.words.effort} (det A"
            f" and B both singular) in {count} of {np.size(singular)} poses, the first {first}",
            float(np.min(determinant)),
            index or None,
        )


def energy(rates: Rates) -> np.ndarray:
    """Return the kinetic energy.

    Parameters
    ----------
    rates : Rates

    Returns
    -------
    (*batch,), J

    References
    ----------
    AMORO lab handout, eq. 21 and 23.

    Examples
    --------
    >>> import fivebar as fb
    >>> rates = fb.dkm(fb.dgm(fb.FiveBar(m=0.0), (0.0, 0.0)), (1.0, 0.0))
    >>> float(fb.energy(rates))  # zz1 q1'^2 / 2
    0.001
    """
    if not isinstance(rates, Rates):
        some_rates(rates, "rates")
    robot, (q1, q2), (x, y) = rates.pose.robot, rates._q_dot, rates._xi_dot
    z1, z2 = robot.inertias
    kinetic = 0.5 * (z1 * q1 * q1 + z2 * q2 * q2 + robot.m * (x * x + y * y))
    physics = physics_of(robot)
    if physics is None or not physics.heavy:
        return kinetic
    turning = 0.0
    for i, (j, my) in enumerate(zip(physics.turning, physics.across)):
        if any_named((j, my)):
            turn = rates.phi_dot[i]
            turning = turning + turn * (0.5 * j * turn - my * rates.pose.b[i] * rates._q_dot[i])
    return kinetic + turning
