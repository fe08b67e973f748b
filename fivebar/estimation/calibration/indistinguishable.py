"""What data cannot tell apart: the null space of the Jacobian in its plainest vectors, in words,
with a remedy.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from .measured_robot import LENGTHS, PLACE, UNITS, place, seen, slopes

SMALL = 1e-6  # of a null vector's largest entry: none
LARGEST = (
    5  # unknowns in a vector that is looked for; a plainer basis than these is not worth the search
)
HARDLY = 0.1  # of an unknown's size: known less well than that, it is hardly known
STEP = {"m": (1e-3, "mm"), "rad": (np.pi / 180, "deg")}
MODES = [(left, right, assembly) for assembly in (-1, 1) for left in (-1, 1) for right in (-1, 1)]


def plainest(null: np.ndarray) -> np.ndarray:
    """Basis (k, n) of the space of the rows of `null` (k, n), with the fewest entries; the largest
    of each is 1.
    """
    count, n = null.shape
    found: list[np.ndarray] = []
    for size in range(1, min(LARGEST, n - count + 1) + 1):
        for chosen in combinations(range(n), size):
            if len(found) == count:
                return np.array(found)
            rest = np.delete(null, chosen, axis=1)
            left, s, _ = np.linalg.svd(rest)
            s = np.concatenate([s, np.zeros(count - len(s))])
            if s[-1] > SMALL:
                continue
            vector = left[:, -1] @ null
            vector = np.where(np.abs(vector) > SMALL * np.abs(vector).max(), vector, 0.0)
            if np.linalg.matrix_rank(np.array([*found, vector]), tol=SMALL) > len(found):
                found.append(vector / vector[np.argmax(np.abs(vector))])
    for vector in _echelon(null):
        if len(found) < count and np.linalg.matrix_rank(
            np.array([*found, vector]), tol=SMALL
        ) > len(found):
            found.append(vector / vector[np.argmax(np.abs(vector))])
    return np.array(found)


def _echelon(null):
    """Reduced rows: each has an unknown of its own."""
    rows = null.copy()
    for k in range(len(rows)):
        column = int(np.argmax(np.abs(rows[k])))
        rows[k] /= rows[k, column]
        others = np.arange(len(rows)) != k
        rows[others] -= np.outer(rows[others, column], rows[k])
    return np.where(np.abs(rows) > SMALL, rows, 0.0)


def combination(vector: np.ndarray, names: Sequence[str], sizes: np.ndarray, p: np.ndarray) -> str:
    """A null vector (in units of the sizes) in words: what of its unknowns the data do tell."""
    used = [k for k in range(len(names)) if vector[k]]
    named = listed([names[k] for k in used])
    if len(used) == 1:
        return f"{named} not at all: no measurement depends on it"
    steps = {names[k]: vector[k] * sizes[k] for k in used}
    lengths = [name for name in steps if name in (*LENGTHS, "x0", "y0")]
    values = {name: p[PLACE[name]] for name in steps}
    if "scale" in steps and len(lengths) == len(steps) - 1 and all(values.values()):
        shares = np.array([steps[name] / values[name] for name in lengths])
        if (
            np.ptp(shares) < 1e-5 * np.abs(shares).max()
            and abs(shares[0] + steps["scale"] / values["scale"]) < 1e-5
        ):
            return f"{named} only by the products of scale and {listed(lengths)}"
    if len(used) == 2:
        (a, step_a), (b, step_b) = steps.items()
        if UNITS.get(a) == UNITS.get(b):
            ratio = step_b / step_a
            if abs(abs(ratio) - 1) < 1e-5:
                what, sign = ("difference", "-") if ratio > 0 else ("sum", "+")
                return f"{a} and {b} only by their {what}, {a} {sign} {b}"
            return f"{a} and {b} only by {b} {'-' if ratio > 0 else '+'} {abs(ratio):.3g} {a}"
    largest = max(steps, key=lambda name: abs(vector[names.index(name)]))
    unit = STEP.get(UNITS.get(largest, ""), (1.0, ""))[0]
    factor = (unit if UNITS.get(largest) else 0.01) / steps[largest]
    changes = [_change(name, factor * step) for name, step in steps.items()]
    return f"{named} only together: nothing measured changes if {listed(changes)}"


def _change(name, step):
    scale, unit = STEP.get(UNITS.get(name, ""), (1.0, ""))
    return (
        f"{name} {'grows' if step > 0 else 'falls'} by {abs(step) / scale:.3g}{unit and ' '}{unit}"
    )


def listed(words) -> str:
    """a, b and c."""
    words = list(words)
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def hardly_told(
    sd: np.ndarray, vectors: np.ndarray, names: Sequence[str], sds: dict[str, float]
) -> tuple[str, ...]:
    """Combinations (k, n) whose standard deviation (k,), in sizes, is so large that they are hardly
    known, in words.
    """
    found = []
    for vector in vectors[sd > HARDLY]:
        vector = np.where(np.abs(vector) > 0.25 * np.abs(vector).max(), vector, 0.0)
        own = [name for name, entry in zip(names, vector) if entry]
        largest = names[int(np.argmax(np.abs(vector)))]
        scale, unit = STEP.get(UNITS.get(largest, ""), (1.0, ""))
        together = "together " if len(own) > 1 else ""
        found.append(
            f"{listed(own)} {together}hardly: {largest} to +-{sds[largest] / scale:.2g} {unit}".rstrip()
        )
    return tuple(found)


class Remedies:
    """Measurements that nobody made, each with its Jacobian by the unknowns, the easiest first."""

    def __init__(
        self,
        p: np.ndarray,
        q: np.ndarray,
        assembly: np.ndarray,
        axes: set,
        columns: np.ndarray,
        sizes,
    ):
        self.p, self.columns, self.sizes = p, columns, sizes
        self._used, self._axes = self._modes(q, assembly), axes
        self._near = _poses(p, np.random.default_rng(1))

    def _modes(self, q, assembly):
        signs = (-np.sign(sine) for sine in place(self.p, q, assembly).sines)
        return {
            tuple(int(m) for m in row)
            for row in np.nan_to_num(np.stack([*signs, assembly], axis=-1))
        }

    def for_vector(self, vector: np.ndarray, names: Sequence[str]) -> str:
        """The first of them that sees the vector, as an advice; else which unknown to measure by
        itself.
        """
        step = vector * self.sizes
        for words, jacobian in self._all():
            if (
                len(jacobian)
                and np.abs(jacobian @ step).max() > 1e-4 * np.abs(jacobian * self.sizes).max()
            ):
                return words
        one = [name for name, entry in zip(names, vector) if entry]
        return (
            f"no measurement of this kind can; measure {' or '.join(one)} by itself, and leave it"
            " out of unknown"
        )

    def _all(self):
        q, assembly, modes = self._near
        used = np.array([mode in self._used for mode in modes]) if len(modes) else np.zeros(0, bool)
        _, slope = seen(self.p, q, assembly)
        slope = slope[:, :, self.columns]
        for axis in (0, 1):
            if axis in self._axes:
                yield "poses in other places of the same modes would tell", slope[used, axis]
        for axis, name in enumerate("xy"):
            if self._axes and axis not in self._axes:
                yield f"measuring {name}, too, would tell", slope[used, axis]
        for mode in MODES:
            if mode not in self._used and self._axes:
                own = np.array([each == mode for each in modes], bool)
                words = (
                    "poses in working modes ({:+d}, {:+d}), assembly {:+d}, too, would tell".format(
                        *mode
                    )
                )
                yield words, slope[own].reshape(-1, len(self.columns))
        at = place(self.p, q, assembly)
        inner = slopes(self.p, q, at)
        gaps = np.stack(at.xi, axis=-1)
        gaps, slope_gap = gaps - np.roll(gaps, 1, axis=0), inner - np.roll(inner, 1, axis=0)
        length = np.hypot(*gaps.T)[:, None]
        ruler = np.einsum("ni,nij->nj", gaps / np.where(length, length, 1.0), slope_gap)[
            :, self.columns
        ]
        yield (
            "a distance between two of its points by a ruler (columns distance, to) would tell",
            ruler,
        )
        if not self._axes:
            yield (
                "points x, y in a measuring frame would tell",
                slope.reshape(-1, len(self.columns)),
            )


def _poses(p, rng):
    """Poses all over the workspace in all modes, well off singularities: readings, assembly modes,
    all three modes.
    """
    theta = rng.uniform(-np.pi, np.pi, (1500, 2))
    readings = (theta - p[5:7]) / np.where(p[7:9], p[7:9], 1.0)
    kept = []
    for side in (-1, 1):
        at = place(p, readings, np.full(len(theta), side))
        with np.errstate(invalid="ignore"):
            good = (np.abs([*at.sines, at.det]) > 0.2).all(axis=0)
        signs = -np.sign(at.sines)
        for k in np.flatnonzero(good)[:250]:
            kept.append((readings[k], side, (*map(int, signs[:, k]), side)))
    if not kept:
        return np.zeros((0, 2)), np.zeros(0, int), []
    own, sides, modes = zip(*kept)
    return np.array(own), np.array(sides), list(modes)
