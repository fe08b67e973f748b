"""Limits of a motion along a path: rows a(s) u + b(s) x + v(s) sqrt(x) + c(s) <= 0.

Here x = s'^2 and u = s''.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from itertools import product
from typing import NamedTuple

import numpy as np

from ...constraints.constraints import Constraints, at_joints
from .bounds import Bernstein

DIRECTIONS = 16  # in which an acceleration is limited first
NEAR = (0.0, 0.01, -0.01, 0.04, -0.04, 0.15, -0.15)  # rad, beside the direction that it had last
PARTS = "a", "b", "v", "c"
ONE = np.array([1.0, 1.0, 1.0, 0.0, 0.0])[:, None]  # in Bernstein form


@dataclass(frozen=True)
class Limits:
    """The limits on torques and rates among constraints, SI, None where there is none.

    stall, no_load: torques at rest and speeds without load of the motors' lines, at the joints.
    """

    torque: tuple[float, float] | None = None
    joint_speed: tuple[float, float] | None = None
    joint_acceleration: tuple[float, float] | None = None
    speed: float | None = None
    acceleration: float | None = None
    jerk: float | None = None
    stall: tuple[float, float] | None = None
    no_load: tuple[float, float] | None = None

    @classmethod
    def of(cls, constraints: Constraints) -> Limits:
        """Return the limits on torques and rates among the constraints."""
        lines = at_joints(constraints.motors) if constraints.motors else (None, None)
        names = [field.name for field in fields(cls)][: -len(lines)]
        return cls(*(getattr(constraints, name) for name in names), *lines)

    @property
    def forces(self) -> bool:
        """Return whether any limit bounds the change of speed."""
        return any((self.torque, self.joint_acceleration, self.acceleration))

    def times(self, share: float, speeds: bool = False) -> Limits:
        """Return limits with those on torque and acceleration, or on speeds, times a share."""
        names: tuple[str, ...] = "torque", "stall", "joint_acceleration", "acceleration"
        if speeds:
            names = "joint_speed", "speed", "no_load"
        return replace(self, **{name: _scaled(getattr(self, name), share) for name in names})


def _scaled(limit, share):
    if limit is None:
        return None
    if isinstance(limit, tuple):
        return tuple(value * share for value in limit)
    return limit * share


class ConstraintRows(NamedTuple):
    """Rows on n stretches.

    parts: {a, b, v, c: (3, rows, n)}, Bernstein coefficients. bend, slack: {a, b, v, c: (rows, n)},
    by which each may differ (`bounds.Bernstein`). kind (rows,): "torque", "joint" or "tip" for an
    acceleration, "speed" for rows of x alone.
    """

    parts: dict
    bend: dict
    slack: dict
    kind: np.ndarray

    def turned(self, back: np.ndarray) -> ConstraintRows:
        """Return the rows with the stretches `back` (n,) run backwards: u changes its sign."""
        parts = {}
        for name, values in self.parts.items():
            sign = -1.0 if name == "a" else 1.0
            parts[name] = np.where(back, values[::-1] * sign, values)
        return self._replace(parts=parts)


def rows_of(
    found: dict[str, Bernstein],
    limits: Limits,
    side: np.ndarray,
    turns: np.ndarray,
    directions: np.ndarray,
    speed: np.ndarray,
    inside: bool,
) -> ConstraintRows:
    """Return the rows of these limits on n stretches.

    side: the sign of det A (n,). turns (2, n): of both joints' derivatives by s. directions (d, n):
    rad from the path's, increasing, in which the acceleration is limited. Of the circle that it may
    fill these are the tangents, or (inside) the chords from one to the next. speed (n,): of the
    end-effector, inf where it is free.
    """
    n = len(side)
    rows: list[tuple[dict, str]] = []  # (row, kind)
    minus_one: list[tuple] = [(-1.0, ONE)]
    for k, sign in product((0, 1), (1.0, -1.0)):
        joint = k + 1
        for limit in (limits.torque, limits.stall):
            if limit is None:
                continue
            share = sign * side / limit[k]
            row = {}
            for part in PARTS:
                if f"{part}{joint}" in found:
                    row[part] = [(share, found[f"{part}{joint}"])]
            row["c"] = [*row.get("c", ()), (-side, found["D"])]
            if f"f{joint}" in found:
                # Where a joint may turn round, friction helps or hinders: the worse of both counts
                # inside, the better one outside.
                either = (1.0 if inside else -1.0) * np.abs(share) * side
                friction = np.where(turns[k], share * turns[k], either)
                row["c"].append((friction, found[f"f{joint}"]))
            if limits.no_load is not None and limit is limits.stall:
                # tau / stall + q' / no_load <= 1, times det A.
                line = sign * side / limits.no_load[k]
                row["v"] = [*row.get("v", ()), (line, found[f"d{joint}"])]
            rows.append((row, "torque"))
        if limits.joint_acceleration is not None:
            share = sign / limits.joint_acceleration[k]
            by_u: list[tuple] = [(share, found[f"q{joint}"])]
            by_x: list[tuple] = [(share, found[f"p{joint}"])]
            rows.append(({"a": by_u, "b": by_x, "c": minus_one}, "joint"))
    if limits.acceleration is not None:
        half = np.diff(directions, axis=0, append=directions[:1] + 2 * np.pi) / 2 * inside
        for angle, opening in zip(directions + half, half):
            along = np.cos(angle) / limits.acceleration
            across = np.sin(angle) / limits.acceleration
            by_u = [(along, found["g"])]
            by_x = [(along, found["m"]), (across, found["k"])]
            rows.append(({"a": by_u, "b": by_x, "c": [(-np.cos(opening), ONE)]}, "tip"))
        for sign in (1.0, -1.0):
            share = sign / limits.acceleration
            rows.append(({"b": [(share, found["k"])], "c": minus_one}, "speed"))
    if limits.joint_speed is not None:
        for k in (0, 1):
            share = limits.joint_speed[k] ** -2
            rows.append(({"b": [(share, found[f"w{k + 1}"])], "c": minus_one}, "speed"))
    if np.isfinite(speed).any():
        rows.append(({"b": [(speed**-2.0, found["w0"])], "c": minus_one}, "speed"))
    return _stacked(rows, n)


def _stacked(rows, n):
    tables = {name: np.zeros((5, len(rows), n)) for name in PARTS}
    for r, (row, _) in enumerate(rows):
        for part, terms in row.items():
            for share, value in terms:
                value = np.asarray(value)
                tables[part][:3, r] += share * value[:3]
                tables[part][3:, r] += np.abs(share) * value[3:]
    parts, bend, slack = (
        {name: table[at] for name, table in tables.items()} for at in (slice(3), 3, 4)
    )
    return ConstraintRows(parts, bend, slack, np.array([kind for _, kind in rows]))
