"""A log of a robot on a table: its rows as they are, cleaned of what is no row, cut where time does
not go on.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...base.backend import finite_numbers
from ...base.checks import number, positive, shown, two_numbers
from ...base.columns import read
from ...base.tables import TextFile, named
from ...models.robots import Robot
from .columns import order, since_1970, wanted

LATE = 1.5  # sampling periods from row to row: from there on rows are missing
UNEVEN = 0.01  # of a period, by which times may be off an even grid
PAIRS = {  # of columns
    "q": ("q1", "q2"),
    "tau": ("tau1", "tau2"),
    "q_dot": ("q1_dot", "q2_dot"),
    "q_ddot": ("q1_ddot", "q2_ddot"),
    "xi": ("x", "y"),
    "xi_ref": ("x_ref", "y_ref"),
}


class Cut(NamedTuple):
    """Between rows `row` - 1 and `row` time does not go on: start, end s; why, in words."""

    row: int
    start: float
    end: float
    why: str
    missing: int  # rows; 0 where time jumps back


@dataclass(frozen=True, eq=False)
class Log:
    """t (n,) s, increasing; q, tau, q_dot, q_ddot, xi, xi_ref (n, 2), SI, at the joints, None where
    not logged; step: s, the sampling period; cuts; said: what was done to the rows, as sentences.
    """

    t: np.ndarray
    q: np.ndarray
    tau: np.ndarray | None
    q_dot: np.ndarray | None
    q_ddot: np.ndarray | None
    xi: np.ndarray | None
    xi_ref: np.ndarray | None
    step: float
    cuts: tuple[Cut, ...]
    notes: tuple[str, ...]

    @property
    def stretches(self) -> list[slice]:
        """The rows between the cuts."""
        edges = [0, *(cut.row for cut in self.cuts), len(self.t)]
        return [slice(a, b) for a, b in zip(edges, edges[1:]) if b > a]


class Gauges(NamedTuple):
    """How columns become coordinates at the joints: `Run.from_log`."""

    counts_per_turn: Any = None
    gear_ratio: Any = 1.0
    offset: Any = (0.0, 0.0)
    torque_constant: Any = None


AT_THE_JOINTS = Gauges()


def read_log(
    source: TextFile | Mapping,
    robot: Robot,
    units: Mapping[str, str] | None = None,
    gauges: Gauges = AT_THE_JOINTS,
) -> Log:
    """The Log in a CSV file or a mapping of arrays with the columns of `wanted`: t, q1, q2, ..."""
    if units is not None and not (
        isinstance(units, Mapping)
        and all(isinstance(each, str) for pair in units.items() for each in pair)
    ):
        raise TypeError(f"units must be a dict {{name: unit}}, not {shown(units)}")
    if isinstance(source, Mapping):
        values, notes, name, lines = _arrays(source, robot, units or {}), (), "the log", None
    elif isinstance(source, (str, os.PathLike)) or hasattr(source, "read"):
        found = read(source, wanted(robot), units or {})
        values, notes, name, lines = found.values, list(found.notes), found.name, found.lines
        values["t"] = since_1970(values["t"], "t" in found.stated, notes)
    else:
        raise TypeError(
            "a log is a Run, a CSV file or a mapping of arrays t, q1, q2, tau1, tau2, not"
            f" {shown(source)}"
        )
    values["t"] = values["t"] + values.pop("t_ns", 0.0)
    with named(name):
        pairs = {name: _pair(values, *columns) for name, columns in PAIRS.items()}
        return _cleaned(values["t"], _gauged(pairs, gauges, robot), robot, notes, name, lines)


def _pair(values, left, right):
    if left not in values and right not in values:
        return None
    if left not in values or right not in values:
        there, missing = (left, right) if left in values else (right, left)
        raise ValueError(f"the log has {there}, but no {missing}")
    return np.stack([values[left], values[right]], axis=1)


def _arrays(source, robot, units):
    """{name: (n,)} of a mapping; q (n, 2) stands for q1 and q2, and so on."""
    values, known = {}, wanted(robot)
    aliases = {name: key for key, quantity in known.items() for name in (key, *quantity.names)}
    for name, given in source.items():
        if given is None:
            continue
        try:
            array = np.array(given, dtype=float)
        except (TypeError, ValueError, OverflowError):
            raise ValueError(f"{name} must be numbers, not {shown(given)}") from None
        if name in PAIRS:
            if array.ndim != 2 or array.shape[1] != 2:
                raise ValueError(f"{name} must have shape (n, 2), not {array.shape}")
            values |= zip(PAIRS[name], array.T)
        elif name in aliases:
            if array.ndim != 1:
                raise ValueError(f"{name} must have shape (n,), not {array.shape}")
            values[aliases[name]] = array
        else:
            raise ValueError(f"no column {name!r}; the known ones are {', '.join(known)}")
    for name, unit in units.items():
        if name not in known or unit not in known[name].units:
            of = ", ".join(known[name].units) if name in known else ", ".join(known)
            raise ValueError(f"units: {name}={unit}: known are {of}")
        if name in values:
            values[name] = values[name] * known[name].units[unit]
    for name in ("t", "q1", "q2"):
        if name not in values:
            raise ValueError(f"the log has no {name}")
    for name, array in values.items():
        if len(array) != len(values["t"]):
            raise ValueError(f"{name} has {len(array)} rows, and t {len(values['t'])}")
        finite_numbers(np.where(np.isfinite(array), array, 0.0), name)
    return values


def _both(value, name):
    """(left, right) of a number for both motors, or of two."""
    several = isinstance(value, (tuple, list)) or (isinstance(value, np.ndarray) and value.ndim)
    return two_numbers(value, name) if several else (number(value, name),) * 2


def _gauged(pairs, gauges, robot):
    """The pairs at the joints."""
    counts, ratio, offset, constant = gauges
    ratio = np.array(_both(ratio, "gear_ratio"))
    if (np.abs(ratio) < 1e-9).any():  # so much that angles would overflow
        raise ValueError(f"gear_ratio must not be 0, but is {ratio.tolist()}")
    scale = 1 / ratio
    if counts is not None:
        counts = np.array(
            [positive(abs(each), "counts_per_turn") for each in _both(counts, "counts_per_turn")]
        )
        scale = scale * (2 * np.pi if robot.turns else 1.0) / counts
    found = {
        name: pairs[name] * scale for name in ("q", "q_dot", "q_ddot") if pairs[name] is not None
    }
    found["q"] += np.array(_both(offset, "offset"))
    if pairs["tau"] is not None and constant is not None:
        found["tau"] = pairs["tau"] * np.array(_both(constant, "torque_constant")) * ratio
    return pairs | found


def _cleaned(t, pairs, robot, notes, name, lines):
    notes, n = list(notes), len(t)
    if n < 2:
        raise ValueError(f"{name} has {n} rows: a motion needs more")

    def at(row):
        return f"row {row}" if lines is None else f"line {lines[row]}"

    empty = ~np.isfinite(t)
    if empty.any():
        notes.append(
            f"{empty.sum()} rows without a time were left out, the first"
            f" {at(int(np.argmax(empty)))}"
        )
    lost = ~empty & ~np.isfinite(pairs["q"]).all(axis=1)
    if lost.any():
        notes.append(
            f"{lost.sum()} rows without both joints' positions were left out, the first"
            f" {at(int(np.argmax(lost)))}"
        )
    for key in ("q_dot", "q_ddot"):  # as some drivers fill what they do not know
        if (
            pairs[key] is not None
            and not np.nan_to_num(pairs[key]).any()
            and np.ptp(pairs["q"][~lost], axis=0).any()
        ):
            notes.append(
                f"{' and '.join(PAIRS[key])} are 0 throughout, though the joints move: not used"
            )
            pairs = pairs | {key: None}
    rows = np.flatnonzero(~empty & ~lost)
    if len(rows) < 2:
        raise ValueError(
            f"{name} has {len(rows)} rows with a time and both joints: a motion needs more"
        )
    if (rank := order(t[rows])) is not None:
        late = int(np.sum(np.diff(t[rows]) < 0))
        notes.append(
            f"{late} rows come later than rows of later times: all are put in the order of their"
            " times"
        )
        rows = rows[rank]
    again = np.concatenate([[False], np.diff(t[rows]) == 0])
    if again.any():
        notes.append(
            f"{again.sum()} rows repeat the time of the row before and were left out, the first "
            f"{at(rows[np.argmax(again)])}"
        )
        rows = rows[~again]
    t, pairs = (
        t[rows].copy(),
        {key: None if pair is None else pair[rows] for key, pair in pairs.items()},
    )
    forward = np.diff(t)[np.diff(t) > 0]
    if not len(forward):
        raise ValueError(f"{name}: its times never increase")
    step = float(np.median(forward))
    if (far := np.abs(t) > 2.0**53 * step).any():  # no digit of it is left for a step
        k = int(np.argmax(far))
        raise ValueError(
            f"{name}, {at(rows[k])}: t = {t[k]:.6g} s is no time of a log with rows every"
            f" {step:.6g} s"
        )
    cuts = _cuts(t, step, rows, at, notes)
    if robot.turns:
        _unwrap(pairs["q"], rows, at, notes)
    return Log(t, **pairs, step=step, cuts=tuple(cuts), notes=tuple(notes))


def _cuts(t, step, rows, at, notes):
    """Where rows are missing, or time begins again: then the times after it are moved on."""
    cuts = []
    for k in np.flatnonzero((np.diff(t) < 0) | (np.diff(t) > LATE * step)) + 1:
        if t[k] < t[k - 1]:
            shift = t[k - 1] + 2 * step - t[k]
            why = f"time jumps back from {t[k - 1]:.6g} to {t[k]:.6g} s at {at(rows[k])}"
            notes.append(f"{why}: taken for a restart, {shift:.6g} s are added from there on")
            t[k:] += shift
            lack = 0
        else:
            lack = max(round((t[k] - t[k - 1]) / step) - 1, 1)
            why = f"{lack} row{'s' * (lack > 1)} missing before {at(rows[k])}"
        cuts.append(Cut(int(k), float(t[k - 1]), float(t[k]), why, lack))
    gaps = [cut for cut in cuts if cut.missing]
    if gaps:
        where = ", ".join(f"{cut.start:.6g} to {cut.end:.6g} s" for cut in gaps[:3])
        notes.append(
            f"{len(gaps)} gaps in time are not bridged:"
            f" {where}{' and more' if len(gaps) > 3 else ''}"
        )
    return cuts


def _unwrap(q, rows, at, notes):
    """Take the jumps of an angle that was kept within a turn out of it, in place; over gaps too, as
    whole turns are the same pose.
    """
    jumps = np.abs(np.diff(q, axis=0)) > np.pi
    if jumps.any():
        k = int(np.argmax(jumps.any(axis=1))) + 1
        first = f"the first at {at(rows[k])}"
        notes.append(
            f"q jumps by more than half a turn {jumps.sum()} times, {first}: taken for whole turns"
        )
        q[:] = np.unwrap(q, axis=0)


def evenly(
    t: np.ndarray, pairs: Mapping[str, np.ndarray], step: float
) -> tuple[np.ndarray, dict, float]:
    """(times, pairs, largest distance of the times from an even grid in periods), of a stretch on
    an even grid.

    Where its times are off it, positions and the like by cubic splines through them, torques (tau,
    ...) linearly; nan where they were not logged.
    """
    n = int(round((t[-1] - t[0]) / step)) + 1
    even = np.linspace(t[0], t[-1], n)
    own = (t[-1] - t[0]) / max(n - 1, 1)
    place = (t - t[0]) / max(own, 1e-300)
    away = float(np.abs(place - np.round(place)).max())
    if (n == len(t) and away <= UNEVEN) or len(t) < 4:
        return (even, dict(pairs), away) if n == len(t) else (t, dict(pairs), away)
    before = np.clip(np.searchsorted(t, even, side="right") - 1, 0, len(t) - 2)
    lost = np.diff(t)[before] > LATE * step
    moved = {}
    for name, pair in pairs.items():
        if name.startswith("tau") or not np.isfinite(pair).all():
            moved[name] = np.stack([np.interp(even, t, column) for column in pair.T], axis=1)
        else:
            from scipy.interpolate import CubicSpline  # only where a log asks for it

            moved[name] = CubicSpline(t, pair)(even)
        if name.startswith("tau"):
            moved[name][lost] = np.nan
    return even, moved, away
