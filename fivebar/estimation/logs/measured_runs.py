"""A log as a Run: positions as they were, rates by differentiation where none were logged, rows of
nan in its gaps.
"""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from typing import TYPE_CHECKING

import numpy as np

from ...base.checks import modes
from ...base.checks import robot as must_be_robot
from ...models.dynamics import energy
from ...models.geometry import dgm
from ...models.kinematics import dkm
from ...models.robots import FiveBar, Robot
from ...simulation.run import Event, Measured, Run
from ...singularities.margins import Singularity
from .derivatives import HIGHEST, derivatives, half_window, spectrum
from .logs import Gauges, Log, evenly, read_log

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

APART = (
    0.02  # of the bars, by which a logged end-effector and the joints' may be apart without a word
)
NEAR = 1e-6  # of det A, below which no rate of the end-effector is told


def run_fields(log: Log, robot: Robot, assembly: int | None) -> dict:
    """{field: value} of the Run of a log, but for its robot. assembly None: the mode that fits x
    and y, or -1.
    """
    notes = list(log.notes)
    q_dot = log.q_dot if log.q_dot is not None else rates_of(log)
    assembly, xi = _placed(log, robot, assembly, notes)
    pose = dgm(robot, log.q, assembly, unreachable="nan")
    closes = np.isfinite(pose.xi).all(axis=1)
    if not closes.all():
        first = int(np.argmin(closes))
        notes.append(
            f"{(~closes).sum()} of {len(closes)} rows do not close the loop of this robot's bars,"
            f" the first at {log.t[first]:.6g} s, q = ({log.q[first, 0]:.5g},"
            f" {log.q[first, 1]:.5g}) {robot.words.unit}"
        )
    moves = closes & np.isfinite(q_dot).all(axis=1)
    moves &= np.abs(np.where(closes, pose.det_A, 0.0)) > NEAR
    kinetic = np.full(len(log.t), np.nan)
    if moves.any():
        kinetic[moves] = energy(dkm(dgm(robot, log.q[moves], assembly), q_dot[moves]))
    tau = np.full_like(log.q, np.nan) if log.tau is None else log.tau
    rows = {
        "t": log.t,
        "q": log.q,
        "q_dot": q_dot,
        "xi": xi,
        "tau": tau,
        "energy": kinetic,
        "xi_ref": log.xi_ref,
    }
    events = _crossings(log, robot, pose, closes)
    gaps = tuple((cut.start, cut.end, cut.why) for cut in log.cuts)
    return {**_with_gaps(rows, log), "events": events, "gaps": gaps, "notes": tuple(notes)}


def rates_of(log: Log) -> np.ndarray:
    """q' (n, 2) of a log without: zero-phase derivatives between its gaps, at their ends of the
    last whole window.
    """
    stretches = [
        (part, *evenly(log.t[part], {"q": log.q[part]}, log.step)[:2]) for part in log.stretches
    ]
    cutoff = spectrum([pairs["q"] for _, _, pairs in stretches], log.step).cutoff
    found = np.full(log.q.shape, np.nan)
    for part, even, pairs in stretches:
        q, high = pairs["q"], cutoff
        while len(q) <= 2 * half_window(high, log.step) and high < HIGHEST / log.step:
            high = min(2 * high, HIGHEST / log.step)
        if len(q) <= 2 * half_window(high, log.step):
            own = np.gradient(q, even, axis=0) if len(q) > 1 else np.zeros_like(q)
        else:
            own = derivatives(q, log.step, high, ends=True)[1]
        t = log.t[part]
        found[part] = (
            np.stack([np.interp(t, even, column) for column in own.T], axis=1)
            if len(t) > 1
            else own
        )
    return found


def _placed(log, robot, assembly, notes):
    """(mode, end-effector (n, 2)): as logged, or by the joints."""
    modes = (-1, 1) if assembly is None else (assembly,)
    found = {mode: dgm(robot, log.q, mode, unreachable="nan").xi for mode in modes}
    if log.xi is None:
        return modes[0], found[modes[0]]
    away = {mode: np.hypot(*(xi - log.xi).T) for mode, xi in found.items()}
    mode = min(
        modes,
        key=lambda each: np.nanmedian(away[each]) if np.isfinite(away[each]).any() else np.inf,
    )
    typical = float(np.nanmedian(away[mode])) if np.isfinite(away[mode]).any() else 0.0
    if typical > APART * max(robot.distal):
        notes.append(
            f"x and y are {1e3 * typical:.3g} mm (median) from where the joints say in assembly"
            f" mode {mode:+d}: another mode, frame or other lengths; fb.calibrate tells"
        )
    lost = ~np.isfinite(log.xi)
    return mode, np.where(lost, found[mode], log.xi)


