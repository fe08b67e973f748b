"""First motions between poses, the best ones first: ways and swings, improved on a coarse mesh."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .guess import first_guess
from .problem import Problem
from .shooting import Motions, Shooting, spline
from .swings import swings

if TYPE_CHECKING:
    from .guess import Guess

# Intervals of the coarse mesh: at least, and in the time that a bar takes to fall by half of its
# length. With 7.5 of them, motions that swing cost up to a hundred times what they do.
LEAST_INTERVALS = 24
FALLING = 12.0
PLANNED = 4.0  # of the plan's first mesh, in that time
TURN = 0.25  # rad or bars that a coarse motion moves in an interval of the plan's first mesh
MOST_INTERVALS = 240
SWINGS = 32
NODES = 4000  # of all motions together
# Of the first guess's, where the duration is free.
DURATIONS = 1.0, 0.6, 1.6
STEPS = 20  # of each coarse motion
KEPT = 10  # coarse motions, at most, that become starts
CLOSED = 0.5  # sum of all gaps, scaled, of a motion that may lead to a plan
SAME = 0.3  # rad or bars: motions that are nowhere farther apart are one


class Start(NamedTuple):
    """Where a plan begins: a problem, a mesh as of `program.solve`, a guess and its cost, SI."""

    problem: Problem
    mesh: list[np.ndarray]
    durations: np.ndarray
    guess: Guess
    cost: float = math.inf


class CoarseGuess(NamedTuple):
    """A coarse motion as the guess of a plan."""

    times: np.ndarray
    x: np.ndarray
    torques: np.ndarray

    def __call__(self, t: np.ndarray) -> np.ndarray:
        bars = spline(self.times, self.x)
        k = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.torques) - 1)
        derivatives = [bars(t, order) for order in range(3)]
        return np.concatenate([*derivatives, self.torques[k]], axis=1)


@np.errstate(all="ignore")  # what diverges has no merit
def starts_between(
    problems: list[tuple[Problem, Any]], intervals: int, is_over: Callable[[], bool]
) -> tuple[list[Start], int]:
    """Return starts, the one of least cost first, and the number of swings among all motions.

    problems: (problem, paths between its stops), the shortest first; intervals: of the plans' first
    mesh.
    """
    problem = problems[0][0]
    guesses = [(each, *first_guess(each, paths)) for each, paths in problems]
    free = problem.stops[-1][1] is None
    factors = DURATIONS if free else (1.0,)
    duration = float(guesses[0][2].sum())
    shooting = Shooting(problem, duration)
    falls = max(factors) * duration * problem.fall_rate
    count = min(max(LEAST_INTERVALS, math.ceil(FALLING * falls)), MOST_INTERVALS)
    most = max(NODES // count, 2)
    mesh = mesh_of(count, guesses[0][2])
    shot = []
    along = 0
    for factor in factors:
        for each, guess, durations in guesses[: max(most // (2 * len(factors)), 1)]:
            shot.append(_along(shooting, each, guess, durations, factor, mesh))
            along += 1
        if len(problem.stops) == 2:
            start, goal = (conditions[0] for conditions, _ in problem.stops)
            own = min(SWINGS, most) // len(factors)
            found = swings(shooting, start, goal, factor * duration, count, own)
            if found is not None:
                shot.append(found)
    motions = Motions.together(shot)
    number = len(motions.x) - along
    even = max(intervals, math.ceil(PLANNED * falls))
    raw = [
        Start(each, mesh_of(even, durations), durations, guess)
        for each, guess, durations in guesses
    ]
    for _ in range(STEPS):
        if is_over():
            return raw, number
        motions.improve()
    coarse = []
    for k in _best(motions)[:KEPT]:
        moves = np.abs(np.diff(motions.x[k, :, :4] / shooting.units[:4], axis=0))
        own = max(intervals, math.ceil(moves.max(axis=1).sum() / TURN))
        coarse.append(_start(problem, motions, k, own))
    return coarse + raw, number


def mesh_of(intervals: int, durations: np.ndarray) -> list[np.ndarray]:
    """Return even knots of the phases, about as many as their shares of all intervals."""
    share = np.round(intervals * durations / durations.sum())
    share = np.maximum(share.astype(int), 2)
    return [np.linspace(0, 1, n + 1) for n in share]


def _along(shooting, problem, guess, durations, factor, mesh):
    """Return one motion that passes a guess in `factor` of its time."""
    starts = np.append(0.0, np.cumsum(durations))
    times = [start + time * knots[:-1] for start, time, knots in zip(starts, durations, mesh)]
    times = np.append(np.concatenate(times), starts[-1])
    stops = np.append(0, np.cumsum([len(knots) - 1 for knots in mesh]))
    table = guess(times)
    x = table[:, :8]
    x[:, 4:] /= factor
    for number, (conditions, _) in zip(stops, problem.stops):
        x[number, :4] = conditions[0]
    x[[0, -1], 4:] = 0.0
    torques = np.clip(table[:-1, 12:], -shooting.torque, shooting.torque)
    return Motions(shooting, x[None], torques[None], factor * times[None], stops)


def _best(motions):
    """Return numbers of different motions whose gaps are small, that of the least merit first."""
    share = np.linspace(0, 1, 41)
    kept = []
    seen = []
    merit = np.where(motions.open < CLOSED, motions.merit(), np.nan)
    for k in np.argsort(merit)[: np.isfinite(merit).sum()]:
        t = motions.times[k]
        bars = spline(t, motions.x[k])(share * t[-1]) / motions.shooting.units[:4]
        if all(np.abs(bars - other).max() > SAME for other in seen):
            kept.append(int(k))
            seen.append(bars)
    return kept


def _start(problem, motions, k, intervals):
    """Return the Start of motion k, on a mesh that is finer where it is faster."""
    x, times = motions.x[k], motions.times[k]
    stops = []
    for number, (conditions, t) in zip(motions.stops, problem.stops):
        stops.append((conditions | {0: x[number, :4]}, t))
    own = replace(problem, stops=tuple(stops))
    durations = np.diff(times[motions.stops])
    rates = np.abs(x[:, 4:] / motions.shooting.units[:4]).max(axis=1)
    density = 10 / durations.min() + (rates[1:] + rates[:-1]) / 2
    along = np.append(0.0, np.cumsum(density * np.diff(times)))
    mesh = []
    for knots, first, last in zip(mesh_of(intervals, durations), motions.stops, motions.stops[1:]):
        even = along[first] + (along[last] - along[first]) * knots
        part = np.interp(even, along, times)
        mesh.append((part - part[0]) / (part[-1] - part[0]))
    guess = CoarseGuess(times, x, motions.torques[k])
    return Start(own, mesh, durations, guess, float(motions.cost[k]))
