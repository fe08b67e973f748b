"""`tip_error`: how far off the tip of a robot is that is built to tolerances."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy import ndarray
from numpy.typing import ArrayLike

from ...base.backend import finite_numbers, unpack
from ...base.checks import instance, not_negative, optional, shown, whole
from ...base.presentation import Plotted
from ...base.representation import one_line
from ...base.robot_uses import takes_robot
from ...models.geometry import Pose, igm
from ...models.robots import FiveBar
from ...paths.tool import Tool
from .calibrate import known_names, start_values
from .measured_robot import PLACE, seen

PLAYS = {"backlash1": "offset1", "backlash2": "offset2"}  # what a motor's play moves


@dataclass(frozen=True, eq=False)
class TipError(Plotted):
    """Errors of the tip at n poses, to first order and by Monte Carlo; from `tip_error`.

    Attributes
    ----------
    pose : Pose
        The poses.
    names, tolerances : (k,)
        The parameters and their tolerances; of a backlash half of it.
    jacobian : (n, 2, k) array
        Derivatives of the tip by the parameters, the motors held.
    drawn : (n, samples, 2) array
        Errors of the tips of the drawn robots, m, nan where a robot does not close.
    """

    pose: Pose
    names: tuple[str, ...]
    tolerances: ndarray
    jacobian: ndarray
    drawn: ndarray = field(repr=False)

    def __repr__(self) -> str:
        n, samples = self.drawn.shape[:2]
        return one_line(
            "TipError",
            f"{n} poses",
            f"{samples} samples",
            f"sd up to {1e3 * self.sd.max():.3g} mm",
            f"by Monte Carlo {1e3 * self.monte_carlo_sd.max():.3g} mm",
        )

    @cached_property
    def covariance(self) -> ndarray:
        """(n, 2, 2), m^2, to first order: J diag(tolerance^2) J'."""
        return np.einsum("nik,k,njk->nij", self.jacobian, self.tolerances**2, self.jacobian)

    @cached_property
    def sd(self) -> ndarray:
        """(n,) RMS distance from where it should be, m, to first order."""
        return np.sqrt(np.trace(self.covariance, axis1=1, axis2=2))

    @cached_property
    def monte_carlo_sd(self) -> ndarray:
        """(n,) the same of the drawn robots that close, bias included; nan where none does."""
        total = np.nansum(self.drawn**2, axis=(1, 2))
        count = self._closed.sum(axis=1)
        return np.sqrt(np.where(count, total / np.maximum(count, 1), np.nan))

    @cached_property
    def _closed(self):
        return np.isfinite(self.drawn[..., 0])

    @property
    def open(self) -> ndarray:
        """(n,) share of drawn robots that cannot take the pose's motor angles at all."""
        return 1 - self._closed.mean(axis=1)

    @cached_property
    def radius(self) -> ndarray:
        """(n,) within which 95 % of all drawn robots are, m; inf where more do not close."""
        size = np.nan_to_num(np.hypot(*np.moveaxis(self.drawn, 2, 0)), nan=np.inf)
        return np.quantile(size, 0.95, axis=1, method="higher")

    @cached_property
    def worst(self) -> ndarray:
        """(n,) farthest error, m, to first order, with every parameter within its tolerance."""
        angle = np.linspace(0, np.pi, 720)
        along = np.stack([np.cos(angle), np.sin(angle)])
        moves = np.einsum("nik,id->ndk", self.jacobian * self.tolerances, along)
        return np.abs(moves).sum(axis=2).max(axis=1)


@takes_robot(tool=optional(instance(Tool)), samples=whole(10, 1_000_000), seed=whole(0, 2**63))
def tip_error(
    robot: FiveBar,
    tolerances: Mapping[str, float],
    poses: Pose | ArrayLike,
    *,
    tool: Tool | None = None,
    working: ArrayLike = (-1, -1),
    samples: int = 20_000,
    seed: int = 0,
) -> TipError:
    """Return errors of the tip of a robot that is commanded by its nominal model.

        d xi = A^-1 (u_i2 . dP_i + d l_i2), q held        (AMORO eq. 13, bars derived, too)

    Parameters
    ----------
    robot : FiveBar
        The nominal robot.
    tolerances : mapping
        {name: size} of l11, l12, l21, l22, d, offset1, offset2 (an encoder's error is one), ratio1,
        ratio2, along, across (of the tool); m and rad: standard deviations. And backlash1,
        backlash2: the play of a motor, rad, which holds its joint half of it on one side or the
        other.
    poses : Pose, or (2,) or (n, 2) array
        Poses, or points, m, that are reached in the mode `working`.
    tool : Tool, optional
        What draws, beside joint C; the poses are those of joint C.
    working : pair or (n, 2) array of +1 and -1
        Working modes.
    samples : int
        Number of robots drawn.
    seed : int
        Of the random numbers.

    Raises
    ------
    ValueError
        A tolerance is impossible; the message names it.
    UnreachableError, SingularityError
        As `igm`.

    Examples
    --------
    >>> import fivebar as fb
    >>> found = fb.tip_error(fb.FiveBar(), {"l11": 1e-4}, (0.0, 0.1))
    >>> bool(abs(found.monte_carlo_sd / found.sd - 1) < 0.05)
    True
    """
    if not isinstance(tolerances, Mapping):
        raise TypeError(f"tolerances must be a mapping {{name: size}}, not {shown(tolerances)}")
    names = tuple(tolerances)
    known = [PLAYS.get(name, name) for name in names]
    known_names(tuple(dict.fromkeys(known)), "tolerances")
    plays = np.array([name in PLAYS for name in names])
    sizes = np.array(
        [not_negative(value, f"tolerances[{name!r}]") for name, value in tolerances.items()]
    )
    sizes[plays] /= 2
    pose = poses if isinstance(poses, Pose) else igm(robot, _points(poses), working)
    if pose.robot != robot:
        raise ValueError("poses must be of the same robot")
    q = pose.q.reshape(-1, 2)
    assembly = np.ravel(pose.assembly)
    if not np.isfinite(q).all() or (assembly == 0).any():
        raise ValueError(
            "poses must be reached, and off Type-2 singularities: there the tip is not held at all"
        )
    if len(q) * samples > 2e7:
        raise ValueError(f"{len(q)} poses times {samples} samples: at most 2e7 together")
    p = start_values(robot, {}, tool, known)
    columns = np.array([PLACE[name] for name in known])
    at, jacobian = seen(p, q, assembly)
    draw = np.random.default_rng(seed)
    unit = draw.standard_normal((len(names), samples))
    unit[plays] = np.sign(unit[plays])
    robots = np.repeat(p[:, None], samples, axis=1)
    np.add.at(robots, columns, sizes[:, None] * unit)
    impossible = (robots[:4] <= 0).any(axis=0) | (robots[PLACE["scale"]] <= 0)
    drawn = np.empty((len(q), samples, 2))
    for k in range(len(q)):
        readings = np.tile(q[k], (samples, 1))
        points = seen(robots, readings, np.full(samples, assembly[k]), derive=False)[0]
        drawn[k] = points - at[k]
    drawn[:, impossible] = np.nan
    return TipError(pose, names, sizes, jacobian[:, :, columns], drawn)


def _points(poses):
    points = finite_numbers(poses, "poses")
    unpack(points, "poses")
    return points
