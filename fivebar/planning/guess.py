"""First guesses of the planner: along a path within the limits, about as fast as they allow."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from ..constraints.constraints import at_joints, distance_inside
from ..models.dynamics import inverse_dynamics
from ..models.geometry import igm
from .coordinates import bars
from .problem import PlanError, Problem

if TYPE_CHECKING:
    from collections.abc import Callable

    from .plans import Plan

    Guess = Callable[[np.ndarray], np.ndarray]  # times (n,) s -> (n, 8): motion, bar forces

GRID = 121  # nodes per side of the grid on which a first path is searched
SMOOTHINGS = 100  # passes over that path
BENDS = 0.3, -0.3, 0.6, -0.6, 1.0, -1.0  # of a distal bar, to the left, of paths beside the line


class GuessAgain(NamedTuple):
    """A plan as the guess of the next one, with its controls at the nodes.

    Forces are interpolated between nodes, as computed ones might be huge there.
    """

    plan: Plan
    controls: np.ndarray

    def __call__(self, t: np.ndarray) -> np.ndarray:
        motion = self.plan.motion(t)
        controls = _interpolated(t, self.plan.nodes, self.controls)
        return np.column_stack([motion[..., :-2], controls])


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
    units = problem.coordinates.units(problem)
    shares = np.maximum(lengths, 0.05 * units.max())
    sigma = np.linspace(0, 1, 201)
    blend = sigma**3 * (10 - 15 * sigma + 6 * sigma**2)
    motions = []
    for path in paths:
        steps = np.ones(len(path) - 1) if even else _steps(path)
        along = np.append(0.0, np.cumsum(steps))
        xi = _interpolated(blend * along[-1], along, path)
        xi_dot = np.gradient(xi, sigma, axis=0)
        xi_ddot = np.gradient(xi_dot, sigma, axis=0)
        motions.append((xi, xi_dot, xi_ddot))
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
    ends = np.cumsum(durations)
    times = []
    rows = []
    for derivatives, duration, end in zip(motions, durations, ends):
        motion = _in_time(derivatives, duration)
        times.append(end + duration * (sigma - 1))
        rows.append(np.pad(motion, [(0, 0), (0, 2)]))  # under no force
    times = np.concatenate(times)
    table = np.concatenate(rows)
    return lambda t: _interpolated(t, times, table), durations


def in_bars(problem: Problem) -> list[tuple[Problem, list[np.ndarray]]]:
    """Return (problem in the four bars, paths of the bars between its stops) along several ways.

    The first one is straight where the limits allow. Between two stops there are others, bent to a
    side.
    """
    points = [np.array(conditions[0]) for conditions, _ in problem.stops]
    legs = list(zip(points, points[1:]))
    ways = [[_path(problem, a, b) for a, b in legs]]
    if len(legs) == 1:
        arcs = [bent(*legs[0], bend * problem.length) for bend in BENDS]
        ways += [[arc] for arc in arcs if (_blocked(problem, arc) <= 0).all()]
    found = []
    for way in ways:
        pose = igm(problem.robot, np.concatenate(way), problem.working)
        angles = np.unwrap(bars(pose), axis=0)
        paths = np.split(angles, np.cumsum([len(path) for path in way])[:-1])
        ends = [paths[0][0], *(path[-1] for path in paths)]
        stops = []
        for end, (conditions, t) in zip(ends, problem.stops):
            own = {order: np.zeros(4) for order in conditions} | {0: end}
            stops.append((own, t))
        found.append((replace(problem, stops=tuple(stops)), paths))
    return found


def bent(a: np.ndarray, b: np.ndarray, bend: float) -> np.ndarray:
    """Return points (61, 2) of a parabola from a to b that is `bend`, m, to their left at most."""
    share = np.linspace(0, 1, 61)[:, None]
    x, y = (b - a) / max(np.linalg.norm(b - a), 1e-300)
    return a + share * (b - a) + 4 * share * (1 - share) * bend * np.array([-y, x])


def _in_time(derivatives, duration):
    """Return the motion (n, 6) of a phase from its derivatives by the share of its duration."""
    return np.concatenate(
        [value / duration**order for order, value in enumerate(derivatives)], axis=1
    )


def _steps(path):
    return np.linalg.norm(np.diff(path, axis=0), axis=1)


def _interpolated(x, nodes, table):
    return np.stack([np.interp(x, nodes, column) for column in table.T], axis=-1)


def _time_needed(problem, derivatives, duration):
    """Return the factor by which a phase of `duration` is to be stretched.

    Torque goes as 1 / time^2, speed as 1 / time.
    """
    motion = _in_time(derivatives, duration)
    acc = problem.accelerations(motion)
    limits = problem.constraints
    weights = problem.weights
    regular = np.abs(acc.rates.pose.det_A) > 0.1
    tau = np.zeros((1, 2))
    if regular.any():
        tau = inverse_dynamics(problem.accelerations(motion[regular]))
    xi_dddot = np.gradient(acc.xi_ddot, duration / 200, axis=0)
    effort = _mean_square(tau) * duration
    jerk = _mean_square(xi_dddot) * duration
    by_effort = 3 * weights["effort"] * effort / weights["time"] / duration
    by_jerk = 5 * weights["jerk"] * jerk / weights["time"] / duration
    factors = [1e-3, by_effort**0.25, by_jerk ** (1 / 6)]
    joint_speed = np.abs(acc.rates.q_dot)
    if limits.torque is not None:
        used = np.abs(tau) / limits.torque
        factors.append(np.sqrt(np.quantile(used, 0.95)))
    if limits.motors is not None:
        _, speed = at_joints(limits.motors)
        factors.append(np.quantile(joint_speed / speed, 0.95))
    if limits.joint_speed is not None:
        factors.append(np.quantile(joint_speed / limits.joint_speed, 0.95))
    if limits.acceleration is not None:
        largest = np.linalg.norm(acc.xi_ddot, axis=1).max()
        factors.append(np.sqrt(largest / limits.acceleration))
    return max(factors)


def _mean_square(vectors):
    squares = np.sum(vectors**2, axis=1)
    return np.mean(squares)


def _path(problem, a, b):
    """Return points (n, 2) of the line from a to b, or of a shortest way round on a grid."""
    share = np.linspace(0, 1, 101)
    straight = a + share[:, None] * (b - a)
    if (_blocked(problem, straight) <= 0).all():
        return straight
    margin = 2 * problem.length
    low = np.minimum(a, b) - margin
    high = np.maximum(a, b) + margin
    axes = np.linspace(low, high, GRID).T
    x, y = np.meshgrid(*axes, indexing="ij")
    nodes = np.column_stack([x.ravel(), y.ravel()])
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
    middles = (nodes[i] + nodes[j]) / 2
    between = np.maximum(_blocked(problem, middles), 0.0)
    excess = blocked[i] + blocked[j] + between
    lengths = np.linalg.norm(nodes[i] - nodes[j], axis=1)
    cost = lengths + 100 * problem.length * excess
    ends = []
    for point in (a, b):
        distances = np.linalg.norm(nodes - point, axis=1)
        nearest = np.argmin(distances + 1e3 * blocked)
        ends.append(int(nearest))
    first, last = ends
    graph = coo_array((cost, (i, j)), shape=(GRID**2,) * 2)
    _, before = dijkstra(graph.tocsr(), directed=False, indices=first, return_predecessors=True)
    way = [last]
    while way[-1] != first:
        way.append(int(before[way[-1]]))
    path = np.concatenate([[a], nodes[way[::-1]], [b]])
    worst = path[np.argmax(_blocked(problem, path))]
    pose = igm(problem.robot, worst, problem.working, unreachable="nan")
    gap = -pose.reach_margin
    if gap > 0:
        x, y = worst
        raise PlanError(
            f"plan: start and goal are not connected in working modes {problem.working}: the way"
            f" with the narrowest gap leaves the reach of the bars by {gap:.3g} m near"
            f" ({x:.4g}, {y:.4g}) m",
            {"reach": gap},
        )
    along = np.append(0.0, np.cumsum(_steps(path)))
    even = np.linspace(0, along[-1], 101)
    path = _interpolated(even, along, path)
    allowed = np.maximum(_blocked(problem, path), 0.0)
    for _ in range(SMOOTHINGS):
        smooth = path.copy()
        neighbours = path[:-2] + path[2:]
        smooth[1:-1] = (neighbours + 2 * path[1:-1]) / 4
        keeps = _blocked(problem, smooth) <= allowed
        path = np.where(keeps[:, None], smooth, path)
    return path


def _blocked(problem, xi):
    """Return the violations of limits at points (n, 2), over their units; > 1 out of reach."""
    pose = igm(problem.robot, xi, problem.working, unreachable="nan")
    excess = problem.violations(sines=problem.signed_sines(pose))
    if problem.constraints.region:
        corners = np.array(problem.constraints.region) @ (1, 1j)
        excess["region"] = -distance_inside(corners, xi @ (1, 1j))
    worst = np.max([value / problem.unit(name) for name, value in excess.items()], axis=0)
    beyond = np.minimum(pose.reach_margin, 0)
    unreachable = 2 - 10 * beyond / problem.length
    return np.where(np.isnan(worst), unreachable, worst)
