"""Sampled computed torque: exact limits of its gains, and the limits measured on the simulated
robot.

To the linear order computed torque makes each joint a double integrator under PD with zero-order
hold. With the period h its stability is a matter of p = Kp h^2 and q = Kd h alone, and of the
samples of delay.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import solve_discrete_lyapunov
from scipy.optimize import brentq

from ...control.laws import ComputedTorque
from ...models.geometry import dgm
from ...models.kinematics import dkm
from ...planning.trajectory import line
from ...simulation.simulate import simulate

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ...models.robots import Robot

PERIOD = 0.01
SMALL = 1e-7  # rad, the first disturbance


def is_stable(p: ArrayLike, q: ArrayLike, delay: int = 0) -> np.ndarray:
    """Whether gains p = Kp h^2, q = Kd h (arrays that broadcast) are asymptotically stable; delay:
    0 or 1 sample.

    Without delay 0 < p and p/2 < q < 2; with one sample, r = q - p/2, 0 < p < r (1 - r). Exact:
    Jury's conditions on the characteristic polynomials of `spectral_radius`.
    """
    p, q = np.asarray(p, dtype=float), np.asarray(q, dtype=float)
    if delay == 0:
        return (0 < p) & (p / 2 < q) & (q < 2)
    if delay == 1:
        r = q - p / 2
        return (0 < p) & (p < r * (1 - r))
    raise ValueError(f"delay must be 0 or 1 samples, not {delay!r}")


def spectral_radius(p: float, q: float, delay: int = 0) -> float:
    """The largest |z| of the sampled double integrator, plain numbers p and q: it grows by this
    factor each sample.
    """
    polynomials = {0: [1, p / 2 + q - 2, 1 + p / 2 - q], 1: [1, -2, 1 + p / 2 + q, p / 2 - q]}
    return float(np.abs(np.roots(polynomials[delay])).max())


def boundary(delay: int = 0, count: int = 201) -> np.ndarray:
    """The limit of stability as a closed curve: points (n, 2) of (p, q)."""
    if delay == 0:
        return np.array([(0.0, 0.0), (4.0, 2.0), (0.0, 2.0), (0.0, 0.0)])
    if delay == 1:
        r = np.linspace(0, 1, count)
        p = r * (1 - r)
        return np.append(np.stack([p, r + p / 2], axis=-1), [(0.0, 0.0)], axis=0)
    raise ValueError(f"delay must be 0 or 1 samples, not {delay!r}")


# The largest s = sqrt(Kp) h of critically damped gains, Kd = 2 sqrt(Kp): by the conditions above.
CRITICALLY_DAMPED = {0: 1.0, 1: 0.426158909}


class _Decided(Exception):
    pass


def growth(
    robot: Robot,
    p: float,
    q: float,
    delay: int = 0,
    pose: ArrayLike = (0.3, 0.9),
    samples: int = 200,
) -> float:
    """Factor per sample by which a small disturbance of the simulated robot grows, held at `pose`
    by ComputedTorque.

    p, q: gains as above.
    delay: samples.
    pose: (2,) rad.
    samples: fewer where the disturbance has become 1e4 times larger, or 1e6 times smaller, before;
        the growth is that between the second and the last quarter of them.
    """
    sizes = []

    def watch(error, rate):
        sizes.append(math.hypot(*error, *(PERIOD * rate)))
        recent = max(sizes[-8:])  # an oscillation passes through zero
        if len(sizes) > 8 and not 1e-6 * SMALL < recent < 1e4 * SMALL:
            raise _Decided

    _hold(robot, p, q, delay, pose, samples, np.zeros((samples, 2, 2)), watch)
    quarter = len(sizes) // 4
    return (max(sizes[-quarter:]) / max(sizes[quarter : 2 * quarter])) ** (1 / (2 * quarter))


def _hold(robot, p, q, delay, pose, samples, noise, watch):
    """Hold `pose` by ComputedTorque from a small error on, until watch(error, its rate) is decided.

    noise: (samples, 2, 2) of what is measured: of the angles, rad, and of the rates, in rad per
        period.
    """
    home = dgm(robot, pose)
    reference = line(home.xi, home.xi, samples * PERIOD)
    control = ComputedTorque(robot, p / PERIOD**2, q / PERIOD)
    start = dkm(dgm(robot, np.add(pose, (SMALL, -0.6 * SMALL))), (0.0, 0.0))
    measured = iter(noise)

    def watched(t, angles, rates, reference):
        watch(angles - home.q, rates)
        of_angles, of_rates = next(measured)
        return control(t, angles + of_angles, rates + of_rates / PERIOD, reference)

    try:
        simulate(
            robot, watched, reference, start=start, control_period=PERIOD, step=PERIOD, delay=delay
        )
    except _Decided:
        pass


def noise_gain(
    robot: Robot,
    p: float,
    q: float,
    delay: int = 0,
    pose: ArrayLike = (0.3, 0.9),
    samples: int = 400,
    seed: int = 0,
) -> float:
    """Standard deviation of the simulated robot's joint angles over that of the noise in what is
    measured.

    White noise of one size on angles and, per period, on rates; the first quarter of the samples
    does not count. inf where the motion grows.
    """
    rng, errors = np.random.default_rng(seed), []

    def watch(error, _):
        errors.append(error)
        if np.abs(error).max() > 1e4 * SMALL:
            raise _Decided

    _hold(robot, p, q, delay, pose, samples, rng.normal(0.0, SMALL, (samples, 2, 2)), watch)
    if len(errors) < samples:
        return math.inf
    return float(np.sqrt(np.mean(np.square(errors[samples // 4 :]))) / SMALL)


def exact_noise_gain(p: float, q: float, delay: int = 0) -> float:
    """The same of the sampled double integrator, by its discrete Lyapunov equation; inf where it is
    not stable.
    """
    if not is_stable(p, q, delay):
        return math.inf
    push = np.array(
        [0.5, 1.0]
    )  # of an acceleration, held for a period, on (angle, rate per period)
    A, feedback = np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([p, q])
    if delay:
        A = np.block([[A, push[:, None]], [-feedback, 0.0]])
        driven = np.array([0.0, 0.0, 1.0])
    else:
        A, driven = A - np.outer(push, feedback), push
    covariance = solve_discrete_lyapunov(A, (p * p + q * q) * np.outer(driven, driven))
    return math.sqrt(covariance[0, 0])


@dataclass(frozen=True, eq=False)
class MeasuredLimit:
    """Limits along rays from a stable centre, (n, 2) of (p, q): measured on the robot, and
    exact.
    """

    delay: int
    measured: np.ndarray
    exact: np.ndarray

    @property
    def worst(self) -> float:
        """Largest relative difference in p or q."""
        return float(np.abs(self.measured / self.exact - 1).max())


CENTRES = {0: (1.5, 1.4), 1: (0.12, 0.5)}


def measure_limit(
    robot: Robot, delay: int = 0, count: int = 8, resolution: float = 1e-3
) -> MeasuredLimit:
    """Where the growth on the simulated robot is 1, on rays from a stable centre through `count`
    points of the limit.

    The edge p = 0 is left out, beyond which a gain would be negative. resolution: of the place, in
    parts of the ray.
    """
    curve, centre = boundary(delay), np.array(CENTRES[delay])
    if delay == 0:
        lower, upper = (
            np.linspace(a, b, count // 2 + 2)[1:-1] for a, b in zip(curve[:2], curve[1:3])
        )
        targets = np.concatenate([lower, upper])
    else:
        targets = curve[np.linspace(0, len(curve) - 2, count + 2).astype(int)[1:-1]]
    directions = targets - centre
    found = [
        brentq(
            lambda s, d=d: math.log(growth(robot, *(centre + s * d), delay=delay)),
            0.6,
            1.4,
            xtol=resolution,
        )
        for d in directions
    ]
    return MeasuredLimit(delay, centre + np.array(found)[:, None] * directions, targets)
