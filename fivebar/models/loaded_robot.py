"""Robots with torques of the user's own at their joints: a drive, friction, a disturbance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..base.backend import is_symbolic, numpy_on_symbols
from ..base.checks import a_callable, returned_pair
from ..base.robot_uses import robot_for
from .robots import Robot

# Two states at which a function of symbols must say what it says of numbers: t, q, q', tau.
NAME = "LoadedRobot: torques"
SAMPLES = (
    (0.3, (0.4, -0.7), (1.1, -0.6), (0.2, -0.1)),
    (1.7, (-0.2, 0.9), (-0.8, 0.3), (-0.3, 0.4)),
)


@dataclass(frozen=True)
class LoadedRobot:
    """A robot with torques of your own at its joints: another drive, friction, a disturbance.

    `simulate`, `simulate_many` and `Tracker` take it in place of its robot.

    Parameters
    ----------
    robot : FiveBar or Biglide
    torques : callable
        (t, q (2,), q_dot (2,), tau (2,)) -> (2,), the torques at the joints, N m (biglide: N), at
        time t, s, where the controller applies tau. It is a function of these alone. Where it is
        made of arithmetic and the functions of CasADi or NumPy, it is compiled; else it is called
        with numbers, some 20 times a step.

    Raises
    ------
    ValueError
        When it is used, if it does not give two torques, or depends on other symbols.

    Examples
    --------
    >>> import numpy as np
    >>> import fivebar as fb
    >>> def rubbed(t, q, q_dot, tau):
    ...     return tau - 0.02 * np.tanh(q_dot / 0.05)
    >>> robot = fb.FiveBar()
    >>> controller = fb.ComputedTorque(robot, kp=100, kd=20)
    >>> reference = fb.line((0.09, 0.068), (0.0, 0.1), duration=2.0)
    >>> run = fb.simulate(fb.LoadedRobot(robot, rubbed), controller, reference)
    >>> bool(abs(run.error).max() > 1e-3)
    True
    """

    robot: Robot
    torques: Callable

    def __post_init__(self) -> None:
        own = robot_for("fb.LoadedRobot")(self.robot, "LoadedRobot: robot")
        object.__setattr__(self, "robot", own)
        a_callable(self.torques, "LoadedRobot: torques")


@dataclass(frozen=True)
class JointTorques:
    """Torques of a LoadedRobot as the simulation calls them.

    text: CasADi's function of (t, q, q_dot, tau) as a text, which other processes and caches of
    compiled steps compare; None where `of_numbers` must be called.
    """

    text: str | None
    of_numbers: Callable | None = None

    @cached_property
    def function(self) -> Any:
        """(t, q, q_dot, tau) -> torques (2), of CasADi's symbols or numbers."""
        import casadi

        return casadi.Function.deserialize(self.text) if self.text else self._at_numbers

    def _at_numbers(self, t, *vectors):
        import casadi

        return casadi.DM(self.at(float(t), *(np.asarray(each).ravel() for each in vectors)))

    def at(self, t: float, q: np.ndarray, q_dot: np.ndarray, tau: np.ndarray) -> np.ndarray:
        """Return the torques (2,), N m, of numbers."""
        if self.of_numbers is None:
            return self.function(t, q, q_dot, tau).full().ravel()
        value = returned_pair(self.of_numbers(t, q, q_dot, tau), NAME)
        if not np.isfinite(value).all():
            raise ArithmeticError(f"LoadedRobot: torques are {value.tolist()} at t = {t:g} s")
        return value

    def taken(self, t: np.ndarray, q: np.ndarray, q_dot: np.ndarray, tau: np.ndarray) -> np.ndarray:
        """Return what they take from the controller's torques tau, (n, 2) N m, along a motion."""
        if self.text is not None:
            joint = self.function(t[None], q.T, q_dot.T, tau.T).full().T
        else:
            joint = np.array([self.at(*row) for row in zip(t.tolist(), q, q_dot, tau)])
        return tau - joint


def robot_and_torques(plant: Robot | LoadedRobot) -> tuple[Robot, JointTorques | None]:
    """Return the robot of a plant, and its torques; None where these are the controller's own."""
    if not isinstance(plant, LoadedRobot):
        return plant, None
    function = _traced(plant.torques)
    if function is None:
        for sample in SAMPLES:
            _of_sample(plant.torques, sample)
        return plant.robot, JointTorques(None, plant.torques)
    return plant.robot, JointTorques(function.serialize())


def refuse_numbers(torques: JointTorques | None, what: str) -> None:
    """Raise where torques cannot be compiled."""
    if torques is not None and torques.text is None:
        raise ValueError(
            f"{what} is compiled, but the torques of this LoadedRobot are a function of numbers:"
            " write them with arithmetic and CasADi's functions, as casadi.if_else in place of if"
        )


def _traced(torques):
    """Return CasADi's function of the torques; None where they are a function of numbers."""
    import casadi

    symbols = [casadi.SX.sym(name, *shape) for name, *shape in (("t",), ("q", 2), ("q_dot", 2))]
    symbols.append(casadi.SX.sym("tau", 2))
    try:
        with numpy_on_symbols():
            value = torques(*symbols)
            if not is_symbolic(value):
                value = casadi.vertcat(*value)
            value = casadi.densify(casadi.SX(value))
    except Exception:  # Whatever a function of numbers raises when it is given symbols.
        return None
    if value.numel() != 2:
        raise ValueError(f"{NAME} must return two torques, not {value.numel()}")
    options = {"allow_free": True}
    function = casadi.Function("torques", symbols, [casadi.reshape(value, 2, 1)], options)
    if free := function.get_free():
        raise ValueError(
            f"LoadedRobot: torques depend on the symbol {free[0]}, which is none of t, q, q_dot,"
            " tau: give its value"
        )
    # Python's math functions, for instance, take symbols and answer nan.
    for sample in SAMPLES:
        try:
            expected = _of_sample(torques, sample)
        except Exception:  # A function of symbols alone, as casadi.if_else of arrays.
            continue
        if not np.allclose(function(*sample).full().ravel(), expected, rtol=1e-9):
            return None
    return function


def _of_sample(torques, sample):
    return returned_pair(torques(sample[0], *map(np.array, sample[1:])), NAME)
