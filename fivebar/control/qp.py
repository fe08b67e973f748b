"""The tracker's problem in one sample: residuals on the horizon condensed to a QP, its solution and
their check.
"""

from __future__ import annotations

from enum import IntEnum

import casadi as ca
import numpy as np

from ..models.compiled import Buffered

SOLVER = "daqp"  # by measurement: tests/benchmarks/qp_solvers.py
HORIZON, LONGEST_STAGE = (1.0, 0.14)  # s: to be seen ahead; what the midpoint rule predicts well
TOLERANCE = 1e-6  # of a solution's optimality, in units of the QP's unknowns and multipliers


class Status(IntEnum):
    """How a step's torque came about; with all but SOLVED the fallback was applied."""

    SOLVED = 0
    QP_FAILED = 1  # the solver says so
    CHECK_FAILED = 2  # it says it succeeded, and the optimality conditions say it did not
    NOT_FINITE = 3  # the estimate or the prediction is not finite


def stage_lengths(horizon: int, period: float, seconds: float | None = None) -> tuple[float, ...]:
    """`horizon` stages, the first of a period, growing by a constant factor to `seconds` in all:
    coarse far ahead.

    Without `seconds`: 1 s, or what stages of at most 0.14 s give.
    """
    if seconds is None:
        growth = max(1.0, LONGEST_STAGE / period) ** (1 / (horizon - 1))
        longest = period * sum(growth**k for k in range(horizon))
        seconds = max(horizon * period, min(HORIZON, longest))
    # With the second of these factors the last stage alone covers all.
    low = 1.0
    high = max(1.0, seconds / period) ** (1 / (horizon - 1))
    for _ in range(60):
        ratio = (low + high) / 2
        too_short = period * sum(ratio**k for k in range(horizon)) < seconds
        low, high = (ratio, high) if too_short else (low, ratio)
    return tuple(period * low**k for k in range(horizon))


def riccati(period: float, position: float, acceleration: float) -> np.ndarray:
    """Cost-to-go (2, 2) of an error and its rate under sampled acceleration: the discrete Riccati
    equation's solution.

    Where no limit acts, the torques and the end-effector's acceleration determine each other, so
    the error obeys a double integrator in x and in y, and this is what its optimal control costs
    after the horizon's end. With equal stages the horizon then acts as an infinite one, whose cost
    falls along the motion.
    """
    A = np.array([[1.0, period], [0.0, 1.0]])
    B = np.array([period**2 / 2, period])
    G = np.outer(B, B) / acceleration**2
    P = np.diag([position**2, 0.0])
    # Doubling: each turn squares the number of samples looked ahead. SciPy's solve_discrete_are
    # loses: with our weights at 0.1 ms it has 9e-13 where this has 9e-15, it refuses some others,
    # and takes 1 to 2 times as long.
    for _ in range(60):
        W = np.linalg.inv(np.eye(2) + G @ P)
        gained = A.T @ P @ W @ A
        A, G, P = A @ W @ A, G + A @ W @ G @ A.T, P + gained
        if np.abs(gained).max() <= 1e-15 * np.abs(P).max():
            break
    return (P + P.T) / 2


