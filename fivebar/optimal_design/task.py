"""The task of a design: table, motor, tolerances, and the motion that the robot does."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, fields
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
from ..base.tables import named
from ..models.motors import Motor, motor_of
from ..paths.curve import DEVIATION, Path
from ..paths.reading.read import path
from .batch import is_number

SAMPLES = 201  # of a motion


class TaskMotion(NamedTuple):
    """Samples of a trajectory, which can be sent to other processes: xi, xi', xi'' (SAMPLES, 2)."""

    duration: float  # s
    xi: np.ndarray
    xi_dot: np.ndarray
    xi_ddot: np.ndarray


@dataclass(frozen=True)
class Task:
    """What figures of merit are about; a figure names what it needs of these.

    Parameters
    ----------
    table : tuple
        (width, height) m about the task's own origin, or (x_min, x_max, y_min, y_max).
    disc : float or tuple
        Radius, m, about the origin, or (x, y, radius); in place of a table.
    poses : tuple of int
        (columns, rows) of nodes on the table, its borders among them; on a disc (radii, angles).
    working : tuple of int
        Modes of the legs; (1, -1): elbows outside above the base, as Liu's.
    motor : str or tuple
        Both motors: a Motor, the name of one of MOTORS, or (stall torque N m, speed without load
        rad/s).
    motion : trajectory
        t -> (xi, xi', xi''), with .start and .duration, about the task's own origin.
    path : Path
        Or what `fb.path` reads, with its corners rounded as by `draw`, within 0.02 mm; about the
        task's own origin.
    tolerances : mapping
        {"q": rad of each motor, "l": m of each bar, "d": m of the base}, each of them +-.
    stiffness : float
        Of each motor, N m/rad.
    det_A, sin : float
        That a dexterous region keeps.
    margin : float
        That discs and rectangles keep, m.
    """

    table: tuple | None = None
    disc: tuple | None = None
    poses: tuple[int, int] = (31, 31)
    working: tuple[int, int] = (1, -1)
    motor: Motor | None = None
    motion: TaskMotion | None = None
    path: Path | None = None
    tolerances: Mapping[str, float] | None = None
    stiffness: float | None = None
    det_A: float = 0.0
    sin: float = 0.0
    margin: float = 0.0
    _given: tuple = field(default=(), repr=False)

    def __repr__(self) -> str:
        return one_line(
            "Task", *(f"{name} = {_short(value)}" for name, value in self.about.items())
        )

    @cached_property
    def nodes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points (p, 2) m about the origin, weights of the mean over the area, and over the disc.

        The second weights, (p,), are of the mean over radius and angle; nan on a table.
        """
        m, n = self.poses
        if self.table:
            x0, x1, y0, y1 = self.table
            grid = np.meshgrid(np.linspace(x0, x1, m), np.linspace(y0, y1, n))
            weights = np.outer(_trapezium(n), _trapezium(m)).ravel()
            return np.stack(grid, axis=-1).reshape(-1, 2), weights, np.full(m * n, np.nan)
        assert self.disc is not None
        cx, cy, radius = self.disc
        rho = radius * np.linspace(0, 1, m)
        phi = 2 * np.pi * np.arange(n) / n
        x = cx + np.outer(np.cos(phi), rho)
        y = cy + np.outer(np.sin(phi), rho)
        polar = np.outer(np.full(n, 1 / n), _trapezium(m))
        area = polar * rho
        points = np.stack([x, y], axis=-1).reshape(-1, 2)
        return points, (area / area.sum()).ravel(), polar.ravel()

    @property
    def about(self) -> dict:
        """What was given, as JSON; of a motion or path its length and a hash of its samples."""
        about = {}
        for name in self._given:
            value = getattr(self, name)
            if name == "motion":
                value = {"duration": value.duration, "sha256": _sha256(np.array(value[1:]))}
            elif name == "path":
                points = value(value.length * np.linspace(0, 1, SAMPLES))[0]
                value = {"length": value.length, "sha256": _sha256(points)}
            elif name == "motor":
                value = asdict(value)
            about[name] = value
        return json.loads(json.dumps(about))


def _sha256(array):
    return hashlib.sha256(array.tobytes()).hexdigest()


def _short(value):
    if isinstance(value, dict):
        return f"({', '.join(f'{name} {_short(part)}' for name, part in value.items() if part)})"
    if isinstance(value, list):
        return f"({', '.join(map(_short, value))})"
    if isinstance(value, float):
        return f"{value:.6g}"
    return shown(value)


def _trapezium(count):
    weights = np.ones(count)
    weights[[0, -1]] = 0.5
    return weights / weights.sum()


CHOICES = tuple(f.name for f in fields(Task) if f.name[0] != "_")


def task_of(choices: Mapping[str, object]) -> Task:
    """Return the Task of keyword arguments; TypeError for an unknown one, else ValueError."""
    if unknown := [name for name in choices if name not in CHOICES]:
        raise TypeError(f"no choice {', '.join(unknown)}; the known ones are {', '.join(CHOICES)}")
    values = {k: _RULES[k](value, k) for k, value in choices.items() if value is not None}
    if "table" in values and "disc" in values:
        raise ValueError("give a table or a disc, not both")
    task = Task(**values, _given=tuple(sorted(values)))
    if task.poses[0] * task.poses[1] > 10**6:
        raise ValueError(f"poses: at most 10^6 nodes, not {task.poses[0]} x {task.poses[1]}")
    return task


def _items(value, name, counts):
    """Return the items of a sequence, which must be so many."""
    items = list(value) if np.iterable(value) else []
    if len(items) not in counts:
        known = " or ".join(map(str, counts))
        raise ValueError(f"{name} must be {known} numbers, not {shown(value)}")
    return items


def _table(value, name):
    ends = [number(end, name) for end in _items(value, name, (2, 4))]
    if len(ends) == 2:
        width, height = (positive(side, name) for side in ends)
        return -width / 2, width / 2, -height / 2, height / 2
    if not (ends[0] < ends[1] and ends[2] < ends[3]):
        raise ValueError(f"{name} = (x_min, x_max, y_min, y_max) must rise, not {shown(value)}")
    return tuple(ends)


def _disc(value, name):
    x, y, radius = (0.0, 0.0, value) if is_number(value) else _items(value, name, (3,))
    return (number(x, name), number(y, name), positive(radius, name))


def _poses(value, name):
    pair = (value, value) if is_number(value) else _items(value, name, (2,))
    return tuple(whole(2, 10**4)(count, name) for count in pair)


def _motor(value, name):
    if isinstance(value, Motor | str | Mapping):
        return motor_of(value, name)
    with named(name):
        return Motor(*two_numbers(value, name))


def _motion(value, name):
    if isinstance(value, TaskMotion):
        return value
    a_callable(value, name)
    if not (hasattr(value, "start") and hasattr(value, "duration")):
        raise ValueError(
            f"{name} must be a trajectory with a start and a duration, not {shown(value)}"
        )
    start = number(value.start, f"{name}'s start")
    duration = positive(value.duration, f"{name}'s duration")
    try:
        samples = value(start + duration * np.linspace(0, 1, SAMPLES))
        parts = [np.array(part, dtype=float) for part in samples]
    except (ValueError, TypeError) as error:
        raise ValueError(f"{name}(t) must give xi, xi', xi'' for times (n,) ({error})") from None
    shapes = [part.shape for part in parts]
    if shapes != [(SAMPLES, 2)] * 3 or not np.isfinite(parts).all():
        raise ValueError(f"{name}(t) must give xi, xi', xi'', finite and (n, 2), not {shapes}")
    return TaskMotion(duration, *parts)


def _path(value, name):
    try:
        return value if isinstance(value, Path) else path(value, deviation=DEVIATION)
    except ValueError as error:  # A UnicodeError takes more arguments than a message.
        raise ValueError(f"{name}: {error}") from None


def _tolerances(value, name):
    if not isinstance(value, Mapping) or not value or set(value) - {"q", "l", "d"}:
        raise ValueError(
            f'{name} must be a table of "q" (rad), "l" and "d" (m), not {shown(value)}'
        )
    return {key: not_negative(size, f"{name}[{key}]") for key, size in value.items()}


_RULES: dict[str, Callable] = {
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
