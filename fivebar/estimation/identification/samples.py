"""Logs as samples of a regression: even in time, differentiated, on the robot's loop; what does not
count is named.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np
from scipy.ndimage import binary_dilation

from ...base.tables import file_or_path
from ...models.geometry import dgm
from ...models.robots import Robot
from ...simulation.run import Run
from ..logs.derivatives import HIGHEST, derivatives, half_window, spectrum
from ..logs.logs import Gauges, Log, evenly, read_log
from .filtering import Rows, filtered, spikes
from .regressor import linear_names, regressor

MARGIN = 0.1  # of det A, below which a singularity makes torques of errors
CREEPING = 0.03  # of the rms of a motor's rate: below, what dry friction does is not known
LONG_AT_LIMIT, AT_LIMIT = (
    3,
    1e-9,
)  # rows in a row whose torque is one of the two extremes: cut off there
BRIDGED = 3  # rows that may be missing without a stretch ending
TAKEN = "q", "tau", "q_dot", "q_ddot"  # of a log
STILL = 10.0  # times what the encoders' noise looks like: less acceleration is no motion


@dataclass(frozen=True, eq=False)
class Samples:
    """parts: (t, W, where (n, 2) a motor's row may count); motion: their (q, q', q''); torques:
    theirs, as logged and as held, and which of them are taken; step s; cutoff Hz; noise (2,), of q;
    remarks: sentences on the log but for its torques; assembly: the mode.
    """

    robot: Robot
    parts: list[tuple]
    motion: list[tuple]
    torques: dict[bool, list[np.ndarray]]
    held: bool
    step: float
    cutoff: float
    noise: tuple[float, float]
    remarks: tuple[str, ...]
    assembly: int

    def as_held(self) -> Samples:
        """The same with each torque held from its row to the next."""
        return replace(self, held=True)

    @cached_property
    def rows(self) -> Rows:
        return filtered(self.pieces, self.step, self.cutoff)

    @cached_property
    def pieces(self) -> list[tuple]:
        """(t, W, tau, counts) as `filtering.filtered` has them."""
        parts = zip(self.parts, self.torques[self.held], self._cut_off, self._spikes)
        return [
            (t, W, tau, good & ~cut & ~spike & np.isfinite(tau))
            for (t, W, good), tau, cut, spike in parts
        ]

    @cached_property
    def _spikes(self):
        """Per part where (n, 2) a torque leaves its neighbours."""
        return [
            np.stack([spikes(tau[:, k]) for k in (0, 1)], axis=1) for tau in self.torques[self.held]
        ]

    @cached_property
    def _extremes(self):
        return [
            (np.nanmin(column), np.nanmax(column))
            for column in np.concatenate(self.torques[self.held]).T
        ]

    @cached_property
    def _cut_off(self):
        """Per part where (n, 2) each torque stays at one of its extremes."""
        torques = self.torques[self.held]
        return [
            np.stack([_at_limit(tau[:, k], *self._extremes[k]) for k in (0, 1)], axis=1)
            for tau in torques
        ]

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences on the log."""
        limits = [
            f"tau{k + 1} stays at its largest value in {rows} rows ({self._extremes[k][1]:.4g} or"
            f" {self._extremes[k][0]:.4g} {self.robot.words.effort_unit}), as if it were cut off"
            " there: these rows do not count"
            for k, rows in enumerate(sum(cut.sum(axis=0) for cut in self._cut_off))
            if rows
        ]
        for k in (0, 1):
            rows = [
                (t[out[:, k]], tau[out[:, k], k])
                for (t, *_), tau, out in zip(self.parts, self.torques[self.held], self._spikes)
            ]
            t, tau = (np.concatenate(each) for each in zip(*rows))
            if len(t):
                limits.append(
                    f"tau{k + 1} leaves its neighbours in {len(t)} rows (the first {tau[0]:.4g} "
                    f"{self.robot.words.effort_unit} at {t[0]:.6g} s): these rows do not count"
                )
        return *self.remarks, *limits

    @property
    def tau_noise(self) -> tuple[float, float]:
        """Standard deviation of each torque's noise, N m, by its fourth differences, in which no
        motion is left.
        """
        found = []
        for column in max(self.torques[self.held], key=len).T:
            rough = np.diff(column[np.isfinite(column)], 4)
            # of white noise their variance is 70 times its own; the median, as jumps are not noise
            found.append(
                float(np.median(np.abs(rough)) / 0.6745 / np.sqrt(70.0)) if len(rough) else 0.0
            )
        return found[0], found[1]


def log_of(source: object, robot: Robot, units: Mapping | None, gauges: Gauges) -> tuple[Log, bool]:
    """A Run's or a file's or a mapping's Log, and whether its torques are held from each time to
    the next.
    """
    if isinstance(source, (str, os.PathLike)) and _is_a_run(source):
        source = Run.from_csv(source)
    if not isinstance(source, Run):
        return read_log(source, robot, units, gauges), False
    if type(source.robot) is not type(robot):
        raise ValueError(
            f"the run is of a {source.robot.words.title}, and robot is a {robot.words.title}"
        )
    own = {"t": source.t, "q": source.q, "tau": source.tau}
    if source.measured is not None and source.measured.rates:
        own["q_dot"] = source.q_dot
    whole = np.isfinite(source.q).all(axis=1)
    own = {name: values[whole] for name, values in own.items()}
    log = read_log(own, robot)
    return log, source.measured is None


