"""Integrators on one conservative motion: how much energy each of them gains or loses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...models.geometry import dgm
from ...models.kinematics import Rates, dkm
from ...models.named_robots import ROBOTS
from ...simulation.settings import Integrator
from ...simulation.simulate import simulate
from .integrators import adaptive, explicit_euler, march, rk4, semi_implicit_euler
from .joint_space import joint_model, joint_slope

# A robot without Type 2, so that only the integrators lose energy; its inertias are ours.
ROBOT: Any = replace(ROBOTS["hoang-2015"].robot, zz1=0.002, zz2=0.002, m=0.5)
FIXED = {"explicit Euler": explicit_euler, "semi-implicit Euler": semi_implicit_euler, "RK4": rk4}


def conservative_start() -> Rates:
    """Return a state from which, without torque, both cranks turn: at about 3 rad/s."""
    return dkm(dgm(ROBOT, (1.0, 2.0)), (3.0, -2.0))


@dataclass(frozen=True, eq=False)
class Drift:
    """The energy of a motion: t (n,) s, relative error (n,), evaluations of the model."""

    name: str
    t: np.ndarray
    error: np.ndarray
    evaluations: int


def drift_by(name: str, step: float = 1e-3, duration: float = 10.0, rtol: float = 1e-3) -> Drift:
    """Return the drift of explicit or semi-implicit Euler, RK4 (step in s), or a SciPy solver."""
    start = conservative_start()
    assembly = int(start.pose.assembly)
    slope = joint_slope(ROBOT, assembly)
    state = np.concatenate([start.pose.q, start.q_dot])
    if name in FIXED:
        t, states = march(FIXED[name], slope, state, duration, step)
        evaluations = (len(t) - 1) * (4 if name == "RK4" else 1)
    else:
        t = np.linspace(0, duration, 1001)
        solution = adaptive(slope, state, t, name, rtol=rtol, atol=1e-3 * rtol)
        t = solution.t
        states = solution.states
        evaluations = solution.evaluations
    energy = joint_model(ROBOT, states.T, assembly)[3]
    return Drift(name, t, energy / energy[:1] - 1, evaluations)


def drift_of_ours(step: float = 1e-3, duration: float = 10.0) -> Drift:
    """Return the drift of fivebar.simulate, in fixed steps."""
    run = simulate(
        ROBOT,
        duration=duration,
        start=conservative_start(),
        step=step,
        integrator=Integrator("rk4"),
    )
    return Drift("fivebar", run.t, run.energy / run.energy[0] - 1, 4 * (len(run.t) - 1))
