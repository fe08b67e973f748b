"""The labs' models step by step, for cranks and for sliders, each quantity by its name in the
papers; any of them may be another one, as a student may have taken it.

A leg's quantities stand side by side, (n, 2); points of the plane are complex numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..models.robots import Robot
from .columns import QUARTER, Array, inverse

Step = Callable[[Any], Any]


class Derivation:
    """The quantities of a batch of questions, each computed when it is first asked for.

    given: an argument's name -> its column (n,); steps: name -> another step in place of the right
    one, or of the robot itself.
    """

    def __init__(self, robot: Robot, given: Mapping[str, Array], steps: Mapping[str, Step] = {}):
        self.robot: Any = steps["robot"](robot) if "robot" in steps else robot
        self._given, self._steps = given, steps
        self.turns = self.robot.turns
        self.distal = np.array(self.robot.distal)
        self.proximal = np.ones(2)
        if self.turns:
            self.proximal = np.array([drive.length for drive in self.robot.drives])

    def __getattr__(self, name: str) -> Any:
        if name not in STEPS:
            raise AttributeError(name)
        value = self._steps.get(name, STEPS[name])(self)
        self.__dict__[name] = value
        return value

    def pair(self, left: str, right: str) -> Array:
        """Return two arguments side by side, (n, 2)."""
        return np.stack([self._given[left], self._given[right]], axis=-1)

    def argument(self, name: str) -> Array:
        """Return an argument (n,). Raises KeyError where the function has none of that name."""
        return self._given[name]

    def has(self, name: str) -> bool:
        """Return whether the function has such an argument."""
        return name in self._given


def unit(angle: Array) -> Array:
    """Return unit vectors (..., 2)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def dot(a: Array, b: Array) -> Array:
    return np.sum(a * b, axis=-1)


def turned(matrix: Array) -> Array:
    """Return the transposes."""
    return matrix.swapaxes(-1, -2)


def solved(matrix: Array, vector: Array) -> Array:
    """Return the solutions (n, 2) of 2 x 2 systems, nan where singular."""
    return (inverse(matrix) @ vector[..., None])[..., 0]


def product(matrix: Array, vector: Array) -> Array:
    return (matrix @ vector[..., None])[..., 0]


def _foot(base: Array, near: Array, far: Array) -> Array:
    """Return the distance of a triangle's foot of the height from the corner at the side `near`."""
    size = np.abs(base)
    return (size**2 + near**2 - far**2) / (2 * size)


def _tip(s):
    if s.has("x"):
        return s.argument("x") + 1j * s.argument("y")
    direction = s.line / np.abs(s.line)
    return s.pivot[:, 1] + s.a * direction + s.mode * s.h * 1j * direction


# Each quantity: from the others. u, v: unit vectors of the proximal bar (1) and the distal bar (2),
# along it and turned by 90 degrees; a slider's u1 is along x, so that its v1 is along y.
STEPS: dict[str, Step] = {
    "base": lambda s: np.array([drive.x for drive in s.robot.drives]),
    "q": lambda s: s.pair("q11", "q21"),
    "passive": lambda s: s.pair("q12", "q22"),
    "rates": lambda s: s.pair("q11D", "q21D"),
    "passive_rates": lambda s: s.pair("q12D", "q22D"),
    "accelerations": lambda s: s.pair("q11DD", "q21DD"),
    "xi_dot": lambda s: s.pair("xD", "yD"),
    "xi_ddot": lambda s: s.pair("xDD", "yDD"),
    "tau": lambda s: s.pair("tau1", "tau2"),
    # geometry
    "crank": lambda s: s.proximal * np.exp(1j * s.q) if s.turns else 1j * s.q,
    "pivot": lambda s: s.base + s.crank,
    "line": lambda s: s.pivot[:, 0] - s.pivot[:, 1],
    "a": lambda s: _foot(s.line, s.distal[1], s.distal[0]),
    "root": lambda s: np.sqrt,  # by which a height is that of its square
    "h": lambda s: s.root(s.distal[1] ** 2 - s.a**2),
    "mode": lambda s: s.argument("assembly_mode"),
    "tip": _tip,
    "reach": lambda s: s.tip[:, None] - s.base,
    "b": lambda s: _foot(s.reach, s.proximal, s.distal) if s.turns else s.reach.real,
    "rise": lambda s: s.root((s.proximal if s.turns else s.distal) ** 2 - s.b**2),
    "gamma": lambda s: s.pair("gamma1", "gamma2"),
    "elbow": lambda s: (s.b + s.gamma * s.rise * 1j) * s.reach / np.abs(s.reach),
    "active": lambda s: np.angle(s.elbow) if s.turns else s.reach.imag + s.gamma * s.rise,
    "bar": lambda s: s.tip[:, None] - s.pivot,
    "absolute": lambda s: np.angle(s.bar),
    "relative": lambda s: s.absolute - s.q if s.turns else s.absolute,
    # first order: A xi' = B q'
    "phi": lambda s: s.q + s.passive if s.turns else s.passive,
    "u1": lambda s: unit(s.q if s.turns else 0 * s.q),
    "u2": lambda s: unit(s.phi),
    "v1": lambda s: s.u1 @ QUARTER.T,
    "v2": lambda s: s.u2 @ QUARTER.T,
    "A": lambda s: s.u2,
    "b_ii": lambda s: s.proximal * dot(s.u2, s.v1),
    "B": lambda s: s.b_ii[..., None] * np.eye(2),
    "J": lambda s: inverse(s.A) @ s.B,
    "J_inverse": lambda s: inverse(s.B) @ s.A,
    "xi_dot_found": lambda s: product(s.J, s.rates),
    "rates_found": lambda s: product(s.J_inverse, s.xi_dot),
    # passive rates and accelerations
    "driven": lambda s: s.accelerations if s.has("xDD") else s.rates,
    "of_tip": lambda s: dot(s.v2, (s.xi_ddot if s.has("xDD") else s.xi_dot)[:, None]),
    "of_pivot": lambda s: s.proximal * dot(s.v2, s.v1) * s.driven,
    "pull": lambda s: s.proximal * s.rates**2 * dot(s.v2, s.u1) if s.turns else 0 * s.rates,
    "across": lambda s: s.of_tip - s.of_pivot + (s.pull if s.has("xDD") else 0),
    "turning": lambda s: s.across / s.distal,
    "passive_found": lambda s: s.turning - s.driven * s.turns,
    # second order: A xi'' = B q'' + d
    "rate": lambda s: s.rates + s.passive_rates if s.turns else s.passive_rates,
    "near": lambda s: s.proximal * s.rates**2 * dot(s.u2, s.u1) if s.turns else 0 * s.rates,
    "square": lambda s: s.rate**2,
    "far": lambda s: s.distal * s.square,
    "d": lambda s: -s.near - s.far,
    "xi_ddot_found": lambda s: solved(s.A, product(s.B, s.accelerations) + s.d),
    "accelerations_found": lambda s: solved(s.B, product(s.A, s.xi_ddot) - s.d),
    # dynamics: tau = M q'' + c
    "Z": lambda s: np.diag(s.robot.inertias),
    "M": lambda s: s.Z + s.robot.m * turned(s.J) @ s.J,
    "c": lambda s: s.robot.m * product(turned(s.J), solved(s.A, s.d)),
    "tau_found": lambda s: product(s.M, s.accelerations) + s.c,
    "free_accelerations": lambda s: solved(s.M, s.tau - s.c),
}
