"""A run, measured or simulated, beside a simulation of the same torques or of the same
reference.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import make_splrep

from ...base.checks import a_callable, one_of, optional, positive, takes
from ...base.checks import robot as must_be_robot
from ...base.errors import SingularityError, UnreachableError
from ...base.presentation import Animated
from ...base.representation import one_line
from ...base.tables import TextFile, write
from ...control.laws import ComputedTorque
from ...models.geometry import dgm
from ...models.kinematics import dkm
from ...models.robots import Robot
from ...planning.trajectory import Trajectory
from ...simulation.run import Run, columns
from ...simulation.simulate import simulate
from .derivatives import derivatives, spectrum
from .logs import LATE

KP, KD = 400.0, 40.0  # 1/s^2, 1/s, of the computed torque that follows a reference
SHORTEST = 4  # rows between gaps that are replayed
MOST_STEP = 1e-3  # s, from row to row of what is simulated under a controller


@dataclass(frozen=True, eq=False)
class Replay(Animated):
    """measured: the run that was; simulated: a Run on its times, with xi of the measured as its
    reference, so that its error is the difference; by: "torques" or "reference"; said: sentences on
    where the simulation began anew, or ended.
    """

    measured: Run
    simulated: Run
    by: str
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        rms, most = self.figures["rms_error_m"], self.figures["max_error_m"]
        return one_line(
            "Replay",
            f"of the {self.by}",
            f"apart {1e6 * rms:.4g} um rms, {1e6 * most:.4g} um at most",
        )

    def __str__(self) -> str:
        words = self.measured.robot.words
        missed = self.tau_difference
        rms = (
            np.sqrt(np.nanmean(missed**2, axis=0))
            if np.isfinite(missed).any()
            else (np.nan, np.nan)
        )
        apart = [1e6 * self.figures[name] for name in ("rms_error_m", "max_error_m")]
        return "\n".join(
            [
                f"replay of the {self.by}: apart {apart[0]:.4g} um rms, {apart[1]:.4g} um at most",
                f"{words.effort}s apart {rms[0]:.3g} and {rms[1]:.3g} {words.effort_unit} rms",
                *self.notes,
            ]
        )

    @property
    def difference(self) -> np.ndarray:
        """xi simulated - measured, (n, 2) m, nan in gaps."""
        return self.simulated.xi - self.measured.xi

    @property
    def q_difference(self) -> np.ndarray:
        """q simulated - measured, (n, 2) rad."""
        return self.measured.robot.joint_difference(self.simulated.q - self.measured.q)

    @property
    def tau_difference(self) -> np.ndarray:
        """tau simulated - measured, (n, 2) N m."""
        return self.simulated.tau - self.measured.tau

    @cached_property
    def figures(self) -> dict[str, float]:
        """rms_error_m, max_error_m, final_error_m: distances of the end-effector, nan where nothing
        was simulated.
        """
        size = np.hypot(*self.difference.T)
        size = size[np.isfinite(size)]
        if not len(size):
            return dict.fromkeys(("rms_error_m", "max_error_m", "final_error_m"), float("nan"))
        return {
            "rms_error_m": float(np.sqrt(np.mean(size**2))),
            "max_error_m": float(size.max()),
            "final_error_m": float(size[-1]),
        }

    @property
    def runs(self) -> dict[str, Run]:
        """{"measured": Run, "simulated": Run}."""
        return {"measured": self.measured, "simulated": self.simulated}

    def to_csv(self, path: TextFile) -> None:
        """Both on the times of the measured, SI units: its columns as of a run, the simulation's
        with _sim.
        """
        names = (
            "t",
            *(
                f"{name}{end}"
                for end in ("", "_sim")
                for name in columns(self.measured.robot, False)[1:9]
            ),
        )
        table = [self.measured.t]
        for run in self.runs.values():
            table += [*run.q.T, *run.q_dot.T, *run.xi.T, *run.tau.T]
        about = {"robot": self.simulated.robot.parameters, "by": self.by}
        write(path, "replay", about, names, np.column_stack(table).tolist())


@takes(
    robot=optional(must_be_robot),
    by=one_of("torques", "reference"),
    controller=optional(a_callable),
    restart=optional(positive),
)
def replay(
    run: Run,
    robot: Robot | None = None,
    by: str = "torques",
    controller: Callable | None = None,
    restart: float | None = None,
) -> Replay:
    """Simulate a run again, under the same torques or after the same reference.

    Parameters
    ----------
    run : Run
        A measured or simulated run.
    robot : FiveBar or Biglide, optional
        The robot that is simulated; the run's own by default.
    by : "torques" or "reference"
        Apply the run's torques from its state at the start and after each gap; or follow its xi_ref
        (or, without one, where it went) under `controller`.
    controller : callable, optional
        The controller that follows the reference; computed torque by default.
    restart : float, optional
        Interval, s, at which the simulation under torques begins again at the measured state.

    Returns
    -------
    Replay
        The run beside its simulation.
    """
    robot = run.robot if robot is None else robot
    if type(robot) is not type(run.robot):
        raise ValueError(
            f"replay: the run is of a {run.robot.words.title}, and robot is a {robot.words.title}"
        )
    if by == "torques" and controller is not None:
        raise ValueError('replay: a controller follows a reference: it goes with by="reference"')
    if by == "reference" and restart is not None:
        raise ValueError(
            'replay: restart is for by="torques", as a controller holds to its reference'
        )
    whole = (
        np.isfinite(run.q).all(axis=1)
        & np.isfinite(run.q_dot).all(axis=1)
        & np.isfinite(run.xi).all(axis=1)
    )
    if by == "torques":
        if not np.isfinite(run.tau).any():
            raise ValueError(
                'replay: this run has no torques; by="reference" follows where it went'
            )
        whole &= np.isfinite(run.tau).all(axis=1)
    found = {name: np.full_like(run.q, np.nan) for name in ("q", "q_dot", "xi", "tau")}
    energy, notes, events = np.full(len(run.t), np.nan), [], []
    for first, end in _stretches(whole, run.t, restart if by == "torques" else None):
        rows = slice(first, end)
        try:
            own = (_by_torques if by == "torques" else _by_reference)(run, robot, rows, controller)
        except (UnreachableError, SingularityError, ArithmeticError) as error:
            notes.append(f"from {run.t[first]:.6g} s nothing was simulated: {error}")
            continue
        for name, values in found.items():
            values[rows] = own[name]
        energy[rows] = own["energy"]
        events += own["events"]
    if not np.isfinite(found["q"]).any():
        raise ValueError(
            "replay: nothing could be simulated: "
            + (notes[0] if notes else "no stretch of the run is long enough")
        )
    simulated = Run(
        robot=robot,
        t=run.t,
        **found,
        energy=energy,
        xi_ref=run.xi,
        torque_limit=run.torque_limit,
        events=tuple(events),
    )
    return Replay(run, simulated, by, tuple(notes))


def _stretches(whole, t, restart):
    """(first, end) rows in which time goes on, and no longer than restart."""
    step = np.median(np.diff(t))
    late = np.concatenate([[True], np.diff(t) > LATE * step])
    edges = np.flatnonzero(np.diff(np.concatenate([[0], whole.astype(int), [0]])))
    for first, end in zip(edges[::2], edges[1::2]):
        starts = [first, *(k for k in range(first + 1, end) if late[k])]
        for a, b in zip(starts, [*starts[1:], end]):
            while b - a >= SHORTEST:
                last = (
                    b
                    if restart is None
                    else min(b, max(int(np.searchsorted(t, t[a] + restart)) + 1, a + SHORTEST))
                )
                yield a, last
                if last >= b:
                    break
                a = last


def _start(run, robot, row):
    """The state at a row: the joints as measured, in the assembly mode of the end-effector."""
    poses = [dgm(robot, run.q[row], mode, unreachable="nan") for mode in (-1, 1)]
    away = [np.hypot(*(pose.xi - run.xi[row])) for pose in poses]
    if not np.isfinite(away).any():
        raise UnreachableError(
            f"replay: at {run.t[row]:.6g} s this robot's bars do not close on the measured joints",
            float("nan"),
        )
    return dkm(poses[int(np.nanargmin(away))], run.q_dot[row])


def _by_torques(run, robot, rows, _):
    t, tau = run.t[rows] - run.t[rows.start], run.tau[rows]
    step = float(t[-1] / (len(t) - 1))
    even = np.arange(len(t)) * step
    if run.measured is not None:  # at its time, not from it on: held, it is the mean of both ends
        tau = np.concatenate([(tau[1:] + tau[:-1]) / 2, tau[-1:]])
    held = (
        tau
        if np.abs(t - even).max() < 0.01 * step
        else np.stack([np.interp(even, t, each) for each in tau.T], axis=1)
    )

    def torque(now, q, q_dot, reference):
        return held[min(int(now / step + 0.5), len(held) - 1)]

    found = simulate(
        robot,
        torque,
        duration=float(even[-1]),
        start=_start(run, robot, rows.start),
        control_period=step,
        step=step,
    )
    return _at(found, t, run, rows)


def _by_reference(run, robot, rows, controller):
    t = run.t[rows] - run.t[rows.start]
    step = float(t[-1] / (len(t) - 1))
    reference = _through(t, _smooth(run.xi[rows], step) if run.xi_ref is None else run.xi_ref[rows])
    start = _start(run, robot, rows.start)
    modes = tuple(int(mode) or -1 for mode in start.pose.working)
    law = (
        ComputedTorque(robot, KP, KD, modes, int(start.pose.assembly))
        if controller is None
        else controller
    )
    split = max(int(np.ceil(step / MOST_STEP - 1e-9)), 1)
    found = simulate(
        robot,
        law,
        reference,
        duration=float(t[-1]),
        start=start,
        control_period=step,
        step=step / split,
    )
    return _at(found, t, run, rows)


def _smooth(xi, step):
    """Positions without the noise of their encoders, whose accelerations would be large."""
    if len(xi) < 50:
        return xi
    found, _, _ = derivatives(xi, step, spectrum([xi], step).cutoff, ends=True)
    return np.where(np.isfinite(found), found, xi)


def _through(t, xi):
    """A reference through the rows, by quintic splines, or cubic ones of few rows."""
    degree = min(5, len(t) - 1)
    splines = [make_splrep(t, column, k=degree, s=0) for column in xi.T]
    both = [
        spline.derivative(order) if order else spline for order in range(3) for spline in splines
    ]
    return Trajectory(
        0.0, float(t[-1]), lambda now: np.stack([spline(now) for spline in both], axis=-1)
    )


def _at(found, t, run, rows):
    """Of a simulation what a run has, on the times of the log."""

    def on(values):
        return np.stack([np.interp(t, found.t, column) for column in values.T], axis=1)

    events = [event._replace(t=event.t + float(run.t[rows.start])) for event in found.events]
    turns = (
        np.round((run.q[rows.start] - found.q[0]) / (2 * np.pi)) * 2 * np.pi
        if run.robot.turns
        else 0.0
    )
    at = np.minimum(np.searchsorted(found.t, t + 1e-9, side="right") - 1, len(found.t) - 1)
    return {
        "q": on(found.q) + turns,
        "q_dot": on(found.q_dot),
        "xi": on(found.xi),
        "tau": found.tau[at],
        "energy": np.interp(t, found.t, found.energy),
        "events": events,
    }
