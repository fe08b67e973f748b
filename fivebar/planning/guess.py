"""First guesses of the planner: along a path within the limits, about as fast as they allow."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from ..constraints.constraints import at_joints, distance_inside
from ..models.dynamics import inverse_dynamics
from ..models.geometry import igm
from .problem import PlanError, Problem

if TYPE_CHECKING:
    from collections.abc import Callable

    from .plans import Plan
    from .program import PlanSolution

    Guess = Callable[[np.ndarray], np.ndarray]  # times (n,) s -> (n, 8): motion, bar forces

GRID = 121  # nodes per side of the grid on which a first path is searched
SMOOTHINGS = 100  # passes over that path


def guess_again(plan: Plan, found: PlanSolution) -> Guess:
    """Return a solution as the guess of the next.

    Forces are interpolated between nodes, as computed ones might be huge there.
    """

    def guess(t):
        controls = [np.interp(t, plan.nodes, control) for control in found.controls.T]
        return np.column_stack([plan.motion(t)[..., :-2], *controls])

    return guess


def first_guess(
    problem: Problem, paths: list[np.ndarray] | None = None
) -> tuple[Guess, np.ndarray]:
    """Return (times -> (n, 8 or 14), duration of each phase), from rest to rest along paths.

    paths: (m, coordinates) between stops, in even steps. Without them the paths are straight where
    the limits allow.
    """
    even = paths is not None
    if paths is None:
        points = [np.array(conditions[0]) for conditions, _ in problem.stops]
        paths = [_path(problem, a, b) for a, b in zip(points, points[1:])]
    lengths = np.array([_steps(path).sum() for path in paths])
    shares = np.maximum(lengths, 0.05 * problem.coordinates.units(problem).max())
    sigma = np.linspace(0, 1, 201)
    blend = sigma**3 * (10 - 15 * sigma + 6 * sigma**2)
    motions = []
    for path in paths:
        steps = np.ones(len(path) - 1) if even else _steps(path)
        along = np.append(0.0, np.cumsum(steps))
        xi = _interpolated(
            blend * along[-1],
            along,
            path,
        )
        xi_dot = np.gradient(xi, sigma, axis=0)
        motions.append((xi, xi_dot, np.gradient(xi_dot, sigma, axis=0)))
    durations = shares / shares.sum()
    timed = problem.timed
    for (i, before), (j, after) in zip(timed, timed[1:]):
        parts = shares[i:j] / shares[i:j].sum()
        durations[i:j] = (after - before) * parts
    last = timed[-1][0]
    if last < len(paths):
        free = shares[last:] / shares[last:].sum()
        factors = [_time_needed(problem, m, T) for m, T in zip(motions[last:], free)]
        durations[last:] = free * max(factors)
    times = []
    rows = []
    for motion, duration, end in zip(motions, durations, np.cumsum(durations)):
        times.append(end + duration * (sigma - 1))
        derivatives = [value / duration**order for order, value in enumerate(motion)]
        motion = np.concatenate(derivatives, axis=1)
        controls = problem.coordinates.first_controls(problem, motion)
        rows.append(np.concatenate([motion, controls], axis=1))
    times = np.concatenate(times)
    table = np.concatenate(rows)
    return lambda t: _interpolated(t, times, table), durations


def _steps(path):
    return np.linalg.norm(np.diff(path, axis=0), axis=1)


def _interpolated(x, nodes, table):
    return np.stack(
        [np.interp(x, nodes, column) for column in table.T],
        axis=-1,
    )


def _time_needed(problem, motion, duration):
    """Return the factor by which a phase of `duration` is to be stretched.

    Torque goes as 1 / time^2, speed as 1 / time.
    """
    motion = np.concatenate(
        [m / duration**i for i, m in enumerate(motion)],
        axis=1,
    )
    acc = problem.accelerations(motion)
    limits = problem.constraints
    weights = problem.weights
    regular = np.abs(acc.rates.pose.det_A) > 0.1
    tau = np.zeros((1, 2))
    if regular.any():
        tau = inverse_dynamics(problem.accelerations(motion[regular]))
    third = np.gradient(acc.xi_ddot, duration / 200, axis=0)
    effort = np.mean(np.sum(tau**2, axis=1)) * duration
    jerk = np.mean(np.sum(third**2, axis=1)) * duration
    factors = [
        1e-3,
        (3 * weights["effort"] * effort / weights["time"] / duration) ** 0.25,
        (5 * weights["jerk"] * jerk / weights["time"] / duration) ** (1 / 6),
    ]
    if limits.torque is not None:
        factors.append(np.sqrt(np.quantile(np.abs(tau) / limits.torque, 0.95)))
    if limits.motors is not None:
        _, speed = at_joints(limits.motors)
        factors.append(np.quantile(np.abs(acc.rates.q_dot) / speed, 0.95))
    if limits.joint_speed is not None:
        factors.append(np.quantile(np.abs(acc.rates.q_dot) / limits.joint_speed, 0.95))
    if limits.acceleration is not None:
        largest = np.linalg.norm(acc.xi_ddot, axis=1).max()
        factors.append(np.sqrt(largest / limits.acceleration))
    return max(factors)


def _path(problem, a, b):
    """Return points (n, 2) of the line from a to b, or of a shortest way round on a grid."""
    straight = a + np.linspace(0, 1, 101)[:, None] * (b - a)
    if (_blocked(problem, straight) <= 0).all():
        return straight
    low = np.minimum(a, b) - 2 * problem.length
    high = np.maximum(a, b) + 2 * problem.length
    axes = [np.linspace(low[i], high[i], GRID) for i in (0, 1)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(
        -1,
        2,
    )
    blocked = np.maximum(_blocked(problem, nodes), 0.0)
    # Edges from each node to its eight neighbours.
    number = np.arange(GRID**2).reshape(GRID, GRID)
    edges = [
        (number[1:], number[:-1]),
        (number[:, 1:], number[:, :-1]),
        (number[1:, 1:], number[:-1, :-1]),
        (number[1:, :-1], number[:-1, 1:]),
    ]
    i = np.concatenate([first.ravel() for first, _ in edges])
    j = np.concatenate([second.ravel() for _, second in edges])
    between = np.maximum(_blocked(problem, (nodes[i] + nodes[j]) / 2), 0.0)
    excess = blocked[i] + blocked[j] + between
    lengths = np.linalg.norm(nodes[i] - nodes[j], axis=1)
    cost = lengths + 100 * problem.length * excess
    ends = []
    for point in (a, b):
        distances = np.linalg.norm(nodes - point, axis=1)
        ends.append(int(np.argmin(distances + 1e3 * blocked)))
    first, last = ends
    graph = coo_array((cost, (i, j)), shape=(GRID**2,) * 2).tocsr()
    _, before = dijkstra(graph, directed=False, indices=first, return_predecessors=True)
    way = [last]
    while way[-1] != first:
        way.append(int(before[way[-1]]))
    path = np.concatenate([[a], nodes[way[::-1]], [b]])
    worst = path[np.argmax(_blocked(problem, path))]
    gap = -igm(problem.robot, worst, problem.working, unreachable="nan").reach_margin
    if gap > 0:
        raise PlanError(
            f"plan: start and goal are not connected in working modes {problem.working}: the way"
            f" with the narrowest gap leaves the reach of the bars by {gap:.3g} m near"
            f" ({worst[0]:.4g}, {worst[1]:.4g}) m",
            {"reach": gap},
        )
    along = np.append(0.0, np.cumsum(_steps(path)))
    path = _interpolated(
        np.linspace(0, along[-1], 101),
        along,
        path,
    )
    allowed = np.maximum(_blocked(problem, path), 0.0)
    for _ in range(SMOOTHINGS):
        smooth = path.copy()
        neighbours = path[:-2] + path[2:]
        smooth[1:-1] = (neighbours + 2 * path[1:-1]) / 4
        path = np.where(
            (_blocked(problem, smooth) <= allowed)[:, None],
            smooth,
            path,
        )
    return path


def _blocked(problem, xi):
    """Return the violations of limits at points (n, 2), over their units; > 1 out of reach."""
    pose = igm(problem.robot, xi, problem.working, unreachable="nan")
    excess = problem.violations(sines=problem.signed_sines(pose))
    if problem.constraints.region:
        corners = np.array(problem.constraints.region) @ (1, 1j)
        excess["region"] = -distance_inside(corners, xi @ (1, 1j))
    worst = np.max(
        [value / problem.unit(name) for name, value in excess.items()],
        axis=0,
    )
    unreachable = 2 - 10 * np.minimum(pose.reach_margin, 0) / problem.length
    return np.where(np.isnan(worst), unreachable, worst)
