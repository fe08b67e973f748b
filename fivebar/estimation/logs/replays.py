"""Simulate a measured run again, under the same torques."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy import ndarray

from ...base.checks import instance, optional, positive, takes
from ...base.errors import SingularityError, UnreachableError
from ...base.presentation import Animated
from ...base.progress import progress
from ...base.representation import one_line
from ...base.robot_uses import robot_for
from ...models.geometry import dgm
from ...models.kinematics import dkm
from ...models.robots import Robot
from ...simulation.run import Run
from ...simulation.simulate import simulate
from .logs import LATE

SHORTEST = 4  # rows between gaps that are simulated


@dataclass(frozen=True, eq=False)
class Replay(Animated):
    """A run beside its simulation, from `replay`.

    Attributes
    ----------
    measured : Run
        The run as it was.
    simulated : Run
        The simulation at its times; its reference is the measured path, so its error is the
        difference.
    notes : tuple of str
        Where nothing could be simulated, and why.
    """

    measured: Run
    simulated: Run
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return one_line("Replay", self._size())

    def __str__(self) -> str:
        words = self.measured.robot.words
        known = self.tau_difference[np.isfinite(self.tau_difference).all(axis=1)]
        rms = np.full(2, np.nan)
        if len(known):
            rms = np.sqrt(np.mean(known**2, axis=0))
        torques = f"{words.effort}s apart {rms[0]:.3g} and {rms[1]:.3g} {words.effort_unit} rms"
        return "\n".join([f"replay: {self._size()}", torques, *self.notes])

    def _size(self):
        rms = 1e6 * self.figures["rms_error_m"]
        largest = 1e6 * self.figures["max_error_m"]
        return f"apart {rms:.4g} um rms, {largest:.4g} um at most"

    @property
    def difference(self) -> ndarray:
        """xi simulated - measured, (n, 2) m, nan in gaps."""
        return self.simulated.xi - self.measured.xi

    @property
    def q_difference(self) -> ndarray:
        """q simulated - measured, (n, 2) rad."""
        return self.measured.robot.joint_difference(self.simulated.q - self.measured.q)

    @property
    def tau_difference(self) -> ndarray:
        """tau simulated - measured, (n, 2) N m."""
        return self.simulated.tau - self.measured.tau

    @cached_property
    def figures(self) -> dict[str, float]:
        """rms_error_m, max_error_m, final_error_m: distances of the end-effector."""
        distance = np.hypot(*self.difference.T)
        distance = distance[np.isfinite(distance)]
        return {
            "rms_error_m": float(np.sqrt(np.mean(distance**2))),
            "max_error_m": float(distance.max()),
            "final_error_m": float(distance[-1]),
        }

    @property
    def runs(self) -> dict[str, Run]:
        """{"measured": Run, "simulated": Run}."""
        return {"measured": self.measured, "simulated": self.simulated}


@takes(
    run=instance("Run", what="a Run, as fb.from_log and fb.Run.from_csv read one"),
    robot=optional(robot_for("fb.replay")),
    restart=optional(positive),
)
def replay(run: Run, robot: Robot | None = None, restart: float | None = None) -> Replay:
    """Simulate a run again, under the same torques from its state at the start and after each gap.

    Torques of a simulated run are held from row to row. Those of a log are those at their times, or
    held too if the simulation then comes nearer to the run.

    Parameters
    ----------
    run : Run
        A measured or simulated run.
    robot : FiveBar or Biglide, optional
        The robot that is simulated; the run's own by default.
    restart : float, optional
        Interval, s, at which the simulation begins again at the measured state.

    Returns
    -------
    Replay
        The run beside its simulation.

    Raises
    ------
    ValueError
        Nothing of the run can be simulated.

    Examples
    --------
    >>> import fivebar as fb
    >>> robot = fb.FiveBar()
    >>> line = fb.line((0.09, 0.068), (0.08, 0.07), 0.1)
    >>> run = fb.simulate(robot, fb.ComputedTorque(robot, 100, 20), line, step=1e-3)
    >>> fb.replay(run).figures["max_error_m"] < 1e-9
    True
    """
    robot = run.robot if robot is None else robot
    if type(robot) is not type(run.robot):
        raise ValueError(
            f"replay: the run is of a {run.robot.words.title}, and robot is a {robot.words.title}"
        )
    if not np.isfinite(run.tau).any():
        raise ValueError("replay: this run has no torques")
    known = np.isfinite(np.hstack([run.q, run.q_dot, run.xi, run.tau])).all(axis=1)
    stretches = list(_stretches(known, run.t, restart))
    held = _replayed(run, robot, stretches, held=True)
    if run.measured is None or run.measured.held:
        return held
    at_times = _replayed(run, robot, stretches, held=False)
    if at_times.figures["rms_error_m"] <= held.figures["rms_error_m"]:
        return at_times
    words = "each torque is taken as held to the next row, which comes nearer to the run"
    return replace(held, notes=(words, *held.notes))


def _replayed(run, robot, stretches, held):
    """Return the Replay of stretches of rows; each torque is held, or that at its time."""
    values: dict[str, Any] = {
        name: np.full_like(run.q, np.nan) for name in ("q", "q_dot", "xi", "tau")
    }
    values["energy"] = np.full(len(run.t), np.nan)
    notes = []
    events = []
    short = []
    for rows in progress(stretches, desc="replay", unit=" stretches", delay=2, leave=False):
        if rows.stop - rows.start < SHORTEST:
            short.append(rows)
            continue
        try:
            simulated = _simulated(run, robot, rows, held)
        except (UnreachableError, SingularityError, ArithmeticError) as error:
            notes.append(f"from {run.t[rows.start]:.6g} s nothing was simulated: {error}")
            continue
        _copy_rows(simulated, run, rows, values)
        start = float(run.t[rows.start])
        events += [event._replace(t=event.t + start) for event in simulated.events]
    if short:
        count = sum(rows.stop - rows.start for rows in short)
        notes.append(
            f"{count} rows, in stretches shorter than {SHORTEST} rows, were not simulated, the"
            f" first from {run.t[short[0].start]:.6g} s"
        )
    if not np.isfinite(values["q"]).any():
        reason = notes[0] if notes else "no row of the run is whole"
        raise ValueError(f"replay: nothing could be simulated: {reason}")
    simulated = Run(
        robot=robot,
        t=run.t,
        **values,
        xi_ref=run.xi,
        torque_limit=run.torque_limit,
        events=tuple(events),
    )
    return Replay(run, simulated, tuple(notes))


def _stretches(known, t, restart):
    """Yield the slices of rows in which time goes on, each about as long as `restart`.

    What would be left over at the end of a stretch, too short to be simulated, belongs to the
    last slice.
    """
    step = np.median(np.diff(t))
    late = np.diff(t, prepend=t[0]) > LATE * step
    edges = np.flatnonzero(np.diff(known, prepend=False, append=False))
    for first, end in zip(edges[::2], edges[1::2]):
        starts = [first, *(first + 1 + np.flatnonzero(late[first + 1 : end])), end]
        for start, stop in zip(starts, starts[1:]):
            while start < stop:
                last = stop
                if restart is not None:
                    after = int(np.searchsorted(t, t[start] + restart)) + 1
                    last = max(after, start + SHORTEST)
                    if stop - last < SHORTEST:
                        last = stop
                yield slice(int(start), int(last))
                start = last


def _start(run, robot, row):
    """Return the state at a row, in the assembly mode of the measured end-effector."""
    poses = [dgm(robot, run.q[row], mode, unreachable="nan") for mode in (-1, 1)]
    distances = [np.hypot(*(pose.xi - run.xi[row])) for pose in poses]
    if not np.isfinite(distances).any():
        raise UnreachableError(
            f"replay: at {run.t[row]:.6g} s this robot's bars do not close on the measured joints",
            float("nan"),
        )
    return dkm(poses[int(np.nanargmin(distances))], run.q_dot[row])


def _simulated(run, robot, rows, held):
    t = run.t[rows] - run.t[rows.start]
    tau = run.tau[rows]
    step = float(t[-1] / (len(t) - 1))
    even = np.arange(len(t)) * step
    if not held:  # the mean of both ends
        means = (tau[1:] + tau[:-1]) / 2
        tau = np.concatenate([means, tau[-1:]])
    if np.abs(t - even).max() >= 0.01 * step:
        tau = np.stack([np.interp(even, t, column) for column in tau.T], axis=1)

    def torque(now, q, q_dot, reference):
        return tau[min(int(now / step + 0.5), len(tau) - 1)]

    return simulate(
        robot,
        torque,
        duration=float(even[-1]),
        start=_start(run, robot, rows.start),
        control_period=step,
        step=step,
    )


def _copy_rows(simulated, run, rows, values):
    """Copy a simulation, interpolated at the times of the run, into the rows of `values`."""
    t = run.t[rows] - run.t[rows.start]
    for name in ("q", "q_dot", "xi"):
        for k, column in enumerate(getattr(simulated, name).T):
            values[name][rows, k] = np.interp(t, simulated.t, column)
    if run.robot.turns:
        apart = run.q[rows.start] - simulated.q[0]
        turns = np.round(apart / (2 * np.pi))
        values["q"][rows] += turns * 2 * np.pi
    held = np.searchsorted(simulated.t, t + 1e-9, side="right") - 1
    values["tau"][rows] = simulated.tau[np.minimum(held, len(simulated.t) - 1)]
    values["energy"][rows] = np.interp(t, simulated.t, simulated.energy)
