"""What a robot is designed for: the table it works on, its motor, its tolerances, the motion it is
to do.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..base.checks import (
    a_callable,
    modes,
    not_negative,
    number,
    positive,
    share,
    shown,
    two_numbers,
    whole,
)
from ..base.representation import one_line
from ..paths.curve import Path
from ..paths.reading.read import path
from .batch import alone

MOST_POSES = 10**6
SAMPLES = 201  # of a motion


class Motor(NamedTuple):
    """torque N m and speed rad/s that both motors have, and where the numbers come from."""

    torque: float
    speed: float
    source: str = ""


class Motion(NamedTuple):
    """A trajectory's samples, which other processes can be sent: xi, xi', xi'' (SAMPLES, 2), SI;
    duration s.
    """

    duration: float
    xi: np.ndarray
    xi_dot: np.ndarray
    xi_ddot: np.ndarray


MOTORS = {
    "xh430-w350": Motor(
        3.4, np.pi, "ROBOTIS e-Manual: stall torque 3.4 N m, no-load speed 30 rev/min, both at 12 V"
    ),
}


@dataclass(frozen=True)
class Task:
    """What figures of merit are about; what is not given is None, and figures that need it say so.

    table: (width, height) m about the task's own origin, or (x_min, x_max, y_min, y_max).
    disc: radius in m about the origin, or (x, y, radius); in place of a table.
    poses: (columns, rows) of nodes on the table, its borders among them; on a disc (radii, angles).
    working: modes of the legs, (1, -1): elbows outside above the base, as Liu's.
    motor: the name of one of MOTORS, or (torque N m, speed rad/s).
    motion: a trajectory, t -> (xi, xi', xi''), with .start and .duration, about the task's own
        origin.
    path: a Path, or what `fb.path` reads, about the task's own origin.
    tolerances: {"q": rad of each motor, "l": m of each bar, "d": m of the base}, each of them +-.
    stiffness: of each motor, N m/rad.
    det_A, sin: that a dexterous region keeps; margin: m that discs and rectangles keep.
    """

    table: tuple | None = None
    disc: tuple | None = None
    poses: tuple[int, int] = (31, 31)
    working: tuple[int, int] = (1, -1)
    motor: Motor | None = None
    motion: Motion | None = None
    path: Path | None = None
    tolerances: Mapping[str, float] | None = None
    stiffness: float | None = None
    det_A: float = 0.0
    sin: float = 0.0
    margin: float = 0.0
    _given: tuple = field(default=(), repr=False)

    def __repr__(self) -> str:
        return one_line("Task", *(f"{name} = {_told(value)}" for name, value in self.about.items()))

    @cached_property
    def nodes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points (p, 2) m about the task's origin, and their shares of the area and of the plain
        polar mean, (p,).
        """
        m, n = self.poses
        if self.table:
            x0, x1, y0, y1 = self.table
            x, y = (np.linspace(*ends, count) for *ends, count in ((x0, x1, m), (y0, y1, n)))
            points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
            weights = np.outer(_trapezium(n), _trapezium(m)).ravel()
            return points, weights, np.full(len(points), np.nan)
        cx, cy, radius = self.disc
        rho, phi = radius * np.linspace(0, 1, m), 2 * np.pi * np.arange(n) / n
        points = np.stack(
            [cx + np.outer(np.cos(phi), rho), cy + np.outer(np.sin(phi), rho)], axis=-1
        ).reshape(-1, 2)
        plain = np.outer(np.full(n, 1 / n), _trapezium(m))
        weighed = plain * rho
        return points, (weighed / weighed.sum()).ravel(), plain.ravel()

    @property
    def about(self) -> dict:
        """What was given, as JSON says it; of a motion its duration and a hash of its samples."""
        found = {}
        for name in self._given:
            value = getattr(self, name)
            if name == "motion":
                digest = hashlib.sha256(np.array(value[1:]).tobytes())
                value = {"duration": value.duration, "sha256": digest.hexdigest()}
            elif name == "path":
                points = value(value.length * np.linspace(0, 1, SAMPLES))[0]
                value = {
                    "length": value.length,
                    "sha256": hashlib.sha256(points.tobytes()).hexdigest(),
                }
            elif isinstance(value, Motor):
                value = {"torque": value.torque, "speed": value.speed}
            found[name] = value
        return json.loads(json.dumps(found))


def _told(value):
    if isinstance(value, dict):
        return f"({', '.join(f'{name} {_told(each)}' for name, each in value.items())})"
    if isinstance(value, list):
        return f"({', '.join(map(_told, value))})"
    return f"{value:.6g}" if isinstance(value, float) else shown(value)


def _trapezium(count):
    weights = np.ones(count)
    weights[[0, -1]] = 0.5
    return weights / weights.sum()


CHOICES = tuple(f.name for f in fields(Task) if f.name[0] != "_")


def task_of(choices: Mapping[str, object]) -> Task:
    """The Task of these keyword arguments; TypeError for one that is none, ValueError for what
    cannot be.
    """
    if unknown := [name for name in choices if name not in CHOICES]:
        raise TypeError(f"no choice {', '.join(unknown)}; the known ones are {', '.join(CHOICES)}")
    given = {name: value for name, value in choices.items() if value is not None}
    found = {name: _RULES[name](value, name) for name, value in given.items()}
    if "table" in found and "disc" in found:
        raise ValueError("give a table or a disc, not both")
    task = Task(**found, _given=tuple(sorted(found)))
    if task.poses[0] * task.poses[1] > MOST_POSES:
        raise ValueError(
            f"poses: at most {MOST_POSES:g} nodes, not {task.poses[0]} x {task.poses[1]}"
        )
    return task


def _numbers(value, name, counts):
    try:
        found = [number(each, name) for each in value]
    except TypeError:
        found = []
    if len(found) not in counts:
        raise ValueError(
            f"{name} must be {' or '.join(map(str, counts))} numbers, not {shown(value)}"
        )
    return found


def _table(value, name):
    found = _numbers(value, name, (2, 4))
    if len(found) == 2:
        width, height = (positive(each, name) for each in found)
        return -width / 2, width / 2, -height / 2, height / 2
    if not (found[0] < found[1] and found[2] < found[3]):
        raise ValueError(f"{name} = (x_min, x_max, y_min, y_max) must rise, not {shown(value)}")
    return tuple(found)


def _disc(value, name):
    x, y, radius = (0.0, 0.0, value) if alone(value) else _numbers(value, name, (3,))
    return x, y, positive(radius, name)


def _poses(value, name):
    try:
        pair = (value, value) if alone(value) else tuple(value)
    except TypeError:
        pair = ()
    if len(pair) != 2:
        raise ValueError(f"{name} must be two whole numbers, not {shown(value)}")
    return tuple(whole(2, 10**4)(each, name) for each in pair)


def _motor(value, name):
    if isinstance(value, str):
        if value not in MOTORS:
            raise ValueError(
                f"{name}: no motor {value!r}; the known ones are {', '.join(MOTORS)}, or (torque,"
                " speed)"
            )
        return MOTORS[value]
    torque, speed = two_numbers(value[:2] if isinstance(value, Motor) else value, name)
    return Motor(positive(torque, f"{name}'s torque"), positive(speed, f"{name}'s speed"))


def _motion(value, name):
    if isinstance(value, Motion):
        return value
    a_callable(value, name)
    if not (hasattr(value, "start") and hasattr(value, "duration")):
        raise ValueError(
            f"{name} must be a trajectory with a start and a duration, not {shown(value)}"
        )
    start, duration = (
        number(value.start, f"{name}'s start"),
        positive(value.duration, f"{name}'s duration"),
    )
    try:
        parts = [
            np.array(part, dtype=float)
            for part in value(start + duration * np.linspace(0, 1, SAMPLES))
        ]
        if [part.shape for part in parts] != [(SAMPLES, 2)] * 3 or not np.isfinite(parts).all():
            raise ValueError(f"it gives {[part.shape for part in parts]}")
    except (ValueError, TypeError) as error:
        raise ValueError(
            f"{name}(t) must give xi, xi', xi'', finite and (n, 2) each, for times (n,) ({error})"
        ) from None
    return Motion(duration, *parts)


def _path(value, name):
    try:
        return value if isinstance(value, Path) else path(value)
    except (ValueError, TypeError) as error:
        kind = (
            TypeError if isinstance(error, TypeError) else ValueError
        )  # one of letters has more to be made of
        raise kind(f"{name}: {error}") from None


def _tolerances(value, name):
    if not isinstance(value, Mapping) or not value or set(value) - {"q", "l", "d"}:
        raise ValueError(
            f'{name} must be a table of "q" (rad), "l" and "d" (m), not {shown(value)}'
        )
    return {key: not_negative(each, f"{name}[{key}]") for key, each in value.items()}


_RULES = {
    "table": _table,
    "disc": _disc,
    "poses": _poses,
    "working": modes(2),
    "motor": _motor,
    "motion": _motion,
    "path": _path,
    "tolerances": _tolerances,
    "stiffness": positive,
    "det_A": share,
    "sin": share,
    "margin": not_negative,
}
