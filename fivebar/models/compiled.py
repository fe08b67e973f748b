"""Compiled models: a casadi.Function that holds the instructions of its requested outputs and no
others.
"""

from __future__ import annotations

import io
import sys
import threading
from collections.abc import Iterable
from contextlib import closing, contextmanager, nullcontext, redirect_stderr
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.backend import as_numbers, is_symbolic
from ..base.checks import flag, modes, strings
from ..base.checks import jit as must_be_jit
from ..base.robot_uses import takes_robot
from .dynamics import dynamic_model, energy, forward_dynamics, gravity_torques, inverse_dynamics
from .four_joints import bars_of, bars_rates
from .geometry import joint_pose, task_pose
from .kinematics import dkm, dkm2, ikm, ikm2
from .loads import friction_torques, potential
from .parameters import parameters_of

if TYPE_CHECKING:
    from types import ModuleType

    import casadi

    from .robots import Robot

# Each level of motion has its inputs, one of which is given, and the outputs that then can be asked
# for.
# The state, the four bars' angles and rates, is two levels in one.
POSITION = ("q", "xi", "state")
VELOCITY = ("q_dot", "xi_dot", "state")
ACCELERATION = ("q_ddot", "xi_ddot", "tau")
POSE_OUTPUTS = (
    "q",
    "xi",
    "q_passive",
    "elbows",
    "assembly",
    "working",
    "A",
    "B",
    "reach_margin",
    "gravity_torques",
    "potential",
)
RATES_OUTPUTS = (
    "q_dot",
    "xi_dot",
    "q_passive_dot",
    "d",
    "M",
    "c",
    "energy",
    "friction_torques",
    "state",
)
LOADS = {
    "gravity_torques": gravity_torques,
    "potential": potential,
    "friction_torques": friction_torques,
}
ACCELERATION_OUTPUTS = ("q_ddot", "xi_ddot", "q_passive_ddot", "tau")
LENGTHS = {"assembly": 1, "state": 8}  # of inputs; of the others 2
MODES = {"q": "assembly", "xi": "working"}  # the mode that a position leaves open
LEVELS = ((POSITION, POSE_OUTPUTS), (VELOCITY, RATES_OUTPUTS), (ACCELERATION, ACCELERATION_OUTPUTS))
QUIET: dict[str, Any] = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes"}
STOPPED = (
    "NonIpopt_Exception_Thrown",
    "User_Requested_Stop",
)  # how IPOPT ends by Ctrl-C, where nobody else ends it


@takes_robot(
    inputs=strings,
    outputs=strings,
    assembly=modes(1),
    working=modes(2),
    jit=must_be_jit,
    source=flag,
)
def compile(
    robot: Robot,
    inputs: Iterable[str],
    outputs: Iterable[str],
    assembly: int = -1,
    working: tuple[int, int] = (-1, -1),
    jit: bool | str = False,
    to: ModuleType | None = None,
    source: bool = False,
) -> Any:
    """Return a robot's models as one function, from named inputs to named outputs.

    Parameters
    ----------
    robot : FiveBar or Biglide
        CasADi symbols among its parameters are inputs too, after the others, each by its own name.
    inputs : iterable of str
        One of q, xi; for what moves also one of q_dot, xi_dot; for accelerations and torques also
        one of q_ddot, xi_ddot, tau. assembly or working among them: the modes are told with each
        call. In place of position and velocity, state (8): the angles of the four bars
        (q1, q1 + q12, q2, q2 + q22) and their rates, which need no mode.
    outputs : iterable of str
        Any of these, and attributes of Pose, Rates and Accelerations: q_passive, elbows, A, B, M,
        c, ...; gravity_torques, potential and friction_torques.
    assembly : int
        Assembly mode, used with q.
    working : (2,)
        Working modes, used with xi.
    jit : bool or "auto"
        True: compile to machine code with the system's C compiler; it is kept in the user's cache
        folder. "auto": where that can be done, else with a warning.
    to : module, optional
        A library of the array API standard, such as numpy, jax.numpy or torch: the function is one
        of its arrays.
    source : bool
        With `to`: return the function's text.

    Returns
    -------
    casadi.Function, or with `to` a function of arrays
        Of CasADi: vectors are 2 x 1, matrices 2 x 2. Of arrays: q, xi and the like are (*batch, 2),
        of float32 or float64, and so are the results; matrices are (*batch, 2, 2). Several
        outputs come as a tuple. Symbols of the robot are given by name, as numbers or (*batch).
        Out of reach the result is nan. Where a leg is stretched to the last digit, a square root
        counts as constant in derivatives. With NumPy a large batch is walked in blocks that fit a
        processor's cache: a chain of models on a million poses takes 0.6 of the time so.

    Raises
    ------
    ValueError
        Names that are not known, or do not go together; a library that lacks a function.

    Examples
    --------
    >>> import fivebar as fb
    >>> function = fb.compile(fb.FiveBar(), ["q"], ["xi"])
    >>> function([0.0, 0.0]).full().ravel().round(6).tolist()
    [0.09, 0.067963]

    >>> import numpy as np
    >>> function = fb.compile(fb.FiveBar(), ["q"], ["xi"], to=np)
    >>> function(np.zeros((1000, 2))).shape
    (1000, 2)
    """
    import casadi

    inputs = list(inputs)
    outputs = list(outputs)
    chosen = _choose(inputs, outputs)
    if to is None and source:
        raise ValueError("source is the text of a function of arrays: it goes with to")
    if to is not None and jit:
        raise ValueError("jit compiles CasADi's function: it does not go with to")
    symbols = {name: casadi.SX.sym(name, LENGTHS.get(name, 2)) for name in inputs}
    symbols = with_symbols_of(robot, symbols)
    with nullcontext() if to is None else as_numbers():
        value = _values(robot, chosen, symbols, assembly, working)
        expressions = casadi.cse([casadi.densify(casadi.SX(value(name))) for name in outputs])
    function = casadi.Function(
        "fivebar", list(symbols.values()), expressions, list(symbols), outputs
    )
    if to is None:
        return compiled(function, jit)
    from . import arrays  # here, as it brings CasADi

    return (
        arrays.source(function, inputs) if source else arrays.array_function(function, inputs, to)
    )


