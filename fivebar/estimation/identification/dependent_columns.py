"""What a log cannot tell apart: columns of the regression that are sums of others, in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...models.geometry import dgm
from ...models.robots import Robot
from .regressor import linear_names, regressor

EXACT, NEARLY = (
    1e-7,
    2e-4,
)  # of a column, less than which is its own: of any motion, and of this log
POSES, ENOUGH, SEED, AWAY = 400, 40, 16, 0.05  # AWAY: of a sine from Type 1


def independent(
    W: np.ndarray, columns: list[int], tolerance: float
) -> tuple[list[int], dict[int, dict[int, float]]]:
    """(columns that are told, {column that is not: {column: factor} whose sum it is}) of W (n, 2,
    p), in this order.

    The first of the columns that depend on each other is told, with the others' shares in it.
    """
    flat = W.reshape(-1, W.shape[-1])
    sizes = np.linalg.norm(flat, axis=0)
    largest = sizes.max(initial=0.0)
    kept, folded, basis = [], {}, np.zeros((len(flat), 0))
    for k in columns:
        if sizes[k] <= 1e-12 * largest:
            folded[k] = {}
            continue
        v = flat[:, k] / sizes[k]
        for _ in range(2):
            v = v - basis @ (basis.T @ v)
        own = np.linalg.norm(v)
        if own > tolerance:
            kept.append(k)
            basis = np.column_stack([basis, v / own])
        else:
            scale = sizes[kept]
            share = np.linalg.lstsq(flat[:, kept] / scale, flat[:, k], rcond=None)[0] / scale
            size = np.abs(share) * scale / sizes[k]
            folded[k] = {j: float(f) for j, f, s in zip(kept, share, size) if s > 1e-6}
    return kept, folded


def any_motion(robot: Robot, assembly: int, working: Sequence[int]) -> np.ndarray:
    """W of motions through poses all over the workspace in these modes, of all rates and
    accelerations of size 1.
    """
    rng = np.random.default_rng(SEED)
    reach = sum(robot.distal) + 1e-9
    found = [np.empty((0, 2))]
    for q in rng.uniform(-1, 1, (20, 3 * POSES, 2)) * (np.pi if robot.turns else reach):
        pose = dgm(robot, q, assembly, unreachable="nan")
        good = np.abs(pose.det_A) > 0.2  # no nan is
        for mode, sine in zip(working, pose.sines):
            good &= -mode * sine > AWAY
        found.append(q[good])
        if sum(map(len, found)) >= POSES:
            break
    q = np.concatenate(found)[:POSES]
    if len(q) < ENOUGH:
        raise ValueError(
            f"this robot has hardly a pose in working modes {tuple(working)}, assembly mode"
            f" {assembly:+d}"
        )
    return regressor(robot, q, rng.normal(size=q.shape), rng.normal(size=q.shape), assembly)


def words(robot: Robot, folded: dict[int, dict[int, float]], everywhere: bool) -> list[str]:
    """Sentences on what is folded."""
    names, notes = linear_names(robot), []
    motion = "no motion of this robot shows" if everywhere else "this log does not show"
    still = [names[k] for k, shares in folded.items() if not shares]
    weights = [name for name in still if name[0] == "m"]
    if weights and not any(robot.gravity):
        notes.append(
            f"{', '.join(weights)}: {motion} them, as without gravity they put no torque on a motor"
        )
        still = [name for name in still if name not in weights]
    if still:
        notes.append(f"{', '.join(still)}: {motion} {'it' if len(still) == 1 else 'them'} at all")
    for k, shares in folded.items():
        if shares:
            sums = ", ".join(f"{names[j]} {factor:+.6g} {names[k]}" for j, factor in shares.items())
            called = ", ".join(names[j] for j in shares)
            notes.append(
                f"{names[k]}: {motion} it by itself, but {sums}: what is called {called} has its"
                " share"
            )
    return notes
