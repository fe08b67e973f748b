"""Make a Run of a log: its positions, rates by differentiation, rows of nan in its gaps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy import ndarray

from ...base.checks import instance, modes, optional, strings, takes
from ...base.robot_uses import robot_for
from ...base.tables import FilePath
from ...models.dynamics import energy
from ...models.geometry import dgm
from ...models.kinematics import dkm
from ...models.robots import FiveBar, Robot
from ...simulation.bags import JOINTS, read_bag
from ...simulation.events import crossings
from ...simulation.run import Measured, Run
from .derivatives import HIGHEST, derivatives, half_window, spectrum
from .logs import Gauges, Log, evenly, read_log

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

NEAR = 1e-6  # |det A| below which no rate of the end-effector is computed
OFF = 0.02  # share of a distal bar by which logged points may be off the joints' without a note


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
    columns: Mapping[str, str] | None = None,
    counts_per_turn: object = None,
    gear_ratio: object = 1.0,
    offset: object = (0.0, 0.0),
    torque_constant: object = None,
    **more: ArrayLike,
) -> Run:
    """Return the Run of a log: its rows, differentiated, with a row of nan in each gap.

    Parameters
    ----------
    t : (n,) array, mapping or file
        Times, s, together with the columns below. Or a mapping of columns, or a CSV or NPZ file;
        headings may name units: t_ms, q1 (deg).
    q1, q2, tau1, tau2 : (n,) arrays
        Joint angles, rad, and torques, N m.
    robot : FiveBar or Biglide, optional
        The robot of the log; the AMORO robot by default.
    assembly : int, optional
        The assembly mode; by default the one that fits x and y, or -1.
    units : mapping, optional
        Units of columns that name none: {"q1": "deg"}.
    columns : mapping, optional
        Headings of columns that are called otherwise: {"q1": "position[0]", "tau1": "M1 (mNm)"}.
    counts_per_turn : float or pair, optional
        Encoder counts of a turn, where q is in counts; negative where it counts the other way.
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
        Rows without a time or a position or out of order, gaps, restarts and jumps of whole turns
        are named in `run.measured.notes`.

    Raises
    ------
    ValueError
        The columns are no motion.

    Examples
    --------
    >>> import fivebar as fb
    >>> t = [0.0, 0.01, 0.02, 0.03]
    >>> run = fb.from_log(t, [0.0, 0.1, 0.2, 0.3], [0.0, 0.0, 0.0, 0.0])
    >>> run.q_dot[1].round(6).tolist()
    [10.0, 0.0]
    """
    source: Any = t
    whole = isinstance(t, (Mapping, str, PathLike)) or hasattr(t, "read")
    arrays = {"q1": q1, "q2": q2, "tau1": tau1, "tau2": tau2, **more}
    if not whole:
        source = {"t": t, **arrays}
    elif extra := [name for name, array in arrays.items() if array is not None]:
        raise ValueError(f"from_log: columns beside a file or a mapping: {', '.join(extra)}")
    own: Any = FiveBar() if robot is None else robot_for("fb.from_log")(robot, "robot")
    if assembly is not None:
        assembly = modes(1)(assembly, "assembly")
    gauges = Gauges(counts_per_turn, gear_ratio, offset, torque_constant, units, columns)
    return _run_of(read_log(source, own, gauges), own, assembly)


@takes(path=instance(str, PathLike), topic=optional(instance(str)), joints=strings)
def from_bag(
    path: FilePath,
    topic: str | None = None,
    joints: Sequence[str] = JOINTS,
    *,
    robot: Robot | None = None,
    assembly: int | None = None,
    gear_ratio: object = 1.0,
    offset: object = (0.0, 0.0),
    torque_constant: object = None,
) -> Run:
    """Return the Run in a bag of ROS 2 (sqlite3 or MCAP), as `from_log` does.

    Parameters
    ----------
    path : path
        The bag's folder, or an MCAP file.
    topic : str, optional
        Of messages sensor_msgs/JointState; /joint_states, or the only one, by default.
    joints : pair of str
        The left and the right motor's joint in the messages.
    robot, assembly, gear_ratio, offset, torque_constant
        As of `from_log`.

    Returns
    -------
    Run
        Its reference is that of a JointTrajectory, or of a Pose or Point in whose topic is "ref",
        "desired", "goal", "target" or "command". Other poses are those of the end-effector.

    Raises
    ------
    ValueError
        The bag has no such topic or joints; the message names those that it has.
    ImportError
        The package rosbags is not installed (`pip install fivebar[ros]`).

    Examples
    --------
    >>> import fivebar as fb
    >>> run = fb.from_bag("rosbag2_2026_05_01", joints=("joint_1", "joint_2"))  # doctest: +SKIP
    """
    own: Any = FiveBar() if robot is None else robot_for("fb.from_bag")(robot, "robot")
    table = read_bag(path, own, topic, joints, -1 if assembly is None else assembly)
    gauges = Gauges(None, gear_ratio, offset, torque_constant)
    return _run_of(read_log(table, own, gauges), own, assembly)


def _run_of(log, robot, assembly):
    notes = list(log.notes)
    q_dot = rates_of(log) if log.q_dot is None else log.q_dot
    assembly, xi = _end_effector(log, robot, assembly, notes)
    pose = dgm(robot, log.q, assembly, unreachable="nan")
    closes = np.isfinite(pose.xi).all(axis=1)
    if not closes.all():
        notes.append(
            f"{(~closes).sum()} of {len(closes)} rows do not close the loop of this robot's bars,"
            f" the first at {log.t[np.argmin(closes)]:.6g} s"
        )
    regular = closes & (np.abs(np.where(closes, pose.det_A, 0.0)) > NEAR)
    moves = regular & np.isfinite(q_dot).all(axis=1)
    kinetic = np.full(len(log.t), np.nan)
    if moves.any():
        kinetic[moves] = energy(dkm(dgm(robot, log.q[moves], assembly), q_dot[moves]))
    middles = [(cut.start + cut.end) / 2 for cut in log.cuts]
    tau = np.full_like(log.q, np.nan) if log.tau is None else log.tau

    def with_gaps(values, between=np.nan):
        return np.insert(values, [cut.row for cut in log.cuts], between, axis=0)

    return Run(
        robot=robot,
        t=with_gaps(log.t, middles),
        q=with_gaps(log.q),
        q_dot=with_gaps(q_dot),
        xi=with_gaps(xi),
        tau=with_gaps(tau),
        energy=with_gaps(kinetic),
        xi_ref=None if log.xi_ref is None else with_gaps(log.xi_ref),
        events=_crossings(log, robot, pose, closes),
        measured=Measured(
            tuple((cut.start, cut.end, cut.why) for cut in log.cuts),
            tuple(notes),
            log.q_dot is not None,
            log.is_held,
        ),
    )


def rates_of(log: Log) -> ndarray:
    """Return q' (n, 2) of a log without rates, by derivatives between its gaps."""
    pieces = [evenly(log.t[rows], {"q": log.q[rows]}, log.step) for rows in log.stretches]
    own_cutoff = spectrum([pairs["q"] for _, pairs, _ in pieces], log.step).cutoff
    highest = HIGHEST / log.step
    result = np.full(log.q.shape, np.nan)
    for rows, (even, pairs, _) in zip(log.stretches, pieces):
        q = pairs["q"]
        cutoff = own_cutoff
        while len(q) <= 2 * half_window(cutoff, log.step) and cutoff < highest:
            cutoff = min(2 * cutoff, highest)
        if len(q) > 2 * half_window(cutoff, log.step):
            rates = derivatives(q, log.step, cutoff, ends=True)[1]
        elif len(q) > 1:
            rates = np.gradient(q, even, axis=0)
        else:
            rates = np.zeros_like(q)
        for k in (0, 1):
            result[rows, k] = np.interp(log.t[rows], even, rates[:, k])
    return result


