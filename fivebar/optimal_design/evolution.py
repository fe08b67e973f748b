"""Differential evolution of many goals at once (GDE3): a population that keeps what nothing else is
better than.

Kukkonen and Lampinen, GDE3: the third evolution step of generalized differential evolution, IEEE
    CEC 2005; limits by
the rule of Deb, 2000: what keeps them is better than what does not, and of two that do not the one
    that is off by less.

Why no package: on the front of workspace against bars, whose answer is known (tests), 80 robots and
300 generations of pymoo 0.6's NSGA-II are off by up to 1e-1 at its worst point and these by 4e-2,
in the same time; `refine` makes 1e-8 of it in a quarter of that.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

CROSSED, LEAST, MOST = (
    0.9,
    0.3,
    0.9,
)  # share of coordinates that are new; of a difference that is added


def evolve(
    evaluate: Callable,
    low: np.ndarray,
    high: np.ndarray,
    goals: int,
    size: int,
    generations: int,
    rng: np.random.Generator,
    told: Callable = lambda: None,
    start: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A population (x (n, k), f (n, goals), off (n,)) after so many generations.

    evaluate: x (n, k) -> (f (n, goals), all to be small, off (n,), 0 where all limits are kept).
        told: after each.
    """
    x = low + (high - low) * _spread(size, len(low), rng)
    if start is not None:
        x[: len(start)] = start[:size]
    f, off = evaluate(x)
    for _ in range(generations):
        trial = _trial(x, low, high, rng)
        ft, offt = evaluate(trial)
        better, worse = dominates(ft, offt, f, off), dominates(f, off, ft, offt)
        both = ~better & ~worse  # neither is better: both stay for now
        new = np.where(better[:, None], trial, x)
        x = np.concatenate([new, trial[both]])
        f = np.concatenate([np.where(better[:, None], ft, f), ft[both]])
        off = np.concatenate([np.where(better, offt, off), offt[both]])
        keep = best(f, off, size)
        x, f, off = x[keep], f[keep], off[keep]
        told()
    return x, f, off


def _spread(size, count, rng):
    """A Latin square: each coordinate evenly filled."""
    cells = np.stack([rng.permutation(size) for _ in range(count)], axis=1)
    return (cells + rng.random((size, count))) / size


def _trial(x, low, high, rng):
    """x + F (x_a - x_b) around another one, crossed with itself, reflected at the bounds."""
    n, k = x.shape
    a, b, c = (rng.permuted(np.tile(np.arange(n), (3, 1)), axis=1)[j] for j in range(3))
    factor = rng.uniform(LEAST, MOST, (n, 1))
    mutant = x[a] + factor * (x[b] - x[c])
    mutant = np.where(mutant < low, 2 * low - mutant, mutant)
    mutant = np.where(mutant > high, 2 * high - mutant, mutant)
    new = rng.random((n, k)) < CROSSED
    new[np.arange(n), rng.integers(k, size=n)] = True
    return np.where(new, np.clip(mutant, low, high), x)


def dominates(f: np.ndarray, off: np.ndarray, g: np.ndarray, goff: np.ndarray) -> np.ndarray:
    """Where f is better than g: in some goal and worse in none, limits first."""
    kept = (f <= g).all(axis=-1) & (f < g).any(axis=-1)
    return np.where((off > 0) | (goff > 0), off < goff, kept)


def best(f: np.ndarray, off: np.ndarray, count: int) -> np.ndarray:
    """Indices of the best: what nothing is better than, then the same of the rest, ...; of the last
    the loneliest.
    """
    left, kept = np.arange(len(f)), []
    while len(left):
        beaten = dominates(
            f[left][:, None], off[left][:, None], f[left][None], off[left][None]
        ).any(axis=0)
        front = left[~beaten]
        if len(kept) + len(front) >= count:
            return np.array(kept + thinned(f, front, count - len(kept)))
        kept += front.tolist()
        left = left[beaten]
    return np.array(kept)


