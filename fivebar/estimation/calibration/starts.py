"""Where a calibration begins: values that bring the legs to the measured points, whatever the
modes.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from ...base.backend import wrap
from ...models.dyads import Crank
from ...models.geometry import reach
from .fit import Task, noted_assembly
from .measured_robot import PLACE, bars_off, frame, place, seen, unframe
from .rows import Rows

# Of a mean bar: a leg that misses a point by more is no noise, and weighs less in the start.
NEAR = 1e-3
FAR = 0.4  # of a length's logarithm from its start: no five-bar is built so wrong
LAID = 4  # times a frame is laid on the points, each in the mode that was nearer then
HOLD = 1e-5  # of a start, to itself: less than any noise
MUCH = 8.0  # rad: a motor of a five-bar turns no more while it is measured
USUAL = (  # counts a turn
    400, 500, 512, 600, 800, 1000, 1024, 1200, 1600, 2000, 2048, 2400, 2500, 3200, 3600, 4000, 4096, 5000, 6400,
    8000, 8192, 10000, 12800, 16384, 20000, 32768, 36000, 40000, 65536,
)  # fmt: skip
SUSPECT = 5e-3  # of a mean bar: missed by more in the median, something is wrong


def begin(task: Task, far: bool = True) -> np.ndarray:
    """Values (13,) to begin with: from points alone, whatever the modes; a bad row or two do not
    matter.

    If the start leads nowhere, the measured points say where the angles begin, usual encoders are
    tried where ratios are free, and (far) a whole turn of offsets.
    """
    if task.rows.whole.sum() < 3:
        return _shifted(task)
    found = settled(task, first(task))
    for more in (_read_off, _counted, _turned)[: 2 + far]:
        if doubt(task, found) > SUSPECT * task.bar and (tried := more(task)):
            found = min(found, settled(task, _best(task, tried)), key=lambda p: doubt(task, p))
    return found


def first(task: Task) -> np.ndarray:
    """The start, or the start with the frame that fits best to either assembly mode, whichever
    misses least.
    """
    return _best(task, [task.start, *_framed(task, task.start)])


def _best(task, tried):
    return min(tried, key=lambda p: doubt(task, p))


def miss(task: Task, p: np.ndarray) -> float:
    """Median over the rows with whole points of how far the legs miss them, measured m; inf where
    that is no number.
    """
    rows = task.rows
    off = bars_off(p, rows.q[rows.whole], rows.points[rows.whole])[0]
    return float(np.nan_to_num(np.median(np.hypot(*off.T)), nan=np.inf))


def doubt(task: Task, p: np.ndarray) -> float:
    """`miss`, by which starts are compared, and more for lengths far from the start's and for
    points in one place.

    A robot without cranks would be in one point, whatever the angles; metres that are millimetres
    look like one.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.abs(np.log(p[:5] / task.start[:5]))[task.start[:5] > 0]
    strange = task.bar * np.maximum(np.nan_to_num(change, nan=np.inf) - FAR, 0.0).max()
    spread = np.std(unframe(p, task.rows.points[task.rows.whole]), axis=1).max()
    return (miss(task, p) / p[PLACE["scale"]] + strange) * max(
        1.0, 0.5 * task.bar / max(spread, 1e-300)
    )


def settled(task: Task, p: np.ndarray, steps: int = 60) -> np.ndarray:
    """Least squares of the legs' misses from these values, held weakly to their start."""
    rows, size = task.rows, task.bar
    q, points = rows.q[rows.whole], rows.points[rows.whole]
    if not np.isfinite(miss(task, p)):
        return p
    shape, hold = (-1, len(task.free)), HOLD * np.eye(len(task.free))

    def off(z):
        return np.concatenate([bars_off(_moved(p, task, z), q, points)[0].ravel() / size, HOLD * z])

    def slope(z):
        own = (
            bars_off(_moved(p, task, z), q, points)[1][:, :, task.free].reshape(shape)
            * task.size
            / size
        )
        return np.concatenate([own, hold])

    start = np.zeros(shape[1])
    done = least_squares(
        off,
        start,
        slope,
        loss="soft_l1",
        f_scale=NEAR,
        max_nfev=steps,
        ftol=1e-7,
        xtol=1e-7,
        gtol=1e-9,
    )
    return _moved(p, task, done.x)


def _moved(p, task, z):
    p = p.copy()
    p[task.free] += z * task.size
    p[PLACE["scale"]] = abs(p[PLACE["scale"]]) or 1e-12
    return p


def _read_off(task):
    """The start with offsets, and ratios, that bring the readings to the angles at which the points
    are reached.
    """
    rows, free = task.rows, set(task.names)
    if not free & {"offset1", "offset2", "ratio1", "ratio2"}:
        return []
    tried = []
    for modes in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
        p = task.start.copy()
        for leg in (0, 1):
            ratio, offset = reading(task.start, rows, leg, modes[leg])
            own = f"ratio{leg + 1}" in free, f"offset{leg + 1}" in free
            p[7 + leg] = ratio if own[0] else p[7 + leg]
            p[5 + leg] = offset if own[1] and own[0] else p[5 + leg]
            if own[1] and not own[0]:
                away = angle_at(task.start, rows, leg, modes[leg]) - p[7 + leg] * rows.q[:, leg]
                p[5 + leg] = np.angle(np.nansum(np.exp(1j * away)))
        tried.append(p)
    return tried


