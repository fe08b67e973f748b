"""Differential evolution of several goals at once (GDE3), and of each point of a front.

Why no package: on the front of workspace against bars, whose answer is known (tests), 80 robots and
300 generations of pymoo 0.6's NSGA-II are off by up to 1e-1 at its worst point and these by 4e-2,
in the same time; `refine` makes 1e-8 of it in a quarter of that.

References
----------
Kukkonen and Lampinen, GDE3: the third evolution step of generalized differential evolution, IEEE
CEC 2005. Limits by the rule of Deb, 2000: a feasible design is better than an infeasible one, and
of two infeasible ones that of the smaller violation.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

CROSSOVER = 0.9  # share of coordinates that a trial takes from its mutant
FACTOR = (0.3, 0.9)  # of a difference of two designs that is added


def evolve(
    evaluate: Callable,
    low: np.ndarray,
    high: np.ndarray,
    size: int,
    generations: int,
    rng: np.random.Generator,
    callback: Callable = lambda: None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a population after so many generations: (x (n, k), f (n, goals), violation (n,)).

    evaluate: x (n, k) -> (f (n, goals), all to be small, violation (n,), 0 where all limits are
    kept).
    """
    # A Latin hypercube: each coordinate is filled evenly.
    cells = np.stack([rng.permutation(size) for _ in low], axis=1)
    x = low + (high - low) * ((cells + rng.random(cells.shape)) / size)
    population = [x, *evaluate(x)]
    for _ in range(generations):
        trial = _trial(population[0], low, high, rng)
        trials = [trial, *evaluate(trial)]
        better = dominates(*trials[1:], *population[1:])
        neither = ~better & ~dominates(*population[1:], *trials[1:])
        for old, new in zip(population, trials):
            old[better] = new[better]
        population = [np.concatenate([old, new[neither]]) for old, new in zip(population, trials)]
        kept = best(population[1], population[2], size)
        population = [array[kept] for array in population]
        callback()
    return tuple(population)


def _trial(x, low, high, rng):
    """Return x_a + F (x_b - x_c), reflected at the bounds, crossed with x."""
    n, k = x.shape
    a, b, c = (rng.permuted(np.tile(np.arange(n), (3, 1)), axis=1)[j] for j in range(3))
    mutant = x[a] + rng.uniform(*FACTOR, (n, 1)) * (x[b] - x[c])
    mutant = np.maximum(mutant, 2 * low - mutant)
    mutant = np.minimum(mutant, 2 * high - mutant)
    new = rng.random((n, k)) < CROSSOVER
    new[np.arange(n), rng.integers(k, size=n)] = True
    return np.where(new, mutant, x)


def dominates(
    f: np.ndarray, violation_f: np.ndarray, g: np.ndarray, violation_g: np.ndarray
) -> np.ndarray:
    """Return where f is better than g: in some goal and worse in none, limits first."""
    feasible = (f <= g).all(axis=-1) & (f < g).any(axis=-1)
    infeasible = (violation_f > 0) | (violation_g > 0)
    return np.where(infeasible, violation_f < violation_g, feasible)


def best(f: np.ndarray, violation: np.ndarray, count: int) -> np.ndarray:
    """Return `count` indices of the best: the first non-dominated fronts; of the last the least
    crowded.
    """
    left = np.arange(len(f))
    kept: list[int] = []
    while True:
        g = f[left]
        v = violation[left]
        dominated = dominates(g[:, None], v[:, None], g[None], v[None]).any(axis=0)
        front = left[~dominated]
        if len(kept) + len(front) >= count:
            return np.array(kept + thinned(f, front, count - len(kept)))
        kept += front.tolist()
        left = left[dominated]


