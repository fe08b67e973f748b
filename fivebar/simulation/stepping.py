"""One step of the simulation as a function of arrays, for loops in JAX, PyTorch and the like."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

import casadi

from ..base.backend import as_numbers
from ..base.checks import optional, positive
from ..base.robot_uses import takes_robot
from ..control.laws import PD, ComputedTorque
from ..models.arrays import array_function
from ..models.compiled import with_symbols_of
from ..models.robots import Robot
from .fixed_plant import refuse_sticking
from .loops import a_built_in_controller, law_of
from .steps import runge_kutta, slope_and_closing


@takes_robot(period=positive, controller=optional(a_built_in_controller))
def stepper(
    robot: Robot, period: float, to: ModuleType, controller: PD | ComputedTorque | None = None
) -> Callable[..., Any]:
    """Return a step of the simulation as a function of arrays, of any number of robots at once.

    It is a step of order 8 on the angles of the four bars, which are then moved so that the loop is
    closed: the same as of `simulate` with `Integrator("dop8")`. The torques are held during it.

    Parameters
    ----------
    robot : FiveBar or Biglide
        CasADi symbols among its parameters are arguments of the function, by name: numbers, or one
        for each robot.
    period : float
        s, of the step, which is the controller's period.
    to : module
        A library of the array API standard, such as numpy, jax.numpy or torch.
    controller : PD or ComputedTorque, optional
        None: the torques are arguments.

    Returns
    -------
    callable
        With a controller (state, q_ref, q_ref_dot, q_ref_ddot) -> (state after the step, tau),
        without one (state, tau) -> state after the step. state : (*batch, 8), of `compile`; the
        others : (*batch, 2).

    Raises
    ------
    ValueError
        For dry friction, which sticks; for a library that lacks a function.

    References
    ----------
    Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section II.5.

    Examples
    --------
    >>> import numpy as np
    >>> import fivebar as fb
    >>> robot = fb.FiveBar()
    >>> step = fb.stepper(robot, 0.01, to=np)
    >>> begin = fb.compile(robot, ["q", "q_dot"], ["state"], to=np)
    >>> state = begin(np.zeros((5, 2)), np.zeros((5, 2)))
    >>> step(state, np.full((5, 2), 0.1)).shape
    (5, 8)
    """
    refuse_sticking(robot)
    lengths = {"state": 8, "tau": 2, "q_ref": 2, "q_ref_dot": 2, "q_ref_ddot": 2}
    symbols = {name: casadi.SX.sym(name, length) for name, length in lengths.items()}
    state, tau, *target = symbols.values()

    def of_arrays(expression, *arguments):
        inputs = with_symbols_of(robot, {name: symbols[name] for name in arguments})
        expressions = casadi.cse([expression])
        return array_function(
            casadi.Function("step", list(inputs.values()), expressions, list(inputs), ["result"]),
            arguments,
            to,
        )

    with as_numbers():
        slope, closing = slope_and_closing(robot, state, tau)
        # Each its own function: what JAX compiles as one piece it would compute again and again.
        slope_of = of_arrays(slope, "state", "tau")
        closed = of_arrays(closing, "state")

        def held(state, tau, **parameters):
            def rate(stage, fraction):
                return slope_of(stage, tau, **parameters)

            return closed(runge_kutta("dop8", period, state, rate), **parameters)

        if controller is None:
            return held
        torques = law_of(robot, controller, period, state, casadi.vertcat(*target))
        law = of_arrays(torques, "state", "q_ref", "q_ref_dot", "q_ref_ddot")

    def controlled(state, q_ref, q_ref_dot, q_ref_ddot, **parameters):
        tau = law(state, q_ref, q_ref_dot, q_ref_ddot, **parameters)
        return held(state, tau, **parameters), tau

    return controlled
