"""What a search is for, and what it has to keep: figures with their senses and limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.checks import number, shown
from ..models.robots import Biglide, FiveBar
from .batch import alone
from .figures import Figure, figures_of
from .task import Task

SENSES = {"min": "small", "small": "small", "max": "large", "large": "large"}
SENSE_OF = {1.0: "min", -1.0: "max"}


@dataclass(frozen=True)
class Limit:
    figure: Figure
    low: float
    high: float


def goals_of(
    goals: Any, task: Task, robot: FiveBar | Biglide
) -> tuple[tuple[Figure, ...], np.ndarray]:
    """The figures, and the sign with which each is to be small."""
    asked = goals if isinstance(goals, Mapping) else {}
    figures = figures_of(list(asked) if asked else goals, task, robot, "goals")
    if len(figures) > 3:
        raise ValueError(f"goals: at most three, not {len(figures)}: name the others as limits")
    senses = [asked.get(key) for key in asked] if asked else [each.better for each in figures]
    for figure, sense in zip(figures, senses):
        if not isinstance(sense, str) or sense not in SENSES:
            raise ValueError(f'goals: {figure.name} is to be "min" or "max", not {shown(sense)}')
    return figures, np.array([1.0 if SENSES[sense] == "small" else -1.0 for sense in senses])


def limits_by_figure(limits: Any, task: Task, robot: FiveBar | Biglide) -> tuple[Limit, ...]:
    """The limits {figure: (low, high) or a number}."""
    if not isinstance(limits, Mapping):
        raise TypeError(f"limits must be a table, as {{'det_A': 0.5}}, not {shown(limits)}")
    if not limits:
        return ()
    found = []
    for figure, asked in zip(figures_of(list(limits), task, robot, "limits"), limits.values()):
        if alone(asked):
            asked = (asked, None) if figure.better == "large" else (None, asked)
        try:
            low, high = asked
        except (TypeError, ValueError):
            raise ValueError(
                f"limits: {figure.name} must have (low, high) or a number, not {shown(asked)}"
            ) from None
        low = -np.inf if low is None else number(low, f"limits: {figure.name}'s low")
        high = np.inf if high is None else number(high, f"limits: {figure.name}'s high")
        if low > high:
            raise ValueError(f"limits: {figure.name} = ({low:g}, {high:g}) is the wrong way round")
        if np.isinf(low) and np.isinf(high):
            raise ValueError(f"limits: {figure.name} has neither a low nor a high one")
        found.append(Limit(figure, low, high))
    return tuple(found)