def thinned(f: np.ndarray, front: np.ndarray, count: int) -> list[int]:
    """Return `count` members of a front, without those of the smallest crowding distances.

    They are removed one by one; the best of each goal stay. The distance is the sum of the sides of
    the box between both neighbours, of three goals the product of the three smallest distances.
    """
    g = f[front]
    g = (g - g.min(axis=0)) / np.maximum(np.ptp(g, axis=0), 1e-300)
    is_end = np.zeros(len(g), dtype=bool)
    is_end[g.argmin(axis=0)] = True
    two_goals = g.shape[1] == 2
    if two_goals:
        left = np.argsort(g[:, 0], kind="stable")
    else:
        left = np.arange(len(g))
        distance = np.linalg.norm(g[:, None] - g, axis=2)
    while len(left) > count:
        if two_goals:
            crowding = np.full(len(left), np.inf)
            crowding[1:-1] = np.abs(g[left[2:]] - g[left[:-2]]).sum(axis=1)
        else:
            nearest = np.sort(distance[np.ix_(left, left)], axis=1)
            crowding = nearest[:, 1:4].prod(axis=1)
        crowding[is_end[left]] = np.inf
        left = np.delete(left, crowding.argmin())
    return front[np.sort(left)].tolist()


def refine(
    evaluate: Callable,
    low: np.ndarray,
    high: np.ndarray,
    x: np.ndarray,
    f: np.ndarray,
    chosen: list[int],
    members: int,
    generations: int,
    rng: np.random.Generator,
    callback: Callable = lambda: None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the chosen points of a front, each improved: (x, f, violation).

    Each has a population of `members`, which gains in all goals by equal shares of the front's
    range (Wierzbicki's achievement function); at an end of the front it gains in that goal. All
    populations are evaluated together. SciPy's differential evolution of each point, in the same
    time, is a hundred times less exact on the front of the tests.
    """
    count = len(chosen)
    aim = f[chosen]
    span = np.maximum(np.ptp(aim, axis=0), 1e-300)
    ends = aim.argmin(axis=0) if count > f.shape[1] else []
    row = np.arange(count)[:, None]

    def evaluate_groups(group):
        g, violation = evaluate(group.reshape(-1, group.shape[2]))
        share = (g.reshape(count, members, -1) - aim[:, None]) / span
        largest = share.max(axis=2)
        for goal, k in enumerate(ends):
            largest[k] = share[k, :, goal]
        value = largest + 1e-4 * share.sum(axis=2)
        return [group, g.reshape(share.shape), violation.reshape(count, members), value]

    distance = np.linalg.norm((aim[:, None] - f) / span, axis=2)
    nearest = np.argsort(distance, axis=1)[:, :members]
    # Where the front is small, each group is filled with its own point.
    nearest = nearest[:, np.arange(members) * (np.arange(members) < nearest.shape[1])]
    group = x[nearest]
    group[:, 1:] += rng.normal(0, 0.01, group[:, 1:].shape) * (high - low)
    groups = evaluate_groups(np.clip(group, low, high))
    for _ in range(generations):
        group, _, violation, value = groups
        top = group[row, np.lexsort((value, violation))[:, :1]]
        a, b = (rng.integers(members, size=(count, members)) for _ in range(2))
        factor = rng.uniform(*FACTOR, (count, members, 1))
        pull = rng.uniform(0, 1, (count, members, 1))
        mutant = group + pull * (top - group) + factor * (group[row, a] - group[row, b])
        inside = np.where(mutant < low, (low + group) / 2, mutant)
        inside = np.where(mutant > high, (high + group) / 2, inside)
        trials = evaluate_groups(np.where(rng.random(group.shape) < CROSSOVER, inside, group))
        infeasible = (violation > 0) | (trials[2] > 0)
        better = np.where(infeasible, trials[2] < violation, trials[3] <= value)
        for old, new in zip(groups, trials):
            old[better] = new[better]
        callback()
    group, g, violation, value = groups
    first = row[:, 0], np.lexsort((value, violation))[:, 0]
    return group[first], g[first], violation[first]
