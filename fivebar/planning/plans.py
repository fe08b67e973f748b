"""Plans: optimal motions with their residuals."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import simpson

from ..base.presentation import Animated
from ..base.representation import one_line
from ..base.tables import Table, TextFile, must_increase, write
from ..constraints.constraints import Constraints
from ..constraints.link_collisions import LinkCollisions
from ..models.four_joints import loop_gap
from ..models.kinematics import Accelerations
from ..models.loads import forces_and_torques, friction_torques
from ..models.parameters import robot_of
from .collocation import METHOD, Pieces, Scheme
from .functions import MotionPoint
from .problem import PlanError, Problem
from .trajectory import refuse_nan

if TYPE_CHECKING:
    from ..models.robots import Robot

AGAIN = 1e-6  # of an objective: motions that differ by less are one
FINE = np.linspace(0.0, 1.0, 13)  # places in each interval where a plan is checked
# Weight of the error of a cost of one's own: of its integral ten times as much is allowed.
OWN = 0.1
COLUMNS = (
    "t",
    "x",
    "y",
    "x_dot",
    "y_dot",
    "x_ddot",
    "y_ddot",
    "tau1",
    "tau2",
    "lambda1",
    "lambda2",
)
BARS = ("q1_ddot", "phi1_ddot", "q2_ddot", "phi2_ddot")  # of a plan in the four bars


class PlanMesh(NamedTuple):
    """One solution: intervals, IPOPT's iterations, objective, `Plan.error`, s since the call."""

    intervals: int
    iterations: int
    objective: float
    error: float
    seconds: float


class Tried(NamedTuple):
    """What was tried for a plan, on a coarse mesh.

    Attributes
    ----------
    ways : int
        Paths of the bars, that differ in the singularities they cross or in their turns; between
        points the straight one and, of a robot with weight, those that bend to a side.
    swings : int
        Motions from both ends under little torque.
    next_best : float or None
        Objective of the next best motion that was found, SI.
    cut : bool
        Whether `Collocation.max_time` ended the search.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.plan(fb.FiveBar(), (0.09, 0.068), (0.08, 0.075), 0.5).tried
    Tried(ways=1, swings=0, next_best=None, cut=False)
    """

    ways: int = 1
    swings: int = 0
    next_best: float | None = None
    cut: bool = False


