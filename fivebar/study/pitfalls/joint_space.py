"""Forward dynamics in joint coordinates, q'' = M^-1 (tau - c), carried across Type 2."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...models.geometry import igm
from ...models.kinematics import ikm
from ...simulation.simulate import simulate
from .integrators import adaptive, march, rk4

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ...models.kinematics import Rates
    from ...models.robots import FiveBar, Robot
    from .integrators import Slope

FREE_START = dict(xi=(0.01, 0.12), xi_dot=(0.02, -0.30), working=(1, -1))
FREE_END = (0.0087618923917, 0.1480740333255)  # at 2 s, good to 5e-13 m


def free_start(robot: Robot) -> Rates:
    """Rates at which the free motion begins: no torque, through Type 2 twice and over a folded
    leg.
    """
    return ikm(igm(robot, FREE_START["xi"], FREE_START["working"]), FREE_START["xi_dot"])


def joint_model(robot: FiveBar, state: np.ndarray, assembly: int) -> tuple[np.ndarray, ...]:
    """xi, xi', q'' (2, ...) and the kinetic energy of a state (q1, q2, q1', q2'), arrays of any
    shape, no torque.

    The lab's formulas as printed (AMORO eq. 1-3, 13, 18, 25), general lengths. nan where the loop
    does not close.
    """
    q, q_dot = state[:2], state[2:]
    l1, l2 = np.array([robot.l11, robot.l21]), np.array([robot.l12, robot.l22])
    base = np.array([-robot.d / 2, robot.d / 2])
    cos, sin = np.cos(q), np.sin(q)
    ex, ey = [base[i] + l1[i] * cos[i] for i in (0, 1)], [l1[i] * sin[i] for i in (0, 1)]
    dx, dy = ex[1] - ex[0], ey[1] - ey[0]
    span = np.sqrt(dx**2 + dy**2)
    a = (span**2 + l2[0] ** 2 - l2[1] ** 2) / (2 * span)
    h = -assembly * np.sqrt(l2[0] ** 2 - a**2)
    xi = np.array([ex[0] + (a * dx - h * dy) / span, ey[0] + (a * dy + h * dx) / span])
    ux, uy = [(xi[0] - ex[i]) / l2[i] for i in (0, 1)], [(xi[1] - ey[i]) / l2[i] for i in (0, 1)]
    b = [l1[i] * (uy[i] * cos[i] - ux[i] * sin[i]) for i in (0, 1)]
    det = ux[0] * uy[1] - uy[0] * ux[1]

    def inverse_a(r1, r2):
        return np.array([(uy[1] * r1 - uy[0] * r2) / det, (ux[0] * r2 - ux[1] * r1) / det])

    zero = np.zeros_like(det)
    j1, j2 = inverse_a(b[0], zero), inverse_a(zero, b[1])  # columns of J
    xi_dot = j1 * q_dot[0] + j2 * q_dot[1]
    bias = []
    for i in (0, 1):
        rx, ry = xi_dot[0] + l1[i] * sin[i] * q_dot[i], xi_dot[1] - l1[i] * cos[i] * q_dot[i]
        swing = ux[i] * ry - uy[i] * rx
        bias.append(-l1[i] * (ux[i] * cos[i] + uy[i] * sin[i]) * q_dot[i] ** 2 - swing**2 / l2[i])
    free = inverse_a(*bias)  # xi'' for q'' = 0
    m11, m22 = (
        robot.zz1 + robot.m * (j1 * j1).sum(axis=0),
        robot.zz2 + robot.m * (j2 * j2).sum(axis=0),
    )
    m12 = robot.m * (j1 * j2).sum(axis=0)
    c1, c2 = robot.m * (j1 * free).sum(axis=0), robot.m * (j2 * free).sum(axis=0)
    det_m = m11 * m22 - m12**2
    q_ddot = np.array([(m12 * c2 - m22 * c1) / det_m, (m12 * c1 - m11 * c2) / det_m])
    energy = 0.5 * (m11 * q_dot[0] ** 2 + 2 * m12 * q_dot[0] * q_dot[1] + m22 * q_dot[1] ** 2)
    return xi, xi_dot, q_ddot, energy


def joint_slope(robot: FiveBar, assembly: int) -> Slope:
    """(t, state) -> slope for the integrators."""
    return lambda t, state: np.concatenate([state[2:], joint_model(robot, state, assembly)[2]])


@dataclass(frozen=True, eq=False)
class FreeRun:
    """One attempt at the free motion: t (n,) s, xi (n, 2) m, energy (n,) J; `claim` is the solver's
    own word for it.
    """

    name: str
    t: np.ndarray
    xi: np.ndarray
    energy: np.ndarray
    success: bool
    claim: str
    evaluations: int = 0

    @property
    def energy_error(self) -> float:
        return np.abs(self.energy / self.energy[0] - 1).max()


def free_motion_by(
    robot: FiveBar, method: str, rtol: float = 1e-9, duration: float = 2.0, samples: int = 401
) -> FreeRun:
    """The free motion by a SciPy solver on the joint-space model, with tolerances that a careful
    user sets.
    """
    start = free_start(robot)
    assembly = int(start.pose.assembly)
    t = np.linspace(0, duration, samples)
    state = np.concatenate([start.pose.q, start.q_dot])
    found = adaptive(joint_slope(robot, assembly), state, t, method, rtol=rtol, atol=1e-3 * rtol)
    with np.errstate(all="ignore"):
        xi, _, _, energy = joint_model(robot, found.states.T, assembly)
    return FreeRun(
        f"{method}, {rtol:g}",
        found.t,
        xi.T,
        energy,
        found.success,
        found.message,
        found.evaluations,
    )


def free_motion_by_rk4(robot: FiveBar, step: float, duration: float = 2.0) -> FreeRun:
    """The free motion by RK4 with fixed step, s, on the joint-space model."""
    start = free_start(robot)
    assembly = int(start.pose.assembly)
    with np.errstate(all="ignore"):
        state = np.concatenate([start.pose.q, start.q_dot])
        t, states = march(rk4, joint_slope(robot, assembly), state, duration, step)
        xi, _, _, energy = joint_model(robot, states.T, assembly)
    return FreeRun(
        f"RK4, {1e3 * step:.3g} ms", t, xi.T, energy, True, "reached the end", 4 * (len(t) - 1)
    )


def free_motion_of_ours(robot: Robot, step: float, duration: float = 2.0) -> FreeRun:
    """The same by fivebar.simulate, the four bars in fixed steps."""
    run = simulate(robot, duration=duration, start=free_start(robot), step=step, method="rk4")
    return FreeRun(
        "fivebar", run.t, run.xi, run.energy, True, "reached the end", 4 * (len(run.t) - 1)
    )


def whole_steps(
    count: int = 400, shortest: float = 4e-4, longest: float = 4e-3, duration: float = 2.0
) -> np.ndarray:
    """Evenly spaced steps, s, each moved to the nearest that divides `duration`, so that all end at
    the same time.
    """
    return duration / np.round(duration / np.linspace(shortest, longest, count))


@dataclass(frozen=True, eq=False)
class StepSizes:
    """The free motion with many fixed steps (n,) s: where it ended (n, 2) m, and its energy's
    relative error (n,).
    """

    step: np.ndarray
    end: np.ndarray
    energy_error: np.ndarray

    def outcomes(self, near: float = 1e-4) -> Counter:
        """How many steps gave nan, ended within `near` (m) of the true end, or elsewhere without a
        word.
        """
        distance = np.linalg.norm(self.end - FREE_END, axis=1)
        finite = np.isfinite(distance)
        kinds = np.where(finite, np.where(distance <= near, "right", "silently wrong"), "nan")
        return Counter(kinds.tolist())


def free_motion_by_steps(robot: FiveBar, steps: ArrayLike, duration: float = 2.0) -> StepSizes:
    """RK4 on the joint-space model with all the fixed steps at once, a column each, until each is
    at `duration`, s.

    steps: (n,) s, parts of the duration. The energy error is the one at the end, with its sign.
    """
    steps = np.asarray(steps, dtype=float)
    start = free_start(robot)
    assembly = int(start.pose.assembly)
    state = np.repeat(np.concatenate([start.pose.q, start.q_dot])[:, None], len(steps), axis=1)
    slope, counts = joint_slope(robot, assembly), np.round(duration / steps).astype(int)
    with np.errstate(all="ignore"):
        for k in range(counts.max()):
            going = np.flatnonzero((counts > k) & np.isfinite(state[0]))
            if not len(going):
                break
            state[:, going] = rk4(slope, 0.0, state[:, going], steps[going])
        xi, _, _, energy = joint_model(robot, state, assembly)
        initial = joint_model(robot, np.concatenate([start.pose.q, start.q_dot]), assembly)[3]
    return StepSizes(steps, xi.T, energy / initial - 1)


def free_motion_of_ours_by_steps(
    robot: Robot, steps: ArrayLike, duration: float = 2.0
) -> StepSizes:
    """The same by fivebar.simulate, a run for each step; the energy error is the largest on the
    way.
    """
    runs = [free_motion_of_ours(robot, float(step), duration) for step in steps]
    return StepSizes(
        np.asarray(steps, dtype=float),
        np.array([run.xi[-1] for run in runs]),
        np.array([run.energy_error for run in runs]),
    )
