"""`measurement_poses`: where to measure so that few measurements tell most, over all modes."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy import ndarray

from ...base.backend import finite_numbers, real_numbers
from ...base.checks import instance, number, optional, positive, shown, strings, whole
from ...base.presentation import Plotted
from ...base.representation import one_line
from ...base.robot_uses import takes_robot
from ...base.tables import TextFile, written
from ...models.geometry import Pose, igm
from ...models.robots import FiveBar
from ...paths.tool import Tool
from .calibrate import DEFAULT, known_names, start_values
from .candidates import MODES, candidates
from .fit import spectrum
from .indistinguishable import combination, plainest
from .measured_robot import PLACE, seen, sizes

BEFORE = 1e-4  # of a pose's information: what is taken as known before any pose


@dataclass(frozen=True, eq=False)
class MeasurementPoses(Plotted):
    """Poses to measure at, in the order of a short tour; from `measurement_poses`.

    Attributes
    ----------
    pose : Pose
        The n poses.
    q : (n, 2) array
        The readings to command.
    unknown : tuple of str
        The unknowns of the calibration.
    worst_tip : float
        The largest standard deviation of the tip (both coordinates) anywhere in the workspace after
        the calibration, in those of one measured number.
    unit_sd : array
        Standard deviations of the unknowns, SI, for numbers measured to 1 m.
    """

    pose: Pose
    q: ndarray
    unknown: tuple[str, ...]
    worst_tip: float
    unit_sd: ndarray

    def __repr__(self) -> str:
        modes = np.unique(np.column_stack([self.working, self.assembly]), axis=0)
        return one_line(
            "MeasurementPoses",
            f"{len(self.q)} poses",
            f"{len(modes)} modes",
            f"tip within {self.worst_tip:.3g} sigma",
        )

    @property
    def xi(self) -> ndarray:
        return self.pose.xi

    @property
    def working(self) -> ndarray:
        return self.pose.working

    @property
    def assembly(self) -> ndarray:
        return self.pose.assembly

    def sd(self, sigma: float) -> dict[str, float]:
        """Return the standard deviations to expect of numbers measured to sigma, m."""
        return dict(zip(self.unknown, (positive(sigma, "sigma") * self.unit_sd).tolist()))

    def to_csv(self, path: TextFile) -> None:
        """Write the poses as `calibrate` reads them, with x and y to be filled in.

        Where they should be stands in x_nominal and y_nominal.
        """
        header = "q1 q2 x y working1 working2 assembly x_nominal y_nominal".split()
        with written(path) as out:
            lines = csv.writer(out)
            lines.writerow(header)
            for k, (q, xi) in enumerate(zip(self.q.tolist(), self.xi.tolist())):
                lines.writerow([*q, "", "", *self.working[k], self.assembly[k], *xi])


@takes_robot(
    tool=optional(instance(Tool)),
    n=whole(1, 1000),
    unknown=strings,
    margin=lambda value, name: number(value, name, 0.01, 0.95),
)
def measurement_poses(
    robot: FiveBar,
    n: int,
    unknown: Sequence[str] = DEFAULT,
    *,
    tool: Tool | None = None,
    margin: float = 0.3,
    working: Sequence | None = None,
    window: Sequence[float] | None = None,
    start: Mapping[str, float] = MappingProxyType({}),
) -> MeasurementPoses:
    """Return the n poses whose measured points x, y tell most of the unknowns.

    By exchange [Fedorov1972]_ among a grid of all working modes, in the order of a short tour. The
    confidence region of the unknowns has the least volume (D-optimal), and so the worst error of
    the tip anywhere is about the least, too [Kiefer1960]_.

    Parameters
    ----------
    robot : FiveBar
        The nominal robot.
    n : int
        Number of poses.
    unknown, tool, start
        As of `calibrate`. The poses are those of joint C.
    margin : float
        Sine of both legs' Type 1 and of Type 2 that poses keep, from 0.01 to 0.95.
    working : sequence of pairs, optional
        Working modes that can be reached, [(-1, -1), ...]; all by default.
    window : sequence of 4 floats, optional
        (x0, x1, y0, y1), m, that poses stay in.

    Raises
    ------
    ValueError
        There are too few poses, or unknowns that no points x, y tell; these are named.

    References
    ----------
    .. [Fedorov1972] V. Fedorov, Theory of Optimal Experiments, 1972.
    .. [Kiefer1960] J. Kiefer, J. Wolfowitz, The equivalence of two extremum problems, 1960.

    Examples
    --------
    >>> import fivebar as fb
    >>> len(fb.measurement_poses(fb.FiveBar(), 6).q)
    6
    """
    unknown = known_names(unknown)
    p = start_values(robot, start, tool, unknown)
    columns = np.array([PLACE[name] for name in unknown])
    pose = candidates(robot, margin, _modes(working), None if window is None else _window(window))
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
    _refuse_untold(jacobian, unknown, size)
    chosen = _exchanged(jacobian, n)
    order = _tour(robot, pose.q[chosen], np.column_stack([pose.working, pose.assembly])[chosen])
    chosen = [chosen[k] for k in order]
    s, tolerance = spectrum(jacobian[chosen].reshape(-1, len(columns)))[1::2]
    if (s <= tolerance).any():
        raise ValueError(f"n = {n} poses are too few to tell {', '.join(unknown)}")
    covariance = np.linalg.inv(sum(j.T @ j for j in jacobian[chosen]))
    worst = float(np.sqrt(_spread(jacobian, covariance).max()))
    xi = pose.xi[chosen]
    modes = pose.working[chosen]
    found = igm(robot, xi, modes)
    sd = size * np.sqrt(np.diag(covariance))
    return MeasurementPoses(found, (found.q - p[5:7]) / p[7:9], unknown, worst, sd)


def _modes(working):
    if working is None:
        return MODES
    found = np.atleast_2d(real_numbers(working, "working"))
    pairs = list(map(tuple, found.tolist()))
    if not pairs or any(pair not in MODES for pair in pairs):
        raise ValueError(
            f"working must be pairs of +1 and -1, some of {MODES}, not {shown(working)}"
        )
    return list(dict.fromkeys(pairs))


def _window(window):
    box = finite_numbers(window, "window")
    if box.shape != (4,) or not (box[0] < box[1] and box[2] < box[3]):
        raise ValueError(
            f"window must be (x0, x1, y0, y1) with x0 < x1, y0 < y1, not {shown(window)}"
        )
    return box.tolist()


def _refuse_untold(jacobian, unknown, size):
    s, right, tolerance = spectrum(jacobian.reshape(-1, len(unknown)))[1:]
    if (s <= tolerance).any():
        null = plainest(right[int((s > tolerance).sum()) :])
        lost = "; ".join(combination(vector, unknown, size) for vector in null)
        raise ValueError(f"unknown: no points x, y tell these apart: {lost}")


def _spread(jacobian, covariance):
    """Return the trace of the tip's covariance at each pose (N,)."""
    return np.einsum("nij,jk,nik->n", jacobian, covariance, jacobian)


