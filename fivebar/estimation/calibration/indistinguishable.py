"""What data cannot tell apart: the null space of the Jacobian, in words, with a remedy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy import ndarray

from .candidates import MODES, candidates
from .measured_robot import FRAMES, OFFSETS, PLACE, RATIOS, UNITS, UNKNOWNS, seen, shown_in

if TYPE_CHECKING:
    from .result import Calibration

OFF = 0.2  # sine of singularities that remedies keep
SMALL = 1e-6  # of a null vector's largest entry: taken for 0


def plainest(null: ndarray) -> ndarray:
    """Return the reduced basis (k, n) of the rows of `null` (k, n), the fewest entries first.

    Each vector has an unknown of its own, and its largest entry is 1.
    """
    rows = null.copy()
    for k in range(len(rows)):
        pivot = int(np.argmax(np.abs(rows[k])))
        rows[k] /= rows[k, pivot]
        others = np.arange(len(rows)) != k
        rows[others] -= np.outer(rows[others, pivot], rows[k])
    largest = np.abs(rows).max(axis=1, keepdims=True)
    rows[np.abs(rows) < SMALL * largest] = 0.0
    rows /= np.take_along_axis(rows, np.abs(rows).argmax(axis=1)[:, None], axis=1)
    entries = rows != 0
    return rows[np.lexsort((entries.argmax(axis=1), entries.sum(axis=1)))]


def combination(vector: ndarray, names: Sequence[str], sizes: ndarray) -> str:
    """Return in words what of its unknowns the data do tell; the vector is in units of sizes."""
    steps = {}
    for name, share, size in zip(names, vector, sizes):
        if share:
            steps[name] = share * size
    named = listed(steps)
    if len(steps) == 1:
        return f"{named} not at all: no measurement depends on it"
    largest = names[int(np.argmax(np.abs(vector)))]
    unit = 1 / shown_in(largest)[0] if largest in UNITS else 0.01
    changes = [_change(name, unit / steps[largest] * step) for name, step in steps.items()]
    return f"{named} only together: nothing measured changes if {listed(changes)}"


def _change(name, step):
    factor, unit = shown_in(name)
    verb = "grows" if step > 0 else "falls"
    return f"{name} {verb} by {factor * abs(step):.3g} {unit}".rstrip()


def listed(words) -> str:
    """Return a, b and c."""
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last


def remedy(found: Calibration, vector: ndarray) -> str:
    """Return the easiest measurement that would tell a null vector, or which unknown to measure.

    Each measurement is tried: its derivatives along the vector must not be 0.
    """
    step = vector * found.sizes
    for words, jacobian in _remedies(found):
        if not len(jacobian):
            continue
        jacobian = jacobian[:, found.free]
        if np.abs(jacobian @ step).max() > 1e-4 * np.abs(jacobian * found.sizes).max():
            return words
    names = " or ".join(name for name, entry in zip(found.unknown, vector) if entry)
    return (
        f"no measurement of this kind can; measure {names} by itself, and leave it out of unknown"
    )


def _remedies(found):
    """Yield measurements that nobody made, with their derivatives, the easiest first."""
    axes = set(found.rows.measured[1].tolist())
    pose = candidates(found.robot, OFF, MODES, None)
    ratios = found.p[RATIOS]
    q = (pose.q - found.p[OFFSETS]) / np.where(ratios, ratios, 1.0)
    modes = np.column_stack([pose.working, pose.assembly])
    noted = np.column_stack([found.working, found.assembly])
    same_modes = (modes[:, None] == noted[None]).all(axis=2).any(axis=1)
    slopes = seen(found.p, q, modes[:, 2])[1]
    for axis in axes:
        yield ("poses in other places of the same modes would tell", slopes[same_modes, axis])
    for axis in {0, 1} - axes if axes else ():
        yield (f"measuring {'xy'[axis]}, too, would tell", slopes[same_modes, axis])
    if axes:
        yield ("poses in other modes, too, would tell", slopes.reshape(-1, len(UNKNOWNS)))
    own = found.p.copy()
    own[FRAMES] = 0.0, 0.0, 0.0, 1.0  # a ruler knows no frame
    points, by_robot = seen(own, q, modes[:, 2])
    by_robot[:, :, PLACE["scale"]] = 0.0
    gaps = points - np.roll(points, 1, axis=0)
    along = gaps / np.hypot(*gaps.T)[:, None]
    ruler = np.einsum("ni,nij->nj", along, by_robot - np.roll(by_robot, 1, axis=0))
    yield (
        "a distance between two of its points by a ruler (columns distance, to) would tell",
        ruler,
    )
    if not axes:
        yield ("points x, y in a measuring frame would tell", slopes.reshape(-1, len(UNKNOWNS)))
