"""Plans: what was asked, what it may cost, and the motion found, which proves itself."""

import math
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..models.dynamics import bar_force_dynamics, drives_forces
from ..models.geometry import igm
from ..models.kinematics import ikm, ikm2
from ..models.robots import robot_of
from ..tables import read_columns
from .collocation import METHODS, Pieces, scheme

FINE = np.linspace(0.0, 1.0, 13)  # places in each interval where a plan is checked
CSV = "# fivebar plan, SI units: "
COLUMNS = ("t", "x", "y", "x_dot", "y_dot", "x_ddot", "y_ddot", "tau1", "tau2", "lambda1", "lambda2")


class PlanError(RuntimeError):
    """No plan was found; `plan` is the best one found (None where there is none), never converged or never feasible.

    violations: dict, by how much it exceeds each limit (SI); status: how IPOPT ended where it did not solve.
    """

    def __init__(self, message, violations, plan=None, status=""):
        super().__init__(message)
        self.violations, self.plan, self.status = violations, plan, status


class Mesh(NamedTuple):
    """One solution on the way: intervals, IPOPT's iterations, objective, error (as `Plan.error`), s since the call."""

    intervals: int
    iterations: int
    objective: float
    error: float
    seconds: float


@dataclass(frozen=True)
class Limits:
    """What a plan must keep, SI: torque, joint_speed one number per joint, acceleration of the end-effector,
    workspace ((x low, x high), (y low, y high)), serial and parallel: least |sin q_i2| and |det A|; None: no limit."""

    torque: tuple | None = None
    joint_speed: tuple | None = None
    acceleration: float | None = None
    workspace: tuple | None = None
    serial: float = 0.05
    parallel: float | None = None


@dataclass(frozen=True, eq=False)
class Problem:
    """What is asked: stops are (conditions by order of derivative, time or None), as in `trajectory.polynomial`."""

    robot: object
    stops: tuple
    working: tuple
    weights: dict
    limits: Limits
    scheme: object

    @property
    def length(self):
        return sum(self.robot.distal) / 2

    @property
    def lever(self):
        """What makes a speed of a joint's: a length where it turns, 1 where it slides."""
        return self.length if self.robot.turns else 1.0

    @property
    def mass(self):
        return self.robot.m + sum(self.robot.inertias) / self.lever**2

    @cached_property
    def side(self):
        """Sign of det A at the start, which a limit on it keeps."""
        return float(np.sign(igm(self.robot, self.stops[0][0][0], self.working).det_A)) or 1.0

    def signed_sines(self, pose):
        """-w_i sin q_i2 of both legs (positive in these working modes), det A with the sign it has at the start."""
        return *(-w * sine for w, sine in zip(self.working, pose.sines)), self.side * pose.det_A

    def violations(self, xi=None, q_dot=None, xi_ddot=None, tau=None, sines=None):
        """By how much the limits on what is given, (..., 2), are exceeded: {name: array}, <= 0 where they are kept."""
        limits, found = self.limits, {}
        if tau is not None and limits.torque is not None:
            found["torque"] = (np.abs(tau) - limits.torque).max(axis=-1)
        if q_dot is not None and limits.joint_speed is not None:
            found["joint_speed"] = (np.abs(q_dot) - limits.joint_speed).max(axis=-1)
        if xi_ddot is not None and limits.acceleration is not None:
            found["acceleration"] = np.linalg.norm(xi_ddot, axis=-1) - limits.acceleration
        if xi is not None and limits.workspace is not None:
            low, high = np.array(limits.workspace).T
            found["workspace"] = np.maximum(low - xi, xi - high).max(axis=-1)
        if sines is not None:
            found["serial"] = limits.serial - np.minimum(sines[0], sines[1])
            if limits.parallel is not None:
                found["parallel"] = limits.parallel - sines[2]
        return found

    def unit(self, name):
        """What a violation is compared with: the limit itself, a bar's length, a sine of 1."""
        if name in ("torque", "joint_speed", "acceleration"):
            return float(np.max(getattr(self.limits, name)))
        return self.length if name in ("workspace", "reach") else 1.0


