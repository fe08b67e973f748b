"""The five-bar in heyoka: Taylor series of adaptive order on our own equations, by LLVM; in
`fivebar[peers]`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from fivebar.models.four_joints import bars_of

from .motions import DURATION, ROBOT
from .mujoco_pinocchio import legs_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from .motions import DrivenMotion


def accelerations(hy, a: tuple, w: tuple, torque: tuple) -> list:
    """Of the bars a = (q1, phi1, q2, phi2) turning at w, by the forces in the distal bars, over m.

    Of the angles only differences come in: three sines and three cosines, as few as our own stages
        have.
    """
    apart, mass, legs = a[3] - a[1], ROBOT.m, []
    sine, cosine = hy.sin(apart), hy.cos(apart)
    for k, (_, l1, l2, z) in enumerate(legs_of(ROBOT)):
        own = a[2 * k + 1] - a[2 * k]
        s, c = l1 * hy.sin(own), l1 * hy.cos(own)
        right = s * torque[k] / z - c * w[2 * k] ** 2 - l2 * w[2 * k + 1] ** 2
        legs.append((s, c, right, mass / z * s**2, l2, z))
    (_, _, r1, k1, *_), (_, _, r2, k2, *_) = legs
    determinant = sine**2 + (k1 + k2) + k1 * k2
    forces = (
        ((1.0 + k2) * r1 - cosine * r2) / determinant,
        ((1.0 + k1) * r2 - cosine * r1) / determinant,
    )
    found = []
    for k, (s, c, _, _, l2, z) in enumerate(legs):
        own = (torque[k] - mass * s * forces[k]) / z
        across = (sine, -sine)[k] * forces[1 - k]
        found += [own, (across - c * own - s * w[2 * k] ** 2) / l2]
    return found


def heyoka_run(motion: DrivenMotion, tolerance: float) -> tuple[Callable, None]:
    """call () -> final bars (q1, phi1, q2, phi2); the loop over the steps is heyoka's own, in
    C++.
    """
    import heyoka as hy

    names = "q1", "phi1", "q2", "phi2"
    a, w = (hy.make_vars(*(f"{name}{dot}" for name in names)) for dot in ("", "_dot"))
    wave = hy.cos(2 * math.pi * hy.time)
    torque = tuple(each * wave if each else 0.0 for each in motion.torque(0.0))  # times cos 2 pi t
    system = [*zip(a, w), *zip(w, accelerations(hy, a, w, torque))]
    start = np.array([float(each) for half in bars_of(motion.begin()) for each in half])
    series = hy.taylor_adaptive(system, start, tol=tolerance, fast_math=True, compact_mode=False)

    def run():
        series.time = 0.0
        series.state[:] = start
        series.propagate_until(DURATION)
        return series.state[:4].copy()

    return run, None
