"""A log as a Run: positions as they were, rates by differentiation where none were logged, rows of nan in its gaps."""

from __future__ import annotations

import numpy as np

from ..models.dynamics import energy
from ..models.geometry import dgm
from ..models.kinematics import dkm
from ..models.robots import Robot
from ..singularities.margins import Singularity
from .derivatives import HIGHEST, derivatives, half_window, spectrum
from .logs import Log, evenly

APART = 0.02  # of the bars, by which a logged end-effector and the joints' may be apart without a word
NEAR = 1e-6  # of det A, below which no rate of the end-effector is told


def run_fields(log: Log, robot: Robot, assembly: int | None) -> dict:
    """{field: value} of the Run of a log, but for its robot. assembly None: the mode that fits x and y, or -1."""
    said = list(log.said)
    q_dot = log.q_dot if log.q_dot is not None else rates_of(log)
    assembly, xi = _placed(log, robot, assembly, said)
    pose = dgm(robot, log.q, assembly, unreachable="nan")
    closes = np.isfinite(pose.xi).all(axis=1)
    if not closes.all():
        first = int(np.argmin(closes))
        said.append(
            f"{(~closes).sum()} of {len(closes)} rows do not close the loop of this robot's bars, the first at "
            f"{log.t[first]:.6g} s, q = ({log.q[first, 0]:.5g}, {log.q[first, 1]:.5g}) {robot.words.unit}"
        )
    moves = closes & np.isfinite(q_dot).all(axis=1)
    moves &= np.abs(np.where(closes, pose.det_A, 0.0)) > NEAR
    kinetic = np.full(len(log.t), np.nan)
    if moves.any():
        kinetic[moves] = energy(dkm(dgm(robot, log.q[moves], assembly), q_dot[moves]))
    tau = np.full_like(log.q, np.nan) if log.tau is None else log.tau
    rows = {"t": log.t, "q": log.q, "q_dot": q_dot, "xi": xi, "tau": tau, "energy": kinetic, "xi_ref": log.xi_ref}
    events = _crossings(log, robot, pose, closes)
    gaps = tuple((cut.start, cut.end, cut.why) for cut in log.cuts)
    return {**_with_gaps(rows, log), "events": events, "gaps": gaps, "said": tuple(said)}


def rates_of(log: Log) -> np.ndarray:
    """q' (n, 2) of a log without: zero-phase derivatives between its gaps, at their ends of the last whole window."""
    stretches = [(part, *evenly(log.t[part], {"q": log.q[part]}, log.step)[:2]) for part in log.stretches]
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
        found[part] = np.stack([np.interp(t, even, column) for column in own.T], axis=1) if len(t) > 1 else own
    return found


def _placed(log, robot, assembly, said):
    """(mode, end-effector (n, 2)): as logged, or by the joints."""
    modes = (-1, 1) if assembly is None else (assembly,)
    found = {mode: dgm(robot, log.q, mode, unreachable="nan").xi for mode in modes}
    if log.xi is None:
        return modes[0], found[modes[0]]
    away = {mode: np.hypot(*(xi - log.xi).T) for mode, xi in found.items()}
    mode = min(modes, key=lambda each: np.nanmedian(away[each]) if np.isfinite(away[each]).any() else np.inf)
    typical = float(np.nanmedian(away[mode])) if np.isfinite(away[mode]).any() else 0.0
    if typical > APART * max(robot.distal):
        said.append(
            f"x and y are {1e3 * typical:.3g} mm (median) from where the joints say in assembly mode {mode:+d}: "
            "another mode, frame or other lengths; fb.calibrate tells"
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
        before, after = ((*map(int, -np.sign(sines[row])), int(-np.sign(pose.det_A[row]))) for row in (k, k + 1))
        found.append((t, Singularity.SERIAL, robot.words.sines[leg], before, after))
    return found


def _with_gaps(rows, log):
    """The rows with one of nan in the middle of each cut."""
    at, given = [cut.row for cut in log.cuts], {name: values for name, values in rows.items() if values is not None}
    between = {"t": [(cut.start + cut.end) / 2 for cut in log.cuts]}
    return rows | {name: np.insert(v, at, between.get(name, np.nan), axis=0) for name, v in given.items()}