@dataclass(frozen=True, eq=False)
class Plan(Animated):
    """A planned motion, from `plan`.

    Call it with t (n,) s, as any reference, for (xi, xi_dot, xi_ddot), each (n, 2). It holds its
    first and last point.

    Attributes
    ----------
    problem : Problem
        Stops, weights, constraints and scheme.
    pieces : Pieces
        The polynomials.
    objective : float
        Its value, SI.
    status : str
        IPOPT's return status.
    meshes : tuple of PlanMesh
        The solutions on the way, mesh by mesh.
    solve_time : float
        Time, s, of the whole call.
    tried : Tried
        How many ways and swings were compared, the next best objective, and whether the search was
        cut.
    others : tuple
        Other motions between the poses, as `alternatives` refines them. Files do not hold them.

    Examples
    --------
    >>> import fivebar as fb
    >>> plan = fb.plan(fb.FiveBar(), (0.09, 0.068), (0.08, 0.075), 0.5)
    >>> plan.duration, plan.status
    (0.5, 'Solve_Succeeded')
    """

    problem: Problem
    pieces: Pieces
    objective: float
    status: str
    meshes: tuple[PlanMesh, ...] = ()
    solve_time: float = math.nan
    tried: Tried = Tried()
    others: tuple = ()
    start = 0.0

    def __repr__(self) -> str:
        aims = " + ".join(self.aims)
        modes = "free of modes" if self.working is None else f"working {self.working}"
        solved = (f"{aims} {self.objective:.4g}", f"{len(self.pieces.xi)} intervals", self.status)
        return one_line("Plan", self.robot.words.title, f"{self.duration:g} s", modes, *solved)

    @property
    def aims(self) -> tuple[str, ...]:
        """Names of what the objective adds up."""
        own = self.problem.own
        known = (name for name, weight in self.problem.weights.items() if weight)
        return *known, *(own.costs if own else ())

    @property
    def notes(self) -> tuple[str, ...]:
        """What was tried, and how much the next best motion costs, in sentences."""
        ways, swings, next_best, cut = self.tried
        notes = []
        if swings or ways > 1:
            counts = [
                f"{n} {word}{'s' * (n > 1)}" for n, word in ((ways, "way"), (swings, "swing")) if n
            ]
            notes.append(f"{' and '.join(counts)} were tried on a coarse mesh")
        if next_best is not None:
            more = f"{next_best / self.objective:.3g} times this one" if self.objective else "more"
            notes.append(f"the next best motion costs {next_best:.4g}, {more}: see alternatives")
        slow = 0.0 if self.problem.constraints.torque is None else self.friction_error
        if slow:
            unit = self.robot.words.effort_unit
            notes.append(
                "near standstill dry friction was smoothed: there the limited"
                f" {self.robot.words.effort} is up to {slow:.3g} {unit} off"
            )
        if cut:
            notes.append("the search was cut by max_time: a larger one may find a better motion")
        return tuple(notes)

    @cached_property
    def alternatives(self) -> tuple[Plan, ...]:
        """Other motions between the same ends, the cheapest first, refined when first asked for.

        They take some seconds. One that cannot be made accurate, or is one of the others or this
        plan again, is left out.
        """
        found = [self]
        for other in self.others:
            try:
                plan = other if isinstance(other, Plan) else other()
            except PlanError:
                continue
            if all(abs(plan.objective - each.objective) > AGAIN * each.objective for each in found):
                found.append(plan)
        return tuple(sorted(found[1:], key=lambda plan: plan.objective))

    @property
    def robot(self) -> Robot:
        return self.problem.robot

    @property
    def working(self) -> tuple[int, int] | None:
        return self.problem.working

    @property
    def duration(self) -> float:
        return float(self.pieces.knots[-1])

    @property
    def iterations(self) -> int:
        return sum(mesh.iterations for mesh in self.meshes)

    def __call__(self, t: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        motion = self.motion(t)
        if not self.problem.in_bars:
            xi, xi_dot, xi_ddot, _ = np.split(motion, (2, 4, 6), axis=-1)
            return xi, xi_dot, xi_ddot
        acc = self.problem.accelerations(motion)
        return acc.rates.pose.xi, acc.rates.xi_dot, acc.xi_ddot

    def torques(self, t: ArrayLike) -> np.ndarray:
        """Return planned torques (*t.shape, 2), N m; 0 before and after."""
        return self.motion(t)[..., -2:]

    def joints(self, t: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return the active joints' coordinates and rates (*t.shape, 2): rad, rad/s."""
        rates = self.accelerations(t).rates
        return rates.pose.q, rates.q_dot

    def motion(self, t: ArrayLike) -> np.ndarray:
        """Return planned coordinates, rates, accelerations and torques, (*t.shape, 8 or 14)."""
        times = np.asarray(t, dtype=float)
        motion = self.pieces.motion(*self.pieces.locate(times))
        outside = ~((times >= 0) & (times <= self.duration))
        if outside.any():
            refuse_nan(times)
            rest = self.problem.coordinates.size
            motion[..., rest:] = np.where(outside[..., None], 0.0, motion[..., rest:])
        return motion

    def accelerations(self, t: ArrayLike) -> Accelerations:
        """Return the planned motion as `Accelerations`, with its pose and rates."""
        return self.problem.accelerations(self.motion(t))

    def bar_forces(self, t: ArrayLike) -> np.ndarray:
        """Return the forces in the distal bars (*t.shape, 2), N, finite at every singularity.

        Of a plan in x and y they are B^-1 (tau - Z q''), of one in the four bars those of
        `dynamics.bar_forces`.
        """
        motion = self.motion(t)
        acc = self.problem.accelerations(motion, self.problem.model)
        return self.problem.bar_forces(acc, motion[..., -2:])

    @property
    def nodes(self) -> np.ndarray:
        """Return the times (n,) s of the collocation points."""
        return self.pieces.scheme.nodes(self.pieces.knots)

    @cached_property
    def _fine(self):
        return self._within(FINE)

    def _within(self, places):
        """Return the motion (n, m, columns) at places (m,) of every interval, and it as
        Accelerations.
        """
        k, sigma = np.meshgrid(np.arange(len(self.pieces.xi)), places, indexing="ij")
        motion = self.pieces.motion(k, sigma)
        return motion, self.problem.accelerations(motion, self.problem.model)

    @cached_property
    def defects(self) -> np.ndarray:
        """Return the largest defect of the force in each interval (n,), N."""
        return self.problem.coordinates.defect(*self._fine).max(axis=1)

    @property
    def error(self) -> float:
        """Return the largest defect over the largest force |m xi''|, both between nodes too.

        Of a cost of one's own, it is also a tenth of what its integral over an interval is off,
        over the mean of all.
        """
        return float(self._relative_defects.max())

    @property
    def friction_error(self) -> float:
        """Return the largest difference, N m, of the robot's friction and its smoothed model."""
        motion, smooth = self._fine
        exact = self.problem.accelerations(motion, self.robot)
        return float(np.abs(friction_torques(exact.rates) - friction_torques(smooth.rates)).max())

    @cached_property
    def _relative_defects(self):
        acc = self._fine[1]
        force = np.hypot(*forces_and_torques(acc)[0]).max()
        relative = self.defects / (force or 1.0)
        if not self.problem.has_own_cost:
            return relative
        scheme = self.pieces.scheme
        at_nodes, _ = self._own(scheme.c, *self._within(scheme.c))
        fine, _ = self._own(FINE, *self._fine)
        costs = self.pieces.widths * simpson(fine, FINE)
        off = np.abs(self.pieces.widths * (at_nodes @ scheme.powers(1.0)[1]) - costs)
        return np.fmax(relative, OWN * off / (np.abs(costs).mean() or 1.0))

    @cached_property
    def _exceeded(self):
        motion, acc = self._fine
        pose = acc.rates.pose
        sines = self.problem.signed_sines(pose)
        excess = self.problem.violations(acc.rates.q_dot, acc.xi_ddot, motion[..., -2:], sines)
        if self.problem.in_bars:
            reach = np.hypot(*loop_gap(pose))
        else:
            reach = -pose.reach_margin
        if self.problem.own is not None:
            excess |= {name: -value for name, value in self._own(FINE, motion, acc)[1].items()}
        return excess | {"reach": reach}

    def _own(self, sigma, motion, acc):
        """Return cost (n, m), {name: constraint (n, m)} of the user's own, at places sigma."""
        t = self.pieces.knots[:-1, None] + self.pieces.widths[:, None] * sigma
        tau = motion[..., -2:]
        point = MotionPoint.of(t, acc, tau, self.problem.bar_forces(acc, tau))
        vectors = (each.reshape(-1, 2) for each in point[1:])
        cost, kept = self.problem.own.values(MotionPoint(t.ravel(), *vectors))
        return cost.reshape(t.shape), {name: each.reshape(t.shape) for name, each in kept.items()}

    @cached_property
    def violations(self) -> dict[str, float]:
        """Return {limit: by how much it is exceeded anywhere, 0.0 if not}, SI."""
        return {
            name: max(0.0, float(np.fmax.reduce(value, axis=None)))
            for name, value in self._exceeded.items()
        }

    @property
    def saturated(self) -> float:
        """Return the part of the time in which at least one torque is within 0.1 % of its limit."""
        t = np.linspace(0, self.duration, 2001)
        share = self.problem.constraints.torque_share(self.torques(t), self.joints(t)[1])
        return float(np.mean(share >= 0.999))

    def to_csv(self, path: TextFile) -> None:
        """Write the plan at its nodes and both ends, SI.

        The problem, the knots and the solution's data are in a comment line. Of functions of your
        own it has the names: a plan that is read back has the motion, but not them.
        """
        pieces = self.pieces
        rule = pieces.scheme
        problem = self.problem
        about = {
            "robot": self.robot.parameters,
            "stops": [[list(c.items()), t] for c, t in problem.stops],
            "working": problem.working,
            "weights": problem.weights,
            "constraints": asdict(problem.constraints),
            "functions": [*problem.own.costs, *problem.own.constraints] if problem.own else [],
            "method": METHOD,
            "degree": len(rule.c),
            "knots": pieces.knots,
            "objective": self.objective,
            "status": self.status,
            "meshes": self.meshes,
            "solve_time": self.solve_time,
            "tried": self.tried,
            "begins": np.hstack([pieces.xi, pieces.xi_dot]),
        }
        n = problem.coordinates.size
        t = np.concatenate([[0.0], self.nodes, [self.duration]])
        motion = self.motion(t)
        # The values themselves, to the last bit.
        inner = motion[1:-1]
        inner[:, 2 * n : -2] = pieces.xi_ddot.reshape(-1, n)
        inner[:, -2:] = pieces.tau.reshape(-1, 2)
        in_bars = problem.in_bars
        if in_bars:
            xi, xi_dot, xi_ddot = self(t)
        else:
            xi, xi_dot, xi_ddot = np.split(motion[:, :6], 3, axis=1)
        table = [t, xi, xi_dot, xi_ddot, motion[:, -2:], self.bar_forces(t)]
        if in_bars:
            table.append(motion[:, 8:12])
        write(path, "plan", about, COLUMNS + BARS * in_bars, np.column_stack(table).tolist())

    @classmethod
    def from_csv(cls, path: TextFile) -> Plan:
        """Read what `to_csv` wrote; ValueError with file and line for what is not such a file."""
        table = Table(path)
        problem, knots, begins, known = table.about("plan", "a file written by Plan.to_csv", _known)
        in_bars = problem.in_bars
        values = table.numbers(COLUMNS[:-2] + BARS * in_bars)
        nodes = problem.scheme.nodes(knots)
        if len(values) != len(nodes) + 2:
            rows = len(nodes) + 2
            raise ValueError(f"{table.name}: {len(values)} rows, its first line needs {rows}")
        values = values[1:-1]
        error = np.abs(values[:, 0] - nodes).max()
        if error > 1e-9 * knots[-1]:
            raise ValueError(f"{table.name}: the times are not those that its first line speaks of")
        accelerations = values[:, 9:] if in_bars else values[:, 5:7]
        tau = values[:, 7:9]
        start, start_rate = np.hsplit(begins, 2)
        by_interval = len(start), len(problem.scheme.c)
        pieces = Pieces(
            problem.scheme,
            knots,
            start,
            start_rate,
            accelerations.reshape(*by_interval, accelerations.shape[1]),
            tau.reshape(*by_interval, 2),
        )
        return cls(problem, pieces, *known)


def _known(about):
    """Return problem, knots, state (n, 4 or 8) at each interval's begin, and the rest of a file."""
    constraints = dict(about["constraints"])
    if constraints["collisions"] is not None:
        constraints["collisions"] = LinkCollisions(**constraints["collisions"])
    if about["method"] != METHOD or about["degree"] not in range(2, 8):
        raise ValueError(f"no method {about['method']} of degree {about['degree']}")
    stops = []
    for conditions, t in about["stops"]:
        stops.append(({order: tuple(value) for order, value in conditions}, t))
    problem = Problem(
        robot_of(about["robot"]),
        tuple(stops),
        about["working"] and tuple(about["working"]),
        about["weights"],
        Constraints(**constraints),
        Scheme(about["degree"]),
    )
    knots = np.array(about["knots"], dtype=float)
    meshes = tuple(PlanMesh(*mesh) for mesh in about["meshes"])
    must_increase(knots, "knots")
    size = 2 * problem.coordinates.size
    begins = np.array(about["begins"], dtype=float).reshape(len(knots) - 1, size)
    if not np.isfinite(begins).all():
        raise ValueError("begins must be finite")
    known = (
        about["objective"],
        about["status"],
        meshes,
        about["solve_time"],
        Tried(*about["tried"]),
    )
    return problem, knots, begins, known