@dataclass(frozen=True, eq=False)
class Plan:
    """A planned motion: call it with t, as any reference, for (xi, xi_dot, xi_ddot); it holds its first and last point.

    problem: what was asked; pieces: the polynomials; objective: its value, SI; status: IPOPT's word; meshes: the way to
    it, mesh by mesh; solve_time: s, of the whole call.
    """

    problem: Problem
    pieces: Pieces
    objective: float
    status: str
    meshes: tuple = ()
    solve_time: float = math.nan
    start = 0.0

    @property
    def robot(self):
        return self.problem.robot

    @property
    def working(self):
        return self.problem.working

    @property
    def duration(self):
        return float(self.pieces.knots[-1])

    @property
    def iterations(self):
        return sum(mesh.iterations for mesh in self.meshes)

    def __call__(self, t):
        motion = self._at(t)
        return motion[..., :2], motion[..., 2:4], motion[..., 4:6]

    def tau(self, t):
        """Planned torques (*t.shape, 2), N m (forces, N, of a biglide); 0 before and after."""
        return self._at(t)[..., 6:]

    def _at(self, t):
        times = np.asarray(t, dtype=float)
        motion = self.pieces.motion(*self.pieces.locate(times))
        outside = (times < 0) | (times > self.duration)
        if outside.any():
            motion[..., 2:] = np.where(outside[..., None], 0.0, motion[..., 2:])
        return motion

    def accelerations(self, t):
        """The planned motion as `Accelerations`, with pose and rates: angles, det A and whatever follows from them."""
        return accelerations_of(self.problem, self._at(t))

    def bar_forces(self, t):
        """Forces in the distal bars (*t.shape, 2), N: B^-1 (tau - Z q''), finite at Type 2."""
        motion = self._at(t)
        return np.stack(drives_forces(accelerations_of(self.problem, motion), _legs(motion)), axis=-1)

    @property
    def nodes(self):
        """Times (n,) s of the collocation points."""
        return self.pieces.scheme.nodes(self.pieces.knots)

    @cached_property
    def _fine(self):
        """Motion (n, 13, 8) within every interval, and it as Accelerations."""
        k, sigma = np.meshgrid(np.arange(len(self.pieces.xi)), FINE, indexing="ij")
        motion = self.pieces.motion(k, sigma)
        return motion, accelerations_of(self.problem, motion)

    @cached_property
    def defects(self):
        """Largest |m xi'' - A^T lambda| in each interval (n,), N, with lambda = B^-1 (tau - Z q'')."""
        motion, acc = self._fine
        push, _ = bar_force_dynamics(acc, drives_forces(acc, _legs(motion)))
        return np.hypot(*push).max(axis=1)

    @property
    def error(self):
        """Largest defect over the largest force |m xi''|, both between nodes too."""
        return float(self._relative_defects.max())

    @cached_property
    def _relative_defects(self):
        force = self.robot.m * np.linalg.norm(self._fine[0][..., 4:6], axis=-1).max()
        return self.defects / (force or 1.0)

    @cached_property
    def _exceeded(self):
        motion, acc = self._fine
        pose = acc.rates.pose
        found = self.problem.violations(
            motion[..., :2], acc.rates.q_dot, motion[..., 4:6], motion[..., 6:], self.problem.signed_sines(pose)
        )
        return found | {"reach": -pose.reach_margin}

    @cached_property
    def violations(self):
        """{limit: by how much it is exceeded anywhere, 0.0 if not}, SI, between nodes too."""
        return {name: max(0.0, float(np.fmax.reduce(value, axis=None))) for name, value in self._exceeded.items()}

    @property
    def saturated(self):
        """Part of the time in which at least one torque is within 0.1 % of its limit."""
        if self.problem.limits.torque is None:
            return 0.0
        tau = self.tau(np.linspace(0, self.duration, 2001))
        return float(np.mean((np.abs(tau) >= 0.999 * np.array(self.problem.limits.torque)).any(axis=1)))

    def to_csv(self, path):
        """Write the plan at its nodes; problem, knots and what is known of the solution go into a comment line. SI."""
        import csv
        import json

        rule, problem = self.pieces.scheme, self.problem
        about = {
            "robot": asdict(self.robot), "stops": [[list(c.items()), t] for c, t in problem.stops],
            "working": problem.working, "weights": problem.weights, "limits": asdict(problem.limits),
            "method": METHODS[not rule.shared], "degree": len(rule.c), "knots": self.pieces.knots.tolist(),
            "objective": self.objective, "status": self.status, "meshes": self.meshes, "solve_time": self.solve_time,
        }  # fmt: skip
        t = self.nodes
        motion, forces = self._at(t), self.bar_forces(t)
        with open(path, "w", newline="", encoding="utf-8") as file:
            file.write(f"{CSV}{json.dumps(about)}\n")
            writer = csv.writer(file)
            writer.writerow(COLUMNS)
            writer.writerows(map(repr, row) for row in np.column_stack([t, motion, forces]).tolist())

    @classmethod
    def from_csv(cls, path):
        """Read what `to_csv` wrote."""
        import json

        with open(path, encoding="utf-8") as file:
            first = file.readline()
        try:
            about = json.loads(first.removeprefix(CSV))
            limits = {k: tuple(v) if isinstance(v, list) else v for k, v in about["limits"].items()}
            if limits["workspace"]:
                limits["workspace"] = tuple(map(tuple, limits["workspace"]))
            stops = tuple(({k: tuple(v) for k, v in conditions}, t) for conditions, t in about["stops"])
            problem = Problem(
                robot_of(about["robot"]), stops, tuple(about["working"]), about["weights"], Limits(**limits),
                scheme(about["method"], about["degree"]),
            )  # fmt: skip
            knots, meshes = np.array(about["knots"]), tuple(Mesh(*mesh) for mesh in about["meshes"])
            known = about["objective"], about["status"], meshes, about["solve_time"]
        except (ValueError, KeyError, TypeError, AttributeError):
            raise ValueError(f"{path}, line 1: not a file written by Plan.to_csv") from None
        table = read_columns(path, COLUMNS)
        index = problem.scheme.points(len(knots) - 1)
        if len(table) != index[-1, -1] + 1:
            raise ValueError(f"{path}: {len(table)} rows, but its first line speaks of {index[-1, -1] + 1}")
        xi, xi_dot, xi_ddot, tau = (table[:, k : k + 2] for k in (1, 3, 5, 7))
        return cls(problem, Pieces.through(problem.scheme, knots, xi, xi_dot, xi_ddot[index], tau[index]), *known)

    def plot(self, path=None):
        """Matplotlib figure of path, torques and margins; written to `path` (PNG, SVG, PDF) if given."""
        from ..pictures.plot.plans import planned

        figure = planned(self)
        if path is not None:
            figure.savefig(path)
        return figure


def accelerations_of(problem, motion):
    pose = igm(problem.robot, motion[..., :2], problem.working, unreachable="nan")
    return ikm2(ikm(pose, motion[..., 2:4]), motion[..., 4:6])


def _legs(motion):
    """The torques of a motion (..., 8), per leg."""
    return motion[..., 6], motion[..., 7]


def listed(problem, violations):
    """The violated limits in words."""
    words, own = [], problem.robot.words
    units = {"torque": own.effort_unit, "joint_speed": f"{own.unit}/s", "acceleration": "m/s^2", "workspace": "m"}
    for name, value in violations.items():
        if value > 1e-6 * problem.unit(name):
            limit = getattr(problem.limits, name, None)
            limit = max(limit) if name in ("torque", "joint_speed") else limit
            against = "" if name in ("workspace", "reach") else f" (limit {limit:.6g})"
            called = own.effort if name == "torque" else name
            words.append(f"{called} by {value:.4g} {units.get(name, 'm' * (name == 'reach'))}".rstrip() + against)
    return f"; violated: {', '.join(words)}" if words else ""
