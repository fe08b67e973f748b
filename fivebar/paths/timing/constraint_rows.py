"""Limits of a motion along a path, on stretches: rows a(s) u + b(s) x + v(s) sqrt(x) + c(s) <= 0, x
= s'^2, u = s''.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np

from ...constraints.constraints import Constraints
from .bounds import Bernstein

DIRECTIONS = 16  # in which an acceleration is limited first
NEAR = 0.0, 0.01, -0.01, 0.04, -0.04, 0.15, -0.15  # rad, beside the direction that it had last
PARTS = "a", "b", "v", "c"


@dataclass(frozen=True)
class Limits:
    """What a motion keeps, SI; None: no limit.

    torque, joint_speed, joint_acceleration: one number per joint; speed, acceleration, jerk: of the
        end-effector.
    """

    torque: tuple[float, float] | None = None
    joint_speed: tuple[float, float] | None = None
    joint_acceleration: tuple[float, float] | None = None
    speed: float | None = None
    acceleration: float | None = None
    jerk: float | None = None

    @classmethod
    def of(cls, constraints: Constraints) -> Limits:
        """Return the limits on torques and rates among the constraints."""
        return cls(**{field.name: getattr(constraints, field.name) for field in fields(cls)})

    @property
    def forces(self) -> bool:
        """Whether anything keeps the motion from changing its speed at once."""
        return not self.torque is self.joint_acceleration is self.acceleration is None

    def times(self, share: float, speeds: bool = False) -> Limits:
        """These limits, those on torque and acceleration (speeds: the others alone) times a
        share.
        """
        names = (
            ("joint_speed", "speed") if speeds else ("torque", "joint_acceleration", "acceleration")
        )
        return replace(self, **{name: _scaled(getattr(self, name), share) for name in names})


def _scaled(value, share):
    return (
        value
        if value is None
        else tuple(v * share for v in value)
        if isinstance(value, tuple)
        else value * share
    )


class Rows(NamedTuple):
    """Rows on n stretches. parts: {a, b, v, c: (3, rows, n)}, Bernstein coefficients; bend, slack:
    {a, b, v, c: (rows, n)}, by which each may differ (`bounds.Bernstein`). torque: (rows,) whether
    a row is one of a torque.
    """

    parts: dict
    bend: dict
    slack: dict
    torque: np.ndarray

    def taken(self, at: np.ndarray) -> Rows:
        """Of some stretches."""

        def pick(table):
            return {name: value[..., at] for name, value in table.items()}

        return Rows(pick(self.parts), pick(self.bend), pick(self.slack), self.torque)


def rows_of(
    found: dict[str, Bernstein],
    limits: Limits,
    side: np.ndarray,
    turns: np.ndarray,
    directions: np.ndarray,
    speed: np.ndarray,
    inside: bool,
) -> tuple[Rows, Rows]:
    """(rows with u, rows of x alone) on n stretches.

    side: the sign of det A (n,); turns: of both joints' derivatives by s (2, n); directions: rad
    (d, n) from the path's, increasing, in which the acceleration is limited: of the circle that it
    may fill the tangents there, or (inside) the chords from one to the next; speed: of the
    end-effector (n,), inf where it is free.
    """
    n, rows, alone = len(side), [], []
    for k, sign in ((k, sign) for k in (0, 1) for sign in (1.0, -1.0)):
        if limits.torque is not None:
            share = sign * side / limits.torque[k]
            row = {
                part: [(share, found[f"{part}{k + 1}"])]
                for part in PARTS
                if f"{part}{k + 1}" in found
            }
            row["c"] = [*row.get("c", ()), (-side, found["D"])]
            if f"f{k + 1}" in found:
                # Where a joint may turn round, friction either helps nor hinders: as it is worse
                # here, or better.
                either = (1.0 if inside else -1.0) * np.abs(share) * side
                row["c"].append((np.where(turns[k], share * turns[k], either), found[f"f{k + 1}"]))
            rows.append((row, True))
        if limits.joint_acceleration is not None:
            share = np.full(n, sign / limits.joint_acceleration[k])
            rows.append(
                (
                    {
                        "a": [(share, found[f"q{k + 1}"])],
                        "b": [(share, found[f"p{k + 1}"])],
                        "c": [(-1.0, None)],
                    },
                    False,
                )
            )
    if limits.acceleration is not None:
        half = np.diff(directions, axis=0, append=directions[:1] + 2 * np.pi) / 2 * inside
        for angle, opening in zip(directions + half, half):
            along, across = np.cos(angle) / limits.acceleration, np.sin(angle) / limits.acceleration
            curved = [(along, found["m"]), (across, found["k"])]
            rows.append(
                ({"a": [(along, found["g"])], "b": curved, "c": [(-np.cos(opening), None)]}, False)
            )
        for sign in (1.0, -1.0):
            alone.append(
                (
                    {
                        "b": [(np.full(n, sign / limits.acceleration), found["k"])],
                        "c": [(-1.0, None)],
                    },
                    False,
                )
            )
    if limits.joint_speed is not None:
        for k in (0, 1):
            alone.append(
                (
                    {
                        "b": [(np.full(n, limits.joint_speed[k] ** -2), found[f"w{k + 1}"])],
                        "c": [(-1.0, None)],
                    },
                    False,
                )
            )
    if np.isfinite(speed).any():
        alone.append(({"b": [(speed**-2.0, found["w0"])], "c": [(-1.0, None)]}, False))
    return _stacked(rows, n), _stacked(alone, n)


def _stacked(rows, n):
    parts, bend, slack = (
        {name: np.zeros(shape) for name in PARTS}
        for shape in ((3, len(rows), n), *2 * [(len(rows), n)])
    )
    for r, (row, _) in enumerate(rows):
        for part, terms in row.items():
            for share, value in terms:
                if value is None:
                    parts[part][:, r] += share
                    continue
                for at, each in enumerate((value.first, value.middle, value.last)):
                    parts[part][at, r] += share * each
                bend[part][r] += np.abs(share) * value.bend
                slack[part][r] += np.abs(share) * value.slack
    return Rows(parts, bend, slack, np.array([torque for _, torque in rows], dtype=bool))
