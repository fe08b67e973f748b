"""How much measurement noise comes out in the angles, simulated and exact: `python -m tests.benchmarks.gains`."""

import math

import numpy as np
from scipy.linalg import solve_discrete_lyapunov

import fivebar as fb
from fivebar.study.pitfalls.sampled import SMALL, Decided, hold


def is_stable(p, q, delay=0):
    """Return whether gains p = Kp h^2, q = Kd h (arrays) are asymptotically stable.

    Without delay 0 < p and p/2 < q < 2; with one sample, r = q - p/2, 0 < p < r (1 - r). Exact:
    Jury's conditions on the characteristic polynomials of `spectral_radius`.
    """
    r = np.asarray(q) - np.asarray(p) / 2
    if delay == 0:
        return (0 < np.asarray(p)) & (r > 0) & (np.asarray(q) < 2)
    return (0 < np.asarray(p)) & (p < r * (1 - r))


def noise_gain(robot, p: float, q: float, delay: int = 0) -> float:
    """Return the standard deviation of the simulated robot's angles over that of measurement noise.

    White noise of one size on angles and, per period, on rates, for 400 samples; the first quarter
    does not count. inf where the motion grows.
    """
    errors = []
    noise = np.random.default_rng(0).normal(0.0, SMALL, (400, 2, 2))

    def watch(error, _):
        errors.append(error)
        if np.abs(error).max() > 1e4 * SMALL:
            raise Decided

    hold(robot, p, q, delay, watch, noise)
    if len(errors) < len(noise):
        return math.inf
    return float(np.sqrt(np.mean(np.square(errors[len(noise) // 4 :]))) / SMALL)


def exact_noise_gain(p: float, q: float, delay: int = 0) -> float:
    """Return the same of the sampled double integrator, by its discrete Lyapunov equation; inf
    where it is not stable.
    """
    if not is_stable(p, q, delay):
        return math.inf
    push = np.array([0.5, 1.0])  # of an acceleration, on (angle, rate per period) after a period
    A = np.array([[1.0, 1.0], [0.0, 1.0]])
    feedback = np.array([p, q])
    if delay:
        A = np.block([[A, push[:, None]], [-feedback, 0.0]])
        driven = np.array([0.0, 0.0, 1.0])
    else:
        A = A - np.outer(push, feedback)
        driven = push
    covariance = solve_discrete_lyapunov(A, (p * p + q * q) * np.outer(driven, driven))
    return math.sqrt(covariance[0, 0])


def main(side=15):
    """Print how far the gain of the simulated robot is from the exact one, over a grid of gains."""
    robot = fb.FiveBar()
    for delay, corner in enumerate(((4.5, 2.45), (0.3, 1.1))):
        differences = []
        for p in (np.arange(side) + 0.5) * corner[0] / side:
            for q in (np.arange(side) + 0.5) * corner[1] / side:
                exact = exact_noise_gain(p, q, delay)
                if math.isfinite(exact):
                    differences.append(abs(noise_gain(robot, p, q, delay) / exact - 1))
        median, largest = 100 * np.median(differences), 100 * max(differences)
        print(
            f"{delay} samples of delay: differ by {median:.2g} % in the median, at most {largest:.2g} %"
        )


if __name__ == "__main__":
    main()
