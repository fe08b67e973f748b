"""What the lab's messages say of a state: active and passive joints, and the end-effector."""

from typing import NamedTuple

import numpy as np

from ...models.dynamics import forward_dynamics


class LabState(NamedTuple):
    """q, passive: continuous joint coordinates, each with rates and accelerations (2,); xi, xi_dot,
    xi_ddot (2,).
    """

    q: np.ndarray
    q_dot: np.ndarray
    q_ddot: np.ndarray
    passive: np.ndarray
    passive_dot: np.ndarray
    passive_ddot: np.ndarray
    xi: np.ndarray
    xi_dot: np.ndarray
    xi_ddot: np.ndarray


def lab_state(plant, tau, before, period, exact):
    """The plant's state now, at the end of a step under torques tau; before: the LabState at its
    start, or None.

    Joint accelerations are velocity differences over the period, as the lab has them, or with
    `exact` those of the dynamics under tau, as the end-effector's always are.
    """
    rates, (q, q_dot) = plant.rates, plant.joints
    found, robot = forward_dynamics(rates, tau), plant.robot
    passive = np.array(
        [drive.relative(phi, own) for drive, phi, own in zip(robot.drives, plant.state[1:4:2], q)]
    )
    q_ddot, passive_ddot = found.q_ddot, found.q_passive_ddot
    if before is not None and not exact:
        q_ddot = (q_dot - before.q_dot) / period
        passive_ddot = (rates.q_passive_dot - before.passive_dot) / period
    return LabState(
        q,
        q_dot,
        q_ddot,
        passive,
        rates.q_passive_dot,
        passive_ddot,
        rates.pose.xi,
        rates.xi_dot,
        found.xi_ddot,
    )