def with_symbols_of(robot: Robot, inputs: dict[str, casadi.SX]) -> dict[str, casadi.SX]:
    """Return the inputs {name: symbol}, and after them the symbols among a robot's parameters."""
    import casadi

    own = casadi.vertcat(casadi.SX(0), *filter(is_symbolic, parameters_of(robot)))
    free = {symbol.name(): symbol for symbol in casadi.symvar(own)}
    if taken := sorted(set(free) & set(inputs)):
        raise ValueError(f"the symbol {taken[0]} of the robot has the name of an input")
    return inputs | free


def _values(robot, chosen, symbols, assembly, working):
    """Return (output's name) -> its expression, in which no more is computed than it needs."""
    import casadi

    position, velocity, acceleration = chosen
    parts = {name: casadi.vertsplit(symbol) for name, symbol in symbols.items()}
    rates: Any = None
    acc: Any = None
    if position == "state":
        rates = bars_rates(robot, parts["state"][:4], parts["state"][4:])
        pose = rates.pose
    elif position == "q":
        pose = joint_pose(robot, tuple(parts["q"]), symbols.get("assembly", assembly))
    else:
        pose = task_pose(robot, tuple(parts["xi"]), tuple(parts.get("working", working)))
    if velocity in ("q_dot", "xi_dot"):
        rates = {"q_dot": dkm, "xi_dot": ikm}[velocity](pose, symbols[velocity])
    if acceleration:
        model = {"q_ddot": dkm2, "xi_ddot": ikm2, "tau": forward_dynamics}[acceleration]
        acc = model(rates, symbols[acceleration])
    dynamics = cache(lambda: dict(zip(("M", "c"), dynamic_model(rates))))

    def value(name):
        if name in LOADS:
            return LOADS[name](rates if name in RATES_OUTPUTS else pose)
        if name in POSE_OUTPUTS:
            return getattr(pose, name)
        if name in ("M", "c"):
            return dynamics()[name]
        if name == "energy":
            return energy(rates)
        if name == "state":
            angles, turns = bars_of(rates)
            return casadi.vertcat(*angles, *turns)
        if name == "tau":
            return inverse_dynamics(acc)
        return getattr(rates if name in RATES_OUTPUTS else acc, name)

    return value


