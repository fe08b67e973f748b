"""Samples of a log for the regression: on an even grid, differentiated, those that count."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy import ndarray
from scipy.ndimage import binary_dilation

from ...base.tables import file_or_path
from ...models.geometry import dgm
from ...models.robots import Robot
from ...simulation.bags import is_bag
from ...simulation.run import Run
from ..logs.derivatives import HIGHEST, derivatives, half_window, spectrum
from ..logs.logs import Gauges, Log, evenly, off_their_neighbours, read_log
from .filtering import RegressionRows, at_limit, filtered
from .regressor import linear_names, regressor

SINGULAR = 0.1  # |det A| below which errors of the joints become torques
CREEPING = 0.03  # of a motor's rms rate: below, dry friction is not known
STILL = 2.0  # times its encoder's noise: a motor that moves by less stands still
FEWEST = 100  # rows of the regression, without which masses and friction are not told apart
MISSING = 1e-3  # of the rows: a filter needs the velocities about each row
PEAK = 0.25  # of the torques' range: as a controller begins, torques have real peaks of less
BRIDGED = 3  # rows that may be missing within a stretch


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of a log.

    pieces: (t (n,), W (n, 2, p), tau (n, 2), counts (n, 2): a motor's sample is used); motion:
    their (q, q', q''); changes: of each W, by noise of the encoders drawn anew; step s; cutoff Hz;
    notes on the log; assembly: the mode; held: each torque is the mean of two rows.
    """

    robot: Robot
    pieces: list[tuple]
    motion: list[tuple]
    changes: list[ndarray]
    step: float
    cutoff: float
    notes: tuple[str, ...]
    assembly: int
    held: bool = False

    @cached_property
    def rows(self) -> RegressionRows:
        pieces = []
        for (t, W, tau, counts), change in zip(self.pieces, self.changes):
            pieces.append((t, np.concatenate([W, change], axis=2), tau, counts))
        rows = filtered(pieces, self.step, self.cutoff)
        W, change = np.split(rows.W, 2, axis=2)
        return replace(rows, W=W, change=change)


def log_of(source: Any, robot: Robot, gauges: Gauges) -> tuple[Log, bool]:
    """Return the Log of a Run, a file or a mapping, and whether its torques are held.

    Those of a simulated run are held from each time to the next.
    """
    if isinstance(source, (str, os.PathLike)) and not is_bag(source) and _is_a_run(source):
        source = Run.from_csv(source)
    if not isinstance(source, Run):
        log = read_log(source, robot, gauges, torques=True)
        return log, log.is_held
    if type(source.robot) is not type(robot):
        raise ValueError(
            f"the run is of a {source.robot.words.title}, and robot is a {robot.words.title}"
        )
    columns = {"t": source.t, "q": source.q, "tau": source.tau}
    if source.measured is not None and source.measured.rates:
        columns["q_dot"] = source.q_dot
    known = np.isfinite(source.q).all(axis=1)  # gaps are rows of nan
    log = read_log({name: values[known] for name, values in columns.items()}, robot)
    return log, source.measured is None or source.measured.held


def _is_a_run(path):
    with open(file_or_path(path, "read"), "rb") as file:
        return file.read(14) == b"# fivebar run,"


