"""`design`: the best robot for one goal, or the Pareto front of several."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from functools import partial
from typing import Any

import numpy as np

from ..base.checks import number, optional, positive, takes, whole
from ..base.progress import progress
from ..base.robot_uses import robot_for
from ..base.workers import WorkersDied, check_executor, compute_chunks
from ..models.robots import Biglide, FiveBar
from .batch import check_variables, robot_of_design, robots_of_designs
from .designs import limits_of
from .evolution import dominates, evolve, refine, thinned
from .figures import figures_of, warn_of_inertias
from .goals import SENSE, goals_of, limits_by_figure
from .results import AT_LIMIT, Design, Front
from .sweeping import compute_chunk
from .task import Task, task_of

PENALTY = 1e30  # above all goals: the value of what violates the limits
PIECE = 5  # designs that an executor computes at a time


def _effort(value, name):
    return number(value, name, 0.01, 100.0)


@takes(
    robot=optional(robot_for("fb.design")),
    step=optional(positive),
    points=whole(2, 200),
    seed=whole(0, 2**63),
    effort=_effort,
)
def design(
    goals: Any,
    bounds: Mapping[str, Any],
    *,
    limits: Mapping[Any, Any] | None = None,
    robot: FiveBar | Biglide | None = None,
    step: float | None = None,
    points: int = 20,
    seed: int = 0,
    effort: float = 1.0,
    executor: Executor | None = None,
    **choices: Any,
) -> Design | Front:
    """Return the best robot within bounds: a Design for one goal, a Front of two or three.

    One goal is searched by SciPy's differential evolution; several by differential evolution of
    all goals at once (GDE3), then each point of the front by itself. A search proves nothing: each
    result names its active bounds and limits, and how far it is from what no robot within the
    bounds passes, where that is known.

    Parameters
    ----------
    goals : str, callable, list or mapping
        A figure of merit by name or as a function of a robot, a list of up to three, {name:
        function} or {figure: "min", "max" or None}. A name knows its own sense; a function is to be
        large.
    bounds : mapping
        {parameter: (low, high)}, a number where it is fixed. Parameters as in `sweep`: l1 and l2
        make the robot symmetric, task_y moves its table.
    limits : mapping
        {figure: (low, high)}, None for no limit; a number is a limit on the worse side. A table
        must be reached without a singularity, whether it is named or not.
    robot : FiveBar or Biglide
        What the bounds do not name; None: FiveBar().
    step : float
        Lengths are whole multiples of it, m, as 0.001.
    points : int
        On the front.
    seed : int
        Of the search.
    effort : float
        Of the search; 2: twice as many generations.
    executor : concurrent.futures.Executor
        Computes figures that are not in closed form, as in `sweep`; None: this process.
    **choices
        What the figures are about, as in `sweep`: table=(0.2, 0.15), motor="xh430-w350", ...

    Returns
    -------
    Design or Front

    Raises
    ------
    ValueError
        No robot within the bounds was found that keeps the limits; or an argument is wrong.
    RuntimeError
        The executor died.

    References
    ----------
    Storn and Price, Journal of Global Optimization 11, 1997. Kukkonen and Lampinen, GDE3, IEEE CEC
    2005.

    Examples
    --------
    >>> import fivebar as fb
    >>> best = fb.design("workspace_area", {"l1": (0.1, 0.2), "d": 0.1}, effort=0.05)
    >>> round(best.parameters["l1"], 3)
    0.2
    """
    robot = FiveBar() if robot is None else robot
    check_executor(executor)
    limits = {} if limits is None else limits
    problem = DesignProblem(goals, bounds, limits, robot, step, task_of(choices), executor)
    rng = np.random.default_rng(seed)
    is_one = len(problem.goals) == 1
    generations = int(np.ceil((300 if is_one else 100) * effort))
    with progress(total=(1 if is_one else 2) * generations, unit=" generations") as bar:
        if is_one:
            return problem.design_of(_search_one(problem, rng, generations, bar))
        rows = _search_front(problem, rng, points, generations, bar)
    designs = [problem.design_of(row) for row in rows]
    return Front(tuple(sorted(designs, key=lambda one: one.values[problem.goals[0].name])))


class DesignProblem:
    """The search as numbers: parameters in; goals to be small and the violation of limits out."""

    def __init__(self, goals, bounds, limits, robot, step, task: Task, executor: Executor | None):
        self.robot = robot
        self.step = step
        self.task = task
        self.executor = executor
        intervals = limits_of(bounds)
        self.names = tuple(intervals)
        self.low, self.high = np.array(list(intervals.values())).T.copy()
        check_variables(self.names, robot, "bounds", self.low, self.high)
        self.goals, self.senses = goals_of(goals, task, robot)
        self.signs = np.array([1.0 if sense == "min" else -1.0 for sense in self.senses])
        self.limits = limits_by_figure(limits, task, robot)
        self.on_table = bool(task.table or task.disc) and isinstance(robot, FiveBar)
        figures = [*self.goals, *(limit.figure for limit in self.limits)]
        if self.on_table:
            figures += figures_of(["reach", "det_A"], task, robot)
            self.task_size = float(np.ptp(task.nodes[0], axis=0).max())
        self.figures = tuple({figure.name: figure for figure in figures}.values())
        warn_of_inertias(self.figures, self.names, robot)
        self.free = self.high > self.low
        self.stepped = np.array([step is not None and name[0] in "lrd" for name in self.names])
        for k in np.flatnonzero(self.stepped):
            self._round_bounds(k)

    def _round_bounds(self, k):
        low = np.ceil(self.low[k] / self.step - 1e-9)
        high = np.floor(self.high[k] / self.step + 1e-9)
        if low > high:
            raise ValueError(
                f"bounds: no multiple of step = {self.step:g} lies in {self.names[k]} ="
                f" ({self.low[k]:g}, {self.high[k]:g})"
            )
        # No -0, which messages would show.
        self.low[k], self.high[k] = low * self.step + 0.0, high * self.step + 0.0

    def rows(self, x: np.ndarray) -> np.ndarray:
        """Return designs (n, k), rounded to steps; what is next to a bound is put on it."""
        near = 1e-9 * (self.high - self.low)
        x = np.where(x >= self.high - near, self.high, x)
        x = np.where(x <= self.low + near, self.low, x)
        if self.step is None:
            return x
        rounded = np.round(np.rint(x / self.step) * self.step, 12)
        return np.where(self.stepped, rounded, x) + 0.0  # no -0

    def values(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        """Return {figure: (n,)} of designs."""
        compute = partial(compute_chunk, self.figures, self.names, self.robot, self.task)
        pieces = [rows]
        executor = None
        if any(figure.kind in ("single", "own") for figure in self.figures):
            executor = self.executor
        if executor is not None:
            pieces = np.array_split(rows, max(1, len(rows) // PIECE))
        try:
            done = dict(compute_chunks(compute, enumerate(pieces), executor, 1))
        except WorkersDied as error:
            raise RuntimeError(f"{error}; a search keeps nothing: begin it anew") from None
        values = np.concatenate([done[k].values for k in range(len(done))])
        return {figure.name: column for figure, column in zip(self.figures, values.T)}

    def __call__(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return (goals to be small (n, goals), violation of the limits (n,)) of designs."""
        values = self.values(self.rows(x))
        goals = np.stack([values[goal.name] for goal in self.goals], axis=1) * self.signs
        violation = np.zeros(len(x))
        for figure, low, high in self.limits:
            value = values[figure.name]
            size = max(abs(end) for end in (low, high) if np.isfinite(end)) or 1.0
            violation += np.fmax(np.maximum(low - value, value - high), 0) / size
        if self.on_table:  # The distance out of reach leads the search to the table.
            violation += np.fmax(-values["reach"], 0) / self.task_size
        lost = (~np.isfinite(list(values.values()))).sum(axis=0)  # figures
        return np.where(np.isfinite(goals), goals, 0.0), violation + 10.0 * lost

    def design_of(self, x: np.ndarray) -> Design:
        """Return the Design of one row."""
        row = self.rows(x[None])[0]
        values = {name: float(column[0]) for name, column in self.values(row[None]).items()}
        return Design(
            parameters=dict(zip(self.names, row.tolist())),
            robot=robot_of_design(self.names, row, self.robot),
            values=values,
            goals={goal.name: sense for goal, sense in zip(self.goals, self.senses)},
            units={figure.name: figure.unit for figure in self.figures},
            binding=(*self._active_bounds(row), *self._active_limits(row, values)),
            unreached_bounds=self._unreached_bounds(),
            task=self.task,
        )

    def _active_bounds(self, row):
        """Yield sentences on the bounds at which, or a step from which, a design is."""
        for k in np.flatnonzero(self.free):
            step = 1.001 * self.step if self.stepped[k] else 0.0
            near = max(AT_LIMIT * (self.high[k] - self.low[k]), step)
            for side, bound in (("lower", self.low[k]), ("upper", self.high[k])):
                distance = abs(row[k] - bound)
                if distance <= near:
                    place = "a step from" if distance > step / 2 > 0 else "at"
                    yield f"{self.names[k]} = {row[k]:.6g} is {place} its {side} bound {bound:.6g}"

    def _active_limits(self, row, values):
        """Yield sentences on the limits at which a design is, or which its neighbours violate."""
        steps = np.diag(np.where(self.stepped, 1.001 * (self.step or 0.0), 0.0))[self.stepped]
        around = self.values(np.concatenate([row[None], row + steps, row - steps]))
        inside = np.ones(1 + 2 * len(steps), dtype=bool)
        if self.on_table:
            inside = around["det_A"] > 0
            reached = around["reach"] >= 0
            if values["reach"] <= AT_LIMIT * self.task_size or not reached.all():
                yield f"reach = {values['reach']:.6g} is near its limit, at least 0"
        for figure, low, high in self.limits:
            name = figure.name
            column = around[name][inside]
            for side, end, violated in (
                ("at least", low, column < low),
                ("at most", high, column > high),
            ):
                near = abs(values[name] - end) <= AT_LIMIT * max(abs(end), 1e-12) < np.inf
                if near or violated.any():
                    place = "at" if near else "less than a step from"
                    yield f"{name} = {values[name]:.6g} is {place} its limit, {side} {end:.6g}"

    def _unreached_bounds(self):
        """Return {goal: what no robot within the bounds passes}, where it is known.

        A figure's bound is that of the longest bars where large values are better, else of the
        shortest.
        """
        bounds = {}
        for figure, sense in zip(self.goals, self.senses):
            if figure.bound is not None and sense == SENSE[figure.better]:
                corner = self.high if sense == "max" else self.low
                robots = robots_of_designs(self.names, corner[None], self.robot)
                bounds[figure.name] = float(figure.bound(robots, self.task)[0])
        return bounds