def _crossings(log, robot, pose, closes) -> list[tuple]:
    """(t, type, name, modes before, after) of the legs' changes of mode between two rows."""
    sines = np.stack([np.where(closes, each, np.nan) for each in pose.sines], axis=1)
    cut = {own.row for own in log.cuts}
    found = []
    for k, leg in zip(*np.nonzero(sines[:-1] * sines[1:] < 0)):
        if k + 1 in cut:
            continue
        share = sines[k, leg] / (sines[k, leg] - sines[k + 1, leg])
        t = float(log.t[k] + share * (log.t[k + 1] - log.t[k]))
        before, after = (
            (*map(int, -np.sign(sines[row])), int(-np.sign(pose.det_A[row]))) for row in (k, k + 1)
        )
        found.append((t, Singularity.SERIAL, robot.words.sines[leg], before, after))
    return found


def _with_gaps(rows, log):
    """The rows with one of nan in the middle of each cut."""
    at, given = (
        [cut.row for cut in log.cuts],
        {name: values for name, values in rows.items() if values is not None},
    )
    between = {"t": [(cut.start + cut.end) / 2 for cut in log.cuts]}
    return rows | {
        name: np.insert(v, at, between.get(name, np.nan), axis=0) for name, v in given.items()
    }


def from_log(
    t: object,
    q1: ArrayLike | None = None,
    q2: ArrayLike | None = None,
    tau1: ArrayLike | None = None,
    tau2: ArrayLike | None = None,
    *,
    robot: Robot | None = None,
    assembly: int | None = None,
    units: Mapping[str, str] | None = None,
    counts_per_turn: object = None,
    gear_ratio: object = 1.0,
    offset: object = (0.0, 0.0),
    torque_constant: object = None,
    **more: ArrayLike,
) -> Run:
    """Return the Run of a log: its rows as they are, differentiated, its gaps marked by rows of
    nan.

    Parameters
    ----------
    t : (n,) array, mapping or CSV file
        Times, s, together with the columns below. Or a mapping of columns, or a CSV file whose
        header names units.
    q1, q2, tau1, tau2 : (n,) arrays
        Joint angles, rad, and torques, N m.
    robot : FiveBar or Biglide, optional
        The robot of the log; the AMORO robot by default.
    assembly : int, optional
        The assembly mode; by default the one that fits x and y, or -1.
    units : mapping, optional
        Units of columns that name none: {"q1": "deg"}.
    counts_per_turn : float or pair, optional
        Encoder counts of a turn, where q is in counts.
    gear_ratio : float or pair
        Turns of the encoder for a turn of the joint; negative where it turns the other way.
    offset : pair
        Angle of the joint, rad, where the encoder reads 0.
    torque_constant : float or pair, optional
        Torque of the motor for a unit of tau, N m/A; the joint's is gear_ratio times as large.
    **more : (n,) arrays
        Columns q1_dot, q2_dot, x, y, x_ref, y_ref.

    Returns
    -------
    Run
        Rows without a time or a position, gaps, restarts and jumps of whole turns are named in
        `run.measured.notes`.

    Raises
    ------
    ValueError
        The columns are no motion.
    """
    source = t
    if (
        q1 is not None
        or q2 is not None
        or not (isinstance(t, (Mapping, str, PathLike)) or hasattr(t, "read"))
    ):
        source = {"t": t, "q1": q1, "q2": q2, "tau1": tau1, "tau2": tau2, **more}
    elif more or tau1 is not None or tau2 is not None:
        raise ValueError(
            f"from_log: columns beside a file or a mapping: {', '.join([*more, 'tau1', 'tau2'])}"
        )
    robot = FiveBar() if robot is None else must_be_robot(robot, "robot")
    log = read_log(
        source, robot, units, Gauges(counts_per_turn, gear_ratio, offset, torque_constant)
    )
    fields = run_fields(log, robot, None if assembly is None else modes(1)(assembly, "assembly"))
    events = tuple(Event(*each) for each in fields.pop("events"))
    measured = Measured(fields.pop("gaps"), fields.pop("notes"), log.q_dot is not None)
    return Run(robot=robot, **fields, events=events, measured=measured)