def samples(log: Log, held: bool, robot: Robot, assembly: int, cutoff: float | None) -> Samples:
    """Return the Samples of a log.

    `held`: a torque stays from its row to the next. `cutoff`, Hz; None: where the motion sinks into
    its noise.
    """
    if log.tau is None:
        raise ValueError(
            f"the log has no torques ({'; '.join(log.notes)}), and masses and friction need them:"
            " record them, too"
        )
    notes = list(log.notes)
    if log.q_dot is not None:
        missing = np.isnan(log.q_dot).any(axis=1).sum()
        if missing > MISSING * len(log.t):
            notes.append(f"the velocities are missing in {missing} rows: they are not used")
            log = replace(log, q_dot=None)
    stretches = _even_stretches(log, notes)
    found = spectrum([pairs["q"] for _, pairs in stretches], log.step)
    if found.fast > 0.02:
        raise ValueError(
            f"{100 * found.fast:.0f} % of the acceleration is at frequencies above"
            f" {HIGHEST / log.step:.3g} Hz, which the sampling rate cannot follow: log faster, or"
            " move slower"
        )
    highest = HIGHEST / log.step
    if cutoff is None:
        duration = log.step * sum(len(t) for t, _ in stretches)
        cutoff = min(max(found.cutoff, FEWEST / (2.5 * duration)), highest)
    if not 0 < cutoff <= highest * (1 + 1e-9):
        raise ValueError(
            f"cutoff = {cutoff:g} Hz must be above 0 and at most {highest:.4g} Hz, 1/12 of the"
            " sampling rate"
        )
    least = 2 * half_window(cutoff, log.step) + 3
    long = [(t, pairs) for t, pairs in stretches if len(t) >= least]
    if not long:
        longest = max(len(t) for t, _ in stretches)
        raise ValueError(
            f"the longest stretch without a gap has {longest} rows, and derivatives at a cut-off of"
            f" {cutoff:.3g} Hz need {least}: log longer, or give a higher cutoff"
        )
    motion = [_rates(pairs, log.step, cutoff) for _, pairs in long]
    _refuse_still(stretches, found.noise, robot)
    drawn = _drawn_noise(long, found.noise, log.step, cutoff)
    regressors = _regressors(motion, drawn, robot, assembly, least // 2, notes)
    torques = np.concatenate([pairs["tau"] for _, pairs in long])
    if not np.isfinite(torques).any(axis=0).all():
        raise ValueError(
            f"no row of the log has positions and both torques ({'; '.join(log.notes)}): record"
            " them together"
        )
    idle = [
        name for name, column in zip(("tau1", "tau2"), torques.T) if not np.nan_to_num(column).any()
    ]
    if idle:
        raise ValueError(
            f"{', '.join(idle)} {'are' if idle[1:] else 'is'} all 0: the driver did not measure"
            f" the {robot.words.effort}s; record them, or the currents (torque_constant)"
        )
    lowest = np.nanmin(torques, axis=0)
    highest_tau = np.nanmax(torques, axis=0)
    pieces = []
    left_out: dict[str, list] = {
        "leave their neighbours": [],
        "stay at their largest value, as if cut off,": [],
    }
    for (t, pairs), (W, _, good) in zip(long, regressors):
        tau = pairs["tau"]
        off = off_their_neighbours(tau, PEAK)[:, None]
        limited = at_limit(tau, lowest, highest_tau)
        for out, times in zip((off, limited), left_out.values()):
            times += t[out.any(axis=1)].tolist()
        tau = np.where(off | limited, np.nan, tau)
        pieces.append((t, W, tau, good & np.isfinite(tau)))
    for words, times in left_out.items():
        if times:
            notes.append(
                f"torques {words} in {len(times)} rows (the first at {times[0]:.6g} s): these rows"
                " do not count"
            )
    changes = [change for _, change, _ in regressors]
    found = Samples(robot, pieces, motion, changes, log.step, cutoff, tuple(notes), assembly)
    return with_held_torques(found) if held else found


def with_held_torques(found: Samples) -> Samples:
    """Return samples whose torques stay from row to row: the mean about each row."""
    pieces = []
    for t, W, tau, counts in found.pieces:
        means = (tau + np.concatenate([tau[:1], tau[:-1]])) / 2
        pieces.append((t, W, np.where(np.isfinite(means), means, tau), counts))
    return replace(found, pieces=pieces, held=True)


def _even_stretches(log, notes):
    """Return (t, pairs) of the stretches, over gaps of a few rows, on an even grid of times."""
    parts = [log.stretches[0]]
    bridged = 0
    for cut, part in zip(log.cuts, log.stretches[1:]):
        if 0 < cut.missing <= BRIDGED:
            parts[-1], bridged = (slice(parts[-1].start, part.stop), bridged + 1)
        else:
            parts.append(part)
    if bridged:
        notes.append(
            f"{bridged} gaps of up to {BRIDGED} rows were bridged by cubic splines, without torques"
        )
    stretches = []
    uneven = 0.0
    for part in parts:
        logged = {name: getattr(log, name) for name in ("q", "tau", "q_dot")}
        pairs = {name: pair[part] for name, pair in logged.items() if pair is not None}
        t, pairs, distance = evenly(log.t[part], pairs, log.step)
        stretches.append((t, pairs))
        uneven = max(uneven, distance)
    if uneven > 0.01:
        notes.append(
            f"times are up to {100 * uneven:.0f} % of a period off an even grid: put on one, by"
            " cubic splines"
        )
    return stretches


def _rates(pairs, step, cutoff):
    """Return (q, q', q''): the same polynomials of what was logged, else their derivatives."""
    q, q_dot, q_ddot = derivatives(pairs["q"], step, cutoff)
    if "q_dot" in pairs:
        q_dot, q_ddot, _ = derivatives(pairs["q_dot"], step, cutoff)
    return q, q_dot, q_ddot


def _drawn_noise(stretches, of_q, step, cutoff):
    """Return (q, q', q'') of noise as large as that of each stretch, drawn anew."""
    rng = np.random.default_rng(0)
    sizes = {"q": of_q}
    if "q_dot" in stretches[0][1]:
        sizes["q_dot"] = spectrum([pairs["q_dot"] for _, pairs in stretches], step).noise
    result = []
    for t, _ in stretches:
        noise = {name: size * rng.normal(size=(len(t), 2)) for name, size in sizes.items()}
        result.append(_rates(noise, step, cutoff))
    return result


def _refuse_still(stretches, noise, robot):
    """Refuse a motor that stands still: its inertia would be that of its encoder's noise."""
    q = np.concatenate([pairs["q"] for _, pairs in stretches])
    swing = np.std(q - q[0], axis=0)
    words = robot.words
    for joint, size, own in zip(words.joints, swing, noise):
        if not size > STILL * own:
            raise ValueError(
                f"{joint} hardly moves: its standard deviation of {size:.2g} {words.unit} is that"
                f" of its noise, {own:.2g} {words.unit}, or of a motion that the sampling rate"
                " cannot follow: move both motors, or log faster"
            )


def _regressors(motion, drawn, robot, assembly, n, notes):
    """Return W (n, 2, p) of each stretch, its change by drawn noise, and where a row may count."""
    names = linear_names(robot)
    rms = np.sqrt(np.nanmean(np.concatenate([q_dot for _, q_dot, _ in motion]) ** 2, axis=0))
    result = []
    total = near = open_ = 0
    for (q, q_dot, q_ddot), noise in zip(motion, drawn):
        known = np.isfinite(q).all(axis=1)
        pose = dgm(robot, np.where(known[:, None], q, 0.0), assembly, unreachable="nan")
        closes = np.isfinite(pose.xi).all(axis=1)
        singular = closes & (np.abs(np.where(closes, pose.det_A, 0.0)) < SINGULAR)
        total += known.sum()
        near += (known & singular).sum()
        open_ += (known & ~closes).sum()
        W = regressor(robot, q, q_dot, q_ddot, assembly)
        noisy = (q + noise[0], q_dot + noise[1], q_ddot + noise[2])
        change = regressor(robot, *noisy, assembly) - W
        good = known & closes & ~singular & np.isfinite(W).all(axis=(1, 2))
        creeps = binary_dilation(~(np.abs(q_dot) > CREEPING * rms), np.ones((2 * n - 1, 1)))
        for k, name in enumerate(("fs1", "fs2")):
            W[:, k, names.index(name)] = np.sign(np.nan_to_num(q_dot[:, k]))
            change[:, k, names.index(name)] = 0.0
        result.append((np.nan_to_num(W), np.nan_to_num(change), good[:, None] & ~creeps))
    open_words = f"{open_} of {total} rows do not close the loop"
    if open_ > 0.02 * total:
        raise ValueError(
            f"{open_words}: the bars of this robot do not reach: are its lengths, and the zeros of"
            " q (offset), those of the robot on the table? fb.calibrate tells. Are q1 and q2"
            " exchanged, or has one the wrong sign or another gear_ratio?"
        )
    if open_:
        notes.append(f"{open_words} of this robot's bars and do not count")
    if near:
        notes.append(
            f"{near} of {total} rows are within |det A| < {SINGULAR:g} of a Type-2 singularity and"
            " do not count: there, errors become torques; before and after, the assembly mode is"
            f" taken to be {assembly:+d}: if the robot crossed, cut the log there"
        )
    return result
