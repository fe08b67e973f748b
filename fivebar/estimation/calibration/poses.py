"""`measurement_poses`: where to measure so that few measurements tell most, over all modes."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from ...base.backend import check_modes, finite_numbers, real_numbers
from ...base.checks import instance, number, one_of, positive, shown, strings, takes, whole
from ...base.presentation import Plotted
from ...base.representation import one_line
from ...base.tables import TextFile, written
from ...models.geometry import Pose, igm, task_pose
from ...models.robots import FiveBar
from .calibrate import DEFAULT, known_names, start_values
from .fit import spectrum
from .indistinguishable import combination, plainest
from .measured_robot import PLACE, seen, sizes

if TYPE_CHECKING:
    pass

MODES = ((-1, -1), (-1, 1), (1, -1), (1, 1))
SIDE = 27  # candidates along the workspace, in each working mode
JUDGED, OFFERED = (
    150,
    400,
)  # poses over the workspace at which the tip's error is compared, and that are exchanged
PASSES, ROUNDS = 12, 2
MANY = 20  # poses, of which each is offered an exchange once a round
ANOTHER_MODE = 10.0  # rad: what a change of modes costs on the tour


@dataclass(frozen=True, eq=False)
class MeasurementPoses(Plotted):
    """Poses to measure at, in the order of a short tour; from `measurement_poses`.

    pose: a Pose of n; q (n, 2) what to command, the readings; assembly (n,), working (n, 2);
    unknown: names; worst_tip: the largest standard deviation of the tip (both coordinates) anywhere
    in the workspace after the calibration, in those of one measured number; sd: of the unknowns,
    SI, for measurements of 1 m.
    """

    pose: Pose
    q: np.ndarray
    unknown: tuple[str, ...]
    criterion: str
    worst_tip: float
    unit_sd: np.ndarray

    def __repr__(self) -> str:
        modes = {(*map(int, w), int(a)) for w, a in zip(self.working, self.assembly)}
        tip = f"tip within {self.worst_tip:.3g} sigma"
        return one_line(
            "MeasurementPoses", f"{len(self.q)} poses", f"{len(modes)} modes", self.criterion, tip
        )

    @property
    def xi(self) -> np.ndarray:
        return self.pose.xi

    @cached_property
    def working(self) -> np.ndarray:
        return self.pose.working

    @cached_property
    def assembly(self) -> np.ndarray:
        return self.pose.assembly

    def sd(self, sigma: float) -> dict[str, float]:
        """Standard deviations to expect of the unknowns where a number is measured to sigma, m."""
        return {
            name: float(positive(sigma, "sigma") * value)
            for name, value in zip(self.unknown, self.unit_sd)
        }

    def to_csv(self, path: TextFile) -> None:
        """Write q1, q2, modes, and x, y to be filled in, as `calibrate` reads it; where they should
        be in x_nominal.
        """
        with written(path) as out:
            lines = csv.writer(out)
            lines.writerow(
                ["q1", "q2", "x", "y", "working1", "working2", "assembly", "x_nominal", "y_nominal"]
            )
            for q, w, a, xi in zip(
                self.q.tolist(), self.working.tolist(), self.assembly.tolist(), self.xi.tolist()
            ):
                lines.writerow([*q, "", "", *w, a, *xi])


@takes(
    robot=instance(FiveBar),
    n=whole(1, 1000),
    unknown=strings,
    criterion=one_of("tip", "D"),
    margin=lambda value, name: number(value, name, 0.0, 0.95),
)
def measurement_poses(
    robot: FiveBar,
    n: int,
    unknown: Sequence[str] = DEFAULT,
    *,
    criterion: str = "tip",
    margin: float = 0.3,
    working: Sequence | None = None,
    window: Sequence[float] | None = None,
    start: Mapping[str, float] = MappingProxyType({}),
) -> MeasurementPoses:
    """The n poses whose measured points x, y tell most of the unknowns, ordered into a short tour.

    criterion: "tip", the least worst error of the tip anywhere in the workspace after calibration
    (G-optimal), or "D", the least volume of the unknowns' confidence region; by exchange (Fedorov
    1972) among a grid of all working modes.
    unknown, start: of `calibrate`. margin: sine of both legs' Type 1 and of Type 2 that poses keep.
    working: the modes that can be reached, [(-1, -1), ...], all by default. window: (x0, x1, y0,
        y1), m, that poses stay in.
    ValueError: too few poses, none there, or unknowns that no points x, y tell (it names them).
    """
    unknown = known_names(unknown)
    p = start_values(robot, start)
    columns = np.array([PLACE[name] for name in unknown])
    pose = candidates(robot, margin, _modes(working), window)
    if 2 * n < len(columns):
        raise ValueError(
            f"n = {n} poses give {2 * n} numbers, fewer than the {len(columns)} unknowns"
        )
    if len(pose.q) < n:
        raise ValueError(
            f"only {len(pose.q)} poses keep the margin {margin:g} (and are in the window): a"
            " smaller margin?"
        )
    readings = (pose.q - p[5:7]) / p[7:9]
    size = sizes(robot, readings, unknown)
    jacobian = seen(p, readings, pose.assembly)[1][:, :, columns] * size
    _must_tell(jacobian, unknown, size, p)
    chosen = _exchanged(jacobian, n)
    for _ in range(ROUNDS if n > 1 and criterion == "tip" else 0):
        chosen = _for_the_tip(jacobian, chosen)
    order = _tour(robot, pose.q[chosen], np.column_stack([pose.working, pose.assembly])[chosen])
    chosen = [chosen[k] for k in order]
    s, tolerance = spectrum(jacobian[chosen].reshape(-1, len(columns)))[1::2]
    if (s <= tolerance).any():
        raise ValueError(f"n = {n} poses are too few to tell {', '.join(unknown)}")
    covariance = np.linalg.inv(sum(j.T @ j for j in jacobian[chosen]))
    worst = float(np.sqrt(_spread(jacobian, covariance).max()))
    xi, modes = pose.xi[chosen], pose.working[chosen]
    found = igm(robot, xi, modes)
    sd = size * np.sqrt(np.diag(covariance))
    return MeasurementPoses(found, (found.q - p[5:7]) / p[7:9], unknown, criterion, worst, sd)


def tip_gain(
    robot: FiveBar,
    q: np.ndarray,
    assembly: np.ndarray,
    unknown: Sequence[str],
    margin: float = 0.3,
    start: Mapping[str, float] = MappingProxyType({}),
    working: Sequence | None = None,
) -> float:
    """`MeasurementPoses.worst_tip` of other poses, over the same workspace; inf where they do not
    tell all unknowns.
    """
    p, columns = (
        start_values(robot, start),
        np.array([PLACE[name] for name in known_names(unknown)]),
    )
    pose = candidates(robot, margin, _modes(working), None)
    size = sizes(robot, pose.q, unknown)
    own = seen(p, np.asarray(q, float), np.broadcast_to(assembly, len(q)))[1][:, :, columns] * size
    over = seen(p, (pose.q - p[5:7]) / p[7:9], pose.assembly)[1][:, :, columns] * size
    s, tolerance = spectrum(own.reshape(-1, len(columns)))[1::2]
    if (s <= tolerance).any():
        return np.inf
    return float(np.sqrt(_spread(over, np.linalg.inv(sum(j.T @ j for j in own))).max()))


def candidates(
    robot: FiveBar, margin: float, modes: Sequence, window: Sequence[float] | None
) -> Pose:
    """Poses on a grid over the workspace in these working modes, off singularities by the margin (a
    sine).
    """
    reach = [robot.l11 + robot.l12, robot.l21 + robot.l22]
    low, high = (
        max(-robot.d / 2 - reach[0], robot.d / 2 - reach[1]),
        min(robot.d / 2 + reach[1], reach[0] - robot.d / 2),
    )
    box = (low, high, -min(reach), min(reach)) if window is None else _window(window)
    x, y = np.meshgrid(np.linspace(*box[:2], SIDE), np.linspace(*box[2:], SIDE))
    points = np.stack([x.ravel(), y.ravel()], axis=-1)
    kept = []
    for mode in modes:
        with np.errstate(invalid="ignore", divide="ignore"):
            pose = task_pose(robot, (points[:, 0], points[:, 1]), mode)
            sines = np.abs(np.stack([*pose.sines, pose.det_A]))
            kept.append(np.flatnonzero((sines > margin).all(axis=0)))
    xi = np.concatenate([points[k] for k in kept])
    if not len(xi):
        raise ValueError(
            f"no pose keeps the margin {margin:g} and is in the window: a smaller margin?"
        )
    working = np.concatenate([np.tile(mode, (len(k), 1)) for mode, k in zip(modes, kept)])
    return igm(robot, xi, working)


def _modes(working):
    if working is None:
        return MODES
    found = check_modes(np.atleast_2d(real_numbers(working, "working")), "working")
    if found.ndim != 2 or found.shape[1] != 2 or not len(found):
        raise ValueError(
            f"working must be pairs of +1 and -1, some of {MODES}, not {shown(working)}"
        )
    return list(dict.fromkeys((int(left), int(right)) for left, right in found))


def _window(window):
    box = finite_numbers(window, "window")
    if box.shape != (4,) or not (box[0] < box[1] and box[2] < box[3]):
        raise ValueError(
            f"window must be (x0, x1, y0, y1) with x0 < x1, y0 < y1, not {shown(window)}"
        )
    return box.tolist()


def _must_tell(jacobian, unknown, size, p):
    s, right, tolerance = spectrum(jacobian.reshape(-1, len(unknown)))[1:]
    if (s <= tolerance).any():
        lost = plainest(right[int((s > tolerance).sum()) :])
        words = "; ".join(combination(vector, unknown, size, p) for vector in lost)
        raise ValueError(f"unknown: no points x, y tell these apart: {words}")


def _spread(jacobian, covariance):
    """Trace of the tip's covariance at each pose (N,)."""
    return np.einsum("nij,jk,nik->n", jacobian, covariance, jacobian)


