"""Costs and constraints of the user's own: functions of a motion, as CasADi's symbols."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from ..base.backend import numpy_on_symbols
from ..base.checks import shown
from ..models.kinematics import Accelerations


class MotionPoint(NamedTuple):
    """What a function of the user's own gets: quantities of a motion at one time, CasADi's symbols.

    t: s; all others are 2 x 1, in SI: the left and the right joint, x and y, or both distal bars.
    """

    t: Any
    q: Any
    q_dot: Any
    q_ddot: Any
    xi: Any
    xi_dot: Any
    xi_ddot: Any
    tau: Any
    bar_forces: Any

    @classmethod
    def of(cls, t: Any, acc: Accelerations, tau: Any, bar_forces: Any) -> MotionPoint:
        """Return the point of a motion, of symbols or numbers."""
        rates = acc.rates
        pose = rates.pose
        velocities = rates.q_dot, acc.q_ddot, pose.xi, rates.xi_dot, acc.xi_ddot
        return cls(t, pose.q, *velocities, tau, bar_forces)


@dataclass(frozen=True)
class OwnFunctions:
    """The user's cost (the integrand) and constraints (>= 0), checked.

    text: CasADi's function of a MotionPoint -> cost, constraints (k), which other processes can
    read.
    """

    costs: tuple[str, ...]
    constraints: tuple[str, ...]
    text: str

    @classmethod
    def of(cls, costs: Iterable[tuple], constraints: Iterable[tuple]) -> OwnFunctions | None:
        """Return those of (name, function) pairs, None where there are none; ValueError."""
        costs, constraints = tuple(costs), tuple(constraints)
        if not costs and not constraints:
            return None
        vectors = (ca.SX.sym(name, 2) for name in MotionPoint._fields[1:])
        point = MotionPoint(ca.SX.sym("t"), *vectors)
        cost = ca.SX(0)
        for name, function in costs:
            cost += _expression(f"{name!r} of the objective", function, point)
        kept = [
            _expression(f"{name!r} of the constraints", each, point) for name, each in constraints
        ]
        outputs = [ca.densify(cost), ca.densify(ca.vertcat(*kept))]
        function = ca.Function("own", [*point], outputs)
        return cls(tuple(dict(costs)), tuple(dict(constraints)), function.serialize())

    @cached_property
    def function(self) -> ca.Function:
        return ca.Function.deserialize(self.text)

    def __getstate__(self) -> dict:
        return {"costs": self.costs, "constraints": self.constraints, "text": self.text}

    def values(self, point: MotionPoint) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return the cost (n,) and {name: constraint (n,)} along numbers (n, 2)."""
        t: Any = point.t
        columns = map(np.transpose, point[1:])
        cost, values = (each.full() for each in self.function(t[None], *columns))
        return cost[0], dict(zip(self.constraints, values, strict=True))


def _expression(what, function, point):
    """Return what a function makes of the symbols of a point; ValueError where it is no number."""
    try:
        with numpy_on_symbols():
            value = ca.SX(function(point))
    except Exception as error:  # Whatever a function of numbers raises when it is given symbols.
        raise ValueError(
            f"plan: {what} fails on CasADi's symbols: {str(error).strip().splitlines()[0]}. It gets"
            f" one argument with {', '.join(MotionPoint._fields)}, and returns a number; write it"
            " with arithmetic and CasADi's functions, as casadi.if_else in place of if"
        ) from error
    if value.numel() != 1:
        raise ValueError(
            f"plan: {what} must return one number, not {value.numel()}: {shown(value)}"
        )
    known = ca.vertcat(*point)
    if free := ca.Function("f", [known], [value], {"allow_free": True}).get_free():
        raise ValueError(
            f"plan: {what} depends on the symbol {free[0]}, which is no quantity of the motion:"
            " give its value"
        )
    slope = ca.jacobian(value, known)
    at = np.random.default_rng(0).uniform(0.1, 1.0, (known.numel(), 8))
    slopes = ca.Function("slope", [known], [slope])(at).full()
    if not slopes.any():
        raise ValueError(
            f"plan: {what} is not differentiable, or constant: its slope is 0 everywhere, so that"
            " the optimizer cannot follow it (sign, floor and comparisons are such steps)"
        )
    return value


def refuse_not_finite(
    own: OwnFunctions, values: np.ndarray, slopes: np.ndarray, t: np.ndarray
) -> None:
    """Raise where own functions (cost, constraints) or their slopes are not finite on a guess."""
    names = " + ".join(own.costs), *own.constraints
    for name, row in zip(names, values):
        bad = np.flatnonzero(~np.isfinite(row))
        if bad.size:
            k = bad[0]
            raise ValueError(f"plan: {name} is {row[k]} on the first guess, at t = {t[k]:.4g} s")
    if not np.isfinite(slopes).all():
        raise ValueError(
            f"plan: the slope of {', '.join(filter(None, names))} is not finite on the first guess:"
            " of a root of 0, for instance (add a small number under it)"
        )