def _end_effector(log, robot, assembly, notes):
    """Return the assembly mode and the end-effector (n, 2), as logged or by the joints."""
    candidates = (-1, 1) if assembly is None else (assembly,)
    by_joints = {mode: dgm(robot, log.q, mode, unreachable="nan").xi for mode in candidates}
    if log.xi is None:
        return candidates[0], by_joints[candidates[0]]
    typical = {}
    for mode, xi in by_joints.items():
        distance = np.hypot(*(xi - log.xi).T)
        known = distance[np.isfinite(distance)]
        typical[mode] = float(np.median(known)) if len(known) else np.inf
    mode = min(candidates, key=lambda mode: typical[mode])
    if np.inf > typical[mode] > OFF * max(robot.distal):
        notes.append(
            f"x and y are {1e3 * typical[mode]:.3g} mm (median) from where the joints say in"
            f" assembly mode {mode:+d}: another mode, frame or other lengths; fb.calibrate tells"
        )
    return mode, np.where(np.isfinite(log.xi), log.xi, by_joints[mode])


def _crossings(log, robot, pose, closes):
    """Return the Events where a sine changes its sign, not across gaps and open loops."""
    margins = np.stack([*pose.sines, pose.det_A], axis=1)
    ends = np.flatnonzero(np.diff(closes)) + 1
    edges = {*ends.tolist(), *(cut.row for cut in log.cuts)}
    pieces = np.split(np.arange(len(closes)), sorted(edges))
    events = []
    for rows in pieces:
        if len(rows) > 1 and closes[rows[0]]:
            t = log.t[rows]
            own = margins[rows]
            events += crossings(robot, t, own, np.gradient(own, t, axis=0))
    return tuple(events)
