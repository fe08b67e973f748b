"""Read a log of a robot: clean its rows, and cut it where rows are missing or time jumps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy import ndarray
from scipy.interpolate import CubicSpline
from scipy.ndimage import median_filter

from ...base.checks import number, two_numbers
from ...base.columns import Columns, read, refuse_unclear_times
from ...base.headings import TIME, Quantity, headings_by_name
from ...base.tables import TextFile, named
from ...base.units import (
    AMPERES,
    COUNTS,
    METRES,
    NEWTON_METRES,
    NEWTONS,
    RADIANS,
    RADIANS_PER_SECOND,
    SPEEDS,
)
from ...models.geometry import dgm
from ...models.robots import Robot
from ...simulation.bags import JOINTS, is_bag, read_bag

GAUGE_OF = {"counts": "counts_per_turn", "A": "torque_constant", "mA": "torque_constant"}
TURN = 2 * np.pi  # rad
LATE = 1.5  # sampling periods between two rows: from there on rows are missing
RESTART = 10  # sampling periods: where time steps back by less, rows are only out of order
SLOW = 0.2  # s: rows without a unit of time that are so far apart may be so many ms
UNEVEN = 0.01  # sampling periods by which times may be off an even grid
PAIRS = {
    "q": ("q1", "q2"),
    "tau": ("tau1", "tau2"),
    "q_dot": ("q1_dot", "q2_dot"),
    "xi": ("x", "y"),
    "xi_ref": ("x_ref", "y_ref"),
}


class Cut(NamedTuple):
    """A place in a log, before row `row`, where time does not go on.

    `start` and `end` are the times on both sides, s; `why` says it in words; `missing` is the
    number of missing rows, 0 where time jumps back.
    """

    row: int
    start: float
    end: float
    why: str
    missing: int


@dataclass(frozen=True, eq=False)
class Log:
    """A log in SI units at the joints.

    t (n,) s increases; q, tau, q_dot, xi, xi_ref are (n, 2), None where not logged; step is
    the sampling period, s; notes say what was done to the rows; is_stated: the units of torques
    are known, not assumed; is_held: each torque is held until the next, as a simulation does.
    """

    t: ndarray
    q: ndarray
    tau: ndarray | None
    q_dot: ndarray | None
    xi: ndarray | None
    xi_ref: ndarray | None
    step: float
    cuts: tuple[Cut, ...]
    notes: tuple[str, ...]
    is_stated: bool = True
    is_held: bool = False

    @property
    def stretches(self) -> list[slice]:
        """The rows between the cuts."""
        edges = [0, *(cut.row for cut in self.cuts), len(self.t)]
        return [slice(a, b) for a, b in zip(edges, edges[1:])]


class Gauges(NamedTuple):
    """How columns become coordinates at the joints: the parameters of `from_log`."""

    counts_per_turn: Any = None
    gear_ratio: Any = 1.0
    offset: Any = (0.0, 0.0)
    torque_constant: Any = None
    units: Any = None
    columns: Any = None


AT_THE_JOINTS = Gauges()


def wanted(robot: Robot, torques: bool = False) -> dict[str, Quantity]:
    """Return the columns of a log with the headings they may have, and whether they are needed."""
    angle, torque, rate = METRES, NEWTONS, SPEEDS
    if robot.turns:
        angle, torque, rate = RADIANS, NEWTON_METRES, RADIANS_PER_SECOND
    columns = {"t": TIME}
    for digit, joint in zip("12", robot.words.joints):
        names = joint, f"theta{digit}", f"position{digit}"
        columns[f"q{digit}"] = Quantity(names, angle | COUNTS)
        names = f"torque{digit}", f"effort{digit}"
        columns[f"tau{digit}"] = Quantity(names, torque | AMPERES, torques)
        columns[f"q{digit}_dot"] = Quantity((f"{joint}_dot", f"velocity{digit}"), rate, False)
    for name in (*PAIRS["xi"], *PAIRS["xi_ref"]):
        columns[name] = Quantity((), METRES, False)
    return columns


def read_log(
    source: TextFile | Mapping | Columns,
    robot: Robot,
    gauges: Gauges = AT_THE_JOINTS,
    torques: bool = False,
) -> Log:
    """Return the Log in a file, a bag, or a mapping of arrays with the columns of `wanted`.

    In a mapping, q (n, 2) may stand for q1 and q2, and so on. `torques`: a table needs them.
    """
    if isinstance(source, Mapping):
        source = _split_pairs(source)
    if is_bag(source):
        called = headings_by_name(gauges.columns, ("q1", "q2"))
        joints = [called.get(name, joint) for name, joint in zip(("q1", "q2"), JOINTS)]
        source = read_bag(source, robot, joints=joints)
    table = (
        source
        if isinstance(source, Columns)
        else read(source, wanted(robot, torques), gauges.units, "the log", gauges.columns)
    )
    refuse_unclear_times(table, SLOW)
    with named(table.name):
        pairs = {name: _pair(table.values, *columns) for name, columns in PAIRS.items()}
        pairs = _at_the_joints(pairs, gauges, robot, table.stated)
        if robot.turns and "q1" not in table.stated and gauges.counts_per_turn is None:
            _refuse_unclear_angles(pairs["q"], robot, table.row_word == "line")
        return _clean(table, pairs, robot)


def _refuse_unclear_angles(q, robot, is_file):
    """Ask for the unit where the loop closes at degrees only, or a file has several turns."""
    known = q[np.isfinite(q).all(axis=1)]
    known = known[:: max(len(known) // 500, 1)]
    largest = np.abs(known).max(initial=0.0)
    if not largest > (0.0 if is_file else TURN):
        return
    as_rad, as_deg = (
        100 * np.isfinite(dgm(robot, angles, unreachable="nan").xi).all(axis=1).mean()
        for angles in (known, np.radians(known))
    )
    if (as_deg > 99.9 and as_rad < 98.0) or (is_file and largest > 2 * TURN):
        advice = (
            ' say which, by units={"q1": "deg", "q2": "deg"} or --units deg, of counts by'
            " --counts-per-turn; or head them q1_deg. As rad, are they exchanged, or has one the"
            " wrong sign?"
        )
        raise ValueError(
            f"q1 and q2 have no unit and reach {largest:.4g}; {as_rad:.0f} % of the rows close the"
            f" loop of the bars as rad, {as_deg:.0f} % as deg:{advice}"
        )


def _split_pairs(arrays):
    columns = {}
    for name, array in arrays.items():
        if name not in PAIRS or array is None:
            columns[name] = array
        elif np.ndim(array) == 2 and np.shape(array)[1] == 2:
            columns |= zip(PAIRS[name], np.transpose(array))
        else:
            raise ValueError(f"{name} must have shape (n, 2), not {np.shape(array)}")
    return columns


def _pair(values, left, right):
    there = [name for name in (left, right) if name in values]
    if not there:
        return None
    if len(there) == 1:
        missing = right if there == [left] else left
        raise ValueError(f"the log has {there[0]}, but no {missing}")
    return np.stack([values[left], values[right]], axis=1)


def _for_both_motors(value, name):
    if isinstance(value, (tuple, list, ndarray)) and np.ndim(value):
        return np.array(two_numbers(value, name))
    return np.full(2, number(value, name))


def _not_0_for_both(value, name):
    pair = _for_both_motors(value, name)
    if (np.abs(pair) < 1e-9).any():  # beyond that, angles overflow
        raise ValueError(f"{name} must not be 0, but is {pair.tolist()}")
    return pair


def _at_the_joints(pairs, gauges, robot, stated):
    for name, unit in stated.items():
        gauge = GAUGE_OF.get(unit)
        if gauge and getattr(gauges, gauge) is None:
            option = gauge.replace("_", "-")
            raise ValueError(f"{name} is in {unit}: give {gauge}, on the command line --{option}")
    ratio = _not_0_for_both(gauges.gear_ratio, "gear_ratio")
    scale = 1 / ratio
    if gauges.counts_per_turn is not None:
        counts = _not_0_for_both(gauges.counts_per_turn, "counts_per_turn")
        scale = scale * (TURN if robot.turns else 1.0) / counts
    result = dict(pairs)
    for name in ("q", "q_dot"):
        if pairs[name] is not None:
            result[name] = pairs[name] * scale
    result["q"] += _for_both_motors(gauges.offset, "offset")
    if pairs["tau"] is not None and gauges.torque_constant is not None:
        constant = _for_both_motors(gauges.torque_constant, "torque_constant")
        result["tau"] = pairs["tau"] * constant * ratio
    return result


def _clean(table: Columns, pairs, robot):
    """Return the Log of the rows that have a time of their own and both joints."""
    t = table.values["t"]
    notes = list(table.notes)
    is_file = table.row_word == "line"
    unnamed = [name for name in table.values if is_file and name not in table.stated]
    if unnamed:
        notes.append(
            f"{', '.join(unnamed)}: no unit in the table, taken for SI units, or for counts with"
            " counts_per_turn"
        )
    rows = np.arange(len(t))
    rows = _leave_out(table, rows, ~np.isfinite(t), "rows without a time", notes)
    rows = _in_order(table, rows, t[rows], notes)
    placed = np.isfinite(pairs["q"]).all(axis=1)
    if pairs["tau"] is not None and placed[rows].sum() > 1:
        pairs["tau"] = _torques_of_rows(t, pairs["tau"], rows, placed, notes)
    why = "rows without both joints' positions"
    rows = _leave_out(table, rows, ~placed[rows], why, notes)
    again = np.diff(t[rows], prepend=np.nan) == 0
    rows = _leave_out(table, rows, again, "rows with the time of the row before", notes)
    if len(rows) < 2:
        raise ValueError(
            f"{table.name} has {len(rows)} rows with a time and both joints: a motion needs more"
        )
    steps = np.diff(t[rows])
    if not (steps > 0).any():
        raise ValueError(f"{table.name}: its times never increase")
    step = float(np.median(steps[steps > 0]))
    # Rounding of a clock that began in 1970 is in each step, and not in their mean.
    step = float(np.mean(steps[np.abs(steps - step) < step / 2]))
    rows = _leave_out_wrong(table, rows, pairs["q"], (steps < 0) | (steps > LATE * step), notes)
    t = t[rows].copy()
    pairs = {name: None if pair is None else pair[rows] for name, pair in pairs.items()}
    late = np.abs(t) > 2.0**53 * step  # no digit is left for a step
    if late.any():
        k = int(np.argmax(late))
        raise table.error(
            rows[k], f"t = {t[k]:.6g} s is no time of a log with rows every {step:.6g} s"
        )
    cuts = _cut(t, step, [table.where(row) for row in rows], notes)
    if robot.turns:
        jumps = (np.abs(np.diff(pairs["q"], axis=0)) > np.pi).any(axis=1)
        if jumps.any():
            notes.append(
                f"q jumps by more than half a turn {jumps.sum()} times, the first at"
                f" {table.where(rows[np.argmax(jumps) + 1])}: taken for whole turns"
            )
            pairs["q"] = np.unwrap(pairs["q"], axis=0)
    _check_rates(t, pairs, robot, notes)
    is_stated = not {"tau1", "tau2"} & set(unnamed)
    is_measured = '"measured": ' in table.comment and '"held": true' not in table.comment
    is_held = table.comment.startswith("fivebar run,") and not is_measured
    return Log(
        t,
        **pairs,
        step=step,
        cuts=tuple(cuts),
        notes=tuple(notes),
        is_stated=is_stated,
        is_held=is_held,
    )


def _check_rates(t, pairs, robot, notes):
    """Leave out rates that are all 0, which no driver filled; refuse those in another unit."""
    rates = pairs["q_dot"]
    if rates is None:
        return
    if not np.nan_to_num(rates).any():
        notes.append("the velocities are all 0: they are not used")
        pairs["q_dot"] = None
        return
    own = np.nan_to_num(rates)
    by_q = np.where(np.isfinite(rates), np.gradient(pairs["q"], t, axis=0), 0.0)
    factors = (own * by_q).sum(axis=0) / np.maximum((own**2).sum(axis=0), 1e-300)
    units = {**(RADIANS_PER_SECOND if robot.turns else SPEEDS), "": -1.0}
    si, *others = units
    for name, joint, factor in zip(PAIRS["q_dot"], PAIRS["q"], factors):
        for unit in others:
            if abs(factor / units[unit] - 1) < 0.1:
                question = f"is it in {unit}, not in {si}" if unit else "is its sign the other one"
                raise ValueError(
                    f"{name} is {1 / factor:.3g} times the rate of {joint}: {question}?"
                )


def off_their_neighbours(values: ndarray, least: float = 0.0) -> ndarray:
    """Return where (n,) up to 3 rows of positions or torques (n, 2) are off those on both sides.

    Their distance from the median of 7 rows is at most twice the largest second difference of a
    motion that is sampled well. The largest of these differences are left aside: a wrong row makes
    up to 6. None are off where more than 1 % would be, or by less than `least` of the range.
    """
    aside = 18 + len(values) // 200
    known = np.isfinite(values).all(axis=1)
    if known.sum() < 5 * aside:
        return np.zeros(len(values), dtype=bool)
    rows = np.arange(len(values))
    q = np.stack([np.interp(rows, rows[known], each[known]) for each in values.T], axis=1)
    limit = 5.0 * np.sort(np.abs(np.diff(q, 2, axis=0)), axis=0)[-aside]
    expected = median_filter(q, (7, 1), mode="nearest")
    limit = np.maximum(limit, least * np.ptp(expected, axis=0))
    off = (np.abs(q - expected) > limit).any(axis=1)
    for k in (0, 1):  # a wrong row moves the medians of those about it, too
        expected[:, k] = np.interp(rows, rows[~off], q[~off, k])
    off &= (np.abs(q - expected) > limit).any(axis=1)
    return off & known & (off.mean() <= 0.01)


def _leave_out(table, rows, out, what, notes):
    if out.any():
        first = table.where(rows[np.argmax(out)])
        notes.append(f"{out.sum()} {what} were left out, the first {first}")
    return rows[~out]


def _leave_out_wrong(table, rows, q, is_cut, notes):
    """Leave out rows with positions off their neighbours, between the cuts after rows."""
    stretches = np.split(rows, np.flatnonzero(is_cut) + 1)
    off = np.concatenate([off_their_neighbours(np.unwrap(q[part], axis=0)) for part in stretches])
    left, right = q[rows[np.argmax(off)]]
    what = f"rows with positions far off their neighbours (first {left:.4g} and {right:.4g})"
    return _leave_out(table, rows, off, what, notes)


def _in_order(table, rows, t, notes):
    """Return the rows in the order of their times, between restarts."""
    steps = np.diff(t)
    period = np.median(steps[steps > 0]) if (steps > 0).any() else 0.0
    starts = np.cumsum(np.diff(t, prepend=t[:1]) < -RESTART * period)
    order = np.lexsort((t, starts))
    moved = order != np.arange(len(t))
    if moved.any():
        first = table.where(rows[np.argmax(moved)])
        notes.append(f"{moved.sum()} rows were not in the order of time, the first {first}: sorted")
    return rows[order]


def _torques_of_rows(t, tau, rows, placed, notes):
    """Return the torques (n, 2), also in rows that are near to other rows with torques alone."""
    there = np.isfinite(tau[rows])
    alone = there.any(axis=1) & ~placed[rows]
    if alone.sum() > (there.all(axis=1) & placed[rows]).sum():
        steps = np.diff(t[rows], prepend=t[rows[0]])
        step = np.median(np.diff(t[rows][placed[rows]]))
        clock = np.cumsum(np.where(steps < 0, 2 * LATE * step, steps))  # restarts are far off
        tau = tau.copy()
        for column in tau.T:
            column[rows] = _near(clock, column[rows], clock, step)
        notes.append("torques are in other rows than positions: interpolated to rows near by")
    without = placed[rows] & ~np.isfinite(tau[rows]).all(axis=1)
    if without.any():
        notes.append(f"{without.sum()} of {placed[rows].sum()} rows with positions lack torques")
    return tau


def _near(t, column, at, step):
    """Return a column (n,) at times near to rows that have it, nan at others."""
    known = np.isfinite(column)
    if not known.any():
        return np.full(len(at), np.nan)
    own = t[known]
    nearest = own[np.rint(np.interp(at, own, np.arange(len(own)))).astype(int)]
    is_far = np.abs(at - nearest) > LATE / 2 * step
    return np.where(is_far, np.nan, np.interp(at, own, column[known]))


def _cut(t, step, where, notes):
    """Return the Cuts; where time jumps back, move the later times on, in place."""
    cuts = []
    restarts = []
    for k in np.flatnonzero((np.diff(t) < 0) | (np.diff(t) > LATE * step)) + 1:
        if t[k] < t[k - 1]:
            shift = t[k - 1] + 2 * step - t[k]
            why = f"time jumps back from {t[k - 1]:.6g} to {t[k]:.6g} s at {where[k]}"
            restarts.append(f"{why}: taken for a restart, {shift:.6g} s are added from there on")
            t[k:] += shift
            missing = 0
        else:
            missing = max(round((t[k] - t[k - 1]) / step) - 1, 1)
            why = f"{missing} rows missing before {where[k]}"
        cuts.append(Cut(int(k), float(t[k - 1]), float(t[k]), why, missing))
    if restarts:
        more = f"; so are {len(restarts) - 1} more jumps back" if restarts[1:] else ""
        notes.append(restarts[0] + more)
    gaps = [f"{cut.start:.10g} to {cut.end:.10g} s" for cut in cuts if cut.missing]
    if gaps:
        more = " and more" if len(gaps) > 3 else ""
        notes.append(f"{len(gaps)} gaps in time: {', '.join(gaps[:3])}{more}")
    return cuts


def evenly(t: ndarray, pairs: Mapping[str, ndarray], step: float) -> tuple[ndarray, dict, float]:
    """Return a stretch on an even grid of times.

    Where its times are off the grid, positions and their derivatives are interpolated by cubic
    splines, torques (names that begin with tau) linearly; torques are nan where rows are missing.

    Returns
    -------
    times, pairs, distance
        The distance is the largest of the times from the grid, in sampling periods.
    """
    n = int(round((t[-1] - t[0]) / step)) + 1
    even = np.linspace(t[0], t[-1], n)
    period = (t[-1] - t[0]) / max(n - 1, 1)
    place = (t - t[0]) / max(period, 1e-300)
    distance = float(np.abs(place - np.round(place)).max())
    if len(t) < 4 or (n == len(t) and distance <= UNEVEN):
        return (even if n == len(t) else t, dict(pairs), distance)
    before = np.minimum(np.searchsorted(t, even, side="right") - 1, len(t) - 2)
    lost = np.diff(t)[before] > LATE * step
    moved = {}
    for name, pair in pairs.items():
        if name.startswith("tau"):
            moved[name] = np.stack([_near(t, column, even, step) for column in pair.T], axis=1)
            moved[name][lost] = np.nan
        elif not np.isfinite(pair).all():
            moved[name] = np.stack([np.interp(even, t, column) for column in pair.T], axis=1)
        else:
            moved[name] = CubicSpline(t, pair)(even)
    return even, moved, distance
