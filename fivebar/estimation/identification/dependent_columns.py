"""Columns of the regression that are sums of others: what a log cannot tell, in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy import ndarray

from ...models.geometry import dgm
from ...models.robots import Robot
from .regressor import linear_names, regressor

# Shares of a column: one whose own is less depends on the others, of any motion and of this log.
EXACT = 1e-7
NEARLY = 2e-4


def independent(
    W: ndarray, columns: list[int], tolerance: float
) -> tuple[list[int], dict[int, dict[int, float]]]:
    """Return the columns of W (n, 2, p) that are told, and the others as sums of these.

    The sums are {column: {column that is told: factor}}. Of columns that depend on each other, the
    first in this order is told.
    """
    # Columns of the triangle have the lengths and angles of the columns of W.
    triangle = np.linalg.qr(W.reshape(-1, W.shape[-1]), mode="r")
    sizes = np.linalg.norm(triangle, axis=0)
    unit = triangle / np.maximum(sizes, 1e-300)
    kept: list[int] = []
    folded: dict[int, dict[int, float]] = {}
    for k in columns:
        if sizes[k] <= 1e-12 * sizes.max():
            folded[k] = {}
            continue
        factors = np.linalg.lstsq(unit[:, kept], unit[:, k], rcond=None)[0]
        if np.linalg.norm(unit[:, k] - unit[:, kept] @ factors) > tolerance:
            kept.append(k)
            continue
        used = [(j, f) for j, f in zip(kept, factors.tolist()) if abs(f) > 1e-6]
        folded[k] = {j: f * float(sizes[k] / sizes[j]) for j, f in used}
    return kept, folded


def any_motion(robot: Robot, assembly: int, working: Sequence[int]) -> ndarray:
    """Return W of motions through poses all over the workspace in these modes."""
    rng = np.random.default_rng(16)
    reach = np.pi if robot.turns else sum(robot.distal)
    drawn = rng.uniform(-1, 1, (24_000, 2)) * reach
    pose = dgm(robot, drawn, assembly, unreachable="nan")
    good = np.abs(pose.det_A) > 0.2  # False for nan
    for mode, sine in zip(working, pose.sines):
        good &= -mode * sine > 0.05
    q = drawn[good][:400]
    if len(q) < 40:
        raise ValueError(
            f"this robot has hardly a pose in working modes {tuple(working)}, assembly mode"
            f" {assembly:+d}"
        )
    return regressor(robot, q, rng.normal(size=q.shape), rng.normal(size=q.shape), assembly)


def sentences(robot: Any, folded: dict[int, dict[int, float]], everywhere: bool) -> list[str]:
    """Return sentences on the columns that are not told."""
    names = linear_names(robot)
    motion = "no motion of this robot shows" if everywhere else "this log does not show"
    unseen = [names[k] for k, factors in folded.items() if not factors]
    weights = [name for name in unseen if name[0] == "m" and not any(robot.gravity)]
    others = [name for name in unseen if name not in weights]
    result = []
    if weights:
        result.append(
            f"{', '.join(weights)}: {motion} them, as without gravity they put no torque on a motor"
        )
    if others:
        result.append(f"{', '.join(others)}: {motion} them at all")
    for k, factors in folded.items():
        if factors:
            terms = []
            for j, factor in factors.items():
                terms.append(f"{names[j]} {factor:+.6g} {names[k]}")
            sums = ", ".join(terms)
            result.append(f"{names[k]}: {motion} it by itself, but {sums}, which are called so")
    return result
