"""Direct collocation of a motion in task space: schemes, piecewise polynomial motions, and the
problem on one mesh.

In each interval the acceleration is the polynomial through its values at the collocation points;
velocity and position are its exact integrals, so that a planned motion is its own derivative
everywhere, as collocation of a second-order equation should have it (Moreno-Martin, Ros, Celaya
2022). The controls are the two bar forces: m xi'' = A^T lambda, tau = Z q'' + B^T lambda, with no
division by det A.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

METHOD = "legendre-gauss"  # as files of plans name the scheme
LIMITS = ("torque", "joint_speed", "acceleration", "poses", "sin", "det_A", "functions")


class Scheme:
    """Legendre and Gauss's points c in [0, 1], and matrices for polynomials through their values.

    to_power (s, s): values -> coefficients of 1, sigma, ...; to_bezier (s, s): values -> Bezier
    points, which hold the polynomial in their hull.
    """

    def __init__(self, degree: int) -> None:
        self.c = (np.polynomial.legendre.leggauss(degree)[0] + 1) / 2
        k = np.arange(degree)
        self.to_power = np.linalg.inv(self.c[:, None] ** k)
        binomials = np.zeros((len(k), len(k)))
        for i, j in np.ndindex(binomials.shape):
            all_of = math.comb(len(k) - 1, j)
            binomials[i, j] = math.comb(i, j) / all_of
        self.to_bezier = binomials @ self.to_power
        # Factors of the integrals over [0, 1] of the squares of a polynomial and of its slope.
        hilbert = 1 / (k[:, None] + k + 1.0)
        self.square = np.linalg.cholesky(hilbert).T
        i = k[1:]
        column = i[:, None]
        products = column * i / (column + i - 1.0)
        slopes = np.eye(len(k))[1:]
        self.square_slope = np.linalg.cholesky(products).T @ slopes

    def powers(self, sigma: ArrayLike) -> tuple[np.ndarray, ...]:
        """Return rows that give acceleration, velocity / h and position / h^2 at sigma (...).

        They are multiplied by the acceleration's values at the points.
        """
        k = np.arange(len(self.c))
        sigma = np.asarray(sigma)[..., None]
        acceleration = sigma**k
        velocity = sigma ** (k + 1) / (k + 1)
        position = sigma ** (k + 2) / ((k + 1) * (k + 2))
        return tuple(terms @ self.to_power for terms in (acceleration, velocity, position))

    def nodes(self, knots: np.ndarray) -> np.ndarray:
        """Return times of all points, by the times of the knots."""
        widths = np.diff(knots)[:, None]
        return (knots[:-1, None] + widths * self.c).ravel()


@dataclass(frozen=True, eq=False)
class Pieces:
    """A motion and its torques, polynomials in each interval.

    knots (n + 1,) s; xi, xi_dot (n, 2) at the beginning of each interval; xi_ddot, tau (n, s, 2) at
    its points; or in place of xi the four bars' angles (n, 4).
    """

    scheme: Scheme
    knots: np.ndarray
    xi: np.ndarray
    xi_dot: np.ndarray
    xi_ddot: np.ndarray
    tau: np.ndarray

    @cached_property
    def widths(self) -> np.ndarray:
        return np.diff(self.knots)

    @property
    def effort(self) -> float:
        """The integral of the squares of the torques."""
        tau = self.scheme.square @ self.scheme.to_power @ self.tau
        return float(self.widths @ np.square(tau).sum(axis=(1, 2)))

    def locate(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return interval and place in it, in [0, 1], of times (...) in s."""
        k = np.clip(np.searchsorted(self.knots, t, side="right") - 1, 0, len(self.xi) - 1)
        return k, np.clip((t - self.knots[k]) / self.widths[k], 0.0, 1.0)

    @cached_property
    def _table(self):
        """Coefficients (n, s + 2, 8) of powers of the place in each interval."""
        s = len(self.scheme.c)
        h = self.widths[:, None, None]
        n = self.xi.shape[1]
        a, tau = (self.scheme.to_power @ values for values in (self.xi_ddot, self.tau))
        k = np.arange(s)[:, None]
        table = np.zeros((len(h), s + 2, 3 * n + 2))
        position = slice(n)
        velocity = slice(n, 2 * n)
        acceleration = slice(2 * n, 3 * n)
        torque = slice(3 * n, None)
        table[:, 0, position] = self.xi
        table[:, 1, position] = h[:, 0] * self.xi_dot
        twice = (k + 1) * (k + 2)
        table[:, 2:, position] = h**2 * a / twice
        table[:, 0, velocity] = self.xi_dot
        table[:, 1:-1, velocity] = h * a / (k + 1)
        table[:, :-2, acceleration] = a
        table[:, :-2, torque] = tau
        return table

    def motion(self, k: np.ndarray, sigma: np.ndarray) -> np.ndarray:
        """Return position, velocity, acceleration and torque at places sigma of intervals k.

        They are (..., 8), in the four bars' angles (..., 14).
        """
        exponents = np.arange(self._table.shape[1])
        powers = np.asarray(sigma)[..., None] ** exponents
        return (powers[..., None, :] @ self._table[k])[..., 0, :]
