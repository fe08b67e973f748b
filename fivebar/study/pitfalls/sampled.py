"""Sampled computed torque: exact limits of its gains, and those measured on the simulated robot.

To the linear order computed torque makes each joint a double integrator under PD with zero-order
hold. With the period h its stability is a matter of p = Kp h^2 and q = Kd h alone, and of the
samples of delay, 0 or 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from ...control.laws import ComputedTorque
from ...models.geometry import dgm
from ...models.kinematics import dkm
from ...models.robots import Robot
from ...planning.trajectory import line
from ...simulation.settings import Measurement
from ...simulation.simulate import simulate

PERIOD = 0.01  # s
SMALL = 1e-7  # rad, the first disturbance
POSE = 0.3, 0.9  # rad, at which the robot is held
CENTRES = {0: (1.5, 1.4), 1: (0.12, 0.5)}  # stable gains (p, q), by samples of delay


def spectral_radius(p: float, q: float, delay: int = 0) -> float:
    """Return the largest |z| of the sampled double integrator: its growth per sample."""
    polynomials = {0: [1, p / 2 + q - 2, 1 + p / 2 - q], 1: [1, -2, 1 + p / 2 + q, p / 2 - q]}
    return float(np.abs(np.roots(polynomials[delay])).max())


def boundary(delay: int = 0) -> np.ndarray:
    """Return the limit of stability as a closed curve: points (n, 2) of (p, q)."""
    if delay == 0:
        return np.array([(0.0, 0.0), (4.0, 2.0), (0.0, 2.0), (0.0, 0.0)])
    r = np.linspace(0, 1, 201)
    p = r * (1 - r)
    return np.append(np.stack([p, r + p / 2], axis=-1), [(0.0, 0.0)], axis=0)


class Decided(Exception):
    """The motion says enough."""


def growth(robot: Robot, p: float, q: float, delay: int = 0) -> float:
    """Return the factor per sample by which a small disturbance of the simulated robot grows.

    It is held by ComputedTorque for at most 200 samples: fewer where the disturbance has become 1e4
    times larger, or 1e6 times smaller. The growth is that between the second and the last quarter.
    """
    sizes = []

    def watch(error, rate):
        sizes.append(math.hypot(*error, *(PERIOD * rate)))
        recent = max(sizes[-8:])  # an oscillation passes through zero
        if len(sizes) > 8 and not 1e-6 * SMALL < recent < 1e4 * SMALL:
            raise Decided

    hold(robot, p, q, delay, watch, np.zeros((200, 2, 2)))
    quarter = len(sizes) // 4
    return (max(sizes[-quarter:]) / max(sizes[quarter : 2 * quarter])) ** (1 / (2 * quarter))


def hold(
    robot: Robot,
    p: float,
    q: float,
    delay: int,
    watch: Callable[[np.ndarray, np.ndarray], object],
    noise: np.ndarray,
) -> None:
    """Hold the pose by ComputedTorque from a small error on, until watch raises Decided.

    Parameters
    ----------
    watch : (error, rate), both (2,), of each sample
    noise : (samples, 2, 2) of what is measured: of angles, rad, and of rates, rad per period
    """
    home = dgm(robot, POSE)
    reference = line(home.xi, home.xi, len(noise) * PERIOD)
    control = ComputedTorque(robot, p / PERIOD**2, q / PERIOD)
    start = dkm(dgm(robot, np.add(POSE, (SMALL, -0.6 * SMALL))), (0.0, 0.0))
    samples = iter(noise)

    def watched(t, angles, rates, reference):
        watch(angles - home.q, rates)
        of_angles, of_rates = next(samples)
        return control(t, angles + of_angles, rates + of_rates / PERIOD, reference)

    timing: dict[str, Any] = {
        "control_period": PERIOD,
        "step": PERIOD,
        "measurement": Measurement(delay=delay),
    }
    try:
        simulate(robot, watched, reference, start=start, **timing)
    except Decided:
        pass


@dataclass(frozen=True, eq=False)
class MeasuredLimit:
    """Limits (n, 2) of (p, q) along rays from a stable centre: measured on the robot, and exact."""

    delay: int
    measured: np.ndarray
    exact: np.ndarray

    @property
    def worst(self) -> float:
        """The largest relative difference in p or q."""
        return float(np.abs(self.measured / self.exact - 1).max())


def measure_limit(
    robot: Robot, delay: int = 0, count: int = 8, resolution: float = 1e-3
) -> MeasuredLimit:
    """Find where the growth of the simulated robot is 1, on rays through points of the limit.

    The edge p = 0 is left out, beyond which a gain would be negative. resolution: of the place, in
    parts of the ray.
    """
    curve = boundary(delay)
    centre = np.array(CENTRES[delay])
    if delay == 0:
        ends = zip(curve[:2], curve[1:3])
        targets = np.concatenate([np.linspace(*pair, count // 2 + 2)[1:-1] for pair in ends])
    else:
        targets = curve[np.linspace(0, len(curve) - 2, count + 2).astype(int)[1:-1]]
    measured = []
    for target in targets:
        ray = target - centre

        def decay(share, ray=ray):
            return math.log(growth(robot, *(centre + share * ray), delay))

        measured.append(centre + brentq(decay, 0.6, 1.4, xtol=resolution) * ray)
    return MeasuredLimit(delay, np.array(measured), targets)
