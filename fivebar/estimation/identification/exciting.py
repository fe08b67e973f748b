"""Motions that tell most of a robot's masses and friction: Fourier series.

    q_i(t) = c_i + sum_k a_ik sin(k w t) + b_ik cos(k w t)
    sum_k k a_ik = 0        sum_k k^2 b_ik = 0        w = 2 pi / period

The series are periodic and at rest at both ends [Swevers1997]_. For each shape and centre, the
amplitude is the largest that keeps to the limits, so every motion tried is feasible. Of these, the
one is sought whose regression matrix, columns scaled to length 1, has the least condition number:
random starts, and Nelder and Mead from the best.

.. [Swevers1997] J. Swevers et al., Optimal robot excitation and identification, 1997.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import casadi
import numpy as np
from numpy import ndarray
from scipy.linalg import null_space
from scipy.optimize import minimize

from ...base.checks import modes, number, optional, positive, seconds, strings, whole
from ...base.progress import progress
from ...base.representation import one_line
from ...base.robot_uses import takes_robot
from ...base.tables import TextFile, write
from ...models.compiled import Buffered
from ...models.dynamics import inverse_dynamics
from ...models.geometry import dgm
from ...models.kinematics import dkm, dkm2
from ...models.robots import Robot
from ...planning.trajectory import Trajectory
from .dependent_columns import EXACT, any_motion, independent, sentences
from .identify import sought_names
from .regressor import linear_names, regressor

SAMPLES = 120  # rows of a motion in the search
BEST, STEPS = (3, 250)  # random shapes that are improved, and trials of each


@dataclass(frozen=True, eq=False, kw_only=True)
class Excitation(Trajectory):
    """A trajectory, as `simulate` takes it, from `exciting_trajectory`.

    Attributes
    ----------
    robot : FiveBar or Biglide
        The robot.
    working, assembly : pair of int, int
        Its modes.
    condition : float
        Condition number of its regression matrix.
    peaks : dict
        {"rate", "acceleration", "torque": (left, right)}, SI.
    margin : float
        The least of both |sines| and |det A|.
    joints : callable
        t -> (q, q', q'').
    """

    robot: Robot
    working: tuple[int, int]
    assembly: int
    condition: float
    peaks: dict[str, tuple[float, float]]
    margin: float
    joints: Callable[[ndarray], tuple]

    def __repr__(self) -> str:
        words = self.robot.words
        rate, torque = (max(self.peaks["rate"]), max(self.peaks["torque"]))
        return one_line(
            "Excitation",
            f"{self.duration:g} s",
            f"condition {self.condition:.3g}",
            f"rates to {rate:.3g} {words.unit}/s",
            f"{words.effort}s to {torque:.3g} {words.effort_unit}",
        )

    def to_csv(self, path: TextFile, step: float = 0.01) -> None:
        """Write rows `step` s apart: t, x, y, the joints and their rates; SI, for `fb.from_csv`."""
        count = int(round(self.duration / positive(step, "step"))) + 1
        t = np.linspace(0.0, self.duration, count)
        xi, xi_dot, _ = self(t)
        about = {"robot": self.robot.parameters, "working": self.working, "assembly": self.assembly}
        rows = np.column_stack([t, xi, xi_dot, self.joints(t)[0]]).tolist()
        header = ("t", "x", "y", "x_dot", "y_dot", *self.robot.words.joints)
        write(path, "exciting trajectory", about, header, rows)


@dataclass(frozen=True, eq=False)
class _Series:
    """A Fourier series of the joints, and the end-effector's motion by it.

    centre (2,); coefficients (2, 2 h) of sines and cosines.
    """

    robot: Robot
    assembly: int
    period: float
    centre: ndarray
    coefficients: ndarray

    def joints(self, t):
        omega = 2 * np.pi / self.period
        k = omega * np.arange(1, self.coefficients.shape[1] // 2 + 1)
        angle = np.multiply.outer(t, k)
        s = np.sin(angle)
        c = np.cos(angle)
        waves = ([s, c], [k * c, -k * s], [-k * k * s, -k * k * c])
        q, q_dot, q_ddot = (np.concatenate(each, axis=-1) @ self.coefficients.T for each in waves)
        return self.centre + q, q_dot, q_ddot

    def __call__(self, t):
        q, q_dot, q_ddot = self.joints(np.asarray(t, dtype=float))
        acc = dkm2(dkm(dgm(self.robot, q, self.assembly), q_dot), q_ddot)
        return np.concatenate([acc.rates.pose.xi, acc.rates.xi_dot, acc.xi_ddot], axis=-1)


@takes_robot(
    period=seconds,
    cycles=whole(1, 1000),
    harmonics=whole(2, 20),
    rate=optional(positive),
    acceleration=optional(positive),
    torque=optional(positive),
    assembly=modes(1),
    working=modes(2),
    unknown=optional(strings),
    seed=whole(0, 2**32 - 1),
    starts=whole(1, 10_000),
)
def exciting_trajectory(
    robot: Robot,
    *,
    period: float = 10.0,
    cycles: int = 1,
    harmonics: int = 5,
    rate: float | None = None,
    acceleration: float | None = None,
    torque: float | None = None,
    margin: float = 0.25,
    working: tuple[int, int] = (-1, -1),
    assembly: int = -1,
    unknown: list[str] | None = None,
    seed: int = 0,
    starts: int = 120,
) -> Excitation:
    """Return the motion of least condition number of `identify`'s regression, within limits.

    Parameters
    ----------
    robot : FiveBar or Biglide
        The robot; torques are by its own masses and friction.
    period : float
        Of the Fourier series, s.
    cycles : int
        Repetitions of the series.
    harmonics : int
        Of the series.
    rate, acceleration : float, optional
        Limits of either joint, rad/s and rad/s^2.
    torque : float, optional
        Limit of either motor, N m.
    margin : float
        Least |sin| of both legs and |det A|, which keeps the motion within one aspect.
    working, assembly
        Modes of the motion.
    unknown : list of str, optional
        As of `identify`.
    seed, starts : int
        Of the random shapes; the same seed, the same motion.

    Raises
    ------
    ValueError
        No motion keeps the limits.

    Examples
    --------
    >>> import fivebar as fb
    >>> excite = fb.exciting_trajectory(fb.FiveBar(), period=2.0, rate=5.0, starts=5)
    >>> max(excite.peaks["rate"]) <= 5.0
    True
    """
    margin = number(margin, "margin", 0.01, 0.9)
    names = linear_names(robot)
    columns = [names.index(name) for name in sought_names(robot, unknown)]
    told, unseen = independent(any_motion(robot, assembly, working), columns, EXACT)
    if not told:
        raise ValueError(f"unknown: {'; '.join(sentences(robot, unseen, everywhere=True))}")
    limits = rate, acceleration, torque
    rng = np.random.default_rng(seed)
    with progress(
        total=starts + BEST * STEPS, desc="exciting", unit=" motions", delay=2, leave=False
    ) as bar:
        search = _Search(robot, period, harmonics, limits, margin, working, assembly, told, bar)
        shape = _best(search, [search.random(rng) for _ in range(starts)])
    if shape is None:
        raise search.no_motion()
    t = np.linspace(0, period, 3000)
    series = search.series(shape, 0.999 * search.amplitude(shape, t))
    q, q_dot, q_ddot = series.joints(t)
    pose = dgm(robot, q, assembly)
    tau = inverse_dynamics(dkm2(dkm(pose, q_dot), q_ddot))
    peaks = {"rate": q_dot, "acceleration": q_ddot, "torque": tau}
    return Excitation(
        0.0,
        period * cycles,
        series,
        robot=robot,
        working=working,
        assembly=assembly,
        condition=search.condition(q, q_dot, q_ddot),
        peaks={name: tuple(np.abs(v).max(axis=0).tolist()) for name, v in peaks.items()},
        margin=float(np.abs([*pose.sines, pose.det_A]).min()),
        joints=series.joints,
    )


@lru_cache(maxsize=16)
def _margins_and_torques(robot, assembly):
    """Return the function (q, q', q'') of SAMPLES rows -> det A, both sines, both torques."""
    q, q_dot, q_ddot = (casadi.SX.sym(name, 2) for name in ("q", "q_dot", "q_ddot"))
    pose = dgm(robot, q, assembly)
    tau = inverse_dynamics(dkm2(dkm(pose, q_dot), q_ddot))
    row = casadi.densify(casadi.vertcat(pose.det_A, *pose.sines, tau))
    return casadi.Function("checked", [q, q_dot, q_ddot], casadi.cse([row])).map(SAMPLES)


def _best(search, shapes):
    """Return the best shape that is found from these; None where none keeps to the limits."""
    ranked = sorted(shapes, key=search.cost)[:BEST]
    if not np.isfinite(search.cost(ranked[0])):
        return None
    options = {"maxfev": STEPS, "adaptive": True}
    for shape in list(ranked):
        ranked.append(minimize(search.cost, shape, method="Nelder-Mead", options=options).x)
    return min(ranked, key=search.cost)


class _Search:
    """Shapes, and what they cost.

    A shape is a centre (2,) and numbers for the coefficients that rest at both ends.
    """

    def __init__(self, robot, period, harmonics, limits, margin, working, assembly, told, bar):
        self.robot, self.period, self.limits, self.margin = (robot, period, limits, margin)
        self.working, self.assembly, self.told, self.bar = (working, assembly, told, bar)
        self.widest = 1.0 if robot.turns else sum(robot.distal)
        k = np.arange(1, harmonics + 1.0)
        self.at_rest = [null_space(row[None]) for row in (k, k * k)]
        # Never at rest, where the sign of dry friction would be that of rounding.
        self.t = (np.arange(SAMPLES) + 0.5) * period / SAMPLES
        self.call = Buffered(_margins_and_torques(robot, assembly))

    def no_motion(self):
        return ValueError(
            f"no motion was found within these limits, of working modes {self.working} and assembly"
            f" mode {self.assembly:+d}, with |sines| and |det A| above {self.margin:g}: ask for"
            " less margin, more torque, or other modes"
        )

    def random(self, rng):
        """Return a shape whose centre is a pose of the modes."""
        reach = np.pi if self.robot.turns else self.widest
        still = np.zeros((1, 2))
        for _ in range(2000):
            centre = rng.uniform(-reach, reach, 2)
            if self.keeps(centre[None], still, still):
                break
        else:
            raise self.no_motion()
        count = sum(basis.shape[1] for basis in self.at_rest)
        return np.concatenate([centre, rng.normal(size=2 * count)])

    def series(self, shape, amplitude):
        sines, cosines = self.at_rest
        centre = shape[:2]
        rest = shape[2:].reshape(2, -1)
        cut = sines.shape[1]
        parts = [rest[:, :cut] @ sines.T, rest[:, cut:] @ cosines.T]
        coefficients = np.concatenate(parts, axis=1)
        k = np.tile(np.arange(1, len(sines) + 1), 2)
        size = np.linalg.norm(coefficients / np.sqrt(k))
        return _Series(
            self.robot, self.assembly, self.period, centre, amplitude * coefficients / size
        )

    def keeps(self, q, q_dot, q_ddot):
        """Return whether a motion keeps to all limits; False where it does not close."""
        for values, limit in zip((q_dot, q_ddot), self.limits):
            if limit is not None and np.abs(values).max() > limit:
                return False
        shape = -(-len(q) // SAMPLES), SAMPLES, 2
        torque = np.inf if self.limits[2] is None else self.limits[2]
        for part in zip(*(np.resize(values, shape) for values in (q, q_dot, q_ddot))):
            (rows,) = self.call(*part)
            signed = -rows[:, :3] * (self.assembly, *self.working)
            if not ((signed >= self.margin).all() and (np.abs(rows[:, 3:]) <= torque).all()):
                return False
        return True

    def amplitude(self, shape, t):
        """Return the largest amplitude that keeps to the limits at these times, 0 if none does."""
        whole = np.array(self.series(shape, 1.0).joints(t))
        centre = np.zeros((3, 1, 2))
        centre[0] = shape[:2]

        def keeps(amplitude):
            return self.keeps(*(centre + amplitude * (whole - centre)))

        low = 0.0
        high = self.widest
        if not keeps(1e-9):
            return 0.0
        for _ in range(9):
            middle = (low + high) / 2
            low, high = (middle, high) if keeps(middle) else (low, middle)
        return low

    def condition(self, q, q_dot, q_ddot):
        W = regressor(self.robot, q, q_dot, q_ddot, self.assembly)[:, :, self.told]
        W = W.reshape(-1, len(self.told))
        sizes = np.linalg.norm(W, axis=0)
        return float(np.linalg.cond(W / sizes)) if sizes.all() else np.inf

    def cost(self, shape):
        """Return the log of the condition number, less a tenth of that of the accelerations."""
        self.bar.update()
        amplitude = self.amplitude(shape, self.t)
        if amplitude == 0:
            return np.inf
        motion = self.series(shape, amplitude).joints(self.t)
        size = np.sqrt(np.mean(motion[2] ** 2)) * self.period**2
        return np.log(self.condition(*motion)) - 0.1 * np.log(size)
