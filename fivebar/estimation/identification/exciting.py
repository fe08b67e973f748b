"""Motions that tell most of a robot's masses and friction: Fourier series in the joints, of least
condition number.

    q_i(t) = c_i + sum_k a_ik sin(k w t) + b_ik cos(k w t)        sum_k k a_ik = 0        sum_k k^2
    b_ik = 0

with w = 2 pi / period: periodic, at rest at both ends (Swevers et al. 1997). For each shape and
centre the amplitude is the largest that keeps to the limits, so that every one tried is feasible;
of these the one is sought whose regression matrix, columns scaled to length 1, has the least
condition number: random starts, and Nelder and Mead from the best.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import casadi
import numpy as np
from scipy.linalg import null_space
from scipy.optimize import minimize

from ...base.checks import modes, number, optional, positive, seconds, strings, takes, whole
from ...base.checks import robot as must_be_robot
from ...base.progress import progress
from ...base.representation import one_line
from ...base.tables import TextFile, write
from ...models.compiled import Buffered
from ...models.dynamics import inverse_dynamics
from ...models.geometry import dgm
from ...models.kinematics import dkm, dkm2
from ...models.robots import Robot
from ...planning.trajectory import Trajectory
from .dependent_columns import EXACT, any_motion, independent
from .identify import sought_names
from .regressor import linear_names, regressor

SAMPLES, DENSE, HALVINGS = 120, 3000, 9
STARTS, BEST, STEPS = 120, 3, 250  # random shapes, of which so many are improved, by so many trials
WIDEST = 1.0  # rad, of the amplitude's search


@dataclass(frozen=True, eq=False, kw_only=True)
class Excitation(Trajectory):
    """A Trajectory, as `simulate` takes it, from `exciting_trajectory`; beyond one: robot; its
    modes working, assembly;
    condition: of its regression matrix; peaks: {"rate", "acceleration", "torque": (2,)}, SI;
        margin: the least of both
    |sines| and |det A|; joints: t -> (q, q', q'').
    """

    robot: Robot
    working: tuple[int, int]
    assembly: int
    condition: float
    peaks: dict[str, tuple[float, float]]
    margin: float
    joints: Callable[[np.ndarray], tuple]

    def __repr__(self) -> str:
        words = self.robot.words
        rate, torque = (max(self.peaks[name]) for name in ("rate", "torque"))
        limits = (
            f"rates to {rate:.3g} {words.unit}/s",
            f"{words.effort}s to {torque:.3g} {words.effort_unit}",
        )
        return one_line(
            "Excitation", f"{self.duration:g} s", f"condition {self.condition:.3g}", *limits
        )

    def to_csv(self, path: TextFile, step: float = 0.01) -> None:
        """Write it in rows `step` s apart: t, x, y, the joints, and their rates; SI. `fb.from_csv`
        reads it.
        """
        t = np.linspace(0.0, self.duration, int(round(self.duration / positive(step, "step"))) + 1)
        xi, xi_dot, _ = self(t)
        left, right = self.robot.words.joints
        about = {"robot": self.robot.parameters, "working": self.working, "assembly": self.assembly}
        rows = np.column_stack([t, xi, xi_dot, self.joints(t)[0]]).tolist()
        write(
            path, "exciting trajectory", about, ("t", "x", "y", "x_dot", "y_dot", left, right), rows
        )


class _Series:
    """q, q', q'' of centres (2,) and coefficients (2, 2 h), and the end-effector's motion by
    them.
    """

    def __init__(self, robot, assembly, period, centre, coefficients):
        self.robot, self.assembly, self.omega = robot, assembly, 2 * np.pi / period
        self.centre, self.coefficients = centre, coefficients

    def joints(self, t):
        waves = _waves(t, self.omega, self.coefficients.shape[1] // 2)
        q, q_dot, q_ddot = (wave @ self.coefficients.T for wave in waves)
        return self.centre + q, q_dot, q_ddot

    def __call__(self, t):
        q, q_dot, q_ddot = self.joints(np.asarray(t, dtype=float))
        acc = dkm2(dkm(dgm(self.robot, q, self.assembly), q_dot), q_ddot)
        return np.concatenate([acc.rates.pose.xi, acc.rates.xi_dot, acc.xi_ddot], axis=-1)


def _waves(t, omega, harmonics):
    """sin and cos of all harmonics, their first and second derivatives, each (*t, 2 h)."""
    k = omega * np.arange(1, harmonics + 1)
    angle = np.multiply.outer(t, k)
    s, c = np.sin(angle), np.cos(angle)
    both = np.concatenate([s, c], axis=-1), np.concatenate([k * c, -k * s], axis=-1)
    return *both, np.concatenate([-k * k * s, -k * k * c], axis=-1)


@takes(
    robot=must_be_robot,
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
    starts: int = STARTS,
) -> Excitation:
    """The motion of least condition number of `identify`'s regression, within limits; gives an
    Excitation.

    period: s, of the Fourier series with so many harmonics, repeated `cycles` times. rate,
    acceleration: rad/s, rad/s^2 of either joint; torque: N m of either motor, by the robot's own
        masses and friction; None: no limit. margin: of
    |sin| of both legs and |det A|, which keeps it within one aspect of these modes. unknown: as of
    `identify`.
    seed, starts: of the random shapes; the same seed, the same motion. ValueError where no motion
        keeps the limits.
    """
    margin = number(margin, "margin", 0.01, 0.9)
    names = linear_names(robot)
    told, _ = independent(
        any_motion(robot, assembly, working),
        [names.index(n) for n in sought_names(robot, unknown)],
        EXACT,
    )
    search = _Search(
        robot, period, harmonics, (rate, acceleration, torque), margin, working, assembly, told
    )
    rng = np.random.default_rng(seed)
    with progress(
        total=starts + BEST * STEPS, desc="exciting", unit=" motions", delay=2, leave=False
    ) as search.bar:
        best = _best(search, [search.random(rng) for _ in range(starts)])
    if best is None:
        raise ValueError(
            f"no motion was found within these limits, of working modes {working} and assembly mode"
            f" {assembly:+d}, with |sines| and |det A| above {margin:g}: ask for less margin, more"
            " torque, or other modes"
        )
    series = search.series(best, search.amplitude(best))
    t = np.linspace(0, period, DENSE)
    for _ in range(200):
        if search.keeps(*series.joints(t)):
            break
        series = _Series(robot, assembly, period, series.centre, 0.98 * series.coefficients)
    q, q_dot, q_ddot = series.joints(t)
    pose = dgm(robot, q, assembly)
    tau = inverse_dynamics(dkm2(dkm(pose, q_dot), q_ddot))
    peaks = {
        name: tuple(np.abs(values).max(axis=0).tolist())
        for name, values in (("rate", q_dot), ("acceleration", q_ddot), ("torque", tau))
    }
    least = float(min(np.abs(each).min() for each in (*pose.sines, pose.det_A)))
    return Excitation(
        0.0,
        period * cycles,
        series,
        robot=robot,
        working=working,
        assembly=assembly,
        condition=search.condition(q, q_dot, q_ddot),
        peaks=peaks,
        margin=least,
        joints=series.joints,
    )


@lru_cache(maxsize=16)
def _checked(robot, assembly):
    """(q, q', q'') of SAMPLES rows -> det A, both sines, both torques, nan where the robot does not
    close.
    """
    q, q_dot, q_ddot = (casadi.SX.sym(name, 2) for name in ("q", "q_dot", "q_ddot"))
    pose = dgm(robot, q, assembly)
    tau = inverse_dynamics(dkm2(dkm(pose, q_dot), q_ddot))
    row = casadi.densify(casadi.vertcat(pose.det_A, *pose.sines, tau))
    return casadi.Function("checked", [q, q_dot, q_ddot], casadi.cse([row])).map(SAMPLES)


def _best(search, shapes):
    """The best shape that is found from these; None where none keeps to the limits."""
    ranked = sorted(shapes, key=search.cost)[:BEST]
    if not np.isfinite(search.cost(ranked[0])):
        return None
    return min((_improved(search, each) for each in ranked), key=search.cost)


def _improved(search, shape):
    found = minimize(
        search.cost, shape, method="Nelder-Mead", options={"maxfev": STEPS, "adaptive": True}
    )
    return min((shape, found.x), key=search.cost)


class _Search:
    """Shapes: a centre (2,) and numbers for the coefficients that rest at both ends; and what they
    cost.
    """

    def __init__(self, robot, period, harmonics, limits, margin, working, assembly, told):
        self.robot, self.period, self.limits, self.margin = robot, period, limits, margin
        self.working, self.assembly, self.told = working, assembly, told
        k = np.arange(1, harmonics + 1.0)
        self.free = [null_space(row[None]) for row in (k, k * k)]
        self.t = np.linspace(0, period, SAMPLES, endpoint=False)
        self.known = {}
        self.call = Buffered(_checked(robot, assembly))

    def random(self, rng):
        """A shape whose centre is a pose of the modes."""
        reach = np.pi if self.robot.turns else sum(self.robot.distal)
        for _ in range(2000):
            centre = rng.uniform(-reach, reach, 2)
            if self.keeps(centre[None], np.zeros((1, 2)), np.zeros((1, 2))):
                break
        return np.concatenate(
            [centre, rng.normal(size=2 * sum(each.shape[1] for each in self.free))]
        )

    def series(self, shape, amplitude):
        centre, rest = shape[:2], shape[2:].reshape(2, -1)
        cut = self.free[0].shape[1]
        own = np.concatenate(
            [rest[:, :cut] @ self.free[0].T, rest[:, cut:] @ self.free[1].T], axis=1
        )
        k = np.tile(np.arange(1, own.shape[1] // 2 + 1), 2)
        size = np.linalg.norm(own / np.sqrt(k)) + 1e-300
        return _Series(self.robot, self.assembly, self.period, centre, amplitude * own / size)

    def keeps(self, q, q_dot, q_ddot):
        """Whether a motion of SAMPLES rows, or of less or more, keeps to all limits."""
        for values, limit in zip((q_dot, q_ddot), self.limits):
            if limit is not None and np.abs(values).max() > limit:
                return False
        shape = -(-len(q) // SAMPLES), SAMPLES, 2
        for part in zip(*(np.resize(each, shape) for each in (q, q_dot, q_ddot))):
            (found,) = self.call(*part)
            if not (
                found[:, 0] * -self.assembly >= self.margin
            ).all():  # nan too, where it does not close
                return False
            if not (-found[:, 1:3] * self.working >= self.margin).all():
                return False
            if self.limits[2] is not None and not (np.abs(found[:, 3:]) <= self.limits[2]).all():
                return False
        return True

    def amplitude(self, shape):
        """The largest that keeps to the limits, 0 where none does; the motion grows with it."""
        low, high = 0.0, WIDEST if self.robot.turns else sum(self.robot.distal)
        whole, centre = np.array(self.series(shape, 1.0).joints(self.t)), np.zeros((3, 1, 2))
        centre[0] = shape[:2]

        def keeps(amplitude):
            return self.keeps(*(centre + amplitude * (whole - centre)))

        if not keeps(1e-9):
            return 0.0
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            low, high = (middle, high) if keeps(middle) else (low, middle)
        return low

    def condition(self, q, q_dot, q_ddot):
        W = regressor(self.robot, q, q_dot, q_ddot, self.assembly)[:, :, self.told].reshape(
            -1, len(self.told)
        )
        sizes = np.linalg.norm(W, axis=0)
        return float(np.linalg.cond(W / sizes)) if sizes.all() else np.inf

    def cost(self, shape):
        """log of the condition number, plus a tenth of the log of what torque the accelerations
        make of noise.
        """
        key = shape.tobytes()
        if key not in self.known:
            self.bar.update()
            amplitude = self.amplitude(shape)
            self.known[key] = np.inf
            if amplitude > 0:
                motion = self.series(shape, amplitude).joints(self.t)
                small = np.sqrt(np.mean(motion[2] ** 2)) * self.period**2
                self.known[key] = np.log(self.condition(*motion)) - 0.1 * np.log(small)
        return self.known[key]
