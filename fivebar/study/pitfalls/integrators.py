"""Integrators that the cases share.

A slope is (t, state (k, ...)) -> (k, ...), positions first, then rates.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

Slope = Callable[[Any, np.ndarray], np.ndarray]


def explicit_euler(slope: Slope, t: float, state: np.ndarray, step: float) -> np.ndarray:
    """Return the state after a step of the explicit Euler method."""
    return state + step * slope(t, state)


def semi_implicit_euler(slope: Slope, t: float, state: np.ndarray, step: float) -> np.ndarray:
    """Return the state after a step: rates first, then positions with the new rates.

    It is symplectic only where the inertia is constant.
    """
    half = len(state) // 2
    rates = state[half:] + step * slope(t, state)[half:]
    return np.concatenate([state[:half] + step * rates, rates])


def rk4(slope: Slope, t: float, state: np.ndarray, step: float | np.ndarray) -> np.ndarray:
    """Return the state after a step of the classical Runge-Kutta method."""
    k1 = slope(t, state)
    k2 = slope(t + step / 2, state + step / 2 * k1)
    k3 = slope(t + step / 2, state + step / 2 * k2)
    k4 = slope(t + step, state + step * k3)
    return state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def march(
    method: Callable, slope: Slope, state: np.ndarray, duration: float, step: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return times (n,) and states (n, k) of a fixed-step method, both ends included."""
    t = np.arange(round(duration / step) + 1) * step
    states = np.empty((len(t), len(state)))
    states[0] = state
    for k in range(len(t) - 1):
        states[k + 1] = method(slope, t[k], states[k], step)
    return t, states


@dataclass(frozen=True, eq=False)
class Solution:
    """The result of a SciPy solver: t (n,) s, states (n, k), whether it claims success,
    evaluations of the slope.
    """

    t: np.ndarray
    states: np.ndarray
    success: bool
    evaluations: int


class _TooMany(Exception):
    pass


def adaptive(
    slope: Slope,
    state: np.ndarray,
    t_eval: np.ndarray,
    method: str,
    rtol: float = 1e-3,
    atol: float = 1e-6,
    limit: int = 100_000,
) -> Solution:
    """Return the result of SciPy's solve_ivp at t_eval (n,) s.

    A solver that meets nan may go on for ever: it is stopped after `limit` evaluations.
    """
    count = 0

    def counted(t, y):
        nonlocal count
        count += 1
        if count > limit:
            raise _TooMany
        return slope(t, y)

    span = (t_eval[0], t_eval[-1])
    tolerances = {"rtol": rtol, "atol": atol}
    try:
        with np.errstate(all="ignore"):
            result = solve_ivp(counted, span, state, method=method, t_eval=t_eval, **tolerances)
    except (_TooMany, ValueError, np.linalg.LinAlgError):
        return Solution(np.empty(0), np.empty((0, len(state))), False, count)
    return Solution(result.t, result.y.T, result.success, count)