def _exchanged(jacobian, n):
    """n candidates of greatest det of the information: greedy, then exchanges while one gains."""
    k = jacobian.shape[2]
    information, chosen = 1e-6 * np.eye(k), []
    for _ in range(n):
        gain = _gain(jacobian, np.linalg.inv(information))
        gain[chosen] = -1.0
        chosen.append(int(np.argmax(gain)))
        information = information + jacobian[chosen[-1]].T @ jacobian[chosen[-1]]
    for _ in range(PASSES):
        moved = False
        for place in range(n):
            own = jacobian[chosen[place]]
            rest = information - own.T @ own
            gain = _gain(jacobian, np.linalg.inv(rest))
            now = gain[chosen[place]]
            gain[chosen] = -1.0
            best = int(np.argmax(gain))
            if gain[best] > now * (1 + 1e-9):
                information, moved = rest + jacobian[best].T @ jacobian[best], True
                chosen[place] = best
        if not moved:
            break
    return chosen


def _gain(jacobian, covariance):
    """det(I + J C J') of each candidate, (N,)."""
    inner = np.einsum("nij,jk,nlk->nil", jacobian, covariance, jacobian)
    return (1 + inner[:, 0, 0]) * (1 + inner[:, 1, 1]) - inner[:, 0, 1] * inner[:, 1, 0]


