"""`calibrate`: a robot's lengths, readings and measuring frame from what was measured on it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from ...base.backend import real_numbers, wrap
from ...base.checks import (
    LONGEST,
    SHORTEST,
    instance,
    number,
    one_of,
    optional,
    positive,
    shown,
    strings,
    takes,
    two_numbers,
)
from ...base.tables import FilePath
from ...models.robots import FiveBar
from .fit import LOSSES, Task, misses, modes_found, solve
from .measured_robot import PLACE, UNKNOWNS, length_ok, sizes, values_of
from .mistakes import lone_rows
from .mistakes import mistakes as found_mistakes
from .result import Calibration
from .rows import rows_of
from .starts import begin

DEFAULT = ("l11", "l12", "l21", "l22", "d", "offset1", "offset2")


@takes(
    robot=instance(FiveBar),
    unknown=strings,
    sigma=optional(positive),
    loss=one_of(*LOSSES),
    mistakes=one_of("raise", "mend", "keep"),
)
def calibrate(
    robot: FiveBar,
    data: Mapping | FilePath,
    unknown: Sequence[str] = DEFAULT,
    *,
    start: Mapping[str, float] = MappingProxyType({}),
    sigma: float | None = None,
    weights: Sequence | None = None,
    bounds: Mapping[str, Sequence[float]] = MappingProxyType({}),
    loss: str = "linear",
    mistakes: str = "raise",
    units: Mapping[str, str] | Sequence[str] = MappingProxyType({}),
) -> Calibration:
    """Calibration of a five-bar: the unknowns of least squares, how well they are known, and what
    cannot be told.

        true angle = ratio q + offset        measured point = (x0, y0) + scale R(turn) xi
        distance = |xi - xi_to|

    robot: nominal, where the search begins. data: a mapping of arrays (n,) or a CSV file, with q1,
        q2 (rad, or counts if ratio1 and ratio2 are there) and what was measured: x, y (m; a row may
        lack one of them), and/or `distance` (m, by a ruler) from the row's point to that of the row
        whose number, counted from 1, is in `to`. Modes are found from the points; working1,
        working2 or assembly, where they are noted, are checked, and needed where nothing else
        tells. sigma: a column too. Headings of a file may name a unit, x (mm), q1_deg.
    unknown: of l11, l12, l21, l22, d, offset1, offset2, ratio1, ratio2, x0, y0, turn, scale.
    start: values of these by name, known or to begin with; without, offsets are 0, ratios and scale
        1.
    sigma: standard deviation of one measured number, m; with it chi^2 says whether the model fits
        at all. weights: (n,) of the rows, relative. bounds: {name: (low, high)}. loss: of
        scipy.optimize.least_squares, "linear" or a robust one. units: of columns whose heading has
        none, {"q1": "deg"} or ("deg", "mm").
    mistakes: a mistake found in data (degrees, mm, swapped columns, a row's modes ...) is an error
        that names all of them ("raise"), is put right ("mend"; `said` tells), or is not looked for
        ("keep").

    ValueError names what is wrong. Gauss-Newton, derivatives in closed form from A d xi = B dq +
    ... (AMORO eq. 13).
    """
    unknown = known_names(unknown)
    p0 = start_values(robot, start)
    rows = rows_of(data, units, weights=None if weights is None else _weights(weights))
    free = np.array([PLACE[name] for name in unknown])
    size = sizes(robot, rows.q, unknown)
    own = rows.sigma[rows.row_of]
    relative = weights is not None
    given = (
        sigma
        if sigma is not None
        else (1.0 if np.isfinite(rows.sigma).any() and not relative else None)
    )
    weight = _weight(own, sigma, relative, rows)
    task = Task(rows, free, p0, size, weight, _bounds(bounds, unknown), loss)
    typical = 0.0 if given is None else float(np.median(1 / weight))
    if mistakes == "keep":
        wrong, p = [], begin(task)
    else:
        wrong, task, p = found_mistakes(task, typical)
    if wrong and (mistakes == "raise" or any(mistake.mend is None for mistake in wrong)):
        raise ValueError(_all(wrong, lone_rows(task, p), data))
    if not length_ok(p):
        p = task.start.copy()
    assembly, unsure = modes_found(p, task.rows)
    needed = np.zeros(len(task.rows), bool)
    needed[task.rows.row_of] = True
    needed[task.rows.to[task.rows.to >= 0]] = True
    if (needed & (assembly == 0)).any():
        k = int(np.argmax(needed & (assembly == 0)))
        raise ValueError(
            f"{task.rows.where[k]}: its modes are not noted, and no point of it is measured that"
            " would tell them: add columns assembly, or working1 and working2"
        )
    assembly = np.where(assembly == 0, -1, assembly)
    p = _reaching(task, p, assembly)
    task, p, held = _within(task, p, assembly)
    turns = np.intersect1d(free, [PLACE[name] for name in ("offset1", "offset2", "turn")])
    p[turns] = p0[turns] + wrap(p[turns] - p0[turns])  # whole turns mean nothing
    notes = [*task.rows.notes, *(f"put right: {mistake}" for mistake in wrong), *lone_rows(task, p)]
    if unsure[needed].any():
        names = ", ".join(np.array(task.rows.where)[unsure & needed])
        notes.append(
            f"assembly mode uncertain, both fit almost alike, the nearer one was taken: {names}"
        )
    return Calibration(
        robot,
        unknown,
        task.rows,
        assembly,
        p0,
        p,
        weight,
        given is not None,
        loss,
        held,
        tuple(notes),
        dict(task.bounds or {}),
    )


def known_names(unknown: Sequence[str], name: str = "unknown") -> tuple[str, ...]:
    """Names of UNKNOWNS, each once; ValueError for others."""
    found = tuple(unknown)
    if not found:
        raise ValueError(f"{name} is empty: name some of {', '.join(UNKNOWNS)}")
    if wrong := [each for each in found if each not in UNKNOWNS]:
        raise ValueError(
            f"{name}: no {', '.join(map(shown, wrong))}; the known ones are {', '.join(UNKNOWNS)}"
        )
    if len(set(found)) < len(found):
        raise ValueError(
            f"{name} names {next(each for each in found if found.count(each) > 1)} twice"
        )
    return found


def start_values(robot: FiveBar, start: Mapping[str, float]) -> np.ndarray:
    """All UNKNOWNS (13,) of a robot with `start` over them; ValueError for names and values that
    none has.
    """
    if not isinstance(start, Mapping):
        raise TypeError(f"start must be a mapping {{name: value}}, not {shown(start)}")
    if wrong := [each for each in start if each not in UNKNOWNS]:
        raise ValueError(
            f"start: no {', '.join(map(shown, wrong))}; the known ones are {', '.join(UNKNOWNS)}"
        )
    values = values_of(
        robot, {name: number(value, f"start[{name!r}]", -1e6, 1e6) for name, value in start.items()}
    )
    if not length_ok(values):
        raise ValueError(
            f"start: bars and scale must be from {SHORTEST:g} to {LONGEST:g}, and d from 0 on"
        )
    return values


def _weights(weights):
    found = real_numbers(weights, "weights")
    if found.ndim != 1 or not (np.isfinite(found) & (found > 0)).all():
        raise ValueError(f"weights must be numbers > 0, one for each row, not {shown(weights)}")
    return found


def _weight(own, sigma, relative, rows):
    """1 / sigma of each measured number; where a row says nothing of its own, the common one."""
    if relative:
        return 1 / own if sigma is None else 1 / (own * sigma)
    known = np.isfinite(own)
    if sigma is None and known.any() and not known.all():
        raise ValueError(
            f"{rows.where[rows.row_of[np.argmin(known)]]}: no sigma, where other rows have one"
        )
    return 1 / np.where(known, own, 1.0 if sigma is None else sigma)


def _bounds(bounds, unknown):
    if not isinstance(bounds, Mapping):
        raise TypeError(f"bounds must be a mapping {{name: (low, high)}}, not {shown(bounds)}")
    found = {}
    for name, limits in bounds.items():
        if name not in unknown:
            raise ValueError(f"bounds: {shown(name)} is none of unknown: {', '.join(unknown)}")
        low, high = two_numbers(limits, f"bounds[{name!r}]")
        if not low < high:
            raise ValueError(
                f"bounds[{name!r}] must be (low, high) with low < high, not {shown(limits)}"
            )
        found[name] = (low, high)
    return found


def _all(wrong, lone, data):
    count = "a mistake" if len(wrong) == 1 else f"{len(wrong)} mistakes"
    where = f" in {os.fspath(data)}" if isinstance(data, (str, os.PathLike)) else " in data"
    listed = "; ".join([*map(str, wrong), *lone])
    how = "Put that right"
    if all(mistake.mend for mistake in wrong):
        how += " (mistakes='mend', on the command line --mend, does)"
    return f"{count}{where}: {listed}. {how}, or take the data as they are ('keep', --keep)"


def _reaching(task, p, assembly):
    """Values from which every row is reached, p or what a fit of the reached rows gives; ValueError
    naming a row.
    """
    for _ in range(3):
        off = misses(p, task.rows, assembly, derive=False)[0]
        out = np.zeros(len(task.rows), bool)
        out[task.rows.row_of[~np.isfinite(off)]] = True
        if not out.any():
            return p
        near = task.rows.without(out)
        if len(near.numbers) < len(task.free):
            break
        kept = np.isfinite(off)
        p = solve(task.with_rows(near, task.weight[kept]), p, assembly[~out])[0]
    names = ", ".join(np.array(task.rows.where)[out][:5])
    raise ValueError(
        f"{names}: with these angles the robot that fits the other rows does not close: a wrong"
        " reading?"
    )


def _within(task, p, assembly):
    """`solve`, and again with bounds where no robot can have the lengths that came out."""
    p_free, held = solve(task, p, assembly)
    if length_ok(p_free):
        return task, p_free, held
    limits = {name: (1e-6, np.inf) for name in task.names if name[0] == "l" or name == "scale"}
    limits |= {"d": (0.0, np.inf)} if "d" in task.names else {}
    asked = task.bounds or {}
    bounds = {name: _narrower(limits.get(name), asked.get(name)) for name in {*limits, *asked}}
    task = replace(task, bounds=bounds)
    for start in (p, task.start):
        if (
            length_ok(start)
            and np.isfinite(misses(start, task.rows, assembly, derive=False)[0]).all()
        ):
            return task, *solve(task, start, assembly)
    raise ValueError(
        "no five-bar fits these data: lengths below 0 come out, and within bounds there is none to"
        " begin with"
    )


def _narrower(one, other):
    pairs = [pair for pair in (one, other) if pair is not None]
    return max(pair[0] for pair in pairs), min(pair[1] for pair in pairs)
