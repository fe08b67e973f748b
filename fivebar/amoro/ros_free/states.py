"""What the lab's messages say of a state: active and passive joints, and the end-effector."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..._backend import wrap
from ...models.compiled import Buffered
from ...models.dynamics import forward_dynamics
from ...simulation.steps import Q_DOT, XI, XI_DOT, Q

# Columns of what is computed beside an observation.
PASSIVE, PASSIVE_DOT, Q_DDOT, PASSIVE_DDOT, XI_DDOT = (slice(2 * k, 2 * k + 2) for k in range(5))


class LabState(NamedTuple):
    """q, passive: continuous joint coordinates, each with rates and accelerations (2,); xi, xi_dot, xi_ddot (2,)."""

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
    """The plant's state now, at the end of a step under torques tau; before: the LabState at its start, or None.

    Joint accelerations are velocity differences over the period, as the lab has them, or with `exact` those of the
    dynamics under tau, as the end-effector's always are.
    """
    seen = plant.observation
    more = _rest_of_state(plant.robot, plant.chart)(plant.state, tau, plant.modes)[0].copy()
    q, passive = seen[Q].copy(), more[PASSIVE]
    q_ddot, passive_ddot = more[Q_DDOT], more[PASSIVE_DDOT]
    if before is not None:
        q = before.q + plant.robot.differ(q - before.q)
        passive = before.passive + wrap(passive - before.passive)
        if not exact:
            q_ddot = (seen[Q_DOT] - before.q_dot) / period
            passive_ddot = (more[PASSIVE_DOT] - before.passive_dot) / period
    return LabState(
        q, seen[Q_DOT].copy(), q_ddot, passive, more[PASSIVE_DOT], passive_ddot, seen[XI].copy(), seen[XI_DOT].copy(),
        more[XI_DDOT],
    )  # fmt: skip


@lru_cache(maxsize=8)
def _rest_of_state(robot, chart):
    """(state, tau, modes) -> passive coordinates and rates, joint accelerations, the end-effector's."""
    import casadi

    state, tau, modes = casadi.SX.sym("state", 4), casadi.SX.sym("tau", 2), casadi.SX.sym("modes", 2)
    rates = chart.rates(robot, (state[0], state[1]), (state[2], state[3]), (modes[0], modes[1]))
    found = forward_dynamics(rates, tau)
    columns = rates.pose.q_passive, rates.q_passive_dot, found.q_ddot, found.q_passive_ddot, found.xi_ddot
    return Buffered(casadi.Function("rest", [state, tau, modes], [casadi.cse(casadi.vertcat(*columns))]))