def _for_the_tip(jacobian, chosen):
    """Exchanges while one lowers the worst error of the tip, over poses everywhere and those that
    are worst now.
    """
    chosen, information = (
        list(chosen),
        1e-9 * np.eye(jacobian.shape[2]) + sum(j.T @ j for j in jacobian[chosen]),
    )
    worst = np.argsort(-_spread(jacobian, np.linalg.inv(information)))
    judged = jacobian[
        np.union1d(
            worst[: JUDGED // 3], np.arange(0, len(jacobian), max(1, len(jacobian) // JUDGED))
        )
    ]
    offered = np.union1d(np.arange(0, len(jacobian), max(1, len(jacobian) // OFFERED)), chosen)
    worst = _spread(judged, np.linalg.inv(information)).max()
    flat, some = judged.reshape(-1, judged.shape[2]), jacobian[offered]
    for place in [*range(len(chosen))] * (1 if len(chosen) > MANY else 3):
        own = jacobian[chosen[place]]
        rest = information - own.T @ own
        covariance = np.linalg.inv(rest + 1e-9 * np.eye(len(rest)))
        # Each candidate j lowers pose w by |L^-1 J_j C J_w'|^2 with L L' = I + J_j C J_j'.
        across = some @ covariance
        lower = np.linalg.inv(np.linalg.cholesky(np.eye(2) + across @ some.transpose(0, 2, 1)))
        touched = ((lower @ across).reshape(-1, len(rest)) @ flat.T) ** 2
        touched = touched[::2] + touched[1::2]
        less = touched[:, ::2] + touched[:, 1::2]
        ends = (_spread(judged, covariance) - less).max(axis=1)
        ends[np.isin(offered, chosen)] = np.inf
        best = int(np.argmin(ends))
        if ends[best] < worst * (1 - 1e-6):
            worst, chosen[place] = ends[best], int(offered[best])
            information = rest + some[best].T @ some[best]
    return chosen


def _tour(robot, q, modes):
    """An order of short moves: from every start the nearest next, the best of these untangled
    (2-opt).
    """
    n = len(q)
    apart = np.abs(robot.joint_difference(q[:, None] - q[None])).max(axis=2)
    apart = apart + ANOTHER_MODE * (modes[:, None] != modes[None]).any(axis=2)
    best = None
    for first in range(n):
        order, left = [first], set(range(n)) - {first}
        while left:
            order.append(min(left, key=lambda k, here=order[-1]: apart[here, k]))
            left.remove(order[-1])
        length = apart[order[:-1], order[1:]].sum()
        if best is None or length < best[0]:
            best = length, order
    order, improved = best[1], n > 3
    while improved:
        improved = False
        for i in range(n - 1):
            for j in range(i + 1, n):
                gain = apart[order[i - 1], order[i]] - apart[order[i - 1], order[j]] if i else 0.0
                gain += (
                    apart[order[j], order[j + 1]] - apart[order[i], order[j + 1]]
                    if j + 1 < n
                    else 0.0
                )
                if gain > 1e-12:
                    order[i : j + 1] = order[i : j + 1][::-1]
                    improved = True
    return order