def _is_a_run(path):
    """Whether a file was written by Run.to_csv, whose torques may be held."""
    with open(file_or_path(path, "read"), "rb") as file:
        return file.read(14) == b"# fivebar run,"


def samples(log: Log, held: bool, robot: Robot, assembly: int, cutoff: float | None) -> Samples:
    """The Samples of a log. held: a torque stays from its row to the next; cutoff: Hz, None:
    `spectrum` says.
    """
    if log.tau is None:
        raise ValueError(
            "the log has no torques (tau1, tau2): without them nothing can be said of masses or"
            " friction"
        )
    notes, stretches = list(log.notes), []
    for part in _bridged(log, notes):
        pairs = {name: getattr(log, name)[part] for name in TAKEN if getattr(log, name) is not None}
        tau = pairs["tau"]
        pairs["tau_held"] = np.concatenate(
            [tau[:1], (tau[1:] + tau[:-1]) / 2]
        )  # the mean about each row
        stretches.append(evenly(log.t[part], pairs, log.step))
    uneven = max(away for _, _, away in stretches)
    if uneven > 0.01:
        notes.append(
            f"times are up to {100 * uneven:.0f} % of a period off an even grid: put on one, by"
            " cubic splines"
        )
    found = spectrum([pairs["q"] for _, pairs, _ in stretches], log.step)
    rate = 1 / log.step
    if found.fast > 0.02:
        for k, (t, pairs) in product((0, 1), [(t, pairs) for t, pairs, _ in stretches]):
            if (out := spikes(pairs["q"][:, k])).any():
                raise ValueError(
                    f"q{k + 1} leaves its neighbours in {out.sum()} rows, the first at"
                    f" {t[np.argmax(out)]:.6g} s: leave these rows out of the log"
                )
        raise ValueError(
            f"{100 * found.fast:.0f} % of the acceleration is at frequencies above"
            f" {HIGHEST * rate:.3g} Hz, which {rate:.4g} samples a second cannot follow: log"
            " faster, or move slower"
        )
    cutoff = found.cutoff if cutoff is None else cutoff
    if not 0 < cutoff <= HIGHEST * rate * (1 + 1e-9):
        raise ValueError(
            f"cutoff = {cutoff:g} Hz must be above 0 and at most {HIGHEST * rate:.4g} Hz, 1/12 of"
            " the sampling rate"
        )
    n = half_window(cutoff, log.step)
    long = [(t, pairs) for t, pairs, _ in stretches if len(t) > 2 * n + 2]
    lost = sum(len(t) for t, *_ in stretches) - sum(len(t) for t, _ in long)
    if not long:
        longest = max(len(t) for t, *_ in stretches)
        raise ValueError(
            f"the longest stretch without a gap has {longest} rows, and derivatives at a cut-off of"
            f" {cutoff:.3g} Hz ask for {2 * n + 3}: log longer, or give a higher cutoff"
        )
    if lost:
        notes.append(
            f"{lost} rows in stretches shorter than {2 * n + 3} rows do not count: too short for"
            " derivatives"
        )
    motion = [_rates(pairs, log.step, cutoff) for _, pairs in long]
    _must_move(motion, found.noise, cutoff, log.step, robot)
    parts = _parts([t for t, _ in long], motion, robot, assembly, n, notes)
    torques = {
        as_held: [pairs[name] for _, pairs in long]
        for as_held, name in ((False, "tau"), (True, "tau_held"))
    }
    return Samples(
        robot, parts, motion, torques, held, log.step, cutoff, found.noise, tuple(notes), assembly
    )


def _bridged(log, notes):
    """The stretches of a log, over gaps of a few rows, whose torques do not count."""
    parts, bridged = [log.stretches[0]], 0
    for cut, part in zip(log.cuts, log.stretches[1:]):
        if cut.missing and cut.end - cut.start < (BRIDGED + 1.5) * log.step:
            parts[-1], bridged = slice(parts[-1].start, part.stop), bridged + 1
        else:
            parts.append(part)
    if bridged:
        notes.append(
            f"{bridged} gaps of up to {BRIDGED} rows were bridged by cubic splines, without torques"
        )
    return parts


def _rates(pairs, step, cutoff):
    """(q, q', q''): of what was logged the same polynomials; else their derivatives."""
    q, q_dot, q_ddot = derivatives(pairs["q"], step, cutoff)
    if "q_dot" in pairs:
        q_dot, q_ddot, _ = derivatives(pairs["q_dot"], step, cutoff)
    if "q_ddot" in pairs:
        q_ddot, _, _ = derivatives(pairs["q_ddot"], step, cutoff)
    return q, q_dot, q_ddot


