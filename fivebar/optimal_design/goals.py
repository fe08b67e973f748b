"""Goals and limits of a search: figures with their senses and intervals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..base.checks import number, shown
from ..models.robots import Biglide, FiveBar
from .batch import is_number
from .figures import Figure, figures_of
from .task import Task

SENSE = {"small": "min", "large": "max"}


class Limit(NamedTuple):
    """An interval in which a figure must lie; -inf and inf are no limits."""

    figure: Figure
    low: float
    high: float


def goals_of(
    goals: Any, task: Task, robot: FiveBar | Biglide
) -> tuple[tuple[Figure, ...], tuple[str, ...]]:
    """Return the figures of the goals, and whether each is to be "min" or "max"."""
    has_senses = isinstance(goals, Mapping) and not any(map(callable, goals.values()))
    figures = figures_of(list(goals) if has_senses else goals, task, robot, "goals")
    if len(figures) > 3:
        raise ValueError(f"goals: at most three, not {len(figures)}: name the others as limits")
    given = goals.values() if has_senses else [None] * len(figures)
    senses = []
    for figure, sense in zip(figures, given):
        if sense not in ("min", "max", None):
            raise ValueError(f'goals: {figure.name} is to be "min" or "max", not {shown(sense)}')
        senses.append(sense or SENSE[figure.better])
    return figures, tuple(senses)


def limits_by_figure(limits: Any, task: Task, robot: FiveBar | Biglide) -> tuple[Limit, ...]:
    """Return the limits {figure: (low, high) or a number}."""
    if not isinstance(limits, Mapping):
        raise TypeError(f"limits must be a table, as {{'det_A': 0.5}}, not {shown(limits)}")
    figures = figures_of(list(limits), task, robot, "limits") if limits else ()
    return tuple(_limit(figure, value) for figure, value in zip(figures, limits.values()))


def _limit(figure, value):
    name = f"limits: {figure.name}"
    if is_number(value):
        value = (value, None) if figure.better == "large" else (None, value)
    try:
        low, high = value
    except (TypeError, ValueError):
        raise ValueError(f"{name} must have (low, high) or a number, not {shown(value)}") from None
    if low is None and high is None:
        raise ValueError(f"{name} has neither a low nor a high one")
    low = -np.inf if low is None else number(low, f"{name}'s low")
    high = np.inf if high is None else number(high, f"{name}'s high")
    if low > high:
        raise ValueError(f"{name} = ({low:g}, {high:g}) is the wrong way round")
    return Limit(figure, low, high)