def _exchanged(jacobian, n):
    """Return n candidates of the greatest det of the information, by greedy steps and exchanges."""
    # A share of a mean pose's information on each unknown, so that no sum is singular.
    information = BEFORE * np.mean(jacobian**2) * np.eye(jacobian.shape[2])
    chosen = []
    for _ in range(n):
        gain = _gain(jacobian, np.linalg.inv(information))
        gain[chosen] = -1.0
        chosen.append(_first_of_largest(gain))
        information = information + jacobian[chosen[-1]].T @ jacobian[chosen[-1]]
    for _ in range(12):
        moved = False
        for place in range(n):
            own = jacobian[chosen[place]]
            rest = information - own.T @ own
            gain = _gain(jacobian, np.linalg.inv(rest))
            now = gain[chosen[place]]
            gain[chosen] = -1.0
            best = _first_of_largest(gain)
            if gain[best] > now * (1 + 1e-9):
                information = rest + jacobian[best].T @ jacobian[best]
                moved = True
                chosen[place] = best
        if not moved:
            break
    return chosen


def _first_of_largest(values):
    """Return the first place of the largest value: which of two mirrored poses, rounding must not
    say.
    """
    largest = values.max()
    return int(np.argmax(values >= largest - 1e-9 * abs(largest)))


def _gain(jacobian, covariance):
    """Return det(I + J C J') of each candidate, (N,)."""
    inner = np.einsum("nij,jk,nlk->nil", jacobian, covariance, jacobian)
    diagonal = (1 + inner[:, 0, 0]) * (1 + inner[:, 1, 1])
    return diagonal - inner[:, 0, 1] * inner[:, 1, 0]


def _tour(robot, q, modes):
    """Return an order of short moves: the best of those that always go to the nearest next."""
    n = len(q)
    cost = np.abs(robot.joint_difference(q[:, None] - q[None])).max(axis=2).round(9)
    cost = cost + 10.0 * (modes[:, None] != modes[None]).any(axis=2)  # modes change rarely
    tours = []
    for first in range(n):
        order = [first]
        left = set(range(n)) - {first}
        while left:
            order.append(min(left, key=cost[order[-1]].__getitem__))
            left.remove(order[-1])
        tours.append((cost[order[:-1], order[1:]].sum(), order))
    return min(tours)[1]