def angle_at(p: np.ndarray, rows: Rows, leg: int, working: int) -> np.ndarray:
    """The drive's angle (n,) with which a leg reaches the measured points, in the mode noted, else
    in `working`.
    """
    robot_xi = np.stack(unframe(p, rows.points), axis=-1)
    mode = np.where(rows.working[:, leg], rows.working[:, leg], working)
    with np.errstate(invalid="ignore", divide="ignore"):
        drive = Crank((-1, 1)[leg] * p[4] / 2, 0.0, p[2 * leg])
        return reach(drive, (robot_xi[:, 0], robot_xi[:, 1]), p[2 * leg + 1], mode).q


def reading(p: np.ndarray, rows: Rows, leg: int, working: int) -> tuple[float, float]:
    """(ratio, offset) with which a leg's readings are the angles at its points: medians of slopes,
    so a bad row or two do not matter.
    """
    angle, q = angle_at(p, rows, leg, working), rows.q[:, leg]
    good = np.isfinite(angle)
    angle, q = angle[good], q[good]
    first, second = np.triu_indices(len(q), 1)
    apart = np.abs(q[first] - q[second]) > 0.1 * np.ptp(q) if len(q) > 1 else np.zeros(0, bool)
    if not apart.any():
        return float(p[7 + leg]), float(p[5 + leg])
    ratio = np.median(wrap(angle[first] - angle[second])[apart] / (q[first] - q[second])[apart])
    return float(ratio), float(np.angle(np.sum(np.exp(1j * (angle - ratio * q)))))


def _turned(task):
    """Starts with the free offsets all over a turn, each with its own frame."""
    turns = np.arange(0, 2 * np.pi, np.pi / 4)
    grids = [turns if f"offset{leg}" in task.names else [0.0] for leg in (1, 2)]
    return _all_framed(
        task, 5, [(one, other) for one in grids[0] for other in grids[1] if one or other]
    )


def _counted(task):
    """Starts in which readings are counts of usual encoders, where ratios are free and angles would
    be absurd.
    """
    wide = wide_legs(task)
    return (
        _all_framed(task, 7, [np.where(wide, 2 * np.pi / turn, 1.0) - 1 for turn in USUAL])
        if wide.any()
        else []
    )


def wide_legs(task: Task, free: bool = True) -> np.ndarray:
    """Which legs (2,) have readings that no motor turns through, and a ratio that is free (or
    not).
    """
    return np.array(
        [
            np.ptp(task.rows.q[:, leg]) > MUCH and (f"ratio{leg + 1}" in task.names) == free
            for leg in (0, 1)
        ]
    )


def _all_framed(task, first_place, pairs):
    """The start with each pair added to two of its values, with the frames that fit."""
    tried = []
    for pair in pairs:
        start = task.start.copy()
        start[first_place : first_place + 2] += pair
        tried += [start, *_framed(task, start)]
    return tried


def _framed(task, start):
    """A start with the frames, as far as they are free, that lay the robot's points on the measured
    ones: first in the modes noted, or else in either assembly mode, then each in the one that is
        nearer.
    """
    free = set(task.names)
    if not free & {"x0", "y0", "turn", "scale"}:
        return []
    rows, noted = task.rows, noted_assembly(start, task.rows)
    found = []
    for side in (-1, 1):
        p = _laid(rows, start.copy(), free, np.where(noted, noted, side))
        for _ in range(LAID):
            p = _laid(rows, p, free, _nearer(rows, p))
        found.append(p)
    return found


def _nearer(rows, p):
    """The assembly mode (n,) in which the robot is nearer to each measured point."""
    off = []
    for side in (-1, 1):
        gap = frame(p, place(p, rows.q, np.full(len(rows), side)).xi) - rows.points
        off.append(np.nan_to_num(np.hypot(*gap.T), nan=np.inf))
    return np.where(off[0] <= off[1], -1, 1)


def _laid(rows, p, free, mode):
    xi = place(p, rows.q, mode).xi
    z, m = xi[0] + 1j * xi[1], rows.points[:, 0] + 1j * rows.points[:, 1]
    good = np.isfinite(z) & np.isfinite(m)
    if good.sum() < 2:
        return p
    z, m = z[good], m[good]
    if free >= {"x0", "y0"}:
        around = z - z.mean()
        if "turn" in free and np.abs(around).max() > 0:
            slope = np.vdot(around, m - m.mean()) / np.vdot(around, around)
            p[PLACE["turn"]] = np.angle(slope)
            if "scale" in free:
                p[PLACE["scale"]] = abs(slope) or 1.0
        rest = m - p[12] * np.exp(1j * p[11]) * z
        p[9], p[10] = np.median(rest.real), np.median(rest.imag)
    elif free >= {"turn"}:
        p[PLACE["turn"]] = np.angle(np.vdot(z, m - p[9] - 1j * p[10]))
    return p


def _shifted(task):
    """Where one coordinate alone is measured: the start with that of the frame moved to the
    measured ones' middle.
    """
    p, rows = task.start.copy(), task.rows
    points = seen(p, rows.q, np.where(noted_assembly(p, rows), noted_assembly(p, rows), -1), False)[
        0
    ]
    for axis, name in ((0, "x0"), (1, "y0")):
        gap = (rows.points - points)[:, axis]
        if name in task.names and np.isfinite(gap).any():
            p[PLACE[name]] += np.nanmedian(gap)
    return p