def rough(step: float, cutoff: float) -> float:
    """1/s^2: what of white noise of positions in rows `step` s apart is left of accelerations below
    the cut-off.
    """
    return float(np.sqrt(2 * step * (2 * np.pi * cutoff) ** 4 * cutoff / 5))


def _must_move(motion, noise, cutoff, step, robot):
    """Refuse a motor that stands: its inertia would be that of its encoder's noise."""
    for k, name in enumerate(robot.words.joints):
        q, _, second = (np.concatenate([part[:, k] for part in parts]) for parts in zip(*motion))
        moves = np.sqrt(np.nanmean(second**2))
        looks = noise[k] * rough(step, cutoff)
        if not moves > max(
            STILL * looks, 1e-9 * (2 * np.pi * cutoff) ** 2 * max(np.nanmax(np.abs(q)), 1e-6)
        ):
            span = np.nanmax(q) - np.nanmin(q)
            raise ValueError(
                f"{name} hardly moves: over {span:.3g} {robot.words.unit}, with accelerations of"
                f" {moves:.3g} {robot.words.unit}/s² where its noise alone makes {looks:.3g}: move"
                " both motors"
            )


def _parts(times, motion, robot, assembly, n, notes):
    """(t, W, where (n, 2) a motor's row may count) of each stretch."""
    names, parts, total, near, open_, first_near = linear_names(robot), [], 0, 0, 0, None
    dry = [names.index(name) for name in ("fs1", "fs2")]
    rms = np.sqrt(np.nanmean(np.concatenate([q_dot for _, q_dot, _ in motion]) ** 2, axis=0))
    for t, (q, q_dot, q_ddot) in zip(times, motion):
        known = np.isfinite(q).all(axis=1)
        pose = dgm(robot, np.where(known[:, None], q, 0.0), assembly, unreachable="nan")
        closes = np.isfinite(pose.xi).all(axis=1)
        det = np.where(closes, pose.det_A, 0.0)
        singular = known & closes & (np.abs(det) < MARGIN)
        if first_near is None and singular.any():
            first_near = t[int(np.argmax(singular))]
        total, near, open_ = (
            total + known.sum(),
            near + singular.sum(),
            open_ + (known & ~closes).sum(),
        )
        W = regressor(robot, q, q_dot, q_ddot, assembly)
        good = known & closes & ~singular & np.isfinite(W).all(axis=(1, 2))
        creeps = binary_dilation(~(np.abs(q_dot) > CREEPING * rms), np.ones((2 * n + 1, 1)))
        for k in (0, 1):
            W[:, k, dry[k]] = np.sign(np.nan_to_num(q_dot[:, k]))
        parts.append((t, np.nan_to_num(W), good[:, None] & ~creeps))
    if open_ > 0.02 * total:
        refuse_open_log(motion, robot, assembly, open_, total)
    if open_:
        notes.append(
            f"{open_} of {total} rows do not close the loop of this robot's bars and do not count"
        )
    if near:
        notes.append(
            f"{near} of {total} rows are within |det A| < {MARGIN:g} of a Type-2 singularity (the"
            f" first at {first_near:.6g} s) and do not count: there, errors become torques; before"
            f" and after, the assembly mode is taken to be {assembly:+d}: if the robot crossed, cut"
            " the log there"
        )
    return parts


def refuse_open_log(motion, robot, assembly, open_, total):
    """Say why poses do not close: degrees, or other lengths."""
    q = np.concatenate([rates[0] for rates in motion])
    q = q[np.isfinite(q).all(axis=1)]
    message = f"{open_} of {total} rows do not close the loop: the bars of this robot do not reach"
    unit, factor, most = (
        ("deg", np.pi / 180, 2 * np.pi) if robot.turns else ("mm", 1e-3, 4 * max(robot.distal))
    )

    def closes(q):
        return np.isfinite(dgm(robot, q, assembly, unreachable="nan").xi).all(axis=1).mean() > 0.999

    if np.abs(q).max() > most and closes(factor * q):
        raise ValueError(
            f'{message}; as {unit} all of them do: units={{"q1": "{unit}", "q2": "{unit}"}}'
        )
    if closes(q[:, ::-1]):
        raise ValueError(
            f"{message}; with {' and '.join(robot.words.joints)} exchanged all of them do"
        )
    raise ValueError(
        f"{message}: are its lengths, and the zeros of q (offset), those of the robot on the table?"
        " fb.calibrate tells"
    )


def _at_limit(tau, low, high):
    """Where a torque stays at one of its two extremes."""
    size = max(abs(low), abs(high), 1e-300)
    flat = (np.abs(tau - high) <= AT_LIMIT * size) | (np.abs(tau - low) <= AT_LIMIT * size)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flat.astype(int), [0]])))
    kept = np.zeros(len(tau), dtype=bool)
    for first, end in zip(edges[::2], edges[1::2]):
        if end - first >= LONG_AT_LIMIT:
            kept[first:end] = True
    return kept