def _choose(inputs, outputs):
    """Return the input of each level, None where it has none."""
    chosen = []
    for names, _ in LEVELS:
        given = [name for name in inputs if name in names]
        if len(given) > 1:
            raise ValueError(f"inputs {' and '.join(given)} are of one level: give one of them")
        chosen += given or [None]
    known = [*dict.fromkeys(name for names, _ in LEVELS for name in names), *MODES.values()]
    for name in inputs:
        if name not in known:
            raise ValueError(f"no input {name!r}; the known ones are {', '.join(known)}")
    if chosen[0] is None:
        raise ValueError("inputs need q, xi or state")
    if chosen[2] and not chosen[1]:
        raise ValueError(f"input {chosen[2]} needs q_dot or xi_dot too")
    for name in inputs:
        if name in MODES.values() and MODES.get(chosen[0]) != name:
            own = f"whose mode is {MODES[chosen[0]]}" if chosen[0] in MODES else "which has no mode"
            raise ValueError(f"no input {name} with {chosen[0]}, {own}")
    if not outputs:
        raise ValueError("outputs must name at least one quantity")
    level_of = {name: level for level, (_, names) in enumerate(LEVELS) for name in names}
    for output in outputs:
        if output not in level_of:
            raise ValueError(f"no output {output!r}; the known ones are {', '.join(level_of)}")
        if output in inputs:
            raise ValueError(f"output {output} is an input already")
        level = level_of[output]
        if chosen[level] is None:
            raise ValueError(f"output {output} needs an input of {', '.join(LEVELS[level][0])}")
    return chosen


def compiled(function, jit):
    """Return the function itself, or with jit=True or "auto" its machine code."""
    if not jit:
        return function
    from .machine_code import machine_code  # here, as it brings in what compiling needs

    return machine_code(function, jit)


class _WithoutInterruptNote(io.TextIOBase):
    """A stream that passes on all lines but CasADi's warning of Ctrl-C, which comes in pieces."""

    def __init__(self, stream):
        super().__init__()
        self._stream = stream
        self._line = ""

    def write(self, text):
        *lines, self._line = (self._line + text).split("\n")
        for line in lines:
            if "KeyboardInterruptException" not in line:
                self._stream.write(line + "\n")
        return len(text)

    def close(self):
        if self._line:
            self._stream.write(self._line)
        super().close()


@contextmanager
def _without_interrupt_note():
    """Leave out CasADi's warning of Ctrl-C within the block."""
    in_main_thread = threading.current_thread() is threading.main_thread()
    if sys.stderr is None or not in_main_thread:  # Ctrl-C reaches the main thread alone
        yield
        return
    with closing(_WithoutInterruptNote(sys.stderr)) as stream, redirect_stderr(stream):
        yield


def minimized(name: str, problem: dict, options: dict, **given: Any) -> tuple[dict, dict]:
    """Return (what IPOPT found, CasADi's word on it) of a nonlinear program; given: x0 and bounds.

    KeyboardInterrupt where it was interrupted. CasADi keeps that for itself up to Python 3.12; from
    3.13 on it leaves the exception set, of which Python makes a SystemError.
    """
    import casadi

    solver = casadi.nlpsol(name, "ipopt", problem, QUIET | options)
    try:
        with _without_interrupt_note():
            found = solver(**given)
    except SystemError as error:
        if isinstance(error.__cause__, KeyboardInterrupt):
            raise error.__cause__ from None
        raise
    stats = solver.stats()
    if stats["return_status"] in STOPPED:
        raise KeyboardInterrupt
    return found, stats


def _array(rows, columns):
    return np.empty((columns, rows) if columns > 1 else rows)


class Buffered:
    """A casadi.Function called through its own arrays, without the cost of converting arguments.

    `call(*inputs)` copies its arguments in and gives the output arrays, overwritten by the next
    call. A vector is (n,), an r x c matrix (c, r): its columns as rows, as they lie in memory.
    """

    def __init__(self, function):
        self._buffer, self._run = function.buffer()
        self._inputs = [_array(*function.size_in(k)) for k in range(function.n_in())]
        self.outputs = [_array(*function.size_out(k)) for k in range(function.n_out())]
        for k, array in enumerate(self._inputs):
            self._buffer.set_arg(k, memoryview(array))
        for k, array in enumerate(self.outputs):
            self._buffer.set_res(k, memoryview(array))

    def stats(self):
        """CasADi's word on the last call, e.g. of a solver."""
        return self._buffer.stats()

    def __call__(self, *inputs):
        for slot, value in zip(self._inputs, inputs):
            slot[...] = value
        self._run()
        return self.outputs