def _search_one(problem, rng, generations, bar):
    """Return the best row by SciPy's differential evolution of what varies."""
    from scipy.optimize import differential_evolution

    free = problem.free
    row = problem.low.copy()
    if free.any():

        def goal(x):
            rows = np.tile(problem.low, (x.shape[1], 1))
            rows[:, free] = x.T
            goals, violation = problem(rows)
            return np.where(violation > 0, PENALTY * (1 + violation), goals[:, 0])

        row[free] = differential_evolution(
            goal,
            list(zip(problem.low[free], problem.high[free])),
            vectorized=True,
            polish=False,
            updating="deferred",
            maxiter=generations,
            popsize=20,
            tol=1e-10,
            rng=rng,
            init="halton",
            callback=lambda *_, **__: bar.update() and None,
        ).x
    _check_limits(problem, row)
    return row


def _search_front(problem, rng, points, generations, bar):
    """Return rows of which none is better than another in all goals."""
    size = max(60, 20 * int(problem.free.sum()), points)
    bounds = (problem.low, problem.high)
    x, f, violation = evolve(problem, *bounds, size, generations, rng, bar.update)
    feasible = violation == 0
    if not feasible.any():
        _check_limits(problem, x[np.argmin(violation)])
    x = x[feasible]
    f = f[feasible]
    chosen = thinned(f, np.arange(len(f)), points)
    x, f, violation = refine(problem, *bounds, x, f, chosen, 20, generations, rng, bar.update)
    rows = problem.rows(x[violation == 0])
    f, _ = problem(rows)
    zero = np.zeros(1)
    best = ~dominates(f[:, None], zero, f, zero).any(axis=0)
    first = np.unique(f[best].round(15), axis=0, return_index=True)[1]
    return rows[best][first]


def _check_limits(problem, x):
    """Raise ValueError where the best row violates the limits, and name them."""
    row = problem.rows(x[None])
    if problem(row)[1][0] == 0:
        return
    values = {name: column[0] for name, column in problem.values(row).items()}
    violated = []
    for figure, low, high in problem.limits:
        value = values[figure.name]
        if value < low or value > high:
            violated.append(f"{figure.name} = {value:.6g}, not from {low:g} to {high:g}")
    if problem.on_table and values["reach"] < 0:
        violated.append(f"the table is out of reach by {-values['reach']:.6g} m")
    elif problem.on_table and not values["det_A"] > 0:
        violated.append("a Type-2 singularity crosses the table")
    at = ", ".join(f"{name} = {value:.6g}" for name, value in zip(problem.names, row[0]))
    reasons = "; ".join(violated) or "no robot closes, or a goal is not finite"
    raise ValueError(
        f"nothing within the bounds was found that keeps the limits; the nearest, {at}: {reasons}"
    )
