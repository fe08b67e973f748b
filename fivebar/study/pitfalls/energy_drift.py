"""Integrators on one conservative motion: how much energy each of them gains or loses."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...models.geometry import dgm
from ...models.kinematics import dkm
from ...models.named_robots import ROBOTS
from ...simulation.simulate import simulate
from .integrators import adaptive, explicit_euler, march, rk4, semi_implicit_euler
from .joint_space import joint_model, joint_slope

if TYPE_CHECKING:
    from ...models.kinematics import Rates

# A robot without Type 2, so that what is lost is lost by the integrators alone; its inertias are
# ours.
ROBOT = replace(ROBOTS["hoang-2015"].robot, zz1=0.002, zz2=0.002, m=0.5)
FIXED = {"explicit Euler": explicit_euler, "semi-implicit Euler": semi_implicit_euler, "RK4": rk4}


def conservative_start() -> Rates:
    """No torque, and both cranks turn: about 3 rad/s, at different rates."""
    return dkm(dgm(ROBOT, (1.0, 2.0)), (3.0, -2.0))


@dataclass(frozen=True, eq=False)
class Drift:
    """A motion's energy: t (n,) s, relative error (n,), and how often the model was evaluated."""

    name: str
    t: np.ndarray
    error: np.ndarray
    evaluations: int

    @property
    def worst(self) -> float:
        """The largest error; infinite where the solver did not get to the end."""
        return float(np.abs(self.error).max()) if len(self.error) else math.inf


def drift_by(name: str, step: float = 1e-3, duration: float = 10.0, rtol: float = 1e-3) -> Drift:
    """Energy along the motion by explicit or semi-implicit Euler, RK4 (step in s), or a SciPy
    solver (rtol).
    """
    start = conservative_start()
    assembly = int(start.pose.assembly)
    slope, state = joint_slope(ROBOT, assembly), np.concatenate([start.pose.q, start.q_dot])
    if name in FIXED:
        t, states = march(FIXED[name], slope, state, duration, step)
        evaluations = (len(t) - 1) * (4 if name == "RK4" else 1)
    else:
        found = adaptive(
            slope, state, np.linspace(0, duration, 1001), name, rtol=rtol, atol=1e-3 * rtol
        )
        t, states, evaluations = found.t, found.states, found.evaluations
    if not len(t):
        return Drift(name, t, t, evaluations)
    return _drift(name, t, joint_model(ROBOT, states.T, assembly)[3], evaluations)


def drift_of_ours(step: float = 1e-3, duration: float = 10.0) -> Drift:
    """The same by fivebar.simulate, in fixed steps."""
    run = simulate(ROBOT, duration=duration, start=conservative_start(), step=step, method="rk4")
    return _drift("fivebar", run.t, run.energy, 4 * (len(run.t) - 1))


def _drift(name, t, energy, evaluations):
    return Drift(name, t, energy / energy[0] - 1, evaluations)
