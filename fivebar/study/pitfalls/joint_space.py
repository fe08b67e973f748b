"""Forward dynamics in joint coordinates, q'' = M^-1 (tau - c), carried across Type 2."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...models.geometry import igm
from ...models.kinematics import Rates, ikm
from ...models.robots import FiveBar, Robot
from ...simulation.settings import Integrator
from ...simulation.simulate import simulate
from .integrators import Slope, adaptive, rk4

FREE_END = (0.0087618923917, 0.1480740333255)  # m, at 2 s, good to 5e-13 m
DURATION = 2.0  # s


def free_start(robot: Robot) -> Rates:
    """Return the state at which the free motion begins: through Type 2 twice, over a folded leg."""
    return ikm(igm(robot, (0.01, 0.12), (1, -1)), (0.02, -0.30))


def joint_model(robot: FiveBar, state: np.ndarray, assembly: int) -> tuple[np.ndarray, ...]:
    """Return xi, xi', q'' (2, ...) and the kinetic energy of states (q1, q2, q1', q2'), no torque.

    The lab's formulas as printed (AMORO eq. 1-3, 13, 18, 25), with general lengths; the arrays have
    any shape. nan where the loop does not close.
    """
    q = state[:2]
    q_dot = state[2:]
    column = (2,) + (1,) * (state.ndim - 1)
    l1 = np.reshape([robot.l11, robot.l21], column)
    l2 = np.reshape([robot.l12, robot.l22], column)
    base = np.reshape([-robot.d / 2, robot.d / 2], column)
    cos = np.cos(q)
    sin = np.sin(q)
    ex = base + l1 * cos
    ey = l1 * sin
    dx = ex[1] - ex[0]
    dy = ey[1] - ey[0]
    span = np.sqrt(dx**2 + dy**2)
    a = (span**2 + robot.l12**2 - robot.l22**2) / (2 * span)
    h = -assembly * np.sqrt(robot.l12**2 - a**2)
    xi = np.array([ex[0] + (a * dx - h * dy) / span, ey[0] + (a * dy + h * dx) / span])
    ux = (xi[0] - ex) / l2
    uy = (xi[1] - ey) / l2
    b = l1 * (uy * cos - ux * sin)
    det = ux[0] * uy[1] - uy[0] * ux[1]

    def inverse_a(r1, r2):
        return np.array([(uy[1] * r1 - uy[0] * r2) / det, (ux[0] * r2 - ux[1] * r1) / det])

    J = np.array([inverse_a(b[0], 0 * det), inverse_a(0 * det, b[1])])  # its columns
    xi_dot = J[0] * q_dot[0] + J[1] * q_dot[1]
    rx = xi_dot[0] + l1 * sin * q_dot
    ry = xi_dot[1] - l1 * cos * q_dot
    transverse = ux * ry - uy * rx
    cosine = ux * cos + uy * sin
    # Leg by leg: Python's power of one number may differ from NumPy's square in the last digit.
    d = [-l1[i] * cosine[i] * q_dot[i] ** 2 - transverse[i] ** 2 / l2[i] for i in (0, 1)]
    c1, c2 = robot.m * (J * inverse_a(*d)).sum(axis=1)
    m11, m22 = np.reshape([robot.zz1, robot.zz2], column) + robot.m * (J * J).sum(axis=1)
    m12 = robot.m * (J[0] * J[1]).sum(axis=0)
    det_m = m11 * m22 - m12**2
    q_ddot = np.array([(m12 * c2 - m22 * c1) / det_m, (m12 * c1 - m11 * c2) / det_m])
    w1, w2 = q_dot
    energy = 0.5 * (m11 * w1**2 + 2 * m12 * w1 * w2 + m22 * w2**2)
    return xi, xi_dot, q_ddot, energy


def joint_slope(robot: FiveBar, assembly: int) -> Slope:
    """Return (t, state) -> slope for the integrators."""
    return lambda t, state: np.concatenate([state[2:], joint_model(robot, state, assembly)[2]])


@dataclass(frozen=True, eq=False)
class FreeRun:
    """An attempt at the free motion: t (n,) s, xi (n, 2) m, energy (n,) J, whether the solver
    claims success.
    """

    name: str
    t: np.ndarray
    xi: np.ndarray
    energy: np.ndarray
    success: bool = True

    @property
    def energy_error(self) -> float:
        """The largest relative error of the energy."""
        return np.abs(self.energy / self.energy[0] - 1).max()


def _started(robot):
    """Return initial state, assembly mode and slope of the free motion in joint coordinates."""
    start = free_start(robot)
    assembly = int(start.pose.assembly)
    state = np.concatenate([start.pose.q, start.q_dot])
    return state, assembly, joint_slope(robot, assembly)


def free_motion_by(robot: FiveBar, method: str, rtol: float = 1e-9) -> FreeRun:
    """Return the free motion by a SciPy solver, with tolerances that a careful user sets."""
    state, assembly, slope = _started(robot)
    t = np.linspace(0, DURATION, 401)
    solution = adaptive(slope, state, t, method, rtol=rtol, atol=1e-3 * rtol)
    with np.errstate(all="ignore"):
        xi, _, _, energy = joint_model(robot, solution.states.T, assembly)
    return FreeRun(f"{method}, {rtol:g}", solution.t, xi.T, energy, solution.success)


def free_motion_of_ours(robot: Robot, step: float) -> FreeRun:
    """Return the same by fivebar.simulate, the four bars in fixed steps, s."""
    run = simulate(
        robot, duration=DURATION, start=free_start(robot), step=step, integrator=Integrator("rk4")
    )
    return FreeRun("fivebar", run.t, run.xi, run.energy)


def whole_steps(count: int = 400, shortest: float = 4e-4, longest: float = 4e-3) -> np.ndarray:
    """Return evenly spaced steps, s, each moved to the nearest that divides the duration."""
    return DURATION / np.round(DURATION / np.linspace(shortest, longest, count))


@dataclass(frozen=True, eq=False)
class StepSizes:
    """The free motion with many fixed steps (n,) s: end (n, 2) m, relative error of the energy
    (n,).
    """

    step: np.ndarray
    end: np.ndarray
    energy_error: np.ndarray


def free_motion_by_steps(robot: FiveBar, steps: np.ndarray) -> StepSizes:
    """Return RK4 on the joint-space model with all the fixed steps (n,) s at once, a column each.

    The energy error is the one at the end, with its sign.
    """
    steps = np.asarray(steps, dtype=float)
    start, assembly, slope = _started(robot)
    state = np.tile(start[:, None], len(steps))
    counts = np.round(DURATION / steps).astype(int)
    with np.errstate(all="ignore"):
        for k in range(counts.max()):
            going = np.flatnonzero((counts > k) & np.isfinite(state[0]))
            state[:, going] = rk4(slope, 0.0, state[:, going], steps[going])
        xi, _, _, energy = joint_model(robot, state, assembly)
    return StepSizes(steps, xi.T, energy / joint_model(robot, start, assembly)[3] - 1)


def free_motion_of_ours_by_steps(robot: Robot, steps: np.ndarray) -> StepSizes:
    """Return the same by fivebar.simulate; the energy error is the largest on the way."""
    runs = [free_motion_of_ours(robot, float(step)) for step in steps]
    ends = np.array([run.xi[-1] for run in runs])
    return StepSizes(np.asarray(steps, float), ends, np.array([run.energy_error for run in runs]))