def thinned(f: np.ndarray, front: np.ndarray, count: int) -> list[int]:
    """So many of a front, evenly spread: one by one the most crowded goes; the ends of each goal
    stay.
    """
    front = np.asarray(front)
    g = f[front]
    g = (g - g.min(axis=0)) / np.maximum(np.ptp(g, axis=0), 1e-300)
    alive = np.ones(len(front), dtype=bool)
    if g.shape[1] > 2:
        apart = np.linalg.norm(g[:, None] - g[None], axis=2)
        np.fill_diagonal(apart, np.inf)
    ends = set(g.argmin(axis=0).tolist())
    while alive.sum() > count:
        here = np.flatnonzero(alive)
        if g.shape[1] <= 2:
            order = here[np.argsort(g[here, 0], kind="stable")]
            room = np.full(len(order), np.inf)
            room[1:-1] = np.abs(g[order[2:]] - g[order[:-2]]).sum(axis=1)
        else:
            order = here
            near = np.sort(apart[np.ix_(here, here)], axis=1)[:, : g.shape[1]]
            room = near.prod(axis=1)
        free = [k for k in range(len(order)) if order[k] not in ends] or list(range(len(order)))
        alive[order[min(free, key=lambda k: room[k])]] = False
    return front[alive].tolist()


def refine(
    evaluate: Callable,
    low: np.ndarray,
    high: np.ndarray,
    x: np.ndarray,
    f: np.ndarray,
    chosen: np.ndarray,
    members: int,
    generations: int,
    rng: np.random.Generator,
    told: Callable = lambda: None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Each of the chosen points of a front driven on by a small population of its own: (x, f, off)
    of all of them.

    A point's aim is to gain in all goals by equal shares of the front's range (Wierzbicki's
    achievement function); an end of the front is to gain in its own goal. All populations are
    evaluated together.
    """
    span = np.maximum(np.ptp(f[chosen], axis=0), 1e-300)
    aim, many = f[chosen], len(chosen)
    ends = (
        {int(k): goal for goal, k in enumerate(f[chosen].argmin(axis=0))}
        if many > f.shape[1]
        else {}
    )

    def worth(g):
        share = (g - aim[:, None]) / span
        value = share.max(axis=2) + 1e-4 * share.sum(axis=2)
        for k, goal in ends.items():
            value[k] = share[k, :, goal] + 1e-4 * share[k].sum(axis=1)
        return value

    def all_of(points):
        g, off = evaluate(points.reshape(-1, points.shape[2]))
        return g.reshape(many, members, -1), off.reshape(many, members)

    near = np.argsort(np.linalg.norm((f[chosen][:, None] - f[None]) / span, axis=2), axis=1)[
        :, :members
    ]
    group = x[near]
    if group.shape[1] < members:
        group = np.concatenate(
            [group, np.repeat(group[:, :1], members - group.shape[1], axis=1)], axis=1
        )
    group[:, 1:] += rng.normal(0, 0.01, group[:, 1:].shape) * (high - low)
    group = np.clip(group, low, high)
    g, off = all_of(group)
    value = worth(g)
    row = np.arange(many)[:, None]
    for _ in range(generations):
        order = np.lexsort((value, off))  # of each group, the best first
        top = group[row[:, 0], order[:, 0]][:, None]
        a, b = (rng.integers(members, size=(many, members)) for _ in range(2))
        factor = rng.uniform(LEAST, MOST, (many, members, 1))
        pull = rng.uniform(0, 1, (many, members, 1))
        mutant = group + pull * (top - group) + factor * (group[row, a] - group[row, b])
        mutant = np.where(
            mutant < low, (low + group) / 2, np.where(mutant > high, (high + group) / 2, mutant)
        )
        new = rng.random(group.shape) < CROSSED
        trial = np.where(new, mutant, group)
        gt, offt = all_of(trial)
        valuet = worth(gt)
        better = np.where((off > 0) | (offt > 0), offt < off, valuet <= value)
        group, g = np.where(better[..., None], trial, group), np.where(better[..., None], gt, g)
        off, value = np.where(better, offt, off), np.where(better, valuet, value)
        told()
    first = np.lexsort((value, off))[:, 0]
    at = row[:, 0], first
    return group[at], g[at], off[at]
