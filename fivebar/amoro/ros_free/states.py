"""What the lab's messages say of a state: active and passive joints, and the end-effector."""

from collections import namedtuple

import numpy as np

from ...models.dynamics import forward_dynamics

# Continuous joint coordinates q and passive, and the end-effector's xi, with rates and
# accelerations: (2,) each.
LabState = namedtuple(
    "LabState", "q q_dot q_ddot passive passive_dot passive_ddot xi xi_dot xi_ddot"
)


def lab_state(plant, tau, before, period, exact):
    """Return the plant's state now, at the end of a step under torques tau; before: the LabState at
    its start, or None.

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
