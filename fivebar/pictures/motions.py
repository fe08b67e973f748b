"""What pictures ask of what they show: a run, several, a plan, a log; all of these are made in rooms above."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

if TYPE_CHECKING:
    from ..models.geometry import Pose
    from ..models.kinematics import Accelerations
    from ..models.robots import Robot


class Run(Protocol):
    """A simulated motion: t (n,) s; q, q_dot, xi, tau (n, 2); energy (n,) J; its reference and torque limit or None."""

    robot: Robot
    t: np.ndarray
    q: np.ndarray
    q_dot: np.ndarray
    xi: np.ndarray
    tau: np.ndarray
    energy: np.ndarray
    xi_ref: np.ndarray | None
    torque_limit: float | None
    measured: Any
    events: tuple
    error: np.ndarray
    q_error: np.ndarray
    saturated: np.ndarray


class Comparison(Protocol):
    """Runs and their figures by name."""

    runs: dict[str, Run]
    figures: dict[str, dict[str, float]]


class Plan(Protocol):
    """An optimal motion: its problem's limits and weights, the pieces of its polynomials, its share at the limit."""

    robot: Robot
    problem: object
    pieces: object
    saturated: float

    def accelerations(self, t: np.ndarray) -> Accelerations: ...


class TimedPath(Protocol):
    """A path and its timing (`paths.timed_path`): s'^2 at the nodes, what bounds it, and what follows at any time."""

    robot: Robot
    path: Any
    working: tuple[int, int]
    limits: Any
    piece: np.ndarray
    first: np.ndarray
    bent: np.ndarray
    lower_bound: float
    crossing: np.ndarray
    cap: np.ndarray
    ceiling: np.ndarray

    @property
    def s(self) -> np.ndarray: ...
    @property
    def times(self) -> np.ndarray: ...
    @property
    def duration(self) -> float: ...
    def __call__(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]: ...
    def along(self, t: np.ndarray) -> tuple[np.ndarray, ...]: ...
    def accelerations(self, t: np.ndarray) -> Accelerations: ...
    def tau(self, t: np.ndarray) -> np.ndarray: ...
    def pen(self, t: np.ndarray) -> np.ndarray: ...


class Replay(Protocol):
    """A run and its simulation on the same times, and how far apart they were."""

    measured: Run
    simulated: Run
    by: str
    figures: dict[str, float]
    difference: np.ndarray
    tau_difference: np.ndarray


class Identification(Protocol):
    """Torques measured and predicted, (n, 2) N m at t (n,) s, the share that is missed; the same of a second run."""

    robot: Robot
    t: np.ndarray
    tau: np.ndarray
    predicted: np.ndarray
    misfit: float
    validation: object | None


def crossings(t: np.ndarray, pose: Pose) -> Iterator[tuple[float, int, int, int, float]]:
    """(s, type, vanished sine, sample before, share of the way to the next) of each singularity between poses at t."""
    sines = np.stack([*pose.sines, pose.det_A], axis=1)
    known = np.isfinite(sines[:-1]) & np.isfinite(sines[1:])
    for k, margin in zip(*np.nonzero(known & np.diff(sines >= 0, axis=0))):  # once, too, where a pose is on it
        share = sines[k, margin] / (sines[k, margin] - sines[k + 1, margin])
        yield float(t[k] + share * (t[k + 1] - t[k])), 2 if margin == 2 else 1, int(margin), int(k), float(share)