class Condenser:
    """Gauss-Newton: residuals of the horizon as linear functions of its scaled torques, and from
    them H and g.

    Residuals: position (m) after each stage; acceleration (m/s^2), the velocity error's change over
    it; change of torque. A stage counts by its length. The last position and velocity carry the
    terminal cost. NumPy's products take a quarter of the time of the same operations in CasADi's
    virtual machine.
    """

    def __init__(
        self,
        lengths: tuple[float, ...],
        position: float,
        acceleration: float,
        torque_rate: float,
        scale: float,
        size: int,
    ) -> None:
        N = len(lengths)
        n = 2 * N
        # State before each stage, and its torque, by scaled torques: [A B] times that is the state
        # after it.
        self.known = np.zeros((N + 1, size + 2, n))
        for k in range(N):
            self.known[k, size:, 2 * k : 2 * k + 2] = scale * np.eye(2)
        self.G = self.known[:, :size]
        self.stages = [(self.known[k], self.known[k + 1, :size]) for k in range(N)]
        self.Y = np.zeros((N + 1, 4, n))  # position and velocity by scaled torques
        share = np.sqrt(np.array(lengths) / lengths[0])[:, None]
        self.acceleration = share * acceleration / np.array(lengths)[:, None]
        self.share = share
        self.weight = position
        self.position = share * position
        self.position[-1] = 0.0  # that one is in the terminal cost
        cost_to_go = riccati(lengths[0], position, acceleration)
        self.terminal = np.kron(np.linalg.cholesky(cost_to_go).T, np.eye(2))
        change = np.eye(n) - np.eye(n, k=-2)
        self.first = (torque_rate * scale) ** 2
        self.smooth = self.first * change.T @ change

    def __call__(
        self,
        e0: np.ndarray,
        e: np.ndarray,
        AB: np.ndarray,
        C: np.ndarray,
        previous: np.ndarray,
        guess: np.ndarray,
        arcs: tuple | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """H (2N, 2N) and g (2N,) of 1/2 v'Hv + g'v, v the scaled torques (N x 2).

        e0 (4,), e (N, 4): errors in position and velocity of the predicted motion, now and after
        each stage. AB (N, size, size + 2): that motion's derivatives by state and torque.
        C (N, 4, size): those of position and velocity.
        previous (2,): the scaled torque before.
        guess (2N,): those of the prediction.
        arcs: (errors (N, k) m of k of the state's coordinates, where these are, their levers) that
            count as positions.
        """
        for slope, (before, after) in zip(AB, self.stages):
            np.dot(slope, before, out=after)
        np.matmul(C, self.G[1:], out=self.Y[1:])
        G = self.Y
        n = len(guess)
        errors = np.diff(np.vstack([e0, e])[:, 2:], axis=0)
        position = self.position[:, :, None] * G[1:, :2]
        acceleration = self.acceleration[:, :, None] * (G[1:, 2:] - G[:-1, 2:])
        R = np.vstack([position.reshape(-1, n), acceleration.reshape(-1, n), self.terminal @ G[-1]])
        r = np.concatenate(
            [
                (self.position * e[:, :2]).ravel(),
                (self.acceleration * errors).ravel(),
                self.terminal @ e[-1],
            ]
        )
        H = R.T @ R + self.smooth
        g = (r - R @ guess) @ R
        g[:2] -= self.first * previous
        if arcs is not None:
            errors, places, levers = arcs
            weights = self.share * self.weight
            rows = (self.G[1:, places] * (weights * levers)[:, :, None]).reshape(-1, n)
            H += rows.T @ rows
            g += ((weights * errors).ravel() - rows @ guess) @ rows
        return H, g


class QP:
    """min 1/2 v'Hv + g'v, low <= v <= high, rows v <= upper: solved, and not believed before it is
    checked.
    """

    def __init__(
        self, n: int, rows: int, solver: str = SOLVER, options: dict | None = None
    ) -> None:
        shapes = {"h": ca.Sparsity.dense(n, n), "a": ca.Sparsity.dense(rows, n)}
        options = {"error_on_fail": False, **(options or {})}
        self.call = Buffered(ca.conic("qp", solver, shapes, options))
        self.cold = np.full(rows, -np.inf), np.zeros(n), np.zeros(rows), np.zeros(0)

    def __call__(
        self,
        H: np.ndarray,
        g: np.ndarray,
        rows: np.ndarray,
        upper: np.ndarray,
        low: np.ndarray,
        high: np.ndarray,
    ) -> tuple[np.ndarray, int, Status]:
        """Return (v, iterations, status). DAQP's own count does not come through CasADi; it begins
        with no bound in force and adds at most one in each iteration, so given is the least: the
        bounds in force at the solution, and one.
        """
        none, zero, multipliers, empty = self.cold
        try:
            v, _, forces, pushes = self.call(
                H, g, rows.T, none, upper, low, high, zero, zero, multipliers, empty, empty
            )
        except RuntimeError:
            return zero, 0, Status.QP_FAILED
        iterations = 1 + int(np.count_nonzero(pushes) + np.count_nonzero(forces))
        if optimality(H, g, rows, upper, low, high, v, forces) <= TOLERANCE:
            return v, iterations, Status.SOLVED
        succeeded = self.call.stats()["success"]
        return (v, iterations, Status.CHECK_FAILED if succeeded else Status.QP_FAILED)


@np.errstate(invalid="ignore", over="ignore")  # a solver that failed leaves anything
def optimality(
    H: np.ndarray,
    g: np.ndarray,
    rows: np.ndarray,
    upper: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    v: np.ndarray,
    forces: np.ndarray,
) -> float:
    """Return how far v is from optimal, 0 at the solution, nan where it is nan: the length of a
    projected gradient step, and of the least of each row's gap and multiplier (`forces`), relative
    to the largest unknown or multiplier.
    """
    slope = H @ v
    slope += g
    if len(upper):
        slope += forces @ rows
    step = v - slope / H.diagonal()
    step = np.abs(v - np.minimum(np.maximum(step, low), high)).max() / (1 + np.abs(v).max())
    if not len(upper):
        return step
    gap = upper - rows @ v
    multipliers = forces / (1 + np.abs(forces).max())
    complementarity = np.abs(np.minimum(gap, multipliers)).max()
    return max(step, complementarity / (1 + np.abs(upper).max()))
